"""The command `amb-cosim sweep`, ready sweeps, maps, and sensitivities."""

import sys

import numpy as np
import pytest

import amb_cosim
from amb_cosim.scenario.prepare_run import prepare_run
from amb_files.packs import files_of
from amb_sweeps import sensitivity as indices
from amb_sweeps.check import check_points
from amb_sweeps.commands import _function
from amb_sweeps.maps import draw_map
from amb_sweeps.ready import read_sweep
from amb_sweeps.sampling import sample_plan
from amb_sweeps.store import open_sweep
from amb_sweeps.summary import FORCES, summarise_sweep
from amb_sweeps.worker import Task
from tests.amb_sweeps.conftest import UNTIL, filled, refined
from tests.support.messages import assert_names, raises_naming

METRIC = "def turns(result):\n    return {'turns': float(result.dataset['cycle'].values[-1])}\n"


@pytest.fixture
def command(runner, small, tmp_path, cluster):
    scenario = str(small.save(tmp_path / "small.toml"))
    return lambda *options: runner(
        "sweep", scenario, "--until", str(UNTIL), "--scheduler", cluster, "-o", str(tmp_path / "out"), *options
    )


def test_the_command_maps_a_scenario_and_resumes(command, tmp_path):
    (tmp_path / "own.py").write_text(METRIC)
    options = ["--vary", "Omega=200:220 rad/s:2", "--vary", "rotor_contact.d1.u=5 g.m,60 g.m"]
    options += ["--metric", f"{tmp_path / 'own.py'}:turns"]
    for _ in range(2):
        result = command(*options)
        assert result.exit_code == 0, result.output
        assert_names(result.output, "4 runs", "2 undecided", "2 completed", "largest force between impacts")
    assert (tmp_path / "out" / "outcome.png").read_bytes().startswith(b"\x89PNG")
    turns = open_sweep(tmp_path / "out")["turns"]
    np.testing.assert_allclose(turns.sel(Omega=220.0), UNTIL * 220.0 / (2.0 * np.pi))
    different = command(*options[:4], "--no-plots")
    assert different.exit_code == 2
    assert "metrics" in different.output


def test_a_metric_that_can_evaluate_no_run_is_refused_and_its_folder_stays_free(command, tmp_path):
    (tmp_path / "own.py").write_text(METRIC + "def wrong(result):\n    return result.dataset.cycles\n")
    options = ["--vary", "rotor_contact.d1.u=5 g.m,60 g.m", "--no-plots", "--metric"]
    refused = command(*options, f"{tmp_path / 'own.py'}:wrong")
    assert refused.exit_code == 2
    assert_names(refused.output, "metric wrong", "AttributeError", "cycles")
    corrected = command(*options, f"{tmp_path / 'own.py'}:turns")
    assert corrected.exit_code == 0, corrected.output


def test_a_metric_without_a_value_at_one_point_is_named_and_changes_no_outcome(command, tmp_path):
    (tmp_path / "own.py").write_text(
        "def first_force(result):\n"
        "    force = result.dataset['rotor_contact.rb1.f_n'].values\n"
        "    return {'first_force': force[force > 0.0][0]}\n"
    )
    options = ["--vary", "rotor_contact.d1.u=5 g.m,60 g.m", "--no-plots", "--metric"]
    result = command(*options, f"{tmp_path / 'own.py'}:first_force")
    assert result.exit_code == 0, result.output
    assert_names(result.output, "1 undecided", "1 completed", "metric first_force", "IndexError", "1 of 2 runs")
    data = open_sweep(tmp_path / "out")
    assert data["outcome"].values.tolist() == ["completed", "undecided"]
    assert [bool(error) for error in data["metric_error"].values] == [True, False]
    assert np.isnan(data["first_force"].values).tolist() == [True, False]


@pytest.mark.parametrize(("name", "file"), files_of("sweeps").items())
def test_ready_sweeps_fit_their_scenarios(name, file):
    study = read_sweep(name, file)
    design = sample_plan(study.options["vary"], study.options.get("sample", "grid"))
    guids, units, _ = check_points(Task(amb_cosim.Scenario.load(study.scenario)), design)
    assert len(guids) == 3
    assert {"rad/s", "kg.m"} & set(units.values())
    assert prepare_run(amb_cosim.Scenario.load(study.scenario)).last > 0


