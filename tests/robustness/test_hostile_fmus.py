"""FMUs that crash, hang, fork, print or close foreign files, at any of their calls."""

import sys
import time

import pytest
from fmu_systems import system_text
from hostile import DEEDS, HARMLESS

import amb_cosim
from amb_cosim.cosim.errors import FmuError, ProcessFailed, StartFailed
from amb_cosim.cosim.run import isolation

pytestmark = [pytest.mark.slow, pytest.mark.skipif(sys.platform != "linux", reason="the FMU is compiled for Linux")]

STEPS = 5
CALLS = 28  # that an FMU gets in them at most
FIRST = (("nothing", 0), ("error", CALLS // 2), ("segv", CALLS // 2))  # one for each outcome; the rest is drawn
LONGEST = 60.0  # s, of a run


@pytest.fixture
def system(hostile, tmp_path):
    """`system(version, coupling)`: path of a system of the hostile FMU alone."""

    def write(version, coupling):
        path = tmp_path / "system.toml"
        text = system_text({"one": hostile.fmu(version)}, '"one.u" = 1.0', f"{STEPS} ms", at="2 ms")
        path.write_text(f'coupling = "{coupling}"\n{text}', encoding="utf-8")
        return path

    return write


def test_any_behaviour_of_an_fmu_gives_an_outcome_or_a_message(
    system, hostile, monkeypatch, chance, first_seed, rounds
):
    """No hang, no leftover process, and the record up to the end of the FMU is kept."""
    monkeypatch.setattr(isolation, "LONGEST_SILENCE", 10.0)  # in which a process starts, too
    monkeypatch.setattr(isolation, "CLOSE_TIME", 2.0)
    outcomes = set()
    for k in range(rounds):
        deed, call = FIRST[k] if k < len(FIRST) else (chance.choice(DEEDS), chance.randrange(CALLS))
        version = chance.choice((2, 3))
        coupling = chance.choice(("gauss_seidel", "iterative"))
        hostile.will(deed, call)
        message = f"seed {first_seed}, round {k}: {deed} at call {call}, FMI {version}, {coupling}"
        begin = time.monotonic()
        try:
            result = amb_cosim.simulate(system(version, coupling))
            outcome, reason = result.outcome.status, result.outcome.reason
        except (FmuError, StartFailed, ProcessFailed) as error:
            outcome, reason = type(error).__name__, str(error)
        outcomes.add(outcome)
        assert "\n" not in reason, message
        assert outcome == "completed" or deed not in HARMLESS, f"{message}: {reason}"
        if outcome == "completed" and deed not in ("nan", "inf"):
            assert result.dataset["one.y"].values[1:].tolist() == [n * 1e-3 + 1e-3 for n in range(STEPS)], message
        assert time.monotonic() < begin + LONGEST, message
        end = time.monotonic() + 10.0
        while left := hostile.processes():
            assert time.monotonic() < end, f"{message}: {left} still run"
            time.sleep(0.05)
    assert outcomes >= {"completed", "failed", "ProcessFailed"}


def test_the_campaign_reaches_every_call(system, hostile, monkeypatch):
    """So many calls are made that the last of them is the end of the instance: a crash there costs no record."""
    monkeypatch.setattr(isolation, "CLOSE_TIME", 2.0)
    ends = []
    for call in range(40):
        hostile.will("segv", call)
        try:
            result = amb_cosim.simulate(system(3, "gauss_seidel"))
        except ProcessFailed:
            ends.append("outcome")
            continue
        ends.append("warned" if "one" in result.dataset.attrs["warnings"] else "completed")
        if ends[-1] == "completed":
            break
    assert ends[-3:] == ["warned", "warned", "completed"], "Terminate, FreeInstance, and none is left"
    assert set(ends[:-3]) == {"outcome"}
    assert len(ends) <= CALLS + 1
