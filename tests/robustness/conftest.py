"""Campaigns of random mistakes, and how long they are."""

from __future__ import annotations

import random
import shutil
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner

sys.path.insert(0, str(Path(__file__).parent / "support"))

from commands import FEW, LONG, MANY, run


@pytest.fixture
def rounds(is_long: bool) -> int:
    return 300 if is_long else 10


@pytest.fixture
def chance(first_seed: int) -> random.Random:
    print(f"seed {first_seed}")
    return random.Random(first_seed)


@pytest.fixture(scope="module")
def loaded(tmp_path_factory):
    """What commands need is built once and loaded into this process, whose forks they are: loading takes seconds."""
    import h5py  # noqa: F401
    import numba  # noqa: F401
    import scipy.linalg  # noqa: F401
    import xarray  # noqa: F401
    from strange_machine import FOLDER

    from amb_cosim.commands.cli import main

    out = str(tmp_path_factory.mktemp("out"))
    for arguments in (
        ["run", "fig4_9", "--until", "0.001", "--no-plots", "-o", out],
        ["plot", out, "mb1.x", "-o", f"{out}/o.png"],
        ["assess", str(FOLDER / "machine.toml"), "--check"],
    ):
        done = CliRunner().invoke(main, arguments)
        assert done.exit_code == 0, done.output


@pytest.fixture(params=[FEW, pytest.param(MANY, marks=pytest.mark.slow)], ids=["few", "many"])
def n_cases(request, is_long):
    return LONG if is_long and request.param == MANY else request.param


@pytest.fixture
def campaign(loaded, tmp_path, first_seed, n_cases):
    """`campaign(case)`: run the command lines and files of `case(chance)`, which `case(None)` has whole.

    `before` is called in each process first; a command line of `must_work` succeeds whatever its files hold.

    Allowed are the exit codes 0, 1 and 2, the last two with a message. Not allowed are a traceback, 2 GB of memory,
    half-written files, and 10 s of CPU time. Commands that may be `lasting` simulate, and must end when stopped.
    """

    def go(case, before=None, must_work=(), lasting=False):
        arguments, files = case(None)
        ended = run(arguments, tmp_path / "whole", files, 300, before)
        assert ended.code == 0, ended.errors
        mistakes, codes = [], []
        for k in range(n_cases):
            seed = first_seed + k
            arguments, files = case(random.Random(seed))
            folder = tmp_path / str(k)
            ended = run(arguments, folder, files, before=before)
            codes.append(ended.code)
            mistake = ended.mistake()
            if ended.stopped and not lasting:
                mistake = mistake or f"stopped after {ended.used:.1f} s of CPU time"
            if arguments in must_work and ended.code != 0:
                mistake = mistake or f"exit code {ended.code}"
            if mistake:
                mistakes.append(f"seed {seed}, {arguments}: {mistake}\n{ended.errors[-3000:]}")
            else:
                shutil.rmtree(folder)
        print({code: codes.count(code) for code in sorted(set(codes))})
        assert not mistakes, f"{len(mistakes)} of {len(codes)}:\n" + "\n".join(mistakes)
        assert 2 in codes

    return go
