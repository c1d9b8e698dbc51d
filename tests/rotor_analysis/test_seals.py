"""Seals and passive bearings: signs of cross coupling and mass in closed form, and unsupported coefficients."""

from dataclasses import replace

import numpy as np
import pytest
from analysis_cases import MASS, NOTHING, disc_between, spring, tensor

from rotor_analysis.modes import modes
from rotor_analysis.parts import AtSpeed, Bearing
from rotor_analysis.rotor_file import load_rotor
from rotor_analysis.supported_rotor import supported_plant, supported_rotor

HELD = [Bearing(name, node, tensor(1e7)) for name, node in (("left", 1), ("right", 3))]
Q = 2e4  # N/m


def jeffcott_with(**seal):
    rotor = replace(disc_between(*HELD), seals=(Bearing("labyrinth", 2, **seal),))
    return modes(supported_rotor(rotor, planes=(2,)).model, 0.0, 2)


@pytest.mark.parametrize(("sign", "unstable"), [(1.0, "forward"), (-1.0, "backward")])
def test_cross_coupling_drives_whirl_of_its_sense(sign, unstable):
    """m s^2 + k - i Q = 0 for x + i y: |zeta| is nearly Q/(2 k)."""
    mode_of = {mode.whirl: mode for mode in jeffcott_with(stiffness=tensor(0.0, sign * Q))}
    assert set(mode_of) == {"forward", "backward"}
    exact = np.sqrt(complex(-spring(), sign * Q) / MASS)
    for whirl, mode in mode_of.items():
        growth = abs(exact.real) * (1.0 if whirl == unstable else -1.0)
        assert mode.eigenvalue == pytest.approx(complex(growth, abs(exact.imag)), rel=1e-6)


def test_mass_of_a_seal_lowers_the_frequency():
    (first, _) = jeffcott_with(mass=tensor(3.0))
    assert first.frequency == pytest.approx(np.sqrt(spring() / (MASS + 3.0)), rel=1e-9)


def test_mass_over_speed_is_interpolated():
    rows = tuple(AtSpeed(speed, NOTHING, NOTHING, tensor(mass)) for speed, mass in ((0.0, 1.0), (100.0, 3.0)))
    seal = Bearing("labyrinth", 2, at_speed=rows)
    for Omega, mass in ((-10.0, 1.0), (50.0, 2.0), (500.0, 3.0)):
        np.testing.assert_allclose(seal.at(Omega)[2], tensor(mass), rtol=1e-12, atol=1e-12)


def test_a_seal_anywhere_adds_no_coordinate_to_the_plant():
    """Its force at a node between the masters is that of the shape of the shaft there."""
    rig = load_rotor()
    rows = tuple(AtSpeed(speed, tensor(k, 2e5), tensor(1e3), tensor(3.0)) for speed, k in ((0.0, 1e6), (100.0, 3e6)))
    seal = Bearing("labyrinth", 8, at_speed=rows)
    sealed = replace(rig, seals=(seal,))
    plant, bare = supported_plant(sealed), supported_plant(rig)
    row = bare.displacement_of((8,))
    assert plant.model.size == bare.model.size
    for Omega in (30.0, 150.0):
        K, C, M = seal.at(Omega)
        model, expected = plant.model.at(Omega), bare.model.at(Omega)
        for name, local in (("K", K), ("C", C), ("M", M)):
            np.testing.assert_allclose(getattr(model, name), getattr(expected, name) + row.T @ local @ row, atol=1e-9)
