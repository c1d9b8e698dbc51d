"""Statements of a source as data: the place, content, value, tolerance and computation of each."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from fnmatch import fnmatchcase
from functools import cache
from typing import Annotated, Any, Literal

from pydantic import Field, StrictBool, StrictFloat, StrictInt, StrictStr, model_validator

from amb_cosim.cosim.system.tables import Table, Values
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
Cause = Literal["data", "detail", "reading", "unexplained"]


class Source(Table):
    """A source of values for statements: a run of a scenario, or a study."""

    scenario: str = ""
    """Name of a scenario; set either this or `study`."""
    set: Values = Field(default={})
    """Values that replace values of the scenario."""
    end_cycle: float | None = Field(default=None, gt=0.0)
    """Cycle at which the run ends, instead of the scenario's end."""
    unbalance_factor: float | None = Field(default=None, gt=0.0)
    """Factor on all unbalances, which replaces the scenario's factor."""
    rotor: dict[str, dict[str, Any]] = Field(default={})
    """Tables that replace tables of the scenario's rotor file."""
    rotor_file: str = ""
    """Name of a rotor that replaces the scenario's."""
    system: str = ""
    """Name of a system that replaces the scenario's; settings of missing components are left out."""
    study: str = ""
    """Name of a study of `amb_analysis.studies`, or `model_inputs`."""
    arguments: Values = Field(default={})
    """Arguments of the study."""
    title: str = ""
    """One-line description that replaces the description of the scenario or study."""
    reading: str = ""
    """Assumptions on open points of the source, and deviations from it."""

    @model_validator(mode="after")
    def _has_scenario_or_study(self) -> Source:
        if bool(self.scenario) == bool(self.study):
            raise ValueError("a source needs either scenario or study")
        return self


class Reading(Table):
    """Another way to compute a statement."""

    source: str
    """Run or study for this computation."""
    quantity: str = ""
    """Quantity of this source, if it differs from that of the statement."""
    arguments: Values | None = None
    """Arguments of the quantity, if they differ from those of the statement."""
    how: str = ""
    """Description of this other computation in words."""


class Statement(Table):
    """One number, list, outcome or picture that a source states."""

    key: Annotated[
        str,
        Field(pattern=r"^[a-z0-9_]+\.[a-z0-9_]+$"),
        Allowed("two names of lower-case letters, digits and underscores with a dot between them"),
    ]
    """Name; its first part names a figure, a table or another group of statements."""
    where: str = Field(min_length=1)
    """Place in the source, such as `Table 2`."""
    what: str
    """Content, in the project's words."""
    value: Expected | None = None
    """The statement; a list for a row of a table."""
    unit: str = ""
    """Its unit."""
    relation: Relation = "equal"
    """With `below` or `above`, the value is a limit."""
    tolerance: float = Field(default=0.0, ge=0.0)
    """Allowed deviation, relative to the value; the larger of this and `absolute` applies."""
    absolute: float = Field(default=0.0, ge=0.0)
    """Allowed deviation in the unit of the value."""
    floor: float | None = None
    """With `below`, the smallest value that meets the limit, in the unit of the value; unlimited by default."""
    because: str = ""
    """Reason for the tolerance."""
    source: str = ""
    """Run or study for the computation."""
    quantity: str = ""
    """Quantity of that run or study."""
    arguments: Values = Field(default={})
    """Arguments of the quantity."""
    reading: tuple[Reading, ...] = ()
    """Other ways to compute the value, tried in turn if the computed value does not match."""
    beside: tuple[Reading, ...] = ()
    """Other ways to compute the value, which are shown but not judged."""
    converged: str = ""
    """Run or study with more modes, whose value of the quantity is printed and judged in a separate column."""
    given: bool = False
    """Whether the value is an input of the model."""
    definition: bool = False
    """Whether every model meets the value: a unit conversion, a kinematic identity, or a formula of the source."""
    inferred: str = ""
    """How the source is interpreted, for example which number stands for one of its words."""
    why: str = ""
    """Reason why the computed value does not match."""
    cause: Cause = "unexplained"
    """Kind of this reason: `data` if the source gives too little or contradicts itself; `detail` if the value depends
    on details of the machine that the source leaves open; `reading` if only another reading of the source meets it."""
    picture: str = ""
    """Content of a figure without numbers."""
    missing: str = ""
    """Reason why the value is not computed."""

    @model_validator(mode="after")
    def _is_complete(self) -> Statement:
        if sum((bool(self.quantity), bool(self.picture), bool(self.missing))) != 1:
            raise ValueError("a statement needs exactly one of quantity, picture and missing")
        if self.quantity and (self.value is None or not self.source):
            raise ValueError("a statement with a quantity needs value and source")
        if self.relation != "equal" and not _is_number(self.value):
            raise ValueError(f"relation {self.relation} needs a number as its value")
        if self.floor is not None and self.relation != "below":
            raise ValueError(f"floor = {self.floor:g} needs relation = 'below'")
        return self

    @property
    def group(self) -> str:
        """First part of the key, which names the figure, table, equation or section."""
        return self.key.partition(".")[0]


