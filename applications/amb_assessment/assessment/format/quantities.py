"""Results of analyses: the quantities that criteria may limit, tables, plots and notes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

from amb_assessment.reporting.panels import Panel


class Declaration(NamedTuple):
    """A quantity: its unit, its variables for formulas besides those of the machine, and its title on the page.

    Without a title the page has its name, with spaces.
    """

    unit: str
    variables: tuple[str, ...] = ()
    title: str = ""


QUANTITIES: Mapping[str, Declaration] = {
    "axial_capacity": Declaration("N", ("capacity",), "Force along the shaft that the rotor carries without contact"),
    "axial_frequency": Declaration("Hz", ("frequency", "N"), "Natural frequency of the axial axis"),
    "axial_load": Declaration("%", ("capacity",)),
    "clearance_share": Declaration("%", ("S_cc",)),
    "clearance_used": Declaration("%"),
    "clearance_used_fault": Declaration("%", title="Largest displacement over the clearance after a fault"),
    "clearance_used_running": Declaration("%"),
    "cross_coupling_ratio": Declaration("1", ("Q_a",)),
    "current_demand": Declaration("%"),
    "decrement": Declaration("1", ("frequency", "N")),
    "decrement_anticipated": Declaration("1", ("frequency", "N")),
    "decrement_anywhere": Declaration("1", ("frequency", "N"), "Least logarithmic decrement at all frequencies"),
    "decrement_varied": Declaration("1", ("frequency", "N"), "Least logarithmic decrement within the tolerances"),
    "heat_to_standstill": Declaration("J", title="Heat in the retainers until the rotor stands still"),
    "landing_backward_whirl": Declaration("%", ("whirl_friction", "friction"), "Landings that whirl backward"),
    "landing_ball_pressure": Declaration("MPa"),
    "landing_contact_elsewhere": Declaration("%", ("whirl_friction", "friction")),
    "landing_failed": Declaration("%", ("whirl_friction", "friction")),
    "landing_force": Declaration("1", ("weight",), "Largest contact force of a landing"),
    "landing_force_change": Declaration("%"),
    "landing_heat": Declaration("J", ("weight",), "Heat of a landing in the retainers"),
    "mode_reach": Declaration("%", ("frequency",)),
    "overload": Declaration("1", title="Acceleration that the rotor carries without contact, over g"),
    "probe_displacement": Declaration("um"),
    "relevitation": Declaration("%"),
    "rest_time": Declaration("s", title="Time until the rotor lies at rest"),
    "retainer_heat": Declaration("J", title="Heat in the retainers"),
    "retainer_temperature": Declaration("K", title="Largest temperature of a retainer"),
    "sensitivity_measured": Declaration("1", ("frequency",)),
    "sensitivity_peak": Declaration("1", ("frequency",)),
    "sensitivity_peak_beyond": Declaration("1", ("frequency",)),
    "sensitivity_varied": Declaration("1"),
    "separation_margin": Declaration("%", ("AF", "N_c"), "Separation margin of a critical speed"),
    "slew_demand": Declaration("%"),
    "spectral_radius": Declaration("1", ("growth_rate", "frequency", "N")),
    "spectral_radius_varied": Declaration("1", ("growth_rate", "frequency", "N")),
    "standstill_time": Declaration("s", title="Time until the rotor stands still"),
    "temperature_to_standstill": Declaration("K", title="Temperature of a retainer until the rotor stands still"),
    "undamped_critical_speed": Declaration("rpm", title="Undamped critical speed"),
    "whirl_friction": Declaration("1", ("friction",)),
}


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
        Reason why the value may become worse, so that a criterion can fail but not be met; otherwise empty.
    chaotic
        Reason why the value is chance, so that a criterion can neither be met nor fail; otherwise empty.
    needs_stable_loop
        Whether it describes a levitated rotor: if the loop is unstable, its criteria are unanswered.
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


@dataclass(frozen=True)
class AnalysisResult:
    """Results of an analysis: quantities, plots, tables, and notes."""

    quantities: tuple[Quantity, ...] = ()
    panels: tuple[Panel, ...] = ()
    tables: tuple[ResultTable, ...] = ()
    notes: tuple[str, ...] = ()


def check_declared(quantity: str, unit: str, variables: Mapping[str, float]) -> None:
    """Raise LookupError if an analysis computes a quantity, its unit or a variable that `QUANTITIES` does not have."""
    declared = QUANTITIES.get(quantity)
    if declared is None or unit != declared.unit or not variables.keys() <= set(declared.variables):
        given = f"{quantity} in {unit or '1'} with {', '.join(variables) or 'no variables'}"
        raise LookupError(f"{given} is not declared in QUANTITIES")
