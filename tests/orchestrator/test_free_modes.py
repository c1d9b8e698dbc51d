"""Slow modes of a free rotor in the table of `study modes`: rounding is no instability, growth is."""

from __future__ import annotations

import pytest

from amb_cosim import studies
from rotor_analysis.parts import Bearing, Body
from rotor_analysis.rotor import Rotor
from rotor_analysis.shaft import Shaft


def free_rotor(*seals: Bearing) -> Rotor:
    steel = {"youngs_modulus": 2e11, "density": 7800.0, "poissons_ratio": 0.3}
    shaft = Shaft(nodes=(0.0, 0.25, 0.5, 0.75, 1.0), diameter=(0.1,), **steel)
    disc = Body("disc", 2, mass=20.0, diametral_inertia=0.1, polar_inertia=0.2, unbalance=True)
    return Rotor("free", shaft, bodies=(disc,), seals=seals)


@pytest.mark.parametrize("speed", [0.05, 0.1, 0.3, 1.0, 300.0, 3000.0])
def test_precession_of_a_free_rotor_is_not_unstable(speed):
    """Torque-free precession at speed I_p/I_t, 0.004 rad/s at 0.1 rad/s, neither grows nor decays."""
    assert "unstable" not in str(studies.modes(free_rotor(), speeds=f"{speed} rad/s"))


def test_slow_growth_of_a_rotor_in_soft_seals_is_unstable():
    """Cross coupling of 1 N/m between x and y, at both ends of a rotor in springs of 100 N/m."""
    ends = (Bearing(name, node, ((100.0, 1.0), (-1.0, 100.0))) for name, node in (("a", 1), ("b", 5)))
    text = str(studies.modes(free_rotor(*ends), speeds="0.1 rad/s", count=4))
    assert text.count("forward, unstable") == 2
