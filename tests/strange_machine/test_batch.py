"""Members of a batch of the expander are runs of it."""

from __future__ import annotations

import gc
import pickle
import signal
import sys
import threading
import time
from contextlib import suppress

import numpy as np
import pytest
from strange_machine import RUB

import amb_cosim
from amb_cosim.scenario.scenario import Scenario
from tests.support.messages import raises_naming

SHORT = Scenario.load(RUB).changed(end_cycle=9)
STEPS = 80 * 8
PLACES = [f"rotor_contact.{place}.{axis}" for place in ("north", "south", "labyrinth") for axis in "xy"]
FRICTION = [0.05, 0.08, 0.08, 0.2, 0.3]
MU, UNBALANCE = "rotor_contact.shroud.mu", "rotor_contact.turbine.u"


def motion(batch):
    return np.array([batch.get(name).copy() for name in PLACES])


def batch_of(n=5, **options):
    return amb_cosim.Batch(SHORT, n, **({"set": {MU: FRICTION[:n]}, "variables": ["rotor_contact.*"]} | options))


@pytest.fixture(scope="module")
def batch():
    with batch_of(threads=2) as members:
        yield members


@pytest.fixture(scope="module")
def alone():
    """The rows of runs alone, shape (members, steps, places)."""
    runs = [amb_cosim.run(SHORT, set={MU: mu}) for mu in FRICTION]
    return np.array([[run.signals[name].values for name in PLACES] for run in runs]).swapaxes(1, 2)


def test_members_have_the_bits_of_runs_alone(batch, alone):
    batch.reset()
    for steps in (1, 7, 472, 160):  # into the rub
        batch.step(steps)
        n = round(batch.time[0] / batch.step_size)
        assert np.array_equal(motion(batch).T, alone[:, n])
    assert np.ptp(motion(batch)[:, [0, 4]], axis=1).all()


@pytest.mark.parametrize("threads", [1, 3, 5])
def test_the_number_of_threads_changes_no_bit(batch, threads):
    batch.reset()
    batch.step(STEPS)
    with batch_of(threads=threads) as other:
        other.step(STEPS)
        assert np.array_equal(motion(other), motion(batch))


def test_members_step_without_the_lock_of_the_interpreter(batch, monkeypatch):
    """Another thread runs while the loop does: else it would wait for the lock until a step ends."""
    advance, within = batch._members._advance, threading.Event()

    def watched(*arguments):
        within.set()
        advance(*arguments)
        within.clear()

    batch.reset()
    monkeypatch.setattr(batch._members, "_advance", watched)
    before, looked = sys.getswitchinterval(), 0
    sys.setswitchinterval(10.0)  # s; who has the lock keeps it until it waits
    try:
        stepping = threading.Thread(target=batch._members._step, args=((0, 5), STEPS))
        stepping.start()
        while stepping.is_alive():
            looked += within.is_set()
            time.sleep(1e-4)
    finally:
        sys.setswitchinterval(before)
    stepping.join()
    assert looked > 2


def test_members_that_are_reset_begin_again_by_themselves(batch, alone):
    batch.reset()
    batch.step(STEPS)
    batch.reset([True, False, False, True, False])
    batch.step(20)
    assert batch.time == pytest.approx(batch.step_size * np.array([20, 660, 660, 20, 660]))
    assert np.array_equal(motion(batch).T[[0, 3]], alone[[0, 3], 20])
    assert np.array_equal(motion(batch).T[[1, 2, 4]], alone[[1, 2, 4], 660])


def test_states_are_brought_back_to_the_bit(batch):
    batch.reset()
    batch.step(STEPS)
    states = batch.save()
    batch.step(50)
    first = motion(batch)
    batch.restore(states)
    batch.step(50)
    assert np.array_equal(motion(batch), first)


def test_what_is_set_holds_for_its_members_alone(batch, alone):
    batch.reset()
    batch.step(100)
    before = batch.get(PLACES[0])
    batch.set(UNBALANCE, 2e-6, mask=[False, True, False, False, False])
    batch.step(200)
    assert before[1] != before[2], "the array is live, and friction is the same in both"
    assert np.array_equal(before[[0, 2, 3]], alone[[0, 2, 3], 300, 0])