def test_refinement_converges_to_a_circle_with_few_points(tmp_path):
    def inside(settings):
        return settings["a.x"] ** 2 + settings["a.y"] ** 2 < 0.5

    vary = {"a.x": np.linspace(0, 1, 5), "a.y": np.linspace(0, 1, 5)}
    tolerance = 0.001
    refinement, runs = refined(filled(tmp_path, vary, lambda s: {"recovered": float(inside(s))}), tolerance, inside)
    result = refinement.boundary()
    radius = np.hypot(result["a.x"], result["a.y"])
    assert result.sizes["point"] == 6
    assert np.all(np.abs(radius - np.sqrt(0.5)) < 2.0 * tolerance)
    assert 25 + runs < 0.1 / tolerance**2


def test_each_alternative_has_its_panel(tmp_path):
    vary = {"control": {"PID": {}, "ROLAC": {"a.z": 1}}, "a.x": [1.0, 2.0, 3.0], "a.y": [1.0, 2.0]}
    swept = filled(
        tmp_path, vary, lambda s: {"peak_contact_force": s["a.x"] * s["a.y"], "recovered": float(s["a.x"] > 1)}
    )
    figure = draw_map(swept, swept.dataset, "peak_contact_force")
    assert [ax.get_title() for ax in figure.axes[:2]] == ["PID", "ROLAC"]
    assert figure.axes[0].get_xlabel() == "a.x"
    figure.canvas.draw()


@pytest.mark.parametrize(
    ("vary", "sample"),
    [({"a.x": "1:2:3"}, "grid"), ({"a.x": "1:2", "a.y": "1:2"}, "lhs:8"), ({"a.kind": "one,two"}, "grid")],
)
def test_lines_samples_and_names_are_drawn(tmp_path, vary, sample):
    swept = filled(tmp_path, vary, lambda settings: {"recovered": 1.0, "orbit_largest": 2.0}, sample)
    for name in ("outcome", "orbit_largest"):
        draw_map(swept, swept.dataset, name).canvas.draw()


def test_sensitivities_match_those_of_an_analytic_function(tmp_path):
    """The variance of a x + b y over the unit square is a^2 / 12 + b^2 / 12."""

    def linear(settings):
        return {"averaged_contact_force": 3.0 * settings["a.x"] + 1.0 * settings["a.y"]}

    swept = filled(tmp_path, {"a.x": "0:1", "a.y": "0:1", "a.z": "0:1"}, linear, "saltelli:512")
    result = indices.sensitivity(swept.design, swept.dataset)
    np.testing.assert_allclose(result["S1"], [0.9, 0.1, 0.0], atol=0.02)
    np.testing.assert_allclose(result["ST"], [0.9, 0.1, 0.0], atol=0.02)
    lines = [line for line in summarise_sweep(swept.dataset, swept.design, tmp_path, "") if "index" in line]
    assert [line.partition(" over ")[0] for line in lines] == [FORCES["averaged_contact_force"]] * 3


def test_a_sensitivity_requires_a_sample_and_a_metric(tmp_path):
    grid = filled(tmp_path / "grid", {"a.x": "1:2:3"}, lambda _: {"m": 1.0})
    with raises_naming(ValueError, "saltelli:N", "grid"):
        indices.sensitivity(grid.design, grid.dataset)
    swept = filled(tmp_path / "sample", {"a.x": "1:2"}, lambda _: {"m": 1.0}, "saltelli:4")
    with raises_naming(ValueError, "'averaged_contact_force'"):
        indices.sensitivity(swept.design, swept.dataset)


@pytest.mark.parametrize(("text", "message"), [
    ("import sys\nsys.exit(0)", "SystemExit: 0"), ("1 / 0", "ZeroDivisionError"), ("", "has no attribute 'metric'"),
])  # fmt: skip
def test_a_metric_file_that_cannot_be_used_is_refused(tmp_path, text, message):
    (tmp_path / "mine.py").write_text(text)
    with pytest.raises(ValueError, match=message):
        _function(f"{tmp_path / 'mine.py'}:metric")


def test_a_metric_file_does_not_shadow_a_package(tmp_path):
    (tmp_path / "numpy.py").write_text("import numpy\ndef metric(result): return {'pi': numpy.pi}")
    assert _function(f"{tmp_path / 'numpy.py'}:metric")(None) == {"pi": np.pi}
    assert sys.modules["numpy"] is np
