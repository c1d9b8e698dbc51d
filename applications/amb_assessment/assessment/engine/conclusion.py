"""Conclusion of an assessment: the number of failed criteria, and a sentence on each with its value and limit."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence

from amb_assessment.assessment.engine.findings import Finding, Judgement

WORST_FIRST = (Judgement.FAILED, Judgement.UNANSWERED, Judgement.MET)


def by_criterion(findings: Sequence[Finding]) -> dict[str, Judgement]:
    """Return the worst verdict on each judged criterion; failed is worse than unanswered, which is worse than met."""
    verdicts: dict[str, list[Judgement]] = {}
    for finding in findings:
        if finding.criterion is not None and finding.verdict is not Judgement.NOT_JUDGED:
            verdicts.setdefault(finding.criterion.key, []).append(finding.verdict)
    return {key: min(cases, key=WORST_FIRST.index) for key, cases in verdicts.items()}


def conclusion_of(
    findings: Sequence[Finding],
    failed_parts: Mapping[str, str],
    parts: Sequence[str] = (),
    unmeasured: Iterable[str] = (),
) -> str:
    """Return whether the machine may run, as a sentence without a full stop.

    Parameters
    ----------
    findings
        All verdicts.
    failed_parts
        Parts that were not computed, with reasons.
    parts
        The assessed parts, if only some parts were assessed.
    unmeasured
        Keys of criteria that are unanswered because their quantity was not measured.
    """
    verdicts = by_criterion(findings) | dict.fromkeys(unmeasured, Judgement.UNANSWERED)
    counts = Counter(verdicts.values())
    failed, unanswered, total = counts[Judgement.FAILED], counts[Judgement.UNANSWERED], len(verdicts)
    within = f" in {', '.join(parts)}" if parts else ""
    if failed:
        result = f"Not yet: {failed} of {_criteria(total)}{within} failed"
    elif unanswered or failed_parts:
        result = f"Undecided: {counts[Judgement.MET]} of {_criteria(total)}{within} met, none failed"
    elif total:
        result = f"Yes: {'the criterion' if total == 1 else f'all {total} criteria'}{within} met"
    else:
        result = f"No verdict: no criterion applies{within}"
    result += f", {unanswered} unanswered" if unanswered else ""
    n = len(failed_parts)
    return result + (f"; {n} part{'s were' if n > 1 else ' was'} not computed: {', '.join(failed_parts)}" if n else "")


def failures(findings: Sequence[Finding]) -> list[tuple[Finding, str]]:
    """Return the worst case of each failed criterion and a sentence that describes it, in the order of the findings."""
    cases: dict[str, list[Finding]] = {}
    for finding in findings:
        if finding.criterion is not None and finding.verdict is Judgement.FAILED:
            cases.setdefault(finding.criterion.key, []).append(finding)
    return [
        (worst := max(of_one, key=lambda case: case.excess), _with_count(worst, len(of_one)))
        for of_one in cases.values()
    ]


def _with_count(worst: Finding, count: int) -> str:
    return worst.sentence + (f"; worst of {count} cases" if count > 1 else "")


def _criteria(count: int) -> str:
    return "1 criterion" if count == 1 else f"{count} criteria"
