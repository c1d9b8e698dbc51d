"""The cost of a sweep: overhead of a run, one and two processes, compared with FMPy in a loop and with commands."""

from __future__ import annotations

import itertools
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager, redirect_stdout
from dataclasses import dataclass
from functools import partial
from io import StringIO
from pathlib import Path
from statistics import median
from typing import TYPE_CHECKING, Any
from unittest.mock import patch

import numpy as np
from rich.table import Table

import amb_cosim
from amb_cosim.cosim.building.loop_library import load_loop
from amb_cosim.presentation.text_tables import labelled_table
from amb_cosim.scenario.scenario import load_scenario
from amb_sweeps.engine import SETTINGS, local_cluster
from amb_sweeps.outcomes import BROKEN_OFF
from amb_sweeps.sampling import SamplePlan, sample_plan
from amb_sweeps.worker import Runner, Task
from benchmarks.timing import environment, interleaved_times, ratios

if TYPE_CHECKING:
    from distributed import LocalCluster

SCENARIO = "fig4_9"
VARY = {"Omega": "250:270 rad/s", "step.rotor_contact.d1.u": "20 g.m:30 g.m"}
LABELS = {
    "two": "sweep, two processes",
    "one": "sweep, one process",
    "fmpy": "fmpy.simulate_fmu in a loop, the three FMUs as one",
    "command": "one amb-cosim run each",
}
MEMORY_SAMPLES = 20


@dataclass(frozen=True)
class SweepEffort:
    """How much is measured: runs of each kind in a round, rounds, runs of the sweep whose memory is watched."""

    batch: int = 200
    loop: int = 20
    commands: int = 3
    rounds: int = 5
    runs: int = 5000


QUICK = SweepEffort(batch=4, loop=1, commands=1, rounds=1, runs=40)


def measure(effort: SweepEffort, show_status: Callable[[str], object]) -> dict[str, Any]:
    """Measure the cost of sweeps of `fig4_9` with native FMUs.

    `overhead_ms` is the time of a run in a batch without its steps, `runs_per_second` are medians, `two_over_one` is
    the rate of two processes over that of one in each round, `memory_mb` is memory over the number of runs done.
    """
    show_status("measuring the overhead of a run (the first run compiles the models)")
    alone = overhead(effort.batch)
    with tempfile.TemporaryDirectory(prefix="benchmark-") as folder, ExitStack() as stack:
        one, two = (stack.enter_context(_cluster(jobs)).scheduler_address for jobs in (1, 2))
        show_status("measuring runs per second")
        folders = (Path(folder) / str(k) for k in itertools.count())
        candidates = {
            "two": partial(_sweep_time, two, effort.batch, folders),
            "one": partial(_sweep_time, one, effort.batch, folders),
            "fmpy": partial(_fmpy_time, _assembled(Path(folder)), effort.loop),
            "command": partial(_command_time, effort.commands, folders),
        }
        times = interleaved_times(candidates, effort.rounds)
        show_status(f"running {effort.runs} runs")
        memory = memory_over_runs(effort.runs, Path(folder) / "memory")
    return {
        **alone,
        "runs_per_second": {name: 1.0 / median(each) for name, each in times.items()},
        "two_over_one": ratios(times, "one", "two"),
        **memory,
        "rounds": effort.rounds,
        "environment": environment(),
    }


def overhead(runs: int) -> dict[str, Any]:
    """Return the median times (ms) of a run in this process: of its steps, and of the rest."""
    advance = load_loop()
    if advance is None:
        raise RuntimeError("there is no compiled loop")
    stepping = 0.0

    def timed(*arguments: Any) -> None:
        nonlocal stepping
        began = time.perf_counter()
        advance(*arguments)
        stepping += time.perf_counter() - began

    design, runner = _design(runs), Runner(Task(load_scenario(SCENARIO)))
    steps, remainders = [], []
    with patch("amb_cosim.cosim.master.compiled.load_loop", return_value=timed):
        for point in (0, *range(runs)):
            began, stepping = time.perf_counter(), 0.0
            runner.run(point, design.settings(point))
            steps.append(stepping)
            remainders.append(time.perf_counter() - began - stepping)
    runner.close()
    return {"steps_ms": 1e3 * median(steps[1:]), "overhead_ms": 1e3 * median(remainders[1:])}


