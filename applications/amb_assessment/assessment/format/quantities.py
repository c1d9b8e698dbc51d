"""Results of analyses: the quantities that criteria may limit, tables, plots and notes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import NamedTuple

from amb_assessment.reporting.panels import Panel
from amb_cosim.presentation.units import column_in_chosen_units


class Declaration(NamedTuple):
    """A quantity: its unit, its variables for formulas besides those of the machine, and its title on the page.

    Without a title, the page shows its name with spaces.
    """

    unit: str
    variables: tuple[str, ...] = ()
    title: str = ""


_DECLARED: dict[str, Declaration] = {}
QUANTITIES: Mapping[str, Declaration] = _DECLARED
"""All quantities, by name; complete when the analyses are imported, as `engine` does."""


def declare(name: str, unit: str, variables: tuple[str, ...] = (), title: str = "") -> None:
    """Declare a quantity, in the module that computes it.

    Raises
    ------
    ValueError
        If there is another quantity of this name.
    """
    if name in QUANTITIES:
        raise ValueError(f"the quantity {name} is declared twice")
    _DECLARED[name] = Declaration(unit, variables, title)


@dataclass(frozen=True)
class Quantity:
    """A quantity of the machine.

    quantity, where
        Name in criteria, and place, axis, mode or speed.
    value, unit
        Number and unit.
    facts
        Variables of this quantity for formulas of criteria.
    note
        Note for the reader.
    may_worsen_because
        Reason why the value may become worse, so a criterion can fail but not be met; otherwise empty.
    chaotic
        Reason why the value depends on chance, so a criterion can neither be met nor fail; otherwise empty.
    needs_stable_loop
        Whether it describes a levitated rotor: if the loop is unstable, its criteria are unanswered.
    shown
        Text shown instead of a placeholder value, as without a stable loop; otherwise empty.
    """

    quantity: str
    where: str
    value: float
    unit: str = ""
    facts: Mapping[str, float] = field(default_factory=dict)
    note: str = ""
    may_worsen_because: str = ""
    chaotic: str = ""
    needs_stable_loop: bool = False
    shown: str = ""

    @property
    def title(self) -> str:
        """The quantity in words."""
        return QUANTITIES[self.quantity].title or self.quantity.replace("_", " ")


@dataclass(frozen=True)
class ResultTable:
    """A table of an analysis: title, heads, and rows of texts."""

    title: str
    heads: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]

    def in_chosen_units(self) -> ResultTable:
        """Return the table with speeds, lengths and forces in the units that were chosen (`presentation.units`)."""
        heads, converters = zip(*map(column_in_chosen_units, self.heads), strict=True)
        rows = (tuple(convert(cell) for convert, cell in zip(converters, row, strict=True)) for row in self.rows)
        return replace(self, heads=heads, rows=tuple(rows))


@dataclass(frozen=True)
class AnalysisResult:
    """Results of an analysis: quantities, plots, tables, and notes."""

    quantities: tuple[Quantity, ...] = ()
    panels: tuple[Panel, ...] = ()
    tables: tuple[ResultTable, ...] = ()
    notes: tuple[str, ...] = ()


def check_declared(quantity: str, unit: str, variables: Mapping[str, float]) -> None:
    """Raise LookupError if an analysis computes an undeclared quantity, unit or variable."""
    declared = QUANTITIES.get(quantity)
    if declared is None or unit != declared.unit or not variables.keys() <= set(declared.variables):
        given = f"{quantity} in {unit or '1'} with {', '.join(variables) or 'no variables'}"
        raise LookupError(f"{given} is not declared; see `declare`")
