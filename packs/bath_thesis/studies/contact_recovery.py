"""Study of which controls free a rotor from contact after a step of unbalance, and of their limits.

The rotor, its speed (16 Hz) and the unbalance factor are taken from Fig. 5.6, with unbalance added on D1. Adaptive
controls are tried at each adaptation rate, with H of the rotor model and with H identified in the sampled loop. For
each control and added unbalance, the trials differ only in the instant of the step. Rotor, bearings and retainers are
isotropic, so the instant matters only because of sampling and current limits. If only some of the trials recover, the
unbalance is close to the limit of the control.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from statistics import median
from typing import Annotated, ClassVar

from amb_analysis.studies.inputs import Number, positive
from amb_analysis.studies.receptance_identification import identify
from amb_analysis.studies.result import DrawnResult
from amb_cosim.cosim.choices import FLAVOURS, Flavour
from amb_cosim.cosim.run.options import Progress, RunOptions
from amb_cosim.cosim.system.values import quantity
from amb_cosim.presentation.progress import progress_bar
from amb_cosim.presentation.text_tables import TextBlock, labelled_table
from amb_cosim.presentation.units import SIZES, speed_unit
from amb_cosim.scenario.scenario import load_scenario
from amb_files.checks import require, require_choice
from amb_files.plain_values import listed
from bath_thesis.studies.recovery_trials import (
    END,
    SCENARIO,
    RecoveryTrial,
    TrialRow,
    adapted_controls,
    simulate_all,
)

FIRST_STEP = 5.0  # cycle
UNIT = "kg.m"
NUMBER = re.compile(r"[+-]?[\d.]+(?:[eE][+-]?\d+)?")


@dataclass(frozen=True)
class RecoveryStatistics:
    """Trials of one control with one added unbalance.

    recovered_share
        Share of the trials that end free of contact (1).
    median_cycles
        Median number of cycles from the step to the last contact in the trials that recover. The median is 0 without
        contact, and None if no trial recovers.
    runs
        Each trial.
    """

    recovered_share: float
    median_cycles: float | None
    runs: tuple[TrialRow, ...]


@dataclass(frozen=True, eq=False, repr=False)
class ControlComparison(DrawnResult):
    """Recovery from contact, by control and added unbalance.

    scenario
        Name of the varied scenario.
    spin_frequency
        Spin frequency (Hz).
    unbalance_factor
        Factor by which all unbalances of the scenario are multiplied (1).
    alphas
        Adaptation rates (1/s).
    end_cycle
        Cycle at which the runs end.
    instants
        Number of instants at which the step is tried.
    added
        Unbalances added on D1 (kg m), before multiplication by the factor, ascending.
    controls
        Statistics for each added unbalance, by the label of the control, which states its rate and the origin of its H.
    """

    name: ClassVar[str] = "recovery"
    renamed: ClassVar[Mapping[str, str]] = {"speed": "`spin_frequency`, in Hz"}

    scenario: str
    spin_frequency: Annotated[float, "Hz"]
    unbalance_factor: float
    alphas: Annotated[tuple[float, ...], "1/s"]
    end_cycle: float
    instants: int
    added: Annotated[tuple[float, ...], "kg.m"]
    controls: dict[str, tuple[RecoveryStatistics, ...]]

    def text(self) -> list[TextBlock]:
        """Return a table of shares and durations, and lines that explain it."""
        at = speed_unit().text(SIZES["speed"]["Hz"] * self.spin_frequency)
        title = f"Recovery at {at}; unbalance added on D1 (g m)"
        table = labelled_table(title, "control", *(f"{1e3 * added:g}" for added in self.added))
        for control, cells in self.controls.items():
            table.add_row(control, *(_cell(cell) for cell in cells))
        return [
            table,
            f"share of the runs that are free of contact at cycle {self.end_cycle:g} (%), and the median number of "
            "cycles from the step to their last contact",
            f"all unbalances are multiplied by {self.unbalance_factor:g}; number of instants of the step: "
            f"{self.instants}; H comes from the rotor model unless it is identified in the sampled loop",
        ]


def _cell(cell: RecoveryStatistics) -> str:
    """Return the share (%) and the duration (cycles) as text."""
    share = f"{100.0 * cell.recovered_share:.0f}"
    return share if cell.median_cycles is None else f"{share}, {cell.median_cycles:.1f}"


def recovery(
    steps: str | Sequence[Number] = "12,16,18,20,22,24,28,32,36,40,44,48 g.m",
    *,
    instants: int = 5,
    alpha: str | Number | Sequence[Number] = "3.5,7 1/s",
    flavour: Flavour = "native",
    progress: bool | Progress | None = None,
) -> ControlComparison:
    """Return the share of runs that end free of contact, and the time to recovery, by control and unbalance.

    Parameters
    ----------
    steps
        Unbalances added on D1 (kg m), before multiplication by the scenario's factor, or a comma-separated string with
        units.
    instants
        Number of instants within a revolution at which the step is tried. Avoid multiples of four, because steps a
        quarter of a revolution apart cause the same motion, turned by a right angle.
    alpha
        Adaptation rates (1/s) on the amplitude, or a comma-separated string with units; (5.22) applies 7 1/s to half of
        the amplitude.
    flavour
        Flavour of the FMUs.
    progress
        Whether to show a bar (default in a terminal and a notebook), or a function that is called with the number of
        finished runs and the number of all runs.

    Raises
    ------
    ValueError
        If an argument is out of range, or a run does not reach its end.
    """
    require_choice("flavour", flavour, FLAVOURS)
    require(1 <= instants <= 1000, "instants", instants, "from 1 to 1000")
    alphas = [quantity(value, "1/s", "alpha") for value in listed_values(alpha)]
    for value in alphas:
        require(value >= 0.0, "alpha", f"{value:g} 1/s", ">= 0 1/s")
    added = unbalances(steps)
    options, scenario = RunOptions(flavour=flavour), load_scenario(SCENARIO)
    controls = adapted_controls(alphas)
    table = identify([scenario.initial_speed], scenario=scenario, flavour=flavour, progress=False).table
    trials = [
        RecoveryTrial(control, u, FIRST_STEP + k / instants, table if control.is_identified else None, options)
        for control in controls
        for u in added
        for k in range(instants)
    ]
    with progress_bar(progress) as report:
        rows = simulate_all(trials, report)
    remaining_rows = iter(rows)
    return ControlComparison(
        scenario=SCENARIO,
        spin_frequency=quantity(scenario.Omega, "Hz", "Omega"),
        unbalance_factor=scenario.unbalance_factor,
        alphas=tuple(alphas),
        end_cycle=END,
        instants=instants,
        added=tuple(added),
        controls={
            control.label: tuple(_statistics(tuple(next(remaining_rows) for _ in range(instants))) for _ in added)
            for control in controls
        },
    )


def unbalances(raw: str | Sequence[Number]) -> list[float]:
    """Return unbalances (kg m), ascending, from a sequence or a comma-separated string.

    In a string such as `8,12,16 g.m`, the last unit applies to all numbers without a unit.

    Raises
    ------
    ValueError
        If one of the values is not a positive unbalance.
    """
    return sorted({positive(value, UNIT, "steps") for value in listed_values(raw)})


def listed_values(raw: str | Number | Sequence[Number]) -> Sequence[Number]:
    """Return the values of a sequence, a single value or a comma-separated string, whose last unit applies to all."""
    if not isinstance(raw, str):
        return listed(raw)
    parts = [part.strip() for part in raw.split(",")]
    unit = NUMBER.sub("", parts[-1], count=1)
    return [f"{part} {unit}" if NUMBER.fullmatch(part) else part for part in parts]


def _statistics(rows: tuple[TrialRow, ...]) -> RecoveryStatistics:
    """Return the statistics of all trials of one control with one unbalance."""
    durations = [row.cycles for row in rows if row.recovered]
    return RecoveryStatistics(len(durations) / len(rows), median(durations) if durations else None, rows)