def memory_over_runs(runs: int, folder: Path) -> dict[str, Any]:
    """Sweep `runs` runs on two processes; return the time (s) and samples of the memory (MB) of all processes.

    A sample in `memory_mb` has the runs done, and the memory of the processes that run and of the one that writes.
    """
    import psutil  # type: ignore[import-untyped]

    samples: list[tuple[int, float, float]] = []
    with _cluster(2) as cluster:

        def watch(done: int, total: int, _: str) -> None:
            if done >= len(samples) * total / MEMORY_SAMPLES:
                processes = (None, *(worker.pid for worker in cluster.workers.values()))
                writer, *workers = (1e-6 * psutil.Process(pid).memory_info().rss for pid in processes)
                samples.append((done, sum(workers), writer))

        began = time.perf_counter()
        _sweep(cluster.scheduler_address, runs, folder, watch)
        seconds = time.perf_counter() - began
    return {"runs": runs, "seconds": seconds, "memory_mb": samples}


def _design(runs: int) -> SamplePlan:
    return sample_plan(VARY, f"lhs:{runs}")


@contextmanager
def _cluster(jobs: int) -> Iterator[LocalCluster]:
    """Start a local cluster for several sweeps, which connect to its address without certificates."""
    import dask

    with dask.config.set(SETTINGS), local_cluster(jobs, security=None) as cluster:
        yield cluster


def _sweep(scheduler: str, runs: int, folder: Path, progress: Any = False) -> None:
    swept = amb_cosim.sweep(SCENARIO, VARY, sample=f"lhs:{runs}", output=folder, scheduler=scheduler, progress=progress)
    if {*BROKEN_OFF} & {*swept.outcomes}:
        raise RuntimeError(f"runs failed: {swept.summary}")


def _sweep_time(scheduler: str, runs: int, folders: Iterator[Path]) -> float:
    """Return the time (s) of a run of a sweep on a cluster that is there."""
    began = time.perf_counter()
    _sweep(scheduler, runs, next(folders))
    return (time.perf_counter() - began) / runs


def _assembled(folder: Path) -> Path:
    return amb_cosim.build_assembled(folder, SCENARIO)


def _fmpy_time(fmu: Path, runs: int) -> float:
    """Return the time (s) of a run with FMPy, which loads the FMU anew each time and steps it from Python."""
    from fmpy import simulate_fmu

    scenario = load_scenario(SCENARIO)
    step_size, settled = scenario.step_size("gauss_seidel"), scenario.settle_cycles * scenario.period
    begins = [0.0, *(settled + event.moment(scenario.period) for event in scenario.event)]
    disc = "rotor_contact.d1.u"
    values = [0.5e-3, 25.5e-3, 0.5e-3]  # kg m
    inputs = np.array(list(zip(begins, values, strict=True)), [("time", float), (disc, float)])
    began = time.perf_counter()
    with redirect_stdout(StringIO()):  # it prints every input without a value
        for _ in range(runs):
            simulate_fmu(
                str(fmu),
                stop_time=settled + scenario.end(scenario.period),
                step_size=step_size,
                output_interval=step_size,
                input=inputs,
                output=["rotor_contact.contact_state", "rotor_contact.rb1.f_n", "rotor_contact.rb2.f_n"],
            )
    return (time.perf_counter() - began) / runs


def _command_time(runs: int, folders: Iterator[Path]) -> float:
    """Return the time (s) of a run by the command, without plots."""
    command = [sys.executable, "-c", "from amb_cosim.start import main; main()", "run", SCENARIO, "--no-plots", "-o"]
    began = time.perf_counter()
    for _ in range(runs):
        subprocess.run([*command, str(next(folders))], check=True, capture_output=True)
    return (time.perf_counter() - began) / runs


def as_tables(data: Mapping[str, Any]) -> list[Table | str]:
    """Return what `measure` returns as tables and lines of text."""
    rates = data["runs_per_second"]
    table = labelled_table(f"Runs of {SCENARIO}", "", "runs/s", "of a sweep with two processes")
    for name, label in LABELS.items():
        table.add_row(label, f"{rates[name]:.3g}", f"{rates[name] / rates['two']:.3g}")
    memory = labelled_table("Memory of a sweep (MB)", "runs done", "processes that run", "process that writes")
    for done, workers, writer in data["memory_mb"]:
        memory.add_row(str(done), f"{workers:.0f}", f"{writer:.0f}")
    gains, where = data["two_over_one"], data["environment"]
    return [
        table,
        memory,
        f"a run: {data['steps_ms']:.2f} ms of steps, {data['overhead_ms']:.2f} ms of overhead",
        f"two processes over one: {median(gains):.2f} ({min(gains):.2f} to {max(gains):.2f})",
        f"{data['runs']} runs in {data['seconds']:.0f} s",
        f"{where['date']}, {where['processor']}, {where['cores']} cores, load {where['load_average']}; "
        f"medians of {data['rounds']} rounds",
    ]
