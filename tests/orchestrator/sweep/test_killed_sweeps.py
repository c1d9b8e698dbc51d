"""Sweeps whose client, worker or scheduler is killed: those that go on equal those that were not disturbed."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

import amb_cosim
from amb_cosim.sweeps.store import open_sweep
from tests.orchestrator.sweep.conftest import same

pytestmark = [pytest.mark.slow, pytest.mark.skipif(sys.platform != "linux", reason="processes are killed by SIGKILL")]

VARY = {"Omega": "180:280:12"}
UNTIL = 0.3
START_TIME = 120.0  # s


class Processes:
    """A scheduler and two workers, each a process."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.started = folder, []
        file = folder / "scheduler.json"
        self.scheduler = self.start(
            "dask_scheduler",
            "--port",
            "0",
            "--dashboard-address",
            "127.0.0.1:0",
            "--host",
            "127.0.0.1",
            "--scheduler-file",
            str(file),
        )
        wait_for(file.exists)
        self.file = str(file)
        self.workers = [self.add_worker() for _ in range(2)]

    def start(self, name: str, *arguments: str) -> subprocess.Popen[bytes]:
        command = [sys.executable, "-m", f"distributed.cli.{name}", *arguments]
        process = subprocess.Popen(command, cwd=self.folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.started.append(process)
        return process

    def add_worker(self) -> subprocess.Popen[bytes]:
        return self.start(
            "dask_worker", "--scheduler-file", self.file, "--nthreads", "1", "--no-nanny", "--no-dashboard"
        )

    @property
    def address(self) -> str:
        import json

        return str(json.loads(Path(self.file).read_text())["address"])

    def close(self) -> None:
        for process in self.started:
            process.kill()
            process.wait()


def wait_for(condition) -> None:
    end = time.monotonic() + START_TIME
    while not condition():
        assert time.monotonic() < end, "the process did not start"
        time.sleep(0.1)


@pytest.fixture
def processes(tmp_path: Path) -> Iterator[Processes]:
    folder = tmp_path / "cluster"
    folder.mkdir()
    cluster = Processes(folder)
    yield cluster
    cluster.close()


@pytest.fixture
def scenario(small, tmp_path):
    return str(small.save(tmp_path / "small.toml"))


@pytest.fixture
def undisturbed(scenario, processes, tmp_path):
    options = {"until": UNTIL, "scheduler": processes.address, "progress": False}
    return amb_cosim.sweep(scenario, VARY, output=tmp_path / "undisturbed", **options).dataset


def client(folder: Path, scenario: str, *where: str) -> subprocess.Popen[str]:
    """Start the command in a process of its own."""
    command = [sys.executable, "-c", "from amb_cosim.start import main; main()", "sweep", scenario]
    options = ["--vary", f"Omega={VARY['Omega']}", "--until", str(UNTIL), "--no-plots", *where]
    return subprocess.Popen(
        [*command, *options, "-o", str(folder)], stderr=subprocess.PIPE, text=True, start_new_session=True
    )


def landed(folder: Path) -> int:
    """Return how many points of a sweep have results."""
    try:
        return int((open_sweep(folder)["outcome"] != "").sum())
    except (ValueError, OSError, KeyError):
        return 0


def test_a_sweep_survives_the_death_of_a_worker(undisturbed, processes, scenario, tmp_path):
    def kill(done: int, total: int, dashboard: str) -> None:
        if done >= 2 and processes.workers[0].poll() is None:
            processes.workers[0].kill()

    options = {"until": UNTIL, "scheduler": processes.address, "progress": kill}
    swept = amb_cosim.sweep(scenario, VARY, output=tmp_path / "swept", **options)
    assert processes.workers[0].wait() == -signal.SIGKILL
    same(swept.dataset, undisturbed)


def test_a_sweep_goes_on_after_its_client_was_killed(undisturbed, processes, scenario, tmp_path, is_long, first_seed):
    chance, killed = random.Random(first_seed), 0
    for k in range(30 if is_long else 3):
        folder = tmp_path / f"killed_{k}"
        process = client(folder, scenario, "--scheduler", processes.address)
        wait_for(lambda folder=folder, process=process: landed(folder) > 0 or process.poll() is not None)
        time.sleep(chance.uniform(0.0, 1.0))
        process.kill()
        process.communicate()
        killed += process.returncode == -signal.SIGKILL
        before = landed(folder)
        seen: list[int] = []
        swept = amb_cosim.sweep(
            scenario,
            VARY,
            output=folder,
            until=UNTIL,
            scheduler=processes.address,
            progress=lambda n, *_, seen=seen: seen.append(n),
        )
        assert not seen or seen[0] == before, f"seed {first_seed}: points were run again"
        same(swept.dataset, undisturbed)
    assert killed > 0


def test_a_sweep_goes_on_after_its_scheduler_was_killed(undisturbed, processes, scenario, tmp_path):
    def kill(done: int, total: int, dashboard: str) -> None:
        if done >= 2 and processes.scheduler.poll() is None:
            processes.scheduler.kill()

    from amb_cosim.sweeps.engine import ClusterFailed

    options = {"until": UNTIL, "output": tmp_path / "swept"}
    with pytest.raises(ClusterFailed):
        amb_cosim.sweep(scenario, VARY, scheduler=processes.address, progress=kill, **options)
    assert 0 < landed(tmp_path / "swept") < 12
    same(amb_cosim.sweep(scenario, VARY, jobs=1, progress=False, **options).dataset, undisturbed)


@pytest.mark.parametrize("local", [True, False])
def test_ctrl_c_keeps_what_came_and_exits_with_130(processes, scenario, tmp_path, local):
    where = ["--jobs", "1"] if local else ["--scheduler", processes.address]
    process = client(tmp_path / "swept", scenario, *where)
    wait_for(lambda: landed(tmp_path / "swept") > 0 or process.poll() is not None)
    os.killpg(process.pid, signal.SIGINT)  # as a terminal does
    _, errors = process.communicate(timeout=60)
    assert process.returncode == 130, errors
    assert "the same command goes on" in errors
    assert "Traceback" not in errors
