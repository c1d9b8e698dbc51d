"""The packaged rotors have the eigenvalues that ROSS computes for their sources, or the modes that were measured."""

import json
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from analysis_cases import one_plane
from ross_numbers import REFERENCE, complex_numbers, difference

from amb_cosim.model_constants import plant_data
from amb_cosim.model_constants.plant_data import plant, plant_structure
from amb_cosim.results.places import limit_of
from amb_files.toml import validate
from rotor_analysis.assembly import assemble
from rotor_analysis.damping import free_modes
from rotor_analysis.free_rotor import free_rotor
from rotor_analysis.packaged_rotors import packaged_rotors, rotor_path
from rotor_analysis.parts import Bearing, Disc, Site
from rotor_analysis.receptance_error import ReceptanceError, receptance_error
from rotor_analysis.reduced_rotor import force_nodes, reduced_rotor
from rotor_analysis.ross_file import read_ross
from rotor_analysis.rotor import Rotor
from rotor_analysis.rotor_file import load_rotor
from rotor_analysis.shaft import Shaft
from rotor_analysis.spectrum import eigenvalues
from rotor_analysis.supported_rotor import supported_rotor
from tests.support.messages import raises_naming

ROSS = json.loads((REFERENCE / "ross" / "results.json").read_text(encoding="utf-8"))
PUBLISHED = json.loads((REFERENCE / "published_rotors.json").read_text(encoding="utf-8"))["ross"]["eigenvalues"]


def largest_difference(rotor, speed, pairs):
    """Of the eigenvalues nearest to those of ROSS, relative to their size."""
    return np.max(difference(eigenvalues(supported_rotor(rotor).model, speed), complex_numbers(pairs)))


@pytest.mark.parametrize(("speed", "pairs"), PUBLISHED["nelson_mcvaugh"]["rayleigh"].items())
def test_eigenvalues_of_nelson_and_mcvaughs_rotor_match_ross(speed, pairs):
    assert largest_difference(load_rotor("nelson_mcvaugh"), float(speed) * np.pi / 30.0, pairs) < 5e-7


@pytest.mark.parametrize(("speed", "pairs"), ROSS["compressor"]["eigenvalues"].items())
def test_eigenvalues_of_the_compressor_on_oil_films_match_ross(speed, pairs):
    """Timbo and Ritto's example with the oil films and gas seals that the packaged rotor leaves out."""
    source = validate(read_ross(REFERENCE / "ross" / "compressor.toml")[0], Rotor, "compressor")
    rotor = replace(
        load_rotor("compressor"),
        bearings=source.bearings,
        seals=source.seals,
        sites=(),
        sensors=(),
        reduction=source.reduction,
        damping=source.damping,
    )
    assert largest_difference(rotor, float(speed), pairs) < 1e-4  # between the speeds of a table


@pytest.mark.parametrize("name", ["nelson_mcvaugh", "compressor", "turbo_expander", "turbo_pump", "bath_rig"])
def test_modes_of_the_plant_in_its_band_are_within_a_tenth_of_a_percent(name):
    rotor = load_rotor(name)
    models = (assemble(rotor), reduced_rotor(rotor).model)
    exact, result = (free_modes(model.M[::2, ::2], model.K[::2, ::2])[0] for model in models)
    inside = exact[: len(result)] < 2.0 * np.pi * rotor.reduction.band
    np.testing.assert_allclose(result[inside], exact[: len(result)][inside], rtol=1e-3)
    assert inside.any()


@pytest.mark.parametrize("name", ["nelson_mcvaugh", "compressor", "turbo_expander", "turbo_pump", "bath_rig"])
def test_receptance_of_a_packaged_plant_is_accurate_in_its_band(name):
    rotor = load_rotor(name)
    error = receptance_error(rotor)
    assert error.accuracy == 1e-3
    assert error.limit > 2.0 * np.pi * rotor.reduction.band


