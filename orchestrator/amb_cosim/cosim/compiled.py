"""Compiled master loop, calling FMI functions directly.

It does what the loop in `master` does, operation by operation, and records the same to the last bit; that loop is the
readable reference. There is one difference: outputs that no component reads are fetched only where they are recorded.
The run goes in blocks of steps, between which Python checks for interrupts and reports progress.

The loop runs without the interpreter lock. FMUs with Python inside take it for each of their calls, as they must
in any host, and other threads run meanwhile.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, NamedTuple, Protocol, TypeVar, cast

import numba
import numpy as np
from llvmlite import ir  # type: ignore[import-untyped]
from numba.core import types
from numba.extending import intrinsic
from numpy.typing import NDArray

from amb_cosim.cosim.component import EntryPoints, Transfer
from amb_cosim.cosim.errors import StepFailed
from amb_cosim.cosim.master import Master, Observer, Participant
from amb_cosim.cosim.recorder import RecordBuffer, Recorder
from amb_cosim.cosim.schedules import Array, Changes, IntArray, Schedule
from amb_cosim.cosim.stopping import Conditions, StopObserver, Stopped

CALLS = ("fmi2Set", "fmi2DoStep", "fmi2Get")
SEND, STEP, FETCH = range(3)
WARNING = 1  # the highest status with which a call has done its work
BLOCK_TIME = 0.05  # s; Python is asked about that often


class Addressable(Participant, Protocol):
    """A participant whose FMI functions can be called by address."""

    def entry_points(self) -> EntryPoints: ...
    def refusal(self, call: str, status: int) -> Exception: ...


class Calls(NamedTuple):
    """The fmi2Set or fmi2Get calls of all components, one after the other.

    Those of component i are `of[i]` to `of[i + 1]`. Call c moves the variables `first[c]` to `first[c + 1]` between
    their `positions` in the value array and `reals` or `integers`, where the FMU reads or writes them. It gets the
    addresses `references_at[c]`, within `references`, and `values_at[c]`, within `reals` or `integers`; where it is
    `direct`, within the value array itself.
    """

    of: IntArray
    function: IntArray
    references_at: IntArray
    values_at: IntArray
    real: NDArray[np.bool_]
    direct: NDArray[np.bool_]
    first: IntArray
    positions: IntArray
    references: NDArray[np.uint32]
    reals: Array
    integers: NDArray[np.int32]


class Program(NamedTuple):
    """The data of a master as arrays; `step_sizes` (s) are those of the components.

    `fetches` are of all outputs, `needed` of those alone that are used whether recorded or not. Where a point is
    recorded, all come in the same calls: one call for the rest would cost more than its values do.
    """

    instance: IntArray
    do_step: IntArray
    every: IntArray
    step_sizes: Array
    sends: Calls
    fetches: Calls
    needed: Calls
    values: Array
    start_time: float
    step_size: float
    jacobi: bool


C = TypeVar("C", bound=Addressable)
F = TypeVar("F", bound=Callable[..., Any])


def run(
    master: Master[C],
    first: int,
    last: int,
    schedules: Sequence[Schedule],
    recorder: Recorder,
    observers: Sequence[Observer] = (),
    stops: StopObserver | None = None,
) -> None:
    """Advance from communication point `first` to `last` as `Master.run` does.

    Parameters
    ----------
    master
        Initialised, with components that have entry points.
    first, last, schedules
        As for `Master.run`.
    recorder
        Sees every point; the last included.
    observers
        Called now and then, about every 50 ms, with the last point that was reached and the values after it, of
        which those that are recorded and nothing else may be older.
    stops
        Judged at every point, after it has been recorded.

    Raises
    ------
    StepFailed
        If a component does not complete a step. The recorder has seen everything up to it.
    Stopped
        If a condition of `stops` is met. The recorder has seen everything up to it.
    """
    master.check_start(first)
    conditions = (stops or StopObserver()).conditions
    program = _program(master, conditions)
    buffer, row = recorder.buffer(first, last), len(recorder.points)
    begin, size = first, 64
    while begin <= last:
        # Point 0 begins a block, because the recorder's clock starts there.
        end = min(begin + size, last + 1, 0 if begin < 0 else last + 1)
        changes = _merged([schedule.changes(begin, end) for schedule in schedules])
        recorder.see(begin)
        started = time.perf_counter()
        reached, row, failed, call, status, met = _advance(program, changes, buffer, conditions, row, begin, end, last)
        recorder.fill(row)
        recorder.see(reached)
        if met >= 0:
            raise Stopped(met, reached)
        if status > WARNING:
            component = master.components[failed]
            reason = component.refusal(CALLS[call], status)
            raise StepFailed(component.name, master.time(reached), str(reason)) from reason
        for observe in observers:
            observe(reached, master.values)
        taken = time.perf_counter() - started
        size = 2 * size if taken < BLOCK_TIME / 2 else max(1, size // 2) if taken > BLOCK_TIME else size
        begin = end


def _program(master: Master[C], conditions: Conditions) -> Program:
    entries = [component.entry_points() for component in master.components]
    every = [component.every for component in master.components]
    fetches = [entry.fetches for entry in entries]
    places = [np.arange(slot.start, slot.stop) for slot in master.slots]
    used = np.zeros(len(master.values), np.bool_)
    for positions in (*master.wiring.sources, conditions.positions):
        used[positions] = True
    return Program(
        instance=np.array([entry.instance for entry in entries], np.intp),
        do_step=np.array([entry.do_step for entry in entries], np.intp),
        every=np.array(every, np.intp),
        step_sizes=np.array([m * master.step_size for m in every], np.float64),
        sends=_calls([entry.sends for entry in entries], master.wiring.sources),
        fetches=_calls(fetches, places, master.values),
        needed=_calls([_only(used[place], of_one) for of_one, place in zip(fetches, places, strict=True)], places),
        values=master.values,
        start_time=float(master.start_time),
        step_size=float(master.step_size),
        jacobi=master.coupling == "jacobi",
    )


def _only(used: NDArray[np.bool_], transfers: Sequence[Transfer]) -> list[Transfer]:
    """Reduce transfers to the outputs that are used."""
    parts = [replace(t, references=t.references[used[t.where]], where=t.where[used[t.where]]) for t in transfers]
    return [part for part in parts if len(part.where)]


def _calls(transfers: Sequence[Sequence[Transfer]], places: Sequence[IntArray], values: Array | None = None) -> Calls:
    """Collect the transfers of all components; `places` are the positions of their variables in the value array.

    Reals that stand one after another in `values`, if it is given, are written there by the FMU itself.
    """
    flat = [t for of_one in transfers for t in of_one]
    positions = [place[t.where] for of_one, place in zip(transfers, places, strict=True) for t in of_one]
    references = np.concatenate([np.zeros(0, np.uint32), *(t.references for t in flat)])
    reals, integers = np.zeros(len(references)), np.zeros(len(references), np.int32)
    first = _ends([len(t.references) for t in flat])
    real = np.array([t.real for t in flat], np.bool_)
    values_at = np.where(real, _addresses(reals, first[:-1]), _addresses(integers, first[:-1]))
    direct = np.zeros(len(flat), np.bool_)
    for c, at in enumerate(positions):
        if values is not None and real[c] and np.all(np.diff(at) == 1):
            direct[c], values_at[c] = True, _addresses(values, at[:1])[0]
    return Calls(
        of=_ends([len(of_one) for of_one in transfers]),
        function=np.array([t.function for t in flat], np.intp),
        references_at=_addresses(references, first[:-1]),
        values_at=values_at,
        real=real,
        direct=direct,
        first=first,
        positions=np.concatenate([np.zeros(0, np.intp), *positions]),
        references=references,
        reals=reals,
        integers=integers,
    )


def _addresses(items: NDArray[Any], at: IntArray) -> IntArray:
    return items.ctypes.data + at * items.itemsize


def _ends(lengths: Sequence[int]) -> IntArray:
    return np.cumsum([0, *lengths], dtype=np.intp)


def _merged(changes: Sequence[Changes]) -> Changes:
    """Merge the changes of several schedules in order of time; at the same point the last schedule wins."""
    nothing = Changes(np.zeros(0, np.intp), np.zeros(0, np.intp), np.zeros(0))
    points, positions, values = (np.concatenate(parts) for parts in zip(nothing, *changes, strict=True))
    order = np.argsort(points, kind="stable")
    return Changes(points[order], positions[order], values[order])


# From here on: machine code. All of it stands in this file, since numba's cache notices a change of this file alone.

# Arrays belong to the caller: without reference counts (`_nrt`) what the loop itself costs is a tenth.
# Parts of the loop become one function: a call would hand over the arrays of `Program` one by one.
_OPTIONS: dict[str, Any] = {"cache": True, "nogil": True, "error_model": "numpy", "_nrt": False, "forceinline": True}


def _kernel(function: F) -> F:
    return cast(F, numba.njit(**_OPTIONS)(function))


def _intrinsic(function: Callable[..., Any]) -> Any:
    return intrinsic(function)


def _call_of(*arguments: Any) -> Any:
    """Return signature and body of an intrinsic that calls a C function by address and returns its C int."""

    def emit(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        kinds = [context.get_value_type(kind) for kind in signature.args[1:]]
        function = ir.FunctionType(ir.IntType(32), kinds)
        return builder.call(builder.inttoptr(values[0], function.as_pointer()), values[1:])

    return types.int32(types.intp, *arguments), emit


# Pointers go as integers of their width, which calling conventions of 64-bit machines do not tell apart.


@_intrinsic
def _exchange(_: Any, function: Any, instance: Any, references: Any, size: Any, values: Any) -> Any:
    """Call fmi2Set or fmi2Get of any type."""
    return _call_of(types.intp, types.intp, types.uintp, types.intp)


@_intrinsic
def _do_step(_: Any, function: Any, instance: Any, time: Any, step_size: Any, no_way_back: Any) -> Any:
    """Call fmi2DoStep."""
    return _call_of(types.intp, types.float64, types.float64, types.int32)


@_kernel
def _give(program: Program, i: int) -> int:
    calls, values = program.sends, program.values
    for c in range(calls.of[i], calls.of[i + 1]):
        first, size = calls.first[c], calls.first[c + 1] - calls.first[c]
        for k in range(first, first + size):
            if calls.real[c]:
                calls.reals[k] = values[calls.positions[k]]
            else:
                calls.integers[k] = np.int32(values[calls.positions[k]])
        status = _exchange(calls.function[c], program.instance[i], calls.references_at[c], size, calls.values_at[c])
        if status > WARNING:
            return status
    return 0


@_kernel
def _recorded(buffer: RecordBuffer, n: int, every: int) -> bool:
    """Return whether a point from n + 1 to n + `every` is recorded; those see the outputs fetched at point n."""
    earliest = max(n + 1, buffer.first)
    return earliest + -earliest % buffer.every <= n + every


@_kernel
def _take(program: Program, buffer: RecordBuffer, i: int, n: int) -> int:
    if _recorded(buffer, n, program.every[i]):
        return _fetch(program, program.fetches, i)
    return _fetch(program, program.needed, i)


@_kernel
def _fetch(program: Program, calls: Calls, i: int) -> int:
    values = program.values
    for c in range(calls.of[i], calls.of[i + 1]):
        first, size = calls.first[c], calls.first[c + 1] - calls.first[c]
        status = _exchange(calls.function[c], program.instance[i], calls.references_at[c], size, calls.values_at[c])
        if status > WARNING:
            return status
        if calls.direct[c]:
            continue
        for k in range(first, first + size):
            values[calls.positions[k]] = calls.reals[k] if calls.real[c] else float(calls.integers[k])
    return 0


@_kernel
def _step(program: Program, i: int, n: int) -> int:
    moment = program.start_time + n * program.step_size
    return _do_step(program.do_step[i], program.instance[i], moment, program.step_sizes[i], 1)


@_kernel
def _gauss_seidel(program: Program, buffer: RecordBuffer, n: int) -> tuple[int, int, int]:
    for i in range(len(program.every)):
        if n % program.every[i] == 0:
            status = _give(program, i)
            if status > WARNING:
                return i, SEND, status
            status = _step(program, i, n)
            if status > WARNING:
                return i, STEP, status
            status = _take(program, buffer, i, n)
            if status > WARNING:
                return i, FETCH, status
    return 0, 0, 0


@_kernel
def _jacobi(program: Program, buffer: RecordBuffer, n: int) -> tuple[int, int, int]:
    for i in range(len(program.every)):
        if n % program.every[i] == 0:
            status = _give(program, i)
            if status > WARNING:
                return i, SEND, status
    for i in range(len(program.every)):
        if n % program.every[i] == 0:
            status = _step(program, i, n)
            if status > WARNING:
                return i, STEP, status
    for i in range(len(program.every)):
        if (n + 1) % program.every[i] == 0:
            status = _take(program, buffer, i, n)
            if status > WARNING:
                return i, FETCH, status
    return 0, 0, 0


@_kernel
def _met(conditions: Conditions, values: Array, n: int) -> int:
    """Return the first condition that is met at point n, or -1."""
    for k in range(len(conditions.positions)):
        if n < conditions.since[k]:
            continue
        sign = conditions.signs[k]
        if not sign * values[conditions.positions[k]] > sign * conditions.limits[k]:
            conditions.since[k] = n + 1
        elif n - conditions.since[k] >= conditions.hold[k]:
            return k
    return -1


@_kernel
def _advance(
    program: Program,
    changes: Changes,
    buffer: RecordBuffer,
    conditions: Conditions,
    row: int,
    begin: int,
    end: int,
    last: int,
) -> tuple[int, int, int, int, int, int]:
    """Process the points from `begin` to `end`, the latter excluded, and step from each but the last of the run.

    Returns the last point seen, the number of rows, component, call and status of what failed, and the condition that
    is met or -1.
    """
    change = 0
    for n in range(begin, end):
        while change < len(changes.points) and changes.points[change] == n:
            program.values[changes.positions[change]] = changes.values[change]
            change += 1
        if n >= buffer.first and n % buffer.every == 0:
            for column in range(len(buffer.positions)):
                buffer.table[row, column] = program.values[buffer.positions[column]]
            buffer.points[row] = n
            row += 1
        met = _met(conditions, program.values, n)
        if met >= 0:
            return n, row, 0, 0, 0, met
        if n < last:
            failed, call, status = _jacobi(program, buffer, n) if program.jacobi else _gauss_seidel(program, buffer, n)
            if status > WARNING:
                return n, row, failed, call, status, -1
    return end - 1, row, 0, 0, 0, -1
