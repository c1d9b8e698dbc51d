"""Sweeps that choose their points: maxima and boundaries of known functions, and what is refused."""

from __future__ import annotations

import importlib.util
import math
import threading
from concurrent.futures import ThreadPoolExecutor, wait
from types import SimpleNamespace

import numpy as np
import pytest
from waiting import LONGEST

import amb_cosim
from amb_cosim.scenario.scenario import load_scenario
from amb_cosim.sweeps.engine import BatchScheduler
from amb_cosim.sweeps.sampling import make_design
from amb_cosim.sweeps.store import SweepStore, open_sweep
from amb_cosim.sweeps.worker import PointResult, Task
from tests.orchestrator.sweep.conftest import UNTIL, filled

pytest.importorskip("sklearn")

from amb_cosim.sweeps.adaptive import Goal, Sampler, read_goal  # after it is known that sklearn is there
from amb_cosim.sweeps.adaptive_run import _Adaptive
from tests.support.messages import assert_names, raises_naming

TURN = {"step.cycle": [k / 360.0 for k in range(360)]}


@pytest.fixture
def seek():
    """`seek(vary, function, kind, ...)`: the sampler when it has found, and the points it ran, in order."""

    def seek(vary, function, kind="maximum", certainty=0.01, level=0.5, sample="grid", at_once=1):
        design = make_design(vary, sample)
        sampler, ran = Sampler(design, Goal(kind, "m", level, certainty)), []
        while True:
            points, is_found = sampler.next_points(at_once)
            if is_found:
                return sampler, ran
            assert points, "nothing is asked for, and nothing found"
            sampler.learn(PointResult(n, "completed", "", {"m": function(design.settings(n))}) for n in points)
            ran += points

    return seek


def wave(settings):
    """Largest, 2.25, at a phase of 0.99: beyond the end of the turn it goes on at its beginning."""
    angle = 2.0 * math.pi * (settings["step.cycle"] - 0.99)
    return math.cos(angle) + 0.25 * math.cos(2.0 * angle) + 1.0


def test_worst_phase_takes_a_third_of_the_runs_of_a_grid(seek):
    """Of the grids, each in its worst place, the least that misses no more than the sampler has left open."""
    result, ran = seek(TURN, wave, certainty=0.002)
    values = np.array([wave({"step.cycle": c}) for c in TURN["step.cycle"]])
    best = max(values[ran])
    promised = result.promise
    assert values.max() - best <= promised <= 0.002 * np.ptp(values)
    spacings = [n for n in range(1, 121) if 360 % n == 0]
    misses = {n: max(values.max() - values[first::n].max() for first in range(n)) for n in spacings}
    as_sure = min(360 // n for n in spacings if misses[n] <= promised)
    assert 3 * len(ran) <= as_sure


def test_a_phase_is_a_circle_and_what_is_close_across_its_end_is_known(seek):
    result, ran = seek(TURN, wave)
    assert result.periodic == ["step.cycle"]
    other, of_line = seek({"a.x": TURN["step.cycle"]}, lambda s: wave({"step.cycle": s["a.x"]}))
    assert other.periodic == []
    assert len(ran) < len(of_line)


def test_a_run_whose_metric_is_infinite_has_no_value(seek):
    def metric(settings):
        return math.inf if settings["a.x"] > 0.5 else 4.0 - settings["a.x"]

    sampler, ran = seek({"a.x": "0:1:20"}, metric)
    assert len(ran) < 20
    assert_names(sampler.summary_lines()[0], "maximum of m", "4", "x = 0")
    assert np.isfinite(sampler.promise)


@pytest.mark.parametrize(
    ("name", "values", "repeats"),
    [
        ("step.cycle", "5:6:40", True),
        ("step.cycle", "5:8:40", False),
        ("gravity_angle", "0 deg:360 deg:37", True),
        ("gravity_angle", "0 deg:90 deg:37", False),
        ("Omega", "0:1:40", False),
    ],
)
def test_what_repeats_is_a_turn_or_a_whole_angle(name, values, repeats):
    design = make_design({name: values})
    sampler = Sampler(design, Goal("maximum", "m"))
    assert sampler.periodic == ([name] if repeats else [])


def hills(at, rng):
    """One to four hills at random places, of half to whole height, over coordinates of shape (n, dimensions)."""
    count = rng.integers(1, 5)
    centres, heights = at[rng.integers(0, len(at), count)], rng.uniform(0.5, 1.0, count)
    widths = rng.uniform(0.08, 0.3, count) * (0.5 if at.shape[1] == 1 else 1.0)
    shares = (
        h * np.exp(-((at - c) ** 2).sum(axis=1) / (2.0 * w**2))
        for c, h, w in zip(centres, heights, widths, strict=True)
    )
    return sum(shares)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("vary", "tries", "most", "runs"),
    [
        ({"a.x": "0:1:200"}, 12, 1, 20),
        ({"a.x": "0:1:200"}, 60, 4, 20),
        ({"a.x": "0:1:31", "a.y": "0:1:31"}, 40, 6, 30),
    ],
)
def test_no_more_is_left_than_promised_among_random_hills(seek, vary, tries, most, runs):
    """But for a few: a hill that is narrower than what lies between the points that were run is not seen."""
    design, rng, broken = make_design(vary), np.random.default_rng(0), 0
    given = [design.settings(n) for n in range(design.size)]
    at = np.array([list(settings.values()) for settings in given])
    for _ in range(tries):
        values = hills(at, rng)
        by_settings = {tuple(settings.values()): value for settings, value in zip(given, values, strict=True)}
        result, ran = seek(vary, lambda s, known=by_settings: known[tuple(s.values())])
        assert len(ran) <= runs
        broken += values.max() - values[ran].max() > max(result.promise, 0.01 * np.ptp(values))
    assert broken <= most


