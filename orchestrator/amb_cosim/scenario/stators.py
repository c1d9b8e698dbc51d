"""Contact with the stators of magnetic bearings: the last resort of a rotor whose magnets have lost their power.

A magnet with power pulls a rotor that crosses the air gap into the stator, which the actuator reports as a fault.
Without power the rotor touches the bore, steel on steel, just beyond the smaller air gap of the bearing's two axes:

    |r| <= 1.001 min(l_x, l_y)

The thousandth lets an axis with power end the run, |x| >= l_x, before the iron stops the rotor.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from amb_cosim.cosim.system.assignments import Assignments
from amb_cosim.cosim.system.system import System
from amb_cosim.cosim.system.values import Raw, is_zero
from amb_cosim.results.component_names import ACTUATOR, PLANT
from amb_cosim.scenario.scenario import Scenario
from amb_files.wildcards import matching_names

SWITCHES = ("amplifier_off_x", "amplifier_off_y")  # inputs of the actuator for each bearing
BEYOND_GAP = 1.001  # clearance of a stator, relative to the air gap
DRY_STEEL = {"mu": 0.3, "restitution": 0.3}  # friction and restitution of steel on steel, assumed


def bearings_without_power(scenario: Scenario, system: System, settings: Mapping[str, Raw]) -> tuple[str, ...]:
    """Return the magnetic bearings whose amplifiers a scenario or its `settings` switch off at any time.

    None where another FMU replaces plant or actuator: nothing says how it treats a rotor that reaches the stator.
    """
    models = {component.name: component.fmu for component in system.components}
    if models.get(PLANT) != PLANT or models.get(ACTUATOR) != ACTUATOR:
        return ()
    changes = [scenario.inputs.get(ACTUATOR, {}), *(event.set.get(ACTUATOR, {}) for event in scenario.event)]
    changes.append({name.removeprefix(f"{ACTUATOR}."): raw for name, raw in settings.items()})
    patterns = [pattern for values in changes for pattern, raw in values.items() if not is_zero(raw)]
    if not any(matching_names(SWITCHES, pattern.rpartition(".")[2]) for pattern in patterns):
        return ()
    from rotor_analysis.rotor_file import load_rotor  # not needed by a run whose magnets keep their power

    bearings = [bearing.name for bearing in load_rotor(scenario.rotor).bearings]
    switches = {name: [f"{name}.{switch}" for switch in SWITCHES] for name in bearings}
    return tuple(name for name in bearings if any(matching_names(switches[name], pattern) for pattern in patterns))


def set_stators(values: Assignments, bearings: Sequence[str], assigned: Iterable[str]) -> None:
    """Set the contact sites in the stator bores of bearings: their air gap as clearance, and dry steel on steel.

    Parameters
    ----------
    values
        The values of all parameters.
    bearings
        Those with such a site. The values of a site that the rotor declares itself stay as they are.
    assigned
        Names and patterns, `component.variable`, of all parameters that a user has set. Patterns that other sites
        match, too, are meant for these alone.
    """
    from rotor_contact.planes import stator_site  # not needed by a run whose magnets keep their power

    names = [port.name for port in values.interfaces[PLANT].of("parameter")]
    sites = {stator_site(bearing): bearing for bearing in bearings}
    begins = tuple(f"{site}." for site in sites)
    found = (matching_names(names, name.removeprefix(f"{PLANT}.")) for name in assigned)
    meant = {name for matches in found if all(match.startswith(begins) for match in matches) for name in matches}
    for name in names:
        site, _, variable = name.partition(".")
        if site not in sites or name in meant:
            continue
        values.parameters[PLANT].pop(name, None)
        if variable == "clearance":
            gaps = (values.parameter(f"{ACTUATOR}.{sites[site]}.gap_{axis}") for axis in "xy")
            values.set(f"{PLANT}.{name}", BEYOND_GAP * min(gaps))
        elif variable in DRY_STEEL:
            values.set(f"{PLANT}.{name}", DRY_STEEL[variable])