def test_error_of_a_spinning_plant_is_that_with_gyroscopic_moments():
    """Forward and backward circles are H_xx - i H_xy and H_xx + i H_xy of both planes together."""
    rotor = load_rotor("turbo_expander")
    error, full, plant = receptance_error(rotor), assemble(rotor), reduced_rotor(rotor)
    rows, free = full.rows(force_nodes(rotor)), free_rotor(full)
    for omega, at_rest, spinning in zip(error.frequencies, error.error, error.spinning, strict=True):
        stiffness = [m.K - omega**2 * m.M + 1j * omega**2 * m.G for m in (full, plant.model)]
        exact = np.linalg.inv(stiffness[0])[np.ix_(rows, rows)]
        d = plant.right[rows] @ np.linalg.solve(stiffness[1], plant.left[:, rows]) - exact
        size = np.sqrt(free.sizes(free.rows(force_nodes(rotor)), omega))
        circles = np.abs([d[::2, ::2] - 1j * d[::2, 1::2], d[::2, ::2] + 1j * d[::2, 1::2]]) / np.outer(size, size)
        assert spinning == pytest.approx(np.max(circles), rel=1e-3, abs=1e-8)
        assert spinning > 10.0 * at_rest or at_rest > 0.1


def test_magnetic_bearings_damp_the_bending_mode_of_the_compressor():
    rotor = load_rotor("compressor")
    held = {bearing.name: (bearing.stiffness[0][0], bearing.damping[0][0]) for bearing in rotor.bearings}
    assert set(held) == {"mb1", "mb2"}
    for stiffness, damping in held.values():
        assert damping == pytest.approx(np.sqrt(rotor.mass / 2.0 * stiffness), rel=0.01)


def test_a_rotor_is_found_by_name_and_by_path(tmp_path):
    names = {"bath_rig", "bath_rig_thesis", "compressor", "nelson_mcvaugh", "tum_rig", "turbo_expander", "turbo_pump"}
    assert set(packaged_rotors()) == names
    copy = tmp_path / "mine.toml"
    copy.write_text(rotor_path("compressor").read_text(encoding="utf-8"), encoding="utf-8")
    assert load_rotor(copy) == load_rotor("compressor") == load_rotor(Path("compressor"))
    assert load_rotor("bath_rig_thesis") == load_rotor()


def test_an_unknown_name_is_refused_with_close_matches():
    with raises_naming(ValueError, "compresor", "compressor"):
        load_rotor("compresor")
    with raises_naming(ValueError, "'q'", "bath_rig, bath_rig_thesis, compressor"):
        load_rotor("q")


def test_sites_refer_to_the_sensor_plane_at_their_position():
    sites = plant(load_rotor("compressor"))[0].layout["sites"]
    assert {site["name"]: site["sensor"] for site in sites} == {"td1": "at_mb1", "td2": "at_mb2", "seal": "at_seal"}


def test_recommended_rig_differs_in_mass_mesh_damping_and_modes():
    texts = (rotor_path(name).read_text(encoding="utf-8") for name in ("bath_rig", "bath_rig_thesis"))
    ours, thesis = (tomllib.loads(text) for text in texts)
    assert ours["shaft"].pop("mass_matrix") == "consistent"
    for key in ("name", "mesh", "damping", "reduction"):
        ours.pop(key)
        thesis.pop(key, None)
    assert ours == thesis


def test_recommended_rig_has_one_percent_of_damping_at_2000_rad_s():
    rotor = load_rotor("bath_rig")
    model = assemble(rotor)
    M, R, K = map(one_plane, (model.M, model.R, model.K))
    frequencies, shapes = free_modes(M, K)
    ratios = np.einsum("im,ij,jm->m", shapes, R, shapes) / (2.0 * frequencies)
    assert np.interp(2000.0, frequencies, ratios) == pytest.approx(0.01, rel=1e-3)
    assert ratios[0] == pytest.approx(0.001, rel=0.2)
    assert not model.C.any()


