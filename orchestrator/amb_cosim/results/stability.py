"""Whether a levitated rotor diverges: its orbit grows, or its amplifiers stay at their limits.

The end of a run is judged: the time since the last change, the last contact and cycle 0, at least `MIN_CYCLES`.
"""

from __future__ import annotations

import numpy as np

from amb_cosim.cosim.basics.choices import ROLES
from amb_cosim.cosim.record.signals import Signals, variables_of
from amb_cosim.results.component_names import ACTUATOR, CONTROLLER, LIMITED, PLANT
from amb_cosim.results.growth import FEWEST, grows
from amb_cosim.results.places import places
from amb_cosim.results.series import cycles, displacements, parameters, signal, speed, speed_changes
from array_types import Array

LAST_CHANGE = "last_change_cycle"  # attribute of a data set: of the last event or point of the speed
MIN_CYCLES = 5.0
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
    """Return whether a part of the motion at the bearings grows exponentially, as modes of an unstable loop do.

    Steady orbits, drifts on a straight line, and orbits that approach another one do not grow (`results.growth`).
    Samples are taken at equal angles of the shaft, so that a synchronous orbit is steady while the speed varies by up
    to 1 %. With a larger change of the speed the result is false.

    Parameters
    ----------
    within
        Samples to judge, without events, contact and test forces.
    """
    if within.stop - within.start < FEWEST:
        return False
    Omega = speed(dataset) if speed_changes(dataset) else signal(dataset, "speed")
    if Omega is not None and np.ptp(Omega[within]) > STEADY_SPEED * np.abs(Omega[within]).max():
        return False
    if _TESTING in dataset and np.ptp(np.asarray(dataset[_TESTING].values)[within]) > 0.0:
        return False
    recorded = [displacements(dataset, f"{bearing}.x", f"{bearing}.y") for bearing in places(dataset).bearings]
    signals = [np.asarray(values, dtype=float)[within] for pair in recorded if pair is not None for values in pair]
    if not signals:
        return False
    motion = np.stack(signals, axis=1)
    if Omega is not None and np.ptp(Omega[within]) > 0.0:
        motion = _at_equal_angles(np.asarray(dataset["time"].values)[within], np.asarray(Omega)[within], motion)
    return grows(motion, NOTICEABLE * _least_clearance(dataset))


def _at_equal_angles(time: Array, Omega: Array, motion: Array) -> Array:
    """Return as many samples of a motion at equal angles of the shaft, by the speed (rad/s) at equal times (s)."""
    angle = np.concatenate([[0.0], np.cumsum(0.5 * (np.abs(Omega[1:]) + np.abs(Omega[:-1])) * np.diff(time))])
    if not (np.diff(angle) > 0.0).all():
        return motion
    from scipy.interpolate import CubicSpline  # slow to import

    return np.asarray(CubicSpline(angle, motion)(np.linspace(0.0, angle[-1], len(angle))))


def is_limited(dataset: Signals, within: slice) -> bool:
    """Return whether an axis is at its limits in more than half of the samples with all amplifiers on."""

    def share(label: str) -> float:
        samples = np.asarray(dataset[label].values)[within] if label in dataset else np.zeros(1)
        return np.count_nonzero(samples) / len(samples)

    axes = [f"{ACTUATOR}.{bearing}.{{}}_{axis}" for bearing in places(dataset).bearings for axis in "xy"]
    if any(share(axis.format(fault)) > 0.0 for axis in axes for fault in ("amplifier_off", "stuck")):
        return False
    limits = [axis.format(name) for axis in axes for name in ("clipped", "voltage_limited")]
    limits += [name for name in variables_of(dataset) if name.rpartition(".")[2] in LIMITED]
    return any(share(label) > LIMITED_SHARE for label in limits)


def needed() -> tuple[str, ...]:
    """Return patterns of the judged variables, other than the displacements at the bearings."""
    names = ("clipped", "voltage_limited", "amplifier_off", "stuck")
    axes, demands = (f"{ACTUATOR}.*.{name}_?" for name in names), (f"*.{name}" for name in LIMITED)
    return (*axes, *demands, _TESTING, f"{PLANT}.speed")


def _least_clearance(dataset: Signals) -> float:
    """Return the smallest clearance of the sites (m); 0 without sites."""
    values = parameters(dataset)
    clearances = (values.get(f"{site}.clearance") for site in places(dataset).sites)
    return min((float(clearance) for clearance in clearances if clearance is not None), default=0.0)
