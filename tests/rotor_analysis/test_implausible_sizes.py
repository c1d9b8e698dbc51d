"""Sizes and materials of rotors in another unit are noticed; those of real machines, small and large, are not."""

from dataclasses import replace

import pytest

from rotor_analysis.implausible_sizes import implausible_sizes
from rotor_analysis.packaged_rotors import packaged_rotors
from rotor_analysis.parts import Body, Disc, Site
from rotor_analysis.rotor import Rotor
from rotor_analysis.rotor_file import load_rotor
from rotor_analysis.shaft import Shaft
from tests.support.messages import assert_names

STEEL = {"youngs_modulus": 210e9, "density": 7850.0, "poissons_ratio": 0.3}


def rotor_of(length, diameter, disc, clearance=2e-4):
    """A shaft with a disc of mass (kg), radius and width (m) in its middle, and a retainer."""
    shaft = Shaft((0.0, 0.5 * length, length), (diameter,), **STEEL)
    return Rotor("fan", shaft, (Disc("wheel", 2, *disc),), sites=(Site("rb", 1, clearance),))


REAL = {
    "dental turbine": (0.012, 0.0015, (0.5e-3, 2.5e-3, 3e-3), 1e-5),
    "dental turbine of a handpiece": (0.02, 0.005, (1e-3, 4e-3, 4e-3), 2e-5),
    "flywheel": (0.4, 0.06, (80.0, 0.25, 0.1), 2.5e-4),
    "motor of 1.5 t": (1.8, 0.25, (700.0, 0.25, 0.8), 4e-4),
    "steam turbine and generator": (15.0, 0.7, (20e3, 1.0, 2.5), 1e-3),
    "generator of a nuclear power station": (17.0, 1.2, (120e3, 0.95, 8.0), 1e-3),
}


@pytest.mark.parametrize("machine", REAL)
def test_real_machines_have_plausible_sizes(machine):
    assert implausible_sizes(rotor_of(*REAL[machine])) == ()


def test_packaged_rotors_have_plausible_sizes():
    assert [implausible_sizes(load_rotor(name)) for name in packaged_rotors()] == [()] * len(packaged_rotors())


@pytest.mark.parametrize("machine", [name for name in REAL if name != "dental turbine"])
def test_sizes_in_millimetres_are_implausible(machine):
    """A shaft of 1.5 mm would be one of 1.5 m, which is that of a large generator."""
    length, diameter, (mass, radius, width), clearance = REAL[machine]
    in_mm = rotor_of(1e3 * length, 1e3 * diameter, (mass, 1e3 * radius, 1e3 * width), 1e3 * clearance)
    assert_names(implausible_sizes(in_mm)[0], "rotor fan", f"{1e3 * diameter:.4g} m", "<= 3 m", "mm")


def test_a_shaft_of_300_mm_by_50_mm_in_metres_names_length_diameter_and_mass():
    lengths, masses, inertias = implausible_sizes(rotor_of(300.0, 50.0, (5.0, 80.0, 20.0), 0.25))
    assert_names(lengths, "length of the shaft = 300 m", "<= 40 m", "diameter of the shaft = 50 m", "<= 3 m")
    assert_names(lengths, "clearance of rb = 0.25 m", "<= 0.02 m", "mm")
    assert_names(masses, "mass = 4.624e+09 kg", "<= 300000 kg")  # 7850 kg/m3 pi 50^2/4 300
    assert_names(inertias, "wheel = 80 m", "<= 4 m")


def test_masses_in_grams_and_inertias_in_kg_mm2_are_implausible():
    """5 kg with I_p = 1e4 kg m2 are a disc with a radius of sqrt(2 1e4/5) m, with I_d a rod of sqrt(12 1e4/5) m."""
    real = rotor_of(*REAL["motor of 1.5 t"])
    (heavy,) = implausible_sizes(replace(real, bodies=(Disc("wheel", 2, 700e3, 0.25, 0.8),)))
    assert_names(heavy, "mass = 7.007e+05 kg", "kg", "g")
    for I_d, I_p, facts in ((0.0, 1e4, ("63.25 m", "<= 4 m")), (1e4, 0.0, ("154.9 m", "<= 40 m"))):
        (wide,) = implausible_sizes(replace(real, bodies=(Body("wheel", 2, 5.0, I_d, I_p),)))
        assert_names(wide, "wheel", *facts, "kg mm2")


def test_a_shaft_converted_to_metres_twice_is_implausible():
    (short,) = implausible_sizes(rotor_of(1.2e-3, 5e-5, (1e-6, 1e-5, 1e-5), 1e-6))
    assert_names(short, "length of the shaft = 0.0012 m", ">= 0.003 m", "twice")


@pytest.mark.parametrize(
    ("material", "facts"),
    [
        ({"youngs_modulus": 210.0}, ("youngs_modulus = 210 Pa", "GPa")),
        ({"youngs_modulus": 210e3}, ("youngs_modulus = 2.1e+05 Pa", "N/mm2")),
        ({"density": 7.85}, ("density = 7.85 kg/m3", "g/cm3")),
    ],
)
def test_a_material_in_another_unit_is_implausible(material, facts):
    shaft = Shaft((0.0, 0.5, 1.0), (0.05,), **STEEL | material)
    assert_names(*implausible_sizes(Rotor("fan", shaft)), "rotor fan", *facts)


@pytest.mark.parametrize("density", [0.0, 1e-30, 1e-3])
def test_a_massless_shaft_is_plausible(density):
    shaft = Shaft((0.0, 1.0), (0.05,), **STEEL | {"density": density})
    assert implausible_sizes(Rotor("fan", shaft, (Disc("wheel", 1, 5.0, 0.1, 0.02),))) == ()
