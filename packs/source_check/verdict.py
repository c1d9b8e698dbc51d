"""Verdicts on whether a computed value agrees with a source."""

from __future__ import annotations

import math
from enum import StrEnum

from source_check.statements import Statement

Computed = bool | float | str | list[float]


class Verdict(StrEnum):
    """Verdict on a statement."""

    REPRODUCED = "reproduced"
    WITH_READING = "reproduced with a stated factor or reading"
    WITHIN_LIMIT = "within a stated limit"
    DEFINITION = "follows from the definition"
    MISSED = "not reproduced"
    GIVEN = "input of the model"
    NOT_COMPUTED = "not computed"
    PICTURE = "no number to compare"


def meets(statement: Statement, ours: Computed | None) -> bool:
    """Return whether a computed value agrees with a statement, within the tolerance of the statement.

    |ours - stated| <= max(tolerance |stated|, absolute)

    A limit may be exceeded by the same amount. A value below the floor of a limit does not meet the limit. In a list,
    every number must agree. Texts and truth values must be equal.

    Parameters
    ----------
    statement
        The statement, in its unit.
    ours
        The computed value, in the unit of the statement; None never agrees.
    """
    stated = statement.value
    if ours is None or stated is None:
        return False
    if isinstance(stated, tuple):
        return (
            isinstance(ours, list)
            and len(ours) == len(stated)
            and all(_is_near(a, float(b), statement) for a, b in zip(ours, stated, strict=True))
        )
    if isinstance(stated, bool | str) or isinstance(ours, bool | str | list):
        return type(ours) is type(stated) and ours == stated
    return _is_near(ours, float(stated), statement)


def judge(statement: Statement, values: list[tuple[Computed | None, str]]) -> tuple[Verdict, int]:
    """Return the verdict on a statement, and the index of the value on which it is based.

    Parameters
    ----------
    statement
        The statement.
    values
        Computed values, in the order in which they are tried, each with its factor or reading (empty if there is none).
    """
    if statement.picture:
        return Verdict.PICTURE, 0
    computed = [k for k, (ours, _) in enumerate(values) if ours is not None]
    if statement.missing or not computed:
        return Verdict.NOT_COMPUTED, 0
    for k in computed:
        ours, reading = values[k]
        if meets(statement, ours):
            return _when_met(statement, reading), k
    return Verdict.MISSED, computed[0]


def _when_met(statement: Statement, reading: str) -> Verdict:
    """Return the verdict on a statement that is met; if several verdicts apply, return the weakest."""
    if statement.given:
        return Verdict.GIVEN
    if statement.definition:
        return Verdict.DEFINITION
    if statement.relation != "equal":
        return Verdict.WITHIN_LIMIT
    return Verdict.WITH_READING if reading else Verdict.REPRODUCED


def ratios(statement: Statement, ours: Computed | None) -> tuple[float, ...]:
    """Return the ratio of computed to stated value for each number other than 0; empty for texts and limits."""
    stated = statement.value
    if statement.relation != "equal" or isinstance(stated, bool | str) or isinstance(ours, bool | str | None):
        return ()
    pairs = zip(
        ours if isinstance(ours, list) else [ours],
        stated if isinstance(stated, tuple) else [stated],
        strict=False,
    )
    return tuple(a / float(b) for a, b in pairs if b)


def _is_near(ours: float, stated: float, statement: Statement) -> bool:
    margin = max(statement.tolerance * abs(stated), statement.absolute)
    rounding = 1e-12 * abs(stated)
    if not math.isfinite(ours):
        return False
    if statement.relation == "below":
        return (statement.floor is None or ours >= statement.floor) and ours <= stated + margin + rounding
    if statement.relation == "above":
        return ours >= stated - margin - rounding
    return abs(ours - stated) <= margin + rounding
