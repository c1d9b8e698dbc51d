"""The run-down of a rotor from the end of a run to standstill, its heat, and the temperatures of its retainers."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from array_types import Array

ROUNDING = 1e-9  # change of the speed, relative, that is no loss
EXTRAPOLATED = 1000  # time steps of a coast-down


@dataclass(frozen=True)
class CoastDown:
    """The run-down of a rotor from the end of a run to standstill, which is the last element of each array.

    times
        Times since the start of the run (s).
    speeds
        Magnitudes of the spin speed at these times (rad/s).
    heats
        Energy of the spin that contact has dissipated until these times (J).
    """

    times: Array
    speeds: Array
    heats: Array

    @property
    def time(self) -> float:
        """Time of standstill (s)."""
        return float(self.times[-1])

    @property
    def heat(self) -> float:
        """Energy of the spin (J) that contact dissipates until standstill."""
        return float(self.heats[-1])

    def warming(self, share: float, of_race: float) -> Array:
        """Return the heat (J) of a retainer over the times.

            Q = s Q_spin + E (1 - (Omega/Omega_1)^2)                                                   (1)

        A race slows down with the rotor, and its drag and its friction dissipate its energy E in the retainer.

        Parameters
        ----------
        share
            Share s of the heat Q_spin of contact.
        of_race
            Kinetic energy E (J) of the race at the end of the run.
        """
        return share * self.heats + of_race * (1.0 - (self.speeds / self.speeds[0]) ** 2)


def coast_down(times: Array, speeds: Array, inertia: float, drag: float) -> CoastDown | None:
    """Return the remaining run-down to standstill, or None if friction does not slow the rotor.

        Omega' = -a - b Omega,   b = drag/inertia                                                     (1)

    With w = Omega exp(b t) and u = (exp(b t) - 1)/b, (1) becomes the line w = w_0 - a u, which is fitted to the second
    half of the run. The run-down ends at u = w_0/a. In a time t after the run, during which the speed falls from
    Omega_1 to Omega, friction dissipates J a (Omega_1 - Omega - a t)/b.

    Parameters
    ----------
    times, speeds
        Ascending times (s) and the spin speeds at these times (rad/s), each of shape (n,) with n > 3.
    inertia, drag
        Polar moment of inertia J (kg m^2), and coefficient of the viscous drag on the spin (N m s), at least 0.
    """
    half = len(times) // 2
    t, Omega, b = times[half:] - times[half], np.abs(speeds[half:]), drag / inertia
    u = np.expm1(b * t) / b if b else t
    slope, first = np.polyfit(u, Omega * np.exp(b * t), 1)
    if -slope * u[-1] <= ROUNDING * first:
        return None
    a = -float(slope)
    end = float(Omega[-1])
    remaining = np.linspace(0.0, (math.log1p(b * end / a) / b) if b else end / a, EXTRAPOLATED + 1)
    if b:
        slowed = end * np.exp(-b * remaining) + a * np.expm1(-b * remaining) / b
        angles = (end - slowed - a * remaining) / b
    else:
        slowed, angles = end - a * remaining, (end - 0.5 * a * remaining) * remaining
    return CoastDown(float(times[-1]) + remaining, slowed, inertia * a * angles)


def temperatures(
    times: Array, heats: Array, first: float, *, capacity: float, transfer: float, ambient: float
) -> Array:
    """Return the temperature (K) of a retainer at each time.

        C T' = Q' - h (T - T_ambient)                                                                  (1)

    The heat flow Q' is constant between two times.

    Parameters
    ----------
    times, heats
        Ascending times (s), and the heat Q so far at these times (J), each of shape (n,).
    first
        Temperature at the first time (K).
    capacity, transfer
        Heat capacity C (J/K) and heat transfer h (W/K).
    ambient
        Ambient temperature (K).
    """
    result = np.full(len(times), first)
    for n, (step, heat) in enumerate(zip(np.diff(times), np.diff(heats), strict=True)):
        exponent = transfer * step / capacity
        mean_share = -math.expm1(-exponent) / exponent if exponent else 1.0
        result[n + 1] = ambient + (result[n] - ambient) * math.exp(-exponent) + heat / capacity * mean_share
    return result
