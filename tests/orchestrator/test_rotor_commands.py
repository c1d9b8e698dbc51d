"""`amb-cosim rotor`: import from ROSS, and the content of rotor files."""

import inspect
import json
import math
import sys
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import pytest
from matplotlib.image import imread

from amb_analysis.studies.commands.analysis import study
from amb_analysis.studies.figures.layout import draw as draw_layout
from amb_analysis.studies.result import WarnedResult
from amb_cosim import studies
from rotor_analysis.implausible_sizes import implausible_sizes
from rotor_analysis.packaged_rotors import rotor_path
from rotor_analysis.parts import Bearing, Body, Disc, Sensor
from rotor_analysis.rotor import ReductionOptions, Rotor
from rotor_analysis.rotor_file import load_rotor
from rotor_analysis.shaft import Shaft
from tests.support.messages import assert_names

ROSS = Path(__file__).parents[1] / "reference" / "ross"


@pytest.fixture
def rotor(runner):
    return lambda *arguments: runner("rotor", *map(str, arguments))


def test_imported_rotor_is_a_rotor_file(rotor, tmp_path):
    done = rotor("import", ROSS / "compressor.toml")
    assert done.exit_code == 0, done.output
    assert done.stdout == "compressor_rotor.toml\n"
    assert done.stderr.startswith("note: Coefficients over speed follow ROSS's spline")
    text = (tmp_path / "compressor_rotor.toml").read_text(encoding="utf-8")
    assert text.startswith(
        "# Imported from compressor.toml, a file saved by ROSS. SI units.\n# Coefficients over speed"
    )
    result = load_rotor(tmp_path / "compressor_rotor.toml")
    assert (len(result.bodies), len(result.bearings), len(result.seals), len(result.materials)) == (7, 2, 12, 3)


def test_whirl_of_a_plant_at_the_speed_of_its_file_is_shown(rotor):
    shown, data = (rotor("show", "turbo_expander", *more).output for more in ((), ("--json",)))
    whirl = json.loads(data)["whirl"]
    assert whirl["speed_rad_s"] == load_rotor("turbo_expander").reduction.speed
    assert_names(shown, "at 41998 rpm", f"{whirl['backward_rad_s'][0] / (2.0 * math.pi):.1f}")
    assert len(whirl["forward_error_percent"]) == len(whirl["backward_error_percent"]) + 1
    at_rest = rotor("show", "bath_rig")
    assert "forward" not in at_rest.output


def test_imported_rotor_can_be_printed_and_drawn(rotor, tmp_path):
    assert rotor("import", ROSS / "cone.toml", "-o", "cone.toml").exit_code == 0
    done = rotor("show", "cone.toml", "-o", "cone.png")
    assert done.exit_code == 0, done.output
    assert "impeller" in done.output
    picture = imread(tmp_path / "cone.png")
    assert picture.shape[0] > 400
    assert picture[..., :3].std() > 0.05


@pytest.mark.parametrize(("name", "head"), [("c.png", b"\x89PNG"), ("c.SVG", b"<?xml"), ("c.pdf", b"%PDF")])
def test_a_picture_has_the_format_of_its_name(rotor, tmp_path, name, head):
    """It was PNG under any name."""
    assert rotor("show", "tum_rig", "-o", name).exit_code == 0
    assert (tmp_path / name).read_bytes().startswith(head)


@pytest.mark.parametrize("command", [("rotor", "show", "tum_rig"), ("controller", "show", "none.toml")])
def test_a_picture_of_another_format_is_refused(runner, tmp_path, command):
    done = runner(*command, "-o", "c.jpg")
    assert done.exit_code == 2
    assert_names(done.stderr, "c.jpg", ".png, .pdf, .svg")
    assert not list(tmp_path.iterdir())


def test_rig_is_printed_with_mass_modes_and_error_of_its_plant(rotor):
    done = rotor("show", rotor_path())
    assert "bath_rig_thesis: 96.03 kg, 1.948 m, 13 nodes" in done.output
    assert "plant by msdc: 12 coordinates, planes at nodes 1, 3, 4, 10, 11, 13;" in done.output
    assert "0.1 % up to 24.4 Hz" in " ".join(done.output.split())
    assert "damping: none" in done.output
    data = json.loads(rotor("show", rotor_path(), "--json").output, parse_constant=pytest.fail)
    assert data["planes"] == [1, 3, 4, 10, 11, 13]
    assert data["mass_kg"] == pytest.approx(load_rotor().mass)
    assert [abs(error) < 0.12 for error in data["error_percent"]] == [True] * 4 + [False] * 2
    parts = {part["name"]: part for part in data["parts"]}
    assert (parts["rb1"]["kind"], parts["rb1"]["node"], parts["rb1"]["z_m"]) == ("contact site", 4, 0.624)


