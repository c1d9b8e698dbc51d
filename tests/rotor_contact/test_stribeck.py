"""Friction that falls with the slip velocity: limits, energy, order of convergence, and a stick-slip oscillator."""

import math

import numpy as np
import pytest
from rotor_cases import UNWATCHED, H, both, masters, place, plant, rigid_rotor, run
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from rotor_contact.variables.contact_laws import LAWS

RING, JOURNAL, MASS = 0.05, 0.025, 10.0  # clearance and journal radius (m), mass at each of two sites (kg)
MU, MU_STATIC, V_S = 0.1, 0.3, 0.1
STRIBECK = both("rb.mu", MU) | both("rb.mu_static", MU_STATIC) | both("rb.stribeck_velocity", V_S)


def mu_of(slip):
    """The Stribeck curve, written down again from its formula."""
    return MU + (MU_STATIC - MU) * np.exp(-((slip / V_S) ** 2))


def sliding_in_ring(whirl_velocity, Omega=0.0, values=STRIBECK):
    """A rigid rotor that slides in its ring, with equal motion at both ends."""
    x = plant(both("rb.clearance", RING) | values | {"Omega": Omega}, rigid_rotor(2.0 * MASS))
    sign = math.copysign(1.0, Omega * JOURNAL + whirl_velocity)
    return place(x, np.full(2, RING + 0j), np.full(2, 1j * whirl_velocity), modes=(1, 1), signs=(sign, sign))


@pytest.mark.parametrize(("velocity", "mu"), [(1e-4 * V_S, MU_STATIC), (20.0 * V_S, MU), (-20.0 * V_S, MU)])
def test_friction_is_static_at_creeping_slip_and_kinetic_at_fast_slip(velocity, mu):
    x = sliding_in_ring(velocity)
    x.step(0.0, 1e-9)
    assert x["rb1.f_t"] / x["rb1.f_n"] == pytest.approx(-math.copysign(mu, velocity), rel=1e-7)


def slowed_whirl(velocity, Omega, duration):
    """Whirl velocity from dv/dt = -sign(slip) mu(slip) v^2/c, integrated independently."""

    def derivative(_, v):
        slip = Omega * JOURNAL + v
        return -np.sign(slip) * mu_of(slip) * v**2 / RING

    return solve_ivp(derivative, (0.0, duration), [velocity], method="DOP853", rtol=1e-12, atol=1e-14).y[0, -1]


@pytest.mark.parametrize(("velocity", "Omega"), [(1.0, -36.0), (1.0, 36.0), (-1.0, 36.0), (2.0, 0.0)])
def test_whirl_in_the_ring_decelerates_by_its_scalar_equation(velocity, Omega):
    x = sliding_in_ring(velocity, Omega)
    run(x, 80)
    expected = slowed_whirl(velocity, Omega, 80 * H)
    assert x["rb1.whirl_speed"] * RING == pytest.approx(expected, rel=1e-8)
    assert x["rb1.mode"] == 1


def test_high_static_friction_ends_slow_slip_in_rolling():
    """mu = 0: at this slip mu(v) is up to mu_s all the same. The whirl ends at v = -R_s Omega."""
    x = sliding_in_ring(-0.48, 0.5 / JOURNAL, STRIBECK | both("rb.mu", 0.0))
    run(x, 80)
    assert x["rb1.mode"] == 2
    assert x["rb1.whirl_speed"] * RING == pytest.approx(-0.5, rel=1e-9)


def test_sliding_with_stribeck_friction_converges_with_fourth_order():
    h, steps, velocity, Omega = 1e-3, 16, 1.0, -36.0  # slip from 0.1 m/s upward or downward, on the slope of the curve
    expected = slowed_whirl(velocity, Omega, steps * h)
    errors = []
    for parts in (1, 2, 4):
        fixed = {"solver.max_substep": h / parts, "solver.tolerance": 1.0, "solver.exact_motion": 0.0}
        x = sliding_in_ring(velocity, Omega, STRIBECK | fixed)
        run(x, steps, h=h)
        errors.append(abs(x["rb1.whirl_speed"] * RING - expected))
    order = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    assert np.all(order > 3.5)


