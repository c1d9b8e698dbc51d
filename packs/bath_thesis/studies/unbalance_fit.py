"""Study of the rig's residual unbalance, which the thesis does not state, fitted to its measurements before ROLAC acts.

    minimise  sum_k [w_k ln(|sum_i X_ki u_i| / a_k)]^2

u_i is the complex unbalance of disc i, X_ki the synchronous displacement at sensor k per kg m on it, measured by the
controller in a co-simulation of the rig with its signal chain, and a_k the amplitude of Figs 6.6 to 6.10. Angles are
relative to the first disc, because amplitudes do not depend on the instant at which theta = 0.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Annotated, ClassVar

import numpy as np
from scipy.optimize import least_squares

from amb_cosim.cosim.basics.choices import Flavour
from amb_cosim.cosim.run.options import Progress
from amb_cosim.cosim.system.values import Raw
from amb_cosim.presentation.progress import progress_bar
from amb_cosim.presentation.text_tables import TextBlock, labelled_table
from amb_cosim.scenario.scenario import Scenario, load_scenario
from amb_cosim.scenario.simulation import PlannedRun, prepare, run_prepared
from amb_cosim.studies.inputs import Number, positive
from amb_cosim.studies.processes import simulate_in_processes
from amb_cosim.studies.result import DrawnResult
from array_types import Array, Complex

DISCS = ("d1", "d2", "d3", "d4")
TRIAL = 5e-3  # kg m, on one disc at a time
SETTLE = 60.0  # cycles
STARTS = 40  # of each fit; the best one counts
LEAST = 1e-9  # mm; without unbalance there is no logarithm


@dataclass(frozen=True)
class Amplitude:
    """An amplitude (mm) under PID at a sensor, its figure and scenario, and its weight in the fit."""

    figure: str
    scenario: str
    sensor: str
    amplitude: Annotated[float, "mm"]
    weight: float = 1.0


# At 10 Hz the thesis states none; these are the middles, on a logarithmic scale, of the upper halves of the axes of the
# figure. Where the two axes of a plane differ, this is their geometric mean: 0.4 and 0.3, 0.4 and 0.35 mm.
MEASURED = (
    Amplitude("6.6", "fig6_6", "s5", 0.07, 0.5),
    Amplitude("6.6", "fig6_6", "s7", 0.14, 0.5),
    Amplitude("6.8", "fig6_8", "s5", 0.20),
    Amplitude("6.8", "fig6_8", "s7", 0.35),
    Amplitude("6.10", "fig6_10", "s3", 0.346),
    Amplitude("6.10", "fig6_10", "s5", 0.374),
)


@dataclass(frozen=True)
class Fit:
    """The best unbalances of some discs.

    discs
        Their names.
    unbalance, angle
        Unbalance and angle of each disc (kg m, rad).
    amplitudes
        Resulting amplitude at each sensor (mm).
    error
        Root mean square of w ln(ours/theirs).
    """

    discs: tuple[str, ...]
    unbalance: Annotated[tuple[float, ...], "kg.m"]
    angle: Annotated[tuple[float, ...], "rad"]
    amplitudes: Annotated[tuple[float, ...], "mm"]
    error: float


@dataclass(frozen=True, eq=False, repr=False)
class RigUnbalance(DrawnResult):
    """Unbalances of the rig that fit Figs 6.6 to 6.10.

    k_b
        Net stiffness of the closed bearings (N/m).
    measured
        The amplitudes to fit.
    fits
        The best fit with each disc alone, each pair of discs, and all four.
    """

    name: ClassVar[str] = "rig_unbalance"

    k_b: Annotated[float, "N/m"]
    measured: tuple[Amplitude, ...]
    fits: tuple[Fit, ...]

    @property
    def best_pair(self) -> Fit:
        """The best pair of discs."""
        return min((fit for fit in self.fits if len(fit.discs) == 2), key=lambda fit: fit.error)

    def text(self) -> list[TextBlock]:
        """Return a table of the fits and a line that explains it."""
        headings = [f"{m.figure} {m.sensor}" for m in self.measured]
        table = labelled_table(
            f"Unbalance of the rig, K_b = {self.k_b:g} N/m", "discs", "u (g m)", "phi (deg)", *headings, "error"
        )
        table.add_row("thesis (mm)", "", "", *(f"{m.amplitude:g}" for m in self.measured), "")
        for fit in self.fits:
            amounts = ", ".join(f"{1e3 * u:.1f}" for u in fit.unbalance)
            angles = ", ".join(f"{np.degrees(angle):.0f}" for angle in fit.angle)
            result = (f"{a:.3f}" for a in fit.amplitudes)
            table.add_row(" ".join(fit.discs), amounts, angles, *result, f"{fit.error:.3f}")
        return [table, "error: root mean square of ln(ours/theirs); weight 1/2 at 10 Hz"]


@dataclass(frozen=True)
class Trial:
    """A run with unbalance on one disc only."""

    scenario: str
    disc: str
    k_b: float
    flavour: Flavour = "native"


def rig_unbalance(
    k_b: Number = "1e6 N/m", *, flavour: Flavour = "native", progress: bool | Progress | None = None
) -> RigUnbalance:
    """Return unbalances of the rig's discs that fit the amplitudes under PID of Figs 6.6 to 6.10.

    Parameters
    ----------
    k_b
        Net stiffness of the closed bearings (N/m), or a string with its unit.
    flavour
        Flavour of the FMUs.
    progress
        Whether a bar is shown (default in a terminal and a notebook), or a function called with the number of runs done
        and of all runs.

    Raises
    ------
    ValueError
        If `k_b` is not positive, or a run does not reach its end.
    """
    stiffness = positive(k_b, "N/m", "k_b")
    trials = [Trial(name, disc, stiffness, flavour) for name in _scenarios() for disc in DISCS]
    prepare_trial(trials[0])  # checks the input and builds the FMUs before processes are started
    with progress_bar(progress) as report:
        result = dict(zip(trials, simulate_in_processes(simulate_trial, trials, report), strict=True))
    responses = np.array(
        [[result[Trial(m.scenario, disc, stiffness, flavour)][m.sensor] for disc in DISCS] for m in MEASURED]
    )
    chosen = [discs for count in (1, 2, 4) for discs in combinations(range(len(DISCS)), count)]
    return RigUnbalance(stiffness, MEASURED, tuple(fit_unbalances(responses, discs) for discs in chosen))


def prepare_trial(trial: Trial) -> PlannedRun:
    """Return a trial that is ready to run."""
    settings: dict[str, Raw] = {"rolac_controller.*.k_b_?": trial.k_b}
    return prepare(_scenario(trial), settings, flavour=trial.flavour)


def simulate_trial(trial: Trial) -> dict[str, complex]:
    """Return the synchronous displacement at each sensor of the fit for one kg m (m/(kg m)).

    Raises
    ------
    ValueError
        If the run does not reach its end.
    """
    result = run_prepared(prepare_trial(trial))
    if result.outcome.failure is not None:
        raise ValueError(f"{trial.scenario}, unbalance on {trial.disc}: {result.outcome.failure}")

    def last(name: str) -> float:
        return float(result.signals[f"rolac_controller.{name}"].values[-1])

    sensors = sorted({m.sensor for m in MEASURED})
    return {s: last(f"amplitude.{s}") * np.exp(1j * last(f"phase.{s}")) / TRIAL for s in sensors}


def fit_unbalances(responses: Complex, discs: Sequence[int], measured: Sequence[Amplitude] = MEASURED) -> Fit:
    """Return the best fit with the discs of some columns of the responses (m/(kg m)), a row for each amplitude."""
    columns = responses[:, list(discs)]
    stated, weights = (np.array([getattr(m, name) for m in measured]) for name in ("amplitude", "weight"))

    def amplitudes(parts: Array) -> Array:
        u = np.concatenate([[parts[0]], parts[1 : len(discs)] + 1j * parts[len(discs) :]])  # g m; the first is real
        return np.asarray(np.maximum(np.abs(columns @ u), LEAST))

    def errors(parts: Array) -> Array:
        return np.asarray(weights * np.log(amplitudes(parts) / stated))

    rng = np.random.default_rng(0)
    starts = rng.normal(scale=8.0, size=(STARTS, 2 * len(discs) - 1))
    best = min((least_squares(errors, start) for start in starts), key=lambda fit: round(float(fit.cost), 9))
    u = np.concatenate([[best.x[0]], best.x[1 : len(discs)] + 1j * best.x[len(discs) :]])
    return Fit(
        discs=tuple(DISCS[k] for k in discs),
        unbalance=tuple(1e-3 * float(abs(value)) for value in u),
        angle=tuple(float(np.angle(value / u[0])) for value in u),
        amplitudes=tuple(float(a) for a in amplitudes(best.x)),
        error=float(np.sqrt(np.mean(best.fun**2))),
    )


def _scenarios() -> list[str]:
    return list(dict.fromkeys(m.scenario for m in MEASURED))


def _scenario(trial: Trial) -> Scenario:
    """Return the scenario of a figure with unbalance on one disc only, under PID from beginning to end."""
    values: dict[str, Raw] = {f"{disc}.u": TRIAL if disc == trial.disc else 0.0 for disc in DISCS}
    values |= {f"{disc}.phi": 0.0 for disc in DISCS}
    inputs = {"rotor_contact": values, "rolac_controller": {"identify": False}}
    base = load_scenario(trial.scenario)
    return base.changed(inputs=inputs, settle_cycles=SETTLE, end_cycle=5.0).model_copy(update={"event": ()})
