"""Study that identifies the receptances of the levitated rotor at several spin speeds and stores them in a table."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, NamedTuple

import numpy as np

from amb_analysis.studies.inputs import Number, spin_speeds
from amb_analysis.studies.receptance_measurement import (
    IdentifiedReceptance,
    computed_identification,
    prepare_identification,
    ratios,
    run_identification,
    table_for,
)
from amb_analysis.studies.result import WarnedResult
from amb_cosim.cosim.choices import Flavour
from amb_cosim.cosim.errors import Interrupted
from amb_cosim.cosim.run.options import RunOptions
from amb_cosim.cosim.system.values import Raw
from amb_cosim.model_constants.controller_data import SPEEDS, condition_number
from amb_cosim.model_constants.receptance_file import ReceptanceTable
from amb_cosim.presentation.json_data import Layout
from amb_cosim.presentation.plain_console import plain_console
from amb_cosim.presentation.progress import STARTING, bars
from amb_cosim.presentation.text_tables import TextBlock, number, text_table
from amb_cosim.presentation.units import speed_unit
from amb_cosim.scenario.rotors import RotorSource
from amb_cosim.scenario.scenario import Scenario, as_scenario

HEADINGS = ("periods", "force (N)", "condition number", "differs from the model (%)", "")


class IdentificationProgress(NamedTuple):
    """Progress of an identification: spin speed (rad/s), and numbers of finished and total speeds and steps."""

    speed: float
    speeds_done: int
    speeds_total: int
    steps_done: int
    steps_total: int


Report = Callable[[IdentificationProgress], None]


@dataclass(frozen=True, eq=False, repr=False)
class Identification(WarnedResult):
    """Receptances identified at several speeds.

    speeds
        Requested spin speeds (rad/s).
    results
        Result at each speed. If Ctrl-C interrupted the study, there are fewer results than speeds.
    table
        Table of the receptances that were identified now or were already in the file.
    """

    speeds: Annotated[tuple[float, ...], "rad/s"]
    results: tuple[IdentifiedReceptance, ...]
    table: Annotated[ReceptanceTable, Layout.OMITTED]

    @property
    def identified(self) -> int:
        """Number of speeds at which the identification succeeded."""
        return sum(result.receptance is not None for result in self.results)

    @property
    def interruption(self) -> str:
        """Reason for an early end of the study; otherwise empty."""
        last = self.results[-1]
        return last.reason if last.interrupted else ""

    def text(self) -> list[TextBlock]:
        """Return a table with a row for each speed."""
        table = text_table("Identification", (f"speed ({speed_unit().label})", *HEADINGS), left=("",))
        for result in self.results:
            condition, difference, outcome = "-", "-", result.reason or "done"
            if result.receptance is not None:
                condition = f"{condition_number(result.receptance):.3f}"
                if result.model is None:
                    outcome = "computed, not compared"
                else:
                    difference = f"{100.0 * np.abs(ratios(result.receptance, result.model) - 1.0).max():.2g}"
            numbers = speed_unit().number(2.0 * np.pi * result.frequency, 6), str(result.periods), number(result.force)
            table.add_row(*numbers, condition, difference, outcome)
        return [table, *self.warning_lines()]


def identify(
    speeds: str | Sequence[Number] | None = None,
    *,
    output: Path | str | None = None,
    scenario: Scenario | Path | str | None = None,
    rotor: RotorSource = None,
    set: Mapping[str, Raw] | None = None,
    flavour: Flavour = "native",
    computed: bool = False,
    progress: bool | Report | None = None,
) -> Identification:
    """Return the receptances of the levitated rotor, as its controller identifies them in co-simulations.

    These receptances describe the loop with all its controllers, including a linear controller in an inner loop of the
    synchronous control.

    Ctrl-C ends the study; the result then contains the finished speeds.

    Parameters
    ----------
    speeds
        Spin speeds (rad/s), each a number or a string with its unit, or one string separated by commas; by default
        twelve from 5 to 35 Hz.
    output
        Table file (TOML), which is written after each speed; its receptances for other speeds are kept.
    scenario
        A scenario, the name of a packaged scenario, or a TOML file, that defines the machine and its parameters. The
        default is the packs' default rotor with the start values of the FMUs.
    rotor
        Name of a packaged rotor, or a rotor file, to use instead of the scenario's.
    set
        Values by `component.variable`, numbers or strings with units.
    flavour
        Flavour of the FMUs.
    computed
        Whether to compute the receptances from the linear model of the sampled loop instead of co-simulations.
        Identified receptances are compared with this model. Computed receptances come from this model, so they cannot
        be compared with it.
    progress
        Whether to display bars (default in a terminal and a notebook), or a function that is called repeatedly with an
        `IdentificationProgress`.

    Raises
    ------
    ValueError
        If an argument is not allowed, or the table in the file belongs to another rotor or control loop.
    Interrupted
        If Ctrl-C ends it. This is a KeyboardInterrupt; its attribute `result` has the speeds until then.

    Examples
    --------
    >>> result = identify("9000 rpm", scenario="compressor_levitated", computed=True)
    >>> result.table.entries[0].receptance.shape  # sensors, axes
    (6, 4)
    """
    chosen_speeds = SPEEDS if speeds is None else spin_speeds(speeds)
    base = None if scenario is None else as_scenario(scenario)
    path = None if output is None else Path(output)
    results: list[IdentifiedReceptance] = []
    with _progress_bars(progress) as report:
        runs = [prepare_identification(Omega, rotor, set, RunOptions(flavour=flavour), base) for Omega in chosen_speeds]
        table = table_for(runs[0], path)
        for machine in runs:

            def report_steps(done: int, total: int, speed: float = machine.Omega) -> None:
                report(IdentificationProgress(speed, len(results), len(runs), done, total))

            result = computed_identification(machine) if computed else run_identification(machine, report_steps)
            results.append(result)
            if result.receptance is not None:
                table = table.updated(result.speed, result.receptance, result.order, result.inner)
                if path is not None:
                    table.write(path)
            if result.interrupted:
                break
    warnings = dict.fromkeys(sentence for machine in runs for sentence in machine.prepared.warnings)
    identification = Identification(tuple(chosen_speeds), tuple(results), table, warnings=tuple(warnings))
    if identification.interruption:
        raise Interrupted(identification.interruption, identification)
    return identification


@contextmanager
def _progress_bars(progress: bool | Report | None) -> Iterator[Report]:
    """Yield `progress` if it is a function, otherwise a function that updates bars for all speeds and this speed."""
    if callable(progress):
        yield progress
        return
    with bars(plain_console(stderr=True), progress) as two_bars:
        all_speeds, this_speed = (
            two_bars.add_task("speeds", total=None),
            two_bars.add_task(STARTING, total=None),
        )

        def show(now: IdentificationProgress) -> None:
            two_bars.update(all_speeds, completed=now.speeds_done, total=now.speeds_total)
            label = f"{now.speed / (2.0 * math.pi):.4g} Hz"
            two_bars.update(this_speed, description=label, completed=now.steps_done, total=now.steps_total)

        yield show
