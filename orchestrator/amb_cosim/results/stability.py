"""Whether a levitated rotor diverges: its orbit grows, or its amplifiers stay at their limits.

The end of a run is judged: the time since the last change, the last contact and cycle 0, at least `MIN_CYCLES`.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from amb_cosim.cosim.basics.choices import ROLES
from amb_cosim.cosim.record.signals import Signals
from amb_cosim.results.component_names import ACTUATOR, CONTROLLER, PLANT
from amb_cosim.results.places import places
from amb_cosim.results.series import cycles, displacements, parameters, signal, speed, speed_changes
from array_types import Array

LAST_CHANGE = "last_change_cycle"  # attribute of a data set: of the last event or point of the speed
MIN_CYCLES = 5.0
GROWTH = 1.5  # of the mean square from the first to the last third
NOTICEABLE = 1e-4  # of the smallest clearance; smaller motion counts as rest
STEADY_SPEED = 0.01  # relative change that is ignored
LIMITED_SHARE = 0.5  # of the last cycles, beyond which an axis stays at its limits
_TESTING = f"{CONTROLLER}.identification_progress"


def is_unstable(dataset: Signals, last_contact: float | None = None) -> bool:
    """Return whether the rotor diverges at the end of a run; `last_contact` is a cycle, or None."""
    cycle = cycles(dataset)
    end = float(cycle.max(initial=0.0))
    events = (float(dataset.attrs.get(name, 0.0)) for name in (LAST_CHANGE, *(f"{role}_cycle" for role in ROLES)))
    begin = max(0.0, last_contact or 0.0, *(event for event in events if event <= end))
    if end - begin < MIN_CYCLES:
        return False
    return orbit_grows(dataset, _since(cycle, begin)) or is_limited(dataset, _since(cycle, end - MIN_CYCLES))


def _since(cycle: Array, begin: float) -> slice:
    """Return the samples after a cycle."""
    return slice(int(np.searchsorted(cycle, begin, "right")), len(cycle))


def orbit_grows(dataset: Signals, within: slice) -> bool:
    """Return whether the motion at the bearings grows at an increasing rate, as modes of an unstable loop do.

        s_k = mean(|z(t) - z_1|^2) over third k of the time, z_k = mean(z),    summed over the bearings
        s_3 - s_2 > s_2 - s_1 > 0    and    s_3 > 1.5 s_1

    An orbit that approaches a larger steady one grows at a decreasing rate. With a changing speed the result is false.
    A rotor that drifts on a straight line is not unstable, see `_drifts`.

    Parameters
    ----------
    within
        Samples to judge, without events, contact and test forces.
    """
    if within.stop - within.start < 3:
        return False
    Omega = speed(dataset) if speed_changes(dataset) else signal(dataset, "speed")
    if Omega is not None and np.ptp(Omega[within]) > STEADY_SPEED * np.abs(Omega[within]).max():
        return False
    if _TESTING in dataset and np.ptp(np.asarray(dataset[_TESTING].values)[within]) > 0.0:
        return False
    recorded = (displacements(dataset, f"{bearing}.x", f"{bearing}.y") for bearing in places(dataset).bearings)
    motions = [np.array_split(m[0][within] + 1j * m[1][within], 3) for m in recorded if m is not None]
    if not motions:
        return False
    squares = np.sum([[_mean_square(third - thirds[0].mean()) for third in thirds] for thirds in motions], axis=0)
    first, second, third = squares
    rest = (NOTICEABLE * _least_clearance(dataset)) ** 2
    grows = third - second > second - first > 0.0 and third > GROWTH * first
    return bool(grows and third > rest and not _drifts(motions, rest))


def _drifts(motions: Sequence[Sequence[Array]], rest: float) -> bool:
    """Return whether motions at the bearings grow because their mean moves on a straight line, as that of a free rotor.

        v_k = mean(|z - line_k|^2) over third k, line_k the least-squares line there,    summed over the bearings
        v_3 <= 1.5 v_1 + rest    and    |z_3 - 2 z_2 + z_1| < 0.107 |z_3 - z_1|/2 + v_1^(1/2)

    The vibration of an unstable mode grows about these lines, whatever the drift. The mean of a real exponential that
    grows by 1.5 in mean square has a ratio of 1.107 = 1.5^(1/4) from third to third. The mean of a steady orbit over a
    third is not zero, and less than v_1^(1/2).

    Parameters
    ----------
    motions
        The motion x + j y in the three thirds, at each bearing (m).
    rest
        Mean square of a motion that counts as rest (m^2).
    """
    vibration = np.sum([[_mean_square(third - _line(third)) for third in thirds] for thirds in motions], axis=0)
    if vibration[2] > GROWTH * vibration[0] + rest:
        return False
    first, second, last = np.array([[third.mean() for third in thirds] for thirds in motions]).T
    bend, way = np.linalg.norm(last - 2.0 * second + first), np.linalg.norm(last - first) / 2.0
    return bool(bend < (GROWTH**0.25 - 1.0) * way + np.sqrt(vibration[0]))


def _mean_square(motion: Array) -> float:
    return float(np.mean(np.abs(motion) ** 2))


def _line(motion: Array) -> Array:
    """Return the least-squares line through equally spaced samples of a complex motion, shape (n,)."""
    place = np.arange(len(motion)) - (len(motion) - 1) / 2.0
    slope = np.sum(place * motion) / max(float(np.sum(place**2)), 1.0)
    return np.asarray(motion.mean() + slope * place)


def is_limited(dataset: Signals, within: slice) -> bool:
    """Return whether an axis is at its limits in more than half of the samples with all amplifiers on."""

    def share(label: str) -> float:
        samples = np.asarray(dataset[label].values)[within] if label in dataset else np.zeros(1)
        return np.count_nonzero(samples) / len(samples)

    axes = [f"{ACTUATOR}.{bearing}.{{}}_{axis}" for bearing in places(dataset).bearings for axis in "xy"]
    if any(share(axis.format(fault)) > 0.0 for axis in axes for fault in ("amplifier_off", "stuck")):
        return False
    limits = [axis.format(name) for axis in axes for name in ("clipped", "voltage_limited")]
    return any(share(label) > LIMITED_SHARE for label in (*limits, f"{CONTROLLER}.current_limited"))


def needed() -> tuple[str, ...]:
    """Return patterns of the judged variables, other than the displacements at the bearings."""
    names = ("clipped", "voltage_limited", "amplifier_off", "stuck")
    return (*(f"{ACTUATOR}.*.{name}_?" for name in names), f"{CONTROLLER}.current_limited", _TESTING, f"{PLANT}.speed")


def _least_clearance(dataset: Signals) -> float:
    """Return the smallest clearance of the sites (m); 0 without sites."""
    values = parameters(dataset)
    result = (values.get(f"{site}.clearance") for site in places(dataset).sites)
    return min((float(clearance) for clearance in result if clearance is not None), default=0.0)
