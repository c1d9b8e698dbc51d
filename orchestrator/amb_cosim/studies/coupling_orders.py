"""What the order of a master and its communication step do to a run: a levitated rotor that touches and recovers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Annotated

from amb_cosim.cosim.choices import Coupling, Flavour, Loop
from amb_cosim.cosim.system_tables import Record
from amb_cosim.results.contact_history import contact_cycles, recovery
from amb_cosim.results.orbits import orbit_before
from amb_cosim.scenario.coupling import PREDICTION, delay
from amb_cosim.scenario.scenario import load_scenario
from amb_cosim.scenario.simulation import prepare, run_prepared

RECORDED = Record(variables=("rotor_contact.mb?.?", "rotor_contact.contact_state"))
TIMINGS = 3  # of each run; the shortest counts
NAMES: Mapping[Coupling, str] = {"gauss_seidel": "Gauss-Seidel", "jacobi": "Jacobi", "iterative": "iterative"}


@dataclass(frozen=True)
class CouplingRun:
    """Order and loop of the master, communication step (s), and whether the controller predicts its displacements."""

    coupling: Coupling
    step: float
    predicts: bool = False
    loop: Loop = "compiled"

    @property
    def name(self) -> str:
        """Name of the order."""
        return NAMES[self.coupling] + ", predicting" * self.predicts + ", plain loop" * (self.loop == "plain")


@dataclass(frozen=True)
class OrderRow:
    """A run.

    order, step
        Name of the order; communication step (s).
    orbit
        Largest radius at each bearing in the cycle before the step of unbalance (mm).
    deviation
        Largest difference of one of them from the first run's, as a share of that (1).
    outcome
        What the step of unbalance led to, or why the run ended before its time.
    last_contact
        Cycle of the last contact; None without one.
    cost
        Time of the run over that of the first (1).
    """

    order: str
    step: Annotated[float, "s"]
    orbit: Annotated[dict[str, float], "mm"]
    deviation: float
    outcome: str
    last_contact: float | None
    cost: float


RUNS = (
    CouplingRun("gauss_seidel", 250e-6),
    *(CouplingRun("jacobi", step) for step in (250e-6, 125e-6, 50e-6, 25e-6, 10e-6)),
    *(CouplingRun("jacobi", step, predicts=True) for step in (250e-6, 125e-6, 50e-6, 25e-6)),
    CouplingRun("gauss_seidel", 250e-6, loop="plain"),
    CouplingRun("iterative", 250e-6, loop="plain"),
)


def simulated(run: CouplingRun, flavour: Flavour = "native") -> tuple[OrderRow, float]:
    """Return a run, with deviation and cost left at 0, and the shortest time that it took (s)."""
    settings = {f"rolac_controller.{PREDICTION}": delay(run.coupling, run.step) if run.predicts else 0.0}
    own = {"coupling": run.coupling, "communication_step": run.step, "record": RECORDED}
    prepared = prepare(load_scenario().model_copy(update=own), settings, flavour=flavour)
    results = [run_prepared(prepared, loop=run.loop) for _ in range(TIMINGS)]
    if any(result.outcome.status == "interrupted" for result in results):
        raise KeyboardInterrupt
    signals, failed = results[0].signals, results[0].outcome.failure
    orbits = {at: radius for at, radius in orbit_before(signals).items() if radius is not None}
    row = OrderRow(run.name, run.step, orbits, 0.0, failed or str(recovery(signals)), contact_cycles(signals)[1], 0.0)
    return row, min(float(result.signals.attrs["wall_s"]) for result in results)


def compared(runs: Sequence[CouplingRun] = RUNS, flavour: Flavour = "native") -> tuple[OrderRow, ...]:
    """Return the runs, each beside the first."""
    found = [simulated(run, flavour) for run in runs]
    first, shortest = found[0]
    return tuple(
        replace(row, deviation=max(abs(row.orbit[at] / r - 1.0) for at, r in first.orbit.items()), cost=wall / shortest)
        for row, wall in found
    )
