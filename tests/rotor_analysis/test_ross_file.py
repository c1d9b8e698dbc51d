"""Rotors saved by ROSS: imported ones have ROSS's frequencies, damping and response; errors name what is unsupported.

`python tools/ross/ross_rotors.py` renews the files and ROSS's numbers.
"""

import json
import subprocess
import sys
import tomllib

import numpy as np
import pytest
import tomli_w
from ross_numbers import REFERENCE, complex_numbers, nearest
from scipy.interpolate import UnivariateSpline

from amb_files.toml import validate
from rotor_analysis.response import unbalance_response
from rotor_analysis.ross_file import read_ross
from rotor_analysis.rotor import Rotor
from rotor_analysis.spectrum import eigenvalues
from rotor_analysis.supported_rotor import supported_rotor
from tests.support.messages import assert_names, raises_naming

ROTORS = [path.stem for path in sorted((REFERENCE / "ross").glob("*.toml"))]
EXACT = 1e-6
SAMPLED = {"compressor", "seals", "three_materials"}  # tables of speeds, whose coefficients err by 3e-5 between them


def tolerance(name):
    return 1e-4 if name in SAMPLED else EXACT


def case(name):
    """An imported rotor, and the results of ROSS for it."""
    rotor = validate(read_ross(REFERENCE / "ross" / f"{name}.toml")[0], Rotor, name)
    return rotor, json.loads((REFERENCE / "ross" / "results.json").read_text(encoding="utf-8"))[name]


@pytest.mark.parametrize("name", ROTORS)
def test_mass_natural_frequencies_and_damping_match_ross(name):
    rotor, expected = case(name)
    assert rotor.mass == pytest.approx(expected["mass"], rel=1e-9)
    model = supported_rotor(rotor).model
    for speed, pairs in expected["eigenvalues"].items():
        theirs = complex_numbers(pairs)
        ours = nearest(eigenvalues(model, float(speed)), theirs)
        np.testing.assert_allclose(np.abs(ours), np.abs(theirs), rtol=tolerance(name))
        np.testing.assert_allclose(-ours.real / np.abs(ours), -theirs.real / np.abs(theirs), atol=tolerance(name))


@pytest.mark.parametrize("name", ROTORS)
def test_unbalance_response_matches_ross(name):
    rotor, expected = case(name)
    unbalance = {}
    for node, u, phase in expected["unbalances"]:
        unbalance[node] = unbalance.get(node, 0.0) + u * np.exp(1j * phase)
    for speed, pairs in expected["x_y"].items():
        ours = unbalance_response(supported_rotor(rotor), unbalance, np.array([float(speed)]), tuple(expected["seen"]))
        theirs = complex_numbers(pairs)
        np.testing.assert_allclose(ours.ravel(), theirs, atol=tolerance(name) * np.min(np.abs(theirs)))


def test_imported_file_needs_no_ross():
    code = "import sys, pathlib; sys.modules['ross'] = None; from rotor_analysis.ross_file import read_ross"
    command = [sys.executable, "-c", f"{code}; print(read_ross(pathlib.Path('{REFERENCE}/ross/cone.toml'))[0]['name'])"]
    assert subprocess.run(command, capture_output=True, text=True, timeout=60, check=True).stdout == "cone\n"


def saved(name="two_discs"):
    return tomllib.loads((REFERENCE / "ross" / f"{name}.toml").read_text(encoding="utf-8"))


def read(tmp_path, data):
    path = tmp_path / "model.toml"
    path.write_text(tomli_w.dumps(data), encoding="utf-8")
    return read_ross(path)


def test_tags_become_unique_names(tmp_path):
    data = saved()
    bearing = data["BearingElement_Bearing 0"]
    data["BearingElement_x"] = bearing | {"tag": "Disk 0"}
    data["SealElement_y"] = bearing | {"tag": "2nd seal"}
    data["PointMass_z"] = {"tag": "Größe", "n": 3, "mx": 2.0, "my": 2.0, "mz": 2.0}
    content, *_ = read(tmp_path, data)
    assert [body["name"] for body in content["bodies"]] == ["disk_0", "disk_1", "gr_e"]
    assert [bearing["name"] for bearing in content["bearings"]] == ["bearing_0", "bearing_1", "disk_0_2"]
    assert [seal["name"] for seal in content["seals"]] == ["part_2nd_seal"]


def test_discs_are_planes_of_unbalance_and_point_masses_are_not(tmp_path):
    mass = {"tag": "ring", "n": 3, "mx": 2.0, "my": 2.0, "mz": 2.0}
    rotor = validate(read(tmp_path, saved() | {"PointMass_ring": mass})[0], Rotor, "model")
    assert rotor.disc_nodes == (3, 5)
    assert (rotor.bodies[2].node, rotor.bodies[2].mass, rotor.bodies[2].polar_inertia) == (4, 2.0, 0.0)


