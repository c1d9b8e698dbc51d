"""Signals of a data set as arrays; a signal that was not recorded is None."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from amb_cosim.cosim.choices import Role
from amb_cosim.cosim.record.signals import AT_STEPS, EACH_STEP, Samples, Signals, SignalTable, variables_of
from amb_cosim.results.component_names import CONTROLLER, PLANT
from array_types import Array

Path = Array  # x and y of a motion over time, shape (2, n)

LARGEST = 1e100  # value in any unit whose powers and products stay finite
MOST_NAMES = 6  # signals that a sentence names

CONTROL_ACTS = f"{CONTROLLER}.rolac_active"


def finite_signals(dataset: Signals) -> tuple[Signals, tuple[str, ...]]:
    """Return a record without signals that are not finite or exceed `LARGEST`, and the names of these signals.

    FMUs and files from elsewhere may contain such values, from which no key value or limit of an axis can be computed.
    """
    left_out = tuple(name for name in variables_of(dataset) if not _is_finite(dataset[name].values))
    if not left_out:
        return dataset, ()
    kept = (name for name in variables_of(dataset) if name not in left_out)
    variables = {name: _samples(dataset, name) for name in kept}
    coordinates = {name: _samples(dataset, name) for name in ("time", "cycle", EACH_STEP) if name in dataset}
    return SignalTable(variables, coordinates, dataset.attrs), left_out


def _is_finite(values: NDArray[Any]) -> bool:
    """Return whether all values are finite and within `LARGEST`."""
    return not len(values) or bool(values.min() >= -LARGEST and values.max() <= LARGEST)


def _samples(dataset: Signals, name: str) -> Samples:
    """Return the samples of a signal, with one value per step if its name ends in `AT_STEPS`."""
    values = dataset[name]
    return Samples(values.values, values.attrs, EACH_STEP if name.endswith(AT_STEPS) or name == EACH_STEP else "time")


def not_finite(left_out: Sequence[str]) -> str:
    """Return a clause that names the signals which `finite_signals` leaves out."""
    named = ", ".join(left_out[:MOST_NAMES])
    others = f" and {len(left_out) - MOST_NAMES} others" if len(left_out) > MOST_NAMES else ""
    return f"{named}{others} {'has' if len(left_out) == 1 else 'have'} values that are not finite or exceed {LARGEST:g}"


def at_every_step(dataset: Signals) -> Signals:
    """Return the values of a thinned record at every step, over `time` and `cycle`; return other records unchanged.

    In a long run each row covers several steps, with the largest values, the sums or the means over them.
    """
    if EACH_STEP not in dataset:
        return dataset
    time = dataset[EACH_STEP].values
    coordinates = {"time": Samples(time, {})}
    if "period_s" in dataset.attrs:  # a system without a scenario has no cycles
        coordinates["cycle"] = Samples(time / dataset.attrs["period_s"], {})
    names = [name for name in variables_of(dataset) if name.endswith(AT_STEPS)]
    return SignalTable(
        {name.removesuffix(AT_STEPS): Samples(dataset[name].values, dataset[name].attrs) for name in names},
        coordinates,
        dataset.attrs,
    )


def thinning(dataset: Signals) -> int:
    """Return the number of communication steps from each sample to the next; 1 for a full record."""
    steps = np.diff(dataset["time"].values)
    step = dataset.attrs.get("communication_step_s")
    return max(1, round(float(np.median(steps)) / float(step))) if step and len(steps) else 1


def signal(dataset: Signals, name: str) -> NDArray[Any] | None:
    """Return the samples of a variable of the plant, or None if it was not recorded."""
    label = f"{PLANT}.{name}"
    return np.asarray(dataset[label].values) if label in dataset else None


def flags(dataset: Signals, label: str) -> dict[int, str] | None:
    """Return the names of the values of a variable; None if it was not recorded, or its values have no names."""
    attributes = dataset[label].attrs if label in dataset else {}
    if "flag_meanings" not in attributes:
        return None
    names = str(attributes["flag_meanings"]).split()
    return dict(zip((int(value) for value in attributes["flag_values"]), names, strict=True))


def shares_of_steps(dataset: Signals) -> dict[str, float] | None:
    """Return the share of the steps from cycle 0 on that the plant computed by each method.

    The methods have the names of the plant's output `solver.method`. A sample has the method of the step that ends at
    it, so that the sample at cycle 0 does not count. The result is None if this output was not recorded, or if no step
    follows cycle 0.
    """
    dataset = at_every_step(dataset)
    names = flags(dataset, f"{PLANT}.solver.method")
    methods, after = signal(dataset, "solver.method"), cycles(dataset) > 0.0
    if methods is None or names is None or not after.any():
        return None
    shares = {name: float(np.mean(methods[after] == value)) for value, name in names.items()}
    return {name: share for name, share in shares.items() if share > 0.0}


def displacements(dataset: Signals, x: str, y: str) -> Path | None:
    """Return two variables as x and y, shape (2, n), in their unit; None if either was not recorded."""
    x_samples, y_samples = signal(dataset, x), signal(dataset, y)
    return None if x_samples is None or y_samples is None else np.array([x_samples, y_samples], np.float64)


def cycles(dataset: Signals) -> Array:
    """Return the cycle of each sample."""
    return np.asarray(dataset["cycle"].values, dtype=np.float64)


def parameters(dataset: Signals, component: str = PLANT) -> dict[str, Any]:
    """Return the parameters of a component, by default the plant; none if the run did not contain it."""
    stored = dataset.attrs.get("parameters", "{}")  # JSON, unless the result is only judged
    of_components: Mapping[str, dict[str, Any]] = _decoded(stored) if isinstance(stored, str) else stored
    return of_components.get(component, {})


@lru_cache(maxsize=1)
def _decoded(text: str) -> dict[str, dict[str, Any]]:
    result: dict[str, dict[str, Any]] = json.loads(text)
    return result


def speed_changes(dataset: Signals) -> bool:
    """Return whether the spin speed changes during the run: by a profile, or because the rotor spins freely."""
    return "speed_profile" in dataset.attrs or _free_speed(dataset) is not None


def speed(dataset: Signals) -> Array:
    """Return the spin speed (rad/s) at each sample."""
    free = _free_speed(dataset)
    if free is not None:
        return free
    profile = json.loads(dataset.attrs.get("speed_profile", "[]")) or [(0.0, dataset.attrs["speed_rad_s"])]
    times, speeds = np.array(profile, dtype=np.float64).T
    return np.interp(dataset["time"].values, times, speeds)


def _free_speed(dataset: Signals) -> Array | None:
    """Return the speed of a freely spinning rotor (rad/s); None for others, or if it was not recorded."""
    measured = signal(dataset, "speed")
    if measured is None or not parameters(dataset).get("spin.free"):
        return None
    return np.asarray(measured, np.float64)


def turns(dataset: Signals) -> Array:
    """Return the revolutions of the rotor since cycle 0 at each sample; at constant speed these are the cycles."""
    if not speed_changes(dataset) or not dataset.sizes["time"]:
        return cycles(dataset)
    time, Omega = dataset["time"].values, speed(dataset)
    turned = np.concatenate([[0.0], np.cumsum(0.5 * (Omega[1:] + Omega[:-1]) * np.diff(time))]) / (2.0 * np.pi)
    return np.asarray(turned - np.interp(0.0, time, turned))


def event_name(dataset: Signals, role: Role) -> str:
    """Return the label, in words, of the event that has a role, or the role itself if the run has no such event."""
    return str(dataset.attrs.get(f"{role}_label", role)).replace("_", " ")


def change(dataset: Signals) -> float | None:
    """Return the cycle of the disturbance or, if there is none, the cycle in which ROLAC starts."""
    if "disturbance_cycle" in dataset.attrs:
        return float(dataset.attrs["disturbance_cycle"])
    return switched_on(dataset)


def switched_on(dataset: Signals) -> float | None:
    """Return the cycle in which ROLAC starts; None if it is on from the beginning or never."""
    if CONTROL_ACTS not in dataset:
        return None
    acts = np.asarray(dataset[CONTROL_ACTS].values, dtype=bool)
    return float(cycles(dataset)[np.argmax(acts)]) if acts.any() and not acts[0] else None
