"""Test forces of an identification: how strong, how long, with which phases (thesis 5.11 to 5.14, 6.3 to 6.6)."""

from __future__ import annotations

import math

from fmi_export.jit import kernel
from fmi_export.model import Array
from rolac_controller.names import N_HARMONICS

FEWEST_PERIODS, PERIODS_PER_HZ = 45.0, 3.0
FORCE = 220.0  # N
WHOLE = 1e-6  # by which a number of periods may exceed a whole one


@kernel
def amplitude_at(frequency: float) -> float:
    """Amplitude A(f) = 220/S(f) of a test force (N), the stronger the less the rotor moves (6.5, 6.6).

    S(f) = 0.25 f + 2 up to 10 Hz, -0.2 f + 6.5 up to 30 Hz, 0.4 from there on.
    """
    if frequency <= 10.0:
        return FORCE / (0.25 * frequency + 2.0)
    if frequency < 30.0:
        return FORCE / (6.5 - 0.2 * frequency)
    return FORCE / 0.4


@kernel
def periods(frequency: float) -> float:
    """Whole revolutions of a slot, N_per = max(3 f, 45), rounded up (6.3); six slots take 6 N_per/f (6.4)."""
    needed = max(PERIODS_PER_HZ * frequency, FEWEST_PERIODS)
    return float(math.ceil(needed - WHOLE))


@kernel
def share(orders: Array, powers: Array, number: int) -> float:
    """Share P of a harmonic in the power of the test force; the harmonics are `orders` up to the first 0."""
    total = 0.0
    for k in range(N_HARMONICS):
        if orders[k] == 0.0:
            break
        total += powers[k]
    of_total: float = powers[number] / total if total > 0.0 else 0.0
    return of_total


@kernel
def schroeder_phase(orders: Array, powers: Array, number: int) -> float:
    """Phase of a harmonic that keeps the peaks of the sum low, phi_1 = 0 (rad) (5.13).

    phi_i = -2 pi sum_{m < i} (n_i - n_m) P_m, with the orders n: for consecutive ones n_i - n_m = i - m.
    """
    phase = 0.0
    for m in range(number):
        phase -= 2.0 * math.pi * (orders[number] - orders[m]) * share(orders, powers, m)
    return phase


@kernel
def component(
    orders: Array, powers: Array, number: int, multi: bool, scale: float, frequency: float
) -> tuple[float, float]:
    """Real and imaginary part of one harmonic of the test force (N).

    One harmonic alone has the amplitude A(f). Several have A sqrt(P), each at its own frequency, so that the power
    stays the same (5.14), and Schroeder's phases.

    Parameters
    ----------
    orders, powers
        Orders and relative powers of the harmonics, shape (N_HARMONICS,).
    number
        Which harmonic, from 0.
    multi
        Whether all harmonics are excited, or the first alone.
    scale
        Factor on the force.
    frequency
        Frequency of rotation (Hz).
    """
    if orders[number] == 0.0 or (number > 0 and not multi):
        return 0.0, 0.0
    amplitude = scale * amplitude_at(orders[number] * frequency)
    if not multi:
        return amplitude, 0.0
    amplitude *= math.sqrt(share(orders, powers, number))
    phase = schroeder_phase(orders, powers, number)
    return amplitude * math.cos(phase), amplitude * math.sin(phase)
