"""A system of foreign FMUs: two instances of a mass and a spring, connected by different names."""

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import amb_cosim
from amb_cosim.cosim.run.recording import Outcome
from tests.support.messages import assert_names, raises_naming

SUPPORT = Path(__file__).parent / "support"
OMEGA = np.sqrt(2.0 * 400.0)  # of two masses of 1 kg against each other


@pytest.fixture
def system_file(foreign_fmus: Path, tmp_path: Path) -> Path:
    shutil.copytree(foreign_fmus, tmp_path, dirs_exist_ok=True)
    return Path(shutil.copy(SUPPORT / "two_masses.toml", tmp_path))


def run(path: Path, experiment: str = "", **settings: object) -> tuple[Outcome, xr.Dataset]:
    """Return outcome and data of a run by the compiled loop, after comparison with the plain one."""
    path.write_text(path.read_text(encoding="utf-8") + experiment, encoding="utf-8")
    runs = [amb_cosim.simulate(path, set=settings, loop=loop, isolated=False) for loop in ("compiled", "plain")]
    compiled, plain = runs
    xr.testing.assert_equal(compiled.dataset, plain.dataset)
    assert compiled.outcome == plain.outcome
    return compiled.outcome, compiled.dataset


def test_two_masses_swing_against_each_other(system_file):
    outcome, result = run(system_file)
    time, left, right = (result[name].values for name in ("time", "left.x", "right.x"))
    swing = 0.005 * np.cos(OMEGA * time)
    assert (outcome.status, outcome.time, outcome.reason) == ("completed", 0.5, "")
    # the force is that of the beginning of each step: the amplitude grows by omega^2 h^2/4 a step
    growth = np.exp(0.25 * OMEGA**2 * 1e-3 * 0.5)
    np.testing.assert_allclose(left, 0.005 + swing, atol=0.005 * (growth - 1.0) * 1.2)
    np.testing.assert_allclose(left + right, 0.01, atol=1e-12)


def test_an_fmu_that_ends_the_simulation_is_named_with_its_reason(system_file):
    outcome, _ = run(system_file, **{"spring.k": -1.0})
    assert (outcome.status, outcome.time) == ("stopped", 0.0)
    assert_names(outcome.reason, "spring", "fmi2Terminated")


def test_an_event_and_a_profile_drive_any_input(system_file):
    changes = """
[[experiment.event]]
time = "0.1 s"
set = { "right.push" = 2.0 }
[[experiment.profile]]
variable = "left.push"
points = [["0.2 s", 0.0], ["0.4 s", 4.0]]
"""
    _, result = run(system_file, changes, **{"left.start": 0.0, "spring.k": 0.0})
    time, push = result["time"].values, result["left.push"].values
    np.testing.assert_allclose(push, np.interp(time, [0.2, 0.4], [0.0, 4.0]), atol=1e-12)
    np.testing.assert_array_equal(result["right.push"].values > 0.0, time > 0.1 - 1e-9)
    np.testing.assert_allclose(result["right.v"], 2.0 * np.maximum(time - 0.1, 0.0), atol=1e-12)
    # the slope of 20 N/s, held over each step of 1 ms
    np.testing.assert_allclose(result["left.v"][-1], 0.5 * 4.0 * 0.2 + 4.0 * 0.1, atol=4.0 * 1e-3)


def test_a_condition_on_any_signal_ends_the_run(system_file):
    outcome, _ = run(system_file, '[[experiment.stop]]\nvariable = "left.x"\nbelow = 0.002\nhold_time = "2 ms"\n')
    assert (outcome.status, outcome.reason) == ("stopped", "left.x below 0.002 for 0.002 s")
    first = np.arccos((0.002 - 0.005) / 0.005) / OMEGA
    assert outcome.time == pytest.approx(first + 2e-3, abs=1.5e-3)


@pytest.mark.parametrize(
    ("change", "options", "facts"),
    [
        (('{ "x" = "left" }', '{ "y" = "left" }'), {}, ("left", "'y'", "spring.left")),
        (('stop_time = "0.5 s"', ""), {}, ("experiment.stop_time",)),
        (('"0.5 s"', '"0.5 kg"'), {}, ("stop_time", "'0.5 kg'", "unit kg")),
        (('fmu = "Spring.fmu"', 'fmu = "Sprung.fmu"'), {}, ("Sprung.fmu",)),
        (("[[connect]]\nfrom", "[[connect]]\nform"), {}, ("connect[0].form", "from")),
        (
            ("[[component]]", 'coupling = "iterative"\n[[component]]'),
            {},
            ("coupling", "'iterative'", "spring, left, right", "canGetAndSetFMUstate"),
        ),
        (("", ""), {"step_size": 1e-3}, ("step_size", "stop_time", "SSP")),
    ],
)
def test_error_names_the_faulty_key_of_a_system_file(system_file, change, options, facts):
    system_file.write_text(system_file.read_text(encoding="utf-8").replace(*change, 1), encoding="utf-8")
    with raises_naming(ValueError, *facts):
        amb_cosim.simulate(system_file, **options)


def test_a_system_without_an_experiment_is_not_run(system_file):
    system = amb_cosim.load_system(system_file)
    with raises_naming(ValueError, "experiment"):
        amb_cosim.simulate(replace(system, name="two masses"))