def test_minimum_is_the_maximum_of_what_is_turned_over(seek):
    _, up = seek(TURN, wave)
    result, down = seek(TURN, lambda s: -wave(s), kind="minimum")
    assert up == down
    assert "minimum of m: -2.2" in result.summary_lines()[0]


def test_boundary_of_a_level_is_known_at_every_point(seek):
    """Within the certainty; the ramp has the level on the line y = 0.3 + 0.4 sin 2.5 x."""

    def height(s):
        return s["a.y"] - 0.3 - 0.4 * math.sin(2.5 * s["a.x"])

    design = make_design(vary := {"a.x": "0:1:25", "a.y": "0:1:25"})
    result, ran = seek(vary, height, kind="boundary", level=0.1)
    mean = result.dataset()["mean"].values.ravel()
    exact = np.array([height(design.settings(n)) for n in range(design.size)])
    clear = np.abs(exact - 0.1) > 0.01 * np.ptp(exact)
    np.testing.assert_array_equal((mean > 0.1)[clear], (exact > 0.1)[clear])
    assert len(ran) < design.size / 10


@pytest.mark.parametrize("at_once", [2, 4])
def test_points_that_are_asked_at_once_are_not_neighbours(seek, at_once):
    _, item = seek(TURN, wave)
    _, some = seek(TURN, wave, at_once=at_once)
    assert len(some) <= len(item) + 2 * at_once


def test_alternatives_are_sought_each_by_itself(seek):
    def force(s):
        return wave({"step.cycle": s["step.cycle"] + (0.5 if s.get("a.on") else 0.0)})

    result, _ = seek({"control": {"PID": {}, "ROLAC": {"a.on": True}}, **TURN}, force)
    assert [line.partition(":")[0] for line in result.summary_lines()] == ["PID", "ROLAC"]
    assert "with cycle of the step = 0.4" in result.summary_lines()[1]


def test_runs_without_a_value_are_done_and_tell_nothing(seek):
    result, ran = seek(TURN, lambda s: math.nan if s["step.cycle"] < 0.5 else wave(s))
    assert len(ran) == len(set(ran))
    assert "maximum of m: 2.2" in result.summary_lines()[0]
    result, ran = seek(TURN, lambda s: math.nan)
    assert_names(result.summary_lines()[0], "no maximum of m")
    assert len(ran) == len(set(ran))


def test_a_metric_that_never_changes_ends_the_search(seek):
    result, ran = seek(TURN, lambda s: 0.0)
    assert len(ran) < 30
    assert_names(result.summary_lines()[0], "maximum of m: 0")


def test_what_is_in_the_store_is_not_asked_for_again(tmp_path):
    swept = filled(tmp_path, {"a.x": "0:1:40"}, lambda s: {"m": s["a.x"]})
    assert Sampler(swept.design, Goal("maximum", "m"), swept.dataset).next_points(3) == ([], True)


