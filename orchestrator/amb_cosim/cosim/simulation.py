"""Runs a plan with the FMUs of its components: initialise, step, record, and close them in any case."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable, Mapping
from contextlib import ExitStack
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Literal

import numpy as np

from amb_cosim.cosim import compiled
from amb_cosim.cosim.assignments import Assignments
from amb_cosim.cosim.choices import Coupling, Flavour, Loop
from amb_cosim.cosim.component import FmuComponent
from amb_cosim.cosim.errors import StepFailed
from amb_cosim.cosim.experiment import Plan, cannot_settle, told_as_simulated
from amb_cosim.cosim.fmu_interface import FmuInterface, read_interface
from amb_cosim.cosim.fmu_libraries import check_libraries
from amb_cosim.cosim.fmus import Fmu, provide
from amb_cosim.cosim.instances import Instances
from amb_cosim.cosim.interruption import deferred
from amb_cosim.cosim.isolation import run_isolated
from amb_cosim.cosim.loop_library import load_loop
from amb_cosim.cosim.master import Master, Observer
from amb_cosim.cosim.recorder import Recorder
from amb_cosim.cosim.replacement import fitted
from amb_cosim.cosim.schedules import Array
from amb_cosim.cosim.settling import CannotSettle, settle
from amb_cosim.cosim.stopping import StopObserver, Stopped
from amb_cosim.cosim.system import MasterLayout, System

REPORT_TIME = 0.04  # s between two reports of progress

Progress = Callable[[int, int], None]  # steps done, and their number
Status = Literal["completed", "stopped", "failed", "interrupted"]


@dataclass(frozen=True)
class Outcome:
    """How a run ended.

    Attributes
    ----------
    status
        `completed`; `stopped` by one of its own conditions; `failed` in a component; `interrupted` by the user.
    time
        Time that was reached (s).
    component
        The component that failed.
    reason
        The condition that was met, or what the component said; empty for a completed run.
    """

    status: Status
    time: float
    component: str | None = None
    reason: str = ""

    @property
    def failure(self) -> str | None:
        """One sentence on what ended the run before its time against its plan; None where nothing did."""
        if self.status == "failed":
            return f"{self.component} failed at t = {self.time:.9g} s: {self.reason}"
        return f"interrupted at t = {self.time:.9g} s" if self.status == "interrupted" else None

    @property
    def stopped(self) -> str | None:
        """The condition that ended the run, and when; None where none did."""
        return f"{self.reason}, at t = {self.time:.9g} s" if self.status == "stopped" else None

    def __str__(self) -> str:
        return self.failure or (f"stopped: {self.stopped}" if self.stopped else f"completed at t = {self.time:.9g} s")


@dataclass(frozen=True)
class Recording:
    """What a run recorded, as far as it came; `warnings` are what each component logged as such."""

    plan: Plan
    interfaces: Mapping[str, FmuInterface]
    recorder: Recorder
    outcome: Outcome
    flavour: str
    warnings: Mapping[str, list[str]]


@dataclass(frozen=True)
class Assembly:
    """A system with the FMUs of its components, checked against their interfaces."""

    system: System
    fmus: Mapping[str, Fmu]
    interfaces: Mapping[str, FmuInterface]

    @property
    def flavour(self) -> str:
        """The flavour of all FMUs, or `mixed`."""
        flavours = {fmu.flavour for fmu in self.fmus.values()}
        return flavours.pop() if len(flavours) == 1 else "mixed"

    @property
    def from_elsewhere(self) -> list[str]:
        """The components whose FMUs were given as files."""
        return [name for name, fmu in self.fmus.items() if fmu.flavour == "file"]

    def assignments(self) -> Assignments:
        """Return the values of the system's parameters, to add others to."""
        return self._assignments.copy()

    def wiring(self, exogenous: Iterable[str], recorded: Iterable[str]) -> MasterLayout:
        """Lay out all signals for a master, see `System.wiring`; runs that differ in values alone share it."""
        key = tuple(exogenous), tuple(recorded)
        if key not in self._wirings:
            self._wirings[key] = self.system.wiring(self.interfaces, *key)
        return self._wirings[key]

    @cached_property
    def _wirings(self) -> dict[tuple[tuple[str, ...], tuple[str, ...]], MasterLayout]:
        return {}

    @cached_property
    def _assignments(self) -> Assignments:
        values = Assignments(self.system, self.interfaces)
        for component, variables in self.system.parameters.items():
            for variable, raw in variables.items():
                values.set_or_drop(f"{component}.{variable}", raw, only="parameter")
        return values


def assemble(system: System, flavour: Flavour = "native", **options: Any) -> Assembly:
    """Find the FMUs of a system and check its connections.

    Parameters
    ----------
    system
        Which components, and how they are connected.
    flavour
        Which flavour of the models is built; FMU files are taken as they are.
    options
        What models are made for, as `model_source` takes it.

    Raises
    ------
    ValueError
        If an FMU cannot be had, or the system does not fit the interfaces.
    """
    fmus = {c.name: provide(c.fmu, flavour, **options) for c in system.components}
    interfaces = {c: _interface(fmu, c) for c, fmu in fmus.items()}
    system, fitting = fitted(system, interfaces, lambda c: _interface(provide(c.fmu, flavour, **options), c.name))
    return Assembly(system, fmus, fitting)


def _interface(fmu: Fmu, component: str) -> FmuInterface:
    """Return the interface of an FMU, whose libraries have been checked."""
    interface = read_interface(fmu.folder, component, fmu.path)
    check_libraries(fmu.folder, interface.identifier, f"{component}: {fmu.path}")
    return interface


