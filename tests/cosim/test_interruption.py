"""Ctrl-C and SIGTERM: exit codes, saved records, and no leftover processes."""

import os
import signal
import subprocess
import sys
import time
from contextlib import suppress

import click
import pytest
from slow import slow_but_first
from waiting import LONGEST, children, is_running, of_process, wait_for_work, wait_until

from amb_cosim.commands import cli
from amb_cosim.cosim.master.master import Master
from amb_cosim.cosim.processes.interruption import deferred
from amb_cosim.cosim.run.dataset import load
from tests.support.messages import assert_names

CODES = {signal.SIGINT: 130, signal.SIGTERM: 143}


@pytest.fixture
def command(monkeypatch):
    """`command(function)`: makes the function the command `tested` of the command line."""

    def add(function):
        monkeypatch.setitem(cli.main.commands, "tested", click.Command("tested", callback=function))

    return add


def workers_among(processes):
    return [process for process in processes if "spawn_main" in of_process(process, "cmdline")]


def be_interrupted(number):
    os.kill(os.getpid(), number)


def swallow(number):
    with suppress(KeyboardInterrupt):
        os.kill(os.getpid(), number)


def fail(number):
    swallow(number)
    raise ImportError("initialization failed")


@pytest.mark.parametrize("number", CODES)
@pytest.mark.parametrize("deed", [be_interrupted, swallow, fail])
def test_a_signal_ends_a_command_with_its_own_exit_code(runner, command, number, deed):
    command(lambda: deed(number))
    before = [signal.getsignal(number) for number in CODES]
    result = runner("tested")
    assert (result.exit_code, result.stderr) == (CODES[number], "amb-cosim: interrupted\n")
    assert [signal.getsignal(number) for number in CODES] == before


@pytest.mark.filterwarnings("error")
def test_a_signal_that_a_finaliser_drops_is_raised_again(runner, command):
    class Killed:
        def __del__(self):
            os.kill(os.getpid(), signal.SIGTERM)

    after = []

    def drop():
        Killed()
        for _ in range(100):
            time.sleep(0.1)
        after.append(True)

    command(drop)
    result = runner("tested")
    assert (result.exit_code, result.stderr, after) == (143, "amb-cosim: interrupted\n", [])


def test_a_signal_that_was_lost_before_a_run_ends_it_at_once(runner, command):
    came = []

    def run():
        swallow(signal.SIGTERM)
        with deferred() as interruption:
            came.append(interruption.received)

    command(run)
    runner("tested")
    assert came == [True]


def test_deferred_interrupts_leave_sigterm_at_its_default():
    with deferred():
        assert signal.getsignal(signal.SIGTERM) is signal.SIG_DFL


IMPORTED = ("amb_cosim.commands.cli", "click", "amb_cosim.commands.run", "numpy", "fmpy")
INTERRUPTED, TERMINATED = ([(number, name) for name in IMPORTED] for number in CODES)


@pytest.mark.parametrize("case", [*INTERRUPTED, *slow_but_first(TERMINATED)])
def test_a_signal_during_an_import_prints_one_line(tmp_path, case):
    number, module = case
    program = f"""
import os, sys
from amb_cosim import start

class Interrupting:
    def find_spec(self, name, *_):
        if name == {module!r}:
            os.kill(os.getpid(), {int(number)})

sys.meta_path.insert(0, Interrupting())
start.main()
"""
    command = [sys.executable, "-c", program, "run", "fig4_9", "--until", "0.001"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=LONGEST)
    assert (done.returncode, done.stderr) == (CODES[number], "amb-cosim: interrupted\n")
    assert not list(tmp_path.iterdir())


def test_an_interruption_at_the_start_keeps_the_old_result(runner, monkeypatch, tmp_path):
    assert runner("run", "fig4_9", "--until", "0.02", "--no-plots", "-o", "out").exit_code == 0
    before = {path: path.read_bytes() for path in (tmp_path / "out").iterdir()}
    monkeypatch.setattr(Master, "check_start", lambda *_: os.kill(os.getpid(), signal.SIGTERM))
    result = runner("run", "fig4_9", "-o", "out")
    assert result.exit_code == 143
    assert_names(result.stderr, "interrupted", "nothing was written")
    assert {path: path.read_bytes() for path in (tmp_path / "out").iterdir()} == before


@pytest.mark.parametrize("number", slow_but_first(CODES))
def test_a_signal_during_a_run_keeps_the_record(start, tmp_path, number):
    (tmp_path / "long.toml").write_text("base = 'fig4_9'\nend_cycle = 1e5\nsettle_cycles = 0\nrecord.every = 1000\n")
    process = start("run", "long.toml", "--no-plots", "-o", "out")
    wait_until(lambda: "rolac_controller.so" in of_process(process.pid, "maps"))
    wait_for_work(process.pid, 0.5)
    process.send_signal(number)
    _, errors = process.communicate(timeout=LONGEST)
    assert process.returncode == CODES[number]
    assert errors.splitlines()[-1].startswith("amb-cosim: interrupted at t = ")
    assert load(tmp_path / "out" / "result.nc").attrs["completed"] == 0
    assert sorted(path.name for path in tmp_path.iterdir()) == ["long.toml", "out"]


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="the processes are found in /proc")
@pytest.mark.parametrize("number", [signal.SIGKILL, *CODES])
def test_the_processes_of_a_study_end_with_the_study(start, number):
    process = start("study", "recovery", "--instants", "16")
    wait_until(lambda: len(workers_among(children(process.pid))) >= min(2, os.cpu_count()))
    workers = workers_among(children(process.pid))
    process.send_signal(number)
    process.communicate(timeout=LONGEST)
    assert process.returncode == CODES.get(number, -signal.SIGKILL)
    wait_until(lambda: not any(map(is_running, workers)))
