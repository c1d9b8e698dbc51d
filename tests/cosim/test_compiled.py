"""The compiled loop compared with the plain one, on components whose C functions are a few lines of Python."""

import math
import sys
import threading
import time
from contextlib import nullcontext
from ctypes import CDLL, c_bool, c_void_p, cast
from itertools import pairwise
from types import SimpleNamespace
from typing import NamedTuple

import numpy as np
import pytest
from c_component import DO_STEP, CComponent

from amb_cosim.cosim.building.loop_library import load_loop
from amb_cosim.cosim.errors import StepFailed
from amb_cosim.cosim.fmu.component import EntryPoints
from amb_cosim.cosim.grid.schedules import PiecewiseConstant, PiecewiseLinear
from amb_cosim.cosim.grid.time_grid import TimeGrid
from amb_cosim.cosim.master import compiled
from amb_cosim.cosim.master.master import Master
from amb_cosim.cosim.record import recorder as record_module
from amb_cosim.cosim.record.recorder import Recorder
from amb_cosim.cosim.system.signal_map import SignalMap
from amb_cosim.cosim.system.stopping import Condition, StopObserver, Stopped
from tests.support.messages import assert_names, raises_naming


@pytest.fixture(scope="module", autouse=True)
def loop(cache):
    if load_loop() is None:
        pytest.skip("there is no compiled loop for this machine, and no compiler to make it")


H = 1e-3
NAMES = ("speed", "slope", "flag", "count", *(f"{c}.{k}" for c in "abc" for k in range(4)))
# By type: the Reals go round, `a` also gets the speed, `b` the slope, `c` count and flag.
SOURCES = ([0, 13, 14, 15], [4, 5, 1, 7], [8, 3, 10, 2])


def machines(every=(1, 1, 1), answers=None):
    trace = []
    return trace, [CComponent(c, m, trace, (answers or {}).get(c)) for c, m in zip("abc", every, strict=True)]


def schedules():
    events = [(-3, 2, 1.0), (5, 3, 4.0), (5, 3, 9.0), (70, 2, 0.0), (70, 3, -2.0), (200, 3, 5.0)]
    return [PiecewiseConstant(events), PiecewiseLinear([(0, 10.0), (33, 10.1), (130, 7.0)], TimeGrid(H), 0, 1)]


class Run(NamedTuple):
    """Recorded points and values by name, calls of the components, last values, exception, last point."""

    points: list
    series: dict
    calls: list
    values: list
    error: tuple | None
    reached: int


RECORDED = ("speed", "slope", "count", "a.0", "a.1", "a.2", "a.3", "c.3", "b.1")


def both(
    first,
    last,
    coupling="gauss_seidel",
    every=(1, 1, 1),
    answers=None,
    keep=0,
    decimation=1,
    stops=(),
    stop=None,
    **ends,
):
    """Return the runs of the plain and the compiled loop; `ends` are options of the master."""
    results = []
    for run in ("plain", "compiled"):
        trace, components = machines(every, answers)
        wiring = SignalMap(NAMES, 4, tuple(np.array(s) for s in SOURCES), ((),) * 16)
        master = Master(components, wiring, H, coupling, start_time=0.1, **ends)
        recorder = Recorder([NAMES.index(name) for name in RECORDED], keep, decimation)
        error = None
        try:
            if run == "plain":
                master.run(first, last, schedules(), [recorder, StopObserver(*stops)], stop)
            else:
                compiled.run(master, first, last, schedules(), recorder, (), StopObserver(*stops), stop=stop)
        except Stopped as stopped:
            error = (stopped.index, stopped.point)
        except StepFailed as failed:
            error = (str(failed), failed.component, failed.time, str(failed.__cause__))
        values = master.values.tolist()
        series = dict(zip(RECORDED, recorder.table.T.tolist(), strict=True))
        results.append(Run(recorder.points.tolist(), series, trace, values, error, recorder.reached))
    return results


