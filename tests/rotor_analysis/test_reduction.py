"""Condensation to the master planes: exact properties, accuracy, and errors."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rotor_cases import discs_at, sensors_at, shaft_only

from amb_cosim.model_constants.plant_data import plant_structure
from rotor_analysis.assembly import assemble, on_bearings
from rotor_analysis.damping import Damping
from rotor_analysis.modes import damped_frequencies
from rotor_analysis.reduced_rotor import reduced_rotor
from rotor_analysis.reduction import msdc
from rotor_analysis.rotor import ReductionOptions
from rotor_analysis.rotor_file import load_rotor
from rotor_analysis.spectrum import eigenvalues
from tests.support.messages import raises_naming

ROTOR = load_rotor()
CROSS = np.array([[1e6, 4e5], [-6e5, 8e5]])  # unsymmetric, as of a journal bearing


def on_cross_coupled_bearings(nodes):
    model = assemble(ROTOR)
    for node in nodes:
        model = model.with_bearing(node, CROSS, 1e-3 * CROSS)
    return model


@pytest.mark.parametrize("bearings", [(4, 11), (6, 12)], ids=["at masters", "at slaves"])
@settings(max_examples=20)
@given(seed=st.integers(0, 2**32 - 1))
def test_static_deflection_is_exact_also_with_cross_coupling(bearings, seed):
    full = on_cross_coupled_bearings(bearings)
    reduction = msdc(full, ROTOR.masters)
    masters = [row for node in ROTOR.masters for row in full.translations[node]]
    force = np.zeros(full.size)
    force[masters] = np.random.default_rng(seed).normal(size=len(masters))
    exact = np.linalg.solve(full.K, force)
    q = np.linalg.solve(reduction.model.K, force[masters])
    np.testing.assert_allclose(q, exact[masters], rtol=1e-6, atol=1e-8 * np.max(np.abs(exact)))
    np.testing.assert_allclose(reduction.right @ q, exact, rtol=1e-6, atol=1e-8 * np.max(np.abs(exact)))


def test_forces_on_slaves_move_masters_exactly_with_cross_coupling():
    full = on_cross_coupled_bearings((6, 12))
    reduction = msdc(full, ROTOR.masters)
    force = np.random.default_rng(1).normal(size=full.size)
    masters = [row for node in ROTOR.masters for row in full.translations[node]]
    q = np.linalg.solve(reduction.model.K, reduction.left @ force)
    exact = np.linalg.solve(full.K, force)[masters]
    np.testing.assert_allclose(q, exact, rtol=1e-6, atol=1e-8 * np.max(np.abs(exact)))


def test_condensation_of_massless_slaves_changes_no_eigenvalue():
    """Slaves without inertia follow statically: the finite eigenvalues of the full model are those of the reduced."""
    full = on_bearings(assemble(ROTOR), ROTOR.on_equal_bearings(1e6, 5000.0))
    masters = [row for node in ROTOR.masters for row in full.translations[node]]
    retained = np.zeros(full.size)
    retained[masters] = 1.0
    mask = np.outer(retained, retained)
    rng = np.random.default_rng(3)
    skew = rng.normal(size=mask.shape)
    full = replace(full, M=full.M * mask, G=0.05 * (skew - skew.T) * mask)
    Omega = 300.0
    values = eigenvalues(full, Omega)
    values = values[np.isfinite(values) & (np.abs(values) < 1e5)]
    reduced = eigenvalues(msdc(full, ROTOR.masters).model, Omega)
    assert len(reduced) == 24
    for value in reduced:
        assert np.min(np.abs(values - value)) < 1e-5 * abs(value)


def test_undamped_reduced_frequencies_bound_the_full_ones_from_above():
    undamped = replace(ROTOR, bearings=tuple(replace(b, damping=((0.0, 0.0), (0.0, 0.0))) for b in ROTOR.bearings))
    full = on_bearings(assemble(ROTOR), undamped)
    exact = damped_frequencies(full, 0.0, 12)
    reduced = damped_frequencies(msdc(full, ROTOR.masters).model, 0.0)
    assert np.all(reduced[:12] >= exact * (1.0 - 1e-9))
    np.testing.assert_allclose(reduced[:8], exact[:8], rtol=2e-3)


def test_reduced_free_rotor_keeps_mass_centre_and_rigid_motion():
    full = assemble(ROTOR)
    reduction = msdc(full, ROTOR.masters)
    along_y = np.zeros(full.size)
    along_y[1::4] = 1.0
    unit = np.tile([0.0, 1.0], len(ROTOR.masters))
    np.testing.assert_allclose(reduction.right @ unit, along_y, atol=1e-7)
    assert unit @ reduction.model.M @ unit == pytest.approx(ROTOR.mass, rel=1e-8)
    np.testing.assert_allclose(reduction.model.K @ unit, 0.0, atol=1e-8 * np.max(reduction.model.K))


@pytest.mark.parametrize("planes", [(4,), ()])
def test_too_few_planes_to_hold_the_rotor_are_refused(planes):
    with raises_naming(ValueError, "two planes"):
        msdc(assemble(ROTOR), planes)


def test_the_structure_of_the_plant_is_the_reduced_model():
    full = assemble(ROTOR)
    reduction = msdc(full, ROTOR.masters)
    s = plant_structure(ROTOR)[0]
    M, MinvG = s.forms[:12], s.over_speed[:12]
    np.testing.assert_array_equal(M, reduction.model.M)
    np.testing.assert_array_equal(s.K, reduction.model.K)
    np.testing.assert_allclose(M @ MinvG, reduction.model.G, atol=1e-9)
    np.testing.assert_allclose(M @ s.Minv, np.eye(12), atol=1e-10)
    assert not s.is_damped
    np.testing.assert_array_equal(s.bearings, [4, 8])  # x of the third and fifth master
    np.testing.assert_array_equal(s.sites, [4, 8, 0, 10])  # the same, and the ends
    # sensor order: motor end, mb2, mb1, non-driven end; all are masters
    expected = np.zeros((8, 12))
    expected[range(8), [10, 11, 8, 9, 4, 5, 0, 1]] = 1.0
    np.testing.assert_array_equal(s.sensors, expected)
    expected = np.zeros((12, 8))
    expected[[0, 1, 2, 3, 6, 7, 10, 11], range(8)] = 1.0
    np.testing.assert_array_equal(s.B_disc, expected.T)


@pytest.mark.parametrize("method", ["msdc", "free_modes"])
def test_damped_structure_of_the_plant_has_the_eigenvalues_of_the_model(method):
    """q'' = -(M^-1 (C + R) + Omega M^-1 G) q' - (M^-1 K - Omega M^-1 R J) q."""
    reduction = ReductionOptions("msdc", ROTOR.masters) if method == "msdc" else ReductionOptions(modes=3)
    rotor = replace(ROTOR, damping=Damping(mass=1.0, modal=0.02, rotating=0.7), reduction=reduction)
    s, Omega = plant_structure(rotor)[0], 300.0
    n = len(s.K)
    MinvG, MinvRJ = s.over_speed[:n], s.over_speed[n:]
    A = np.block([[np.zeros((n, n)), np.eye(n)], [Omega * MinvRJ - s.MinvK, -s.MinvC - Omega * MinvG]])
    result, expected = (
        values[np.abs(values) > 10.0]
        for values in (np.linalg.eigvals(A), eigenvalues(reduced_rotor(rotor).model, Omega))
    )
    assert len(result) == len(expected)
    for value in expected:
        assert np.min(np.abs(result - value)) < 1e-7 * abs(value)
    M, C, R = s.forms[:n], s.forms[n : 2 * n], s.forms[2 * n :]
    np.testing.assert_allclose(M @ s.MinvC, C + R, atol=1e-9 * np.max(C + R))
    assert s.is_damped


def test_sensors_and_discs_may_sit_between_the_masters():
    """A slave plane is seen, and pushed, through the static deflection: reciprocally."""
    rotor = replace(ROTOR, bodies=discs_at(2, 6, 8, 12), sensors=sensors_at(12, 8, 6, 2))
    s = plant_structure(rotor)[0]
    for k in range(4):
        for axis in range(2):
            np.testing.assert_allclose(s.B_disc[2 * k + axis], s.sensors[2 * (3 - k) + axis], atol=1e-8)
    np.testing.assert_allclose(s.sensors @ np.tile([1.0, 0.0], 6), np.tile([1.0, 0.0], 4), atol=1e-7)


def test_two_masters_leave_a_rotor_rigid():
    s = plant_structure(shaft_only((0.0, 1.0)))[0]
    np.testing.assert_allclose(s.K, 0.0, atol=1e-6 * 2e5)
