"""FMUs that answer what FMI does not have, leave processes behind, or crash as they are ended."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import amb_cosim
from amb_cosim.cosim import isolation
from amb_cosim.cosim.warnings import warnings_of

GOOD, MINUS_ONE, NINETY_NINE, LATIN, NAN_OUT, FORK, FORK_AWAY, CRASH_AT_TERMINATE, CRASH_AT_FREE, FORK_DAEMON = range(
    10
)
COMMAND = [sys.executable, "-c", "from amb_cosim.start import main; main()"]
SYSTEM = """
[[component]]
name = "one"
fmu = "Odd.fmu"
[experiment]
communication_step = "1 ms"
stop_time = "{end}"
record.variables = ["*"]
[[experiment.event]]
time = "5 ms"
set = {{ "one.what" = {what} }}
"""

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="the FMU is compiled for Linux")


@pytest.fixture
def run(odd_fmu, tmp_path):
    """`run(what, **options)`: the result of a system whose FMU does that after 5 ms."""
    shutil.copy(odd_fmu, tmp_path)

    def simulate(what, end="10 ms", **options):
        (tmp_path / "system.toml").write_text(SYSTEM.format(what=what, end=end))
        return amb_cosim.simulate(tmp_path / "system.toml", **options)

    return simulate


def processes_of(folder):
    """Numbers of the processes that have something of this folder loaded."""
    found = []
    for process in Path("/proc").glob("[0-9]*"):
        try:
            if str(folder) in (process / "maps").read_text():
                found.append(int(process.name))
        except OSError:
            continue
    return found


@pytest.mark.parametrize("loop", ["compiled", "plain"])
@pytest.mark.parametrize(("what", "status"), [(MINUS_ONE, -1), (NINETY_NINE, 99)])
def test_a_status_that_fmi_does_not_have_is_an_error(run, what, status, loop):
    outcome = run(what, loop=loop).outcome
    assert (outcome.status, outcome.time) == ("failed", 0.005)
    assert f"answered {status}, a status that FMI does not have" in outcome.reason


def test_a_message_that_is_not_utf8_is_kept(run):
    (warned,) = {w.sentence for w in warnings_of(run(LATIN).dataset)}
    assert warned == "Temp\ufffdrature trop \ufffdlev\ufffde"


def test_a_value_that_is_no_number_is_a_warning_with_name_and_time(run):
    result = run(NAN_OUT)
    assert result.outcome.status == "completed"
    assert [w.sentence for w in warnings_of(result.dataset)] == [
        "one.y = nan at t = 0.006 s, which is no finite number"
    ]
    assert not warnings_of(run(GOOD).dataset)


@pytest.mark.parametrize("what", [FORK, FORK_AWAY])
def test_a_process_that_an_fmu_starts_does_not_hold_the_run(run, what, monkeypatch):
    monkeypatch.setattr(isolation, "CLOSE_TIME", 2.0)
    begin = time.monotonic()
    result = run(what)
    assert (result.outcome.status, result.dataset.sizes["time"]) == ("completed", 11)
    assert time.monotonic() < begin + 60.0, "it waited for the process that the FMU has started"


@pytest.mark.parametrize("what", [FORK, FORK_AWAY, FORK_DAEMON])
def test_a_process_of_a_process_ends_with_the_run(run, tmp_path, monkeypatch, what):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    run(what)
    end = time.monotonic() + 10.0
    while processes_of(tmp_path / "cache"):
        assert time.monotonic() < end
        time.sleep(0.05)


@pytest.mark.parametrize("what", [CRASH_AT_TERMINATE, CRASH_AT_FREE])
def test_a_crash_as_it_is_ended_costs_no_record(run, what):
    result = run(what)
    assert result.outcome.status == "completed"
    np.testing.assert_allclose(result.dataset["one.y"][-1], 0.01)
    (warned,) = warnings_of(result.dataset)
    assert (
        "the process of one ended with SIGSEGV, as they were terminated and freed; the record is whole"
        in warned.sentence
    )


def test_ctrl_c_says_what_it_waits_for_and_ends_what_was_started(run, foreign_fmus, tmp_path):
    shutil.copy(foreign_fmus / "Unruly.fmu", tmp_path)
    (tmp_path / "system.toml").write_text(SYSTEM.format(what=2, end="10 ms").replace("Odd", "Unruly"))  # it hangs
    environment = os.environ | {"XDG_CACHE_HOME": str(tmp_path / "cache")}
    command = [*COMMAND, "simulate", "system.toml", "-o", "out"]
    with subprocess.Popen(command, cwd=tmp_path, env=environment, stderr=subprocess.PIPE, text=True) as process:
        end = time.monotonic() + 60.0
        while not processes_of(tmp_path / "cache"):
            assert time.monotonic() < end
            time.sleep(0.05)
        time.sleep(1.0)
        os.kill(process.pid, signal.SIGINT)
        line = next(line for line in process.stderr if "waiting" in line)
        assert "waiting for a step of one to end; a second Ctrl-C ends it at once" in line
        os.kill(process.pid, signal.SIGINT)
        process.communicate(timeout=60)
    assert process.returncode == 130
    assert not processes_of(tmp_path / "cache")
