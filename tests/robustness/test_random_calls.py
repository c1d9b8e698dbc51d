"""Calls of each FMU in any order with any values: finite numbers or an error, and never a crash or a hang."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from slow import slow_but_first

NATIVE_SUPPORT = Path(__file__).parents[1] / "native" / "support"
MODELS = ("amb_actuator", "rolac_controller", "rotor_contact")
SLOWEST = 5.0  # s of the processor's time that a call may take
STALLED = 600.0  # s without another call, in which flavour `python` compiles its kernels first


@pytest.fixture
def call_randomly(fmu_folder, first_seed, tmp_path):
    """`call_randomly(model, flavour, calls, threads)`: how often each function had each status."""

    def call(model, flavour, calls, threads):
        script, journal = Path(__file__).parent / "support" / "random_calls.py", tmp_path / "journal"
        arguments = [fmu_folder(model, flavour), first_seed, calls, threads, SLOWEST, journal]
        environment = os.environ | {"PYTHONPATH": str(NATIVE_SUPPORT)}
        process = subprocess.Popen(
            [sys.executable, script, *map(str, arguments)], env=environment, stdout=subprocess.PIPE, text=True
        )
        before, output = b"", None
        while output is None:
            try:
                output, _ = process.communicate(timeout=STALLED)
            except subprocess.TimeoutExpired:
                now = journal.read_bytes() if journal.is_file() else b""
                if now == before:
                    process.kill()
                    process.wait()
                    output = "it hangs"
                before = now
        last = [line.strip() for line in journal.read_text().replace("\0", " ").split("call ") if line.strip()]
        answer = json.loads(output.splitlines()[-1]) if process.returncode in (0, 1) else {"mistakes": [output]}
        said = f"seed {first_seed}, exit code {process.returncode}, {answer['mistakes']}, last calls {last}"
        assert process.returncode == 0, said
        print(answer["counts"])
        return answer["counts"]

    return call


@pytest.mark.parametrize("threads", slow_but_first([3, 1]))
@pytest.mark.parametrize("model", slow_but_first(MODELS))
def test_native_fmu_answers_any_calls_with_finite_numbers_or_errors(call_randomly, is_long, model, threads):
    counts = call_randomly(model, "native", 1_000_000 if is_long else 20_000, threads)
    assert counts["DoStep 0"] > 500
    assert counts["DoStep 3"] > 100
    assert counts["SetFMUstate 0"] > 200
    assert counts["foreign states refused"] > 20


@pytest.mark.slow
@pytest.mark.parametrize("model", MODELS)
def test_python_fmu_answers_any_calls_with_finite_numbers_or_errors(call_randomly, is_long, model):
    counts = call_randomly(model, "python", 100_000 if is_long else 5_000, 2)
    assert counts["DoStep 0"] > 100
    assert counts["DoStep 3"] > 20
    assert counts["SetFMUstate 0"] > 50
    assert counts["foreign states refused"] > 5
