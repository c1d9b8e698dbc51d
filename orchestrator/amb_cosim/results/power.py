"""Times at which the amplifiers of the magnets are off, during which warnings about their demand are irrelevant."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from amb_cosim.cosim.record.signals import Signals
from amb_cosim.cosim.record.warnings import WarningRecord, share_of_time
from amb_cosim.results.component_names import ACTUATOR, LIMITED
from amb_cosim.results.places import places
from amb_cosim.results.signal_arrays import cycles
from array_types import Bools


def amplifiers_off(dataset: Signals) -> list[Bools]:
    """Return the samples at which the amplifier is off, for each axis of a magnet with a switched amplifier."""
    axes = (axis.rsplit(".", 1) for axis in places(dataset).magnetic_axes)
    labels = [f"{ACTUATOR}.{magnet}.amplifier_off_{axis}" for magnet, axis in axes]
    return [np.asarray(dataset[label].values, bool) for label in labels if label in dataset]


def without_power(dataset: Signals) -> Bools:
    """Return the samples at which the amplifiers of all magnets are off; none without magnets."""
    off = amplifiers_off(dataset)
    if not off or len(off) < len(places(dataset).magnetic_axes):
        return np.zeros(dataset.sizes["time"], bool)
    return np.all(off, axis=0)


def power_lost_at(dataset: Signals) -> float | None:
    """Return the first cycle after which no magnet has power.

    The result is None if there are no magnets, or if one of them has power at the end.
    """
    off = without_power(dataset)
    if not off.any() or not off[-1]:
        return None
    powered = np.flatnonzero(~off)
    return float(cycles(dataset)[powered[-1] + 1 if len(powered) else 0])


def with_power(warned: Iterable[WarningRecord], dataset: Signals) -> list[WarningRecord]:
    """Return the warnings of a run, except those about demands that reach limits only while no amplifier is on.

    A demand has no effect while all amplifiers are off, so a warning that occurred at no other time is omitted.
    """
    return [
        part
        for record in warned
        for part in ([record] if record.variable not in LIMITED else _while_powered(record, dataset))
    ]


def _while_powered(warned: WarningRecord, dataset: Signals) -> list[WarningRecord]:
    label, unpowered = f"{warned.component}.{warned.variable}", without_power(dataset)
    if label not in dataset or not unpowered.any():
        return [warned]
    times = np.asarray(dataset["time"].values, np.float64)
    limited = (np.asarray(dataset[label].values) != 0) & ~unpowered
    if warned.first is not None and len(times) and warned.first < times[0]:
        return [warned]
    if not limited.any():
        return []
    first, last = times[limited][[0, -1]].tolist()
    return [replace(warned, first=first, last=last, share=share_of_time(times, limited))]
