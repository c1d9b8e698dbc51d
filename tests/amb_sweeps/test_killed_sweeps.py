"""Sweeps whose client is killed: a resumed sweep equals an undisturbed one."""

import os
import random
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from command_line import COMMAND
from waiting import wait_until

import amb_cosim
from amb_sweeps.store import open_sweep
from tests.amb_sweeps.conftest import same

pytestmark = [pytest.mark.slow, pytest.mark.skipif(sys.platform != "linux", reason="processes are killed by SIGKILL")]

POINTS = 120
VARY = {"Omega": f"180:280 rad/s:{POINTS}"}
UNTIL = 0.5  # s; the points take some seconds together
KILLED_CLIENT = """
import os, sys
import amb_cosim
from killer import Killer
points, delay, scenario, speeds, until, scheduler, folder = sys.argv[1:]
killer = Killer(os.getpid(), int(points), float(delay))
amb_cosim.sweep(
    scenario, {"Omega": speeds}, until=float(until), scheduler=scheduler, output=folder, progress=killer
)
"""


@pytest.fixture
def scenario(small, tmp_path):
    return str(small.save(tmp_path / "small.toml"))


@pytest.fixture(scope="module")
def undisturbed(small, cluster, tmp_path_factory):
    """The same sweep on another cluster."""
    options = {"until": UNTIL, "scheduler": cluster, "output": tmp_path_factory.mktemp("undisturbed")}
    return amb_cosim.sweep(small, VARY, **options).dataset


@pytest.fixture
def moments(is_long: bool, first_seed: int) -> list[tuple[int, float]]:
    """Return kill times: a number of points in each of `n` equal parts, and a delay (s)."""
    chance, n = random.Random(first_seed), 30 if is_long else 3
    return [(int(0.8 * POINTS * (k + chance.random()) / n), chance.uniform(0.0, 0.1)) for k in range(n)]


def client(folder: Path, scenario: str, *where: str) -> subprocess.Popen[str]:
    """Start the command in a separate process."""
    options = ["--vary", f"Omega={VARY['Omega']}", "--until", str(UNTIL), "--no-plots", *where, "-o", str(folder)]
    return subprocess.Popen(
        [*COMMAND, "sweep", scenario, *options], stderr=subprocess.PIPE, text=True, start_new_session=True
    )


def landed(folder: Path) -> int:
    """Return how many points of a sweep have results."""
    try:
        return int((open_sweep(folder)["outcome"] != "").sum())
    except (ValueError, OSError, KeyError):
        return 0


def test_a_sweep_resumes_after_its_client_was_killed(undisturbed, cluster, scenario, tmp_path, moments):
    for k, moment in enumerate(moments):
        folder = tmp_path / f"swept_{k}"
        arguments = map(str, (*moment, scenario, VARY["Omega"], UNTIL, cluster, folder))
        environment = os.environ | {"PYTHONPATH": str(Path(__file__).parents[1] / "support")}
        done = subprocess.run([sys.executable, "-c", KILLED_CLIENT, *arguments], env=environment, check=False)
        assert done.returncode == -signal.SIGKILL, moment
        go_on(scenario, folder, cluster, undisturbed, moment)


def go_on(scenario: str, folder: Path, scheduler: str, expected, moment: tuple[int, float]) -> None:
    """Resume a sweep, and check that it runs only the missing points and equals the undisturbed one."""
    before, seen = landed(folder), []
    swept = amb_cosim.sweep(
        scenario, VARY, output=folder, until=UNTIL, scheduler=scheduler, progress=lambda done, *_: seen.append(done)
    )
    assert seen[0] == before < POINTS, f"{moment}: points were run again"
    same(swept.dataset, expected)


@pytest.mark.parametrize("local", [True, False])
def test_ctrl_c_keeps_finished_runs_and_exits_with_130(cluster, scenario, tmp_path, local):
    where = ["--jobs", "1"] if local else ["--scheduler", cluster]
    process = client(tmp_path / "swept", scenario, *where)
    wait_until(lambda: landed(tmp_path / "swept") > 0 or process.poll() is not None)
    os.killpg(process.pid, signal.SIGINT)  # as a terminal does
    _, errors = process.communicate(timeout=60)
    assert process.returncode == 130, errors
    assert "run the same command again" in errors
    assert "Traceback" not in errors
