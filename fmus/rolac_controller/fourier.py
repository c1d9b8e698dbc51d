"""Recursive Fourier transform of the sensor signals over the last revolution (thesis 5.20, 5.21).

    Q_n(t) = (2/T) integral_{t-T}^{t} q exp(-j n theta) ds = (1/pi) integral q exp(-j n theta) dtheta

over the last 2 pi of rotor angle, so that q ~ Re[sum Q_n exp(j n theta)]. At constant speed both forms are the
same; on the angle the harmonics stay orthogonal while the speed changes.

    oldest sample                                              newest sample
      o-----|-o-------o-------o---  ...  ---o-------o-------o-------o      angle ->
      excess|<------------------------ 2 pi ----------------------->|

Trapezoidal rule on the products q exp(-j n theta), the oldest segment cut where the revolution begins by
linear interpolation. Each segment is added once, when it enters, and subtracted once, when it leaves. Segments are
subtracted from one sum (`old`) and added to another (`fresh`): when the last segment of the old sum has left, its
accumulated rounding is dropped and the fresh sum takes its place, so that nothing drifts.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from fmi_export.jit import kernel
from fmi_export.model import Array
from fmi_export.records import record
from rolac_controller.complex_numbers import Complex, divided, phasor
from rolac_controller.rig_layout import N_HARMONICS, N_SENSORS

CAPACITY = 2048  # samples: down to 2 Hz at 4 kHz
LARGEST_STEP = 0.5 * math.pi  # rad between samples; more is a jump of the angle, and the window starts again
ANGLE_TOLERANCE = 1e-9  # rad by which a revolution may fall short, so that rounding does not cost a sample
FEWEST_SAMPLES = 4.0  # in a period of a harmonic

SAMPLE = record(
    ("theta", "f8"),
    ("displacements", "f8", (N_SENSORS,)),
    ("phasors", "c16", (N_HARMONICS,)),  # exp(-j n theta)
)
SUM = record(
    ("angle", "f8"),
    ("components", "c16", (N_HARMONICS, N_SENSORS)),  # integral q exp(-j n theta) dtheta
)
WINDOW = record(
    ("first", "f8"),  # number of the oldest sample
    ("next", "f8"),  # number of the next sample to come
    ("fresh_from", "f8"),  # number of the sample with which the fresh sum begins
    ("old", SUM),
    ("fresh", SUM),
    ("samples", SAMPLE, (CAPACITY,)),  # a ring: sample k is at k modulo CAPACITY
)


@kernel
def angle_between(earlier: float, later: float) -> float:
    """Return the change of angle in [-pi, pi), whether the angles are wrapped to a revolution or not (rad)."""
    change = later - earlier
    return change - 2.0 * math.pi * math.floor((change + math.pi) / (2.0 * math.pi))


@kernel
def ring_index(number: float) -> int:
    """Return where sample `number` is in the ring."""
    return int(number) % CAPACITY


@kernel
def segment_angle(window: np.record, number: float) -> float:
    """Return the angle from sample `number` to the one after it (rad)."""
    return angle_between(window.samples[ring_index(number)].theta, window.samples[ring_index(number + 1)].theta)


@kernel
def window_angle(window: np.record) -> float:
    """Return the angle from the oldest sample of the window to the newest (rad)."""
    angle: float = window.old.angle + window.fresh.angle
    return angle


@kernel
def last_delta_theta(window: np.record) -> float:
    """Return the angle from the sample before the newest to the newest (rad); 0 where there is none before it."""
    if window.next - window.first < 2:
        return 0.0
    return segment_angle(window, window.next - 2)


@kernel
def add_segment(
    window: np.record, harmonics: NDArray[np.record], integral: np.record, number: float, sign: float
) -> None:
    """Add (sign 1) or subtract (sign -1) the segment from sample `number` to the next to one of the two sums."""
    a, b = window.samples[ring_index(number)], window.samples[ring_index(number + 1)]
    width = angle_between(a.theta, b.theta)
    weight = 0.5 * sign * width
    integral.angle += sign * width
    for k in range(N_HARMONICS):
        if harmonics[k].order == 0.0:
            break
        for s in range(N_SENSORS):
            ends = a.phasors[k] * a.displacements[s] + b.phasors[k] * b.displacements[s]
            integral.components[k, s] += weight * ends


@kernel
def clear_sum(integral: np.record) -> None:
    """Set a sum to zero."""
    integral.angle = 0.0
    integral.components[:] = 0.0


@kernel
def remove_oldest(window: np.record, harmonics: NDArray[np.record]) -> None:
    """Remove the oldest sample and its segment."""
    if window.first == window.fresh_from:
        window.old = window.fresh
        clear_sum(window.fresh)
        window.fresh_from = window.next - 1
    add_segment(window, harmonics, window.old, window.first, -1.0)
    window.first += 1


@kernel
def clear_window(window: np.record) -> None:
    """Remove all samples."""
    window.first = window.next
    window.fresh_from = window.next
    clear_sum(window.old)
    clear_sum(window.fresh)


@kernel
def add_sample(window: np.record, harmonics: NDArray[np.record], theta: float, displacements: Array) -> None:
    """Add one sample and remove what lies more than a revolution back.

    Parameters
    ----------
    window
        Record WINDOW; all zeros is an empty one.
    harmonics
        Records HARMONIC, shape (N_HARMONICS,), the same at every call; the first order 0 ends them.
    theta
        Rotor angle (rad), wrapped or not, within 1e18. A jump by more than `LARGEST_STEP` clears the window first.
    displacements
        Of the sensors, shape (N_SENSORS,) (m).
    """
    if window.next > window.first:
        jump = angle_between(window.samples[ring_index(window.next - 1)].theta, theta)
        if abs(jump) > LARGEST_STEP:
            clear_window(window)
    if window.next - window.first == CAPACITY:
        remove_oldest(window, harmonics)
    newest = window.samples[ring_index(window.next)]
    newest.theta = theta
    for s in range(N_SENSORS):
        newest.displacements[s] = displacements[s]
    for k in range(N_HARMONICS):
        if harmonics[k].order == 0.0:
            break
        newest.phasors[k] = phasor(harmonics[k].order * theta).conjugate()
    if window.next > window.first:
        add_segment(window, harmonics, window.fresh, window.next - 1, 1.0)
    window.next += 1
    while window_angle(window) - segment_angle(window, window.first) >= 2.0 * math.pi - ANGLE_TOLERANCE:
        remove_oldest(window, harmonics)


@kernel
def samples_of_revolution(window: np.record) -> float:
    """Return the length of the last revolution in samples, with its fraction; 0 while there is less than one."""
    excess = window_angle(window) - 2.0 * math.pi
    if excess < -ANGLE_TOLERANCE:
        return 0.0
    samples: float = window.next - 1.0 - window.first - excess / segment_angle(window, window.first)
    return samples


@kernel
def transform(window: np.record, harmonics: NDArray[np.record], Q: Complex) -> None:
    """Find the components of the last revolution in all harmonics.

    Q_n = (1/pi) integral of q exp(-j n theta) dtheta over the last 2 pi (5.20, 5.21). For a signal with
    amplitude a in harmonic m (m = 0: constant) and delta rad between samples, the error is below

        a (m^2 + n^2) delta^3 sqrt(3) / (216 pi)

    to leading order in (m + n) delta, and nothing but rounding when the revolution is a whole number of
    samples (aliases excepted, m + n >= 2 pi/delta).

    Parameters
    ----------
    window
        Record WINDOW.
    harmonics
        Records HARMONIC that the window was filled with, shape (N_HARMONICS,); the first order 0 ends them.
    Q
        Receives the components, shape (N_HARMONICS, N_SENSORS) (m). It is not changed while the window has
        less than a revolution, nor for a harmonic whose period has fewer than `FEWEST_SAMPLES` samples.
    """
    samples = samples_of_revolution(window)
    if samples == 0.0:
        return
    excess = window_angle(window) - 2.0 * math.pi
    a, b = window.samples[ring_index(window.first)], window.samples[ring_index(window.first + 1)]
    part = excess / segment_angle(window, window.first)
    weight_a, weight_b = excess * (1.0 - 0.5 * part), excess * 0.5 * part
    for k in range(N_HARMONICS):
        order = harmonics[k].order
        if order == 0.0 or samples < FEWEST_SAMPLES * order:
            break
        phasor_a, phasor_b = weight_a * a.phasors[k], weight_b * b.phasors[k]
        for s in range(N_SENSORS):
            whole = window.old.components[k, s] + window.fresh.components[k, s]
            cut = whole - phasor_a * a.displacements[s] - phasor_b * b.displacements[s]
            Q[k, s] = divided(cut, math.pi)