@pytest.mark.parametrize("coupling", ["gauss_seidel", "jacobi"])
@pytest.mark.parametrize("every", [(1, 1, 1), (4, 1, 2), (1, 3, 6)])
def test_calls_and_values_equal_those_of_the_plain_loop(coupling, every):
    plain, fast = both(-12, 260, coupling, every, keep=-12)
    assert fast == plain
    assert fast.error is None
    assert fast.points == list(range(-12, 261))
    assert [call[0] for call in fast.calls if call[1] == "step"].count("b") == -(-272 // every[1])
    assert all(len(set(fast.series[name])) > 2 for name in ("speed", "slope", "count", "a.0", "a.1"))


@pytest.mark.parametrize("coupling", ["gauss_seidel", "jacobi"])
@pytest.mark.parametrize("last", [1, 199, 200])
def test_a_shorter_last_step_is_the_same_in_both_loops(coupling, last):
    size, begin = 0.4 * H, last - 1
    ends = {"end": (last, 0.1 + begin * H + size), "last_steps": dict.fromkeys(range(3), (begin, size))}
    plain, fast = both(0, last, coupling, **ends)
    assert fast == plain
    sizes = [call[4] for call in fast.calls if call[1] == "step"]
    assert sizes == [H] * 3 * begin + [size] * 3


def test_both_loops_stop_before_a_point():
    plain, fast = both(0, 260, stop=90)
    assert fast == plain
    assert fast.points == list(range(90))


@pytest.mark.parametrize("coupling", ["gauss_seidel", "jacobi"])
@pytest.mark.parametrize("call", ["Set", "DoStep", "Get"])
@pytest.mark.parametrize("component", ["a", "c"])
def test_a_failed_call_ends_both_loops_at_the_same_point(coupling, call, component):
    plain, fast = both(0, 260, coupling, (2, 1, 2), {component: {(call, 0.1 + 90 * H): 3}})
    assert fast == plain
    assert fast.error[1] == component
    assert fast.error[3] == f"{call} answered 3"
    assert 90 <= fast.points[-1] <= 92


@pytest.mark.parametrize("status", [1, 2, 3, 4, 5])
def test_every_status_worse_than_a_warning_ends_the_run(status):
    plain, fast = both(0, 120, answers={"b": {("DoStep", 0.1 + 90 * H): status}})
    assert fast == plain
    assert fast.points == list(range(91 if status > 1 else 121))
    if status > 1:
        assert_names(fast.error[0], "b", "0.19 s", "DoStep", f"{status}")


@pytest.mark.parametrize("block_time", [0.0, 1e9])
def test_results_do_not_depend_on_blocks_of_steps(block_time, monkeypatch):
    monkeypatch.setattr(compiled, "BLOCK_TIME", block_time)
    plain, fast = both(-12, 700, every=(4, 1, 2), keep=-12)
    assert fast == plain


@pytest.mark.parametrize("coupling", ["gauss_seidel", "jacobi"])
@pytest.mark.parametrize("every", [(1, 1, 1), (4, 1, 2), (1, 3, 6)])
@pytest.mark.parametrize(("keep", "decimation"), [(0, 1), (-9, 4), (7, 5), (500, 1), (0, 1000)])
def test_signals_that_are_only_recorded_are_fetched_at_recorded_points(coupling, every, keep, decimation):
    plain, fast = both(-12, 260, coupling, every, keep=keep, decimation=decimation)
    assert (fast.points, fast.series) == (plain.points, plain.series), "the same is recorded"
    assert fast.points == [n for n in range(-12, 261) if n >= keep and n % decimation == 0]
    assert [call for call in fast.calls if call[1] != "get"] == [call for call in plain.calls if call[1] != "get"]
    read = {"a": {107, 108, 110}, "b": {107, 109}, "c": {108, 109, 110}}  # by SOURCES
    for name, m in zip("abc", every, strict=True):
        fetched = fetches(fast.calls, name)
        assert len(fetched) == -(-272 // m)
        for k, references in enumerate(fetched):
            seen = range(-12 + m * k + 1, -12 + m * k + m + 1)  # points at which its values are the present ones
            if coupling == "jacobi":
                seen = range(seen.start + m - 1, seen.stop + m - 1)
            if seen.start > 260:
                break  # the run ends before
            is_recorded = any(n >= keep and n % decimation == 0 for n in seen)
            assert references == ({107, 108, 109, 110} if is_recorded else read[name]), (name, k)


def fetches(trace, name):
    """Return the references read from a component after each of its steps."""
    result = []
    for call in trace:
        if call[0] == name and call[1] == "step":
            result.append(set())
        elif call[0] == name and call[1] == "get":
            result[-1] |= set(call[4])
    return result


def condition(signal, side, limit, first=0, hold=0):
    return [Condition(signal, side == "above", limit, first, hold, "")], [NAMES.index(signal)]


@pytest.mark.parametrize("coupling", ["gauss_seidel", "jacobi"])
@pytest.mark.parametrize("decimation", [1, 7])
@pytest.mark.parametrize(
    ("stops", "point"),
    [
        # The speed rises from 10 at point 0 to 10.1 at 33, and falls to 7 at 130.
        (condition("speed", "above", 10.05), 17),
        (condition("speed", "above", 10.05, hold=9), 26),
        (condition("speed", "above", 10.05, first=20), 20),
        (condition("speed", "above", 10.05, first=20, hold=9), 29),
        (condition("speed", "below", 8.0), 99),
        (condition("flag", "below", 1.0), 70),
        (condition("speed", "above", 7.0, hold=129), 129),
        (condition("speed", "above", 7.0, hold=130), None),
        (condition("speed", "above", 10.1), None),
        (condition("c.0", "above", 1e9), None),
    ],
)
def test_a_condition_ends_both_loops_at_the_same_point(coupling, decimation, stops, point):
    plain, fast = both(-12, 260, coupling, (4, 1, 2), decimation=decimation, stops=stops)
    assert (fast.points, fast.series) == (plain.points, plain.series)
    assert (fast.error, fast.reached) == (plain.error, plain.reached)
    assert fast.error == (None if point is None else (0, point))
    reached = 260 if point is None else point
    assert fast.reached == reached
    assert fast.points == list(range(0, reached + 1, decimation))


def test_a_condition_sees_outputs_that_are_neither_read_nor_recorded():
    whole, _ = both(0, 260)
    first = next(n for n, value in zip(whole.points, whole.series["a.2"], strict=True) if value < -100.0)
    plain, fast = both(0, 260, keep=500, stops=condition("a.2", "below", -100.0))
    assert 1 < first < 260
    assert fast.points == plain.points == []
    assert fast.error == plain.error == (0, first)


def ticking(**options):
    wiring = SignalMap(NAMES, 4, tuple(np.array(s) for s in SOURCES), ((),) * 16)
    return Master(machines(**options)[1], wiring, H)


def test_observers_are_called_between_blocks_and_at_the_end():
    seen, recorder = [], Recorder([4], 0)
    master = ticking()
    compiled.run(master, -10, 1500, [], recorder, [lambda n, values: seen.append((n, recorder.points.tolist()))])
    reached = [n for n, _ in seen]
    assert -1 in reached, "the clock of the record starts with point 0, and so a block does"
    assert reached[-1] == 1500
    assert len(reached) > 2
    assert all(a < b for a, b in pairwise(reached))
    assert all(points == list(range(n + 1)) for n, points in seen)


def test_blocks_after_a_short_one_are_as_long_as_before(monkeypatch):
    monkeypatch.setattr(compiled, "CLOCK", SimpleNamespace(flag=lambda: nullcontext(c_bool(False))))
    monkeypatch.setattr(compiled, "BLOCK_TIME", math.inf)
    seen = []
    compiled.run(ticking(), -2, 1500, [], Recorder([4], 0), [lambda n, values: seen.append(n)])
    assert seen == [-1, 1023, 1500], "the first block ends with point -1, after two steps"


@pytest.mark.parametrize("coupling", ["gauss_seidel", "jacobi"])
@pytest.mark.parametrize("answers", [None, {"b": {("DoStep", -5 * H): 3}}])
def test_steps_alone_equal_those_of_the_plain_loop(coupling, answers):
    results = []
    for run in ("plain", "compiled"):
        trace, components = machines(answers=answers)
        wiring = SignalMap(NAMES, 4, tuple(np.array(s) for s in SOURCES), ((),) * 16)
        master, error = Master(components, wiring, H, coupling), ""
        master.exogenous[:] = 10.0, 0.5, 1.0, 3.0
        try:
            if run == "plain":
                master.run(-40, 20)
            else:
                compiled.step(master, -40, 20, StopObserver(), Recorder([], 0))
        except StepFailed as failed:
            error = str(failed)
        calls = [call for call in trace if call[1] != "get"]  # what no component reads is not fetched
        results.append((calls, error, master.values[np.concatenate(wiring.sources)].tolist()))
    assert results[1] == results[0]
    assert bool(error) == bool(answers)


def test_an_interrupt_between_blocks_keeps_the_record():
    recorder = Recorder([4], 0)

    def stop(n, values):
        if n > 100:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        compiled.run(ticking(), 0, 100_000, [], recorder, [stop])
    assert 100 < recorder.reached < 2000
    assert recorder.points.tolist() == list(range(recorder.reached + 1))


@pytest.mark.slow  # measures time
def test_slow_steps_end_their_block(monkeypatch):
    """After 5000 fast steps blocks have thousands; then 25 steps take the time that a block should."""
    monkeypatch.setattr(compiled, "BLOCK_TIME", 0.2)
    sleeper, seen = CComponent("sleeper"), []

    def step(instance, moment, step_size, no_way_back):
        if moment > 5000 * H:
            time.sleep(0.008)
        return 0

    c_step = DO_STEP(step)
    sleeper.entry_points = lambda: EntryPoints(0, cast(c_step, c_void_p).value, (), ())
    master = Master([sleeper], SignalMap(("a", "b", "c", "d"), 0, (np.array([], dtype=int),), ((),) * 4), H)
    compiled.run(master, 0, 5150, [], Recorder([0], 0), [lambda n, _: seen.append(n)])
    assert sum(n > 5000 for n in seen) > 3


def test_a_slow_component_cannot_start_between_its_points():
    with raises_naming(ValueError, "b", "4 communication points", "-3"):
        compiled.run(ticking(every=(1, 4, 1)), -3, 0, [], Recorder([4], 0))


def test_wall_time_starts_at_point_0():
    recorder, clock = Recorder([4], 0), []
    master = ticking()
    step = time.perf_counter
    compiled.run(master, -300, 0, [], recorder, [lambda n, values: clock.append(step())])
    assert recorder.wall_time < clock[-1] - clock[0]


@pytest.mark.slow  # measures time
@pytest.mark.skipif(sys.platform == "win32", reason="needs usleep")
def test_other_threads_run_while_the_loop_does():
    """The step is the C library's `usleep`, whose argument is the instance: no Python runs during a block."""
    sleeper = CComponent("sleeper")
    entries = EntryPoints(3000, cast(CDLL(None).usleep, c_void_p).value, (), ())
    sleeper.entry_points = lambda: entries
    stop, ticks = threading.Event(), []

    def tick():
        while not stop.wait(0.002):
            ticks.append(time.perf_counter())

    master = Master([sleeper], SignalMap(("a", "b", "c", "d"), 0, (np.array([], dtype=int),), ((),) * 4), H)
    compiled.run(master, 0, 1, [], Recorder([0], 0))
    thread = threading.Thread(target=tick)
    thread.start()
    compiled.run(master, 0, 60, [], Recorder([0], 0))
    stop.set()
    thread.join()
    assert len(ticks) > 5


def test_a_record_of_more_than_the_memory_is_refused_before_the_run(monkeypatch):
    """Linux promises more memory than there is, and kills the process that uses it."""
    with pytest.raises(ValueError, match=r" 9 variables .* \d+ points.* record\.variables"):
        Recorder(range(9), 0).buffer(0, 2**55)
    monkeypatch.setattr(record_module, "physical_memory", lambda: 1e6)
    recorder = Recorder(range(9), 0, 10, each=range(3))
    recorder.buffer(0, 10_000)
    recorder.buffer(0, 20_000, may_stop=True)
    with pytest.raises(ValueError, match=r"of 9 variables .* 3 of them .* 1\.\d+ GB .*record\.variables") as refused:
        recorder.buffer(0, 20_000_000)
    assert "0.001 GB" in str(refused.value)
