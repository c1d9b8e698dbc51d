"""Values, ratios and verdicts as short texts, for the page and the table."""

from __future__ import annotations

from amb_assessment.reporting.page_parts import number_text
from source_check.evaluation import Judged
from source_check.statements import Expected, Statement
from source_check.verdict import Computed, Verdict

RELATIONS = {"equal": "", "below": "at most ", "above": "at least "}
MOST_NUMBERS = 4  # of a list, that are shown


def value_text(value: Expected | Computed | None, unit: str = "") -> str:
    """Return a value with its unit; for a long list, the first and last numbers."""
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
    """Return the stated value."""
    return RELATIONS[statement.relation] + value_text(statement.value, statement.unit)


def ratio_text(one: Judged) -> str:
    """Return the computed over the stated value: one number, or the smallest and the largest."""
    if not one.ratios:
        return "–"
    low, high = f"{min(one.ratios):.3g}", f"{max(one.ratios):.3g}"
    return low if low == high else f"{low} to {high}"


def converged_text(one: Judged) -> str:
    """Return the value of the model with more modes, and whether it meets the statement."""
    if one.is_met_there is None:
        return "–"
    return f"{value_text(one.converged, one.statement.unit)}, {'met' if one.is_met_there else 'not met'}"


def remark_text(one: Judged, known: str = "") -> str:
    """Return the reading of a verdict, the reason of a miss, or a remark; and the results of other ways.

    A reading that is `known` to the reader is omitted.
    """
    reading = (
        one.reading if one.verdict in (Verdict.WITH_READING, Verdict.WITHIN_LIMIT) and one.reading != known else ""
    )
    parts = [reading, one.reason or one.statement.picture, one.robustness]
    if one.beside:
        parts.append("; ".join(f"{how}: {value_text(value, one.statement.unit)}" for how, value in one.beside))
    return ". ".join(_capitalised(part) for part in parts if part)


def tolerance_text(statement: Statement) -> str:
    """Return the tolerance of a value, and its reason."""
    margins = [f"{100.0 * statement.tolerance:g} %"] if statement.tolerance else []
    margins += [_with_unit(f"{statement.absolute:g}", statement.unit)] if statement.absolute else []
    within = f"within {' or '.join(margins)}" if margins else ""
    return _capitalised("; ".join(filter(None, (within, statement.because))))


def _with_unit(text: str, unit: str) -> str:
    return f"{text} {unit}".strip()


def _capitalised(text: str) -> str:
    return text[:1].upper() + text[1:]
