"""Recursive Fourier transform of the sensor signals over the last revolution (thesis 5.20, 5.21).

The integral is defined in docs/theory/synchronous_control.md; it covers the last 2 pi of rotor angle, so that
q ~ Re[sum Q_n exp(j n theta)]. At constant speed this is the integral over one period of time.

    oldest sample                                              newest sample
      o-----|-o-------o-------o---  ...  ---o-------o-------o-------o      angle ->
      excess|<------------------------ 2 pi ----------------------->|

The trapezoidal rule is applied to the products q exp(-j n theta). Linear interpolation cuts the oldest segment at the
beginning of the revolution. Each segment is added once, when it enters the window, and subtracted once, when it leaves.
Segments are subtracted from one sum (`old`) and added to another (`fresh`). When the last segment of the old sum has
left, the fresh sum replaces the old one. This discards the rounding errors of the old sum and so prevents drift.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from fmi_export.jit import inlined_kernel, kernel, views
from fmi_export.model import Array
from fmi_export.parts import clear, copy_all, part
from fmi_export.records import record, size_of
from rolac_controller.complex_numbers import COMPLEX, REAL, Complex, divided, phasor
from rolac_controller.control_loop import N_HARMONICS
from rolac_controller.sizes import Records

CAPACITY = 2048  # samples: down to 2 Hz at 4 kHz
LARGEST_STEP = 0.5 * math.pi  # rad between samples; more is a jump of the angle, which restarts the window
ANGLE_TOLERANCE = 1e-9  # rad by which a revolution may fall short due to rounding
FEWEST_SAMPLES = 4.0  # in a period of a harmonic

EXTENT = record(
    ("first", "f8"),  # number of the oldest sample
    ("next", "f8"),  # number of the next sample to come
    ("fresh_from", "f8"),  # number of the sample with which the fresh sum begins
    ("old_angle", "f8"),  # that the old sum covers (rad)
    ("fresh_angle", "f8"),  # that the fresh sum covers (rad)
)
N_EXTENT = size_of(EXTENT)


class Window(NamedTuple):
    """The samples of the last revolution, and their sums.

    extent
        Record EXTENT, in an array of length 1.
    old, fresh
        The two sums for the integral of q exp(-j n theta) dtheta, shape (N_HARMONICS, n_sensors).
    thetas, displacements, phasors
        Angles, displacements and phasors exp(-j n theta) of the samples, shapes (CAPACITY,), (CAPACITY, n_sensors) and
        (CAPACITY, N_HARMONICS). These arrays are ring buffers: sample k is at index k modulo CAPACITY.
    """

    extent: Records
    old: Complex
    fresh: Complex
    thetas: Array
    displacements: Array
    phasors: Complex


@views
def window_size(n_sensors: int) -> int:
    """Return the size of the window for this number of sensors."""
    return N_EXTENT + 4 * N_HARMONICS * n_sensors + CAPACITY * (1 + n_sensors + 2 * N_HARMONICS)


@views
def window_of(array: Array, start: int, n_sensors: int) -> Window:
    """Return the window as views into an array, beginning at `start`; if all numbers are zero, the window is empty."""
    size = 2 * N_HARMONICS * n_sensors
    old = start + N_EXTENT
    thetas = old + 2 * size
    displacements = thetas + CAPACITY
    phasors = displacements + CAPACITY * n_sensors
    return Window(
        part(array, start, EXTENT, 1),
        part(array, old, COMPLEX, (N_HARMONICS, n_sensors)),
        part(array, old + size, COMPLEX, (N_HARMONICS, n_sensors)),
        part(array, thetas, REAL, CAPACITY),
        part(array, displacements, REAL, (CAPACITY, n_sensors)),
        part(array, phasors, COMPLEX, (CAPACITY, N_HARMONICS)),
    )


@kernel
def angle_between(earlier: float, later: float) -> float:
    """Return the change of angle, in [-pi, pi) (rad); both angles may be wrapped to one revolution."""
    change = later - earlier
    return change - 2.0 * math.pi * math.floor((change + math.pi) / (2.0 * math.pi))


@kernel
def ring_index(number: float) -> int:
    """Return the index of sample `number` in the ring buffers."""
    return int(number) % CAPACITY


@inlined_kernel
def segment_angle(window: Window, number: float) -> float:
    """Return the angle from sample `number` to the next (rad)."""
    return angle_between(window.thetas[ring_index(number)], window.thetas[ring_index(number + 1)])


@inlined_kernel
def window_angle(window: Window) -> float:
    """Return the angle from the oldest to the newest sample of the window (rad)."""
    angle: float = window.extent[0].old_angle + window.extent[0].fresh_angle
    return angle


@inlined_kernel
def last_delta_theta(window: Window) -> float:
    """Return the angle from the second newest to the newest sample (rad), or 0 if there are fewer than two samples."""
    extent = window.extent[0]
    if extent.next - extent.first < 2:
        return 0.0
    return segment_angle(window, extent.next - 2)


@inlined_kernel
def angle_jump(window: Window, theta: float) -> float:
    """Return the change of angle (rad) from the newest sample to `theta` if it exceeds `LARGEST_STEP`, else 0."""
    extent = window.extent[0]
    if extent.next == extent.first:
        return 0.0
    change = angle_between(window.thetas[ring_index(extent.next - 1)], theta)
    return change if abs(change) > LARGEST_STEP else 0.0


@inlined_kernel
def add_segment(window: Window, harmonics: Records, integral: Complex, number: float, sign: float) -> float:
    """Add the segment from sample `number` to the next sample to one of the sums (`sign` 1), or subtract it (-1).

    Returns
    -------
    float
        Change (rad) of the range of angles covered by the sum.
    """
    a, b = ring_index(number), ring_index(number + 1)
    width = angle_between(window.thetas[a], window.thetas[b])
    weight = 0.5 * sign * width
    for k in range(N_HARMONICS):
        if harmonics[k].order == 0.0:
            break
        phasor_a, phasor_b = window.phasors[a, k], window.phasors[b, k]
        for s in range(integral.shape[1]):
            ends = phasor_a * window.displacements[a, s] + phasor_b * window.displacements[b, s]
            integral[k, s] += weight * ends
    return sign * width


@inlined_kernel
def remove_oldest(window: Window, harmonics: Records) -> None:
    """Remove the oldest sample and its segment."""
    extent = window.extent[0]
    if extent.first == extent.fresh_from:
        copy_all(window.fresh, window.old)
        clear(window.fresh)
        extent.old_angle = extent.fresh_angle
        extent.fresh_angle = 0.0
        extent.fresh_from = extent.next - 1
    extent.old_angle += add_segment(window, harmonics, window.old, extent.first, -1.0)
    extent.first += 1


@inlined_kernel
def clear_window(window: Window) -> None:
    """Remove all samples."""
    extent = window.extent[0]
    extent.first = extent.next
    extent.fresh_from = extent.next
    extent.old_angle = 0.0
    extent.fresh_angle = 0.0
    clear(window.old)
    clear(window.fresh)


@inlined_kernel
def add_sample(window: Window, harmonics: Records, theta: float, displacements: Array) -> None:
    """Add one sample and remove samples more than a revolution old.

    Parameters
    ----------
    harmonics
        Records HARMONIC, shape (N_HARMONICS,), which must be the same at every call; the first order 0 ends the list.
    theta
        Rotor angle (rad), wrapped or not, with a magnitude of at most 1e18. If the angle jumps (`angle_jump`), the
        window is cleared first.
    displacements
        Displacements at the sensors, shape (n_sensors,) (m).
    """
    extent = window.extent[0]
    if angle_jump(window, theta) != 0.0:
        clear_window(window)
    if extent.next - extent.first == CAPACITY:
        remove_oldest(window, harmonics)
    newest = ring_index(extent.next)
    window.thetas[newest] = theta
    for s in range(displacements.shape[0]):
        window.displacements[newest, s] = displacements[s]
    for k in range(N_HARMONICS):
        if harmonics[k].order == 0.0:
            break
        window.phasors[newest, k] = phasor(harmonics[k].order * theta).conjugate()
    if extent.next > extent.first:
        extent.fresh_angle += add_segment(window, harmonics, window.fresh, extent.next - 1, 1.0)
    extent.next += 1
    while window_angle(window) - segment_angle(window, extent.first) >= 2.0 * math.pi - ANGLE_TOLERANCE:
        remove_oldest(window, harmonics)


@inlined_kernel
def samples_of_revolution(window: Window) -> float:
    """Return the length of the last revolution in samples, not rounded; 0 if the window has no full revolution."""
    excess = window_angle(window) - 2.0 * math.pi
    if excess < -ANGLE_TOLERANCE:
        return 0.0
    extent = window.extent[0]
    samples: float = extent.next - 1.0 - extent.first - excess / segment_angle(window, extent.first)
    return samples


@inlined_kernel
def transform(window: Window, harmonics: Records, Q: Complex) -> None:
    """Compute the components of all harmonics over the last revolution.

    Q_n is 1/pi times the integral of q exp(-j n theta) dtheta over the last 2 pi (5.20, 5.21). If the signal is a
    harmonic m (a constant if m = 0) with the amplitude a, sampled every delta rad, the error is below

        a (m^2 + n^2) delta^3 sqrt(3) / (216 pi)

    to leading order in (m + n) delta. If the revolution is a whole number of samples, the only error is rounding,
    unless the signal is aliased (m + n >= 2 pi/delta).

    Parameters
    ----------
    harmonics
        Records HARMONIC with which the window was filled, shape (N_HARMONICS,); the first order 0 ends the list.
    Q
        Receives the components, shape (N_HARMONICS, n_sensors) (m). Nothing is written while the window covers less
        than a revolution, or for harmonics with fewer than `FEWEST_SAMPLES` samples per period.
    """
    samples = samples_of_revolution(window)
    if samples == 0.0:
        return
    excess = window_angle(window) - 2.0 * math.pi
    first = window.extent[0].first
    a, b = ring_index(first), ring_index(first + 1)
    part = excess / segment_angle(window, first)
    weight_a, weight_b = excess * (1.0 - 0.5 * part), excess * 0.5 * part
    for k in range(N_HARMONICS):
        order = harmonics[k].order
        if order == 0.0 or samples < FEWEST_SAMPLES * order:
            break
        phasor_a, phasor_b = weight_a * window.phasors[a, k], weight_b * window.phasors[b, k]
        for s in range(Q.shape[1]):
            whole = window.old[k, s] + window.fresh[k, s]
            cut = whole - phasor_a * window.displacements[a, s] - phasor_b * window.displacements[b, s]
            Q[k, s] = divided(cut, math.pi)
