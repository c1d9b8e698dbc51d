"""Contact with the stators of magnetic bearings, the last support of a rotor whose magnets have lost their power.

If a rotor crosses the air gap of an energised magnet, the magnet pulls it into the stator, and the actuator reports a
fault. If the magnet has no power, the rotor touches the bore, steel on steel, just beyond the air gap, which is the
smaller one if those of the bearing's two axes differ:

    |r| <= 1.001 min(l_x, l_y)

The additional 0.1 % ensures that an energised axis ends the run, at |x| >= l_x, before the iron stops the rotor.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING

from amb_cosim.cosim.system.assembly import Assembly
from amb_cosim.cosim.system.assignments import Assignments
from amb_cosim.cosim.system.system import System
from amb_cosim.cosim.system.values import Raw, is_zero
from amb_cosim.model_constants.stator_names import stator_site
from amb_cosim.results.component_names import ACTUATOR, PLANT
from amb_cosim.scenario.scenario import Scenario
from amb_cosim.scenario.scenario_tables import Event
from amb_files.wildcards import matching_names

if TYPE_CHECKING:
    from amb_cosim.cosim.run.checkpoint import Checkpoint

SWITCHES = ("amplifier_off_x", "amplifier_off_y")  # inputs of the actuator for each bearing
BEYOND_GAP = 1.001  # clearance of a stator, relative to the air gap
DRY_STEEL = {"mu": 0.3, "restitution": 0.3}  # friction and restitution of steel on steel, assumed


def reasons_for_stators(scenario: Scenario, settings: Mapping[str, Raw]) -> tuple[str, ...]:
    """Return the names and patterns, `component.variable`, that require stators and that a scenario or `settings` set.

    These variables switch amplifiers off at any time, or are parameters of the stators themselves.
    """
    tables = [scenario.parameters, scenario.inputs, *(event.set for event in scenario.event)]
    stated = [(f"{name}.{v}", raw) for table in tables for name, values in table.items() for v, raw in values.items()]
    values = [*stated, *settings.items()]
    return tuple(sorted({name for name, raw in values if _is_of_stator(name) or _switches_off(name, raw)}))


def _is_of_stator(name: str) -> bool:
    return name.startswith(f"{PLANT}.{stator_site('')}")


def _switches_off(name: str, raw: Raw) -> bool:
    variable = name.rpartition(".")[2]
    return name.startswith(f"{ACTUATOR}.") and not is_zero(raw) and bool(matching_names(SWITCHES, variable))


def switches_amplifiers_off(event: Event) -> bool:
    """Return whether an event takes the power of a magnet."""
    changes = [(f"{component}.{v}", raw) for component, values in event.set.items() for v, raw in values.items()]
    return any(_switches_off(name, raw) for name, raw in changes)


def touchable_stators(scenario: Scenario, system: System, settings: Mapping[str, Raw]) -> tuple[str, ...]:
    """Return the magnetic bearings whose stators the rotor can touch, according to `reasons_for_stators`.

    If another FMU replaces the plant or the actuator, no bearings are returned, because it is unknown how that FMU
    treats a rotor at the stator.
    """
    reasons = reasons_for_stators(scenario, settings)
    if not reasons or not _is_modelled(system):
        return ()
    patterns = [name.rpartition(".")[0] + ".*" if _is_of_stator(name) else name for name in reasons]

    def names(bearing: str) -> list[str]:
        return [f"{PLANT}.{stator_site(bearing)}.*", *(f"{ACTUATOR}.{bearing}.{switch}" for switch in SWITCHES)]

    return tuple(b for b in _bearings(scenario) if any(matching_names(names(b), pattern) for pattern in patterns))


def stators_of_run(
    scenario: Scenario, system: System, settings: Mapping[str, Raw], start: Checkpoint | None = None
) -> tuple[str, ...]:
    """Return the bearings whose stators are part of a run: those of its past, if any, or `touchable_stators`."""
    if start is None:
        return touchable_stators(scenario, system, settings)
    parameters = start.past.get("parameters", {}).get(PLANT, {})
    if not _is_modelled(system) or not any(name.startswith(stator_site("")) for name in parameters):
        return ()
    return tuple(name for name in _bearings(scenario) if f"{stator_site(name)}.clearance" in parameters)


def lacking_stators(
    scenario: Scenario, assembly: Assembly, settings: Mapping[str, Raw], start: Checkpoint
) -> list[str]:
    """Return a warning if a run switches off amplifiers of bearings that had no stators in the run's past."""
    modelled = assembly.options["stators"]
    missing = [name for name in touchable_stators(scenario, assembly.system, settings) if name not in modelled]
    if not missing:
        return []
    return [
        f"the checkpoint at t = {start.time:.9g} s has no stators at {', '.join(missing)}, where this run switches off "
        "amplifiers; the run ends if the rotor crosses the air gap there"
    ]


def _is_modelled(system: System) -> bool:
    """Return whether the plant and the actuator are the models with these names."""
    models = {component.name: component.fmu for component in system.components}
    return models.get(PLANT) == PLANT and models.get(ACTUATOR) == ACTUATOR


def _bearings(scenario: Scenario) -> list[str]:
    from rotor_analysis.rotor_file import load_rotor  # not needed by a run whose magnets keep their power

    return [bearing.name for bearing in load_rotor(scenario.rotor).bearings]


def set_stators(values: Assignments, bearings: Sequence[str], assigned: Iterable[str]) -> None:
    """Set the contact sites in stator bores: the air gap is their clearance, and the contact is dry steel on steel.

    Parameters
    ----------
    values
        The values of all parameters.
    bearings
        The bearings with such a site. If the rotor itself declares a site there, the values of that site are not
        changed.
    assigned
        Names and patterns, `component.variable`, of all parameters that a user has set. A pattern that also matches
        other sites is taken to mean only the other sites.
    """
    names = [port.name for port in values.interfaces[PLANT].of("parameter")]
    sites = {stator_site(bearing): bearing for bearing in bearings}
    prefixes = tuple(f"{site}." for site in sites)
    matched = (matching_names(names, name.removeprefix(f"{PLANT}.")) for name in assigned)
    settings = {name for matches in matched if all(match.startswith(prefixes) for match in matches) for name in matches}
    for name in names:
        site, _, variable = name.partition(".")
        if site not in sites or name in settings:
            continue
        values.parameters[PLANT].pop(name, None)
        if variable == "clearance":
            gaps = (values.parameter(f"{ACTUATOR}.{sites[site]}.gap_{axis}") for axis in "xy")
            values.set(f"{PLANT}.{name}", BEYOND_GAP * min(gaps))
        elif variable in DRY_STEEL:
            values.set(f"{PLANT}.{name}", DRY_STEEL[variable])
