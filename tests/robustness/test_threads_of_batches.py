"""Batches that several threads of Python call at once: the bits of the same calls one after the other, and no race."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

SUPPORT = Path(__file__).parent / "support"
SCRIPT = SUPPORT / "threads_of_batches.py"
PYTHONPATH = os.pathsep.join([str(SUPPORT), str(SUPPORT.parents[1] / "support")])
RACE = 66  # exit code of a process in which the sanitizer saw one


@pytest.fixture
def call():
    """`call(arguments, environment)`: the script's exit code, and all that it wrote."""

    def call(arguments, environment=None):
        variables = os.environ | {"PYTHONPATH": PYTHONPATH} | (environment or {})
        command = [sys.executable, str(SCRIPT), *map(str, arguments)]
        done = subprocess.run(command, env=variables, capture_output=True, text=True, check=False)
        return done.returncode, done.stdout + done.stderr

    return call


@pytest.mark.parametrize("calls", [20, pytest.param(100, marks=pytest.mark.slow)])
def test_calls_of_three_threads_have_the_bits_of_one(call, first_seed, is_long, calls):
    rounds = 10 if is_long and calls > 20 else 1
    for seed in range(first_seed, first_seed + rounds):
        code, output = call([seed, calls, 0, 1, 2, 8])
        assert code == 0, f"seed {seed}: {output}"
        print(output)


@pytest.fixture
def under_sanitizer(call, cache, tmp_path):
    """`call` with a cache of loop and FMUs that the sanitizer watches."""
    if not shutil.which("gcc"):
        pytest.skip("needs gcc with its sanitizers")
    place = subprocess.run(["gcc", "-print-file-name=libtsan.so"], capture_output=True, text=True, check=True)
    library = Path(place.stdout.strip())
    if sys.platform != "linux" or not library.is_file():
        pytest.skip("needs gcc with its sanitizers")
    kept = tmp_path / "cache" / "amb-cosim"
    kept.mkdir(parents=True)
    for folder in (cache / "amb-cosim").glob("kernels-*"):  # or they are lowered anew
        shutil.copytree(folder, kept / folder.name)
    environment = {
        "XDG_CACHE_HOME": str(tmp_path / "cache"),
        "LD_PRELOAD": str(library.resolve()),
        "TSAN_OPTIONS": f"exitcode={RACE} halt_on_error=1",
        "OPENBLAS_NUM_THREADS": "1",  # its threads, which the sanitizer does not know, would be found to race
    }
    code, output = call(["build"], environment)
    assert code == 0, output
    return lambda arguments: call(arguments, environment)


@pytest.mark.slow
def test_thread_sanitizer_finds_no_race_in_a_batch(under_sanitizer, first_seed):
    """It would find one: members that two threads step without the lock of the batch race in loop and FMUs."""
    code, output = under_sanitizer([first_seed, 0, 1, 1])
    assert code == RACE, output
    assert "data race" in output
    assert "/amb-cosim/" in output  # in a library of the cache: the loop or an FMU, whose functions may have no names
    code, output = under_sanitizer([first_seed, 12, 0, 1, 2, 8])
    assert code == 0, output
    print(output)
