"""The study of classical contact laws: closed forms of an impact, energy, agreement with the plant, bad input."""

import math

import numpy as np
import pytest
from rotor_cases import both, masters, place, plant, rigid_rotor
from slow import slow_but_first

from amb_cosim import studies
from bath_thesis.studies.contact_hysteresis import AS_PRINTED, ContactLaws
from rotor_contact.variables.contact_laws import LAWS

MASS, SPEED, K = 10.0, 0.2, 1e8


@pytest.fixture(scope="module")
def result() -> ContactLaws:
    return studies.contact_laws(speed=SPEED, mass=MASS, k_c=K)


def test_depths_of_spring_and_hertz_contact_match_closed_forms(result):
    """v sqrt(m/k), and (5 m v^2/(4 K))^(2/5) with K = k_c/sqrt(delta_c)."""
    assert result.laws["linear"].deepest == pytest.approx(SPEED * math.sqrt(MASS / K), rel=1e-4)
    hertz = (5.0 * MASS * SPEED**2 * math.sqrt(result.delta_c) / (4.0 * K)) ** 0.4
    assert result.laws["hertz"].deepest == pytest.approx(hertz, rel=1e-4)
    assert [result.laws[name].restitution for name in ("linear", "hertz")] == pytest.approx([1.0, 1.0])


def test_area_of_a_loop_is_the_kinetic_energy_lost(result):
    kinetic = 0.5 * MASS * SPEED**2
    for loop in result.laws.values():
        assert loop.enclosed == pytest.approx(loop.loss, abs=2e-3 * kinetic)


def test_damped_laws_have_the_restitution_that_they_are_tuned_to(result):
    matches = {name: loop.restitution for name, loop in result.laws.items()}
    assert matches["kelvin_voigt"] == pytest.approx(0.7, rel=1e-5)
    assert matches["ulbrich"] == pytest.approx(0.7, rel=0.01)
    light = studies.contact_laws(restitution=0.95).laws["hunt_crossley"]
    assert light.restitution == pytest.approx(0.95, abs=0.003)  # (4.7) is its first order


def test_printed_law_jumps_at_the_touch_and_pulls_at_the_end(result):
    """Points A and B of Fig. 4.1: c_c v, and -c_c v exp(-pi zeta/sqrt(1 - zeta^2)) when delta = 0 again."""
    printed = result.laws[AS_PRINTED]
    zeta = result.c_c / (2.0 * math.sqrt(K * MASS))
    leaving = math.exp(-math.pi * zeta / math.sqrt(1.0 - zeta**2))
    assert printed.force_at_touch == pytest.approx(result.c_c * SPEED)
    assert printed.smallest_force == pytest.approx(-result.c_c * SPEED * leaving, rel=1e-5)
    others = [loop for name, loop in result.laws.items() if name != AS_PRINTED]
    assert min(loop.smallest_force for loop in others) == 0.0


@pytest.mark.parametrize(
    "law", slow_but_first(["kelvin_voigt", "kirk", "hunt_crossley", "ulbrich", "switched_kelvin_voigt"])
)
def test_impact_agrees_with_the_plant(result, law):
    ring, h = 0.05, 2e-6
    settings = {"law": LAWS.index(law), "clearance": ring, "k_c": K, "c_c": result.c_c, "delta_c": result.delta_c}
    settings |= {"alpha_c": result.alpha_c, "eta": result.eta}
    values = {name: value for key, v in settings.items() for name, value in both(f"rb.{key}", v).items()}
    rotor = plant(values | {"solver.max_substep": 1e-6}, rigid_rotor(2.0 * MASS))
    place(rotor, np.full(2, ring - 1e-9 + 0j), np.full(2, SPEED + 0j))
    forces, gaps = [], []
    for n in range(1000):
        rotor.step(n * h, h)
        forces.append(rotor["rb1.f_n"])
        gaps.append(rotor["rb1.gap"])
    loop = result.laws[law]
    assert max(forces) == pytest.approx(loop.largest_force, rel=1e-3)
    assert -min(gaps) == pytest.approx(loop.deepest, rel=1e-4)
    assert -masters(rotor)[1][0].real / SPEED == pytest.approx(loop.restitution, rel=1e-4)