ELEMENT, BEARING, DISC = "ShaftElement_Shaft Element 2", "BearingElement_Bearing 1", "DiskElement_Disk 0"
CANNOT = {
    "axial force": (ELEMENT, {"axial_force": 10.0}, ("axial force", "Shaft Element 2")),
    "torque": (ELEMENT, {"torque": 10.0}, ("torque", "Shaft Element 2")),
    "no inertia": (ELEMENT, {"rotary_inertia": False}, ("rotary inertia", "Shaft Element 2")),
    "no gyroscopics": (ELEMENT, {"gyroscopic": False}, ("gyroscopic", "Shaft Element 2")),
    "some shear": (ELEMENT, {"shear_effects": False}, ("shear", "Shaft Element 2")),
    "some damping": (ELEMENT, {"beta": 1e-5}, ("damping", "Shaft Element 2")),
    "pieces": (ELEMENT, {"n": 7}, ("pieces", "no element at node 2")),
    "support": (BEARING, {"n_link": 8}, ("supported", "Bearing 1")),
    "speeds": (BEARING, {"frequency": [0.0, 1.0]}, ("coefficients", "Bearing 1")),
    "beside": (DISC, {"n": 12}, ("beyond the end of the shaft", "Disk 0")),
    "gear": ("GearElement_g", {"tag": "g"}, ("another kind", "GearElement_g")),
    "mass": ("PointMass_p", {"tag": "p", "n": 2, "mx": 1.0, "my": 2.0}, ("mass", "p")),
}


@pytest.mark.parametrize("what", CANNOT)
def test_elements_without_counterpart_are_refused_by_name(tmp_path, what):
    key, changes, expected = CANNOT[what]
    data = saved()
    data[key] = data.get(key, {}) | changes
    with raises_naming(ValueError, str(tmp_path / "model.toml"), *expected):
        read(tmp_path, data)


def test_all_unsupported_elements_are_named_at_once(tmp_path):
    data = saved()
    for key in data:
        if key.startswith("ShaftElement"):
            data[key] |= {"torque": 5.0}
    data[BEARING] |= {"n_link": 8}
    with raises_naming(ValueError, "torque") as caught:
        read(tmp_path, data)
    torque, link = str(caught.value).splitlines()
    assert_names(torque, "torque", "Shaft Element 0, Shaft Element 1, Shaft Element 2", "3 more")
    assert_names(link, "Bearing 1")


@pytest.mark.parametrize(
    ("key", "changes", "facts"),
    [
        (BEARING, {"kzz": [1e5]}, ("Bearing 1", "axial")),
        (BEARING, {"seal_leakage": 0.1}, ("Bearing 1", "seal_leakage")),
    ],
)
def test_omitted_content_is_reported(tmp_path, key, changes, facts):
    data = saved()
    data[key] |= changes
    (note,) = read(tmp_path, data)[1]
    assert_names(note, *facts)


OVER_SPEED = {"frequency": [0.0, 200.0, 400.0, 600.0], "cxx": [2e4, 2e4, 500.0, 500.0]}


def with_table(**table):
    """A bearing of ROSS 2 with a table over the spin speed, which that version calls frequency."""
    data = saved()
    zero = {f"{letter}{axes}": [0.0] * 4 for letter in "kcm" for axes in ("xx", "xy", "yx", "yy")}
    data[BEARING] |= zero | {"kxx": [1e6] * 4} | OVER_SPEED | table
    return data


def test_table_matches_the_spline_of_ross_between_its_speeds(tmp_path):
    """UnivariateSpline is what ROSS before version 3 calls; the table of a rotor file is monotone between its rows."""
    content, notes, _ = read(tmp_path, with_table())
    bearing = validate(content, Rotor, "model").bearings[1]
    spline = UnivariateSpline(OVER_SPEED["frequency"], OVER_SPEED["cxx"])
    for Omega in np.linspace(0.0, 600.0, 97):
        assert bearing.at(Omega)[1][0, 0] == pytest.approx(float(spline(Omega)), abs=3e-5 * 2e4)
        assert bearing.at(Omega)[0][0, 0] == pytest.approx(1e6, rel=1e-9)
    (overshoot,) = [note for note in notes if "cxx" in note]
    assert_names(overshoot, "Bearing 1", "cxx", "500 to 2e+04", "rad/s")


def test_table_of_speeds_that_fall_is_refused(tmp_path):
    with raises_naming(ValueError, "at_speed", "ascending"):
        read(tmp_path, with_table(frequency=[0.0, 400.0, 200.0, 600.0]))


def test_shear_coefficient_matches_hutchinson(tmp_path):
    data = saved()
    for key in data:
        if key.startswith("ShaftElement"):
            data[key] |= {"shear_method_calc": "hutchinson"}
    content, notes, _ = read(tmp_path, data)
    assert content["shaft"]["shear"] == "hutchinson"
    (note,) = notes
    assert_names(note, "Hutchinson's", "1 + nu")


@pytest.mark.parametrize(
    ("text", "facts"),
    [
        ("x = 1", ("table",)),
        ("[ShaftElement_1]\nn = 0", ("L",)),
        ("[ShaftElement_1", ("TOML",)),
        ("[PointMass_1]\nn = 0.5\ntag = 'p'\nmx = 1.0\nmy = 1.0", ("n", "0.5", "whole number")),
    ],
)
def test_file_that_is_not_from_ross_is_refused(tmp_path, text, facts):
    (tmp_path / "model.toml").write_text(text, encoding="utf-8")
    with raises_naming(ValueError, *facts):
        read_ross(tmp_path / "model.toml")
