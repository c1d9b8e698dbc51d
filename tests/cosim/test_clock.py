"""The clock that the runs of a process share."""

import multiprocessing
import sys
import threading
from ctypes import c_bool

import pytest
from waiting import LONGEST, wait_until

from amb_cosim.cosim.processes.clock import Clock


def is_raised(flag: c_bool) -> bool:
    wait_until(lambda: flag.value, 0.001)
    return True


def test_flags_are_raised_periodically_while_in_use():
    clock = Clock(0.005)
    with clock.flag() as first, clock.flag() as second:
        for _ in range(3):
            assert is_raised(first)
            assert is_raised(second)
            first.value = second.value = False


def clocks() -> set[threading.Thread]:
    """Other threads of the process may end at any time."""
    return {thread for thread in threading.enumerate() if thread.name == "amb-cosim clock"}


def test_runs_share_a_thread_that_ends_after_the_last():
    clock, before = Clock(0.05), clocks()
    with clock.flag():
        (thread,) = clocks() - before
    for _ in range(20):
        with clock.flag():
            assert clocks() - before == {thread}
    thread.join(timeout=LONGEST)
    assert not thread.is_alive()
    with clock.flag() as flag:
        assert is_raised(flag)


@pytest.mark.skipif(sys.platform != "linux", reason="processes are forked")
@pytest.mark.filterwarnings("ignore:.*multi-threaded.*:DeprecationWarning")
def test_a_forked_process_starts_a_new_clock():
    clock = Clock(0.005)

    def child(answer) -> None:
        with clock.flag() as flag:
            answer.put(is_raised(flag))

    context = multiprocessing.get_context("fork")
    with clock.flag():
        answer = context.Queue()
        process = context.Process(target=child, args=(answer,))
        process.start()
        assert answer.get(timeout=LONGEST)
        process.join()
