"""Summary of a report in one paragraph: the statements that are reproduced, and the reasons for the others."""

from __future__ import annotations

from collections.abc import Mapping

from source_check.evaluation import Report
from source_check.statements import Cause
from source_check.verdict import Verdict

REASONS: Mapping[Cause, str] = {
    "data": "For {count}, the {label} gives too little data or contradicts itself.",
    "detail": "{count} depend on details of the machine that the {label} leaves open.",
    "reading": "{count} are met only by another reading of the {label}.",
    "unexplained": "For {count} no reason is known: {names}.",
}


def overview(report: Report) -> str:
    """Return sentences with the number of statements for each verdict, and the missed statements for each cause.

    If only some statements of the source were judged, their number and the number of all statements are given.
    """
    counts, label = report.counts(), report.statements.label
    plain, with_reading = counts[Verdict.REPRODUCED], counts[Verdict.WITH_READING]
    within, missed = counts[Verdict.WITHIN_LIMIT], counts[Verdict.MISSED]
    given, definition = counts[Verdict.GIVEN], counts[Verdict.DEFINITION]
    others = counts[Verdict.PICTURE] + counts[Verdict.NOT_COMPUTED]
    judged, all_of_source = counts.total(), len(report.statements.statement)
    scope = (
        f"The {label} has {judged} statements"
        if judged == all_of_source
        else f"{judged} of the {all_of_source} statements of the {label} are selected"
    )
    reasons = [
        REASONS[cause].format(
            label=label, count=len(items), names=", ".join(f"`{item.statement.key}`" for item in items)
        )
        for cause, items in report.missed_by_cause().items()
        if items
    ]
    return " ".join(
        [
            f"{scope}; {plain + with_reading + within} of them are reproduced: "
            f"{plain} as they stand, {with_reading} with a stated factor or reading, and {within} because a value "
            "is within a limit.",
            f"{missed} are not reproduced.",
            *reasons,
            f"The others prove nothing: {given} are inputs of the model, {definition} follow from definitions, and "
            f"{others} have no number to compare or are not computed.",
        ]
    )
