"""Recursive Fourier transform of the sensor signals over the last revolution (thesis 5.20, 5.21).

    Q(t) = (2/T) integral_{t-T}^{t} q exp(-j theta) ds = (1/pi) integral q exp(-j theta) dtheta

over the last 2 pi of rotor angle, so that q ~ Re[Q exp(j theta)]. At constant speed both forms are the
same; on the angle the harmonics stay orthogonal while the speed changes.

    oldest sample                                              newest sample
      o-----|-o-------o-------o---  ...  ---o-------o-------o-------o      angle ->
      excess|<------------------------ 2 pi ----------------------->|

Trapezoidal rule on the products q exp(-j theta), the oldest segment cut where the revolution begins by
linear interpolation. Each segment is added once, when it enters, and subtracted once, when it leaves. What
is subtracted from (`OLD`) and what is added to (`FRESH`) are two sums: when the last segment of the old sum
has left, the rounding it has gathered is thrown away and the fresh sum takes its place, so nothing drifts.
"""

from __future__ import annotations

import math

from fmi_export.jit import kernel
from fmi_export.model import Array

N_SENSORS = 8
CAPACITY = 2048  # samples: down to 2 Hz at 4 kHz
LARGEST_STEP = 0.5 * math.pi  # rad between samples; more is a jump of the angle, and the window starts again
SLACK = 1e-9  # rad by which a revolution may fall short, so that rounding does not cost a sample

# Layout of a window: sample numbers, two sums (angle; re, im per sensor), ring of samples (angle, sensors).
FIRST, NEXT, RESTART = 0, 1, 2  # oldest sample held, next one to come, first of the fresh sum
N_SUM = 1 + 2 * N_SENSORS
OLD = 3
FRESH = OLD + N_SUM
RING = FRESH + N_SUM
N_SAMPLE = 1 + N_SENSORS
N_WINDOW = RING + CAPACITY * N_SAMPLE


@kernel
def angle_between(earlier: float, later: float) -> float:
    """Change of angle in [-pi, pi), whether the angles are wrapped to a revolution or not (rad)."""
    change = later - earlier
    return change - 2.0 * math.pi * math.floor((change + math.pi) / (2.0 * math.pi))


@kernel
def slot(number: float) -> int:
    """Where sample `number` is in the window array."""
    return RING + int(number) % CAPACITY * N_SAMPLE


@kernel
def segment_width(window: Array, number: float) -> float:
    """Angle from sample `number` to the one after it (rad)."""
    return angle_between(window[slot(number)], window[slot(number + 1)])


@kernel
def span(window: Array) -> float:
    """Angle from the oldest sample held to the newest (rad)."""
    angle: float = window[OLD] + window[FRESH]
    return angle


@kernel
def add_segment(window: Array, sums: int, number: float, sign: float) -> None:
    """Add (sign 1) or subtract (-1) the segment from sample `number` to the next to the sum at `sums`."""
    a, b = slot(number), slot(number + 1)
    width = segment_width(window, number)
    weight = 0.5 * sign * width
    cos_a, sin_a = math.cos(window[a]), math.sin(window[a])
    cos_b, sin_b = math.cos(window[b]), math.sin(window[b])
    window[sums] += sign * width
    for s in range(N_SENSORS):
        q_a, q_b = window[a + 1 + s], window[b + 1 + s]
        window[sums + 1 + 2 * s] += weight * (q_a * cos_a + q_b * cos_b)
        window[sums + 2 + 2 * s] -= weight * (q_a * sin_a + q_b * sin_b)


@kernel
def drop_oldest(window: Array) -> None:
    """Let the oldest sample and its segment leave."""
    if window[FIRST] == window[RESTART]:
        for i in range(N_SUM):
            window[OLD + i] = window[FRESH + i]
            window[FRESH + i] = 0.0
        window[RESTART] = window[NEXT] - 1
    add_segment(window, OLD, window[FIRST], -1.0)
    window[FIRST] += 1


@kernel
def empty(window: Array) -> None:
    """Forget all samples."""
    window[FIRST] = window[RESTART] = window[NEXT]
    for i in range(OLD, RING):
        window[i] = 0.0


@kernel
def record(window: Array, theta: float, sensors: Array) -> None:
    """Take in one sample and let go of what lies more than a revolution back.

    Parameters
    ----------
    window
        The window, shape (N_WINDOW,); all zeros is an empty one.
    theta
        Rotor angle (rad), wrapped or not, within 1e18. A jump by more than `LARGEST_STEP` empties the window first.
    sensors
        Displacements, shape (N_SENSORS,) (m).
    """
    if window[NEXT] > window[FIRST] and abs(angle_between(window[slot(window[NEXT] - 1)], theta)) > LARGEST_STEP:
        empty(window)
    if window[NEXT] - window[FIRST] == CAPACITY:
        drop_oldest(window)
    newest = slot(window[NEXT])
    window[newest] = theta
    for s in range(N_SENSORS):
        window[newest + 1 + s] = sensors[s]
    window[NEXT] += 1
    if window[NEXT] - window[FIRST] > 1:
        add_segment(window, FRESH, window[NEXT] - 2, 1.0)
        while span(window) - segment_width(window, window[FIRST]) >= 2.0 * math.pi - SLACK:
            drop_oldest(window)


@kernel
def synchronous(window: Array, q: Array) -> float:
    """Synchronous components of the last revolution, and how many samples it took.

    Q = (1/pi) integral of q exp(-j theta) dtheta over the last 2 pi (5.20, 5.21). For a signal with
    amplitude a in harmonic m (m = 0: constant) and delta rad between samples, the error is below

        a (m^2 + 1) delta^3 sqrt(3) / (216 pi)

    to leading order in (m + 1) delta, and nothing but rounding when the revolution is a whole number of
    samples (aliases excepted, m + 1 >= 2 pi/delta).

    Parameters
    ----------
    window
        The window, shape (N_WINDOW,).
    q
        Receives re, im of each sensor, shape (2 N_SENSORS,) (m); zeros as long as less than a revolution is
        held.

    Returns
    -------
    float
        Length of the revolution in samples, with its fraction; 0 as long as less than one is held.
    """
    excess = span(window) - 2.0 * math.pi
    if excess < -SLACK:
        for i in range(2 * N_SENSORS):
            q[i] = 0.0
        return 0.0
    a, b = slot(window[FIRST]), slot(window[FIRST] + 1)
    part = excess / segment_width(window, window[FIRST])
    weight_a, weight_b = excess * (1.0 - 0.5 * part), excess * 0.5 * part
    cos_a, sin_a = weight_a * math.cos(window[a]), weight_a * math.sin(window[a])
    cos_b, sin_b = weight_b * math.cos(window[b]), weight_b * math.sin(window[b])
    for s in range(N_SENSORS):
        q_a, q_b = window[a + 1 + s], window[b + 1 + s]
        re, im = 1 + 2 * s, 2 + 2 * s
        q[2 * s] = (window[OLD + re] + window[FRESH + re] - q_a * cos_a - q_b * cos_b) / math.pi
        q[2 * s + 1] = (window[OLD + im] + window[FRESH + im] + q_a * sin_a + q_b * sin_b) / math.pi
    samples: float = window[NEXT] - 1.0 - window[FIRST] - part
    return samples
