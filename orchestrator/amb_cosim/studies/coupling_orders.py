"""What the order of a master and its communication step do to a run: a levitated rotor that touches and recovers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated

from amb_cosim.contact_history import recovery
from amb_cosim.cosim.choices import Coupling, Flavour
from amb_cosim.cosim.system_tables import Record
from amb_cosim.coupling import DELAY_STEPS
from amb_cosim.orbits import orbit_before
from amb_cosim.scenario import load_scenario
from amb_cosim.simulation import prepare, run_prepared

SCENARIO = "fig4_9"
RECORDED = Record(variables=("rotor_contact.mb?.?", "rotor_contact.contact_state"))


@dataclass(frozen=True)
class Run:
    """An order of the master, a communication step (s), and whether the controller predicts its displacements."""

    coupling: Coupling
    step: float
    predicts: bool = False

    @property
    def name(self) -> str:
        """Name of the order."""
        names = {"gauss_seidel": "Gauss-Seidel", "jacobi": "Jacobi", "iterative": "iterative"}
        return names[self.coupling] + (", predicting" if self.predicts else "")


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
        How the run ended, and its last contact.
    cost
        Time that it took over that of the first run (1).
    """

    order: str
    step: Annotated[float, "s"]
    orbit: Annotated[dict[str, float], "mm"]
    deviation: float
    outcome: str
    cost: float


REFERENCE = Run("gauss_seidel", 250e-6)
RUNS = (
    REFERENCE,
    *(Run("jacobi", step) for step in (250e-6, 125e-6, 50e-6, 25e-6, 10e-6)),
    *(Run("jacobi", step, predicts=True) for step in (250e-6, 125e-6, 50e-6)),
)


def simulated(run: Run, flavour: Flavour = "native") -> tuple[dict[str, float], str, float]:
    """Return the orbits before the step of unbalance (mm), the outcome, and the time that the run took (s)."""
    settings = {"rolac_controller.prediction_time": DELAY_STEPS * run.step} if run.predicts else None
    base = load_scenario(SCENARIO)
    scenario = base.model_copy(
        update={"coupling": run.coupling, "communication_step": run.step, "record": RECORDED},
    )
    result = run_prepared(prepare(scenario, settings, flavour=flavour))
    orbits = {at: radius for at, radius in orbit_before(result.signals).items() if radius is not None}
    failed = result.outcome.failure
    return orbits, failed or str(recovery(result.signals)), float(result.signals.attrs["wall_s"])


def compared(flavour: Flavour = "native") -> tuple[OrderRow, ...]:
    """Return the runs, each beside the first."""
    rows: list[OrderRow] = []
    first: tuple[Mapping[str, float], float] | None = None
    for run in RUNS:
        orbit, outcome, wall = simulated(run, flavour)
        first = first or (orbit, wall)
        deviation = max((abs(radius / first[0][at] - 1.0) for at, radius in orbit.items()), default=float("inf"))
        rows.append(OrderRow(run.name, run.step, orbit, deviation, outcome, wall / first[1]))
    return tuple(rows)
