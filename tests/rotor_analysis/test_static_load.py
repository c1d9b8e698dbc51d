"""How the bearings share the weight of a rotor: by levers where there are two, by bending where there are more."""

from dataclasses import replace

import numpy as np
import pytest
from analysis_cases import MASS, NOTHING, STEEL, L, disc_between

from rotor_analysis.packaged_rotors import packaged_rotors
from rotor_analysis.parts import AtSpeed, Bearing
from rotor_analysis.rigid_body import rigid_body
from rotor_analysis.rotor import Rotor
from rotor_analysis.rotor_file import load_rotor
from rotor_analysis.shaft import Shaft
from rotor_analysis.static_load import carried_masses, carried_with_seals
from tests.support.messages import raises_naming


@pytest.mark.parametrize("name", packaged_rotors())
def test_two_bearings_share_the_weight_by_their_distance_from_its_centre(name):
    """The second bearing of Nelson and McVaugh's overhung rotor pulls it down."""
    rotor = load_rotor(name)
    body, z = rigid_body(rotor), [rotor.shaft.nodes[node - 1] for node in rotor.bearing_nodes]
    first = body.mass * (z[1] - body.centre) / (z[1] - z[0])
    assert list(carried_masses(rotor).values()) == pytest.approx([first, body.mass - first], rel=1e-8)
    assert (first > body.mass) == (name == "nelson_mcvaugh")


LENGTH, DIAMETER = 4.0, 0.02  # m


def slender_beam():
    bearings = tuple(Bearing(name, node) for name, node in (("left", 1), ("middle", 11), ("right", 21)))
    nodes = tuple(np.linspace(0.0, LENGTH, 21).tolist())
    shaft = Shaft(nodes, (DIAMETER,), **STEEL, theory="rayleigh", mass_matrix="consistent")
    return Rotor("beam", shaft, bearings=bearings)


def test_three_bearings_share_the_weight_of_a_slender_beam_by_its_bending():
    """3/16, 5/8 and 3/16 of an even beam on three equidistant supports."""
    beam = slender_beam()
    shares = np.array(list(carried_masses(beam).values())) / beam.mass
    assert shares == pytest.approx([3 / 16, 5 / 8, 3 / 16], rel=1e-6)


@pytest.mark.parametrize("k", [0.0, 1e2, 1e3, 1e12])
def test_a_spring_in_the_middle_of_a_beam_carries_what_its_deflection_gives(k):
    """k (5 m L^3/(384 E I) - f L^3/(48 E I)) = f, from no share to 5/8 of the beam."""
    beam, EI = slender_beam(), STEEL["youngs_modulus"] * np.pi * DIAMETER**4 / 64.0
    carried = carried_masses(beam, {"middle": k})
    middle = 5.0 / 8.0 * beam.mass / (1.0 + 48.0 * EI / (k * LENGTH**3)) if k else 0.0
    ends = 0.5 * (beam.mass - middle)
    assert carried == pytest.approx({"left": ends, "middle": middle, "right": ends}, rel=1e-5, abs=1e-12)


@pytest.mark.parametrize("Omega", [0.0, 300.0])
def test_a_seal_in_the_middle_of_a_beam_carries_weight_by_its_stiffness(Omega):
    """As a spring k - i Q of x + i y: cross-coupled stiffness loads the bearings across gravity, too."""
    beam, EI = slender_beam(), STEEL["youngs_modulus"] * np.pi * DIAMETER**4 / 64.0
    seal = Bearing("seal", 11, at_speed=(AtSpeed(0.0, 1e2, mass=5.0), AtSpeed(300.0, ((1e3, 4e2), (-4e2, 1e3)))))
    carried = carried_with_seals(replace(beam, bearings=beam.bearings[::2], seals=(seal,)), {}, Omega)
    k = 1e3 - 4e2j if Omega else 1e2
    middle = 5.0 / 8.0 * beam.mass / (1.0 + 48.0 * EI / (k * LENGTH**3))
    end = 0.5 * (beam.mass - middle)
    expected = np.array([[end.real, -end.imag], [end.imag, end.real]])
    for name in ("left", "right"):
        np.testing.assert_allclose(carried[name], expected, rtol=1e-5, atol=1e-9)


def test_without_seals_the_load_of_a_bearing_is_that_of_its_mass():
    beam = slender_beam()
    for name, mass in carried_masses(beam, {"middle": 1e3}).items():
        assert np.array_equal(carried_with_seals(beam, {"middle": 1e3}, 0.0)[name], mass * np.eye(2))


def test_a_bearing_and_a_spring_hold_a_rotor_which_nothing_else_holds():
    """The spring holds the other end, whatever its stiffness; without stiffness the rotor would fall."""
    left, middle, right = (Bearing(name, node, NOTHING) for name, node in (("left", 1), ("middle", 2), ("right", 3)))
    rotor = disc_between(left, middle, right)
    carried = carried_masses(rotor, {"middle": 0.0, "right": 1e3})
    assert carried == pytest.approx({"left": 0.5 * MASS, "middle": 0.0, "right": 0.5 * MASS})
    with raises_naming(ValueError, "3 bearings", "2 of them without stiffness"):
        carried_masses(rotor, {"middle": 0.0, "right": 0.0})


def test_middle_bearing_under_the_disc_carries_it_alone():
    left, middle, right = (Bearing(name, node, NOTHING) for name, node in (("left", 1), ("middle", 2), ("right", 3)))
    carried = carried_masses(disc_between(left, middle, right))
    assert carried == pytest.approx({"left": 0.0, "right": 0.0, "middle": MASS}, abs=1e-9)


def test_a_rotor_on_a_single_bearing_is_refused():
    shaft = Shaft((0.0, L / 2, L), (0.03,), 2.1e11, 7850.0, 0.3)
    with raises_naming(ValueError, "'swing'", "1 bearing;", "two or more"):
        carried_masses(Rotor("swing", shaft, bearings=(Bearing("only", 2),)))
