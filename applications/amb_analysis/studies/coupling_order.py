"""Study of the effect of the master's order and communication step on a run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, ClassVar

from amb_analysis.studies.result import DrawnResult, WarnedResult
from amb_cosim.cosim.choices import Coupling, Flavour, Loop
from amb_cosim.cosim.run.options import RunOptions
from amb_cosim.cosim.system.system_tables import Record
from amb_cosim.cosim.system.values import Raw
from amb_cosim.presentation.descriptions import name_label
from amb_cosim.presentation.text_tables import TextBlock, labelled_table, number
from amb_cosim.results.contact_history import contact_cycles, recovery
from amb_cosim.results.orbits import orbit_after, orbit_before
from amb_cosim.results.thinned import judged
from amb_cosim.scenario.coupling import delay, predictable
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.scenario import Scenario, as_scenario
from amb_cosim.scenario.simulation import execute

TIMINGS = 3  # of each run; the cost is that of the shortest
NAMES: Mapping[Coupling, str] = {"gauss_seidel": "Gauss-Seidel", "jacobi": "Jacobi", "iterative": "iterative"}


@dataclass(frozen=True)
class CouplingRun:
    """Order and loop of the master, divisor of the scenario's step, and whether the controller uses a prediction."""

    coupling: Coupling
    parts: int
    predicts: bool = False
    loop: Loop = "compiled"

    @property
    def name(self) -> str:
        """Name of the order, which mentions the prediction and the plain loop if they are used."""
        return NAMES[self.coupling] + ", predicting" * self.predicts + ", plain loop" * (self.loop == "plain")


@dataclass(frozen=True)
class OrderRow:
    """A run.

    order, step
        Name of the order, and communication step (s).
    orbit
        Largest radius at each bearing in the cycle before the scenario's step change, or in the last cycle (mm).
    deviation
        Largest relative difference (1) between an orbit and the same orbit in the first run.
    outcome
        Outcome of the step change, or of the run if there is no step change, or the reason for an early end.
    last_contact
        Cycle of the last contact; None if there is none.
    cost
        Run time relative to the first run (1).
    """

    order: str
    step: Annotated[float, "s"]
    orbit: Annotated[dict[str, float], "mm"]
    deviation: float
    outcome: str
    last_contact: float | None
    cost: float


@dataclass(frozen=True, eq=False, repr=False)
class CouplingOrders(WarnedResult, DrawnResult):
    """Runs of a scenario with several orders and steps of the master, each compared with the first run."""

    name: ClassVar[str] = "coupling"

    scenario: str
    rows: tuple[OrderRow, ...]

    def text(self) -> list[TextBlock]:
        """Return a table of the runs by order and step."""
        places = [f"{name_label(at)} (mm)" for at in self.rows[0].orbit]
        columns = ("step (us)", *places, "deviation (%)", "outcome", "last contact (cycle)", "cost")
        title = f"{self.scenario}: orbit before the scenario's step, or at the end; outcome and cost"
        table = labelled_table(title, "order", *columns)
        for row in self.rows:
            orbits = map(number, row.orbit.values())
            last = "-" if row.last_contact is None else f"{row.last_contact:.1f}"
            other_cells = (f"{100.0 * row.deviation:.1f}", row.outcome, last, f"{row.cost:.1f}")
            table.add_row(row.order, f"{1e6 * row.step:g}", *orbits, *other_cells)
        return [table, *self.warning_lines()]


RUNS = (
    *(CouplingRun("gauss_seidel", parts) for parts in (1, 5)),
    *(CouplingRun("jacobi", parts) for parts in (1, 2, 5, 10, 25)),
    *(CouplingRun("jacobi", parts, predicts=True) for parts in (1, 2, 5, 10)),
    CouplingRun("gauss_seidel", 1, loop="plain"),
    CouplingRun("iterative", 1, loop="plain"),
)


def coupling(
    scenario: str | Path | Scenario | None = None,
    *,
    rotor: str | Path | None = None,
    set: Mapping[str, Raw] | None = None,
    flavour: Flavour = "native",
) -> CouplingOrders:
    """Return the orbit, outcome and cost of a scenario for each order and communication step of the master.

    Parameters
    ----------
    scenario
        A `Scenario`, the name of a packaged scenario, or a TOML file; by default the packs' default scenario. The
        study compares the scenario's communication step and fractions of it.
    rotor
        Name of a packaged rotor, or a rotor file, to use instead of the scenario's.
    set
        Values by `component.variable` that replace the scenario's.
    flavour
        Flavour of the FMUs.

    Raises
    ------
    ValueError
        If the scenario, a value or a file is invalid, or if the first run has no orbit.
    """
    values = as_scenario(scenario, rotor).model_copy(update={"record": Record()})
    options = RunOptions(flavour=flavour)
    prepared = prepare_run(values, set, options=options)
    runs = [run for run in RUNS if not run.predicts or predictable(prepared.interfaces)]
    result = [simulated(run, values, set or {}, options) for run in runs]
    first, shortest = result[0]
    if not first.orbit or not all(first.orbit.values()):
        raise ValueError(
            f"scenario {values.name}: the rotor does not move in the cycle whose orbit is compared; {first.outcome}"
        )
    rows = (replace(row, deviation=_deviation(row, first), cost=wall / shortest) for row, wall in result)
    return CouplingOrders(values.name, tuple(rows), warnings=prepared.warnings)


def simulated(
    run: CouplingRun, scenario: Scenario, settings: Mapping[str, Raw], options: RunOptions
) -> tuple[OrderRow, float]:
    """Return the row of a run, with deviation and cost not yet computed (0), and the shortest of its run times (s)."""
    step = scenario.step_size("gauss_seidel") / run.parts
    changed = scenario.model_copy(update={"coupling": run.coupling, "communication_step": step})
    ahead = delay(run.coupling, step) if run.predicts else 0.0
    names = predictable(prepare_run(changed, settings, options=options).interfaces)
    prepared = prepare_run(changed, {**settings, **dict.fromkeys(names, ahead)}, options=options)
    results = [execute(prepared, replace(options, loop=run.loop)) for _ in range(TIMINGS)]
    if any(result.outcome.status == "interrupted" for result in results):
        raise KeyboardInterrupt
    signals, outcome = judged(results[0].signals), results[0].outcome
    radii = orbit_before(signals) if "disturbance_cycle" in signals.attrs else orbit_after(signals)
    orbits = {at: radius for at, radius in radii.items() if radius is not None}
    ending = outcome.failure or recovery(signals) or outcome.status
    row = OrderRow(run.name, step, orbits, 0.0, ending, contact_cycles(signals)[1], 0.0)
    return row, min(float(result.signals.attrs["wall_s"]) for result in results)


def _deviation(row: OrderRow, first: OrderRow) -> float:
    return max((abs(row.orbit[at] / r - 1.0) for at, r in first.orbit.items() if at in row.orbit), default=1.0)