def run_plan(
    assembly: Assembly,
    plan: Plan,
    progress: Progress | None = None,
    loop: Loop = "compiled",
    coupling: Coupling | None = None,
    isolated: bool | None = None,
    instances: Instances | None = None,
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

    Raises
    ------
    StartFailed, FmuError
        If an FMU cannot be loaded or refuses to start.
    ProcessFailed
        If the FMUs' own process ended before its time, or took too long.
    ValueError
        If the coupling is iterative, and an FMU cannot save its state, or steps at a rate of its own.
    """
    if assembly.from_elsewhere if isolated is None else isolated:
        return run_isolated(assembly, plan, progress, loop, coupling)
    try:
        return _run(assembly, plan, progress, loop, coupling, instances)
    except CannotSettle as error:
        if plan.settling == "solved":
            raise ValueError(cannot_settle(str(error))) from error
        told = (*plan.notices, told_as_simulated(str(error)))
        return _run(assembly, replace(plan, settling="simulated", notices=told), progress, loop, coupling, instances)


def _run(
    assembly: Assembly,
    plan: Plan,
    progress: Progress | None,
    loop: Loop,
    coupling: Coupling | None,
    instances: Instances | None,
) -> Recording:
    """Run a plan in this process; raises CannotSettle where its settled motion cannot be solved for."""
    system = plan.system
    coupling = coupling or system.coupling
    if coupling == "iterative":
        _check_states(assembly)
        loop = "plain"
    if loop == "compiled" and load_loop() is None:
        loop = "plain"
    layout = assembly.wiring(plan.inputs, plan.recorded)
    wiring, inputs, outputs = layout
    recorder = Recorder([wiring.names.index(name) for name in plan.recorded], plan.record_from, plan.record_every)
    with ExitStack() as stack, deferred() as interruption:
        living = Instances() if instances is None else instances
        stack.callback(living.close)
        components = []
        for c in system.components:
            folder, interface = assembly.fmus[c.name].folder, assembly.interfaces[c.name]
            exchanged = inputs[c.name], outputs[c.name]
            components.append(living.take(c.name, folder, interface, *exchanged, plan.parameters[c.name], c.every))
        master = Master(components, wiring, plan.step_size, coupling)
        master.exogenous[:] = list(plan.inputs.values())
        begin = plan.begin
        master.initialise(begin)
        schedules = plan.schedules(wiring.names)
        stops = StopObserver(plan.stops, [wiring.names.index(condition.signal) for condition in plan.stops])
        observers: list[Observer] = [lambda *_: interruption.check()]
        if progress is not None:
            observers.append(_reporting(progress, plan))
        try:
            interruption.check()
            if plan.settling != "simulated":
                begin = _settle(assembly, master, layout, plan.first, begin, loop)
            if loop == "compiled":
                compiled.run(master, begin, plan.last, schedules, recorder, observers, stops)
            else:
                master.run(begin, plan.last, schedules, [recorder, stops, *observers])
            outcome = Outcome("completed", plan.last * plan.step_size)
        except CannotSettle:
            if instances is not None:
                stack.pop_all()
            raise
        except StepFailed as error:
            outcome = Outcome("failed", error.time, error.component, error.reason)
        except Stopped as condition:
            outcome = Outcome("stopped", master.time(condition.point), None, plan.stops[condition.index].text)
        except KeyboardInterrupt:
            outcome = Outcome("interrupted", recorder.reached * plan.step_size)
        warnings = {component.name: component.warnings for component in components}
        _warn_of_not_finite(assembly, plan, recorder, warnings)
        if instances is not None:
            stack.pop_all()  # the next run resets them, or loads new ones
            if outcome.status not in ("completed", "stopped"):
                instances.expire()
    return Recording(plan, assembly.interfaces, recorder, outcome, assembly.flavour, warnings)


def _settle(
    assembly: Assembly, master: Master[FmuComponent], layout: MasterLayout, first: int, begin: int, loop: Loop
) -> int:
    """Bring a master from `begin` into its settled motion, as if it had run since `first`; return where it is then."""

    program = compiled.program_of(master) if loop == "compiled" else None

    def advance(start: int, end: int) -> None:
        if program is not None:
            compiled.run(master, start, end, (), Recorder([], 1), program=program)
        else:
            master.run(start, end)

    return settle(master, layout, assembly.fmus, assembly.interfaces, advance, first, begin)


def _warn_of_not_finite(assembly: Assembly, plan: Plan, recorder: Recorder, warnings: dict[str, list[str]]) -> None:
    """Add to the warnings of FMUs from elsewhere which outputs were recorded as NaN or infinite, and since when."""
    for name, samples in zip(plan.recorded, recorder.table.T, strict=True):
        component = name.partition(".")[0]
        if component in assembly.from_elsewhere and not np.isfinite(samples).all():
            row = int(np.argmin(np.isfinite(samples)))
            time = recorder.points[row] * plan.step_size
            warnings[component].append(f"{name} = {samples[row]:g} at t = {time:.9g} s, which is no finite number")


def _check_states(assembly: Assembly) -> None:
    """Raise ValueError if an FMU cannot save its state."""
    unable = [name for name, interface in assembly.interfaces.items() if not interface.saves_state]
    if unable:
        raise ValueError(
            f"coupling = 'iterative' is not allowed with {', '.join(unable)}: it repeats steps, and an FMU cannot save "
            "and restore its state there (canGetAndSetFMUstate)"
        )


def _reporting(progress: Progress, plan: Plan) -> Observer:
    total, latest = plan.last - plan.begin, -math.inf

    def report(n: int, _: Array) -> None:
        nonlocal latest
        done, now = n - plan.begin, time.perf_counter()
        if now > latest + REPORT_TIME or done == total:
            latest = now
            progress(done, total)

    return report
