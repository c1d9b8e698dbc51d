"""Free modes with residual shapes of the contact sites: the receptance of all elements, in few coordinates."""

from dataclasses import replace

import numpy as np
import pytest
from analysis_cases import STEEL

from amb_cosim.model_constants.plant_data import plant_structure
from rotor_analysis.assembly import assemble, on_bearings
from rotor_analysis.free_rotor import free_rotor, residual_modes
from rotor_analysis.modal_reduction import ShapeSpace, reduce_to_shapes, space_with_modes
from rotor_analysis.parts import Bearing, Disc, Sensor, Site
from rotor_analysis.reduced_rotor import reduced_rotor
from rotor_analysis.rotor import ReductionOptions, Rotor
from rotor_analysis.shaft import Shaft
from tests.support.messages import raises_naming

NODES = tuple(np.linspace(0.0, 0.5, 41).tolist())
SITES = (6, 34)
PLACES = (6, 9, 31, 34)  # with the magnets


def overhung(*more, nodes=NODES, **options):
    """A shaft with two overhung wheels, magnets inboard of two retainers."""
    shaft = Shaft(diameter=(0.05,), nodes=nodes, mass_matrix="consistent", **STEEL)
    wheels = (Disc("w1", 1, 0.9, 0.07, 0.03, unbalance=True), Disc("w2", len(nodes), 0.7, 0.06, 0.03, unbalance=True))
    parts = {"bearings": (Bearing("b1", 9), Bearing("b2", 31)), "sites": tuple(Site(f"s{n}", n) for n in SITES)}
    parts["sensors"] = (Sensor("p1", 10), Sensor("p2", 30))
    for kind, part in more:
        parts[kind] = (*parts.get(kind, ()), part)
    discs = parts.pop("bodies", ())
    return Rotor("overhung", shaft, (*wheels, *discs), reduction=ReductionOptions("free_modes", **options), **parts)


def receptances(full, reduction, nodes, omega, Omega=0.0):
    """Between nodes in both planes, of the full model and of its reduction, by solving both."""
    rows = full.rows(nodes)
    exact = np.linalg.inv(full.K + 1j * omega * (full.C + Omega * full.G) - omega**2 * full.M)[np.ix_(rows, rows)]
    model, at = reduction.model, reduction.right[rows]
    D = model.K + 1j * omega * (model.C + Omega * model.G) - omega**2 * model.M
    return exact, at @ np.linalg.solve(D, reduction.left[:, rows])


def test_sum_over_all_modes_is_the_receptance_of_all_elements():
    full = assemble(overhung())
    free, rows = free_rotor(full), [full.rows(SITES)[k] for k in (0, 2)]
    for omega in (50.0, 3e3, 4e4):
        exact = np.linalg.inv(full.K - omega**2 * full.M)[np.ix_(rows, rows)]
        np.testing.assert_allclose(free.receptance(free.rows(SITES), omega), exact, rtol=1e-6)


def test_reported_error_is_that_of_the_matrices():
    rotor = overhung()
    full = assemble(rotor)
    space = space_with_modes(free_rotor(full), 4, PLACES, 1e-3)
    reduction = reduce_to_shapes(full, space, PLACES)
    rows = free_rotor(full).rows(SITES)
    for omega in (3e3, 2e4, 4e4):
        exact, result = receptances(full, reduction, SITES, omega)
        size = np.sqrt(space.rotor.sizes(rows, omega))
        error = np.max(np.abs(result - exact)[::2, ::2] / np.outer(size, size))
        assert error == pytest.approx(space.receptance_error(SITES, omega), rel=1e-3, abs=1e-8)


def test_band_and_accuracy_determine_the_number_of_shapes():
    sizes = [reduced_rotor(overhung(band=band)).model.size for band in (500.0, 2000.0, 5000.0, 10000.0)]
    assert sizes == sorted(set(sizes))
    loose, fine = (reduced_rotor(overhung(band=5000.0, accuracy=e)).model.size for e in (1e-1, 1e-6))
    assert loose < sizes[2] < fine


def test_fastest_shape_stays_slow_although_places_are_close():
    """Static shapes between planes 5 mm apart would have 100 kHz and more."""
    close = (("sites", Site("s1b", 7)), ("sensors", Sensor("p3", 8)), ("sensors", Sensor("p4", 5)))
    model = reduced_rotor(overhung(*close, band=5000.0)).model
    fastest = np.sqrt(np.max(np.linalg.eigvals(np.linalg.solve(model.M, model.K)).real)) / (2.0 * np.pi)
    assert fastest < 60e3


def test_rotor_held_at_its_sites_deflects_exactly_under_forces_there():
    """Residual shapes are exact under static forces where they belong, springs included."""
    rotor = overhung(modes=3)
    held = replace(rotor, bearings=tuple(Bearing(f"spring{node}", node, stiffness=1e7) for node in SITES))
    free, full = reduced_rotor(rotor), on_bearings(assemble(held), held)
    force = np.zeros(full.size)
    force[full.rows(SITES)] = 10.0, -3.0, 4.0, 7.0
    exact = np.linalg.solve(full.K, force)[full.rows(SITES)]
    K = free.left @ full.K @ free.right
    result = (free.right @ np.linalg.solve(K, free.left @ force))[full.rows(SITES)]
    np.testing.assert_allclose(result, exact, rtol=1e-6)


