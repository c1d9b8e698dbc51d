"""README's table says what ROSS has: rubbing with a stiffness, PID magnetic bearings in time, their sensitivity."""

import inspect

import pytest

pytestmark = pytest.mark.slow


def test_ross_has_what_the_readme_says():
    ross = pytest.importorskip("ross", reason="ROSS is not installed (extra: referees)")
    assert "contact_stiffness" in inspect.signature(ross.Rotor.run_rubbing).parameters
    assert "disturbance_amplitude" in inspect.signature(ross.Rotor.run_amb_sensitivity).parameters
    assert {"kp_pid", "ki_pid", "kd_pid"} <= {*inspect.signature(ross.MagneticBearingElement).parameters}
