"""Test forces of an identification: amplitude, duration and phases (thesis 5.11 to 5.14, 6.3 to 6.6)."""

from __future__ import annotations

import math

from fmi_export.jit import kernel
from rolac_controller.complex_numbers import phasor, scaled
from rolac_controller.control_loop import N_HARMONICS
from rolac_controller.sizes import Records

FEWEST_PERIODS, PERIODS_PER_HZ = 45.0, 3.0
FORCE = 220.0  # N
ROUNDING = 1e-6  # by which a number of periods may exceed a whole number


@kernel
def amplitude_at(frequency: float) -> float:
    """Return the amplitude A(f) = 220/S(f) of a test force (N); S(f) models the rotor's response (6.5, 6.6).

    S(f) is 0.25 f + 2 up to 10 Hz, -0.2 f + 6.5 from 10 to 30 Hz, and 0.4 above.
    """
    if frequency <= 10.0:
        return FORCE / (0.25 * frequency + 2.0)
    if frequency < 30.0:
        return FORCE / (6.5 - 0.2 * frequency)
    return FORCE / 0.4


@kernel
def periods(frequency: float) -> float:
    """Return N_per = max(3 f, 45) rounded up, the revolutions in a slot (6.4); n slots take n N_per/f seconds (6.3)."""
    needed = max(PERIODS_PER_HZ * frequency, FEWEST_PERIODS)
    return float(math.ceil(needed - ROUNDING))


@kernel
def power_share(harmonics: Records, number: int) -> float:
    """Return the fraction P of the test force's power that a harmonic has."""
    total = 0.0
    for k in range(N_HARMONICS):
        if harmonics[k].order == 0.0:
            break
        total += harmonics[k].power
    share: float = harmonics[number].power / total if total > 0.0 else 0.0
    return share


@kernel
def schroeder_phase(harmonics: Records, number: int) -> float:
    """Return the phase of a harmonic (rad) (5.13); these phases, with phi_1 = 0, keep the peaks of the sum low.

    The phase is phi_i = -2 pi sum_{m < i} (n_i - n_m) P_m, where n are the orders; if these are consecutive, n_i - n_m
    = i - m.
    """
    phase = 0.0
    for m in range(number):
        phase -= 2.0 * math.pi * (harmonics[number].order - harmonics[m].order) * power_share(harmonics, m)
    return phase


@kernel
def force_component(harmonics: Records, number: int, multi: bool, scale: float, frequency: float) -> complex:
    """Return the complex amplitude of a harmonic of the test force (N).

    A single harmonic has the amplitude A(f). Several harmonics have the amplitudes A sqrt(P), where A is evaluated at
    each harmonic's frequency, so that the total power is the same (5.14). Their phases follow Schroeder's rule (5.13).

    Parameters
    ----------
    harmonics
        Records HARMONIC, shape (N_HARMONICS,); the first order 0 ends the list.
    number
        Number of the harmonic, from 0.
    multi
        Whether all harmonics are excited instead of only the first.
    scale
        Factor by which the force is multiplied.
    frequency
        Frequency of rotation (Hz).
    """
    order = harmonics[number].order
    if order == 0.0 or (number > 0 and not multi):
        return 0j
    amplitude = scale * amplitude_at(order * frequency)
    if not multi:
        return complex(amplitude, 0.0)
    amplitude *= math.sqrt(power_share(harmonics, number))
    return scaled(phasor(schroeder_phase(harmonics, number)), amplitude)
