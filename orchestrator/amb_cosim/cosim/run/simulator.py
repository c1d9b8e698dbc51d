"""A plan with its loaded FMUs and its record; it is started or resumed, advanced from point to point, and saved."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from amb_cosim.cosim.building.loop_library import load_loop
from amb_cosim.cosim.choices import Loop
from amb_cosim.cosim.errors import FmuError, StartFailed, StepFailed
from amb_cosim.cosim.fmu.component import FmuComponent, FmuState
from amb_cosim.cosim.fmu.process_sharing import separate_components
from amb_cosim.cosim.grid.time_grid import NEAR_STEP
from amb_cosim.cosim.master import compiled
from amb_cosim.cosim.master.instances import InstancePool
from amb_cosim.cosim.master.master import Master, Observer
from amb_cosim.cosim.master.settling import CannotSettle, settle
from amb_cosim.cosim.record.finite_watch import FiniteWatch
from amb_cosim.cosim.record.recorder import Recorder
from amb_cosim.cosim.record.step_rows import StepRows, steps_in_row
from amb_cosim.cosim.run.checkpoint import Checkpoint
from amb_cosim.cosim.run.checkpoint_content import check_numbers, check_parts, columns_of
from amb_cosim.cosim.run.state_fingerprint import name_of, state_fingerprint
from amb_cosim.cosim.system.experiment import Plan
from amb_cosim.cosim.system.stopping import StopObserver
from amb_cosim.cosim.system.system import UNCHANGED, Component


class Simulator:
    """A run of a plan: the master of its components, and the record.

    Parameters
    ----------
    plan
        The plan to run.
    loop
        `compiled` or `plain`.
    instances
        The loaded FMUs; missing ones are loaded.
    notice
        Reason why the motion before point 0 is simulated instead of solved for.
    has_end
        Whether the FMUs get the end time of the plan; they do not if another run may continue from a saved state.

    Raises
    ------
    StartFailed
        If an FMU cannot be loaded or refuses a start value.
    ValueError
        If the coupling is iterative and an FMU cannot save its state.
    """

    def __init__(
        self, plan: Plan, loop: Loop, instances: InstancePool, notice: str = "", has_end: bool = False
    ) -> None:
        assembly, self._plan = plan.assembly, plan
        self.notice = notice
        self.plan = with_simulated_settling(plan, notice) if notice else plan
        coupling = plan.system.coupling
        if coupling == "iterative":
            _check_states(plan)
        transformed = plan.system.transformed
        explicit = not transformed and coupling != "iterative"
        separate = separate_components(assembly.fmus, assembly.interfaces)
        self._is_compiled = explicit and not separate and loop == "compiled" and load_loop() is not None
        self.wiring = wiring = assembly.wiring(plan.inputs, plan.recorded)
        self._instances = instances
        self._at = {name: position for position, name in enumerate(wiring.names)}
        self.components = [self._load(c, plan, c.name in separate) for c in plan.system.components]
        for component in self.components if transformed else ():
            names = [f"{component.name}.{v}" for v in self.wiring.inputs[component.name]]
            if transformed.keys() & set(names):
                component.transform([transformed.get(name, UNCHANGED) for name in names])
        end = None if plan.stop_time is None else (plan.last, plan.stop_time)
        last_steps = _shorter_last_steps(plan) if has_end or end is not None else {}
        self.master = Master(
            self.components,
            wiring,
            plan.step_size,
            coupling,
            plan.start_time,
            instances.values(wiring.names),
            end,
            last_steps,
        )
        for component in self.components if has_end else ():
            component.stop_time = _end_of(component.name, component.every, plan)
        recorded, each = ([self._at[name] for name in names] for names in (plan.recorded, plan.recorded_each))
        self.recorder = Recorder(recorded, plan.record_from, plan.record_every, each, _step_rows(plan))
        self.watch = FiniteWatch(
            {
                position: wiring.names[position]
                for component, slot in zip(self.components, self.master.slots, strict=True)
                for position in range(slot.start, slot.stop)
                if component.name in assembly.from_elsewhere
            },
            plan.record_from,
        )
        self.schedules = plan.schedules(wiring.names)
        self._stops = StopObserver(plan.stops, [self._at[condition.signal] for condition in plan.stops])
        self.master.exogenous[:] = list(plan.inputs.values())

    def _load(self, component: Component, plan: Plan, is_separate: bool) -> FmuComponent:
        """Return the instance of a component; raises StartFailed, with its name, if the FMU refuses."""
        name = component.name
        try:
            return self._instances.acquire(
                name,
                plan.fmus[name].folder,
                plan.interfaces[name],
                self.wiring.inputs[name],
                self.wiring.outputs[name],
                {**plan.parameters[name], **plan.texts.get(name, {})},
                component.every,
                is_separate,
            )
        except FmuError as error:
            raise StartFailed(f"{name}: {error}") from error

    def initialise(self) -> int:
        """Initialise the FMUs, and return the point at which the run begins; raises StartFailed if an FMU refuses."""
        self.master.initialise(self.plan.begin)
        return self.plan.begin

    def settle(self) -> int:
        """Settle from the beginning of the run, and return the point from which it continues.

        Raises
        ------
        CannotSettle
            If the settled motion cannot be solved for.
        StepFailed
            If a step fails.
        """
        plan = self.plan
        if plan.settling == "simulated":
            return plan.begin
        if plan.system.transformed:
            raise CannotSettle("a connection transforms its value")

        def step(first: int, last: int) -> None:
            if self._is_compiled:
                compiled.step(self.master, first, last, self._stops, self.recorder, self._instances.programs)
            else:
                self.master.run(first, last)

        return settle(self.master, plan.assembly, step, plan.first, plan.begin)

    def advance(self, first: int, stop: int, observers: Sequence[Observer] = ()) -> None:
        """At points from `first` to `stop` - 1, apply schedules, record, and step (except at the plan's last point).

        Raises
        ------
        StepFailed
            If a component does not complete a step.
        Stopped
            If a condition of the plan is met.
        """
        arguments = self.master, first, self.plan.last, self.schedules
        if self._is_compiled:
            programs = self._instances.programs
            compiled.run(*arguments, self.recorder, observers, self._stops, programs, stop, self.watch)
        else:
            self.master.run(*arguments[1:], [self.recorder, self.watch, self._stops, *observers], stop)

    def end(self, failed: StepFailed) -> float:
        """Record the end of a run that a component ended in a step, and return the time of this end (s).

        According to FMI, the values then belong to the time that the component states. In a step from t to t + h, this
        time must be within the step. If the component states no time, or a time outside the step, the end is t. If one
        of several components ends the run within a step, the others have no values at that time, and the record ends at
        t.
        """
        master, n, begin = self.master, self.recorder.reached, failed.time
        i, end = master.position(failed.component), math.nan if failed.end is None else failed.end
        if not begin < end <= begin + (1.0 + NEAR_STEP) * master.step_size_of(i, n):
            return begin
        is_full_step = master.grid.is_at(n + 1, end)
        end = master.time(n + 1) if is_full_step else end
        if begin == master.time(n) and master.complete(i, n, end):
            self.plan = replace(self.plan, last=n + 1, stop_time=end)
            for schedule in self.schedules if is_full_step else ():
                schedule(n + 1, master.exogenous)
            self.recorder(n + 1, master.values)
            self.watch(n + 1, master.values)
        return end

    def checkpoint(self, point: int, held: bool = False) -> Checkpoint:
        """Return the state before the changes at the present point, serialised or held in the memory of the FMUs."""
        plan = self.plan

        def state(component: FmuComponent) -> FmuState:
            return component.hold() if held else component.serialise()

        return Checkpoint(
            point=point,
            step_size=plan.step_size,
            start_time=plan.start_time,
            past=state_fingerprint(self._plan, point),
            sources={} if held else plan.assembly.sources,
            notice=self.notice,
            signals=dict(zip(self._at, self.master.values.tolist(), strict=True)),
            scales=self.master.scales if self.master.coupling == "iterative" else np.zeros(0),
            recorded=plan.recorded,
            points=self.recorder.points.copy(),
            table=self.recorder.table.copy(),
            recorded_each=tuple(plan.recorded_each),
            steps=self.recorder.step_rows.complete.copy(),
            rest=self.recorder.step_rows.rest.copy(),
            steps_in_row=self.recorder.step_rows.steps,
            since={name_of(c): int(since) for c, since in zip(plan.stops, self._stops.conditions.since, strict=True)},
            states={component.name: state(component) for component in self.components},
            warnings={component.name: component.warnings for component in self.components},
        )

    def resume(self, start: Checkpoint) -> int:
        """Bring a new run to a checkpoint, and return its point.

        If the states are held in memory, the caller must already have compared its past with that of the run. FMUs of
        this project accept a state without initialisation.

        Raises
        ------
        ValueError
            If the checkpoint has another past, is later than the end of this run, lacks recorded variables, or contains
            NaN from an FMU of this project.
        FmuError
            If an FMU does not accept its state.
        """
        plan = self.plan
        if start.point > plan.last:
            end = plan.time(plan.last)
            raise ValueError(f"the run ends at {end:.9g} s, before {start.title} at t = {start.time:.9g} s")
        if start.point < plan.begin:
            begin = plan.time(plan.begin)
            raise ValueError(f"the run begins at {begin:.9g} s, after {start.title} at t = {start.time:.9g} s")
        if not start.is_held:
            past = state_fingerprint(self._plan, start.point)
            start.check_past(past, plan.assembly.sources)
            check_parts(start, plan, self.master)
            check_numbers(start, plan)
        if not start.is_held or any(fmu.layout is None for fmu in plan.fmus.values()):
            self.initialise()
        for component in self.components:
            component.put(start.states[component.name], start.warnings[component.name])
        for name, value in start.signals.items():
            if name in self._at:
                self.master.values[self._at[name]] = value
        if self.master.coupling == "iterative":
            self.master.scales = start.scales
        for k, condition in enumerate(plan.stops):
            self._stops.conditions.since[k] = start.since.get(name_of(condition), condition.first)
        self.recorder.restore(start.points, columns_of(start, start.recorded, start.table, plan.recorded, plan))
        complete, rest = (
            columns_of(start, start.recorded_each, rows, tuple(plan.recorded_each), plan)
            for rows in (start.steps, start.rest)
        )
        self.recorder.step_rows.restore(start.point, complete, rest, start.steps_in_row)
        return start.point


def _step_rows(plan: Plan) -> StepRows:
    """Return an empty record for the values at every step of a run."""
    n_steps = plan.last - plan.first_recorded
    steps = steps_in_row(n_steps, plan.record_every, plan.step_size) if plan.recorded_each else 1
    return StepRows(plan.first_recorded, tuple(plan.recorded_each.values()), steps)


def with_simulated_settling(plan: Plan, notice: str) -> Plan:
    """Return the plan with the motion before point 0 simulated, and with a notice that gives the reason."""
    return replace(plan, settling="simulated", notices=(*plan.notices, notice))


def _shorter_last_steps(plan: Plan) -> dict[int, tuple[int, float]]:
    """Return the beginning (a point) and size (s) of the last step of each component whose last step is shortened."""
    end, last_steps = plan.time(plan.last), {}
    for i, c in enumerate(plan.system.components):
        point = (plan.last - 1) // c.every * c.every
        is_longer = point + c.every > plan.last or plan.stop_time is not None
        if is_longer and plan.interfaces[c.name].takes_any_step:
            last_steps[i] = (point, end - plan.time(point))
    return last_steps


def _end_of(name: str, every: int, plan: Plan) -> float:
    """Return the time at which the last step of a component ends (s)."""
    if every == 1 or plan.interfaces[name].takes_any_step:
        return plan.time(plan.last)
    return plan.start_time + math.ceil(plan.last / every) * every * plan.step_size


def _check_states(plan: Plan) -> None:
    """Raise ValueError if an FMU cannot save its state."""
    unable = [name for name, interface in plan.interfaces.items() if not interface.saves_state]
    if unable:
        raise ValueError(
            f"coupling = 'iterative' is not allowed with {', '.join(unable)}: it repeats steps, which "
            f"requires FMUs that save and restore their state (canGetAndSetFMUstate)"
        )
