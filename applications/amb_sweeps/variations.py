"""Variations of a scenario that test whether its outcome is robust: small changes, one at a time."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from amb_cosim.cosim.system.values import Raw
from amb_cosim.model_constants.receptance_file import ReceptanceTable
from amb_cosim.results.component_names import CONTROLLER, PLANT
from amb_cosim.scenario.plan import ScenarioPlan
from amb_cosim.scenario.scenario import UNBALANCE
from amb_files.wildcards import matches

STEP = 2.0 * np.pi  # rad/s between speeds at which H is identified, for runs with a varying speed
SWITCHES = {name: f"{CONTROLLER}.{name}" for name in ("rolac_enable", "identify")}

# Quantities and their parameters: of a controller with gains K_b and C_b, of one with k_p and k_d, of the plant.
ASSUMED = {"K_b": "*.k_b_?", "C_b": "*.c_b_?"}
DIRECT = {"k_p": "*.k_p_?", "k_d": "*.k_d_?"}
OF_PLANT = {"K_b": "*.k_b", "C_b": "*.c_b", "clearance": "*.clearance"}


Setting = Raw | ReceptanceTable


@dataclass(frozen=True)
class Variation:
    """A change, and the settings that make it."""

    name: str
    settings: Mapping[str, Setting]


@dataclass(frozen=True)
class Variations:
    """Variations of a scenario, reasons why other quantities are not varied, and changes of those that are, by name."""

    made: tuple[Variation, ...]
    left_out: Mapping[str, str]
    extents: Mapping[str, str]

    def with_others(self, others: Variations) -> Variations:
        """Return these variations, followed by others."""
        return Variations(
            (*self.made, *others.made), {**self.left_out, **others.left_out}, {**self.extents, **others.extents}
        )


def variations(
    plan: ScenarioPlan, settings: Mapping[str, Raw], change: float, identified: Callable[[], ReceptanceTable]
) -> Variations:
    """Return variations of the scenario: each quantity increased and decreased, and H as identified in a simulation.

    Each variation changes one quantity everywhere at once: K_b, C_b or alpha for all bearings, the clearances of all
    sites, or the unbalances of all discs.

    Parameters
    ----------
    plan
        The unchanged scenario.
    settings
        Values that replaced those of the scenario.
    change
        Fraction by which each quantity is changed, such as 0.01.
    identified
        Function that identifies H and returns its table; called only if the controller uses such a table.
    """
    made, left_out, extents = [], {}, {}
    if reason := _without_h(plan):
        left_out["identified H"] = reason
    else:
        try:
            made.append(Variation("identified H", {"receptances": identified()}))
            extents["identified H"] = ""
        except ValueError as error:
            left_out["identified H"] = f"its identification failed: {error}"
    for name, scaled in _quantities(plan, settings):
        if isinstance(scaled, str):
            left_out[name] = scaled
            continue
        extents[name] = f"{100.0 * change:g} %"
        for sign, factor in (("+", 1.0 + change), ("-", 1.0 - change)):
            made.append(Variation(f"{name} {sign} {100.0 * change:g} %", scaled(factor)))
    return Variations(tuple(made), left_out, extents)


def identification_speeds(plan: ScenarioPlan) -> list[float]:
    """Return the speeds (rad/s) at which H is identified: the speed of the run, or a grid over its speed range."""
    speeds = [plan.speed, *(speed for _, speed in plan.profile)]
    lowest = plan.all_parameters()[CONTROLLER]["rolac.min_speed"] or 0.0
    low, high = max(min(speeds), lowest), max(speeds)
    return [high] if high - low < STEP else [float(v) for v in np.linspace(low, high, 1 + round((high - low) / STEP))]


Scaled = Callable[[float], dict[str, Raw]]


def _quantities(plan: ScenarioPlan, settings: Mapping[str, Raw]) -> Iterator[tuple[str, Scaled | str]]:
    """Yield each quantity with a function that scales its settings by a factor, or the reason why it is not varied."""
    values = {k: dict(v) for k, v in plan.all_parameters().items()}
    controller, plant = values.get(CONTROLLER, {}), values.get(PLANT, {})
    gains = DIRECT if controller.get("pid.direct") else ASSUMED
    nominal: dict[str, dict[str, float]] = {}
    for component, parameters, patterns in ((CONTROLLER, controller, gains), (PLANT, plant, OF_PLANT)):
        for quantity, pattern in patterns.items():
            matching = {f"{component}.{n}": v for n, v in parameters.items() if v and matches(n, pattern)}
            nominal[quantity] = nominal.get(quantity, {}) | matching
    if _is_on(plan, "rolac_enable"):
        nominal["alpha"] = {f"{CONTROLLER}.rolac.alpha": controller["rolac.alpha"] or 0.0}
    else:
        yield "alpha", "the synchronous control is off"
    for quantity, values_of_quantity in nominal.items():
        yield (
            quantity,
            _times(values_of_quantity) if any(values_of_quantity.values()) else "the parameter is zero everywhere",
        )
    yield "unbalance", _unbalance(plan, settings)


def _times(values: Mapping[str, float]) -> Scaled:
    return lambda factor: {name: factor * value for name, value in values.items()}


def _unbalance(plan: ScenarioPlan, settings: Mapping[str, Raw]) -> Scaled | str:
    """Return a function that scales all unbalances, including any set by the user; a text if there are none."""
    assignments = plan.assembly.assignments()
    first = {n: v for n, v in plan.inputs.items() if v and assignments.port(n).unit == UNBALANCE}
    later = [n for _, n, value in plan.events if value and assignments.port(n).unit == UNBALANCE]
    if not first and not later:
        return "there is none"
    replaced = {name for values in settings if "." in values for name in assignments.matching(values)} & first.keys()
    unbalance_factor = plan.scenario.unbalance_factor
    return lambda factor: {
        "unbalance_factor": unbalance_factor * factor,
        **{name: factor * first[name] for name in replaced},
    }


def _is_on(plan: ScenarioPlan, switch: str) -> bool:
    """Return whether an input of the controller is on at any time during the run."""
    name = SWITCHES[switch]
    return bool(plan.inputs.get(name)) or any(value for _, changed, value in plan.events if changed == name)


def _without_h(plan: ScenarioPlan) -> str:
    """Return the reason why a run has no variation with identified H; empty if the outcome depends on H."""
    if not _is_on(plan, "rolac_enable"):
        return "the synchronous control is off"
    if _is_on(plan, "identify"):
        return "the run identifies H itself"
    return "the scenario has its own table of H" if plan.scenario.receptances is not None else ""
