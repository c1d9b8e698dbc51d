"""Verdicts on the computed quantities of a machine."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum

from amb_assessment.assessment.format.criteria import Criterion
from amb_assessment.assessment.format.quantities import Quantity
from amb_assessment.reporting.page_parts import number_text
from amb_cosim.presentation.digits import with_micro_signs
from amb_cosim.presentation.units import temperature_text

KELVIN = "K"  # unit of temperatures, which are shown in °C


class Judgement(StrEnum):
    """Verdict on a quantity or an analysis."""

    MET = "met"
    FAILED = "failed"
    NOT_JUDGED = "no criterion"
    UNANSWERED = "unanswered"


@dataclass(frozen=True)
class Finding:
    """A verdict on a quantity.

    measured, criterion
        The computed quantity, and its criterion, if any.
    verdict, limit, zone
        The verdict, its limit, and the zone if the criterion has zones.
    reason
        Reason for a missing verdict.
    facts
        Variables of the machine and of the quantity.
    """

    measured: Quantity
    criterion: Criterion | None
    verdict: Judgement
    limit: float | None = None
    zone: str = ""
    reason: str = ""
    facts: Mapping[str, float] = field(default_factory=dict)

    @property
    def advice(self) -> str:
        """Advice for a failed criterion."""
        return self.criterion.advice if self.criterion is not None and self.verdict is Judgement.FAILED else ""

    @property
    def excess(self) -> float:
        """Amount by which the value misses the limit, in their common unit; negative if the limit is met."""
        if self.criterion is None or self.limit is None:
            return -math.inf
        return (self.measured.value - self.limit) * (1.0 if self.criterion.relation == "below" else -1.0)

    @property
    def sentence(self) -> str:
        """A sentence that states which criterion failed, with the value and the limit."""
        if self.criterion is None or not self.criterion.failure:
            what = self.measured.title if self.criterion is None else self.criterion.what
            return f"{what}: {self.value_text} ({self.limit_text}), {self.measured.where}"
        limit = "" if self.limit is None else _with_unit(self.limit, self.criterion.unit)
        words = {"value": self._number_with_unit, "limit": limit, "where": self.measured.where, "zone": self.zone}
        return self.criterion.failure.format_map({name: _grouped(x) for name, x in self.facts.items()} | words)

    @property
    def limit_text(self) -> str:
        """The limit with its relation and unit, or the last accepted zone with its limit."""
        if self.criterion is None or self.limit is None:
            return "–"
        number = _with_unit(self.limit, self.criterion.unit)
        if self.criterion.zones:
            return f"zone {self.criterion.accepted}: below {number}"
        return f"{'at most' if self.criterion.relation == 'below' else 'at least'} {number}"

    @property
    def value_text(self) -> str:
        """The value with its unit and, if the criterion has zones, its zone."""
        return f"{self._number_with_unit}, zone {self.zone}" if self.zone else self._number_with_unit

    @property
    def _number_with_unit(self) -> str:
        """The value with its unit; if the criterion failed, the value has enough digits to differ from the limit."""
        value, unit, limit = self.measured.value, self.measured.unit, self.limit
        if self.measured.shown:
            return self.measured.shown
        number = number_text(value)
        if unit == KELVIN:
            return temperature_text(value)
        if self.verdict is Judgement.FAILED and limit is not None and number == number_text(limit):
            number = next(text for n in range(5, 18) if (text := f"{value:.{n}g}") != f"{limit:.{n}g}")
        return _joined(number, unit)


def _with_unit(value: float, unit: str) -> str:
    return temperature_text(value) if unit == KELVIN else _joined(number_text(value), unit)


def _joined(number: str, unit: str) -> str:
    return number if unit in ("", "1") else f"{number} {with_micro_signs(unit)}"


def _grouped(value: float) -> str:
    """Return a number as text; numbers of 10,000 or more have thousands separators."""
    return f"{value:,.0f}" if abs(value) >= 1e4 else number_text(value)


def judge(
    measured: Sequence[Quantity],
    criteria: Sequence[Criterion],
    machine: Mapping[str, float],
    unstable: Callable[[], str] = str,
) -> list[Finding]:
    """Return the verdicts on quantities in the order of the criteria; quantities without a criterion come last.

    Parameters
    ----------
    measured
        Computed quantities.
    criteria
        Criteria.
    machine
        Variables of the machine that formulas may use.
    unstable
        Function that returns why the machine does not levitate, or "" if it does. It is called only if a quantity has
        `needs_stable_loop`.
    """
    result: list[Finding] = []
    for item in measured:
        facts = {**machine, **item.facts}
        applicable = [criterion for criterion in criteria if criterion.quantity == item.quantity]
        instability = unstable() if item.needs_stable_loop and applicable else ""
        judged = [
            verdict for criterion in applicable if (verdict := _judged(item, criterion, facts, instability)) is not None
        ]
        result += judged or [Finding(item, None, Judgement.NOT_JUDGED)]
    order = {criterion.key: k for k, criterion in enumerate(criteria)}
    return sorted(result, key=lambda item: len(order) if item.criterion is None else order[item.criterion.key])


def _judged(item: Quantity, criterion: Criterion, facts: Mapping[str, float], instability: str) -> Finding | None:
    try:
        if not criterion.applies(facts):
            return None
        if criterion.known == "missing":
            return Finding(item, criterion, Judgement.NOT_JUDGED, reason="No source for its limits was found")
        if instability:
            return Finding(item, criterion, Judgement.UNANSWERED, reason=instability)
        limit = criterion.limit_of(facts)
        verdict = Judgement.MET if criterion.is_met(item.value, facts) else Judgement.FAILED
    except ValueError as error:
        return Finding(item, criterion, Judgement.UNANSWERED, reason=str(error))
    if reason := item.chaotic or (item.may_worsen_because if verdict is Judgement.MET else ""):
        return Finding(item, criterion, Judgement.UNANSWERED, limit, reason=reason)
    return Finding(item, criterion, verdict, limit, criterion.zone_of(item.value), facts=facts)
