"""Criteria as data: requirements of standards or users on quantities, with their sources and reliability."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from string import Formatter
from typing import Annotated, Literal

from pydantic import Field, FiniteFloat, model_validator

from amb_assessment.assessment.format.expressions import evaluate, names_in
from amb_assessment.assessment.format.quantities import QUANTITIES
from amb_cosim.cosim.system.tables import Table
from amb_files.checks import repeated
from amb_files.packs import PackFiles, files_of, pack_of
from amb_files.suggestions import suggest
from amb_files.toml import read_toml, validate
from amb_files.validation_errors import Allowed

Reliability = Literal["read", "secondary", "recalled", "own", "missing"]
WORDS = ("value", "limit", "where", "zone")  # of a sentence on a failure
RELIABILITIES: Mapping[Reliability, str] = {
    "read": "read in the standard",
    "secondary": "from a secondary source; not checked against the standard",
    "recalled": "from memory; not checked against the standard",
    "own": "own criterion",
    "missing": "its limits are unknown; no source was found",
}


class Criterion(Table):
    """A requirement on a quantity.

    key, clause, what
        Name of the criterion; clause of the standard; the requirement in the project's own words.
    quantity, unit
        The judged quantity, which is one of `QUANTITIES`, and the unit of the limits, which must equal the quantity's
        unit.
    relation
        `below` or `above`: the side of the limit on which the quantity must be.
    limit
        Formula for the limit, in terms of variables of the machine and of the quantity.
    zones, accepted
        These replace a limit: the upper limits of the zones by name, in ascending order, and the last accepted zone.
        Values above all limits are in the zone `beyond`.
    beyond
        Name of the zone above all others.
    when
        Formula that is true in the cases to which the criterion applies; by default, the criterion applies to all
        cases.
    source, known
        Source of the limit, and how reliable the source is. If no source is known, `known` is `missing` and the
        criterion has no limit, so the quantity is reported without a verdict.
    failure
        Sentence that is shown if the criterion fails. In this sentence, `{value}`, `{limit}`, `{where}`, `{zone}` and
        variables of formulas in braces are replaced by texts. By default, the sentence contains `what`, the value, the
        limit and the place.
    advice
        Advice that is shown if the criterion fails.
    """

    key: Annotated[str, Field(pattern=r"^[a-z0-9_]+$"), Allowed("a name of lower-case letters, digits and underscores")]
    clause: str = ""
    what: str
    failure: str = ""
    quantity: str
    unit: str = "1"
    relation: Literal["below", "above"] = "below"
    limit: str = ""
    zones: dict[str, FiniteFloat] = Field(default={})
    accepted: str = ""
    beyond: str = ""
    when: str = ""
    source: str
    known: Reliability
    advice: str = ""
    standard: str = ""
    edition: str = ""

    @model_validator(mode="after")
    def _is_complete(self) -> Criterion:
        if self.known == "missing":
            if self.limit or self.zones:
                raise ValueError(f"criterion {self.key} has known = 'missing' but has limits; state their source")
        elif bool(self.limit) == bool(self.zones):
            raise ValueError(f"criterion {self.key} needs either 'limit' or 'zones'")
        if self.zones and (self.accepted not in self.zones or not self.beyond):
            raise ValueError(
                f"criterion {self.key} with zones needs both 'beyond' and 'accepted'; 'accepted' must be one of "
                f"{', '.join(self.zones)}"
            )
        if self.zones and list(self.zones.values()) != sorted(self.zones.values()):
            raise ValueError(f"criterion {self.key}: zones must ascend")
        for formula in filter(None, (self.limit, self.when)):
            names_in(formula)
        _ = self.named_in_failure
        return self

    @property
    def named_in_failure(self) -> set[str]:
        """The names between braces in `failure`."""
        try:
            return {name for _, name, _, _ in Formatter().parse(self.failure) if name is not None}
        except ValueError as error:
            raise ValueError(f"criterion {self.key}: failure = {self.failure!r} is not allowed: {error}") from error

    @property
    def where(self) -> str:
        """Standard, edition and clause in a single text."""
        return ", ".join(filter(None, (f"{self.standard} {self.edition}".strip(), self.clause)))

    def applies(self, facts: Mapping[str, float]) -> bool:
        """Return whether the criterion applies to a case with these variables."""
        return not self.when or bool(evaluate(self.when, facts))

    def limit_of(self, facts: Mapping[str, float]) -> float:
        """Return the limit in a case with these variables, in the criterion's unit."""
        return self.zones[self.accepted] if self.zones else evaluate(self.limit, facts)

    def zone_of(self, value: float) -> str:
        """Return the zone of a value, or an empty text if the criterion has no zones."""
        if not self.zones:
            return ""
        return next((name for name, upper in self.zones.items() if value < upper), self.beyond)

    def is_met(self, value: float, facts: Mapping[str, float]) -> bool:
        """Return whether a value meets the criterion; a value at the limit meets it, except at the limit of a zone."""
        limit = self.limit_of(facts)
        if self.zones:
            return value < limit
        return value <= limit * (1.0 + 1e-12) if self.relation == "below" else value >= limit * (1.0 - 1e-12)


