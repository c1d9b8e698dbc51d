"""Comparison of signals of several runs: common signals, their differences, and signals that only some runs have."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from amb_cosim.cosim.record.differences import differences
from amb_cosim.cosim.record.signals import AT_STEPS, Signals, variables_of
from amb_cosim.results.signal_arrays import cycles, finite_signals, not_finite

MOST_NAMES = 6  # most names in a printed list
OBSERVED = ("m", "N", "A", "V", "rad/s", "K")  # units of signals that are preferred to energies, angles and flags
NOTABLE = 1e-6  # of the range: a smaller difference of such a signal is not preferred


@dataclass(frozen=True)
class LargestDifference:
    """Largest difference of a signal from the same signal of the first run, in its unit, and the cycle of the value."""

    signal: str
    unit: str
    difference: float
    cycle: float


@dataclass(frozen=True)
class AgainstFirst:
    """Comparison of a run with the first run at the times at which both have samples.

    label
        The run.
    same_times
        Whether both have samples at the same times, up to the end of the shorter run; otherwise signals are not
        compared.
    compared, equal
        Number of common signals, and number of common signals that are bitwise equal.
    not_finite
        Common signals that differ and have non-finite values in at least one of the two runs.
    largest
        Difference of the signal that deviates most, relative to the largest range of any signal with its unit in the
        two runs. Motions, forces, currents, speeds and temperatures are preferred to other signals, of which flags and
        counts come last. None if no signal with a range differs.
    """

    label: str
    same_times: bool
    compared: int
    equal: int
    largest: LargestDifference | None
    not_finite: tuple[str, ...] = ()


@dataclass(frozen=True)
class SignalComparison:
    """Signals of the runs.

    common
        Signals that all runs have.
    only_some
        For each signal that not all runs have, the runs that have it.
    against_first
        Comparison of each other run with the first.
    """

    common: tuple[str, ...]
    only_some: dict[str, tuple[str, ...]]
    against_first: tuple[AgainstFirst, ...]

    def text(self) -> list[str]:
        """Return a line for each run, and for each group of signals that only some runs have."""
        lines = []
        for other in self.against_first:
            if not other.same_times:
                lines.append(
                    f"{other.label}: its sampling times differ from those of the first run, so signals are not compared"
                )
                continue
            text = f"{other.label}: {other.equal} of {other.compared} common signals are bitwise equal"
            if other.largest is not None:
                worst = other.largest
                by = f"{worst.difference:.4g} {worst.unit}".rstrip()
                text += f"; {worst.signal} deviates most, by {by} at cycle {worst.cycle:.4g}"
            if other.not_finite:
                text += f"; deviation not computed for: {not_finite(other.not_finite)}"
            lines.append(text)
        groups: dict[tuple[str, ...], list[str]] = {}
        for signal, labels in self.only_some.items():
            groups.setdefault(labels, []).append(signal)
        for labels, names in groups.items():
            more = f" and {len(names) - MOST_NAMES} more" if len(names) > MOST_NAMES else ""
            lines.append(f"only in {' and '.join(labels)}: {', '.join(names[:MOST_NAMES])}{more}")
        return lines


def compare_signals(labels: Sequence[str], runs: Sequence[Signals]) -> SignalComparison:
    """Return the common signals of runs, and their differences from the first run.

    Parameters
    ----------
    labels
        Names of the runs.
    runs
        Their records.
    """
    names = [[name for name in variables_of(run) if not name.endswith(AT_STEPS)] for run in runs]  # each name once
    every = dict.fromkeys(name for of_run in names for name in of_run)
    having = {
        name: tuple(label for label, of_run in zip(labels, names, strict=True) if name in of_run) for name in every
    }
    common = tuple(name for name, owners in having.items() if len(owners) == len(labels))
    only_some = {name: owners for name, owners in having.items() if len(owners) < len(labels)}
    against = (
        _against(label, runs[0], run, [name for name in names[0] if name in of_run])
        for label, run, of_run in zip(labels[1:], runs[1:], names[1:], strict=True)
    )
    return SignalComparison(common, only_some, tuple(against))


def _against(label: str, first: Signals, run: Signals, names: Iterable[str]) -> AgainstFirst:
    """Return the differences of a run's signals from the signals of the first run."""
    shorter = min(first.sizes["time"], run.sizes["time"])
    times, first_times = (np.asarray(record["time"].values[:shorter]) for record in (run, first))
    compared = [*names]
    if not shorter or not np.array_equal(times, first_times):
        return AgainstFirst(label, False, len(compared), 0, None)
    equal, left_out = 0, {*finite_signals(first)[1], *finite_signals(run)[1]}
    unequal = []
    ranges: dict[str, float] = {}  # largest range of the signals of a unit
    differing: list[LargestDifference] = []
    for name in compared:
        reference, values = (np.asarray(record[name].values[:shorter], dtype=np.float64) for record in (first, run))
        unit = _unit(first, name)
        if name not in left_out:
            ranges[unit] = max(ranges.get(unit, 0.0), float(np.ptp(reference)), float(np.ptp(values)))
        if np.array_equal(values, reference, equal_nan=True):
            equal += 1
        elif name in left_out:
            unequal.append(name)
        else:
            difference = differences(values, reference, unit)
            at = int(np.argmax(difference))
            differing.append(LargestDifference(name, unit, float(difference[at]), float(cycles(first)[at])))
    return AgainstFirst(label, True, len(compared), equal, _largest(differing, ranges), tuple(unequal))


def _unit(record: Signals, name: str) -> str:
    unit = str(record[name].attrs.get("units", ""))
    return "" if unit == "1" else unit


def _largest(differing: Iterable[LargestDifference], ranges: Mapping[str, float]) -> LargestDifference | None:
    """Return the difference that matters most to a user (`AgainstFirst.largest`)."""

    def rank(item: LargestDifference) -> tuple[bool, bool, float]:
        share = item.difference / ranges[item.unit]
        return item.unit in OBSERVED and share > NOTABLE, item.unit != "", share

    return max(
        (item for item in differing if ranges[item.unit] > 0.0 and item.difference > 0.0), key=rank, default=None
    )
