"""Stores of sweeps and files of results damaged at random: the same numbers, or one ValueError."""

from __future__ import annotations

import random
import shutil

import numpy as np
import pytest
from damage import damaged

from amb_sweeps.sampling import make_design
from amb_sweeps.store import SweepStore, open_sweep
from amb_sweeps.worker import PointResult

pytestmark = pytest.mark.slow

DESIGN = make_design({"Omega": np.linspace(100.0, 200.0, 40), "x.y": ["a", "b"]})


def swept(folder, first=0):
    """A store in which points from `first` on are done, with two rounds of refinement in it."""
    for group in ("", "contact_1", "contact_2"):
        store = SweepStore(folder, DESIGN, {"a": 1}, {}, group)
        draw = np.random.default_rng(1).normal(size=DESIGN.size)
        points = [n for n in store.missing if n >= first]
        store.add([PointResult(n, "recovered", "why" * (n % 3), {"peak": draw[n]}, 1.0) for n in points])


def test_a_damaged_store_is_told_and_never_goes_on(tmp_path, first_seed, rounds):
    swept(tmp_path / "whole", first=9)
    groups = ("", "contact_1", "contact_2")
    expected = {group: open_sweep(tmp_path / "whole", group) for group in groups}
    copy = tmp_path / "copy"
    for seed in range(first_seed, first_seed + rounds):
        chance = random.Random(seed)
        shutil.copytree(tmp_path / "whole", copy)
        files = sorted(path for path in copy.rglob("*") if path.is_file())
        for path in chance.sample(files, chance.choice((1, 1, 3))):
            if chance.random() < 0.2:
                path.unlink()
            else:
                path.write_bytes(damaged(path.read_bytes(), chance))
        for group in groups:
            try:
                assert open_sweep(copy, group).identical(expected[group]), f"seed {seed}, group {group!r}"
            except ValueError:
                continue
        try:
            swept(copy)
        except ValueError:
            shutil.rmtree(copy)
            continue
        for group in groups:
            result = open_sweep(copy, group)
            assert (result["outcome"] == "recovered").all(), f"seed {seed}"
            np.testing.assert_array_equal(
                result["peak"].values.ravel(), np.random.default_rng(1).normal(size=DESIGN.size)
            )
        shutil.rmtree(copy)