class Chapter(Table):
    """A part of the statements, which is a chapter of the page."""

    key: str
    """Name for `--only`, such as `ch4`."""
    name: str
    """Name on the page, such as `chapter 4`."""
    title: str = ""
    """Title on the page, such as `Contact`."""
    groups: tuple[str, ...] = ("*",)
    """Patterns such as `table4_*`; a statement whose group matches one of them belongs here."""

    def has(self, statement: Statement) -> bool:
        """Return whether a statement belongs to the chapter."""
        return any(fnmatchcase(statement.group, pattern) for pattern in self.groups)


class Statements(Table):
    """Content of a file of statements."""

    title: str
    """Title of the page."""
    about: str = ""
    """Sentence on what the page compares."""
    note: str = ""
    """Note on the verdicts."""
    label: str = "stated"
    """Name of the source in table headings."""
    converged: str = "converged model"
    """Name, in table headings, of the model with more modes."""
    quantities: str = ""
    """Module with additional quantities and plots, see `source_check.quantities`."""
    chapter: tuple[Chapter, ...] = (Chapter(key="all", name="statements"),)
    """Chapters of the page; default: one."""
    sources: dict[str, Source]
    """Runs and studies by name."""
    statement: tuple[Statement, ...]
    """Statements in the order of their source."""

    @model_validator(mode="after")
    def _fits(self) -> Statements:
        keys = [statement.key for statement in self.statement]
        repeated = sorted({key for key in keys if keys.count(key) > 1})
        if repeated:
            raise ValueError(f"two statements have the key {repeated[0]}")
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
        """Statements of each chapter (`ch4`) and of each group (`table3_1`), by name."""
        result: dict[str, list[Statement]] = {}
        for statement in self.statement:
            for name in (*(chapter.key for chapter in self.chapter if chapter.has(statement)), statement.group):
                result.setdefault(name, []).append(statement)
        return result


def parse_statements(data: Mapping[str, Any], name: str) -> Statements:
    """Check the content of a file, and return it as `Statements`.

    Raises
    ------
    ValueError
        If the data are malformed; the message has one line, which begins with `name`, for each mistake.
    """
    return validate(data, Statements, name)


def packs_with_statements() -> list[str]:
    """Return the names of the packs that have statements."""
    return [pack for pack, folder in packs().items() if (folder / FILE).is_file()]


@cache
def load_statements(pack: str) -> Statements:
    """Return the statements of a pack.

    Raises
    ------
    ValueError
        If there is no such pack, it has no statements, or its file is malformed.
    """
    if pack not in packs_with_statements():
        raise ValueError(f"pack {pack!r} has no {FILE}; {suggest(pack, packs_with_statements())}")
    name = f"{FILE} of pack {pack}"
    return parse_statements(read_toml(packs()[pack] / FILE, name), name)


def selected(statements: Statements, only: Collection[str] = ()) -> tuple[Statement, ...]:
    """Return the statements of the chapters (`ch4`) and groups (`table3_1`) in `only`; by default all statements.

    Raises
    ------
    ValueError
        If a name denotes neither a chapter nor a group.
    """
    named = statements.named
    for name in only:
        if name not in named:
            raise ValueError(f"only = {name} is not allowed; {suggest(name, sorted(named))}")
    chosen = {statement.key for name in only for statement in named[name]}
    return tuple(statement for statement in statements.statement if not only or statement.key in chosen)


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)
