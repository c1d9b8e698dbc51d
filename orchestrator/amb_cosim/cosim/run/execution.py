"""Executes a plan with the FMUs of its components: initialise, step and record them, and close them in any case."""

from __future__ import annotations

import logging
import math
import time
from collections.abc import Sequence
from contextlib import ExitStack
from functools import partial
from pathlib import Path

from amb_cosim.cosim.errors import StepFailed
from amb_cosim.cosim.fmu.fmus import note_first_loading
from amb_cosim.cosim.master.instances import InstancePool
from amb_cosim.cosim.master.master import Observer
from amb_cosim.cosim.master.settling import CannotSettle
from amb_cosim.cosim.processes.interruption import Interruption, deferred
from amb_cosim.cosim.record.finite_watch import FiniteWatch
from amb_cosim.cosim.run.checkpoint import Checkpoint
from amb_cosim.cosim.run.isolation import run_isolated
from amb_cosim.cosim.run.options import DEFAULTS, Progress, RunOptions, Saves
from amb_cosim.cosim.run.recording import Outcome, Recording
from amb_cosim.cosim.run.simulator import Simulator
from amb_cosim.cosim.system.experiment import Plan
from amb_cosim.cosim.system.planning import cannot_settle, simulated_settling_notice
from amb_cosim.cosim.system.stopping import Stopped
from array_types import Array

log = logging.getLogger(__name__)

REPORT_TIME = 0.04  # s between two reports of progress
SHARE = 0.05  # at most, of the time of a run, that automatic checkpoints take
FIRST = 16  # steps after which their duration is first measured


def execute_plan(plan: Plan, options: RunOptions = DEFAULTS) -> Recording:
    """Execute a plan with its FMUs.

    The run ends early if a step fails, if Ctrl-C or SIGTERM (from the command line) interrupts it, if a stop condition
    is met, or if an FMU ends it. The outcome then states the cause, and the record is kept.

    Raises
    ------
    StartFailed, FmuError
        If an FMU cannot be loaded or refuses to start.
    ProcessFailed
        If the separate process ended early or took too long.
    ValueError
        If the coupling is iterative and an FMU cannot save its state or has its own rate, if an FMU cannot serialise a
        state to be saved, or if `start` belongs to another run.
    """
    options = options.for_plan(plan)
    for fmu in plan.fmus.values():
        note_first_loading(fmu)
    return (run_isolated if options.isolated else run_here)(plan, options)


def run_here(plan: Plan, options: RunOptions) -> Recording:
    """Run a plan in this process, with options from `RunOptions.for_plan`; see `execute_plan`.

    If the settled motion before point 0 cannot be solved for, the settling is simulated, and a notice is added.
    """
    with ExitStack() as stack, deferred() as interruption:
        instances = InstancePool() if options.instances is None else options.instances
        stack.callback(instances.close)
        record = partial(_record, plan, options, instances, interruption)
        try:
            recording = record("" if options.start is None else options.start.notice)
        except CannotSettle as error:
            if plan.settling == "solved":
                raise ValueError(cannot_settle(str(error))) from error
            recording = record(simulated_settling_notice(str(error)))
        if options.instances is not None:
            stack.pop_all()  # the next run resets them, or loads new ones
            if recording.outcome.status not in ("completed", "stopped") or recording.outcome.component:
                instances.expire()
    return recording


