"""Tables whose entries are closer than the speeds of a diagram: values between these speeds count."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

from amb_cosim import studies
from rotor_analysis.parts import AtSpeed, Bearing, Body
from rotor_analysis.rotor import Rotor
from rotor_analysis.rotor_file import load_rotor
from rotor_analysis.shaft import Shaft

MASS, STIFF, SOFT = 10.0, 5e6, 5e5  # kg, N/m of a bearing
FROM, MIDDLE, TO = 400.0, 402.0, 404.0  # rad/s, where the bearings are soft
COMPRESSOR = "compressor_levitated"


def isotropic(k):
    return ((k, 0.0), (0.0, k))


def soft_for_a_moment():
    """Return a mass half way between two bearings, which are soft about one speed, on a stiff shaft without mass."""
    speeds = ((0.0, STIFF), (FROM, STIFF), (MIDDLE, SOFT), (TO, STIFF), (3000.0, STIFF))
    rows = tuple(AtSpeed(speed, isotropic(k), isotropic(50.0)) for speed, k in speeds)
    shaft = Shaft((0.0, 0.5, 1.0), (0.5,), youngs_modulus=2.1e13, density=0.0, poissons_ratio=0.3)
    bearings = (Bearing("a", 1, at_speed=rows), Bearing("b", 3, at_speed=rows))
    return Rotor("soft", shaft, (Body("disc", 2, MASS, 0.01, 0.02, unbalance=True),), bearings)


def crossings():
    """2 k(Omega) = m Omega^2 with k = STIFF + (SOFT - STIFF) (3 t^2 - 2 t^3), level at each entry, and 1000 rad/s."""

    def excess(Omega):
        t = 1.0 - abs(Omega - MIDDLE) / (MIDDLE - FROM)
        return 2.0 * (STIFF + (SOFT - STIFF) * (3.0 * t**2 - 2.0 * t**3)) - MASS * Omega**2

    return [brentq(excess, FROM, MIDDLE), brentq(excess, MIDDLE, TO), np.sqrt(2.0 * STIFF / MASS)]


@pytest.mark.parametrize("up_to", [1100.0, 2000.0])
def test_campbell_diagram_has_critical_speeds_within_a_narrow_table(up_to):
    found = studies.campbell(soft_for_a_moment(), up_to=up_to, count=4).critical_speeds
    forward = [row.speed for row in found if row.whirl == "forward" and row.speed < 1050.0]
    assert forward == pytest.approx(crossings(), rel=1e-4)


def test_peaks_within_a_narrow_table_are_those_of_the_response():
    response = studies.unbalance_response(soft_for_a_moment(), up_to=2000.0, unbalance=1e-6)
    assert [item.speed for item in response.critical_speeds] == pytest.approx(crossings(), rel=1e-3)


@pytest.fixture(scope="module")
def driven_about_202_rad_s():
    """Return the poles of a compressor with a seal that drives forward whirl between 202.4 and 202.6 rad/s."""
    rotor = load_rotor("compressor")
    rows = tuple(
        AtSpeed(speed, ((0.0, Q), (-Q, 0.0))) for speed, Q in ((0.0, 0.0), (202.4, 0.0), (202.5, 1e9), (202.6, 0.0))
    )
    seal = Bearing("labyrinth", rotor.part_nodes[0], at_speed=rows)
    return studies.poles(
        COMPRESSOR, rotor=replace(rotor, seals=(*rotor.seals, seal)), up_to=300.0, count=2, flavour="python"
    )


@pytest.mark.slow
def test_poles_are_unstable_where_a_seal_drives_whirl_between_two_speeds(driven_about_202_rad_s):
    assert driven_about_202_rad_s.unstable == (202.5,)
    assert driven_about_202_rad_s.least_stable.speed == pytest.approx(202.5, abs=0.05)
    assert studies.poles(COMPRESSOR, up_to=300.0, count=2, flavour="python").unstable == ()


@pytest.mark.slow
def test_critical_speeds_of_the_loop_do_not_depend_on_the_range():
    """At a crossing the frequencies of rotation and of vibration of the loop are equal."""
    near, far = (
        [c.speed for c in studies.poles(COMPRESSOR, up_to=up_to, count=2, flavour="python").critical_speeds]
        for up_to in (330.0, 1100.0)
    )
    assert near == pytest.approx(far, rel=2e-5)


def test_a_critical_speed_of_a_growing_whirl_is_marked():
    """At 1000 rad/s the damping of both bearings is 100 N s/m, so that 1e5 N/m of cross coupling would balance it."""
    rotor = soft_for_a_moment()
    for Q, is_marked in ((0.9e5, False), (1.1e5, True)):
        coupled = tuple(
            Bearing(b.name, b.node, ((STIFF, Q / 2.0), (-Q / 2.0, STIFF)), isotropic(50.0)) for b in rotor.bearings
        )
        found = studies.campbell(replace(rotor, bearings=coupled), up_to=1100.0, count=4)
        assert ("forward, unstable" in str(found)) == is_marked
        assert "-0.0000" not in str(found)
