"""Which control frees a rotor that an unbalance has thrown against its retainers, and how much unbalance it stands.

The case is that of Fig. 5.6, with its unbalance factor: 16 Hz, unbalance added on D1. For each control and each amount
the runs differ in the instant of the step alone. Rotor, bearings and retainers are the same in all directions, so that
the instant could only matter through the samples and the limits of the currents: a share between none and all is a
sign that the outcome hangs by little.
"""

from __future__ import annotations

import multiprocessing
import re
import signal
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from functools import partial
from statistics import median
from typing import Any

from rich.table import Table

from amb_cosim.cosim.values import Raw, quantity
from amb_cosim.flavours import Flavour
from amb_cosim.results import contact_cycles, recovered
from amb_cosim.scenario import Event, Record, Scenario, load_scenario
from amb_cosim.simulation import Prepared, prepare, run
from amb_cosim.studies import rolac_figures
from amb_cosim.studies.outcome import Outcome
from amb_cosim.text_tables import labelled_table
from rolac_controller.names import FORCE_FREE, NOTCH, OLAC, OWN_SENSORS, ROLAC
from rotor_analysis.rotor import require

SCENARIO = "fig5_6"
DISC = "d1.u"
END = 60.0  # cycle
FIRST_STEP = 5.0  # cycle
UNIT = "kg.m"
NUMBER = re.compile(r"[+-]?[\d.]+(?:[eE][+-]?\d+)?")

Progress = Callable[[int, int], None]

CONTROLS: dict[str, dict[str, Raw]] = {
    "PID": {"rolac_enable": False},
    "PID + OLAC": {"rolac.mode": OLAC},
    "PID + generalised notch": {"rolac.mode": NOTCH},
    "PID + synchronous force rejection": {"rolac.mode": FORCE_FREE},
    "PID + ROLAC": {"rolac.mode": ROLAC},
    "PID + contact-aware ROLAC": {"rolac.mode": ROLAC, "contact.aware": True, "contact.source": OWN_SENSORS},
}


@dataclass(frozen=True)
class Case:
    """One run: the control, what it adds on D1 (kg m, before the scenario's factor) and at which cycle, alpha (1/s)."""

    control: str
    added: float
    cycle: float
    alpha: float
    flavour: Flavour = "python"


@dataclass(frozen=True)
class Result:
    """Whether the rotor is free at the end, and the cycle of its last contact, if it touched at all."""

    recovered: bool
    last_contact_cycle: float | None


def recovery(steps: str, instants: int, alpha: str, flavour: Flavour, progress: Progress) -> Outcome:
    """Share of the runs that end free of contact, and the cycles that takes, over the unbalance added."""
    require(instants >= 1, "instants", instants, "1 or more")
    rate = quantity(alpha, "1/s", "alpha")
    added = unbalances(steps)
    cases = [
        Case(control, u, FIRST_STEP + k / instants, rate, flavour)
        for control in CONTROLS
        for u in added
        for k in range(instants)
    ]
    results = outcomes(cases, progress)
    data: dict[str, Any] = {
        "scenario": SCENARIO,
        "speed_hz": quantity(load_scenario(SCENARIO).Omega, "Hz", "Omega"),
        "unbalance_factor": load_scenario(SCENARIO).unbalance_factor,
        "alpha_per_s": rate,
        "end_cycle": END,
        "instants": instants,
        "added_kg_m": added,
        "controls": {
            control: [
                _summary([(c, r) for c, r in zip(cases, results, strict=True) if (c.control, c.added) == (control, u)])
                for u in added
            ]
            for control in CONTROLS
        },
    }
    return Outcome(data, {"recovery": partial(rolac_figures.recovery, data)}, as_text(data))


def unbalances(text: str) -> list[float]:
    """Unbalances (kg m), ascending, from a list with commas; `8,12,16 g.m` gives the unit once for all."""
    parts = [part.strip() for part in text.split(",")]
    unit = NUMBER.sub("", parts[-1], count=1)
    values = [quantity(f"{part} {unit}" if NUMBER.fullmatch(part) else part, UNIT, "steps") for part in parts]
    for value in values:
        require(0.0 < value < float("inf"), "steps", f"{value:g} kg m", "> 0 kg m")
    return sorted(set(values))


