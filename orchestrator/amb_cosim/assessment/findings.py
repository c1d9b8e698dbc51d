"""What was computed of a machine, and the verdict on it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum

from amb_cosim.assessment.criteria import Criterion
from amb_cosim.reporting.page_parts import number_text
from amb_cosim.reporting.panels import Panel


class Judgement(StrEnum):
    """What became of a question."""

    MET = "met"
    MISSED = "missed"
    NOT_JUDGED = "no criterion"
    UNANSWERED = "not answered"


@dataclass(frozen=True)
class Quantity:
    """A quantity of the machine.

    quantity, where
        Its name, as criteria have it, and place, axis, mode or speed.
    value, unit
        Number and unit.
    facts
        Variables of its own that formulas of criteria may name.
    note
        What a reader must know of it.
    """

    quantity: str
    where: str
    value: float
    unit: str = ""
    facts: Mapping[str, float] = field(default_factory=dict)
    note: str = ""


@dataclass(frozen=True)
class PartTable:
    """A table of a part: title, heads, and rows of texts."""

    title: str
    heads: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


@dataclass(frozen=True)
class PartResult:
    """What a part found: quantities, plots, tables, and what a reader must know."""

    measured: tuple[Quantity, ...] = ()
    panels: tuple[Panel, ...] = ()
    tables: tuple[PartTable, ...] = ()
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class Finding:
    """A verdict on a quantity.

    measured, criterion
        What was computed, and what is asked of it, if anything is.
    verdict, limit, zone
        The verdict, the limit it rests on, and the zone where the criterion has zones.
    reason
        Why there is none.
    """

    measured: Quantity
    criterion: Criterion | None
    verdict: Judgement
    limit: float | None = None
    zone: str = ""
    reason: str = ""

    @property
    def advice(self) -> str:
        """What to do, where a criterion is missed."""
        return self.criterion.advice if self.criterion is not None and self.verdict is Judgement.MISSED else ""

    @property
    def limit_text(self) -> str:
        """The limit with relation and unit, or the zones that are accepted."""
        if self.criterion is None or self.limit is None:
            return "–"
        number = _with_unit(self.limit, self.criterion.unit)
        if self.criterion.zones:
            return f"zone {self.criterion.accepted}: below {number}"
        return f"{'at most' if self.criterion.relation == 'below' else 'at least'} {number}"

    @property
    def value_text(self) -> str:
        """The value with unit and zone, in as many digits as tell it from a limit that it misses."""
        value, unit, limit = self.measured.value, self.measured.unit, self.limit
        number = number_text(value)
        if self.verdict is Judgement.MISSED and limit is not None and number == number_text(limit):
            number = next(message for n in range(5, 18) if (message := f"{value:.{n}g}") != f"{limit:.{n}g}")
        text = number if unit in ("", "1") else f"{number} {unit}"
        return f"{text}, zone {self.zone}" if self.zone else text


def _with_unit(value: float, unit: str) -> str:
    return number_text(value) if unit in ("", "1") else f"{number_text(value)} {unit}"


def judge(measured: Sequence[Quantity], criteria: Sequence[Criterion], machine: Mapping[str, float]) -> list[Finding]:
    """Return the verdicts on quantities, criterion by criterion, and after these what no criterion asks for.

    Parameters
    ----------
    measured
        What was computed.
    criteria
        What is asked.
    machine
        Variables of the machine that formulas may name.
    """
    result: list[Finding] = []
    for one in measured:
        facts = {**machine, **one.facts}
        requested = [criterion for criterion in criteria if criterion.quantity == one.quantity]
        judged = [verdict for criterion in requested if (verdict := _judged(one, criterion, facts)) is not None]
        result += judged or [Finding(one, None, Judgement.NOT_JUDGED)]
    order = {criterion.key: k for k, criterion in enumerate(criteria)}
    return sorted(result, key=lambda one: len(order) if one.criterion is None else order[one.criterion.key])


def _judged(one: Quantity, criterion: Criterion, facts: Mapping[str, float]) -> Finding | None:
    try:
        if not criterion.applies(facts):
            return None
        if criterion.known == "missing":
            return Finding(one, criterion, Judgement.NOT_JUDGED, reason="No source of its limits could be read")
        limit = criterion.limit_of(facts)
        verdict = Judgement.MET if criterion.is_met(one.value, facts) else Judgement.MISSED
    except ValueError as error:
        return Finding(one, criterion, Judgement.UNANSWERED, reason=str(error))
    if criterion.unit != one.unit:
        reason = f"the criterion is in {criterion.unit or '1'}, the quantity in {one.unit or '1'}"
        return Finding(one, criterion, Judgement.UNANSWERED, reason=reason)
    return Finding(one, criterion, verdict, limit, criterion.zone_of(one.value))
