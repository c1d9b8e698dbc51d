"""Each component of the rig replaced by another's FMU: the rig runs, and the results are those that they must be."""

import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tomli_w

import amb_cosim
from amb_cosim.results.result import Result
from rotor_analysis.response import unbalance_response
from rotor_analysis.rotor_file import load_rotor
from rotor_analysis.supported_rotor import supported_plant, supported_rotor

pytestmark = pytest.mark.gate


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """`run(fmu=.., ...)`: `fig4_9` with replaced components, once each; paths are relative to the scenario's file."""
    folder, results = tmp_path_factory.mktemp("scenarios"), {}

    def run_it(fmu: dict[str, Path] | None = None, **changes: Any) -> Result:
        files = {component: os.path.relpath(path, folder) for component, path in (fmu or {}).items()}
        scenario = {"base": "fig4_9", "settling": "simulated", "fmu": files, **changes}
        if (text := tomli_w.dumps(scenario)) not in results:
            path = folder / "swapped.toml"
            path.write_text(text, encoding="utf-8")
            results[text] = amb_cosim.run(path, progress=False)
            assert results[text].outcome.failure is None, results[text].outcome.failure
        return results[text]

    return run_it


def motion(result: Result) -> np.ndarray:
    names = [f"rotor_contact.{b}.{a}" for b in ("mb1", "mb2") for a in "xy"]
    return np.array([result.dataset[name].values for name in names])


def before_the_step(result: Result) -> np.ndarray:
    return motion(result)[:, result.dataset["cycle"].values < 5.0]


@pytest.mark.slow
def test_a_c_controller_of_four_inputs_agrees_with_the_pid(run, c_controller):
    pid, swapped = run(), run({"rolac_controller": c_controller})
    expected = before_the_step(pid)
    np.testing.assert_allclose(before_the_step(swapped), expected, rtol=0.0, atol=1e-9 * np.abs(expected).max())
    assert swapped.summary.recovery == "recovered"
    assert swapped.summary.as_dict()["notices"] == [
        f"rolac_controller: {c_controller.name} has no rolac_enable; such settings are ignored"
    ]


@pytest.mark.slow
def test_linear_bearings_are_the_linear_law_with_held_forces(run, python_fmus):
    held = run(gradient=False)
    swapped = run({"amb_actuator": python_fmus / "LinearActuator.fmu"})
    expected = before_the_step(held)
    np.testing.assert_allclose(before_the_step(swapped), expected, rtol=0.0, atol=1e-9 * np.abs(expected).max())
    assert swapped.summary.recovery == "recovered"


@pytest.mark.slow
def test_full_and_reduced_rotor_differ_by_their_frequency_response(run, python_fmus):
    """The ratio of the orbits is that of the unbalance responses on bearings with K_b and C_b."""
    quiet = {"event": [], "end_cycle": 5}
    swapped = run({"rotor_contact": python_fmus / "FullRotor.fmu"}, **quiet)
    reduced = run(gradient=False, **quiet)
    rotor = load_rotor().on_equal_bearings(1e6, 5000.0)
    responses = [
        np.abs(unbalance_response(model, {1: 0.5e-3}, np.array([260.0]), rotor.bearing_nodes)[0, :, 0])
        for model in (supported_rotor(rotor), supported_plant(rotor))
    ]
    orbits = [
        [result.summary.as_dict()["settled_amplitude_mm"]["end"][bearing] for bearing in ("mb1", "mb2")]
        for result in (swapped, reduced)
    ]
    expected = responses[0] / responses[1]
    np.testing.assert_allclose(np.divide(*orbits), expected, rtol=2e-4)
    assert abs(expected[0] - 1.0) > 2e-3, "a difference that shows"
    assert swapped.summary.as_dict()["site_share"] == {}, "it has nothing to touch"
    assert swapped.dataset["rotor_contact.mb1.x"].attrs["units"] == "m", (
        "a variable without a unit has that of the variable it replaces"
    )
    dropped, unfed = swapped.summary.as_dict()["notices"]
    assert "has no solver.tolerance, contact.impact_law" in dropped
    assert "nothing feeds d2.u, d3.u, d4.u" in unfed