@pytest.mark.parametrize(
    ("text", "certainty", "facts"),
    [
        ("largest:contact", 0.01, ("--adaptive", "largest:contact", "maximum:METRIC")),
        ("maximum", 0.01, ("--adaptive", "maximum")),
        ("maximum:contact=1", 0.01, ("--adaptive", "maximum:contact=1")),
        ("boundary:contact=1e999", 0.01, ("1e999", "finite")),
        ("boundary:contact=--", 0.01, ("--", "finite")),
        ("maximum:peak_contact_forse", 0.01, ("peak_contact_forse", "peak_contact_force")),
        ("maximum:contact", 0.0, ("--certainty", "0", ">= 1e-06", "< 1")),
        ("maximum:contact", math.nan, ("--certainty", "nan")),
    ],
)
def test_what_is_no_goal_is_refused(text, certainty, facts):
    with raises_naming(ValueError, *facts):
        read_goal(text, certainty)


def test_a_sweep_that_cannot_be_sampled_is_refused(tmp_path, small):
    with raises_naming(ValueError, "--adaptive", "two numbers"):
        Sampler(make_design({"control": {"PID": {}, "ROLAC": {}}}), Goal("maximum", "m"))
    with raises_naming(ValueError, "90000 points", "--adaptive", "50000"):
        Sampler(make_design({"a.x": "0:1:300", "a.y": "0:1:300"}), Goal("maximum", "m"))


def test_the_extra_is_named_where_it_is_missing(tmp_path, small, monkeypatch):
    result = importlib.util.find_spec
    monkeypatch.setattr(
        "fmi_export.building.extras.find_spec", lambda name: result(name) if name != "sklearn" else None
    )
    with raises_naming(ValueError, "sklearn", "pip install", "[adaptive]"):
        amb_cosim.sweep(small, {"Omega": "1:2:3"}, output=tmp_path, adaptive="maximum:contact")


class Thinks:
    """A sampler whose thoughts take until they are allowed to end."""

    def __init__(self):
        self.may_end, self.pending = threading.Semaphore(0), []

    def next_points(self, count, pending):
        self.pending.append(set(pending))
        assert self.may_end.acquire(timeout=LONGEST)
        return [10 * len(self.pending) + k for k in range(count)], False


def test_points_are_run_while_the_sampler_thinks(tmp_path, monkeypatch):
    """The second thought begins as soon as fewer points wait than there are processes, which take those meanwhile."""
    store = SweepStore(tmp_path, make_design(TURN), {"scenario": {"name": "made up"}}, {})
    client, task = SimpleNamespace(cluster="own", dashboard_link=""), Task(load_scenario("fig4_9"))
    monkeypatch.setattr(BatchScheduler, "_threads", lambda _: 3)
    with ThreadPoolExecutor(1) as thinker:
        sampler = Thinks()
        search = _Adaptive(client, "", task, store, lambda *_: None, None, sampler, thinker)
        assert search._refill()
        sampler.may_end.release()
        wait([search._thought])
        search._refill()
        assert search._next_batch() == [10]
        search._refill()
        thought = search._thought
        assert [search._next_batch() for _ in range(2)] == [[11], [12]]
        assert search._refill()
        assert thought is search._thought
        assert not thought.done()
        sampler.may_end.release()
        wait([thought])
        search._refill()
        assert search._next_batch() == [20]
        sampler.may_end.release()
    assert sampler.pending[:2] == [set(), {11, 12}]


@pytest.mark.slow
def test_processes_run_what_is_asked_and_a_sweep_goes_on(cluster, small, tmp_path):
    """A peak force over a step of unbalance: fewer runs than points, those of the whole grid, and its maximum."""
    vary = {"rotor_contact.d1.u": "5 g.m:60 g.m:60"}
    values = {"output": tmp_path, "until": UNTIL, "scheduler": cluster, "progress": False}
    goal = {"adaptive": "maximum:orbit_largest", "certainty": 0.02}

    def stop(done, total, dashboard):
        if done >= 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        amb_cosim.sweep(small, vary, **values | {"progress": stop}, **goal)
    before = int((open_sweep(tmp_path)["outcome"] != "").sum())
    assert 3 <= before < 60
    swept = amb_cosim.sweep(small, vary, **values, **goal)
    partly = swept.dataset["orbit_largest"].values
    assert before <= np.isfinite(partly).sum() < 60
    assert "maximum of orbit_largest: " in swept.summary
    whole = amb_cosim.sweep(small, vary, **values).dataset["orbit_largest"].values
    is_run = np.isfinite(partly)
    np.testing.assert_array_equal(partly[is_run], whole[is_run])
    assert np.nanmax(whole) - np.nanmax(partly) <= 0.02 * np.ptp(whole)
    assert open_sweep(tmp_path, "maximum_orbit_largest")["mean"].shape == (60,)