def test_printed_nodes_are_those_of_the_file(rotor, tmp_path):
    """The rig on a finer mesh, with a sensor plane between its nodes: numbers as in the file, none for the plane."""
    text = rotor_path().read_text(encoding="utf-8") + '[mesh]\n[[sensors]]\nname = "eye"\nz = 0.02\n'
    (tmp_path / "fine.toml").write_text(text, encoding="utf-8")
    done = rotor("show", "fine.toml", "--json")
    parts = {part["name"]: (part["node"], part["z_m"]) for part in json.loads(done.output)["parts"]}
    assert parts["rb1"] == (4, 0.624)
    assert parts["eye"] == (None, 0.02)
    assert "planes at nodes 1, 3, 4, 10, 11, 13;" in rotor("show", "fine.toml").output


def test_errors_of_the_plant_that_round_to_zero_have_no_minus():
    result = studies.layout("turbo_expander")
    whirl = replace(result.whirl, forward_error=-1e-6 * abs(result.whirl.forward_error))
    text = str(replace(result, error=-1e-6 * abs(result.error), whirl=whirl))
    assert "-0.0000" not in text
    assert text.count("+0.0000") >= len(result.error)


@pytest.mark.parametrize(
    ("stiffness", "words"),
    [
        (1e6, "1000000 N/m, 0 N s/m along x and y"),
        (((1e6, 0.0), (0.0, 2e6)), "1000000 N/m, 0 N s/m along x, 2000000 N/m, 0 N s/m along y"),
    ],
)
def test_coefficients_of_a_bearing_name_both_of_its_axes(stiffness, words):
    shaft = Shaft((0.0, 0.5, 1.0), (0.05,), youngs_modulus=2e11, density=7850.0, poissons_ratio=0.3)
    bearings = (Bearing("left", 1, stiffness), Bearing("right", 3, 1e6))
    assert studies.layout(Rotor("shaft", shaft, bearings=bearings)).parts[0].what == words


def test_seals_are_listed_with_their_mass_and_drawn():
    shaft = Shaft((0.0, 0.5, 1.0), (0.05,), youngs_modulus=2e11, density=7850.0, poissons_ratio=0.3)
    bearings, film = (Bearing("left", 1, 1e6), Bearing("right", 3, 1e6)), Bearing("film", 2, 1e5, 3e2, mass=4.0)
    result = studies.layout(Rotor("shaft", shaft, bearings=bearings, seals=(film,)))
    assert result.parts[-1].what == "100000 N/m, 300 N s/m, 4 kg along x and y"
    lanes = draw_layout(result).axes[1]
    assert [label.get_text() for label in lanes.get_yticklabels()] == ["planes", "seals", "bearings"]
    assert "film" in [text.get_text() for text in lanes.texts]


def test_inertias_are_those_of_the_parts():
    """Discs and cores summed by hand, and the shaft as a slender rod with a small radius."""
    rig, result = load_rotor(), studies.layout()
    shaft = rig.mass - sum(body.mass for body in rig.bodies)
    z = rig.shaft.nodes
    moment = shaft * z[-1] / 2.0 + sum(body.mass * z[body.node - 1] for body in rig.bodies)
    assert result.centre == pytest.approx(moment / rig.mass, rel=1e-9)
    polar = shaft * 0.025**2 / 2.0 + sum(body.polar_inertia for body in rig.bodies)
    assert result.polar_inertia == pytest.approx(polar, rel=1e-9)
    local = shaft * (z[-1] ** 2 / 12.0 + 0.025**2 / 4.0) + sum(body.diametral_inertia for body in rig.bodies)
    apart = sum(body.mass * (z[body.node - 1] - result.centre) ** 2 for body in rig.bodies)
    apart += shaft * (z[-1] / 2.0 - result.centre) ** 2
    assert result.diametral_inertia == pytest.approx(local + apart, rel=1e-6)


@pytest.mark.parametrize("density", [0.0, 1e-30])
@pytest.mark.parametrize("node", [1, 4, 7])
def test_a_point_mass_on_a_massless_shaft_is_printed(density, node):
    """It does not resist tilting, and neither does the free shaft: there is no elastic mode."""
    shaft = Shaft(tuple(0.1 * k for k in range(7)), 0.02, 2e11, density, 0.3)
    bearings = (Bearing("a", 1, stiffness=5e5), Bearing("b", 7, stiffness=5e5))
    result = studies.layout(Rotor("jeffcott", shaft, (Body("m", node, 10.0, 0.0, 0.0),), bearings))
    assert result.mass == pytest.approx(10.0)
    assert result.fastest == 0.0
    if node != 4:  # over a bearing
        assert result.frequencies[0] == pytest.approx(math.sqrt(5e5 / 10.0), rel=1e-6)


