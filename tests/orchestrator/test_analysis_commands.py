"""Commands that analyse a rotor: their output, files, and messages for bad input."""

import inspect
import json
from pathlib import Path

import click
import numpy as np
import pytest
from pump import SHAFT, UNSTABLE

from amb_analysis.studies.commands import analysis
from amb_cosim import studies
from rotor_analysis.modes import damped_frequencies
from rotor_analysis.rotor_file import load_rotor
from rotor_analysis.supported_rotor import supported_rotor
from tests.support.messages import raises_naming


@pytest.fixture(autouse=True)
def rotors(tmp_path: Path) -> None:
    (tmp_path / "pump.toml").write_text(UNSTABLE)
    (tmp_path / "free.toml").write_text(SHAFT)


def test_modes_of_the_rig_are_printed_as_json_and_as_text(runner, tmp_path):
    text = runner("study", "modes", "--speeds", "90 rad/s,120 rad/s,145 rad/s", "-o", "out").stdout
    data = json.loads((tmp_path / "out" / "modes.json").read_text())
    assert (data["rotor"], data["mass"]) == ("bath_rig_thesis", "diagonal")
    assert list(data["speeds"]) == ["90", "120", "145"]
    result = data["speeds"]["90"]
    expected = damped_frequencies(supported_rotor(load_rotor()).model, 90.0, 8)
    np.testing.assert_allclose(result["frequencies_rad_s"], expected, rtol=1e-9)
    assert len(result["damping_ratios"]) == len(result["whirl"]) == 8
    assert result["whirl"][:2] == ["backward", "forward"]
    assert f"{expected[0] / (2.0 * np.pi):.6g}" in text
    assert "unstable" not in text


def test_modes_of_any_rotor_at_speeds_with_units(runner, tmp_path):
    arguments = ("--rotor", "pump.toml", "--speeds", "0, 50 Hz", "--count", "3", "--mass", "consistent")
    text = runner("study", "modes", *arguments, "-o", "out").stdout
    data = json.loads((tmp_path / "out" / "modes.json").read_text())
    assert (data["rotor"], data["mass"], list(data["speeds"])) == ("pump", "consistent", ["0", "314.159"])
    assert min(data["speeds"]["0"]["damping_ratios"]) < 0.0
    assert len(data["speeds"]["0"]["whirl"]) == 3
    assert "forward, unstable" in text


@pytest.mark.slow
def test_critical_speeds_are_on_the_synchronous_line(runner, tmp_path):
    runner("study", "campbell", "--up-to", "50 Hz", "-o", "out", "--count", "6")
    data = json.loads((tmp_path / "out" / "campbell.json").read_text())
    assert data["speeds_rad_s"][-1] == pytest.approx(100.0 * np.pi)
    assert len(data["modes"]) == 6
    model = supported_rotor(load_rotor()).model
    for critical in data["critical_speeds"]:
        frequencies = damped_frequencies(model, critical["speed_rad_s"])
        assert np.min(np.abs(frequencies / critical["speed_rad_s"] - 1.0)) < 1e-5


@pytest.mark.parametrize("added", ["", "[mesh]\naccuracy = 1e-2\n", '[[sensors]]\nname = "eye"\nz = 0.1\n'])
def test_node_of_an_unbalance_counts_nodes_of_the_file(tmp_path, added):
    """Node 3 of four is at 0.6 m, regardless of the nodes that `z` and [mesh] add."""
    (tmp_path / "pump.toml").write_text(f"{UNSTABLE}{added}")
    response = studies.unbalance_response(str(tmp_path / "pump.toml"), unbalance="1 g.m", node=3, up_to="100 rad/s")
    assert (response.z, list(response.unbalances)) == (0.6, ["z = 0.6 m"])
    with raises_naming(ValueError, "node", "5", "1 to 4"):
        studies.unbalance_response(str(tmp_path / "pump.toml"), node=5)


@pytest.mark.parametrize("name", analysis.study.list_commands(click.Context(analysis.study)))
def test_defaults_are_those_of_the_python_function(name):
    values = analysis.study.commands[name].make_context(name, []).params
    del values["output"]
    options = {key: value or None for key, value in values.items()}
    parameters = inspect.signature(getattr(studies, name)).parameters.values()
    assert options == {p.name: p.default or None for p in parameters if p.name != "progress"}
