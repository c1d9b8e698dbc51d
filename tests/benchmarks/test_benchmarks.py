"""The baseline computes what the co-simulation computes, and every result is printed. No time is asserted."""

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

from benchmarks import process, sweeps
from benchmarks.live.measure import BROWSERS
from benchmarks.timing import interleaved_times, ratio, ratios
from tests.support.messages import raises_naming

needs_compiler = pytest.mark.skipif(find_spec("ziglang") is None, reason="a native FMU is compiled by ziglang")


def test_candidates_alternate_and_the_first_round_does_not_count() -> None:
    turns: list[str] = []

    def candidate(name: str) -> Callable[[], float]:
        def run() -> float:
            turns.append(name)
            return float(len(turns))

        return run

    times = interleaved_times({name: candidate(name) for name in "ab"}, rounds=2)
    assert turns == ["a", "b"] * 3
    assert times == {"a": [3.0, 5.0], "b": [4.0, 6.0]}


def test_ratios_are_taken_within_a_round() -> None:
    """A machine that is slow in one round is so for both."""
    times = {"a": [2.0, 20.0, 9.0], "b": [1.0, 10.0, 3.0]}
    assert ratios(times, "a", "b") == [2.0, 2.0, 3.0]
    assert ratio(times, "a", "b") == 2.0
    assert ratio(times, "a", "absent") is None


def test_error_of_a_failed_process_has_its_cause(tmp_path: Path) -> None:
    file = tmp_path / "case.py"
    file.write_text("def half(x):\n    return 1 / x\n", encoding="utf-8")
    assert process.run_function(sys.executable, str(file), "half", x=3) == 1 / 3
    with raises_naming(process.CandidateFailed, "half", "1", "ZeroDivisionError"):
        process.run_function(sys.executable, str(file), "half", x=0)


SCENARIO = """
description = "Unbalance comes and goes at 260 rad/s"
Omega = "260 rad/s"
settle_cycles = 3
end_cycle = 8
communication_step = "{step} us"

[inputs.rotor_contact]
"d1.u" = "0.5 g.m"

[[event]]
cycle = 0
set.rotor_contact."d1.u" = "25.5 g.m"

[[event]]
cycle = 6
set.rotor_contact."d1.u" = "0.5 g.m"
"""


def compared_with_baseline(cases: list[tuple[str, str | None]]) -> list[dict[str, Any]]:
    """Return the differences between co-simulation and baseline, and the data of each run.

    A case is the text or name of a scenario, and the end of its run.
    """
    import tomllib

    from amb_cosim.cosim.run.options import RunOptions
    from amb_cosim.scenario.prepare_run import prepare_run
    from amb_cosim.scenario.scenario import load_scenario, make_scenario
    from amb_cosim.scenario.simulation import execute
    from benchmarks.baseline import Baseline

    results = []
    for scenario, until in cases:
        parsed = make_scenario(tomllib.loads(scenario), "case") if "\n" in scenario else load_scenario(scenario)
        prepared = prepare_run(parsed, until=until, options=RunOptions(flavour="native"))
        dataset, result = execute(prepared).dataset, Baseline(prepared).run()
        profiled = Baseline(prepared).run(profile=True)
        expected = {name: dataset[name].values.astype(float) for name in prepared.recorded}
        pairs = zip(expected, result.table.T, strict=True)
        results.append(
            {
                "shape": list(result.table.shape),
                "points": dataset.sizes["time"],
                "variables": len(dataset.data_vars),
                "differing": [name for name, values in pairs if values.tobytes() != expected[name].tobytes()],
                "profiled": profiled.table.tobytes() == result.table.tobytes(),
                "parts": sum(profiled.parts.values()) / profiled.seconds,
                "steps": len(profiled.steps),
                "shortest_step": profiled.steps.min(),
                "all_steps": sum(profiled.steps) / sum(profiled.parts[c.name] for c in prepared.system.components),
                "contact": sorted(set(dataset["rotor_contact.contact_state"].values.tolist())),
            }
        )
    return results


BLOWER = str(process.REPOSITORY / "tests/amb_assessment/assessment/blower/levitation.toml")


@pytest.mark.slow
@needs_compiler
@pytest.mark.slow
def test_every_cost_of_a_sweep_is_measured() -> None:
    pytest.importorskip("distributed")
    data = sweeps.measure(sweeps.SweepEffort(batch=2, loop=1, commands=1, rounds=1, runs=4), lambda status: None)
    assert all(rate > 0.0 for rate in data["runs_per_second"].values())
    assert data["steps_ms"] > 0.0
    assert data["memory_mb"][-1][0] == 4
    assert all(1.0 < memory < 1e5 for _, *sampled in data["memory_mb"] for memory in sampled)
    assert sweeps.as_tables(data)


