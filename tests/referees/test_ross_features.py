"""README's table says what ROSS has: rubbing with a stiffness, PID magnetic bearings in time, their sensitivity."""

import inspect

import pytest

pytestmark = pytest.mark.slow
ross = pytest.importorskip("ross")


def test_ross_has_what_the_readme_says():
    assert "contact_stiffness" in inspect.signature(ross.Rotor.run_rubbing).parameters
    assert "disturbance_amplitude" in inspect.signature(ross.Rotor.run_amb_sensitivity).parameters
    assert {"kp_pid", "ki_pid", "kd_pid"} <= {*inspect.signature(ross.MagneticBearingElement).parameters}
