"""Heat of rotating damping in a levitated rotor whose speed changes, against an integration in substeps of 2 us.

The speed of a slow ramp and a constant speed give the same heat. Steps at a constant speed and pieces of a ramp compute
it with different matrices. The shaft's damping turns with it, and the bending modes vibrate within a step.
"""

import numpy as np
import pytest

import amb_cosim

SCENARIO = amb_cosim.Scenario.load("compressor_levitated")
SPEED = 9000.0 * np.pi / 30.0
END = 0.15  # s
TERMS = ("kinetic", "strain", "damping", "work")


def energies(gain, **settings):
    """Each term (J) at the end, and the largest error of the balance, with a spin that accelerates (rad/s^2)."""
    scenario = SCENARIO.changed(speed=[{"time": END, "Omega": SPEED + END * gain}]) if gain else SCENARIO
    data = amb_cosim.run(scenario, until=f"{END} s", set=settings).dataset
    terms = [float(data[f"rotor_contact.energy.{term}"][-1]) for term in TERMS]
    return np.array(terms), float(np.abs(data["rotor_contact.energy.balance"]).max())


@pytest.mark.parametrize("gain", [0.0, 1e-6, 30.0, 300.0])
def test_each_energy_of_a_levitated_rotor_is_that_of_its_integration(gain):
    exact, balance = energies(gain)
    fine = {"rotor_contact.solver.exact_motion": False, "rotor_contact.solver.max_substep": "2 us"}
    integrated, _ = energies(gain, **fine)
    np.testing.assert_allclose(exact, integrated, rtol=1e-5, atol=1e-5 * integrated[TERMS.index("damping")])
    assert balance < 1e-3 * exact[TERMS.index("damping")]  # a heat that is wrong by a hundredth fails here, too
