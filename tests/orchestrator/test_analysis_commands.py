"""Commands that analyse a rotor: what they print and write, and what they say about bad input."""

from __future__ import annotations

import inspect
import json
import sys
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import ClassVar

import click
import numpy as np
import pytest
from matplotlib.figure import Figure
from pump import SHAFT, UNSTABLE

from amb_analysis.studies.commands import analysis
from amb_analysis.studies.result import DrawnResult
from amb_cosim import studies
from amb_cosim.commands.options import ROTOR, SETTINGS
from amb_cosim.presentation.text_tables import TextBlock
from rotor_analysis.modes import damped_frequencies
from rotor_analysis.packaged_rotors import rotor_path
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
    assert f"{expected[0]:.3f}" in text
    assert "unstable" not in text


def test_modes_of_any_rotor_at_speeds_with_units(runner, tmp_path):
    arguments = ("--rotor", "pump.toml", "--speeds", "0, 50 Hz", "--count", "3", "--mass", "consistent")
    text = runner("study", "modes", *arguments, "-o", "out").stdout
    data = json.loads((tmp_path / "out" / "modes.json").read_text())
    assert (data["rotor"], data["mass"], list(data["speeds"])) == ("pump", "consistent", ["0", "314.159"])
    assert min(data["speeds"]["0"]["damping_ratios"]) < 0.0
    assert len(data["speeds"]["0"]["whirl"]) == 3
    assert "forward, unstable" in text


def test_motion_without_oscillation_is_reported(runner, tmp_path):
    text = runner("study", "modes", "--rotor", "free.toml", "-o", "out").stdout
    data = json.loads((tmp_path / "out" / "modes.json").read_text())
    assert data["speeds"]["0"]["real_eigenvalues_per_s"] == [0.0] * 8
    assert "aperiodic motion" in text


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
    """Node 3 of four lies at 0.6 m, whatever nodes `z` and [mesh] add."""
    (tmp_path / "pump.toml").write_text(f"{UNSTABLE}{added}")
    response = studies.unbalance_response(str(tmp_path / "pump.toml"), unbalance="1 g.m", node=3, up_to="100 rad/s")
    assert (response.z, list(response.unbalances)) == (0.6, ["z = 0.6 m"])
    with raises_naming(ValueError, "node", "5", "1 to 4"):
        studies.unbalance_response(str(tmp_path / "pump.toml"), node=5)


def test_response_data_grow_with_the_unbalance(runner, tmp_path):
    peaks = []
    for unbalance in ("1 g.m", "2 g.m"):
        arguments = ("--unbalance", unbalance, "--node", "10", "-o", "out")
        assert runner("study", "unbalance_response", *arguments).exit_code == 0
        data = json.loads((tmp_path / "out" / "unbalance_response.json").read_text())
        assert data["z_m"] == pytest.approx(load_rotor().shaft.nodes[9])
        assert set(data["places"]) == {"mb1", "mb2", "eb1", "eb2"}
        peaks.append(max(data["places"]["mb2"]["amplitude_m"]))
    assert peaks[1] == pytest.approx(2.0 * peaks[0])


@dataclass(frozen=True)
class Level(DrawnResult):
    """A result of the smallest kind."""

    name: ClassVar[str] = "mine"
    level: float

    def text(self) -> list[TextBlock]:
        return [f"level {self.level:g}"]


@pytest.fixture
def added(monkeypatch):
    """`added(compute, *options, **more)`: adds the study `mine` to the command line."""

    def add(compute, *options, **more) -> None:
        beside = Level.__module__.rpartition(".")[0]
        monkeypatch.setitem(sys.modules, f"{beside}.figures.mine", SimpleNamespace(draw=lambda _: Figure()))
        monkeypatch.setattr(studies, "mine", compute, raising=False)
        monkeypatch.setitem(studies.STUDIES, "mine", studies.Study("mine", "A study."))
        monkeypatch.setattr(analysis.study, "commands", dict(analysis.study.commands))
        analysis.add_study("mine", *options, **more)

    return add


@pytest.mark.parametrize("more", [{}, {"shows_progress": True}])
def test_added_study_runs_with_its_options(runner, added, tmp_path, more):
    seen = {}

    def mine(rotor, level, set):
        seen.update(rotor=rotor, level=level, set=set)
        return Level(level)

    added(mine, ROTOR, SETTINGS, click.option("--level", type=float, default=1.0), **more)
    result = runner("study", "mine", "--rotor", "pump.toml", "--level", "3", "--set", "a.b=2 mm")
    assert result.exit_code == 0, result.output
    assert seen == {"rotor": "pump.toml", "level": 3.0, "set": {"a.b": "2 mm"}}
    assert json.loads((tmp_path / "results" / "study_mine" / "mine.json").read_text()) == {"level": 3.0}
    assert "level 3" in result.stdout
    assert result.stderr == ""


@pytest.mark.parametrize("name", analysis.study.list_commands(click.Context(analysis.study)))
def test_defaults_are_those_of_the_python_function(name):
    values = analysis.study.commands[name].make_context(name, []).params
    del values["output"]
    options = {key: value or None for key, value in values.items()}
    parameters = inspect.signature(getattr(studies, name)).parameters.values()
    assert options == {p.name: p.default or None for p in parameters if p.name != "progress"}


def test_result_of_a_study_shows_itself():
    diagram = studies.campbell(up_to="50 Hz", count=4)
    assert repr(diagram).startswith(
        "CampbellDiagram(rotor='bath_rig_thesis', mass='diagonal', speeds=<array of shape (161,)>"
    )
    assert "Critical speeds" in str(diagram)
    assert studies.figure(diagram)._repr_png_().startswith(b"\x89PNG")
    np.testing.assert_allclose(diagram.speeds[-1], 100.0 * np.pi)


def test_studies_are_listed():
    assert set(studies.STUDIES) <= set(dir(studies))
    for name in studies.STUDIES:
        assert callable(getattr(studies, name))
    with raises_naming(AttributeError, "'cambell'", "layout"):
        studies.cambell  # noqa: B018


@pytest.mark.parametrize("rotor", [None, "pump.toml", Path("pump.toml")])
def test_studies_take_rotors_and_their_files(runner, rotor):
    expected = "bath_rig_thesis" if rotor is None else "pump"
    assert studies.modes(rotor, speeds=[90.0, "10 Hz"]).description.name == expected
    assert studies.modes(load_rotor(Path(rotor or rotor_path()))).description.name == expected
