"""What of a model's state moves linearly while nothing limits it, so that a host can solve for steady motion."""

from __future__ import annotations

from typing import NamedTuple


class LinearState(NamedTuple):
    """Places in the state of a model.

    rows
        First place, and the one after the last, of each row of numbers that follow x(n+1) = A x(n) + B u(n) + f(theta),
        with constant A and B and a first harmonic f of the angle, as long as nothing limits them.
    angle
        Place of the angle theta (rad), which grows by the same with every step; None where there is none.
    energy
        Places of the energy that the output `energy.balance` is counted from, and of the largest energy so far (J);
        None where the model has no such output.
    unless
        Variables (`*` and `?` match any characters and one) that are not 0 where it does not move so.
    """

    rows: tuple[tuple[int, int], ...]
    angle: int | None = None
    energy: tuple[int, int] | None = None
    unless: tuple[str, ...] = ()
