"""Vibrations of the sampled loop at several spin speeds, and their pairing from one speed to the next."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from amb_analysis.linear.loop import CLOSE, Loop
from amb_analysis.linear.stability import OVERDAMPED
from amb_cosim.presentation.digits import significant
from amb_cosim.presentation.units import frequency_unit
from amb_cosim.results.loop_stability import LoopStability
from array_types import Array, Complex
from rotor_analysis.modes import Whirl
from rotor_analysis.refinement import refined

TURN = 0.3  # cost of the opposite sense of whirl in the pairing of poles, as a distance over |s|
APART = 1e6  # of such costs, between a vibration along the shaft and one across it
Direction = Whirl | Literal["axial"]
CLEAR = 0.05  # sense of whirl, from -1 to 1, up to which it is mixed


@dataclass(frozen=True)
class Vibrations:
    """Poles s (rad/s) with Im s > 0, and their senses of whirl from -1 (backward) to 1 (forward), each of shape (n,).

    The sense of a vibration along the shaft is NaN. `stability` takes all poles into account, including those without
    vibration.
    """

    poles: Complex
    senses: Array
    stability: LoopStability

    def ratios(self) -> Array:
        """Return the damping ratios."""
        return np.asarray(-self.poles.real / np.abs(self.poles))

    def decrements(self) -> Array:
        """Return the logarithmic decrements, -2 pi Re s/Im s."""
        return np.asarray(-2.0 * np.pi * self.poles.real / self.poles.imag)

    def up_to(self, frequency: float) -> Vibrations:
        """Return the vibrations up to a frequency (rad/s)."""
        in_range = self.poles.imag <= frequency
        return Vibrations(self.poles[in_range], self.senses[in_range], self.stability)

    @property
    def least_ratio(self) -> float:
        """Smallest damping ratio; 1 if there are no vibrations."""
        return float(self.ratios().min(initial=1.0))


@dataclass(frozen=True)
class LeastDamped:
    """The vibration with the smallest damping ratio over all speeds: its speed, damped frequency (rad/s), and whirl."""

    damping_ratio: float
    speed: Annotated[float, "rad/s"]
    frequency: Annotated[float, "rad/s"]
    whirl: Direction

    def __str__(self) -> str:
        frequency = frequency_unit().text(self.frequency, 5)
        return f"damping ratio {significant(self.damping_ratio)} of the {self.whirl} vibration at {frequency}"


def vibrations(loop: Loop, Omega: float) -> Vibrations:
    """Return the vibrations of a loop at a spin speed (rad/s), the slowest first.

    The sense of whirl is 2 Im(x conj(y)) / (|x|^2 + |y|^2), where numerator and denominator are summed over the
    journals of the bearings. It is NaN for a vibration along the shaft.
    """
    loop_poles = loop.poles(Omega)
    s = loop_poles.s
    alternates = (loop_poles.z.real < 0.0) & (
        np.abs(loop_poles.z.imag) <= 1e-9 * np.abs(loop_poles.z)
    )  # at half the sample rate
    vibrates = ~alternates & (s.imag > 0.0) & (-s.real < OVERDAMPED * np.abs(s))
    chosen = np.flatnonzero(vibrates)[np.argsort(s[vibrates].imag, kind="stable")]
    x, y = loop_poles.shapes[0::2, chosen], loop_poles.shapes[1::2, chosen]
    size = (np.abs(x) ** 2 + np.abs(y) ** 2).sum(axis=0)
    turning = 2.0 * (x * y.conj()).imag.sum(axis=0)
    senses = np.divide(turning, size, out=np.zeros(len(chosen)), where=size > 0.0)
    senses[loop_poles.is_axial[chosen]] = np.nan
    return Vibrations(s[chosen], senses, loop_poles.stability)


def vibrations_over(
    loop: Loop,
    speeds: Array,
    least: Callable[[Vibrations], Sequence[float]] = lambda v: (v.least_ratio,),
) -> tuple[Array, list[Vibrations]]:
    """Return speeds (rad/s), denser near the largest growth and the smallest damping ratios, and their vibrations.

    Parameters
    ----------
    loop
        The loop.
    speeds
        Speeds (rad/s) that the result must contain, ascending, shape (n,).
    least
        Function that returns the damping ratios whose minima over speed are refined; by default, the smallest damping
        ratio of all vibrations.
    """

    def at_speeds(more: Array) -> NDArray[np.object_]:
        values = np.empty(len(more), dtype=object)
        values[:] = [vibrations(loop, float(Omega)) for Omega in more]
        return values

    def heights(values: NDArray[np.object_]) -> Array:
        return np.array([[at.stability.growth_rate, *(-ratio for ratio in least(at))] for at in values])

    closer, values = refined(at_speeds, speeds, heights, CLOSE, resonant=False)
    return closer, list(values)


def least_damped(speeds: Array, vibrations: list[Vibrations]) -> LeastDamped | None:
    """Return the least damped of the vibrations at all speeds (rad/s), shape (n,); None if there are no vibrations."""
    candidates = [
        (float(ratio), float(Omega), float(s.imag), whirl_of(float(sense)))
        for Omega, of_speed in zip(speeds, vibrations, strict=True)
        for ratio, s, sense in zip(of_speed.ratios(), of_speed.poles, of_speed.senses, strict=True)
    ]
    return LeastDamped(*min(candidates)) if candidates else None


def whirl_of(sense: float) -> Direction:
    """Return the whirl direction for a sense of whirl from -1 (backward) to 1 (forward), or `axial` for NaN."""
    if math.isnan(sense):
        return "axial"
    return "mixed" if abs(sense) <= CLEAR else "forward" if sense > 0.0 else "backward"


def followed(vibrations: list[Vibrations], count: int) -> list[list[int | None]]:
    """Return the index of each of the first `count` vibrations at every speed; None once the vibration has ended.

    Each vibration is paired with the pole that is nearest to a linear extrapolation of its last two poles. The distance
    is |s - s_expected| / |s|, plus `TURN` times half the difference between the senses of whirl. The extrapolation
    covers the step in speed, but never more than the length of the previous step.
    """
    tracks: list[list[int | None]] = [[k] for k in range(min(count, len(vibrations[0].poles)))]
    for n in range(1, len(vibrations)):
        continued = [track for track in tracks if track[-1] is not None]
        now = vibrations[n]
        cost = np.array([_distances(vibrations, track, now, n) for track in continued]).reshape(
            len(continued), len(now.poles)
        )
        pairs = dict(zip(*map(list, linear_sum_assignment(cost)), strict=True))
        for k, track in enumerate(continued):
            best = pairs.get(k)
            track.append(best if best is not None and cost[k, best] < TURN else None)
        for track in tracks:
            if len(track) == n:
                track.append(None)
    return tracks


def begun_later(vibrations: list[Vibrations], tracks: list[list[int | None]]) -> list[list[int | None]]:
    """Return tracks of vibrations that begin above the first speed and continue to the last; earlier entries are None.

    For example, a well-damped rigid rotor obeys I_d a'' + (c - i Omega I_p) a' + k a = 0. Without spin, it creeps back
    without vibration. At speed, it whirls backward at nearly k / (Omega I_p), with the damping ratio c / |c - i Omega
    I_p|.

    Parameters
    ----------
    vibrations
        Vibrations at each speed, shape (n,).
    tracks
        Tracks of the vibrations that exist at the first speed (`followed`); their poles are not used again.
    """
    result = []
    for backward in followed(vibrations[::-1], len(vibrations[-1].poles)):
        track = backward[::-1]
        taken = [n for n, k in enumerate(track) if k is not None and any(other[n] == k for other in tracks)]
        begin = max(taken, default=-1) + 1
        track[:begin] = [None] * begin
        if track[0] is None and track[-1] is not None:
            result.append(track)
    return result


def _step_ratio(vibrations: list[Vibrations], n: int) -> float:
    """Return the n-th step in speed, divided by the step before it; at most 1."""
    before, last, now = (at.stability.speed for at in vibrations[n - 2 : n + 1])
    return min((now - last) / (last - before), 1.0) if last != before else 1.0


def _distances(vibrations: list[Vibrations], track: list[int | None], now: Vibrations, n: int) -> Array:
    last, before = track[-1], track[-2] if n > 1 else None
    assert last is not None
    expected = vibrations[n - 1].poles[last]
    if before is not None:
        expected += _step_ratio(vibrations, n) * (expected - vibrations[n - 2].poles[before])
    sense = vibrations[n - 1].senses[last]
    turn = np.nan_to_num(np.abs(now.senses - sense) / 2.0)
    turn[np.isnan(now.senses) != np.isnan(sense)] = APART
    return np.asarray(np.abs(now.poles - expected) / np.abs(expected) + TURN * turn)
