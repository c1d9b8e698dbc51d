"""Hosts that make the calls of well-known importers in their order, written against the standard.

Each returns how its run ended and when. None of them may take a fault for an end that the model wanted.
"""

import math
from collections.abc import Callable
from ctypes import byref, c_char_p, c_double, c_int, c_size_t

import pytest

Input = Callable[[float], float]


@pytest.fixture(scope="module")
def library(unpacked, lag):
    from raw import Library

    return Library(unpacked(lag))


@pytest.fixture(scope="module")
def library3(unpacked, lag):
    from raw import Library3

    return Library3(unpacked(lag, None, None, 3))


def is_close(a, b):
    return abs(a - b) <= 1e-12 * max(abs(a), abs(b))


def with_regular_points(fmu, stop, h, u: Input):
    """As FMPy and fmusim do: points at multiples of the interval, a shorter last step, and what fmi2Discard means."""
    fmu.set(gain=2.0)
    fmu.setup(0.0, stop)
    fmu.call("EnterInitializationMode")
    fmu.set(u=u(0.0))
    if fmu.call("ExitInitializationMode") > 1:
        return "failed", 0.0
    time, n = 0.0, 0
    while not (time > stop or is_close(time, stop)):
        point = (n + 1) * h
        if point > stop and not is_close(point, stop):
            point = stop
        fmu.set(u=u(time))
        status = fmu.call("DoStep", c_double(time), c_double(point - time), 1)
        if status == 2:
            ended = c_int()
            fmu.call("GetBooleanStatus", 3, byref(ended))
            if ended.value:
                return "ended by the model", fmu.last_time()
        elif status > 2:
            return "failed", time
        else:
            time = point
        n += is_close(time, (n + 1) * h)
        fmu.get("y")
    return ("finished", time) if fmu.call("Terminate") == 0 else ("failed", time)


def with_a_sum_of_steps(fmu, stop, h, u: Input):
    """As the checker of FMI Library does: time is summed, the last step ends at the stop time, results come first."""
    fmu.call("SetDebugLogging", 1, c_size_t(0), (c_char_p * 1)())
    fmu.set(gain=2.0)
    fmu.call("SetupExperiment", 1, c_double(1e-4), c_double(0.0), 1, c_double(stop))
    fmu.call("EnterInitializationMode")
    if fmu.call("ExitInitializationMode") > 1:
        return "failed", 0.0
    time, status = 0.0, 0
    while time < stop and status <= 1:
        after = time + h
        if after > stop - 1e-3 * h:
            h, after = stop - time, stop
        fmu.set(u=u(time))
        status = fmu.call("DoStep", c_double(time), c_double(h), 1)
        time = after
        fmu.get("y", "steps", "held")
        if status == 2:
            time, ended = fmu.last_time(), c_int()
            if fmu.call("GetBooleanStatus", 3, byref(ended)) == 0 and ended.value:
                status = 0
                break
    fmu.call("Terminate")
    return "failed" if status > 1 else "finished", time


def without_a_stop_time(fmu, stop, h, u: Input):
    """As fmi4c and many masters do: no stop time, whole steps until it is passed, and a goodbye whatever happened."""
    fmu.setup()
    fmu.call("EnterInitializationMode")
    fmu.set(gain=2.0, u=u(0.0))
    fmu.call("ExitInitializationMode")
    time, status = 0.0, 0
    while time < stop and status == 0:
        fmu.set(u=u(time))
        status = fmu.call("DoStep", c_double(time), c_double(h), 1)
        if status == 0:
            fmu.get("y")
            time += h
    fmu.call("Terminate")
    return "failed" if status else "finished", time


def in_version_3(fmu, stop, h, u: Input):
    """As FMPy and fmusim do with FMI 3.0."""
    fmu.set(gain=2.0)
    fmu.enter(0.0, stop)
    fmu.set(u=u(0.0))
    if fmu.call("ExitInitializationMode") > 1:
        return "failed", 0.0
    time, n = 0.0, 0
    while not (time > stop or is_close(time, stop)):
        point = (n + 1) * h
        if point > stop and not is_close(point, stop):
            point = stop
        fmu.set(u=u(time))
        status, (event, ended, early), last = fmu.do_step(time, point - time)
        if status > 1 or event or early:
            return "failed", time
        time = point
        assert last == time
        n += is_close(time, (n + 1) * h)
        fmu.get("y", "time")
        if ended:
            return "ended by the model", time
    return ("finished", time) if fmu.call("Terminate") == 0 else ("failed", time)


# None of these programs is run: what a test runs is their calls in their order.
AS_HOSTS = pytest.mark.host(
    "calls as FMPy and fmusim, the checker of FMI Library, and fmi4c make them, without these programs",
    fmus="a probe, FMI 2.0 and 3.0",
    what="ends at its stop time; a fault is a failure with its reason",
)
HOSTS = (with_regular_points, with_a_sum_of_steps, without_a_stop_time, in_version_3)


@pytest.fixture(params=HOSTS, ids=lambda host: host.__name__)
def host(request, library, library3):
    """`host(stop, h, u)`: how the run ended, when, and the instance after it."""
    open_instances = []

    def run(stop, h, u):
        fmu = (library3 if request.param is in_version_3 else library).instantiate()
        open_instances.append(fmu)
        return *request.param(fmu, stop, h, u), fmu

    run.overshoots = request.param is without_a_stop_time
    yield run
    for fmu in open_instances:
        fmu.__exit__()


@AS_HOSTS
@pytest.mark.parametrize("h", [1e-3, 3e-4, 7e-3])
def test_a_run_ends_at_the_stop_time_whatever_the_last_step(host, h):
    outcome, time, fmu = host(0.05, h, lambda t: 1.0)
    assert outcome == "finished"
    assert time == pytest.approx(0.05, abs=h if host.overshoots else 1e-12)
    assert fmu.get("y") == [pytest.approx(2.0 * (1.0 - math.exp(-time / 1e-3)), rel=1e-9)]
    assert fmu.log == []


@AS_HOSTS
def test_a_fault_ends_a_run_as_a_failure_with_its_reason(host):
    outcome, time, fmu = host(0.05, 1e-3, lambda t: 5.0 if t > 0.0195 else 1.0)
    assert outcome == "failed"
    assert time == pytest.approx(0.02, abs=1.1e-3)
    assert fmu.log[0][0] == 3
    assert fmu.log[0][2].startswith("at t = 0.02 s: u = 5 V is 100 %")
    assert fmu.get("fault_code") == [1]


@pytest.mark.parametrize("h", [0.0, -1e-3, math.nan])
def test_a_wrong_step_size_ends_a_run_as_a_failure_with_the_reason(library, library3, h):
    for item, host in ((library, with_a_sum_of_steps), (library, without_a_stop_time), (library3, None)):
        with item.instantiate() as fmu:
            if host:
                assert host(fmu, 0.05, h, lambda t: 1.0)[0] == "failed"
            else:
                assert fmu.begin().do_step(0.0, h)[0] == 3
            said = f"at t = 0 s: step size = {h:g} s is not allowed; it must be > 0 s and finite"
            assert said in [text for _, _, text in fmu.log]
            assert fmu.get("fault_code") == [999]
