"""A fall under every contact law: the same whether a step is exact or integrated, and with a quarter of its length.

So are the heat of each kind and the work of all inputs, which the energy balance compares only in sum.
"""

import numpy as np
import pytest
from rotor_cases import CLEARANCE, H, both, plant, run

from rotor_analysis.rotor_file import load_rotor
from rotor_contact.variables.contact_laws import LAWS

ELASTIC = load_rotor("bath_rig")
# One blow of each end, or three of rigid ones. Each multiplies the error of matrices between speeds, 1e-8 clearances.
STEPS = 82
FALL = {"solver.tolerance": 1e-8, "gravity": 9.81, "Omega": 260.0, "d1.u": 5e-4} | both("rb.mu", 0.12)
FALL |= both("rb.k_c", 1e8) | both("rb.c_c", 1e4) | both("rb.alpha_c", 1.0) | both("rb.eta", 0.2)
RACES = both("rb.race_inertia", 2.5e-4) | both("rb.race_drag", 0.02)
MOUNTS = both("rb.housing_mass", 3.0) | both("rb.mount_stiffness_x", 1e7) | both("rb.mount_damping_x", 1e4)
MOUNTS |= both("rb.mount_stiffness_y", 2e7) | both("rb.mount_damping_y", 1e4)
LOADS = {"base.a_x": 4.0, "base.a_y": -7.0, "mb1.f_x": 80.0, "mb2.f_y": -50.0, "mb2.k_xx": 3e5, "rb1.offset_x": 1e-4}
LOADS |= {"drive.torque": 4.0, "drive.gain": 2.0, "drive.torque_limit": 20.0, "spin.drag": 0.02}
CASES = {
    "given speed": {},
    "free spin": {"spin.free": 1.0},
    "free spin, races, mounts, loads": {"spin.free": 1.0} | RACES | MOUNTS | LOADS,
}
ORBITS = [f"mb{k}.{axis}" for k in (1, 2) for axis in "xy"]
ENERGIES = [f"energy.{name}" for name in ("balance", "dissipated", "damping", "friction", "impact", "work")]
ENERGIES += ["rb1.heat", "rb2.heat"]
PEAKS = ["rb1.f_n_peak", "rb2.f_n_peak"]
INTEGRATED = {"solver.exact_motion": 0.0, "solver.max_substep": 7.5e-6}


def fall(values, parts=1):
    """Orbits (m) and energies (J) at the ends of the steps, and the largest force (N); `parts` steps for one of H.

    The energy balance must close.
    """
    record = run(plant(FALL | values, ELASTIC), STEPS * parts, ORBITS + PEAKS + ENERGIES, H / parts)
    assert np.max(np.abs(record[:, 6])) < 2e-6 * record[-1, 7]
    return record[parts - 1 :: parts, :4], record[parts - 1 :: parts, 7:], np.max(record[:, 4:6])


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("law", LAWS)
def test_no_force_is_lost_in_the_step_in_which_contact_begins(law, case):
    values = CASES[case] | both("rb.law", LAWS.index(law))
    orbits, energies, peak = fall(values)
    assert peak > 1000.0
    for other, heat, force in (fall(values | INTEGRATED), fall(values, parts=4)):
        np.testing.assert_allclose(orbits, other, rtol=0.0, atol=1e-6 * CLEARANCE)
        np.testing.assert_allclose(energies, heat, rtol=0.0, atol=1e-5 * energies[-1, 0])
        assert peak == pytest.approx(force, rel=1e-3)
