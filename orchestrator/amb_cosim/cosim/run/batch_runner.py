"""Members of a batch: runs of one system, stepped side by side in threads of this process.

All values are in one array, a row for each member: its master works in that row. The compiled loop steps members
without the interpreter's lock, each with its own FMU instances: a member gives the same bits as a single run, for any
number of threads. FMUs that contain Python acquire the lock for each call.
"""

from __future__ import annotations

import os
import time
import weakref
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from ctypes import POINTER, Structure, byref, c_bool, c_ssize_t, c_void_p, cast, pointer
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np

from amb_cosim.cosim.basics.interruption import deferred
from amb_cosim.cosim.basics.loop_library import load_members
from amb_cosim.cosim.basics.schedules import Changes
from amb_cosim.cosim.fmu.component import HeldState
from amb_cosim.cosim.master.compiled import CALLS, WARNING, End, merged, structure_of
from amb_cosim.cosim.master.instances import InstancePool
from amb_cosim.cosim.master.settling import CannotSettle
from amb_cosim.cosim.run.checkpoint import Checkpoint
from amb_cosim.cosim.run.plan_session import Simulator
from amb_cosim.cosim.system.assembly import Assembly
from amb_cosim.cosim.system.experiment import Plan
from amb_cosim.cosim.system.planning import cannot_settle, simulated_settling_notice
from array_types import Array, Bools, Indices

HeldStates = dict[int, tuple[int, Array, dict[str, HeldState]]]  # point, values, and states of the FMUs, by member

SHARES = 4  # parts of a batch for each thread, so that those with little to do take more of them
FIRST_BLOCK, BLOCK_TIME = 64, 0.05  # steps, s: an interruption waits for a block of steps


class States:
    """States of all members, held in the memory of their FMUs until the object is deleted."""

    def __init__(self, owner: BatchRunner, held: HeldStates, dropped: list[HeldStates]) -> None:
        self.owner, self.held = owner, held
        weakref.finalize(self, dropped.append, held).atexit = False


