"""Recursive Fourier transform of the sensor signals over the last revolution (thesis 5.20, 5.21).

    Q_n(t) = (2/T) integral_{t-T}^{t} q exp(-j n theta) ds = (1/pi) integral q exp(-j n theta) dtheta

over the last 2 pi of rotor angle, so that q ~ Re[sum Q_n exp(j n theta)]. At constant speed both forms are the
same; on the angle the harmonics stay orthogonal while the speed changes.

    oldest sample                                              newest sample
      o-----|-o-------o-------o---  ...  ---o-------o-------o-------o      angle ->
      excess|<------------------------ 2 pi ----------------------->|

Trapezoidal rule on the products q exp(-j n theta), the oldest segment cut where the revolution begins by
linear interpolation. Each segment is added once, when it enters, and subtracted once, when it leaves. What
is subtracted from (`OLD`) and what is added to (`FRESH`) are two sums: when the last segment of the old sum
has left, the rounding it has gathered is thrown away and the fresh sum takes its place, so nothing drifts.
"""

from __future__ import annotations

import math

from fmi_export.jit import kernel
from fmi_export.model import Array
from rolac_controller.names import N_HARMONICS, N_SENSORS

CAPACITY = 2048  # samples: down to 2 Hz at 4 kHz
LARGEST_STEP = 0.5 * math.pi  # rad between samples; more is a jump of the angle, and the window starts again
SLACK = 1e-9  # rad by which a revolution may fall short, so that rounding does not cost a sample
FEWEST_SAMPLES = 4.0  # in a period of a harmonic

# Layout of a window: sample numbers, two sums (angle; re, im for each harmonic and sensor), ring of samples (angle,
# sensors; cosine and sine of each harmonic's angle, since a sample counts four times).
FIRST, NEXT, RESTART = 0, 1, 2  # oldest sample held, next one to come, first of the fresh sum
N_Q = 2 * N_SENSORS
N_SUM = 1 + N_HARMONICS * N_Q
OLD = 3
FRESH = OLD + N_SUM
RING = FRESH + N_SUM
TURNED = 1 + N_SENSORS  # in a sample
N_SAMPLE = TURNED + 2 * N_HARMONICS
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
def turned(window: Array) -> float:
    """Angle from the sample before the newest to the newest (rad); 0 where there is none before it."""
    if window[NEXT] - window[FIRST] < 2:
        return 0.0
    return segment_width(window, window[NEXT] - 2)


@kernel
def add_segment(window: Array, orders: Array, sums: int, number: float, sign: float) -> None:
    """Add (sign 1) or subtract (-1) the segment from sample `number` to the next to the sum at `sums`."""
    a, b = slot(number), slot(number + 1)
    width = segment_width(window, number)
    weight = 0.5 * sign * width
    window[sums] += sign * width
    for k in range(N_HARMONICS):
        if orders[k] == 0.0:
            break
        cos_a, sin_a = window[a + TURNED + 2 * k], window[a + TURNED + 2 * k + 1]
        cos_b, sin_b = window[b + TURNED + 2 * k], window[b + TURNED + 2 * k + 1]
        of_harmonic = sums + 1 + k * N_Q
        for s in range(N_SENSORS):
            q_a, q_b = window[a + 1 + s], window[b + 1 + s]
            window[of_harmonic + 2 * s] += weight * (q_a * cos_a + q_b * cos_b)
            window[of_harmonic + 2 * s + 1] -= weight * (q_a * sin_a + q_b * sin_b)


@kernel
def drop_oldest(window: Array, orders: Array) -> None:
    """Let the oldest sample and its segment leave."""
    if window[FIRST] == window[RESTART]:
        for i in range(N_SUM):
            window[OLD + i] = window[FRESH + i]
            window[FRESH + i] = 0.0
        window[RESTART] = window[NEXT] - 1
    add_segment(window, orders, OLD, window[FIRST], -1.0)
    window[FIRST] += 1


@kernel
def empty(window: Array) -> None:
    """Forget all samples."""
    window[FIRST] = window[RESTART] = window[NEXT]
    for i in range(OLD, RING):
        window[i] = 0.0


