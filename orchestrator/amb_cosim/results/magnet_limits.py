"""Control currents and forces of the magnets of a run, and their limits."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from amb_cosim.cosim.record.signals import Signals
from amb_cosim.results.component_names import ACTUATOR, CONTROLLER
from amb_cosim.results.places import places
from amb_cosim.results.signal_arrays import parameters
from array_types import Array, Bools

MU_0 = 4e-7 * math.pi  # H/m
Limits = tuple[float, float]


def control_current(dataset: Signals, axis: str) -> Array | None:
    """Return the demanded control current (A) of an axis, `BEARING.x`, at each sample; None if it was not recorded."""
    return _recorded(dataset, axis, f"{CONTROLLER}.{{}}.i_{{}}")


def amplifier_off(dataset: Signals, axis: str) -> Bools:
    """Return the samples at which the amplifier of an axis is off; none if its state was not recorded."""
    off = _recorded(dataset, axis, f"{ACTUATOR}.{{}}.amplifier_off_{{}}")
    return np.zeros(dataset.sizes["time"], bool) if off is None else np.asarray(off, bool)


def demanded_current(dataset: Signals, axis: str) -> Array | None:
    """Return the demanded control current (A) of an axis; it is NaN while its amplifier is off and has no effect."""
    demand = control_current(dataset, axis)
    return None if demand is None else np.where(amplifier_off(dataset, axis), np.nan, demand)


def flowing_current(dataset: Signals, axis: str) -> Array | None:
    """Return the control current (A) that flows in the coils of an axis; None if their currents were not recorded.

        i = (i_upper - i_lower - I_s)/2,    i_upper = I_s + I_b - I_m + i,   i_lower = I_b - I_m - i

    The currents of healthy coil pairs have this i in common, and the bias I_b and the permanent magnets I_m cancel. A
    pair that has lost all its turns carries no current, so that i follows from the other pair. i is NaN while the
    amplifier is off, because the currents then decay without a demand.
    """
    p = magnet_parameters(dataset, axis)
    upper, lower = (_recorded(dataset, axis, f"{ACTUATOR}.{{}}.i_{pair}_{{}}") for pair in ("upper", "lower"))
    if upper is None or lower is None or not {"bias_current", "static_current"} <= p.keys():
        return None
    bias, static = p["bias_current"] - p.get("permanent_bias", 0.0), p["static_current"]
    above, below = upper - static - bias, bias - lower
    current = np.select(
        [_lost(dataset, axis, "upper"), _lost(dataset, axis, "lower")], [below, above], 0.5 * (above + below)
    )
    return np.where(amplifier_off(dataset, axis), np.nan, current)


def _lost(dataset: Signals, axis: str, pair: str) -> Bools:
    """Return the samples at which a coil pair of an axis has lost all its turns."""
    loss = _recorded(dataset, axis, f"{ACTUATOR}.{{}}.coil_loss_{pair}_{{}}")
    return np.zeros(dataset.sizes["time"], bool) if loss is None else loss >= 1.0


def magnet_force(dataset: Signals, axis: str) -> Array | None:
    """Return the force (N) of an axis at each sample; None if it was not recorded."""
    return _recorded(dataset, axis, f"{ACTUATOR}.{{}}.f_{{}}")


def is_magnetic(dataset: Signals, bearing: str) -> bool:
    """Return whether a bearing is ever energised and has a recorded current or force that is not always zero."""
    axes = [f"{bearing}.{axis}" for axis in places(dataset).directions(bearing)]
    signals = (of(dataset, axis) for of in (control_current, magnet_force) for axis in axes)
    has_power = not all(amplifier_off(dataset, axis).all() for axis in axes)
    return has_power and any(values is not None and bool(values.any()) for values in signals)


def current_limits(dataset: Signals, axis: str) -> Limits | None:
    """Return the smallest and largest control current (A) of an axis, `BEARING.x`; None if unknown."""
    bearing, _, direction = axis.rpartition(".")
    values = parameters(dataset, CONTROLLER)
    low, high = (values.get(f"{bearing}.{name}_{direction}") for name in ("i_min", "i_max"))
    if low is None or high is None or high <= low:
        return None
    return float(low), float(high)


def coil_limits(p: Mapping[str, float]) -> Limits:
    """Return the smallest and largest control current i (A) that the coils of an axis allow.

        max(0, I_m - I_max) <= I_s + I_b + i, I_b - i <= I_m + I_max

    Parameters
    ----------
    p
        Parameters of an axis as `magnet_parameters` returns them; I_m, the contribution of permanent magnets, may be
        missing.
    """
    bias, limit, permanent = p["bias_current"], p["current_limit"], p.get("permanent_bias", 0.0)
    operating, least, most = p["static_current"] + bias, max(0.0, permanent - limit), permanent + limit
    return max(least - operating, bias - most), min(most - operating, bias - least)


def magnet_parameters(dataset: Signals, axis: str) -> dict[str, float]:
    """Return the actuator's parameters for an axis, `BEARING.x`, by their names without the bearing and the axis."""
    bearing, _, direction = axis.rpartition(".")
    prefix, suffix = f"{bearing}.", f"_{direction}"
    return {
        name[len(prefix) : -len(suffix)]: float(value)
        for name, value in parameters(dataset, ACTUATOR).items()
        if name.startswith(prefix) and name.endswith(suffix) and not isinstance(value, str)
    }


def force_limits(dataset: Signals, axis: str) -> Limits | None:
    """Return the smallest and largest force (N) of an axis with the rotor centred; None if unknown.

        P = B^2 A_e cos(phi)/mu_0,   B = min(B_sat, mu_0 N (I_max + I_m)/l);   -P - F_0 <= F <= P - F_0         (2.6)

    One coil pair pulls with the largest force that the iron, the amplifier and the permanent magnets (I_m) allow, while
    the other does not pull. F_0 is the static load if the recorded force excludes its static part, and otherwise 0.
    """
    p = magnet_parameters(dataset, axis)
    if not {"turns", "pole_area", "gap", "half_angle", "bias_current", "static_current", "current_limit"} <= p.keys():
        return None
    per_ampere = MU_0 * p["turns"] / p["gap"]
    largest = p["current_limit"] + p.get("permanent_bias", 0.0)
    flux = min(p.get("b_sat", math.inf), per_ampere * largest)
    pull_of_square = p["pole_area"] * math.cos(p["half_angle"]) / MU_0
    operating = p["static_current"] + p["bias_current"]
    static = 0.0
    if not parameters(dataset, ACTUATOR).get("total_force"):
        static = pull_of_square * per_ampere**2 * (operating**2 - p["bias_current"] ** 2)
    return -pull_of_square * flux**2 - static, pull_of_square * flux**2 - static


def _recorded(dataset: Signals, axis: str, form: str) -> Array | None:
    label = form.format(*axis.rsplit(".", 1))
    return np.asarray(dataset[label].values, np.float64) if label in dataset else None
