"""Misfit of a value against a statement of the thesis: a number that can be averaged over statements."""

from __future__ import annotations

import math

from source_check.statements import Statement
from source_check.verdict import Computed

MOST = math.log(10.0)  # what a number can add
DIFFERS = 1.0  # what a text or a truth value adds that differs: as much as a factor of e


def misfit(statement: Statement, ours: Computed | None) -> float:
    """Return the misfit of a value against a statement; 0 is agreement.

    |ln((|ours| + a) / (|thesis| + a))|, at most ln 10, with a the absolute tolerance

    A limit that is met counts 0. A number of opposite sign, or a missing one, counts ln 10; a list counts its mean; a
    different text or truth value counts 1.

    Parameters
    ----------
    statement
        The statement, in its unit.
    ours
        The computed value, in the same unit.
    """
    thesis = statement.value
    if isinstance(thesis, bool | str):
        return float(ours != thesis) * DIFFERS
    if isinstance(thesis, tuple):
        result = ours if isinstance(ours, list) and len(ours) == len(thesis) else [None] * len(thesis)
        return sum(_of_number(statement, a, float(b)) for a, b in zip(result, thesis, strict=True)) / len(thesis)
    assert thesis is not None  # a statement with a quantity has a value
    return _of_number(statement, None if isinstance(ours, bool | str | list) else ours, float(thesis))


def _of_number(statement: Statement, ours: float | None, thesis: float) -> float:
    if ours is None:
        return MOST
    if (statement.relation == "below" and ours <= thesis) or (statement.relation == "above" and ours >= thesis):
        return 0.0
    sizes = abs(ours) + statement.absolute, abs(thesis) + statement.absolute
    if ours == thesis:
        return 0.0
    if ours * thesis < 0.0 or 0.0 in sizes:
        return MOST
    return min(abs(math.log(sizes[0] / sizes[1])), MOST)
