"""Warnings on currents that no amplifier is there to carry."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from amb_cosim.cosim.record.signals import Signals
from amb_cosim.cosim.record.warnings import WarningRecord
from amb_cosim.results.component_names import CONTROLLER
from amb_cosim.results.power import without_power

DEMAND = (CONTROLLER, "current_limited")


def with_power(warned: Iterable[WarningRecord], dataset: Signals) -> list[WarningRecord]:
    """Return warnings of a run; a demand at its limit counts only while an amplifier is on.

    With all amplifiers off the demand has no effect; the warning is omitted if there is no other time.
    """
    return [
        left
        for record in warned
        for left in ([record] if (record.component, record.variable) != DEMAND else _heard(record, dataset))
    ]


def _heard(warned: WarningRecord, dataset: Signals) -> list[WarningRecord]:
    label, silent = ".".join(DEMAND), without_power(dataset)
    if label not in dataset or not silent.any():
        return [warned]
    times = np.asarray(dataset["time"].values, np.float64)
    true = (np.asarray(dataset[label].values) != 0) & ~silent
    if warned.first is not None and len(times) and warned.first < times[0]:
        return [warned]
    if not true.any():
        return []
    return [replace(warned, first=float(times[true][0]), last=float(times[true][-1]), share=float(np.mean(true)))]
