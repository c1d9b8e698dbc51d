"""FMUs that crash, hang, fork, speak or close what is not theirs, at any of their calls."""

from __future__ import annotations

import os
import subprocess
import sys
import time
import zipfile
from pathlib import Path

import pytest

import amb_cosim
from amb_cosim.cosim import isolation
from amb_cosim.cosim.errors import FmuError, ProcessFailed, StartFailed

pytestmark = [pytest.mark.slow, pytest.mark.skipif(sys.platform != "linux", reason="the FMU is compiled for Linux")]

SOURCE = Path(__file__).parent / "support" / "hostile.c"
(NOTHING, SEGV, ABORT, LEAVE, KILL, OVERFLOW, FORK, FORK_AWAY, DAEMON, HANG, SPEAK, CLOSE, EAT, TERM, FREE_TWICE, ERROR,
 FATAL, UNKNOWN, DEAF) = range(19)  # fmt: skip
HARMLESS = (NOTHING, FORK, FORK_AWAY, DAEMON, EAT, DEAF)  # after which the run goes on
STEPS = 5
LONGEST = 60.0  # s, of a run; those that hang are ended after one
DESCRIPTION = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="Hostile" guid="{hostile}">
<CoSimulation modelIdentifier="hostile" canHandleVariableCommunicationStepSize="true" canGetAndSetFMUstate="true"/>
<ModelVariables>
<ScalarVariable name="u" valueReference="0" causality="input"><Real start="0"/></ScalarVariable>
<ScalarVariable name="y" valueReference="1" causality="output"><Real/></ScalarVariable>
</ModelVariables>
<ModelStructure><Outputs><Unknown index="2"/></Outputs></ModelStructure>
</fmiModelDescription>
"""
SYSTEM = f"""
coupling = "{{coupling}}"
[[component]]
name = "one"
fmu = "Hostile.fmu"
[experiment]
communication_step = "1 ms"
stop_time = "{STEPS} ms"
record.variables = ["*"]
[[experiment.event]]
time = "2 ms"
set = {{{{ "one.u" = 1.0 }}}}
"""


@pytest.fixture
def system(create_once, tmp_path):
    """`system(coupling)`: path of a system of the hostile FMU alone."""
    pytest.importorskip("ziglang", reason="the FMU is compiled by ziglang: pip install 'amb-cosim[native]'")

    def fill(folder):
        compile_it = [sys.executable, "-m", "ziglang", "cc", "-shared", "-fPIC", "-O1", "-fno-sanitize=all"]
        subprocess.run([*compile_it, "-o", folder / "hostile.so", SOURCE], check=True, capture_output=True)
        with zipfile.ZipFile(folder / "Hostile.fmu", "w") as archive:
            archive.writestr("modelDescription.xml", DESCRIPTION)
            archive.write(folder / "hostile.so", "binaries/linux64/hostile.so")

    fmu = create_once("hostile-fmu", fill) / "Hostile.fmu"

    def write(coupling):
        path = tmp_path / "system.toml"
        path.write_text(SYSTEM.format(coupling=coupling).replace("Hostile.fmu", str(fmu)), encoding="utf-8")
        return path

    return write


def processes_with(word: str) -> set[int]:
    """Numbers of the processes that have this in their environment."""
    found = set()
    for process in Path("/proc").glob("[0-9]*"):
        try:
            if word.encode() in (process / "environ").read_bytes():
                found.add(int(process.name))
        except OSError:
            continue
    return found


def test_whatever_an_fmu_does_is_an_outcome_or_one_message(system, monkeypatch, chance, first_seed, rounds):
    """No hang, no process left, and what was recorded before the FMU was ended is kept."""
    monkeypatch.setattr(isolation, "LONGEST_SILENCE", 2.0)
    monkeypatch.setattr(isolation, "CLOSE_TIME", 2.0)
    outcomes = set()
    for k in range(rounds):
        deed, call, coupling = chance.randrange(19), chance.randrange(28), chance.choice(("gauss_seidel", "iterative"))
        mark = f"HOSTILE_MARK={os.getpid()}-{first_seed}-{k}"
        for name, value in (("HOSTILE_DEED", deed), ("HOSTILE_CALL", call), ("HOSTILE_MARK", mark.partition("=")[2])):
            monkeypatch.setenv(name, str(value))
        told = f"seed {first_seed}, round {k}: deed {deed} at call {call}, {coupling}"
        begin = time.monotonic()
        try:
            result = amb_cosim.simulate(system(coupling))
            ended, said = result.outcome.status, result.outcome.reason
        except (FmuError, StartFailed, ProcessFailed) as error:
            ended, said = type(error).__name__, str(error)
        outcomes.add(ended)
        assert "\n" not in said, told
        assert ended == "completed" or deed not in HARMLESS, f"{told}: {said}"
        if ended == "completed":
            assert result.dataset["one.y"].values[1:].tolist() == [n * 1e-3 + 1e-3 for n in range(STEPS)], told
        assert time.monotonic() < begin + LONGEST, told
        end = time.monotonic() + 10.0
        while left := processes_with(mark) - {os.getpid()}:
            assert time.monotonic() < end, f"{told}: {left} still run"
            time.sleep(0.05)
    assert outcomes >= {"completed", "failed", "ProcessFailed"}


def test_the_campaign_reaches_every_call(system, monkeypatch):
    """So many calls are made that the last of them is the end of the instance: a crash there costs no record."""
    monkeypatch.setenv("HOSTILE_DEED", str(SEGV))
    monkeypatch.setattr(isolation, "CLOSE_TIME", 2.0)
    ends = []
    for call in range(40):
        monkeypatch.setenv("HOSTILE_CALL", str(call))
        try:
            result = amb_cosim.simulate(system("gauss_seidel"))
        except ProcessFailed:
            ends.append("ended")
            continue
        ends.append("warned" if "one" in result.dataset.attrs["warnings"] else "completed")
        if ends[-1] == "completed":
            break
    assert ends[-3:] == ["warned", "warned", "completed"], "fmi2Terminate, fmi2FreeInstance, and none is left"
    assert set(ends[:-3]) == {"ended"}
