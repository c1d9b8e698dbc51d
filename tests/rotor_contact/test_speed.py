"""Spin speed that changes: run-up against an independent integration, angle, rolling that follows the spin."""

import numpy as np
import pytest
from rotor_cases import BEARINGS, H, OnePlane, both, masters, place, plant, rigid_rotor
from scipy.integrate import solve_ivp

from rotor_analysis.rotor_file import load_rotor
from rotor_contact.variables.enumerations import EXACT, INTEGRATED, PIECES

ROTOR = load_rotor()
WIDE = both("rb.clearance", 0.1)


def run_up(x, Omega, Omega_dot, steps, names=(), h=H, start=0.0):
    """Feed a ramp as a master does: the speed at the beginning of each step, and its slope."""
    record = np.empty((steps, len(names)))
    x["Omega_dot"] = Omega_dot
    for n in range(steps):
        x["Omega"] = Omega + Omega_dot * n * h
        x.step(start + n * h, h)
        record[n] = [x[name] for name in names]
    return record


# Speed (rad/s) at the beginning; rates (rad/s^2) and steps of the parts that follow; error of the exact motion, which
# would be several times as large with an unbalance that is ahead or behind in each step (`piece_solution`).
RAMPS = {
    "run-up": (40.0, [(400.0, 800)], 3e-6),
    "coast-down": (150.0, [(-300.0, 800)], 3e-7),
    "backward run-up": (-40.0, [(-400.0, 800)], 3e-6),
    "braking by 2 rad/s in a step": (260.0, [(-40.0, 60), (-8000.0, 100)], 1e-5),
}


@pytest.mark.parametrize("exactly", [0, 1])
@pytest.mark.parametrize("case", RAMPS)
def test_run_through_a_critical_speed_is_the_one_of_the_complex_model(case, exactly):
    """M r'' + (C - i Omega(t) G) r' + K r = u exp(i theta) (Omega^2 - i Omega'), theta = Omega t + Omega' t^2/2."""
    Omega, parts, tolerance = RAMPS[case]
    tolerance = tolerance if exactly else 1e-8
    u, theta, time, z = 5e-3, 0.0, 0.0, np.zeros(12, dtype=complex)
    model = OnePlane.of(ROTOR, 1e6, 5000.0)
    shape = model.unbalance([u, 0, 0, 2e-3j])
    unbalance = {"d1.u": u, "d4.u": 2e-3, "d4.phi": np.pi / 2}
    x = plant(WIDE | BEARINGS | unbalance | {"solver.exact_motion": exactly, "solver.max_substep": 5e-6})
    for rate, steps in parts:

        def derivative(t, z, Omega=Omega, theta=theta, rate=rate):
            r, v = np.split(z, 2)
            speed = Omega + rate * t
            turned = np.exp(1j * (theta + Omega * t + 0.5 * rate * t**2)) * (speed**2 - 1j * rate)
            return np.concatenate([v, model.acceleration(speed, r, v, shape * turned)])

        z = solve_ivp(derivative, (0.0, steps * H), z, method="DOP853", rtol=1e-12, atol=1e-16).y[:, -1]
        run_up(x, Omega, rate, steps, start=time)
        theta += Omega * steps * H + 0.5 * rate * (steps * H) ** 2
        Omega, time = Omega + rate * steps * H, time + steps * H
    r, v = masters(x)
    np.testing.assert_allclose(r, z[:6], atol=tolerance * np.max(np.abs(z[:6])))
    np.testing.assert_allclose(v, z[6:], atol=10.0 * tolerance * np.max(np.abs(z[6:])))
    assert x["solver.method"] in ((EXACT, PIECES) if exactly else (INTEGRATED,))
    assert x["theta"] == pytest.approx(theta % (2 * np.pi), rel=1e-9)
    assert abs(x["energy.balance"]) < 0.3 * tolerance * x["energy.work"]


def test_rolling_follows_the_spin_as_it_changes():
    ring, Omega, Omega_dot = 0.05, 60.0, 100.0
    x = plant(both("rb.clearance", ring) | both("rb.mu", 2.0) | {"Omega": Omega}, rigid_rotor(20.0))
    place(x, np.full(2, ring + 0j), np.full(2, -1j * 0.025 * Omega), modes=(2, 2))
    names = ["rb1.whirl_speed", "rb1.mode", "rb1.f_t", "rb1.slip_velocity", "energy.friction", "energy.balance"]
    record = run_up(x, Omega, Omega_dot, 800, names)
    speed = Omega + Omega_dot * H * np.arange(1, 801)
    np.testing.assert_allclose(record[:, 0], -0.025 / ring * speed, rtol=1e-9)
    assert np.all(record[:, 1] == 2)
    np.testing.assert_allclose(record[:, 2], -10.0 * 0.025 * Omega_dot, rtol=1e-6)  # m t.a, a = -R_s Omega'
    np.testing.assert_allclose(record[:, 3], 0.0, atol=1e-10)
    assert record[-1, 4] == 0.0
    np.testing.assert_allclose(record[:, 5], 0.0, atol=1e-6 * x["energy.kinetic"])
