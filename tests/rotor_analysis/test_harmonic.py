"""The reduced harmonic response against all elements, and its signs in closed form."""

from pathlib import Path

import numpy as np
import pytest

from rotor_analysis.assembly import assemble, with_bearings
from rotor_analysis.harmonic import Forces, harmonic_model
from rotor_analysis.rotor_file import load_rotor
from rotor_analysis.spectrum import eigenvalues

EXPANDER = Path(__file__).parents[1] / "strange_machine/expander.toml"
OMEGAS = 2 * np.pi * np.linspace(5.0, 2000.0, 60)
SPEED = 1000.0


def row_at(rotor, node, axis=0):
    row = np.zeros((1, 2 * len(rotor.shaft.nodes)))
    row[0, 2 * (node - 1) + axis] = 1.0
    return row


@pytest.mark.parametrize("held", [False, True])
def test_every_place_moves_as_in_the_full_model(held):
    rotor = load_rotor(EXPANDER)
    bearings = (*rotor.bearings, *rotor.seals) if held else ()
    n, node = len(rotor.shaft.nodes), rotor.bodies[0].node
    model = harmonic_model(rotor, [node], OMEGAS[-1], bearings)
    result = model.response(OMEGAS, SPEED, row_at(rotor, node).T, np.eye(2 * n), None)
    full = with_bearings(assemble(rotor), bearings).at(SPEED)
    rows = full.rows(tuple(range(1, n + 1)))
    force = np.eye(full.size)[:, [full.translations[node][0]]]
    for omega, motion in zip(OMEGAS, result, strict=True):
        D = full.K - omega**2 * full.M + 1j * omega * (full.C + SPEED * full.G)
        exact = np.linalg.solve(D, force)[rows]
        assert np.linalg.norm(motion - exact) < 3e-3 * np.linalg.norm(exact)
    assert model.model.size < full.size / 4


@pytest.mark.parametrize("name", ["turbo_expander", "compressor"])
def test_spinning_rotor_whirls_as_with_all_elements_in_its_range(name):
    """At the speed of the file; gyroscopic moments couple retained modes and those left out."""
    rotor = load_rotor(name)
    Omega, highest = rotor.reduction.speed, 2.0 * rotor.reduction.speed
    model = harmonic_model(rotor, rotor.bearing_nodes, highest, ()).model
    exact, result = (np.abs(eigenvalues(one, Omega).imag) for one in (assemble(rotor), model))
    exact, result = (np.sort(omega[omega > 10.0]) for omega in (exact, result))
    inside = exact < highest
    assert np.sum(inside) > 4
    np.testing.assert_allclose(result[: len(exact)][inside[: len(result)]], exact[inside], rtol=1e-4)


def test_a_force_of_a_bearing_that_pulls_back_stiffens():
    rotor = load_rotor(EXPANDER)
    node = rotor.bodies[1].node
    model = harmonic_model(rotor, [node], OMEGAS[-1], (*rotor.bearings, *rotor.seals))
    spring, damper, row = 4e5, 30.0, 2 * (node - 1)
    half = Forces([row, row], [row], lambda omegas: -0.5 * (spring + 1j * omegas * damper)[:, None, None] * [[1], [1]])
    place = row_at(rotor, node)
    alone = model.response(OMEGAS, 0.0, place.T, place, None)[:, 0, 0]
    closed = model.response(OMEGAS, 0.0, place.T, place, half)[:, 0, 0]  # two halves at one place
    np.testing.assert_allclose(1.0 / closed, 1.0 / alone + spring + 1j * OMEGAS * damper, rtol=1e-9)