def test_coordinates_span_the_shapes_and_begin_with_positions():
    rotor = overhung(modes=5)
    full, model = assemble(rotor), reduced_rotor(rotor).model
    space = space_with_modes(free_rotor(full), 5, PLACES, 1e-3)
    values = np.sort(np.linalg.eigvals(np.linalg.solve(model.M, model.K)).real)
    np.testing.assert_allclose(values[4:], np.repeat(np.sort(space.frequencies[2:] ** 2), 2), rtol=1e-8)
    assert np.max(np.abs(values[:4])) < 1e-12 * values[-1]
    right = reduced_rotor(rotor).right
    assert list(model.translations) == [6, 9, 31, 34]
    np.testing.assert_allclose(right[full.rows((6, 9, 31, 34))], np.eye(8, model.size), atol=1e-9)
    np.testing.assert_allclose(model.M, right.T @ full.M @ right, atol=1e-9)
    np.testing.assert_allclose(model.K, right.T @ full.K @ right, atol=1e-9 * np.max(model.K))
    rest = model.K[8:, 8:]
    np.testing.assert_allclose(rest, np.diag(np.diag(rest)), atol=1e-9 * np.max(rest))


@pytest.mark.parametrize(
    "part",
    [
        ("sensors", Sensor("p3", 20)),
        ("bodies", Disc("plane", 22, 0.0, 0.05, 0.01, unbalance=True)),
        ("seals", Bearing("stage", 24, stiffness=((0.0, 1e5), (-1e5, 0.0)))),
        ("seals", Bearing("eye", 3, stiffness=1e5, damping=30.0)),
    ],
    ids=["sensor", "unbalance", "stage", "seal"],
)
def test_part_without_contact_anywhere_costs_no_coordinate(part):
    bare, more = plant_structure(overhung(modes=6))[0], plant_structure(overhung(part, modes=6))[0]
    assert len(more.K) == len(bare.K)
    np.testing.assert_allclose(more.K, bare.K, atol=1e-6 * np.max(bare.K))


def test_site_and_bearing_at_one_node_share_a_coordinate():
    apart, together = (plant_structure(overhung(("sites", Site("s3", node)), modes=6))[0] for node in (12, 9))
    assert together.n_translations == apart.n_translations - 2
    assert together.sites[2] == together.bearings[0]


@pytest.mark.parametrize("distance", [5e-3, 1e-3, 1e-4])
def test_close_positions_are_separated_without_a_stiff_mode(distance):
    nodes = tuple(sorted({*NODES, NODES[8] + distance}))
    close = Site("close", 10)
    rotor = overhung(nodes=nodes, modes=6)
    bearings = (Bearing("b1", 9), Bearing("b2", 32))
    rotor = replace(rotor, bearings=bearings, sites=(*rotor.sites, close))
    s = plant_structure(rotor)[0]
    np.testing.assert_allclose(s.forms[: len(s.K)] @ s.Minv, np.eye(len(s.K)), atol=1e-6)
    values = np.linalg.eigvals(s.MinvK).real
    assert np.sqrt(np.max(values)) < 2.0 * np.pi * 100e3
    assert np.min(values) > -1e-9 * np.max(values)


def test_positions_that_the_shapes_do_not_separate_are_refused():
    full = assemble(overhung())
    free = free_rotor(full)
    none = residual_modes(free, 0, (), 1e-3)
    with raises_naming(ValueError, "2 shapes"):
        reduce_to_shapes(full, ShapeSpace(free, 0, none), (6, 9, 31))


@pytest.mark.parametrize("elastic", [0, 1, 20, 58])
def test_plant_of_4_to_120_coordinates_keeps_its_energy_in_free_flight(elastic):
    """With two places, 0 elastic modes and no residual shape the rotor is a rigid body in space."""
    rotor = overhung(nodes=tuple(np.linspace(0.0, 0.5, 41).tolist()))
    full = assemble(rotor)
    space = ShapeSpace(free_rotor(full), elastic, residual_modes(free_rotor(full), elastic, (), 1e-3))
    model = reduce_to_shapes(full, space, (6, 34)).model
    assert model.size == 4 + 2 * elastic
    M, K = model.M, model.K
    np.testing.assert_allclose(M, M.T)
    assert np.linalg.eigvalsh(M)[0] > 0.0
    values = np.linalg.eigvals(np.linalg.solve(M, K)).real
    assert np.sum(np.abs(values) < 1e-9 * np.max(values, initial=1e9)) == 4


def test_more_modes_than_exist_are_refused():
    with raises_naming(ValueError, "modes", "81", "0 to 80"):
        reduced_rotor(overhung(modes=81))
