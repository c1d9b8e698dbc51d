"""A system of FMUs that are not this project's: two instances of one, wired by different names."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

SUPPORT = Path(__file__).parent / "support"
OMEGA = np.sqrt(2.0 * 400.0)  # of two masses of 1 kg against each other


@pytest.fixture(scope="module")
def system_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    from pythonfmu.builder import FmuBuilder

    folder = tmp_path_factory.mktemp("two_masses")
    for script in ("mass.py", "spring.py"):
        FmuBuilder.build_FMU(SUPPORT / script, dest=folder)
    return Path(shutil.copy(SUPPORT / "two_masses.toml", folder))


def run(run_python, path: Path, experiment: str = "", **settings: object) -> dict:
    def simulated(path: str, experiment: str, settings: dict) -> dict:
        import tomllib
        from pathlib import Path

        import amb_cosim

        if experiment:
            text = Path(path).read_text(encoding="utf-8")
            path = str(Path(path).with_name("changed.toml"))
            Path(path).write_text(text + experiment, encoding="utf-8")
            tomllib.loads(text + experiment)
        results = {loop: amb_cosim.simulate(path, set=settings, loop=loop) for loop in ("compiled", "plain")}
        data = {loop: {n: v.values.tolist() for n, v in r.dataset.items()} for loop, r in results.items()}
        assert data["compiled"] == data["plain"]
        found = results["plain"]
        return {
            "time": found.dataset.time.values.tolist(),
            "outcome": [found.outcome.status, found.outcome.time, found.outcome.reason],
            **data["plain"],
        }

    return run_python(simulated, path=str(path), experiment=experiment, settings=settings)


def test_two_masses_swing_against_each_other(run_python, system_file):
    found = run(run_python, system_file)
    time, left, right = (np.array(found[name]) for name in ("time", "left.x", "right.x"))
    swing = 0.005 * np.cos(OMEGA * time)
    assert found["outcome"] == ["completed", 0.5, ""]
    # the force is that of the beginning of each step: the amplitude grows by omega^2 h^2/4 a step
    growth = np.exp(0.25 * OMEGA**2 * 1e-3 * 0.5)
    np.testing.assert_allclose(left, 0.005 + swing, atol=0.005 * (growth - 1.0) * 1.2)
    np.testing.assert_allclose(left + right, 0.01, atol=1e-12)


@pytest.mark.slow
def test_the_error_of_the_coupling_falls_with_the_step(run_python, system_file):
    errors = []
    for step in ("1 ms", "0.5 ms"):
        text = system_file.read_text(encoding="utf-8").replace('"1 ms"', f'"{step}"')
        path = system_file.with_name("stepped.toml")
        path.write_text(text, encoding="utf-8")
        found = run(run_python, path)
        time, left = np.array(found["time"]), np.array(found["left.x"])
        errors.append(np.max(np.abs(left - 0.005 - 0.005 * np.cos(OMEGA * time))))
    assert 1.7 < errors[0] / errors[1] < 2.3


def test_an_fmu_that_ends_the_simulation_is_named_with_its_reason(run_python, system_file):
    found = run(run_python, system_file, **{"spring.k": -1.0})
    sentence = "fmi2DoStep answered Discard: with fmi2Terminated the FMU ends the simulation"
    assert found["outcome"] == ["failed", 0.0, sentence]


def test_fmus_that_save_no_state_are_refused_where_steps_are_repeated(run_python, system_file):
    def refusal(path: str) -> str:
        import amb_cosim

        try:
            amb_cosim.simulate(path)
        except ValueError as error:
            return str(error)
        return ""

    path = system_file.with_name("iterative.toml")
    path.write_text('coupling = "iterative"\n' + system_file.read_text(encoding="utf-8"), encoding="utf-8")
    assert run_python(refusal, path=str(path)) == (
        "coupling = 'iterative' is not allowed with spring, left, right: it repeats steps, and an FMU cannot save and "
        "restore its state there (canGetAndSetFMUstate)"
    )


def test_an_event_and_a_profile_drive_any_input(run_python, system_file):
    changes = """
[[experiment.event]]
time = "0.1 s"
set = { "right.push" = 2.0 }
[[experiment.profile]]
variable = "left.push"
points = [["0.2 s", 0.0], ["0.4 s", 4.0]]
"""
    found = run(run_python, system_file, changes, **{"left.start": 0.0, "spring.k": 0.0})
    time, push = np.array(found["time"]), np.array(found["left.push"])
    np.testing.assert_allclose(push, np.interp(time, [0.2, 0.4], [0.0, 4.0]), atol=1e-12)
    np.testing.assert_array_equal(np.array(found["right.push"]) > 0.0, time > 0.1 - 1e-9)
    np.testing.assert_allclose(found["right.v"], 2.0 * np.maximum(time - 0.1, 0.0), atol=1e-12)
    # the slope of 20 N/s, held over each step of 1 ms
    np.testing.assert_allclose(found["left.v"][-1], 0.5 * 4.0 * 0.2 + 4.0 * 0.1, atol=4.0 * 1e-3)


def test_a_condition_on_any_signal_ends_the_run(run_python, system_file):
    found = run(
        run_python, system_file, '[[experiment.stop]]\nvariable = "left.x"\nbelow = 0.002\nhold_time = "2 ms"\n'
    )
    status, end, reason = found["outcome"]
    assert (status, reason) == ("stopped", "left.x below 0.002 for 0.002 s")
    first = np.arccos((0.002 - 0.005) / 0.005) / OMEGA
    assert end == pytest.approx(first + 2e-3, abs=1.5e-3)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (('{ "x" = "left" }', '{ "y" = "left" }'), r"left has no variable 'y'.*connected with spring\.left"),
        (('stop_time = "0.5 s"', ""), r"experiment\.stop_time is missing"),
        (('"0.5 s"', '"0.5 kg"'), "stop_time = '0.5 kg' has unit kg"),
        (('fmu = "Spring.fmu"', 'fmu = "Sprung.fmu"'), r"no FMU '.*Sprung\.fmu'"),
        (("[[connect]]\nfrom", "[[connect]]\nform"), r"unknown key connect\[0\]\.form; did you mean from"),
    ],
)
def test_a_mistake_in_a_system_file_is_named(system_file, change, message):
    import amb_cosim

    path = system_file.with_name("wrong.toml")
    path.write_text(system_file.read_text(encoding="utf-8").replace(*change, 1), encoding="utf-8")
    with pytest.raises(ValueError, match=message):
        amb_cosim.simulate(path)


def test_a_system_needs_an_experiment_to_run(system_file):
    import amb_cosim

    system = amb_cosim.load_system(system_file)
    with pytest.raises(ValueError, match="needs an experiment"):
        amb_cosim.simulate(replace(system, name="two masses"))


def test_step_and_end_of_a_system_file_are_its_experiments(system_file):
    import amb_cosim

    with pytest.raises(ValueError, match="step_size and stop_time are for SSP archives"):
        amb_cosim.simulate(system_file, step_size=1e-3)
