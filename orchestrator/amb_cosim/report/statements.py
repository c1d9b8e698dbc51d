"""Statements of the thesis as data: where, what, value, tolerance, and how the same is computed here."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping
from functools import cache
from importlib.resources import files
from typing import Annotated, Any, Literal

from pydantic import Field, StrictBool, StrictFloat, StrictInt, StrictStr, model_validator

from amb_cosim.cosim.tables import Table, Values
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
    planes
        Nodes whose translations the plant keeps, in place of those of the scenario's rotor.
    study, arguments
        Name of a study of `study_quantities`, and its arguments.
    reading
        What differs from the words of the thesis, where they leave something open or do not lead to what they report.
    """

    scenario: str = ""
    set: Values = Field(default={})
    end_cycle: float | None = Field(default=None, gt=0.0)
    planes: tuple[StrictInt, ...] = ()
    study: str = ""
    arguments: Values = Field(default={})
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
    """One number, list, outcome or picture of the thesis.

    key, where, what
        Name, place in the thesis (`Fig. 4.9`), and content in the project's words.
    value, unit, relation
        What the thesis has; a list for a row of a table. With `below` and `above` it is a limit.
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
    given
        Whether the model takes the value over as an input.
    why
        Why it is missed, where it is.
    picture, missing
        What a figure without numbers shows; why a statement is not computed.
    """

    key: str = Field(pattern=r"^[a-z]+\d_\d+[a-z]?\.[a-z0-9_]+$")
    where: str = Field(pattern=r"^(Fig\.|Figs|Table|Eq\.|Section) [2-7]\.\d+")
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
    given: bool = False
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
    def chapter(self) -> int:
        """Chapter of the thesis."""
        found = re.search(r"\d", self.where)
        assert found is not None  # the form demands it
        return int(found[0])

    @property
    def group(self) -> str:
        """First part of the key: the figure, table, equation or section."""
        return self.key.partition(".")[0]


class Statements(Table):
    """The content of the file: sources by name, and statements in the order of the thesis."""

    sources: dict[str, Source]
    statement: tuple[Statement, ...]

    @model_validator(mode="after")
    def _fits(self) -> Statements:
        keys = [statement.key for statement in self.statement]
        twice = sorted({key for key in keys if keys.count(key) > 1})
        if twice:
            raise ValueError(f"two statements have the key {twice[0]}")
        for statement in self.statement:
            for name in (statement.source, *(reading.source for reading in (*statement.reading, *statement.beside))):
                if name and name not in self.sources:
                    raise ValueError(f"statement {statement.key}: no source {name!r}; {suggest(name, self.sources)}")
        return self


def parse_statements(data: Mapping[str, Any], name: str) -> Statements:
    """Return the statements in what a file holds.

    Raises
    ------
    ValueError
        If the data does not have the form; one line for each mistake, which begins with `name`.
    """
    return validate(data, Statements, name)


@cache
def load_statements() -> Statements:
    """Return the statements that come with the package."""
    return parse_statements(read_toml(files(__package__) / FILE, FILE), FILE)


def selected(statements: Statements, only: Collection[str] = ()) -> tuple[Statement, ...]:
    """Return the statements of some chapters (`ch4`), figures and tables (`fig4_9`, `table3_1`); all without `only`.

    Raises
    ------
    ValueError
        If there is no statement of that name.
    """
    names = {f"ch{statement.chapter}" for statement in statements.statement}
    names |= {statement.group for statement in statements.statement}
    for name in only:
        if name not in names:
            raise ValueError(f"--only {name} is not allowed; {suggest(name, sorted(names))}")
    return tuple(s for s in statements.statement if not only or {f"ch{s.chapter}", s.group} & {*only})


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)
