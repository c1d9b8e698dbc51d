"""Damping that the loop takes from modes of the casing, against an independent calculation.

The reference has its own finite elements and its own sampled loop of the expander in `expander`, at 42,000 rpm: the
change of damping of a casing mode times its modal mass, over the mass of the rotor. It is computed without a casing and
agrees with the poles of rotor and casing within 3 % where a mode is heavy.
"""

from pathlib import Path

import numpy as np
import pytest

from amb_analysis.machine.casing_damping import damping_taken
from amb_analysis.machine.machine import machine_of
from amb_analysis.studies.stability_margin import CasingDamping, casing_damping
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.scenario import as_scenario

HERTZ = [3.0, 27.0, 51.0, 99.0, 195.0, 291.0, 387.0, 575.0, 1055.0, 1535.0]
GAINED = {  # m Delta zeta over the rotor's mass, by the motion of sensors and seals over that of the magnets
    1.0: [8e-05, 0.06741, 0.327232, 0.423005, 0.2137, 0.135415, 0.09565, 0.055097, 0.016384, 0.004239],
    0.0: [6.02896, -0.410413, -0.861305, -0.339811, -0.046461, -0.013303, -0.005301, -0.001364, -0.000108, -1.2e-05],
    -0.3: [10.2223, -0.374947, -1.0886, -0.534839, -0.118017, -0.054631, -0.033371, -0.016934, -0.004355, -0.000816],
}


@pytest.fixture(scope="module")
def machine():
    return machine_of(prepare_run(as_scenario(Path(__file__).parent / "expander" / "levitation.toml")))


@pytest.mark.parametrize("others", GAINED)
def test_the_damping_of_a_mode_is_that_of_an_independent_loop(machine, others):
    expected = -np.array(GAINED[others])
    result = damping_taken(machine, np.array(HERTZ), others) / machine.rotor.mass
    assert result == pytest.approx(expected, rel=0.01, abs=2e-6)


def test_the_worst_frequency_and_product_are_named(machine):
    """0.863 of 6.717 kg at 53 Hz, if only the magnets move; a casing that moves as a whole is damped up to 1.9 kHz."""
    result = casing_damping(machine)
    needed, at = result.worst("only the magnets move")
    assert (needed, at) == (pytest.approx(0.86324 * 6.7168, rel=0.01), pytest.approx(53.0, abs=1.0))
    assert all(result.needed["all planes move alike"][result.frequencies < 1900.0] < 0.0)
    assert "5.8 kg at 53 Hz" in result.conclusion


def test_nothing_is_needed_where_the_loop_damps():
    result = CasingDamping(np.array([5.0, 50.0]), {"a shape": np.array([-1.0, -2.0])})
    assert "nothing if a shape" in result.conclusion
    assert result.rows == [("10", "none"), ("20", "none"), ("50", "none")]


def test_motion_along_the_shaft_takes_no_part():
    """A rotor on five axes has this motion as its last coordinate; its bearings damp a casing that moves as a whole."""
    machine = machine_of(prepare_run(as_scenario("turbo_pump_levitation")))
    assert (damping_taken(machine, np.array([30.0, 300.0]), 1.0) < 0.0).all()
