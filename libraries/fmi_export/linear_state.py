"""The linear part of a model's state, for hosts that solve for steady motion."""

from __future__ import annotations

from typing import NamedTuple


class LinearState(NamedTuple):
    """Positions in the state of a model.

    rows
        Start and end (exclusive) of each range of numbers that obey x(n+1) = A x(n) + B u(n) + f(theta) as long as no
        limit is active. A and B are constant, and f is a first harmonic of the angle.
    angle
        Position of the angle theta (rad), which grows by the same amount in every step; None if the state has no angle.
    energy
        Positions of two energies (J): the reference of the output `energy.balance`, and the largest energy so far. None
        if the model does not have this output.
    unless
        Variables (`*` and `?` are wildcards); if any of them differs from 0, the motion is not linear.
    """

    rows: tuple[tuple[int, int], ...]
    angle: int | None = None
    energy: tuple[int, int] | None = None
    unless: tuple[str, ...] = ()