def _record(
    plan: Plan, options: RunOptions, instances: InstancePool, interruption: Interruption, notice: str
) -> Recording:
    """Start or resume a run, settle it, step it, and return its record; raises CannotSettle like `Simulator.settle`."""
    simulator = Simulator(plan, options.loop, instances, notice, has_end=options.has_end)
    plan, recorder, start = simulator.plan, simulator.recorder, options.start
    observers: list[Observer] = [lambda *_: interruption.check()]
    if options.progress is not None:
        observers.append(_reporting(options.progress, plan))
    checkpoints: dict[int, Checkpoint] = {}
    begin = simulator.initialise() if start is None else simulator.resume(start)
    try:
        interruption.check()
        begin = simulator.settle() if start is None else begin
        _step_to_end(simulator, begin, options.saves, observers, checkpoints)
        interruption.check()  # of the last step, which would be lost
        outcome = Outcome("completed", plan.time(plan.last))
    except StepFailed as error:
        ended = error.end is not None
        time = simulator.end(error) if ended else error.time
        outcome = Outcome("stopped" if ended else "failed", time, error.component, error.reason)
        plan = simulator.plan
    except Stopped as condition:
        stopped_at = simulator.master.time(condition.point)
        outcome = Outcome("stopped", stopped_at, None, plan.stops[condition.index].text)
    except KeyboardInterrupt:
        outcome = Outcome("interrupted", plan.time(recorder.reached))
    warnings = {component.name: component.warnings for component in simulator.components}
    nan = _first_nan(simulator, warnings)
    outcome = outcome if nan is None or outcome.failure else nan
    return Recording(plan, recorder, outcome, warnings, checkpoints)


def _step_to_end(
    simulator: Simulator,
    begin: int,
    saves: Saves,
    observers: Sequence[Observer],
    checkpoints: dict[int, Checkpoint],
) -> None:
    """Step a plan from point `begin` to its end, and add the states to be saved to `checkpoints`; see `advance`."""
    last, common = simulator.plan.last, simulator.plan.common_steps
    due = sorted((n - n % common, n) for n in saves.points if n - n % common >= begin)
    size, next_save = FIRST * common, time.monotonic() + saves.every
    while begin <= last:
        while due and due[0][0] == begin:
            checkpoints[due.pop(0)[1]] = simulator.checkpoint(begin, saves.held)
        stop = min([last + 1, *(n for n, _ in due[:1]), *([begin + size] if saves.file else [])])
        started = time.monotonic()
        simulator.advance(begin, stop, observers)
        begin, now = stop, time.monotonic()
        if saves.file is None:
            continue
        size = 4 * size if now - started < saves.every / 8.0 else max(common, size // 2 // common * common)
        if now >= next_save and begin <= last:
            _autosave(simulator.checkpoint(begin), saves.file)
            next_save = time.monotonic() + max(saves.every, (time.monotonic() - now) / SHARE)


def _autosave(checkpoint: Checkpoint, file: Path) -> None:
    """Write an automatic checkpoint; the run continues if that fails."""
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        checkpoint.save(file)
    except OSError as error:
        log.warning("the run continues without an automatic checkpoint: %s", error)


def _first_nan(simulator: Simulator, warnings: dict[str, list[str]]) -> Outcome | None:
    """Return the failure of the first foreign FMU with an output that is NaN; for infinite outputs, add warnings.

    Outputs that are recorded or connected are watched; before the checkpoint from which a run is resumed, only recorded
    outputs are watched.
    """
    plan, recorder, foreign = simulator.plan, simulator.recorder, simulator.plan.assembly.from_elsewhere
    if not foreign:
        return None
    watch = FiniteWatch(dict(enumerate(plan.recorded)), plan.record_from)
    watch.see(recorder.points, recorder.table)
    watch.add(simulator.watch)
    failures = []
    for not_finite in (watch.nan, watch.infinite):
        for name, (point, value) in not_finite.items():
            component, time = plan.system.divide(name)[0], plan.time(point)
            if component in foreign and not_finite is watch.nan:
                reason = f"{name} = {value:g}, which is not a finite number"
                failures.append(Outcome("failed", time, component, reason))
            elif component in foreign and name not in watch.nan:
                warnings[component].append(f"{name} = {value:g} at t = {time:.9g} s, which is not a finite number")
    return min(failures, key=lambda outcome: outcome.time, default=None)


def _reporting(progress: Progress, plan: Plan) -> Observer:
    total, latest = plan.last - plan.begin, -math.inf

    def report(n: int, _: Array) -> None:
        nonlocal latest
        done, now = n - plan.begin, time.perf_counter()
        if now > latest + REPORT_TIME or done == total:
            latest = now
            progress(done, total)

    return report
