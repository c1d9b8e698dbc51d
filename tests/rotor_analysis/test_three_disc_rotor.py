"""The rotor with three discs of M. Lalanne and G. Ferraris, Rotordynamics Prediction in Engineering, Wiley 1998.

Its numbers are quoted from memory, and were not compared with the book.
"""

import numpy as np
import pytest

from amb_cosim import studies
from rotor_analysis.rotor_file import rotor_from

RPM = np.pi / 30.0
FREQUENCIES = (55.41, 67.21, 157.9, 193.7, 249.9, 407.6, 446.6, 622.7)  # Hz at 25,000 1/min
CRITICAL_SPEEDS = (3620.0, 3798.0, 10018.0, 11279.0, 16785.0, 24409.0)  # 1/min
DISCS = ((0.2, 14.580, 0.06463, 0.12319), (0.5, 45.945, 0.49763, 0.97634), (1.0, 55.134, 0.60243, 1.1716))


@pytest.fixture(scope="module")
def rotor():
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


def test_frequencies_of_three_discs_are_those_of_the_book(rotor):
    (at_speed,) = studies.modes(rotor, speeds=[25000.0 * RPM], count=8).frequencies.speeds.values()
    np.testing.assert_allclose(np.array(at_speed.frequencies) / (2.0 * np.pi), FREQUENCIES, rtol=1e-3)


def test_critical_speeds_of_three_discs_are_those_of_the_book(rotor):
    result = studies.campbell(rotor, up_to=25000.0 * RPM)
    np.testing.assert_allclose([row.speed / RPM for row in result.critical_speeds], CRITICAL_SPEEDS, rtol=1e-3)
