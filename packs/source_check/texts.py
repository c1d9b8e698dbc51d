"""Values, ratios and verdicts as short texts, for the page and the table."""

from __future__ import annotations

from amb_assessment.reporting.page_parts import number_text
from source_check.evaluation import Judged
from source_check.statements import Expected, Statement
from source_check.verdict import Computed, Verdict

RELATIONS = {"equal": "", "below": "at most ", "above": "at least "}
MOST_NUMBERS = 4  # displayed numbers of a list


def value_text(value: Expected | Computed | None, unit: str = "") -> str:
    """Return a value with its unit as text; of a long list, only the first and last numbers are included."""
    if value is None:
        return "–"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, str):
        return value
    if isinstance(value, tuple | list):
        numbers = [number_text(number) for number in value]
        if len(numbers) > MOST_NUMBERS:
            numbers = [*numbers[:2], "…", *numbers[-2:]]
        return _with_unit(", ".join(numbers), unit)
    return _with_unit(number_text(value), unit)


def stated_text(statement: Statement) -> str:
    """Return the stated value as text."""
    return RELATIONS[statement.relation] + value_text(statement.value, statement.unit)


def ratio_text(item: Judged) -> str:
    """Return the ratio of the computed to the stated value; for a list, the smallest and the largest ratio."""
    if not item.ratios:
        return "–"
    low, high = f"{min(item.ratios):.3g}", f"{max(item.ratios):.3g}"
    return low if low == high else f"{low} to {high}"


def converged_text(item: Judged) -> str:
    """Return the value of the model with more modes as text, and whether it meets the statement."""
    if item.converged_is_met is None:
        return "–"
    return f"{value_text(item.converged, item.statement.unit)}, {'met' if item.converged_is_met else 'not met'}"


def remark_text(item: Judged, omitted: str = "") -> str:
    """Return remarks on a statement, such as its reading, the reason for a miss, and the results of other computations.

    `omitted` is a reading that is left out because the page states it elsewhere.
    """
    reading = (
        item.reading if item.verdict in (Verdict.WITH_READING, Verdict.WITHIN_LIMIT) and item.reading != omitted else ""
    )
    parts = [reading, item.reason or item.statement.picture, item.robustness]
    if item.beside:
        parts.append("; ".join(f"{how}: {value_text(value, item.statement.unit)}" for how, value in item.beside))
    return ". ".join(_capitalised(part) for part in parts if part)


def tolerance_text(statement: Statement) -> str:
    """Return the tolerance of a statement, and the reason for the tolerance."""
    margins = [f"{100.0 * statement.tolerance:g} %"] if statement.tolerance else []
    margins += [_with_unit(f"{statement.absolute:g}", statement.unit)] if statement.absolute else []
    within = f"within {' or '.join(margins)}" if margins else ""
    return _capitalised("; ".join(filter(None, (within, statement.because))))


def _with_unit(text: str, unit: str) -> str:
    return f"{text} {unit}".strip()


def _capitalised(text: str) -> str:
    return text[:1].upper() + text[1:]
