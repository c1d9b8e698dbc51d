"""Statements of a source as data: where, what, value, tolerance, and how the same is computed here."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from fnmatch import fnmatchcase
from functools import cache
from typing import Annotated, Any, Literal

from pydantic import Field, StrictBool, StrictFloat, StrictInt, StrictStr, model_validator

from amb_cosim.cosim.tables import Table, Values
from amb_files.packs import packs
from amb_files.suggestions import suggest
from amb_files.toml import read_toml, validate
from amb_files.validation_errors import Allowed

FILE = "statements.toml"

Number = StrictInt | StrictFloat
Expected = Annotated[
    StrictBool | Number | StrictStr | tuple[Number, ...],
    Field(union_mode="smart"),
    Allowed("a number, a list of numbers, true, false or a text"),
]
Relation = Literal["equal", "below", "above"]


class Source(Table):
    """A run of a scenario or a study, from which statements are computed.

    scenario, set, end_cycle
        Name of a scenario, values that replace its own, and the cycle at which the run ends in place of its own.
    unbalance_factor, rotor, rotor_file
        Factor on all unbalances in place of the scenario's, tables that replace those of its rotor file, and the name
        of a rotor in place of its own.
    study, arguments
        Name of a study, of `amb_cosim.studies` or `model_inputs`, and its arguments.
    title
        One line about it, in place of the scenario's or the study's own.
    reading
        What differs from the words of the source, where they leave something open or do not lead to what they report.
    """

    scenario: str = ""
    set: Values = Field(default={})
    end_cycle: float | None = Field(default=None, gt=0.0)
    unbalance_factor: float | None = Field(default=None, gt=0.0)
    rotor: dict[str, dict[str, Any]] = Field(default={})
    rotor_file: str = ""
    study: str = ""
    arguments: Values = Field(default={})
    title: str = ""
    reading: str = ""

    @model_validator(mode="after")
    def _is_one(self) -> Source:
        if bool(self.scenario) == bool(self.study):
            raise ValueError("a source needs either scenario or study")
        return self


class Reading(Table):
    """Another way to compute a statement: its source, and quantity and arguments where they differ; `how` in words."""

    source: str
    quantity: str = ""
    arguments: Values | None = None
    how: str = ""


class Statement(Table):
    """One number, list, outcome or picture of a source.

    key, where, what
        Name, whose first part is that of a figure, a table or another group of statements; place in the source, such as
        `Table 2`; and content in the project's words.
    value, unit, relation
        What is stated; a list for a row of a table. With `below` and `above` it is a limit.
    tolerance, absolute
        How far our value may be from it, relative to it and in its unit; the larger one counts.
    because
        Why the tolerance is what it is.
    source, quantity, arguments
        What it is computed from, and the quantity of that.
    reading
        Other ways to compute it, tried in turn where the first one misses.
    beside
        Other ways that are shown beside, and not judged.
    converged
        Source of the same quantity on a model with more modes, shown and judged in a column of its own.
    given
        Whether the model takes the value over as an input.
    definition
        Whether any model must meet it: a conversion of units, a kinematic identity, a formula of the source itself.
    inferred
        What is read into the words of the source where they do not say it: a number for a word, a comparison.
    why
        Why it is missed, where it is.
    picture, missing
        What a figure without numbers shows; why a statement is not computed.
    """

    key: str = Field(pattern=r"^[a-z0-9_]+\.[a-z0-9_]+$")
    where: str = Field(min_length=1)
    what: str
    value: Expected | None = None
    unit: str = ""
    relation: Relation = "equal"
    tolerance: float = Field(default=0.0, ge=0.0)
    absolute: float = Field(default=0.0, ge=0.0)
    because: str = ""
    source: str = ""
    quantity: str = ""
    arguments: Values = Field(default={})
    reading: tuple[Reading, ...] = ()
    beside: tuple[Reading, ...] = ()
    converged: str = ""
    given: bool = False
    definition: bool = False
    inferred: str = ""
    why: str = ""
    picture: str = ""
    missing: str = ""

    @model_validator(mode="after")
    def _is_complete(self) -> Statement:
        if sum((bool(self.quantity), bool(self.picture), bool(self.missing))) != 1:
            raise ValueError("a statement needs one of quantity, picture and missing")
        if self.quantity and (self.value is None or not self.source):
            raise ValueError("a statement with a quantity needs value and source")
        if self.relation != "equal" and not _is_number(self.value):
            raise ValueError(f"relation {self.relation} needs a number as value")
        return self

    @property
    def group(self) -> str:
        """First part of the key: the figure, table, equation or section."""
        return self.key.partition(".")[0]


class Chapter(Table):
    """A part of the statements: those whose groups match a pattern, such as `table4_*`.

    key, name, title
        Name for `--only` (`ch4`), name and title on the page (`chapter 4`, `Contact`).
    groups
        Patterns of the groups of its statements.
    """

    key: str
    name: str
    title: str = ""
    groups: tuple[str, ...] = ("*",)

    def has(self, statement: Statement) -> bool:
        """Return whether a statement is one of the chapter."""
        return any(fnmatchcase(statement.group, pattern) for pattern in self.groups)


class Statements(Table):
    """The content of the file.

    title, about, note
        What the page is called, what it compares, and what a reader must know of its verdicts.
    label, converged
        What the source, and the model with more modes, are called in the heads of tables.
    quantities
        Module with quantities and plots of its own, see `amb_cosim.assessment.quantities`.
    chapter
        Parts of the statements; without, they are one.
    sources, statement
        Runs and studies by name, and statements in the order of their source.
    """

    title: str
    about: str = ""
    note: str = ""
    label: str = "stated"
    converged: str = "converged model"
    quantities: str = ""
    chapter: tuple[Chapter, ...] = (Chapter(key="all", name="statements"),)
    sources: dict[str, Source]
    statement: tuple[Statement, ...]

    @model_validator(mode="after")
    def _fits(self) -> Statements:
        keys = [statement.key for statement in self.statement]
        twice = sorted({key for key in keys if keys.count(key) > 1})
        if twice:
            raise ValueError(f"two statements have the key {twice[0]}")
        for statement in self.statement:
            if not any(chapter.has(statement) for chapter in self.chapter):
                raise ValueError(f"statement {statement.key}: no chapter has groups that match {statement.group}")
            others = (reading.source for reading in (*statement.reading, *statement.beside))
            for name in (statement.source, statement.converged, *others):
                if name and name not in self.sources:
                    raise ValueError(f"statement {statement.key}: no source {name!r}; {suggest(name, self.sources)}")
        return self

    @property
    def named(self) -> dict[str, list[Statement]]:
        """The statements of each chapter (`ch4`) and each group (`table3_1`)."""
        found: dict[str, list[Statement]] = {}
        for statement in self.statement:
            for name in (*(chapter.key for chapter in self.chapter if chapter.has(statement)), statement.group):
                found.setdefault(name, []).append(statement)
        return found


def parse_statements(data: Mapping[str, Any], name: str) -> Statements:
    """Return the statements in what a file holds.

    Raises
    ------
    ValueError
        If the data does not have the form; one line for each mistake, which begins with `name`.
    """
    return validate(data, Statements, name)


def packs_with_statements() -> list[str]:
    """Return the names of the packs that state something."""
    return [pack for pack, folder in packs().items() if (folder / FILE).is_file()]


@cache
def load_statements(pack: str) -> Statements:
    """Return the statements of a pack.

    Raises
    ------
    ValueError
        If there is no such pack, it states nothing, or its file does not have the form.
    """
    if pack not in packs_with_statements():
        raise ValueError(f"pack {pack!r} has no {FILE}; {suggest(pack, packs_with_statements())}")
    name = f"{FILE} of pack {pack}"
    return parse_statements(read_toml(packs()[pack] / FILE, name), name)


def selected(statements: Statements, only: Collection[str] = ()) -> tuple[Statement, ...]:
    """Return the statements of some chapters (`ch4`) and groups (`table3_1`); all without `only`.

    Raises
    ------
    ValueError
        If there is no statement of that name.
    """
    named = statements.named
    for name in only:
        if name not in named:
            raise ValueError(f"--only {name} is not allowed; {suggest(name, sorted(named))}")
    chosen = {statement.key for name in only for statement in named[name]}
    return tuple(statement for statement in statements.statement if not only or statement.key in chosen)


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)
