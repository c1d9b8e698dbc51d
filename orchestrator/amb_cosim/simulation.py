"""Runs a scenario: finds its FMUs, plans, initialises, steps, and hands back what was recorded."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import xarray as xr

from amb_cosim.build import CONTROLLER, Fmu, check_loop, provide
from amb_cosim.cosim import compiled
from amb_cosim.cosim.component import FmuComponent
from amb_cosim.cosim.interface import Interface, read_interface
from amb_cosim.cosim.master import (
    Array,
    Loop,
    Master,
    Observer,
    PiecewiseConstant,
    PiecewiseLinear,
    Schedule,
    StepFailed,
)
from amb_cosim.cosim.recorder import Recorder
from amb_cosim.cosim.stopping import Stopped, Watch
from amb_cosim.cosim.system import load_system
from amb_cosim.cosim.values import Raw
from amb_cosim.dataset import to_dataset
from amb_cosim.flavours import Flavour
from amb_cosim.plan import ACCELERATION, SPEED, Plan, make_plan
from amb_cosim.scenario import Scenario

Progress = Callable[[int, int], None]


@dataclass(frozen=True)
class Prepared:
    """A scenario with everything that it needs to run, checked."""

    name: str
    scenario: Scenario
    plan: Plan
    fmus: Mapping[str, Fmu]
    interfaces: Mapping[str, Interface]


@dataclass(frozen=True)
class Outcome:
    """What a run recorded, what ended it early, if something did, and whether that was Ctrl-C."""

    dataset: xr.Dataset
    failure: str | None
    interrupted: bool = False


def prepare(
    name: str,
    scenario: Scenario,
    settings: Mapping[str, Raw] | None = None,
    until: float | None = None,
    flavour: Flavour = "python",
) -> Prepared:
    """Find the FMUs of a scenario, check its system and plan it; see `make_plan` and `provide` for the arguments.

    Raises
    ------
    ValueError
        If anything in it does not fit.
    """
    system = load_system(scenario.system, {"gradient": scenario.gradient})
    for component in scenario.fmu:
        system.component(component)
    sources = {c.name: scenario.fmu.get(c.name, c.fmu) for c in system.components}
    rotor, table = (None if file is None else Path(file) for file in (scenario.rotor, scenario.receptances))
    controller = next((c for c, source in sources.items() if source == CONTROLLER), None)
    if table is not None and controller is None:
        raise ValueError(f"receptances {table} have no use: no component of the run is the model {CONTROLLER}")
    fmus = {c: provide(source, flavour, rotor, table) for c, source in sources.items()}
    interfaces = {c: read_interface(fmu.folder, c) for c, fmu in fmus.items()}
    system.check(interfaces)
    plan = make_plan(scenario, system, interfaces, settings, until)
    if table is not None and controller is not None:
        check_loop(table, plan.parameters(interfaces)[controller])
    return Prepared(name, scenario, plan, fmus, interfaces)


def run(prepared: Prepared, progress: Progress | None = None, loop: Loop = "compiled") -> Outcome:
    """Run a prepared scenario.

    A step that fails and Ctrl-C end the run early: the outcome holds what was recorded and what happened. A condition
    of the scenario that is met ends it too, and is no failure; the data set says which.
    `progress` is called now and then with the steps done and their number.
    The `compiled` loop and the `plain` one, which calls the FMUs from Python, give the same to the last bit.

    Raises
    ------
    StartFailed, FmuError
        If an FMU cannot be loaded or refuses to start.
    """
    plan, system = prepared.plan, prepared.plan.system
    wiring, inputs, outputs = system.wiring(prepared.interfaces, list(plan.exogenous), plan.recorded)
    positions = [wiring.names.index(name) for name in plan.recorded]
    recorder = Recorder(
        positions, plan.first if prepared.scenario.record.settling else 0, prepared.scenario.record.every
    )
    failure: str | None = None
    stopped: str | None = None
    by_user = False
    with ExitStack() as stack, _deferred_interrupt() as interrupted:
        components = []
        for c in system.components:
            component = FmuComponent(
                c.name,
                prepared.fmus[c.name].folder,
                prepared.interfaces[c.name],
                inputs[c.name],
                outputs[c.name],
                plan.start[c.name],
                c.every,
            )
            stack.callback(component.close)
            components.append(component)
        master = Master(components, wiring, plan.step_size, prepared.scenario.coupling or system.coupling)
        master.exogenous[:] = list(plan.exogenous.values())
        master.initialise(plan.first)
        at = wiring.names.index
        schedules: list[Schedule] = [PiecewiseConstant((n, at(name), value) for n, name, value in plan.events)]
        if plan.profile:
            schedules.append(PiecewiseLinear(plan.profile, plan.step_size, at(SPEED), at(ACCELERATION)))
        watch = Watch(plan.stops, [at(condition.signal) for condition in plan.stops])
        observers: list[Observer] = [_stop_when(interrupted)]
        if progress is not None:
            observers.append(_reporting(progress, plan, every=1 if loop == "compiled" else 200))
        try:
            if loop == "compiled":
                compiled.run(master, plan.first, plan.last, schedules, recorder, observers, watch)
            else:
                master.run(plan.first, plan.last, schedules, [recorder, watch, *observers])
        except StepFailed as error:
            failure = str(error)
        except Stopped as condition:
            stopped = f"{plan.stops[condition.index].text}, at t = {master.time(condition.point):.9g} s"
        except KeyboardInterrupt:
            by_user = True
            failure = f"interrupted at t = {recorder.reached * plan.step_size:.9g} s"
    dataset = to_dataset(
        prepared.name,
        prepared.scenario,
        plan,
        prepared.interfaces,
        _flavour(prepared.fmus),
        recorder,
        failure,
        stopped,
    )
    return Outcome(dataset, failure, by_user)


def _flavour(fmus: Mapping[str, Fmu]) -> str:
    flavours = {fmu.flavour for fmu in fmus.values()}
    return flavours.pop() if len(flavours) == 1 else "mixed"


def _reporting(progress: Progress, plan: Plan, every: int) -> Observer:
    total = plan.last - plan.first

    def report(n: int, _: Array) -> None:
        done = n - plan.first
        if done % every == 0 or done == total:
            progress(done, total)

    return report


def _stop_when(interrupted: threading.Event) -> Observer:
    def stop(*_: Any) -> None:
        if interrupted.is_set():
            raise KeyboardInterrupt

    return stop


@contextmanager
def _deferred_interrupt() -> Iterator[threading.Event]:
    """Ctrl-C sets the event; the second one interrupts at once.

    An exception raised at any moment could leave a Python FMU half-way through a call, and crash the process.
    """
    interrupted = threading.Event()
    if threading.current_thread() is not threading.main_thread():
        yield interrupted
        return

    def handle(*_: Any) -> None:
        interrupted.set()
        signal.signal(signal.SIGINT, before)

    before = signal.signal(signal.SIGINT, handle)
    try:
        yield interrupted
    finally:
        signal.signal(signal.SIGINT, before)
