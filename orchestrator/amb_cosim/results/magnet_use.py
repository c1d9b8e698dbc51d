"""The largest current and force of the magnets of a run, as shares of their limits."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

from amb_cosim.cosim.record.signals import Signals
from amb_cosim.presentation.descriptions import name_label
from amb_cosim.presentation.units import force_unit
from amb_cosim.results.magnet_limits import (
    Limits,
    amplifier_off,
    coil_limits,
    current_limits,
    demanded_current,
    flowing_current,
    force_limits,
    magnet_force,
    magnet_parameters,
)
from amb_cosim.results.places import places
from amb_cosim.results.signal_arrays import cycles
from array_types import Array

DIFFERS = 0.01  # of the limit, by which a demanded current differs from the one that flows


class Use(NamedTuple):
    """The largest ratio of a value to its limit, with this value, the limit, and the name of the axis."""

    share: float
    value: float
    limit: float
    axis: str


def magnet_use_rows(dataset: Signals) -> Iterator[tuple[str, str]]:
    """Yield labels and texts for the largest currents and force over all energised axes, from cycle 0 on.

    The control current is the one that flows. The demanded one has its own row if its share of the limit differs by
    more than `DIFFERS`, because an amplifier that is slow or at its voltage limit does not follow its demand. It also
    has one if the currents of the coils were not recorded.
    """
    flowing, demanded = (largest_use(dataset, of, allowed_currents) for of in (flowing_current, demanded_current))
    if flowing is not None:
        yield "largest control current", _current_text(flowing)
    if demanded is not None and (flowing is None or abs(demanded.share - flowing.share) > DIFFERS):
        yield "largest demanded current", _current_text(demanded)
    force = largest_use(dataset, powered_force, force_limits)
    if force is not None:
        value, limit = (force_unit(abs(of)).text(abs(of), 3) for of in (force.value, force.limit))
        where = f"{_percent(force)} of its limit at {force.axis}"
        yield "largest magnet force", f"{where}: {value} of {limit} with the rotor centred"


def largest_use(
    dataset: Signals,
    values_of: Callable[[Signals, str], Array | None],
    limits_of: Callable[[Signals, str], Limits | None],
) -> Use | None:
    """Return the largest ratio of a value to its limit over all axes from cycle 0 on; None if no axis has both.

    share = max(max(v)/high, min(v)/low),   low < 0 < high
    """
    after, uses = cycles(dataset) >= 0.0, list[Use]()
    for axis in places(dataset).magnetic_axes:
        values, limits = values_of(dataset, axis), limits_of(dataset, axis)
        if values is None or limits is None or not np.isfinite(values[after]).any():
            continue
        extremes = (float(np.nanmin(values[after])), float(np.nanmax(values[after])))
        signed = [
            (value, limit) for value, limit in zip(extremes, limits, strict=True) if limit and value * limit > 0.0
        ]
        uses += [Use(value / limit, value, limit, name_label(axis)) for value, limit in signed]
    return max(uses, default=None)


def allowed_currents(dataset: Signals, axis: str) -> Limits | None:
    """Return the smallest and largest control current (A) that the controller and the coils allow; None if unknown."""
    p, of_controller = magnet_parameters(dataset, axis), current_limits(dataset, axis)
    if not {"bias_current", "static_current", "current_limit"} <= p.keys():
        return of_controller
    low, high = coil_limits(p)
    if of_controller is not None:
        low, high = max(low, of_controller[0]), min(high, of_controller[1])
    return (float(low), float(high)) if low < 0.0 < high else None


def powered_force(dataset: Signals, axis: str) -> Array | None:
    """Return the force (N) of an axis at each sample, NaN while its amplifier is off; None if not recorded."""
    force = magnet_force(dataset, axis)
    return None if force is None else np.where(amplifier_off(dataset, axis), np.nan, force)


def _current_text(use: Use) -> str:
    return f"{_percent(use)} of its limit at {use.axis}: {abs(use.value):.3g} A of {abs(use.limit):.3g} A"


def _percent(use: Use) -> str:
    return f"{100.0 * use.share:.3g} %"
