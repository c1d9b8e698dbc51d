"""Processes killed at any moment, folders that cannot be written, caches that are absent."""

import json
import os
import resource
import signal
import subprocess
import sys
import time

import h5py
import pytest
from command_line import COMMAND
from waiting import let_compute, of_process, processor_time

pytestmark = [pytest.mark.slow, pytest.mark.skipif(sys.platform != "linux", reason="processes are watched in /proc")]

RUN = ["run", "fig4_9", "--until", "0.05", "--no-plots", "-o", "out"]


@pytest.fixture
def rounds(is_long):
    return 300 if is_long else 5


@pytest.fixture
def folder(tmp_path, cache):
    """A working folder with a first result, of a run that also fills the cache."""
    working = tmp_path / "working"
    working.mkdir()
    assert finished(working).returncode == 0
    return working


def start(folder, *arguments, **options):
    options = {"stderr": subprocess.PIPE, "stdout": subprocess.DEVNULL, "text": True} | options
    return subprocess.Popen([*COMMAND, *(arguments or RUN)], cwd=folder, **options)


def finished(folder, *arguments, **options):
    with start(folder, *arguments, **options) as process:
        try:
            _, errors = process.communicate(timeout=900.0)
        except subprocess.TimeoutExpired:
            process.kill()
            raise
    return subprocess.CompletedProcess(process.args, process.returncode, "", errors)


@pytest.fixture
def duration(folder):
    """The processor time of a run (s)."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    assert finished(folder).returncode == 0
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def moments(chance, rounds):
    """Return a random time in each of `rounds` equal parts of a run, as a share of its CPU time."""
    return [(k + chance.random()) / rounds for k in range(rounds)]


def handles_signals(process):
    """Whether the process handles SIGTERM itself; before that, Python is starting."""
    status = of_process(process.pid, "status")
    if not status:
        return True
    caught = next((line.split()[1] for line in status.splitlines() if line.startswith("SigCgt")), "0")
    return bool(int(caught, 16) >> (signal.SIGTERM - 1) & 1)


def check_result(folder):
    """A whole result, and nothing beside it."""
    json.loads((folder / "out" / "summary.json").read_text())
    with h5py.File(folder / "out" / "result.nc") as data:
        assert len(data["time"]) > 0
    assert sorted(path.name for path in (folder / "out").iterdir()) == ["result.nc", "summary.json"]


def test_kill_at_any_moment_leaves_a_whole_result(folder, duration, chance, rounds):
    killed = 0
    for moment in moments(chance, rounds):
        process = start(folder)
        let_compute(process, moment * duration)
        process.kill()
        process.communicate()
        killed += process.returncode == -signal.SIGKILL
        json.loads((folder / "out" / "summary.json").read_text())
        with h5py.File(folder / "out" / "result.nc") as data:
            assert len(data["time"]) > 0
    assert killed > 0.5 * rounds
    assert finished(folder).returncode == 0
    check_result(folder)
    assert [path.name for path in folder.iterdir()] == ["out"]


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_signal_at_any_moment_prints_one_line(folder, duration, chance, rounds, number, code):
    codes = []
    for moment in moments(chance, rounds):
        process = start(folder)
        while not handles_signals(process):
            time.sleep(0.001)
        begin = processor_time(process.pid)
        let_compute(process, begin + moment * (duration - begin))
        process.send_signal(number)
        _, errors = process.communicate(timeout=300.0)
        codes.append(process.returncode)
        # Python takes its handlers away when it ends, and has nothing left to do then
        assert process.returncode in (0, code, -number), errors
        assert "Traceback" not in errors
        if process.returncode == code:
            assert sum(line.startswith("amb-cosim: ") for line in errors.splitlines()) == 1, errors
        check_result(folder)
    assert code in codes


def test_read_only_folder_is_refused_before_the_run(folder, small_disk):
    read_only_disk = small_disk("300k")
    subprocess.run(["mount", "-o", "remount,ro", read_only_disk], check=True)
    done = finished(folder, "run", "fig4_9", "-o", str(read_only_disk / "out"))
    assert done.returncode == 2
    assert done.stderr.startswith(f"amb-cosim: {read_only_disk}/out cannot be written to: Read-only file system")


def test_run_without_home_and_cache_is_the_same(folder, tmp_path):
    """What is compiled stays in the temporary folder of the process, and goes with it."""
    temporary = tmp_path / "temporary"
    temporary.mkdir()
    environment = {name: os.environ[name] for name in ("PATH", "OPENBLAS_NUM_THREADS") if name in os.environ}
    environment |= {"HOME": "/nonexistent/home", "XDG_CACHE_HOME": "/dev/null/cache", "TMPDIR": str(temporary)}
    done = finished(folder, env=environment)
    assert done.returncode == 0, done.stderr
    check_result(folder)
    assert not list(temporary.glob(".amb-cosim-*"))
