"""Rotors of the literature: eigenvalues and unbalance response against ROSS, frequencies against printed ones.

Both programs use the same elements, those of Nelson and McVaugh without shear deformation and of Nelson with it, and
differ by rounding alone. `python tools/ross/published_rotors.py` renews ROSS's numbers.
"""

import json
from dataclasses import replace

import numpy as np
import pytest
from ross_numbers import REFERENCE, complex_numbers, difference

from rotor_analysis.assembly import assemble, on_bearings
from rotor_analysis.rotor_file import load_rotor
from rotor_analysis.spectrum import eigenvalues

STORED = json.loads((REFERENCE / "published_rotors.json").read_text(encoding="utf-8"))
ROSS = STORED["ross"]
CASES = [(rotor, speed) for rotor, theories in ROSS["eigenvalues"].items() for speed in theories["rayleigh"]]
RPM = np.pi / 30.0

# The stored numbers have ten digits. Nelson and McVaugh's rotor has an element 5 mm long and 66 mm thick, 1e6 times as
# stiff as the first mode; the eigensolver rounds on its scale: 1e-7 was measured.
ROUNDING = {"nelson_mcvaugh": 5e-7, "nelson_mcvaugh_coupled": 5e-7}


def rotor_of(name, theory=None):
    rotor = load_rotor(REFERENCE / "rotors" / f"{name}.toml")
    return replace(rotor, shaft=replace(rotor.shaft, theory=theory)) if theory else rotor


def supported_rotor(rotor):
    return on_bearings(assemble(rotor, "consistent"), rotor)


@pytest.mark.parametrize("theory", ["rayleigh", "timoshenko"])
@pytest.mark.parametrize(("name", "speed"), CASES)
def test_eigenvalues_match_ross(name, speed, theory):
    expected = complex_numbers(ROSS["eigenvalues"][name][theory][speed])
    result = eigenvalues(supported_rotor(rotor_of(name, theory)), float(speed) * RPM)
    assert np.max(difference(result, expected)) < ROUNDING.get(name, 2e-9)


@pytest.mark.parametrize("case", STORED["printed"], ids=lambda case: f"{case['rotor']}-{case['speed']}")
def test_frequencies_match_print_to_one_unit_of_the_last_digit(case):
    result = eigenvalues(supported_rotor(rotor_of(case["rotor"])), case["speed"] * RPM)
    upper = sorted(result[result.imag > 1.0], key=lambda value: value.imag)
    for quantity, numbers in (("damped_frequencies", np.imag(upper)), ("sizes", np.abs(upper))):
        for number, printed in zip(numbers / (2.0 * np.pi), case.get(quantity, []), strict=False):
            assert number == pytest.approx(float(printed), abs=1.001 * 10.0 ** -len(printed.partition(".")[2]))


@pytest.mark.parametrize("theory", ["rayleigh", "timoshenko"])
@pytest.mark.parametrize("name", ROSS["unbalance_response"]["x_y"])
def test_amplitude_and_phase_of_unbalance_response_match_ross(name, theory):
    case = ROSS["unbalance_response"]
    model = supported_rotor(rotor_of(name, theory))
    for speed, pairs in case["x_y"][name][theory].items():
        expected = complex_numbers(pairs)
        result = response(model, float(speed) * RPM, case["unbalances"])[model.rows(tuple(case["nodes"]))]
        np.testing.assert_allclose(np.abs(result), np.abs(expected), rtol=2e-9)
        np.testing.assert_allclose(np.angle(result / expected), 0.0, atol=2e-9)


def response(model, Omega, unbalances):
    """(-Omega^2 M + i Omega (C + Omega G) + K) q = f, with f_x + i f_y = u Omega^2 exp(i (theta + phase))."""
    force = np.zeros(model.size, dtype=complex)
    for unbalance in unbalances:
        x, y = model.translations[unbalance["node"]]
        phasor = unbalance["magnitude"] * Omega**2 * np.exp(1j * unbalance["phase"])
        force[x] += phasor
        force[y] -= 1j * phasor
    return np.linalg.solve(-(Omega**2) * model.M + 1j * Omega * (model.C + Omega * model.G) + model.K, force)


def test_oil_film_of_the_rotor_file_matches_ross():
    for bearing in rotor_of("friswell_5_9_6").bearings:
        np.testing.assert_allclose(bearing.stiffness, ROSS["oil_film"]["stiffness"], rtol=1e-6)
        np.testing.assert_allclose(bearing.damping, ROSS["oil_film"]["damping"], rtol=1e-6)