class CriteriaFile(Table):
    """A file of criteria, from an edition of a standard or from a user."""

    standard: str
    edition: str = ""
    note: str = ""
    criterion: tuple[Criterion, ...]

    @model_validator(mode="after")
    def _has_each_once(self) -> CriteriaFile:
        if duplicates := repeated(criterion.key for criterion in self.criterion):
            raise ValueError(f"two criteria have the key {duplicates[0]}")
        return self


def check_criteria(criteria: Sequence[Criterion], facts: Mapping[str, float]) -> None:
    """Check quantities, units and names in formulas, and evaluate formulas that use only the machine's variables.

    Raises
    ------
    ValueError
        If a criterion names an unknown quantity or variable, if its unit differs from the quantity's unit, or if a
        formula has no value. The message names the criterion.
    """
    for criterion in criteria:
        if criterion.quantity not in QUANTITIES:
            hint = suggest(criterion.quantity, QUANTITIES)
            raise ValueError(f"criterion {criterion.key}: there is no quantity {criterion.quantity!r}; {hint}")
        if criterion.unit != (unit := QUANTITIES[criterion.quantity].unit):
            wrong = f"unit = {criterion.unit!r} is not allowed; {criterion.quantity} is in {unit}"
            raise ValueError(f"criterion {criterion.key}: {wrong}")
        known = [*facts, *QUANTITIES[criterion.quantity].variables]
        for formula in filter(None, (criterion.limit, criterion.when)):
            if unknown := sorted(names_in(formula) - set(known)):
                hint = suggest(unknown[0], known)
                raise ValueError(
                    f"criterion {criterion.key}: formula {formula!r} names an unknown variable {unknown[0]!r}; {hint}"
                )
            if names_in(formula) <= facts.keys():
                try:
                    evaluate(formula, facts)
                except ValueError as error:
                    raise ValueError(f"criterion {criterion.key}: {error}") from error
        if unknown := sorted(criterion.named_in_failure - {*WORDS, *known}):
            hint = suggest(unknown[0], [*WORDS, *known])
            raise ValueError(f"criterion {criterion.key}: failure names an unknown variable {unknown[0]!r}; {hint}")


def packaged_criteria() -> PackFiles:
    """Return the criteria files of this package and of all packs, by name."""
    return files_of("criteria", amb_cosim=Path(__file__).parents[1])


def unread(criteria: Sequence[Criterion]) -> int:
    """Return the number of criteria that were written without access to the text of their standard."""
    return sum(item.known not in ("read", "own") for item in criteria)


def load_criteria(sources: Sequence[str | Path] = ()) -> tuple[Criterion, ...]:
    """Return all criteria in the given files; see `criteria_by_file`."""
    return tuple(item for criteria in criteria_by_file(sources).values() for item in criteria)


def own_criteria(by_file: Mapping[str | Path, Sequence[Criterion]]) -> tuple[Criterion, ...]:
    """Return the criteria from files that belong neither to this package nor to a pack."""
    packaged = packaged_criteria()
    return tuple(item for source, criteria in by_file.items() if str(source) not in packaged for item in criteria)


def criteria_by_file(sources: Sequence[str | Path] = ()) -> dict[str | Path, list[Criterion]]:
    """Return the criteria of each file, by the file's name or path; by default, of all packaged files.

    Raises
    ------
    ValueError
        If a file does not exist or is invalid; the message has a line for each mistake. The error is also raised if all
        packaged files are read and two packs have a criteria file of the same name.
    """
    packaged = packaged_criteria()
    if not sources and (clashes := packaged.clashes()):
        raise ValueError(clashes[0])
    return {source: _criteria_in(source, packaged) for source in (sources or packaged)}


def _criteria_in(source: str | Path, packaged: PackFiles) -> list[Criterion]:
    path = packaged.get(str(source), Path(source))
    if not path.exists():
        raise ValueError(f"there is no file of criteria {str(source)!r}; {suggest(str(source), packaged)}")
    name = f"criteria {path.name}" + (f" of pack {pack_of(path)}" if str(source) in packaged else "")
    file = validate(read_toml(path, name), CriteriaFile, name)
    common = {"standard": file.standard, "edition": file.edition}
    return [
        item.model_copy(update={k: v for k, v in common.items() if not getattr(item, k)}) for item in file.criterion
    ]