def froude_pendulum(load, surface, duration):
    """Stick-slip of a mass in a ring, pressed outward by `load` (N) and driven by a surface with velocity `surface`.

    m c phi'' = -F sin phi + T and N = m c phi'^2 + F cos phi, with slip v = surface + c phi'. Phases of slip are
    integrated to the event v = 0; a phase of stick has phi' = -surface/c and ends where |T| = F |sin phi| = mu_s N.
    Returns the times at which stick ends and begins, and phi as a function of time.
    """

    def normal(phi, rate):
        return MASS * RING * rate**2 + load * np.cos(phi)

    def slipping(_, y):
        phi, rate = y
        slip = surface + RING * rate
        return [rate, (-load * np.sin(phi) - mu_of(slip) * normal(phi, rate)) / (MASS * RING)]

    def slip_vanishes(_, y):
        return surface + RING * y[1]

    slip_vanishes.terminal = True
    slip_vanishes.direction = -1.0

    def excess(phi):
        return abs(load * math.sin(phi)) - MU_STATIC * normal(phi, surface / RING)

    t, y, switches, pieces = 0.0, [0.0, 0.0], [], []
    while t < duration:
        s = solve_ivp(
            slipping, (t, duration), y, method="DOP853", rtol=1e-12, atol=1e-14, events=slip_vanishes, dense_output=True
        )
        pieces.append((t, s.sol))
        t, y = s.t[-1], [s.y[0, -1], -surface / RING]
        if t >= duration:
            break
        limit = brentq(excess, -1.0, 0.0) if excess(y[0]) < 0.0 else y[0]
        begin, phi = t, y[0]
        pieces.append((t, lambda time, begin=begin, phi=phi: np.array([phi - surface / RING * (time - begin), np.nan])))
        t, y = t + (y[0] - limit) * RING / surface, [limit, -surface / RING]
        switches += [begin, t]

    def angle(time):
        return [piece for piece in pieces if piece[0] <= time][-1][1](time)[0]

    return np.array(switches), angle


def test_stick_slip_oscillation_matches_an_independent_model():
    load, surface, steps = 900.0, 0.1, 4000
    x = plant(
        both("rb.clearance", RING) | STRIBECK | both("mb.f_x", load) | {"Omega": surface / JOURNAL},
        rigid_rotor(2.0 * MASS),
    )
    place(x, np.full(2, RING + 0j), np.zeros(2), modes=(1, 1))
    switches, angle = froude_pendulum(load, surface, steps * H)
    assert len(switches) >= 6
    phi, mode = np.empty(steps), np.empty(steps)
    for n in range(steps):
        x.step(n * H, H)
        phi[n], mode[n] = np.angle(masters(x)[0][0]), x["rb1.mode"]
    times = H * np.arange(1, steps + 1)
    np.testing.assert_allclose(phi, [angle(t) for t in times], atol=2e-6 * np.max(np.abs(phi)))
    changed = times[np.flatnonzero(np.diff(mode)) + 1]
    within = switches[switches < times[-1]]
    assert len(changed) == len(within)
    assert np.all((changed - within >= -1e-9) & (changed - within <= H + 1e-9))
    assert abs(x["energy.balance"]) < 1e-6 * x["energy.work"]


def test_compliant_contact_has_the_same_coefficient_of_friction():
    """Far above the velocity scale of its tanh, 0.01 m/s, where only the Stribeck curve is left."""
    x = sliding_in_ring(0.8 * V_S, values=STRIBECK | UNWATCHED | both("rb.law", LAWS.index("linear")))
    place(x, np.full(2, RING + 1e-5 + 0j), np.full(2, 0.8j * V_S), modes=(1, 1))
    x.step(0.0, 1e-9)
    assert x["rb1.f_t"] / x["rb1.f_n"] == pytest.approx(-mu_of(0.8 * V_S), rel=1e-6)
