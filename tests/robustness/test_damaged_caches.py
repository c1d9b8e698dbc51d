"""Files of the caches damaged at random: what is damaged is made anew, and the numbers stay the same."""

from __future__ import annotations

import os
import random
import shutil

import h5py
import numpy as np
import pytest
from command_line import run_command
from damage import damaged

pytestmark = pytest.mark.slow

ONE = """
[[component]]
name = "amb_actuator"
fmu = "amb_actuator"
[experiment]
communication_step = "1 ms"
stop_time = "20 ms"
record.variables = ["*"]
"""


@pytest.fixture
def run_with(tmp_path):
    """`run_with(cache, flavour)`: what a run with this cache recorded."""
    (tmp_path / "one.toml").write_text(ONE)

    def run(cache, flavour):
        environment = os.environ | {"XDG_CACHE_HOME": str(cache)}
        done = run_command(
            "simulate", "one.toml", "-o", "out", "--flavour", flavour, cwd=tmp_path, env=environment, timeout=300
        )
        assert "Traceback" not in done.stderr
        with h5py.File(tmp_path / "out" / "result.nc") as data:
            return {name: np.array(data[name]) for name in data}

    return run


@pytest.mark.parametrize("flavour", ["native", "python"])
def test_damaged_fmus_and_libraries_in_the_cache_are_made_anew(run_with, tmp_path, first_seed, rounds, flavour):
    whole, cache = tmp_path / "whole", tmp_path / "cache"
    expected = run_with(whole, flavour)
    for seed in range(first_seed, first_seed + rounds):
        chance = random.Random(seed)
        shutil.copytree(whole, cache)
        files = sorted(path for path in cache.rglob("*") if path.is_file())
        for path in chance.sample(files, chance.choice((1, 1, 3))):
            path.write_bytes(damaged(path.read_bytes(), chance))
        try:
            result = run_with(cache, flavour)
        except AssertionError as error:
            raise AssertionError(f"seed {seed}: {error}") from error
        for name, values in expected.items():
            np.testing.assert_array_equal(result[name], values, f"seed {seed}")
        shutil.rmtree(cache)
