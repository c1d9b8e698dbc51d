"""Variations of what decides a run with contact: friction, restitution, the moment of the disturbance, and retainers.

Nobody knows friction and restitution within a per cent, and the moment at which a machine loses its power is a matter
of chance. A landing is therefore repeated with larger changes of these (`LANDING`). Restitution changes by an absolute
amount, because it is often zero.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from amb_cosim.cosim.system.values import Raw
from amb_cosim.results.component_names import ACTUATOR, PLANT
from amb_cosim.scenario.plan import ScenarioPlan
from amb_cosim.scenario.stators import switches_amplifiers_off
from amb_files.wildcards import matches
from amb_sweeps.event_phases import delays, disturbance_of
from amb_sweeps.variations import Variation, Variations
from rotor_contact.variables.contact_laws import CONSTRAINT
from rotor_contact.variables.enumerations import NEWTON

FRICTION = ("*.mu", "*.mu_*")
OF_RETAINERS = {  # zero if a retainer has a fixed housing, or a race that does not turn
    "mount stiffness": ("*.mount_stiffness_?",),
    "mount damping": ("*.mount_damping_?",),
    "race inertia": ("*.race_inertia",),
    "race drag": ("*.race_drag", "*.race_viscous_drag"),
}
OF_LAWS = {"contact stiffness": ("k_c",), "contact damping": ("c_c", "alpha_c", "eta")}  # compliant laws
DECISIVE = ("friction", "restitution", "phase")  # an outcome with contact is not robust if one of them is not varied
WITHOUT_EFFECT = "no contact law of the run uses it"  # why a quantity that cannot change the outcome is not varied
LANDING = 0.2, 0.1  # fraction of friction, and change of restitution, of a landing


@dataclass(frozen=True)
class Tolerances:
    """Changes of a run: a fraction of each quantity, one of friction, an amount of restitution, and a number of phases.

    A friction or restitution of None changes as in `LANDING` if magnets lose their power, otherwise by `change`.
    """

    change: float
    friction: float | None = None
    restitution: float | None = None
    phases: int = 32

    def of_contact(self, *, lands: bool) -> tuple[float, float]:
        """Return the fraction by which friction changes, and the amount by which restitution changes."""
        friction, restitution = LANDING if lands else (self.change, self.change)
        return (
            friction if self.friction is None else self.friction,
            restitution if self.restitution is None else self.restitution,
        )


def contact_variations(plan: ScenarioPlan, tolerances: Tolerances) -> Variations:
    """Return variations of a run with contact, whose events have labels or roles (`with_labels`)."""
    made: list[Variation] = []
    extents: dict[str, str] = {}
    left_out: dict[str, str] = {}
    event, without_power = disturbance_of(plan), _starts_without_power(plan)
    lands = without_power or (event is not None and switches_amplifiers_off(event))
    friction, restitution = tolerances.of_contact(lands=lands)
    for name, variations_of_name, extent in (
        ("friction", *_frictions(plan, friction)),
        ("restitution", *_restitutions(plan, restitution)),
        *_of_retainers(plan, tolerances.change),
    ):
        made += variations_of_name
        (extents if variations_of_name else left_out)[name] = extent
    if without_power:
        left_out["phase"] = "magnets have no power from the start"
    elif event is not None:
        try:
            made += [Variation(name, settings) for name, settings in _delayed(plan, tolerances.phases).items()]
            extents["phase"] = f"{tolerances.phases} phases of the {event.name.replace('_', ' ')}"
        except ValueError as error:
            left_out["phase"] = str(error)
    elif (disturbance := plan.scenario.by_role("disturbance")) and disturbance in plan.scenario.profile:
        left_out["phase"] = f"{disturbance.described} begins at a fixed time"
    return Variations(tuple(made), left_out, extents)


def _starts_without_power(plan: ScenarioPlan) -> bool:
    return any(value and matches(name, f"{ACTUATOR}.*.amplifier_off_?") for name, value in plan.inputs.items())


def _delayed(plan: ScenarioPlan, phases: int) -> Mapping[str, Mapping[str, Raw]]:
    event = disturbance_of(plan)
    if event is None or phases < 2:
        raise ValueError("only one phase was run")
    return delays(plan, event, phases)


def _plant(plan: ScenarioPlan) -> dict[str, float]:
    """Return the parameters of the plant that are numbers."""
    return {name: value for name, value in plan.all_parameters().get(PLANT, {}).items() if value is not None}


def _frictions(plan: ScenarioPlan, fraction: float) -> tuple[list[Variation], str]:
    """Return variations of friction, and by how much it changes, or no variations and the reason.

    Friction that is zero everywhere increases to the value of `fraction`.
    """
    plant = _plant(plan)
    of_sites = {name: value for name, value in plant.items() if any(matches(name, pattern) for pattern in FRICTION)}
    if not of_sites or not fraction:
        return [], "its change is 0" if of_sites else "the plant has no such parameter"
    if any(of_sites.values()):
        return _times("friction", fraction, of_sites), _percent(fraction)
    more: dict[str, Raw] = {f"{PLANT}.{name}": fraction for name in of_sites if matches(name, FRICTION[0])}
    return [Variation(f"friction + {fraction:g}", more)], f"0 to {fraction:g}"


def _restitutions(plan: ScenarioPlan, change: float) -> tuple[list[Variation], str]:
    """Return variations of the restitution of all sites and faces, and its change, or no variations and the reason."""
    plant = _plant(plan)
    laws = {name.removesuffix(".law"): law for name, law in plant.items() if name.endswith(".law")}
    rebounds = plant.get("contact.impact_law", NEWTON) == NEWTON
    values = {}
    for name, value in plant.items():
        place = name.removesuffix(".restitution")  # a face has no law
        if place != name and (place not in laws or (laws[place] == CONSTRAINT and rebounds)):
            values[name] = value
    if not values or not change:
        return [], "its change is 0" if values else WITHOUT_EFFECT
    ports = plan.interfaces[PLANT].ports
    made = []
    for sign, step in (("+", change), ("-", -change)):
        new = {name: min(max(value + step, ports[name].minimum), ports[name].maximum) for name, value in values.items()}
        if new != values:
            made.append(
                Variation(f"restitution {sign} {change:g}", {f"{PLANT}.{name}": value for name, value in new.items()})
            )
    return made, f"{change:g}"


def _of_retainers(plan: ScenarioPlan, change: float) -> Iterator[tuple[str, list[Variation], str]]:
    """Yield each property of mounts, races and compliant contact that the plant has, with variations and their size."""
    plant = _plant(plan)
    compliant = [
        name.removesuffix(".law") for name, law in plant.items() if name.endswith(".law") and law != CONSTRAINT
    ]
    laws = {what: tuple(f"{site}.{name}" for site in compliant for name in names) for what, names in OF_LAWS.items()}
    for quantity, patterns in {**OF_RETAINERS, **laws}.items():
        values = {name: value for name, value in plant.items() if any(matches(name, pattern) for pattern in patterns)}
        if any(values.values()):
            yield quantity, _times(quantity, change, values), _percent(change)


def _times(quantity: str, fraction: float, values: Mapping[str, float]) -> list[Variation]:
    """Return two variations that increase and decrease a quantity by a fraction."""
    made = []
    for sign, factor in (("+", 1.0 + fraction), ("-", 1.0 - fraction)):
        settings: dict[str, Raw] = {f"{PLANT}.{name}": factor * value for name, value in values.items() if value}
        made.append(Variation(f"{quantity} {sign} {_percent(fraction)}", settings))
    return made


def _percent(fraction: float) -> str:
    return f"{100.0 * fraction:g} %"