class BatchRunner:
    """A batch of members, each at point 0 of its plan.

    Parameters
    ----------
    assembly
        The FMUs; each member has its own instances.
    plans
        One plan per member, with the same signals.
    threads
        Number of threads; by default one per processor.

    Attributes
    ----------
    values
        Values of all signals, shape (members, signals); the rows are the masters' memory.
    points
        Communication points of the members; changes at these points are still to come.
    failed
        Members that did not complete a step, and stop until they are restored.

    Raises
    ------
    ValueError
        If an FMU cannot save its state, the coupling is iterative, or there is no compiled loop.
    StartFailed, FmuError, StepFailed
        If an FMU cannot be loaded, refuses to start, or fails before point 0.
    """

    def __init__(self, assembly: Assembly, plans: Sequence[Plan], threads: int | None = None) -> None:
        advance = load_members()
        if advance is None:
            raise ValueError("there is no compiled loop for this machine, and no compiler to make it")
        unable = [name for name, interface in assembly.interfaces.items() if not interface.saves_state]
        if unable:
            raise ValueError(f"no batch is possible with {', '.join(unable)}: an FMU must have canGetAndSetFMUstate")
        if plans[0].system.coupling == "iterative":
            raise ValueError("no batch is possible in iterative coupling")
        if plans[0].system.transformed:
            raise ValueError("no batch is possible with a connection that transforms its value")
        self._advance = advance
        self.names = assembly.wiring(plans[0].inputs, plans[0].recorded).wiring.names
        n = len(plans)
        self.values: Array = np.zeros((n, len(self.names)))
        self.points: Indices = np.zeros(n, np.intp)
        self.failed: Bools = np.zeros(n, np.bool_)
        self._ends = (End * n)()
        of_ends = np.ctypeslib.as_array(cast(self._ends, POINTER(c_ssize_t)), (n, len(End._fields_)))
        self._status = of_ends[:, [field[0] for field in End._fields_].index("status")]
        self._threads = min(n, threads or os.cpu_count() or 1)
        self._stack = ExitStack()
        self._kept: list[Any] = []  # what C structures point to
        self._dropped: list[HeldStates] = []  # which nobody can restore; a finaliser may run in any thread
        try:
            self._runs = self._started(assembly, plans)
            self._programs = self._pointers([run.program() for run in self._runs])
            self._changes = self._pointers([structure_of(self._changes_of(run)) for run in self._runs])
            self.start = self.save()
        except BaseException:
            self.close()
            raise
        self._pool = self._stack.enter_context(ThreadPoolExecutor(self._threads)) if self._threads > 1 else None

    def _started(self, assembly: Assembly, plans: Sequence[Plan]) -> list[Simulator]:
        """Return members at point 0; those with equal plans start from one state."""
        runs: list[Simulator] = []
        first: list[tuple[Plan, Checkpoint, str]] = []
        serialises = all(interface.serialises_state for interface in assembly.interfaces.values())
        for row, plan in zip(self.values, plans, strict=True):
            instances = InstancePool()
            self._stack.callback(instances.close)
            alike = next(((state, notice) for available, state, notice in first if available == plan), None)
            if alike is not None:
                run = Simulator(assembly, plan, "compiled", instances, alike[1], row)
                run.resume(alike[0])
            else:
                run = self._settled(assembly, plan, instances, row)
                if serialises:
                    first.append((plan, run.checkpoint(0), run.notice))
            runs.append(run)
        return runs

    @staticmethod
    def _settled(assembly: Assembly, plan: Plan, instances: InstancePool, row: Array) -> Simulator:
        def run(notice: str) -> Simulator:
            row[:] = 0.0
            simulator = Simulator(assembly, plan, "compiled", instances, notice, row)
            simulator.initialise()
            simulator.advance(simulator.settle(), 0)
            return simulator

        try:
            return run("")
        except CannotSettle as error:
            if plan.settling == "solved":
                raise ValueError(cannot_settle(str(error))) from error
            return run(simulated_settling_notice(str(error)))

    @staticmethod
    def _changes_of(run: Simulator) -> Changes:
        return merged([schedule.changes(0, run.plan.last + 1) for schedule in run.schedules])

    def _pointers(self, structures: Sequence[Structure]) -> Any:
        self._kept.append(structures)
        return (c_void_p * len(structures))(*(cast(pointer(item), c_void_p) for item in structures))

    def step(self, steps: int) -> None:
        """Advance all members that have not failed by a number of communication steps.

        Raises
        ------
        KeyboardInterrupt
            If a signal was received; all members are then at the same, earlier point.
        """
        n, shares = len(self.points), SHARES * self._threads if self._pool else 1
        bounds = [k * n // shares for k in range(shares + 1)]
        parts = [(a, b) for a, b in pairwise(bounds) if b > a]
        size = FIRST_BLOCK
        with deferred() as interruption:
            while steps > 0:
                block, begin = min(size, steps), time.perf_counter()
                list((self._pool.map if self._pool else map)(partial(self._step, steps=block), parts))
                np.logical_or(self._status < 0, self._status > WARNING, out=self.failed)
                interruption.check()
                steps -= block
                taken = time.perf_counter() - begin
                size = 4 * size if taken < BLOCK_TIME / 4 else max(1, size // 2) if taken > BLOCK_TIME else size

    def _step(self, part: tuple[int, int], steps: int) -> None:
        points, rests = (cast(array.ctypes.data, c_void_p) for array in (self.points, self.failed))
        bounds = (c_ssize_t(number) for number in (*part, steps))
        self._advance(self._programs, self._changes, points, rests, *bounds, byref(c_bool(False)), self._ends)

    def reason(self, member: int) -> str:
        """Return the cause of a member's failure; empty if it did not fail."""
        if not self.failed[member]:
            return ""
        end, run = self._ends[member], self._runs[member]
        component = run.components[end.component]
        reason = component.refusal(CALLS[end.call], end.status)
        return f"{component.name} failed at t = {run.master.time(end.reached):.9g} s: {reason}"

    def save(self) -> States:
        """Return the states of all members."""
        self.free_dropped()
        held = {
            i: (int(self.points[i]), self.values[i].copy(), {c.name: c.hold() for c in run.components})
            for i, run in enumerate(self._runs)
        }
        return States(self, held, self._dropped)

    def restore(self, states: States, members: Sequence[int]) -> None:
        """Restore states that `save` returned.

        Raises
        ------
        ValueError
            If the states are not of these members.
        """
        if not isinstance(states, States) or states.owner is not self:
            raise ValueError("these are not states of this batch; pass the result of save to restore")
        for i in members:
            self.points[i], self.values[i], held = states.held[i]
            for component in self._runs[i].components:
                component.put(held[component.name])
            self.failed[i], self._status[i] = False, 0

    def free_dropped(self) -> None:
        """Free the states that can no longer be restored."""
        while self._dropped:
            for i, (_, _, held) in self._dropped.pop().items():
                for component in self._runs[i].components:
                    component.forget(held[component.name])

    def close(self) -> None:
        """Free all FMUs."""
        self._stack.close()