@kernel
def record(window: Array, orders: Array, theta: float, sensors: Array) -> None:
    """Take in one sample and let go of what lies more than a revolution back.

    Parameters
    ----------
    window
        The window, shape (N_WINDOW,); all zeros is an empty one.
    orders
        Orders n of the harmonics, shape (N_HARMONICS,), the same at every call; the first 0 ends them.
    theta
        Rotor angle (rad), wrapped or not, within 1e18. A jump by more than `LARGEST_STEP` empties the window first.
    sensors
        Displacements, shape (N_SENSORS,) (m).
    """
    if window[NEXT] > window[FIRST] and abs(angle_between(window[slot(window[NEXT] - 1)], theta)) > LARGEST_STEP:
        empty(window)
    if window[NEXT] - window[FIRST] == CAPACITY:
        drop_oldest(window, orders)
    newest = slot(window[NEXT])
    window[newest] = theta
    for s in range(N_SENSORS):
        window[newest + 1 + s] = sensors[s]
    for k in range(N_HARMONICS):
        if orders[k] == 0.0:
            break
        window[newest + TURNED + 2 * k] = math.cos(orders[k] * theta)
        window[newest + TURNED + 2 * k + 1] = math.sin(orders[k] * theta)
    window[NEXT] += 1
    if window[NEXT] - window[FIRST] > 1:
        add_segment(window, orders, FRESH, window[NEXT] - 2, 1.0)
        while span(window) - segment_width(window, window[FIRST]) >= 2.0 * math.pi - SLACK:
            drop_oldest(window, orders)


@kernel
def revolution(window: Array) -> float:
    """Length of the last revolution in samples, with its fraction; 0 as long as less than one is held."""
    excess = span(window) - 2.0 * math.pi
    if excess < -SLACK:
        return 0.0
    samples: float = window[NEXT] - 1.0 - window[FIRST] - excess / segment_width(window, window[FIRST])
    return samples


@kernel
def components(window: Array, orders: Array, q: Array) -> None:
    """Components of the last revolution in all harmonics.

    Q_n = (1/pi) integral of q exp(-j n theta) dtheta over the last 2 pi (5.20, 5.21). For a signal with
    amplitude a in harmonic m (m = 0: constant) and delta rad between samples, the error is below

        a (m^2 + n^2) delta^3 sqrt(3) / (216 pi)

    to leading order in (m + n) delta, and nothing but rounding when the revolution is a whole number of
    samples (aliases excepted, m + n >= 2 pi/delta).

    Parameters
    ----------
    window
        The window, shape (N_WINDOW,).
    orders
        Orders n of the harmonics that the window was recorded with, shape (N_HARMONICS,); the first 0 ends them.
    q
        Receives re, im of each sensor for each harmonic, shape (N_HARMONICS N_Q,) (m). It is left as it is as long as
        less than a revolution is held, and where a period of the harmonic has fewer than `FEWEST_SAMPLES` samples.
    """
    samples = revolution(window)
    if samples == 0.0:
        return
    excess = span(window) - 2.0 * math.pi
    a, b = slot(window[FIRST]), slot(window[FIRST] + 1)
    part = excess / segment_width(window, window[FIRST])
    weight_a, weight_b = excess * (1.0 - 0.5 * part), excess * 0.5 * part
    for k in range(N_HARMONICS):
        n = orders[k]
        if n == 0.0 or samples < FEWEST_SAMPLES * n:
            break
        cos_a, sin_a = weight_a * window[a + TURNED + 2 * k], weight_a * window[a + TURNED + 2 * k + 1]
        cos_b, sin_b = weight_b * window[b + TURNED + 2 * k], weight_b * window[b + TURNED + 2 * k + 1]
        old, fresh = OLD + 1 + k * N_Q, FRESH + 1 + k * N_Q
        for s in range(N_SENSORS):
            q_a, q_b = window[a + 1 + s], window[b + 1 + s]
            re, im = 2 * s, 2 * s + 1
            q[k * N_Q + re] = (window[old + re] + window[fresh + re] - q_a * cos_a - q_b * cos_b) / math.pi
            q[k * N_Q + im] = (window[old + im] + window[fresh + im] + q_a * sin_a + q_b * sin_b) / math.pi
