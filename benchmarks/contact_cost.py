"""Compare the cost of contact as a constraint with that of the classical force laws, at equal accuracy.

The case is that of Fig. 4.9 on continuous bearings: 260 rad/s, 25 g m added on D1, five turns of impacts and rubbing at
both retainers. Two comparisons, both with located events and the plant's own shorter substeps for stiff contacts:

* each law against its own solution with very short substeps: the cost of its stiffness;
* Kelvin-Voigt contacts of rising stiffness against the constraint: the cost of approximating a rigid retainer.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np
from rich.table import Table

from amb_cosim.model_constants.plant_data import plant
from amb_cosim.presentation.style import BLUE, ORANGE, StyledFigure, write_png
from amb_cosim.presentation.text_tables import labelled_table
from array_types import Array
from fmi_export.model import Instance
from rotor_contact.shaft.structure import structure_of
from rotor_contact.variables.contact_laws import LAWS

SPEED, STEP, TURNS = 260.0, 250e-6, 5.0
CLEARANCE = 0.75e-3
STIFFNESS = 1e8  # N/m, of the classical laws
RISING_STIFFNESS = (1e8, 1e9, 1e10)  # N/m, to approximate a rigid retainer
DAMPING_RATIO = 2.0  # of the retainer as a spring and damper under the journal's mass: it does not rebound
REFERENCE_SUBSTEP = 2e-6
SUBSTEPS = (250e-6, 125e-6, 62.5e-6, 31.25e-6, 15.625e-6)
FORCE_TOLERANCE = 1e-3  # of the peak contact force
ORBIT_TOLERANCE = 1e-2  # of the clearance
SIGNALS = ("mb1.x", "mb1.y", "mb2.x", "mb2.y", "rb1.f_n", "rb2.f_n")


@dataclass(frozen=True)
class Formulation:
    """A contact law with its parameters (SI), at both retainers."""

    law: str
    values: Mapping[str, float] = field(default_factory=dict)

    @property
    def label(self) -> str:
        stiffness = self.values.get("k_c")
        return self.law if stiffness is None else f"{self.law}, k_c = {stiffness:.0e} N/m"

    def plant(self, substep: float) -> Instance:
        """Return the rig in its orbit with 0.5 g m, just after 25 g m were added."""
        rotor = Instance(*plant())
        values = {"law": float(LAWS.index(self.law)), **self.values}
        settings = {f"rb{k}.{name}": value for name, value in values.items() for k in (1, 2)}
        settings |= {f"mb{k}.{name}": value for name, value in {"k_b": 1e6, "c_b": 5e3}.items() for k in (1, 2)}
        settings |= {"eb1.enabled": 0.0, "eb2.enabled": 0.0, "Omega": SPEED, "d1.u": 0.5e-3, "initial.orbit": 1.0}
        settings |= {"solver.max_substep": substep, "solver.tolerance": 1.0, "solver.exact_motion": 0.0}
        for name, value in settings.items():
            rotor[name] = value
        rotor.initialise()
        rotor["d1.u"] = 25.5e-3
        return rotor


@dataclass(frozen=True)
class ContactCost:
    """Errors and cost of one run.

    Attributes
    ----------
    substep
        Longest substep (s).
    orbit_error, force_error, penetration
        Error of the orbit over the clearance, of the force over its peak, and penetration over the clearance.
    cost
        CPU time for a simulated second (s/s).
    """

    formulation: Formulation
    substep: float
    orbit_error: float
    force_error: float
    penetration: float
    cost: float


def classical_laws() -> list[Formulation]:
    """Return every law of section 4.2 of the thesis at the same stiffness, with damping where the law has it."""
    damping: dict[str, dict[str, float]] = {
        "kelvin_voigt": {"c_c": 1e4},
        "kirk": {"c_c": 1e4},
        "hunt_crossley": {"alpha_c": 1.0},
        "ulbrich": {"eta": 0.2},
        "switched_kelvin_voigt": {"c_c": 1e4, "delta_c": 1e-6},
    }
    return [Formulation(law, {"k_c": STIFFNESS} | damping.get(law, {})) for law in LAWS[1:]]


def stiff_contacts() -> list[Formulation]:
    """Return Kelvin-Voigt contacts of rising stiffness that do not rebound."""
    s = structure_of(plant()[1])
    mass = 1.0 / s.Minv[int(s.sites[0]), int(s.sites[0])]
    return [
        Formulation("kelvin_voigt", {"k_c": k_c, "c_c": 2.0 * DAMPING_RATIO * math.sqrt(k_c * mass)})
        for k_c in RISING_STIFFNESS
    ]


def simulate(rotor: Instance, record: bool) -> tuple[Array, float]:
    """Return the signals after each step, shape (steps, signals), and CPU time per simulated second.

    Without `record` the signals are zeros.
    """
    steps = round(TURNS * 2.0 * math.pi / SPEED / STEP)
    columns = [rotor.model.interface.position[name] for name in SIGNALS]
    table = np.zeros((steps, len(columns)))
    begin = time.process_time()
    for n in range(steps):
        rotor.step(n * STEP, STEP)
        if record:
            table[n] = rotor.values[columns]
    return table, (time.process_time() - begin) / (steps * STEP)


def costs_over_substeps(
    formulation: Formulation, reference: Array, substeps: Sequence[float], repeats: int
) -> Iterator[ContactCost]:
    """Yield errors against `reference` and the median cost of `repeats` runs, for each longest substep (s)."""
    for substep in substeps:
        table, _ = simulate(formulation.plant(substep), record=True)
        error = np.max(np.abs(table - reference), axis=0)
        depth = max(float(np.max(np.hypot(table[:, i], table[:, i + 1]))) for i in (0, 2)) - CLEARANCE
        yield ContactCost(
            formulation,
            substep,
            float(np.max(error[:4])) / CLEARANCE,
            float(np.max(error[4:]) / np.max(reference[:, 4:])),
            max(depth, 0.0) / CLEARANCE,
            median(simulate(formulation.plant(substep), record=False)[1] for _ in range(repeats)),
        )


def cheapest(costs: Sequence[ContactCost], error: str, tolerance: float) -> ContactCost | None:
    """Return the least costly run whose `error` is within `tolerance`, if there is one."""
    good = [m for m in costs if getattr(m, error) <= tolerance]
    return min(good, key=lambda m: m.cost, default=None)


def compare(repeats: int = 5) -> dict[str, Any]:
    """Return both comparisons, for JSON; costs are ratios to that of the constraint at the same tolerance."""
    constraint = Formulation("constraint")
    rigid, _ = simulate(constraint.plant(REFERENCE_SUBSTEP), record=True)
    constraint_costs = list(costs_over_substeps(constraint, rigid, SUBSTEPS, repeats))
    by_force = cheapest(constraint_costs, "force_error", FORCE_TOLERANCE)
    by_orbit = cheapest(constraint_costs, "orbit_error", ORBIT_TOLERANCE)
    assert by_force is not None
    assert by_orbit is not None
    laws = []
    for law in classical_laws():
        reference, _ = simulate(law.plant(REFERENCE_SUBSTEP), record=True)
        best = cheapest(list(costs_over_substeps(law, reference, SUBSTEPS, repeats)), "force_error", FORCE_TOLERANCE)
        laws.append(_row(law, best, by_force))
    rising = [m for f in stiff_contacts() for m in costs_over_substeps(f, rigid, SUBSTEPS[:1], repeats)]
    equivalent = cheapest(rising, "orbit_error", ORBIT_TOLERANCE)
    return {
        "case": f"{SPEED:g} rad/s, 25 g m added on D1, {TURNS:g} turns, communication step {STEP * 1e6:g} us",
        "force_tolerance": FORCE_TOLERANCE,
        "orbit_tolerance": ORBIT_TOLERANCE,
        "constraint": [_row(constraint, m, by_orbit) for m in constraint_costs],
        "own_accuracy": laws,
        "rigid_retainer": [_row(m.formulation, m, by_orbit) for m in rising],
        "cost_ratio_at_equal_accuracy": None if equivalent is None else equivalent.cost / by_orbit.cost,
    }


def _row(formulation: Formulation, m: ContactCost | None, base: ContactCost) -> dict[str, Any]:
    row: dict[str, Any] = {"formulation": formulation.label}
    if m is not None:
        row |= {
            "substep_s": m.substep,
            "orbit_error": m.orbit_error,
            "force_error": m.force_error,
            "penetration": m.penetration,
            "cost_ratio": m.cost / base.cost,
        }
    return row


def as_tables(data: Mapping[str, Any]) -> list[Table | str]:
    """Return what `compare` returns as tables and lines of text."""
    ratio = data["cost_ratio_at_equal_accuracy"]
    headline = (
        f"no stiffness tried approximates a rigid retainer within {data['orbit_tolerance']:.0%} of the clearance"
        if ratio is None
        else f"within {data['orbit_tolerance']:.0%} of the clearance of a rigid retainer, the stiff law costs "
        f"{ratio:.1f} times what the constraint costs"
    )
    tolerance = f"{data['force_tolerance']:g} of the peak force"
    return [
        data["case"],
        _table(f"Each law against its own solution with short substeps; cost at {tolerance}", data["own_accuracy"]),
        _table("Against a rigid retainer: the constraint", data["constraint"]),
        _table("Against a rigid retainer: Kelvin-Voigt of rising stiffness", data["rigid_retainer"]),
        headline,
    ]


def _table(title: str, rows: Sequence[Mapping[str, Any]]) -> Table:
    numbers = ("longest substep (us)", "orbit error / c", "force error / peak", "penetration / c", "cost ratio")
    table = labelled_table(title, "contact", *numbers)
    for row in rows:
        if "cost_ratio" not in row:
            table.add_row(row["formulation"], *["-"] * 5)
            continue
        errors = (f"{row[key]:.1e}" for key in ("orbit_error", "force_error", "penetration"))
        table.add_row(row["formulation"], f"{1e6 * row['substep_s']:g}", *errors, f"{row['cost_ratio']:.2f}")
    return table


def draw(data: Mapping[str, Any], path: Path) -> None:
    """Draw deviation from a rigid retainer over cost, for the constraint and for contacts of rising stiffness."""
    figure = StyledFigure(figsize=(6.0, 3.8), layout="constrained")
    axis = figure.subplots()
    kinds = (("constraint", "constraint, shorter substeps", "o", BLUE),)
    for key, label, marker, colour in (*kinds, ("rigid_retainer", "Kelvin-Voigt, rising stiffness", "s", ORANGE)):
        rows = data[key]
        axis.loglog(
            [r["cost_ratio"] for r in rows], [r["orbit_error"] for r in rows], marker, color=colour, label=label
        )
        for row in rows:
            name = row["formulation"].partition("k_c = ")[2] or f"{1e6 * row['substep_s']:.3g} us"
            place = (row["cost_ratio"], row["orbit_error"])
            axis.annotate(name, place, xytext=(6, 4), textcoords="offset points", fontsize=8)
    axis.axhline(data["orbit_tolerance"], color="0.5", lw=0.8, ls="--")
    axis.set(xlabel="cost, constraint at that tolerance = 1", ylabel="largest deviation of the orbit / clearance")
    axis.margins(x=0.2, y=0.15)
    figure.legend(frameon=False, loc="outside upper center", ncols=2, fontsize=8)
    axis.grid(alpha=0.3, which="both", lw=0.4)
    write_png(figure, path)