def test_values_are_checked_and_names_are_told(batch):
    with raises_naming(ValueError, "rotor_contact.turbine.u", "nan kg.m"):
        batch.set(UNBALANCE, np.nan)
    with raises_naming(ValueError, "'rotor_contact.turbine.v'", "rotor_contact.turbine.u"):
        batch.set("rotor_contact.turbine.v", 1.0)
    with raises_naming(ValueError, "rotor_contact.north.z"):
        batch.get("rotor_contact.north.z")
    with raises_naming(ValueError, "0 steps"):
        batch.step(0)
    with raises_naming(ValueError, "rotor_contact.shroud.mu", "2 values", "3 members"):
        batch_of(3, set={MU: [0.1, 0.2]})


def test_a_member_that_fails_rests_and_says_why(batch):
    batch.reset()
    batch.set(UNBALANCE, 1e6, mask=[False, False, True, False, False])
    batch.step(STEPS)
    assert batch.failed.tolist() == [False, False, True, False, False]
    assert "failed at t = " in batch.reason(2)
    assert batch.reason(1) == ""
    assert batch.time[2] < batch.time[1]
    batch.reset([False, False, True, False, False])
    batch.step(1)
    assert not batch.failed.any()


def held(batch):
    return sum(len(c._held) for run in batch._members._runs for c in run.components)


def test_two_threads_step_one_batch_in_turn(batch):
    batch.reset()
    before = batch.time.copy()
    threads = [threading.Thread(target=lambda: [batch.step(3) for _ in range(40)]) for _ in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert batch.time == pytest.approx(before + 240 * batch.step_size)
    alternating = motion(batch)
    batch.reset()
    batch.step(240)
    assert np.array_equal(motion(batch), alternating)


@pytest.mark.parametrize("threads", [1, 2])
def test_a_closed_batch_says_so(threads):
    batch = batch_of(2, threads=threads)
    states = batch.save()

    def step():
        with suppress(ValueError):  # closed before it began
            batch.step(20000)

    stepping = threading.Thread(target=step)
    stepping.start()
    batch.close()  # waits for the step where that began first
    batch.close()
    stepping.join()
    calls = (
        lambda: batch.step(1),
        lambda: batch.get(PLACES[0]),
        lambda: batch.set(UNBALANCE, 0.0),
        lambda: batch.reason(0),
        lambda: batch.time,
        lambda: batch.failed,
        lambda: batch.restore(states),
        batch.save,
        batch.reset,
    )
    for call in calls:
        with pytest.raises(ValueError, match="the batch is closed"):
            call()


@pytest.mark.parametrize("k", [0, -1, 2**31, 2**63, 1.5, "1", None])
def test_a_number_of_steps_is_a_whole_number(batch, k):
    with raises_naming(ValueError, "steps", "whole number", "1 to 2147483647"):
        batch.step(k)


@pytest.mark.parametrize("mask", [[True], [1, 0, 0, 0, 0], [[True] * 5], True, "TTTTT"])
def test_a_mask_has_an_element_for_each_member(batch, mask):
    for call in (lambda: batch.reset(mask), lambda: batch.set(UNBALANCE, 0.0, mask)):
        with raises_naming(ValueError, "5 elements", "True", "False"):
            call()


def test_values_are_one_or_one_for_each_member(batch):
    for values in ([0.0], [0.0] * 4, [[0.0] * 5], "x", [None] * 4):
        with raises_naming(ValueError, "number", "5 members"):
            batch.set(UNBALANCE, values)


def test_states_that_are_dropped_are_freed(batch):
    batch.reset()
    first = batch.save()
    count = held(batch)
    for _ in range(5):
        batch.save()
    gc.collect()
    del first
    gc.collect()
    last = batch.save()
    assert held(batch) == count
    batch.restore(last)


def test_states_of_another_batch_are_refused(batch):
    with batch_of(5) as other, raises_naming(ValueError, "states", "batch"):
        batch.restore(other.save())
    with raises_naming(ValueError, "states", "batch"):
        batch.restore({})


def test_ctrl_c_ends_a_long_step_with_all_members_at_one_point(batch):
    batch.reset()
    threading.Timer(0.3, signal.raise_signal, (signal.SIGINT,)).start()
    with pytest.raises(KeyboardInterrupt):
        batch.step(2**31 - 1)
    assert np.ptp(batch.time) == 0.0
    batch.step(1)


def test_a_batch_that_is_pickled_says_why_it_cannot_be(batch):
    with raises_naming(TypeError, "FMUs", "process"):
        pickle.dumps(batch)
