"""Mode tracking: modes at different speeds, on different meshes or of different models are paired by their shapes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache, partial
from itertools import pairwise

import numpy as np
from scipy.optimize import linear_sum_assignment

from amb_files.checks import require
from array_types import Array, Complex
from rotor_analysis.assembly import Matrices
from rotor_analysis.modes import SAME_EIGENVALUE, Mode, modes

HALVING_ASSURANCE = 0.9  # below it a step in speed is halved
LOWEST_ASSURANCE = 0.5  # below it a mode has no continuation
MAX_HALVINGS = 10
RESONANT = math.sqrt(0.5)  # damping ratio up to which a response has a peak
KEPT = 2**26  # bytes of shapes, of the latest speeds


class ModesOverSpeed:
    """The modes of a model at any speed, cached so that tracks to higher and lower speeds share the solutions.

    Parameters
    ----------
    model
        A model with its bearings.

    Attributes
    ----------
    M
        Its mass matrix.
    at
        Function that returns all modes at a spin speed (rad/s).
    """

    def __init__(self, model: Matrices) -> None:
        self.M = model.M
        self.at = lru_cache(max(1, KEPT // (16 * model.size**2)))(partial(modes, model))


def modal_assurance(M: Array, first: Sequence[Complex], second: Sequence[Complex]) -> Array:
    """Return the modal assurance criterion (MAC), weighted with M, for each pair of a first and a second shape.

    MAC_ij = |a_i^H M b_j|^2 / ((a_i^H M a_i) (b_j^H M b_j))

    It is 1 for the same motion, whatever its size and phase, and 0 for a forward and a backward circle.

    Parameters
    ----------
    M
        Mass matrix, shape (n, n).
    first, second
        Shapes of n complex numbers each.

    Returns
    -------
    array, shape (len(first), len(second))
    """
    a, b = (np.array(shapes).reshape(-1, len(M)).T for shapes in (first, second))
    size_a, size_b = (np.einsum("ij,ij->j", c.conj(), M @ c).real for c in (a, b))
    return np.asarray(np.abs(a.conj().T @ M @ b) ** 2 / np.outer(size_a, size_b))


def pair_modes(M: Array, tracked: Sequence[Complex], shapes: Sequence[Complex]) -> list[tuple[int | None, float]]:
    """Return, for each tracked shape, the index in `shapes` of the shape that continues it, and the MAC of the pair.

    Each shape is used once. The index is None if no shape is left or the MAC is below 0.5.
    """
    criterion = modal_assurance(M, tracked, shapes)
    pairs: list[tuple[int | None, float]] = [(None, 0.0)] * len(tracked)
    for row, column in zip(*linear_sum_assignment(criterion, maximize=True), strict=True):
        value = float(criterion[row, column])
        pairs[row] = (int(column) if value >= LOWEST_ASSURANCE else None, value)
    return pairs


def track_modes(over_speed: ModesOverSpeed, speeds: Array, count: int) -> list[list[Mode | None]]:
    """Track the first `count` modes from the lowest speed to the highest.

    A step over which the MAC of a mode falls below 0.9 is halved, so that modes keep their identity where their
    frequencies cross.

    Parameters
    ----------
    over_speed
        The modes of a model with its bearings.
    speeds
        Spin speeds (rad/s), ascending, shape (n,).
    count
        Number of modes.

    Returns
    -------
    list
        For each mode, its state at each speed; None after it has stopped oscillating.

    Raises
    ------
    ValueError
        If the speeds are not finite and ascending, or `count` is below 1.
    """
    speeds = np.atleast_1d(np.asarray(speeds, dtype=np.float64))
    ascending = len(speeds) > 0 and bool(np.all(np.isfinite(speeds)) and np.all(np.diff(speeds) > 0.0))
    require(ascending, "speeds", f"{speeds.tolist()} rad/s", "finite and ascending, one or more")
    require(count >= 1, "count", count, "1 or more")
    current: list[Mode | None] = list(over_speed.at(float(speeds[0]))[:count])
    tracks = [[mode] for mode in current]
    for before, after in pairwise(speeds.tolist()):
        current = continue_modes(over_speed, current, before, after)
        for track, mode in zip(tracks, current, strict=True):
            track.append(mode)
    return tracks


def modes_begun_later(
    over_speed: ModesOverSpeed, speeds: Array, tracks: Sequence[Sequence[Mode | None]]
) -> list[list[Mode | None]]:
    """Return the tracks of modes that begin to oscillate above the first speed, with None at lower speeds.

    A mode counts if it begins without a resonance, that is, with a damping ratio above 1/sqrt(2), but has a resonance
    at the last speed. There it must be slower than the fastest of `tracks`. For example, a gyroscopic rotor in
    well-damped bearings creeps at rest but whirls backward at speed.

    Parameters
    ----------
    over_speed
        The modes of a model with its bearings.
    speeds
        Spin speeds (rad/s), ascending, shape (n,).
    tracks
        Tracks returned by `track_modes`; their modes are not returned again.
    """
    ends = [track[-1].eigenvalue for track in tracks if track[-1] is not None]
    fastest = max((value.imag for value in ends), default=0.0)
    current: list[Mode | None] = [
        mode
        for mode in over_speed.at(float(speeds[-1]))
        if mode.frequency < fastest and abs(mode.damping_ratio) <= RESONANT and not _is_of(mode, ends)
    ]
    later: list[list[Mode | None]] = [[mode] for mode in current]
    down = speeds[::-1].tolist()
    for n, (before, after) in enumerate(pairwise(down), start=2):
        if any(mode is not None for mode in current):
            current = continue_modes(over_speed, current, before, after)
        taken = [mode.eigenvalue for track in tracks if (mode := track[-n]) is not None]
        current = [None if mode is None or _is_of(mode, taken) else mode for mode in current]
        for track, mode in zip(later, current, strict=True):
            track.append(mode)
    return [track[::-1] for track in later if track[-1] is None and _first_ratio(track[::-1]) > RESONANT]


def _first_ratio(track: Sequence[Mode | None]) -> float:
    """Return the damping ratio with which a track begins."""
    return next(mode.damping_ratio for mode in track if mode is not None)


def _is_of(mode: Mode, eigenvalues: Sequence[complex]) -> bool:
    return any(abs(mode.eigenvalue - value) <= SAME_EIGENVALUE * abs(value) for value in eigenvalues)


def continue_modes(
    over_speed: ModesOverSpeed, current: list[Mode | None], before: float, after: float, halvings: int = MAX_HALVINGS
) -> list[Mode | None]:
    """Continue the modes `current` at speed `before` (rad/s) to the speed `after`; an entry None stays None."""
    oscillating = [k for k, mode in enumerate(current) if mode is not None]
    result = over_speed.at(after)
    pairs = pair_modes(over_speed.M, [m.shape for m in current if m is not None], [m.shape for m in result])
    if halvings and any(value < HALVING_ASSURANCE for _, value in pairs):
        middle = 0.5 * (before + after)
        return continue_modes(
            over_speed, continue_modes(over_speed, current, before, middle, halvings - 1), middle, after, halvings - 1
        )
    continued: list[Mode | None] = [None] * len(current)
    for k, (index, _) in zip(oscillating, pairs, strict=True):
        continued[k] = None if index is None else result[index]
    return continued