@pytest.mark.parametrize(("density", "masters"), [(0.0, ()), (7850.0, (1, 4))], ids=["massless", "two_planes"])
def test_a_plant_without_elastic_modes_is_printed(density, masters):
    """A mass on a massless shaft, and a shaft between two planes: neither has an elastic mode."""
    shaft = Shaft((0.0, 0.3, 0.6, 0.9), 0.05, 2e11, density, 0.3, theory="rayleigh")
    bearings = (Bearing("a", 1, stiffness=1e7), Bearing("b", 4, stiffness=1e7))
    rotor = Rotor("rigid", shaft, (Body("m", 2, 8.0, 0.0, 0.0),), bearings, reduction=ReductionOptions(masters=masters))
    result = studies.layout(rotor)
    assert result.fastest == 0.0
    assert (result.receptance is None) == (density == 0.0)
    assert_names(result, "no elastic mode")


IN_MM = """name = "fan"
[shaft]
material = "steel"
sections = [{length = 300.0, diameter = 50.0}, {length = 300.0, diameter = 50.0}]
[materials.steel]
density = 7850.0
youngs_modulus = 2.1e11
poissons_ratio = 0.3
"""
WITH_ROTOR = [name for name, command in study.commands.items() if "rotor" in {p.name for p in command.params}]


@pytest.mark.parametrize("name", WITH_ROTOR)
def test_studies_warn_of_a_rotor_in_mm_once_and_before_they_compute(runner, tmp_path, monkeypatch, name):
    (tmp_path / "fan.toml").write_text(IN_MM)
    sentences = implausible_sizes(load_rotor(tmp_path / "fan.toml"))
    result = SimpleNamespace(text=lambda: [f"warning: {sentence}" for sentence in sentences])  # as of a prepared run
    monkeypatch.setattr(studies, name, lambda **_: result, raising=False)
    monkeypatch.setattr(studies, "save", lambda *_: None)
    done = runner("study", name, "--rotor", "fan.toml")
    assert done.exit_code == 0, done.output
    assert len(sentences) == 2
    assert [done.stderr.count(sentence) for sentence in sentences] == [1, 1]
    assert "warning" not in done.stdout


ROTOR_ALONE = {
    "campbell": {"up_to": 1.0, "count": 1},
    "modes": {"count": 1},
    "layout": {},
    "receptance": {"up_to": 10.0},
    "response": {"inputs": ["fan.f_x"], "outputs": ["fan.x"], "up_to": "2 Hz"},
    "unbalance_response": {"up_to": 1.0, "unbalance": 1.0},
}


@pytest.mark.parametrize("name", ROTOR_ALONE)
def test_studies_of_a_rotor_in_mm_have_its_warnings_without_a_command(name):
    """A shaft of 600 m and 50 m diameter on two bearings."""
    shaft = Shaft((0.0, 300.0, 600.0), (50.0,), 2.1e11, 7850.0, 0.3)
    bearings = tuple(Bearing(label, node, stiffness=1e13, damping=1e12) for label, node in (("a", 1), ("b", 3)))
    sensors = tuple(Sensor(label, node) for label, node in (("s1", 1), ("s2", 3)))
    rotor = Rotor("fan", shaft, (Disc("fan", 2, 1e6, 1e9, 1e9),), bearings, sensors=sensors)
    result = getattr(studies, name)(rotor=rotor, **ROTOR_ALONE[name])
    assert_names(result.warnings[0], "rotor fan", "length of the shaft = 600 m", "mm")
    assert result.as_dict()["warnings"] == list(result.warnings)
    assert all(f"warning: {sentence}" in result.text() for sentence in result.warnings)


def test_every_study_with_a_rotor_can_warn():
    functions = {name: getattr(studies, name) for name in studies.STUDIES}
    with_rotor = {name: f for name, f in functions.items() if "rotor" in inspect.signature(f).parameters}
    results = {name: vars(sys.modules[f.__module__])[f.__annotations__["return"]] for name, f in with_rotor.items()}
    assert {"campbell", "fit", "h_matrix"} < results.keys()
    assert [name for name, result in results.items() if not issubclass(result, WarnedResult)] == []


@pytest.mark.parametrize("command", [("build",), ("new", "fan", "--speed", "3000 rpm")])
def test_rotor_in_mm_explains_why_its_machine_is_refused(runner, tmp_path, command):
    (tmp_path / "fan.toml").write_text(IN_MM)
    done = runner(*command, "--rotor", "fan.toml")
    assert done.exit_code == 2
    assert_names(done.stderr, "warning: rotor fan", "length of the shaft = 600 m", "mm")


def test_faces_and_the_thrust_disc_are_listed_and_point_where_they_push():
    result = studies.layout("turbo_pump")
    parts = {part.name: part for part in result.parts}
    assert (parts["thrust"].kind, parts["thrust"].z) == ("thrust disc", 0.054)
    assert_names(parts["seat"].what, "-z", "250 um", "catch_lower")
    above, lanes = draw_layout(result).axes
    assert {"thrust discs", "faces"} <= {label.get_text() for label in lanes.get_yticklabels()}
    at_radius = {line.get_marker(): line.get_xdata()[0] for line in above.lines if abs(line.get_ydata()[0]) == 0.0125}
    assert at_radius == {">": 0.032, "<": 0.01}
