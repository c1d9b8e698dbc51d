"""The linear part of a model's state, for hosts that solve for steady motion."""

from __future__ import annotations

from typing import NamedTuple


class LinearState(NamedTuple):
    """Positions in the state of a model.

    rows
        Begin and end (exclusive) of each row of numbers that follow x(n+1) = A x(n) + B u(n) + f(theta), with constant
        A and B and a first harmonic f of the angle, as long as no limit is active.
    angle
        Position of the angle theta (rad), which grows by the same amount in every step; None if there is none.
    energy
        Positions of the reference energy of the output `energy.balance`, and of the largest energy so far (J); None if
        the model has no such output.
    unless
        Variables (`*` and `?` are wildcards) that differ from 0 if the motion is not linear.
    """

    rows: tuple[tuple[int, int], ...]
    angle: int | None = None
    energy: tuple[int, int] | None = None
    unless: tuple[str, ...] = ()