def test_recommended_rig_is_accurate_far_beyond_the_thesis_planes():
    structures = {name: plant_structure(load_rotor(name))[0] for name in ("bath_rig", "bath_rig_thesis")}
    assert structures["bath_rig_thesis"].valid_to == pytest.approx(418.4, rel=1e-3)
    assert structures["bath_rig"].valid_to > 2.0 * np.pi * 2000.0


MEASURED = np.loadtxt(Path(__file__).parents[1] / "reference/tum_rig_modes.csv", delimiter=",", skiprows=1)


def test_untuned_free_modes_are_within_one_and_a_half_percent_of_measured():
    model = assemble(load_rotor("tum_rig"))
    frequencies, _ = free_modes(model.M[::2, ::2], model.K[::2, ::2])
    percent = 100.0 * (frequencies[:4] / (2.0 * np.pi) / MEASURED[:, 0] - 1.0)
    assert np.abs(percent).max() < 1.5
    np.testing.assert_allclose(percent, [-1.2, -0.5, 0.5, -1.1], atol=0.1)


def test_rig_has_measured_damping_and_the_mass_of_its_parts():
    rotor = load_rotor("tum_rig")
    np.testing.assert_allclose(rotor.damping.modal, MEASURED[:, 1])
    shaft = 7860.0 * np.pi / 4.0 * (0.6 * 0.008**2 + 0.102 * 0.0096**2)
    assert abs(rotor.mass - (2 * 0.85074 + 1.276499 + shaft)) < 1e-9


def stiff_rotor():
    """A shaft of 12 cm whose first mode, at 3.7 kHz, the reduction to 2 kHz has 1.6 % too fast."""
    shaft = Shaft((0.0, 0.015, 0.022, 0.054, 0.098, 0.105, 0.12), (0.015,), 2.1e11, 7850.0, 0.3)
    bearings = (Bearing("a", 3, stiffness=5e4), Bearing("b", 5, stiffness=5e4))
    sites = (Site("ra", 2, 1e-4, bearing="a"), Site("rb", 6, 1e-4, bearing="b"))
    return Rotor("micro", shaft, (Disc("wheel", 4, 0.06, 0.0275, 0.0032),), bearings, sites)


def test_a_stiff_rotor_without_a_mode_in_its_band_is_valid_up_to_its_accuracy():
    rotor = stiff_rotor()
    omega, nodes = plant_structure(rotor)[0].valid_to, (2, 3, 5, 6)
    assert 2.0 * np.pi * 2000.0 < omega < 2.0 * np.pi * 3500.0
    full, reduced = assemble(rotor), reduced_rotor(rotor).model
    H, approximate = (
        np.linalg.inv(model.K - omega**2 * model.M)[np.ix_(rows, rows)]
        for model in (full, reduced)
        for rows in [[model.translations[node][0] for node in nodes]]
    )
    assert np.abs(approximate - H).max() < 0.005 * np.abs(H).max()


def test_a_rotor_without_a_limit_is_never_beyond_it(monkeypatch):
    """The plant compares whirl speeds with infinity, and its layout, which is JSON, has no number."""
    unlimited = ReceptanceError(0.9, np.inf, *[np.zeros(0)] * 3)
    monkeypatch.setattr(plant_data, "receptance_error", lambda rotor: unlimited)
    structure, planes = plant_structure(stiff_rotor())
    assert structure.valid_to == np.inf
    layout = json.loads(json.dumps(planes.layout(), allow_nan=False))
    assert limit_of(layout) is None


@pytest.mark.parametrize(
    ("layout", "limit"),
    [({}, None), ({"valid_to": None}, None), ({"valid_to": 0.0}, None), ({"valid_to": 418.4}, 418.4)],
)
def test_a_layout_states_one_limit_or_none(layout, limit):
    """FMUs of version 0.3 have 0 without a limit, and those of others have no such field."""
    assert limit_of(layout) == limit
