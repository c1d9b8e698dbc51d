"""Results of analyses: the quantities that criteria may limit, tables, plots and notes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import NamedTuple

from amb_assessment.reporting.panels import Panel
from amb_cosim.presentation.units import column_in_chosen_units


class Declaration(NamedTuple):
    """A quantity: its unit, the variables that it provides to formulas besides those of the machine, and its title.

    If the title is empty, the page shows the quantity's name, with spaces instead of underscores.
    """

    unit: str
    variables: tuple[str, ...] = ()
    title: str = ""


_DECLARED: dict[str, Declaration] = {}
QUANTITIES: Mapping[str, Declaration] = _DECLARED
"""All quantities, by name. The mapping is complete once the analyses are imported, which `engine` does."""


def declare(name: str, unit: str, variables: tuple[str, ...] = (), title: str = "") -> None:
    """Declare a quantity; call this function in the module that computes it.

    Raises
    ------
    ValueError
        If another quantity of this name is declared already.
    """
    if name in QUANTITIES:
        raise ValueError(f"the quantity {name} is declared twice")
    _DECLARED[name] = Declaration(unit, variables, title)


@dataclass(frozen=True)
class Quantity:
    """A quantity of the machine.

    quantity, where
        Name that criteria use, and the place, axis, mode or speed to which the value belongs.
    value, unit
        Number and unit.
    facts
        Variables of this quantity that formulas of criteria may use.
    note
        Note for the reader.
    may_worsen_because
        Reason why the value may become worse, so that a criterion can fail but cannot be met; otherwise empty.
    chaotic
        Reason why the value depends on chance, so that a criterion can neither be met nor fail; otherwise empty.
    needs_stable_loop
        Whether the value describes a levitated rotor, so that its criteria are unanswered if the loop is unstable.
    shown
        Text that is shown instead of a placeholder value, for example if the loop is unstable; otherwise empty.
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
    """A table of an analysis: title, column heads, and rows of texts."""

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
