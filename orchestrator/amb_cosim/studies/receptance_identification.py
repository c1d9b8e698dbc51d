"""Study that identifies the receptances of the levitated rotor over the spin speed, and keeps them in a table."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, NamedTuple

import numpy as np
from rich.console import Console

from amb_cosim.cosim.basics.choices import Flavour
from amb_cosim.cosim.system.values import Raw
from amb_cosim.design.controller_data import SPEEDS, condition_number
from amb_cosim.design.receptance_file import ReceptanceTable
from amb_cosim.presentation.json_data import Layout
from amb_cosim.presentation.progress import STARTING, bars
from amb_cosim.presentation.text_tables import TextPart, text_table
from amb_cosim.scenario.scenario import Scenario, load_scenario
from amb_cosim.studies.inputs import Number, spin_speeds
from amb_cosim.studies.receptance_measurement import (
    IdentifiedReceptance,
    computed_identification,
    prepare_identification,
    ratios,
    run_identification,
    table_for,
)
from amb_cosim.studies.result import StudyResult

HEADINGS = ("speed (Hz)", "periods", "force (N)", "condition number", "differs from the model (%)", "")


class IdentificationProgress(NamedTuple):
    """Progress of an identification: its spin speed (rad/s), speeds done and in total, steps done and in total."""

    speed: float
    speeds_done: int
    speeds_total: int
    steps_done: int
    steps_total: int


Report = Callable[[IdentificationProgress], None]


@dataclass(frozen=True, eq=False, repr=False)
class Identification(StudyResult):
    """Receptances identified at several speeds.

    speeds
        Spin speeds that were requested (rad/s).
    results
        Result at each speed; fewer than speeds if Ctrl-C interrupted the study.
    table
        Table of the receptances: those identified now, and those that the table held before.
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
        """Reason why the study ended before its last speed; empty if it did not."""
        last = self.results[-1]
        return last.reason if last.interrupted else ""

    def text(self) -> list[TextPart]:
        """Return a table with a row for each speed."""
        table = text_table("Identification", HEADINGS, left=("",))
        for result in self.results:
            condition, difference, outcome = "-", "-", result.reason or "done"
            if result.receptance is not None:
                condition = f"{condition_number(result.receptance):.3f}"
                if result.model is None:
                    outcome = "computed, not compared"
                else:
                    difference = f"{100.0 * np.abs(ratios(result.receptance, result.model) - 1.0).max():.2g}"
            numbers = f"{result.frequency:.6g}", str(result.periods), f"{result.force:.1f}"
            table.add_row(*numbers, condition, difference, outcome)
        return [table]


def identify(
    speeds: str | Sequence[Number] | None = None,
    *,
    output: Path | str | None = None,
    scenario: Scenario | Path | str | None = None,
    rotor: Path | str | None = None,
    set: Mapping[str, Raw] | None = None,
    flavour: Flavour = "native",
    computed: bool = False,
    progress: bool | Report | None = None,
) -> Identification:
    """Return the receptances of the levitated rotor, as its controller identifies them in co-simulations.

    They are those of the loop with all its controllers, a linear one beneath the synchronous control too.

    Ctrl-C ends the study; the result then holds the speeds before.

    Parameters
    ----------
    speeds
        Spin speeds (rad/s), each a number or a text with its unit, or one text with commas; by default twelve from
        5 to 35 Hz.
    output
        Table file (TOML), written after each speed; the receptances that it holds for other speeds are kept.
    scenario
        A scenario, the name of one of a pack, or a TOML file, whose machine and parameters are taken; the packs'
        default rotor with the start values of the FMUs without.
    rotor
        Name of a rotor of a pack, or rotor file, in place of the scenario's.
    set
        Values by `component.variable`, numbers or texts with units.
    flavour
        Flavour of the FMUs.
    computed
        Whether they come from the linear model of the sampled loop, in place of co-simulations, which the others are
        compared with; nothing else is independent of it.
    progress
        Whether bars are shown (by default in a terminal and in a notebook), or a function that is called now and then
        with an `IdentificationProgress`.

    Raises
    ------
    ValueError
        If an argument is not allowed, or the table in the file belongs to another rotor or control loop.
    """
    chosen = SPEEDS if speeds is None else spin_speeds(speeds)
    machine = scenario if isinstance(scenario, Scenario | None) else load_scenario(str(scenario))
    path = None if output is None else Path(output)
    results: list[IdentifiedReceptance] = []
    with _progress_bars(progress) as report:
        runs = [prepare_identification(Omega, rotor, set, flavour, machine) for Omega in chosen]
        table = table_for(runs[0], path)
        for prepared in runs:

            def report_steps(done: int, total: int, speed: float = prepared.plan.speed) -> None:
                report(IdentificationProgress(speed, len(results), len(runs), done, total))

            result = computed_identification(prepared) if computed else run_identification(prepared, report_steps)
            results.append(result)
            if result.receptance is not None:
                table = table.updated(result.speed, result.receptance, result.order, result.inner)
                if path is not None:
                    table.write(path)
            if result.interrupted:
                break
    return Identification(tuple(chosen), tuple(results), table)


@contextmanager
def _progress_bars(progress: bool | Report | None) -> Iterator[Report]:
    """Yield the function `progress`, or one that shows two bars: all speeds, and the speed that is simulated."""
    if callable(progress):
        yield progress
        return
    with bars(Console(stderr=True), progress) as displayed:
        all_speeds, this_speed = displayed.add_task("speeds", total=None), displayed.add_task(STARTING, total=None)

        def show(now: IdentificationProgress) -> None:
            displayed.update(all_speeds, completed=now.speeds_done, total=now.speeds_total)
            label = f"{now.speed / (2.0 * math.pi):.4g} Hz"
            displayed.update(this_speed, description=label, completed=now.steps_done, total=now.steps_total)

        yield show
