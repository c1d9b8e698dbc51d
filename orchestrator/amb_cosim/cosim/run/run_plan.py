"""Runs a plan with the FMUs of its components: initialise, step, record, and close them in any case."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from contextlib import ExitStack

import numpy as np

from amb_cosim.cosim.basics.choices import Coupling, Loop
from amb_cosim.cosim.basics.errors import StepFailed
from amb_cosim.cosim.basics.interruption import Interruption, deferred
from amb_cosim.cosim.basics.schedules import Array
from amb_cosim.cosim.master.instances import InstancePool
from amb_cosim.cosim.master.master import Observer
from amb_cosim.cosim.master.settling import CannotSettle
from amb_cosim.cosim.record.recorder import Recorder
from amb_cosim.cosim.run.checkpoint import Checkpoint
from amb_cosim.cosim.run.isolation import run_isolated
from amb_cosim.cosim.run.plan_session import Simulator
from amb_cosim.cosim.run.recording import Outcome, Recording
from amb_cosim.cosim.run.saving import Saves, run_saving
from amb_cosim.cosim.system.assembly import Assembly
from amb_cosim.cosim.system.experiment import Plan
from amb_cosim.cosim.system.planning import cannot_settle, simulated_settling_notice
from amb_cosim.cosim.system.stopping import Stopped

REPORT_TIME = 0.04  # s between two reports of progress

Progress = Callable[[int, int], None]  # steps done, and their number


def run_plan(
    assembly: Assembly,
    plan: Plan,
    progress: Progress | None = None,
    loop: Loop = "compiled",
    coupling: Coupling | None = None,
    isolated: bool | None = None,
    instances: InstancePool | None = None,
    start: Checkpoint | None = None,
    saves: Saves | None = None,
) -> Recording:
    """Run a plan with the FMUs of an assembly.

    A step that fails, Ctrl-C and, from the command line, SIGTERM end the run early; the outcome says what happened, and
    what was recorded is kept. A condition that is met ends it too.

    Parameters
    ----------
    progress
        Called now and then with the steps done and their number.
    loop
        Of an explicit coupling; an iterative one runs in the plain loop. The `compiled` loop and the `plain` one, which
        calls the FMUs from Python, give the same to the last bit. Where there is no compiled one (see `loop_library`),
        the plain one runs.
    coupling
        In place of the system's.
    isolated
        Whether the FMUs run in a process of their own, whose end is not that of this one; by default they do if one of
        them was given as a file.
    start
        A state from which the run goes on, of a run with the same past; the record is then that of the whole.
    saves
        What of the state is saved on the way.

    Raises
    ------
    StartFailed, FmuError
        If an FMU cannot be loaded or refuses to start.
    ProcessFailed
        If the FMUs' own process ended before its time, or took too long.
    ValueError
        If the coupling is iterative, and an FMU cannot save its state, or steps at a rate of its own; if a state is to
        be saved that an FMU cannot serialise, or `start` is of another run.
    """
    saves = (saves or Saves()).possible(assembly)
    if assembly.from_elsewhere if isolated is None else isolated:
        return run_isolated(assembly, plan, progress, loop, coupling, start, saves)
    notice = "" if start is None else start.notice
    with ExitStack() as stack, deferred() as interruption:
        living = InstancePool() if instances is None else instances
        stack.callback(living.close)

        def run(notice: str) -> Recording:
            simulator = Simulator(assembly, plan, coupling, loop, living, notice)
            return _run(simulator, progress, interruption, start, saves)

        try:
            recording = run(notice)
        except CannotSettle as error:
            if plan.settling == "solved":
                raise ValueError(cannot_settle(str(error))) from error
            recording = run(simulated_settling_notice(str(error)))
        if instances is not None:
            stack.pop_all()  # the next run resets them, or loads new ones
            if recording.outcome.status not in ("completed", "stopped"):
                instances.expire()
    return recording


def _run(
    simulator: Simulator, progress: Progress | None, interruption: Interruption, start: Checkpoint | None, saves: Saves
) -> Recording:
    """Run to the end of the plan; raises CannotSettle where the settled motion cannot be solved for."""
    plan, recorder = simulator.plan, simulator.recorder
    observers: list[Observer] = [lambda *_: interruption.check()]
    if progress is not None:
        observers.append(_reporting(progress, plan))
    checkpoints: dict[int, Checkpoint] = {}
    begin = simulator.initialise() if start is None else simulator.resume(start)
    try:
        interruption.check()
        run_saving(simulator, simulator.settle() if start is None else begin, saves, observers, checkpoints.__setitem__)
        outcome = Outcome("completed", plan.last * plan.step_size)
    except StepFailed as error:
        outcome = Outcome("failed", error.time, error.component, error.reason)
    except Stopped as condition:
        stopped_at = simulator.master.time(condition.point)
        outcome = Outcome("stopped", stopped_at, None, plan.stops[condition.index].text)
    except KeyboardInterrupt:
        outcome = Outcome("interrupted", recorder.reached * plan.step_size)
    assembly = simulator.assembly
    warnings = {component.name: component.warnings for component in simulator.components}
    nan = _first_nan(assembly, plan, recorder, warnings)
    outcome = outcome if nan is None or outcome.failure else nan
    return Recording(plan, assembly.interfaces, recorder, outcome, assembly.flavour, warnings, checkpoints)


def _first_nan(assembly: Assembly, plan: Plan, recorder: Recorder, warnings: dict[str, list[str]]) -> Outcome | None:
    """Return the failure of the first FMU from elsewhere of which NaN was recorded; infinite outputs are warnings."""
    failures = []
    for name, samples in zip(plan.recorded, recorder.table.T, strict=True):
        component = name.partition(".")[0]
        if component not in assembly.from_elsewhere or np.isfinite(samples).all():
            continue
        row = int(np.argmin(np.isfinite(samples)))
        time = recorder.points[row] * plan.step_size
        if np.isnan(samples).any():
            failures.append(Outcome("failed", time, component, f"{name} = {samples[row]:g}, which is no finite number"))
        else:
            warnings[component].append(f"{name} = {samples[row]:g} at t = {time:.9g} s, which is no finite number")
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
