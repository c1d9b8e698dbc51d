"""Critical speeds and amplification against closed forms and against ROSS."""

import json
from itertools import pairwise

import numpy as np
import pytest
from ross_numbers import REFERENCE

from amb_files.toml import validate
from rotor_analysis.assembly import assemble
from rotor_analysis.critical_speeds import antinodes, critical_speeds, lobe_masses
from rotor_analysis.damping import free_modes
from rotor_analysis.peaks import UNDAMPED, highest_peaks, peaks_of, separation_margin
from rotor_analysis.ross_file import read_ross
from rotor_analysis.rotor import Rotor
from rotor_analysis.shaft import Shaft
from tests.support.messages import raises_naming

ROSS = json.loads((REFERENCE / "ross" / "critical_speeds.json").read_text(encoding="utf-8"))
ROTORS = ("two_discs", "three_materials", "compressor")
EXACT = 1e-6


def rotor_of(name):
    return validate(read_ross(REFERENCE / "ross" / f"{name}.toml")[0], Rotor, name)


def free_rotor(name):
    return assemble(rotor_of(name))


@pytest.mark.parametrize("zeta", [0.02, 0.1, 0.3])
def test_peak_and_amplification_of_an_oscillator_match_closed_forms(zeta):
    r = np.linspace(0.02, 6.0, 4000)
    peaks = peaks_of(r, r**2 / np.hypot(1.0 - r**2, 2.0 * zeta * r))
    half = 0.5 / (4.0 * zeta**2 * (1.0 - zeta**2))
    ends = np.sqrt(np.roots([1.0 - half, half * (2.0 - 4.0 * zeta**2), -half]).real)
    (peak,) = peaks
    assert peak.Omega == pytest.approx(1.0 / np.sqrt(1.0 - 2.0 * zeta**2), rel=1e-5)
    assert peak.amplitude == pytest.approx(1.0 / (2.0 * zeta * np.sqrt(1.0 - zeta**2)), rel=1e-5)
    assert not peak.from_single_side
    assert peak.amplification == pytest.approx(peak.Omega / abs(ends[0] - ends[1]), rel=1e-4)


def test_a_peak_narrower_than_rounding_has_a_finite_amplification():
    """Both half-power speeds of an undamped resonance are the next number to it, or itself."""
    (peak,) = peaks_of(np.array([249.0, 250.0, 251.0]), np.array([1.0, 1e14, 1.0]))
    assert peak.Omega == pytest.approx(250.0)
    assert UNDAMPED < peak.amplification < np.inf


def test_a_response_without_resonance_has_no_peak():
    r = np.linspace(0.02, 6.0, 400)
    assert peaks_of(r, r**2 / np.hypot(1.0 - r**2, 2.0 * 0.8 * r)) == []


def test_a_shoulder_of_a_higher_peak_has_a_single_half_power_speed():
    r = np.linspace(0.0, 3.0, 3001)
    low, high = (a / np.hypot(1.0, (r - at) / 0.05) for a, at in ((1.0, 1.0), (3.0, 1.3)))
    first, second = peaks_of(r, low + high)
    assert first.from_single_side
    assert not second.from_single_side


def test_a_peak_at_a_single_position_is_listed():
    """The place with the higher peak does not show the other critical speed; where both peak, the higher counts."""
    r = np.linspace(0.02, 3.0, 3001)
    first, second = (a / np.hypot(1.0, (r - at) / 0.02) for a, at in ((1.0, 1.0), (3.0, 2.0)))
    found = highest_peaks(r, {"drive end": second, "far end": first + 0.5 * second})
    assert [(name, round(peak.Omega, 2)) for name, peak in found] == [("far end", 1.0), ("drive end", 2.0)]


def test_separation_margin_is_relative_and_negative_within_the_range():
    assert separation_margin(80.0, 100.0, 200.0) == pytest.approx(20.0)
    assert separation_margin(230.0, 100.0, 200.0) == pytest.approx(15.0)
    assert separation_margin(190.0, 100.0, 200.0) == pytest.approx(-5.0)


def test_lobes_alternate_and_rigid_motion_has_the_rotor_mass():
    free = free_rotor("two_discs")
    _, shapes = critical_speeds(free, {1: 1e6, 7: 1e6}, 3)
    lobes = [lobe_masses(free, shape) for shape in shapes.T]
    assert [len(of) for of in lobes] == [1, 2, 3]
    assert all(a * b < 0.0 for of in lobes for (_, _, a), (_, _, b) in pairwise(of))
    ((_, whole, _),) = lobe_masses(free, np.ones(len(shapes)))
    assert whole == pytest.approx(free.M[::4, ::4].sum())
    assert [at for at, _ in antinodes(np.array([0.1, 0.4, -0.2, -0.6, -0.1]))] == [1, 3]


@pytest.mark.parametrize("rounding", [-1e-16, 0.0, 1e-16])
@pytest.mark.parametrize("elements", [10, 20])
def test_modal_masses_of_a_tilting_shaft_match_two_levers(elements, rounding):
    """m_l = integral of rho A |z - z_0| dz = rho A a^2/2 of either arm a, for any mesh and any sign of the zero."""
    z = np.linspace(0.0, 1.0, elements + 1)
    bar = Rotor("bar", Shaft(tuple(z), (0.05,), youngs_modulus=2.1e11, density=7850.0, poissons_ratio=0.3))
    shape = z - 0.3
    shape[3 * elements // 10] = rounding
    (_, first, low), (_, second, high) = lobe_masses(assemble(bar), shape)
    per_length = 7850.0 * 0.25 * np.pi * 0.05**2
    assert (low, high) == (-1.0, 1.0)
    assert (first, second) == (pytest.approx(0.5 * per_length * 0.3**2), pytest.approx(0.5 * per_length * 0.7**2))


def test_springs_that_do_not_support_the_rotor_are_refused():
    with raises_naming(ValueError, "two or more"):
        critical_speeds(free_rotor("two_discs"), {1: 1e6}, 3)


@pytest.mark.parametrize("name", ROTORS)
def test_free_modes_match_ross(name):
    free = free_rotor(name)
    result = free_modes(free.M[::2, ::2], free.K[::2, ::2])[0]
    np.testing.assert_allclose(result[: len(ROSS[name]["bending"])], ROSS[name]["bending"], rtol=EXACT)


@pytest.mark.parametrize("name", ROTORS)
def test_critical_speeds_over_stiffness_match_ross(name):
    free, expected = free_rotor(name), ROSS[name]
    for stiffness, speeds in expected["critical_speeds"].items():
        result, _ = critical_speeds(free, dict.fromkeys(expected["bearings"], float(stiffness)), len(speeds))
        np.testing.assert_allclose(result, speeds, rtol=EXACT)