def outcomes(cases: Sequence[Case], progress: Progress) -> list[Result]:
    """What becomes of each case, by as many processes as there are processors.

    Threads would wait for each other: FMUs with Python inside hold its lock.

    Raises
    ------
    ValueError
        If a case cannot be run, or does not come to its end.
    """
    for case in {case.control: case for case in cases}.values():  # one of each, with the largest unbalance
        prepared(case)  # refuses what is wrong, and builds the FMUs, before there are processes
    with ProcessPoolExecutor(
        mp_context=multiprocessing.get_context("spawn"),
        initializer=signal.signal,
        initargs=(signal.SIGINT, signal.SIG_IGN),  # Ctrl-C is for this process, which then stops the others
    ) as pool:
        try:
            futures = [pool.submit(outcome_of, case) for case in cases]
            for done, future in enumerate(as_completed(futures), start=1):
                future.result()
                progress(done, len(cases))
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise
    return [future.result() for future in futures]


def outcome_of(case: Case) -> Result:
    """Run one case. Raises ValueError if it does not come to its end."""
    outcome = run(prepared(case))
    if outcome.failure is not None:
        raise ValueError(f"{case.control}, {case.added:g} kg m added: {outcome.failure}")
    return Result(bool(recovered(outcome.dataset)), contact_cycles(outcome.dataset)[1])


def prepared(case: Case) -> Prepared:
    """A case ready to run."""
    settings = {"rolac.alpha": case.alpha, **CONTROLS[case.control]}
    named = {f"rolac_controller.{name}": value for name, value in settings.items()}
    return prepare("recovery", scenario(case), named, flavour=case.flavour)


def scenario(case: Case) -> Scenario:
    """The scenario of Fig. 5.6 with another step: every sample is kept of what tells contact, and little else."""
    base = load_scenario(SCENARIO)
    before = quantity(base.inputs["rotor_contact"][DISC], UNIT, DISC)
    step = Event(label="step", cycle=case.cycle, set={"rotor_contact": {DISC: before + case.added}})
    record = Record(variables=("rotor_contact.contact_state",))
    return base.model_copy(update={"event": (step,), "end_cycle": END, "record": record})


def _summary(runs: Sequence[tuple[Case, Result]]) -> dict[str, Any]:
    """Share recovered, and the median of the cycles from the step to the last contact of those; 0 without contact."""
    cycles = [max(0.0, (r.last_contact_cycle or 0.0) - c.cycle) for c, r in runs]
    taken = [time for time, (_, r) in zip(cycles, runs, strict=True) if r.recovered]
    return {
        "recovered_share": len(taken) / len(runs),
        "median_cycles": median(taken) if taken else None,
        "runs": [
            {"step_cycle": c.cycle, "recovered": r.recovered, "cycles": time}
            for time, (c, r) in zip(cycles, runs, strict=True)
        ],
    }


def as_text(data: dict[str, Any]) -> list[Table | str]:
    """What `recovery` found, to print."""
    title = f"Recovery at {data['speed_hz']:g} Hz; unbalance added on D1 (g m)"
    table = labelled_table(title, "control", *(f"{1e3 * added:g}" for added in data["added_kg_m"]))
    for control, cells in data["controls"].items():
        table.add_row(control, *(_cell(cell) for cell in cells))
    return [
        table,
        f"runs free of contact at cycle {data['end_cycle']:g} (%), and the median cycles that those took to their "
        "last contact",
        f"unbalances times {data['unbalance_factor']:g}, alpha = {data['alpha_per_s']:g} 1/s, "
        f"instants of the step: {data['instants']}",
    ]


def _cell(cell: dict[str, Any]) -> str:
    share = f"{100.0 * cell['recovered_share']:.0f}"
    return share if cell["median_cycles"] is None else f"{share}, {cell['median_cycles']:.1f}"