@pytest.mark.slow
@needs_compiler
def test_the_baseline_equals_the_co_simulation_to_the_last_bit(run_python) -> None:
    cases = {
        # the same program; in the second, every second step of the controller takes no sample
        (SCENARIO.format(step=250), None): 3,
        (SCENARIO.format(step=125), None): 3,
        ("drop", "0.02 s"): 1,  # with the stators of the run
        (BLOWER, "2 ms"): 0,  # with a controller of its own
    }
    results = run_python(compared_with_baseline, cases=[*cases], timeout=600)
    for result, contact in zip(results, cases.values(), strict=True):
        assert result["differing"] == []
        assert result["profiled"]
        assert result["shape"] == [result["points"], result["variables"]]
        assert result["contact"][-1] >= contact
        assert 0.0 < result["parts"] <= 1.0  # less than half if another program interrupts one of few steps
        assert result["steps"] == result["points"] - 1
        assert result["shortest_step"] > 0.0
        assert result["all_steps"] == pytest.approx(1.0, abs=1e-9)


def longest_of(scenario: str) -> dict[str, Any]:
    from benchmarks.step_times import step_times

    return step_times(3, [scenario])[scenario]["longest"]  # the least of three, since any may be interrupted


@pytest.mark.slow
@needs_compiler
def test_the_longest_step_of_a_fall_is_one_with_a_first_touch(run_python: Callable[..., Any]) -> None:
    """A rotor that falls from the centre touches after sqrt(2 c/g) = 12.4 ms, and flies by one product before."""
    longest = run_python(longest_of, scenario="drop", timeout=600)
    assert longest["begin"] > 0.011
    assert longest["method"] in ("pieces", "events")
    assert any(before != after for before, after in longest["contact"].values())


@pytest.mark.slow
@needs_compiler
def test_every_ratio_is_printed_and_null_for_missing_codes(tmp_path: Path) -> None:
    """ROSS and Siconos are missing unless this Python has them; ecos needs `unzip`."""
    tools, here = tmp_path / "tools", tmp_path / "here"
    for folder in (tools, here):
        folder.mkdir()
    if (unzip := shutil.which("unzip")) is not None:
        (tools / "unzip").symlink_to(unzip)
    paths = [str(process.REPOSITORY), *filter(None, [os.environ.get("PYTHONPATH")])]
    answer = subprocess.run(
        [sys.executable, "-m", "benchmarks", "--quick", "--json"],
        cwd=here,
        env={**os.environ, "PATH": str(tools), "PYTHONPATH": os.pathsep.join(paths)},
        capture_output=True,
        text=True,
        timeout=900,
        check=False,
    )
    assert answer.returncode == 0, answer.stderr[-2000:]
    data = json.loads(answer.stdout)
    for name in ("ecospy", "libcosimpy", "ross", "siconos"):
        measured = data["ratios"].pop(f"{name}_over_native")
        assert (measured is None) == (find_spec(name) is None) == (name in data["missing"]), data["missing"]
        assert measured is None or measured > 0.0
    assert sorted(data["ratios"]) == ["native_over_floor", "plain_over_compiled_python"]
    assert min(data["ratios"].values()) > 0.0
    assert {"native", "python"} <= {name for name, factor in data["real_time_factor"].items() if factor > 0.0}
    assert {"date", "processor", "cores", "python", "versions"} <= data["environment"].keys()
    assert data["linearity"]["sites"]["sites_in_contact"] == [0.0, 1.0, 2.0, 3.0, 4.0]
    assert data["linearity"]["variables"]["variables"][-1] > 200.0
    assert set(data["floor_us"]) == {"rolac_controller", "amb_actuator", "rotor_contact", "recording"}
    assert data["contact"]["cost_ratio_at_equal_accuracy"] > 1.0
    assert list(here.iterdir()) == []


@pytest.mark.slow
def test_missing_programs_are_reported_and_the_others_measured():
    from benchmarks.__main__ import main

    ended = CliRunner().invoke(main, ["live", "--quick", "--json"])
    assert ended.exit_code == 0, ended.output
    (factors,) = json.loads(ended.stdout)["factors"].values()
    has_browser = any(map(shutil.which, BROWSERS))
    for place, is_there in (("native", True), ("node", shutil.which("node")), ("chromium", has_browser)):
        assert (factors[place] is not None) == bool(is_there), place
        assert not is_there or 0.0 < factors[place]["least"] <= factors[place]["median"]
