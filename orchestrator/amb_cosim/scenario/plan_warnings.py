"""Notes on a plan: idle switches, effects that make turns differ, implausible sizes or unbalances, viscous losses."""

from __future__ import annotations

from collections.abc import Collection

from amb_cosim.cosim.system.assembly import Assembly
from amb_cosim.cosim.system.assignments import Assignments
from amb_cosim.cosim.system.experiment import Plan
from amb_cosim.presentation.units import speed_unit
from amb_cosim.results.component_names import CONTROLLER
from amb_cosim.scenario.scenario import SPEED, UNBALANCE

PRESET, CUSTOM = "chain.preset", "custom"
IDEAL, SWITCHES = "ideal", ("noise", "filter", "adc", "dac", "delay")
LARGEST_GRADE = 0.63  # m/s, of an unbalance: lost blades have 0.1, crankshafts of engines 0.63 and more
UNSTEADY = ("noise", "adc", "dac")  # effects with which no two turns are alike


def idle_switches(values: Assignments, stated: Collection[str]) -> list[str]:
    """Return a sentence on switches that were set but have no effect under the preset of the chain.

    The preset `custom` leaves each effect to its switch. Under `ideal` all effects are off, and under any other preset
    all are on, so that a switch changes nothing.

    Parameters
    ----------
    stated
        Parameters, `component.variable`, that the user has set.
    """
    controller = values.interfaces.get(CONTROLLER)
    preset = None if controller is None else controller.ports.get(PRESET)
    if preset is None or CUSTOM not in preset.items:
        return []
    name = f"{CONTROLLER}.{PRESET}"
    chosen = next(label for label, number in preset.items.items() if number == values.parameter(name))
    switches = [f"{CONTROLLER}.chain.{effect}" for effect in SWITCHES]
    idle = [s for s in switches if s in stated and bool(values.parameter(s)) == (chosen == IDEAL)]
    if chosen == CUSTOM or not idle:
        return []
    settings = ", ".join(f"{switch} = {'true' if values.parameter(switch) else 'false'}" for switch in idle)
    return [f"{settings} has no effect while {name} = {chosen}; to apply it, set {name} = {CUSTOM}"]


def unsteady_effects(values: Assignments) -> str:
    """Return the names of signal-chain effects that make every turn differ; empty if there are none."""
    effects = []
    for component, interface in values.interfaces.items():
        preset = interface.ports.get(PRESET)
        if preset is None or CUSTOM not in preset.items or not (chosen := values.parameter(f"{component}.{PRESET}")):
            continue
        switches = [f"{component}.chain.{effect}" for effect in UNSTEADY]
        custom = chosen == preset.items[CUSTOM]
        effects += [name for name in switches if not custom or values.parameter(name)]
    return f"{', '.join(effects)}: every turn differs from the others" if effects else ""


def implausible_sizes(assembly: Assembly) -> list[str]:
    """Return the sentences on implausible sizes of the rotors (see `rotor_analysis.implausible_sizes`)."""
    return [sentence for fmu in assembly.fmus.values() for sentence in (fmu.layout or {}).get("implausible", ())]


def implausible_unbalances(plan: Plan) -> list[str]:
    """Return a sentence for the largest unbalance of each rotor whose balancing grade is implausible.

        G = e Omega,   e = u/m     (ISO 21940-11)

    m is the mass of the rotor, and Omega is its highest speed. A wrong prefix in the unit of u changes u by a factor of
    1000, so that a balancing grade of 2.5 mm/s becomes 2500 mm/s.
    """
    changes = [*plan.inputs.items(), *((name, value) for _, name, value in plan.events)]
    of_profile = [value for ramp in plan.ramps if ramp.variable == SPEED for _, value in ramp.points]
    fastest = max([*(value for name, value in changes if name == SPEED), *of_profile], default=0.0)
    largest: dict[str, tuple[float, str]] = {}
    for name, value in changes:
        component, port = plan.port(name)
        if port.unit == UNBALANCE:
            largest[component] = max(largest.get(component, (0.0, "")), (abs(value), name))
    sentences = []
    for component, (u, name) in largest.items():
        fmu = plan.fmus.get(component)
        mass = 0.0 if fmu is None else (fmu.layout or {}).get("mass", 0.0)
        if u * fastest > LARGEST_GRADE * mass > 0.0:
            sentences.append(
                f"{name} = {u:.4g} kg m is implausible for {mass:.4g} kg at "
                f"{speed_unit().text(fastest)}: it gives an eccentricity of {1e3 * u / mass:.3g} mm, "
                f"G {1e3 * u / mass * fastest:.4g} (plausible: <= G {1e3 * LARGEST_GRADE:g}; "
                "residual unbalance: G 2.5); is it in g m or g mm?"
            )
    return sentences


def viscous_losses(assembly: Assembly) -> list[str]:
    """Return a sentence for each rotor whose loss factor is approximated by viscous damping (see `hysteresis`)."""
    losses = {name: (fmu.layout or {}).get("loss_factor", 0.0) for name, fmu in assembly.fmus.items()}
    return [
        f"{name}: loss_factor = {eta:g} is approximated by viscous damping with the same loss in the elastic modes of "
        "the free rotor at rest; this damping is too weak on stiff supports, and its effect on subsynchronous whirl "
        "grows with the spin speed ('study campbell' uses the loss factor itself)"
        for name, eta in losses.items()
        if eta
    ]
