"""Adaptive sweeps whose runs fail and which are broken off: they end, run nothing twice, and report what they ran."""

from __future__ import annotations

import math
import random

import numpy as np
import pytest

from amb_cosim.sweeps.sampling import make_design
from amb_cosim.sweeps.store import SweepStore, open_sweep
from amb_cosim.sweeps.worker import PointResult

pytest.importorskip("sklearn")

from amb_cosim.sweeps.adaptive import Goal, Sampler  # after it is known that sklearn is there

VARY = (
    {"a.x": "0:1:30"},
    {"step.cycle": [k / 36.0 for k in range(36)]},
    {"a.x": "0:1:7", "a.y": "-1:1:6"},
    {"a.x": "0:1:12", "kind": ["one", "two"]},
)
BAD = ("failed", "crashed", "trapped")


class Runs:
    """What the points of a sweep lead to: a smooth metric, but where the run fails or the metric is none."""

    def __init__(self, design, chance):
        rng = np.random.default_rng(chance.randrange(2**32))
        self.design, share = design, chance.choice((0.0, 0.1, 0.5, 0.95, 1.0))
        centre, width = rng.uniform(size=2), rng.uniform(0.1, 1.0)
        at = np.array(np.unravel_index(np.arange(design.size), design.shape)).T / np.array(design.shape)
        values = np.exp(-((at - centre[: at.shape[1]]) ** 2).sum(axis=1) / width**2)
        values = np.full(design.size, 3.0) if chance.random() < 0.1 else values * 10 ** rng.uniform(-12, 12)
        self.values = np.where(rng.uniform(size=design.size) < share, np.nan, values)
        self.how = [chance.choice((*BAD, "nan", "inf")) for _ in range(design.size)]
        self.ran = []

    def __call__(self, n):
        self.ran.append(n)
        if math.isfinite(self.values[n]):
            return PointResult(n, "recovered", "", {"m": float(self.values[n])}, 0.1)
        if self.how[n] in BAD[:2]:
            return PointResult(n, self.how[n], "it broke off", {}, 0.1)
        return PointResult(n, "recovered", "", {"m": math.inf if self.how[n] == "inf" else math.nan}, 0.1)


def searched(folder, goal, runs, chance):
    """Run a search to its end, broken off and begun again from its store now and then; return the sampler."""
    pending, sampler, broken = [], None, 0
    while True:
        if sampler is None:
            store = SweepStore(folder, runs.design, {"a": 1}, {})
            known = open_sweep(folder) if runs.ran else None
            sampler, pending = Sampler(runs.design, goal, known), []
        points, is_found = sampler.next_points(chance.randint(1, 4), pending)
        assert len(set(points)) == len(points)
        assert not set(points) & {*pending, *runs.ran}, "a point is asked for twice"
        if is_found:
            return sampler, broken
        pending += points
        assert pending, "nothing is asked for, and nothing found"
        if chance.random() < 0.1:  # what is under way is lost
            sampler, broken = None, broken + 1
            continue
        chance.shuffle(pending)
        count = chance.randint(1, len(pending))
        results, pending = [runs(n) for n in pending[:count]], pending[count:]
        store.add(results)
        sampler.learn(results)


@pytest.fixture
def count(is_long):
    return 1000 if is_long else 20


@pytest.mark.slow
def test_a_search_with_failed_runs_ends_and_reports_the_best(tmp_path, first_seed, count):
    """No more than a twentieth of the searches misses more than a tenth of the range, where most runs succeed."""
    missed, judged, breaks = 0, 0, 0
    for seed in range(first_seed, first_seed + count):
        chance = random.Random(seed)
        design = make_design(chance.choice(VARY))
        runs = Runs(design, chance)
        kind = chance.choice(("maximum", "minimum", "boundary"))
        goal = Goal(kind, "m", level=chance.choice((0.5, 1e6, float(np.nanmedian([*runs.values, 0.0])))))
        sampler, broken = searched(tmp_path / str(seed), goal, runs, chance)
        breaks += broken
        assert len(runs.ran) == len(set(runs.ran)) <= design.size, f"seed {seed}"
        dataset = open_sweep(tmp_path / str(seed))
        assert int((dataset["outcome"] != "").sum()) == len(runs.ran), f"seed {seed}"
        said = sampler.summary_lines()
        assert all("nan" not in line and "inf" not in line.replace("information", "") for line in said), (
            f"seed {seed}: {said}"
        )
        found = sampler.dataset()
        assert not np.isinf(found["mean"]).any(), f"seed {seed}"
        if kind == "boundary" or not np.isfinite(runs.values).mean() > 0.8:
            continue
        sign = 1.0 if kind == "maximum" else -1.0
        best = np.nanmax(sign * runs.values[runs.ran])
        judged += 1
        missed += np.nanmax(sign * runs.values) - best > 0.1 * np.ptp(runs.values[np.isfinite(runs.values)])
    print(f"{count} searches, {breaks} broken off, {missed} of {judged} missed")
    assert breaks > count / 4
    assert missed <= max(1, judged / 20)
