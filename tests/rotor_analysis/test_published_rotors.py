"""Rotors of the literature: eigenvalues and unbalance response against ROSS, frequencies against printed ones.

Both programs use the same elements, those of Nelson and McVaugh without shear deformation and of Nelson with it, and
differ by rounding alone. `python tools/ross/published_rotors.py` renews ROSS's numbers.
"""

import json
from dataclasses import replace

import numpy as np
import pytest
from ross_numbers import REFERENCE, complex_numbers, difference

from amb_cosim import studies
from rotor_analysis.assembly import assemble, on_bearings
from rotor_analysis.rotor_file import load_rotor, rotor_from
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


FREQUENCIES = (55.41, 67.21, 157.9, 193.7, 249.9, 407.6, 446.6, 622.7)  # Hz at 25,000 1/min
CRITICAL_SPEEDS = (3620.0, 3798.0, 10018.0, 11279.0, 16785.0, 24409.0)  # 1/min
DISCS = ((0.2, 14.580, 0.06463, 0.12319), (0.5, 45.945, 0.49763, 0.97634), (1.0, 55.134, 0.60243, 1.1716))


@pytest.fixture(scope="module")
def three_discs():
    """The rotor of M. Lalanne and G. Ferraris, Rotordynamics Prediction in Engineering, Wiley 1998.

    Its numbers are quoted from memory, and were not compared with the book.
    """
    names = ("z", "mass", "diametral_inertia", "polar_inertia")
    support = {"stiffness": [[5e7, 0.0], [0.0, 7e7]], "damping": [[5e2, 0.0], [0.0, 7e2]]}
    return rotor_from(
        {
            "name": "three discs",
            "shaft": {
                "nodes": [round(0.1 * k, 1) for k in range(14)],
                "diameter": 0.1,
                "youngs_modulus": 2e11,
                "density": 7800.0,
                "poissons_ratio": 0.3,
                "mass_matrix": "consistent",
            },
            "bodies": [{"name": f"d{k}", **dict(zip(names, disc, strict=True))} for k, disc in enumerate(DISCS, 1)],
            "bearings": [{"name": name, "z": z, **support} for name, z in (("left", 0.0), ("right", 1.3))],
        },
        "three discs",
    )


def test_frequencies_of_three_discs_match_the_book(three_discs):
    (at_speed,) = studies.modes(three_discs, speeds=[25000.0 * RPM], count=8).frequencies.speeds.values()
    np.testing.assert_allclose(np.array(at_speed.frequencies) / (2.0 * np.pi), FREQUENCIES, rtol=1e-3)


def test_critical_speeds_of_three_discs_match_the_book(three_discs):
    result = studies.campbell(three_discs, up_to=25000.0 * RPM)
    np.testing.assert_allclose([row.speed / RPM for row in result.critical_speeds], CRITICAL_SPEEDS, rtol=1e-3)
