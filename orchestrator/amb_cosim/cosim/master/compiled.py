"""The data of a run for the compiled master loop, `loop.c`, which calls FMI functions directly.

The compiled loop repeats the loop in `master`, the readable reference, operation by operation, and records the same
values to the last bit. Outputs that no component reads are fetched only when they are recorded, whereas `master`
fetches them at every point. The run consists of blocks of steps, between which Python checks for interrupts and reports
progress. If steps are slow, a clock ends a block early.

The loop runs without the interpreter lock. FMUs that contain Python acquire this lock for each of their calls, as in
any host.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Sequence
from ctypes import Structure, byref, c_bool, c_double, c_ssize_t, c_void_p
from functools import cache
from typing import Any, NamedTuple, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from amb_cosim.cosim.building.loop_library import load_loop
from amb_cosim.cosim.fmu.component import EntryPoints
from amb_cosim.cosim.fmu.exchange import Transfer
from amb_cosim.cosim.grid.schedules import Changes, Schedule
from amb_cosim.cosim.master.master import Master, Observer, Participant
from amb_cosim.cosim.processes.clock import Clock
from amb_cosim.cosim.record.finite_watch import FiniteWatch
from amb_cosim.cosim.record.recorder import RecordBuffer, Recorder
from amb_cosim.cosim.system.stopping import StopObserver, Stopped
from array_types import Array, Bools, Indices

CALLS = ("Set", "DoStep", "Get")
WARNING = 1  # highest status of a successful call
BLOCK_TIME = 0.05  # s; Python checks for interrupts about that often
FIRST = 1024  # steps of the first block, which ends earlier if they are slow
WATCHED = 4096  # steps of the longest block with watched values
CLOCK = Clock(BLOCK_TIME)


class Addressable(Participant, Protocol):
    """A participant whose FMI functions can be called by address."""

    def entry_points(self) -> EntryPoints: ...
    def refusal(self, call: str, status: int) -> Exception: ...


class Calls(NamedTuple):
    """All calls that set variables of components, or all calls that get them, in sequence.

    Component i has the calls from `of[i]` up to but not including `of[i + 1]`. Likewise, call c moves the variables
    from `first[c]` to `first[c + 1]` between their `positions` in the value array and `reals` or `integers`, where the
    FMU reads or writes them. The call has two addresses as arguments: `references_at[c]`, within `references`, and
    `values_at[c]`, within `reals` or `integers`. If `direct[c]` is set, `values_at[c]` is instead within the value
    array itself.
    """

    of: Indices
    function: Indices
    references_at: Indices
    values_at: Indices
    real: Bools
    direct: Bools
    first: Indices
    positions: Indices
    references: NDArray[np.uint32]
    reals: Array
    integers: NDArray[np.int32]


class _Program(NamedTuple):
    """The data of a master as arrays; `step_sizes` are the step sizes of the components (s).

    `fetches` get all outputs; `needed` get only the outputs that are used at every point, recorded or not. At a
    recorded point, `fetches` get all outputs at once, because additional calls would cost more than the additional
    values.
    """

    instance: Indices
    do_step: Indices
    every: Indices
    step_sizes: Array
    sends: Calls
    fetches: Calls
    needed: Calls
    values: Array
    start_time: float
    step_size: float
    jacobi: bool


C = TypeVar("C", bound=Addressable)
Programs = dict[tuple[Any, ...], Structure]  # by what they are made from, while the components exist
_NOTHING = Changes(np.zeros(0, np.intp), np.zeros(0, np.intp), np.zeros(0))
_TYPES: dict[type, Any] = {np.ndarray: c_void_p, bool: c_bool, float: c_double, int: c_ssize_t}


class End(Structure):
    """End of a block of steps: last point reached, number of rows, failed call, and the condition met (-1 if none)."""

    _fields_ = [(name, c_ssize_t) for name in ("reached", "row", "component", "call", "status", "met")]


def run(
    master: Master[C],
    first: int,
    last: int,
    schedules: Sequence[Schedule],
    recorder: Recorder,
    observers: Sequence[Observer] = (),
    stops: StopObserver | None = None,
    programs: Programs | None = None,
    stop: int | None = None,
    watch: FiniteWatch | None = None,
) -> None:
    """Advance from communication point `first` to `last` like `Master.run`.

    Parameters
    ----------
    master
        The master, initialised, with components that have entry points.
    first, last, schedules
        As for `Master.run`.
    recorder
        Records every point, including the last.
    observers
        Called about every 50 ms with the last point reached and the values after it; values that are only recorded may
        be older.
    stops
        Conditions that are checked at every point, after the point has been recorded.
    programs
        Data of earlier runs of these components, to which the data of this run are added.
    stop
        As for `Master.run`.
    watch
        Watch that receives the values at its positions for every point.

    Raises
    ------
    StepFailed
        If a component does not complete a step. The recorder has seen everything up to that step.
    Stopped
        If a condition of `stops` is met. The recorder has seen everything up to that step.
    """
    advance = load_loop()
    if advance is None:
        raise ValueError("there is no compiled loop for this machine, and no compiler to make it")
    master.check_start(first)
    stops = stops or StopObserver()
    conditions = stops.conditions
    may_stop = len(conditions.positions) > 0
    program = _program_of(master, stops, recorder, programs)
    buffer, row = recorder.buffer(first, last, may_stop), len(recorder.points)
    rows, limits = structure_of(buffer), structure_of(conditions)
    watching = None if watch is None or not len(watch.positions) else watch
    by_block = watching is not None or recorder.step_rows.steps > 1
    begin, size, outcome = first, FIRST, End()
    until = last + 1 if stop is None else stop
    shorter = {max(first, point) for point, _ in master.last_steps.values()}
    with CLOCK.flag() as pause:
        while begin < until:
            # Point 0 begins a block, because the recorder's clock starts there; so do the points of shorter last steps.
            end = min(begin + size, *(point for point in (0, *shorter, until) if point > begin))
            if begin in shorter:
                sizes = np.array([master.step_size_of(i, begin) for i in range(len(master.components))])
                program = structure_of(program.data._replace(step_sizes=sizes))
            if by_block:
                end = min(end, begin + WATCHED)
                block = _block(buffer, watching, begin, end)
                rows = structure_of(block)
            changes = _merged([schedule.changes(begin, end) for schedule in schedules])
            recorder.see(begin)
            started, pause.value = time.perf_counter(), False
            changed = _UNCHANGED if changes is _NOTHING else structure_of(changes)
            advance(*map(byref, (program, changed, rows, limits)), row, begin, end, last, byref(pause), byref(outcome))
            row, reached = outcome.row, outcome.reached
            if by_block:
                _see(watching, recorder, block, begin, reached)
            recorder.fill(row, reached)
            recorder.see(reached)
            if outcome.met >= 0:
                raise Stopped(outcome.met, reached)
            _check(master, outcome)
            for observe in observers:
                observe(reached, master.values)
            taken, done = time.perf_counter() - started, reached + 1 - begin
            if taken < BLOCK_TIME / 4:
                size = max(size, 4 * done)  # a block that ends at a point above may have few steps
            else:
                size = max(1, done // 2) if taken > BLOCK_TIME else done
            begin = reached + 1


def step(
    master: Master[C], first: int, last: int, stops: StopObserver, recorder: Recorder, programs: Programs | None = None
) -> None:
    """Step from one point to another like `Master.run`, but without schedules, recording, conditions or pauses.

    Parameters
    ----------
    master, first, last, stops, recorder, programs
        As for `run`; `stops` and `recorder` only determine which outputs are read at every point.

    Raises
    ------
    StepFailed
        If a component does not complete a step.
    """
    advance, outcome = load_loop(), End()
    assert advance is not None, "there is no compiled loop"
    program = _program_of(master, stops, recorder, programs)
    structures = map(byref, (program, _UNCHANGED, _UNRECORDED, _UNCONDITIONAL))
    advance(*structures, 0, first, last, last, byref(c_bool(False)), byref(outcome))
    _check(master, outcome)


def _check(master: Master[C], outcome: End) -> None:
    """Raise StepFailed if a component did not complete a step."""
    if not 0 <= outcome.status <= WARNING:
        component = master.components[outcome.component]
        reason = component.refusal(CALLS[outcome.call], outcome.status)
        raise master.failure(component, outcome.reached, reason) from reason


def _block(buffer: RecordBuffer, watch: FiniteWatch | None, begin: int, end: int) -> RecordBuffer:
    """Return the buffer of a block of steps, with additional columns for the values that are watched."""
    every = buffer.steps_positions if watch is None else np.concatenate([buffer.steps_positions, watch.positions])
    table = np.zeros((end - begin, len(every)))
    return buffer._replace(steps_positions=every, steps_size=len(every), steps_first=begin, steps_table=table)


def _see(watch: FiniteWatch | None, recorder: Recorder, block: RecordBuffer, begin: int, reached: int) -> None:
    """Pass the values at the points of a block to a watch, and record those that are stored at every point."""
    first, n_recorded = max(begin, block.first), len(recorder.each)
    rows = block.steps_table[first - begin : reached + 1 - begin]
    if n_recorded and len(rows):
        recorder.step_rows.add(rows[:, :n_recorded])
    if watch is not None:
        watch.see(range(first, first + len(rows)), rows[:, n_recorded:])


def _program_of(master: Master[C], stops: StopObserver, recorder: Recorder, programs: Programs | None) -> Structure:
    """Return the data of a master as a C structure, which is reused if `programs` contains an equal one.

    Quantities of stop conditions, and quantities that are recorded at every point, are read at every point.
    """
    every = [component.every for component in master.components]
    judged = tuple(stops.conditions.positions.tolist()), tuple(recorder.each.tolist())
    key = master.values.ctypes.data, master.wiring.names, master.coupling, master.grid, tuple(every), judged
    programs = {} if programs is None else programs
    if key in programs:
        return programs[key]
    entries = [component.entry_points() for component in master.components]
    fetches = [entry.fetches for entry in entries]
    places = [np.arange(slot.start, slot.stop) for slot in master.slots]
    used = np.zeros(len(master.values), np.bool_)
    for positions in (*master.wiring.sources, stops.conditions.positions, recorder.each):
        used[positions] = True
    program = _Program(
        instance=np.array([entry.instance for entry in entries], np.intp),
        do_step=np.array([entry.do_step for entry in entries], np.intp),
        every=np.array(every, np.intp),
        step_sizes=np.array([m * master.step_size for m in every], np.float64),
        sends=_calls([entry.sends for entry in entries], master.wiring.sources),
        fetches=_calls(fetches, places, master.values),
        needed=_calls([_only(used[place], group) for group, place in zip(fetches, places, strict=True)], places),
        values=master.values,
        start_time=float(master.grid.start),
        step_size=float(master.step_size),
        jacobi=master.coupling == "jacobi",
    )
    programs[key] = structure_of(program)
    return programs[key]


def _only(used: Bools, transfers: Sequence[Transfer]) -> list[Transfer]:
    """Return the transfers of those outputs that are used."""
    masks = [used[t.where] for t in transfers]
    return [t if keep.all() else t.only(keep) for t, keep in zip(transfers, masks, strict=True) if keep.any()]


def _calls(transfers: Sequence[Sequence[Transfer]], places: Sequence[Indices], values: Array | None = None) -> Calls:
    """Collect the transfers of all components; `places` are positions of their variables in the value array.

    If `values` is passed, FMUs write Reals with consecutive positions in `values` directly to this array.
    """
    flat = [t for group in transfers for t in group]
    positions = [place[t.where] for group, place in zip(transfers, places, strict=True) for t in group]
    references = np.concatenate([np.zeros(0, np.uint32), *(t.references for t in flat)])
    first = _ends([len(t.where) for t in flat])
    reals, integers = np.zeros(first[-1]), np.zeros(first[-1], np.int32)
    real = np.array([t.real for t in flat], np.bool_)
    values_at = np.where(real, _addresses(reals, first[:-1]), _addresses(integers, first[:-1]))
    direct = np.zeros(len(flat), np.bool_)
    for c, at in enumerate(positions):
        if values is not None and real[c] and np.all(np.diff(at) == 1):
            direct[c], values_at[c] = True, _addresses(values, at[:1])[0]
    return Calls(
        of=_ends([len(group) for group in transfers]),
        function=np.array([t.function for t in flat], np.intp),
        references_at=_addresses(references, _ends([len(t.references) for t in flat])[:-1]),
        values_at=values_at,
        real=real,
        direct=direct,
        first=first,
        positions=np.concatenate([np.zeros(0, np.intp), *positions]),
        references=references,
        reals=reals,
        integers=integers,
    )


def _addresses(items: NDArray[Any], at: Indices) -> Indices:
    return items.ctypes.data + at * items.itemsize


def _ends(lengths: Sequence[int]) -> Indices:
    return np.cumsum([0, *lengths], dtype=np.intp)


def _merged(changes: Sequence[Changes]) -> Changes:
    """Merge the changes of several schedules in order of time; at the same point the last schedule wins."""
    if not any(len(each.points) for each in changes):
        return _NOTHING
    points, positions, values = (np.concatenate(parts) for parts in zip(_NOTHING, *changes, strict=True))
    order = np.argsort(points, kind="stable")
    return Changes(points[order], positions[order], values[order])


def structure_of(data: Any) -> Structure:
    """Return a NamedTuple as a C structure: arrays as their addresses, and the length of the first array at the end.

    The structure keeps the arrays alive.
    """
    size = next(len(value) for value in data if isinstance(value, np.ndarray))
    members = [_member(value) for value in data]
    types = tuple(_TYPES.get(type(value)) or type(member) for value, member in zip(data, members, strict=True))
    record: Any = type(data)
    structure = _structure_type(record, types)(*members, size)
    structure.data = data
    return structure


@cache
def _structure_type(record: Any, types: tuple[type[Any], ...]) -> Any:
    fields = list(zip((*record._fields, "size"), (*types, c_ssize_t), strict=True))
    return type(record.__name__, (Structure,), {"_fields_": fields})


def _member(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        return value.ctypes.data
    return structure_of(value) if isinstance(value, tuple) else value


_UNCHANGED = structure_of(_NOTHING)
_UNRECORDED = structure_of(Recorder([], sys.maxsize).buffer(0, 0))
_UNCONDITIONAL = structure_of(StopObserver().conditions)
