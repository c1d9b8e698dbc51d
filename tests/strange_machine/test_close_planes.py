"""A gland close to the labyrinth: planes so close have modes too fast for the series of a step, but not for pieces."""

import numpy as np
import pytest
from instances import initialised
from rotor_cases import run
from strange_machine import RUB

from amb_cosim.model_constants import plant_data
from rotor_analysis.rotor_file import load_rotor
from rotor_contact.variables.enumerations import EXACT, NO_MATRICES, PIECES

SITES = ("catch_n", "catch_s", "labyrinth", "shroud")
ORBITS = [f"{site}.{axis}" for site in SITES for axis in "xy"]
N_ORBITS = len(ORBITS)
WATCHED = [*ORBITS, *(f"{site}.f_n" for site in SITES), "solver.method"]
CLEARANCE = 0.1e-3
STEP = 50e-6
SPEED = 900.0  # rad/s


@pytest.fixture(scope="module")
def rotor(tmp_path_factory):
    text = (RUB.parent / "expander.toml").read_text(encoding="utf-8")
    apart, close = 'name = "gland"\nz = 0.06', 'name = "gland"\nz = 0.065'
    assert apart in text
    path = tmp_path_factory.mktemp("close") / "expander.toml"
    path.write_text(text.replace(apart, close), encoding="utf-8")
    return load_rotor(path)


def recorded(rotor, steps, **values):
    return run(initialised(*plant_data.plant(rotor), {"Omega": SPEED} | values), steps, WATCHED, STEP)


def test_a_machine_with_close_planes_flies_exactly_at_constant_speed(rotor):
    ours = recorded(rotor, 400, **{"turbine.u": 2e-7})
    integrated = recorded(rotor, 400, **{"turbine.u": 2e-7, "solver.exact_motion": 0})
    size = np.abs(integrated[:, :N_ORBITS]).max()
    assert size < 0.9 * CLEARANCE
    np.testing.assert_allclose(ours[:, :N_ORBITS], integrated[:, :N_ORBITS], atol=1e-6 * size)
    assert ours[0, -1] == NO_MATRICES
    assert set(ours[1:, -1]) == {EXACT}


def test_a_machine_with_close_planes_rubs_exactly_at_constant_speed(rotor):
    """Forces right after impacts, while fast modes ring, differ by up to 1e-2 of the peak."""
    values = {"turbine.u": 6e-5, "gravity": 9.81}
    ours, integrated = recorded(rotor, 400, **values), recorded(rotor, 400, **values, **{"solver.exact_motion": 0})
    forces = slice(N_ORBITS, N_ORBITS + len(SITES))
    peak = integrated[:, forces].max()
    assert peak > 100.0
    np.testing.assert_allclose(ours[:, :N_ORBITS], integrated[:, :N_ORBITS], atol=5e-4 * CLEARANCE)
    np.testing.assert_allclose(ours[:, forces], integrated[:, forces], atol=1e-2 * peak)
    assert np.mean(np.isin(ours[40:, -1], (EXACT, PIECES))) > 0.5
