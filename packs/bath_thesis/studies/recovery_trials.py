"""Runs of the recovery study: the scenario of Fig. 5.6 with other controls, rates, H and steps of unbalance."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from amb_analysis.studies.processes import simulate_in_processes
from amb_cosim.cosim.run.options import DEFAULTS, Progress, RunOptions
from amb_cosim.cosim.system.system_tables import Record
from amb_cosim.cosim.system.values import Raw, quantity
from amb_cosim.model_constants.receptance_file import ReceptanceTable
from amb_cosim.results.contact_history import contact_cycles, recovered
from amb_cosim.results.thinned import judged
from amb_cosim.scenario.plan import ScenarioPlan
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.scenario import Scenario, load_scenario
from amb_cosim.scenario.scenario_tables import Event
from amb_cosim.scenario.simulation import execute
from rolac_controller.enumerations import FORCE_FREE, NOTCH, OLAC, OWN_SENSORS, ROLAC

SCENARIO = "fig5_6"
DISC = "d1.u"
END = 60.0  # cycle


@dataclass(frozen=True)
class Control:
    """A control: its name, its settings, whether it adapts at the rate alpha, and whether it uses H."""

    name: str
    settings: Mapping[str, Raw]
    adapts: bool = False
    uses_h: bool = False


AWARE = {"contact.aware": True, "contact.source": OWN_SENSORS}
CONTROLS = (
    Control("PID", {"rolac_enable": False}),
    Control("PID + OLAC", {"rolac.mode": OLAC}, uses_h=True),
    Control("PID + generalised notch", {"rolac.mode": NOTCH}, adapts=True),
    Control("PID + synchronous force rejection", {"rolac.mode": FORCE_FREE}, adapts=True),
    Control("PID + ROLAC", {"rolac.mode": ROLAC}, adapts=True, uses_h=True),
    Control("PID + contact-aware ROLAC", {"rolac.mode": ROLAC, **AWARE}, adapts=True, uses_h=True),
)


@dataclass(frozen=True)
class AdaptedControl:
    """A control, its adaptation rate (1/s), and whether its H is identified in the sampled loop or is the model's."""

    control: Control
    alpha: float
    is_identified: bool = False

    @property
    def label(self) -> str:
        """Name of the control, followed by its rate and the origin of its H, if any."""
        rate = [f"{self.alpha:g} 1/s"] if self.control.adapts else []
        return ", ".join([self.control.name, *rate, *(["H identified"] if self.is_identified else [])])


def adapted_controls(alphas: Sequence[float]) -> list[AdaptedControl]:
    """Return all controls at each rate (1/s), both with H of the model and with identified H."""
    return [
        AdaptedControl(control, alpha, is_identified)
        for control in CONTROLS
        for alpha in (alphas if control.adapts else alphas[:1])
        for is_identified in ((False, True) if control.uses_h else (False,))
    ]


@dataclass(frozen=True)
class RecoveryTrial:
    """One run: control, unbalance (kg m) added on D1 before the scenario's factor applies, and cycle of the step.

    `table` contains the receptances that were identified in the sampled loop, if the control uses them.
    """

    control: AdaptedControl
    added: float
    cycle: float
    table: ReceptanceTable | None = None
    options: RunOptions = DEFAULTS


@dataclass(frozen=True)
class TrialRow:
    """Result of a trial: cycle of the step, whether the rotor recovered, and cycles until the last contact."""

    disturbance_cycle: float
    recovered: bool
    cycles: float


def simulate_all(trials: Sequence[RecoveryTrial], progress: Progress) -> list[TrialRow]:
    """Simulate trials in parallel, with one process per processor, and return their results.

    Raises
    ------
    ValueError
        If a trial cannot be run, or does not reach its end.
    """
    for trial in {
        trial.control.label: trial for trial in trials
    }.values():  # one for each control, the largest unbalance
        prepare_trial(trial)  # checks the input and builds the FMUs before processes are started
    return simulate_in_processes(simulate_trial, trials, progress)


def simulate_trial(trial: RecoveryTrial) -> TrialRow:
    """Simulate one trial and return its result.

    Raises
    ------
    ValueError
        If the run does not reach its end.
    """
    result = execute(prepare_trial(trial), trial.options)
    if result.outcome.failure is not None:
        raise ValueError(f"{trial.control.label}, {trial.added:g} kg m added: {result.outcome.failure}")
    signals = judged(result.signals)
    return row_of(trial, bool(recovered(signals)), contact_cycles(signals)[1])


def row_of(trial: RecoveryTrial, is_free: bool, last: float | None) -> TrialRow:
    """Return the result of a trial whose last contact is in cycle `last`, or None if there was no contact."""
    return TrialRow(trial.cycle, is_free, max(0.0, (last or 0.0) - trial.cycle))


def prepare_trial(trial: RecoveryTrial) -> ScenarioPlan:
    """Return a trial that is ready to run."""
    settings = {"rolac.alpha": trial.control.alpha, **trial.control.control.settings}
    named = {f"rolac_controller.{name}": value for name, value in settings.items()}
    return prepare_run(trial_scenario(trial), named, options=trial.options)


def trial_scenario(trial: RecoveryTrial) -> Scenario:
    """Return the scenario of Fig. 5.6 with another step; every sample of the contact state is recorded."""
    base = load_scenario(SCENARIO)
    before = quantity(base.inputs["rotor_contact"][DISC], "kg.m", DISC)
    step = Event(
        label="step", role="disturbance", cycle=trial.cycle, set={"rotor_contact": {DISC: before + trial.added}}
    )
    record = Record(variables=("rotor_contact.contact_state",))
    changes = {"event": (step,), "end_cycle": END, "record": record}
    return base.model_copy(update=changes | ({"receptances": trial.table} if trial.control.is_identified else {}))
