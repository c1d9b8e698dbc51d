"""A steady synchronous rub on a spring: its radius, and when friction makes it bounce.

A mass m in springs k and dampers c that whirls with the spin, pressed against a ring of stiffness k_c by its unbalance,
is at rest in axes that turn with Omega, at the radius R with the penetration d = R - C_r:

    (k - m Omega^2 + i Omega c + k_c (1 + i mu) d/R) R e^{i phi} = u Omega^2

There a small displacement (xi, eta) along n and t obeys M'' + D' + K = 0 with

    D = [c, -2 m Omega; 2 m Omega, c]        Coriolis
    K = [k + k_c - m Omega^2, -c Omega - mu k_c d/R; c Omega + mu k_c, k + k_c d/R - m Omega^2]

Of a stiff ring, omega_c^2 = k_c/m >> Omega^2, the bounce along n drives a motion along t by friction, -mu k_c xi, and
that comes back by Coriolis: the bounce grows with mu Omega - c/(2 m). So the steady solution is there, but a rotor that
has more friction than damping leaves it and keeps bouncing, whose mean is less than its radius: the model's truth.
"""

import math

import numpy as np
import pytest
from rotor_cases import both, place, plant, rigid_rotor
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from rotor_contact.variables.contact_laws import LAWS

pytestmark = pytest.mark.gate

M, K, K_C, C_R, OMEGA, JOURNAL = 10.0, 1e6, 1e8, 0.2e-3, 260.0, 0.025
H = 5e-5


def steady(c, mu, u):
    """Radius and phase of the steady rub."""

    def force(R):
        return (K - M * OMEGA**2 + 1j * OMEGA * c + K_C * (1.0 + 1j * mu) * (1.0 - C_R / R)) * R

    R = brentq(lambda r: abs(force(r)) - u * OMEGA**2, C_R, 1.2 * C_R, xtol=1e-18)
    return R, -np.angle(force(R))


def growth(c, mu, R):
    """Largest real part (1/s) of the eigenvalues of small motions about the steady rub."""
    share = 1.0 - C_R / R
    stiffness = [
        [K + K_C - M * OMEGA**2, -c * OMEGA - mu * K_C * share],
        [c * OMEGA + mu * K_C, K + K_C * share - M * OMEGA**2],
    ]
    damping = [[c, -2.0 * M * OMEGA], [2.0 * M * OMEGA, c]]
    A = np.block([[np.zeros((2, 2)), np.eye(2)], [-np.array(stiffness) / M, -np.array(damping) / M]])
    return float(np.linalg.eigvals(A).real.max())


def unbalance(c):
    """Unbalance (kg m) whose free orbit is 1.3 clearances."""
    return 1.3 * C_R * abs(K - M * OMEGA**2 + 1j * OMEGA * c) / OMEGA**2


def rubbing(c, mu, begin, seconds):
    """Radius over time of the plant, a mass of 10 kg at each site; `begin` is its first position and velocity."""
    u = unbalance(c)
    values = both("rb.law", LAWS.index("linear")) | both("rb.k_c", K_C) | both("rb.clearance", C_R)
    values |= both("rb.mu", mu) | both("rb.journal_radius", JOURNAL) | both("mb.k_b", K) | both("mb.c_b", c)
    x = plant(values | {"Omega": OMEGA, "d1.u": u, "d4.u": u, "solver.max_substep": 2e-5}, rigid_rotor(2.0 * M))
    place(x, np.full(2, begin[0]), np.full(2, begin[1]), modes=(1, 1))
    radius = np.empty((round(seconds / H), 2))
    for n in range(len(radius)):
        x.step(n * H, H)
        radius[n] = [math.hypot(x[f"{site}.x"], x[f"{site}.y"]) for site in ("rb1", "rb2")]
    np.testing.assert_allclose(radius[:, 0], radius[:, 1], rtol=1e-6)
    return radius[:, 0]


def start_beside(c, mu, offset):
    """A start that is off the steady rub along n by a share of the penetration."""
    R, phase = steady(c, mu, unbalance(c))
    r = (R + offset * (R - C_R)) * np.exp(1j * phase)
    return R, (r, 1j * OMEGA * r)


@pytest.mark.parametrize(("c", "mu"), [(2000.0, 0.1), (500.0, 0.02), (500.0, 0.3), (100.0, 0.2)])
def test_small_bounces_grow_or_decay_with_friction_and_damping(c, mu):
    R, begin = start_beside(c, mu, 1e-3)
    expected, seconds = growth(c, mu, R), 0.06
    bounce = np.abs(rubbing(c, mu, begin, seconds) - R)
    early, late = (bounce[part].max() for part in np.array_split(np.arange(len(bounce)), 3)[::2])
    assert math.log(late / early) / (2.0 * seconds / 3.0) == pytest.approx(expected, abs=4.0)
    assert expected == pytest.approx(mu * OMEGA - c / (2.0 * M), abs=8.0)


def test_with_enough_damping_the_rub_is_steady_at_its_closed_form():
    R, begin = start_beside(2000.0, 0.1, 0.3)
    assert rubbing(2000.0, 0.1, begin, 0.2)[-100:] == pytest.approx(R, rel=1e-6)


def integrated(c, mu, begin, seconds):
    """Radius over time of the same mass, by an eighth-order integration independent of the plant."""
    u = unbalance(c)

    def rate(t, y):
        r, v = complex(y[0], y[1]), complex(y[2], y[3])
        n = r / abs(r)
        N = K_C * max(abs(r) - C_R, 0.0)
        slip = OMEGA * JOURNAL + (v / n).imag
        T = -mu * N * math.tanh(slip / 0.01)
        a = (u * OMEGA**2 * np.exp(1j * OMEGA * t) - K * r - c * v - N * n + T * 1j * n) / M
        return [v.real, v.imag, a.real, a.imag]

    times = H * np.arange(1, round(seconds / H) + 1)
    start = [begin[0].real, begin[0].imag, begin[1].real, begin[1].imag]
    result = solve_ivp(rate, (0.0, seconds), start, "DOP853", times, rtol=1e-9, atol=1e-14, max_step=H)
    return np.hypot(result.y[0], result.y[1])


@pytest.mark.slow
def test_rub_with_friction_keeps_bouncing_inside_the_steady_radius():
    c, mu, seconds = 500.0, 0.12, 0.6  # with 100 N s/m and 0.2 the bounces end in backward whirl
    R, begin = start_beside(c, mu, 0.3)
    simulated, integrated_radius = rubbing(c, mu, begin, seconds), integrated(c, mu, begin, seconds)
    np.testing.assert_allclose(simulated[:400], integrated_radius[:400], atol=1e-3 * (R - C_R))
    settled = slice(len(simulated) // 2, None)
    assert np.ptp(simulated[settled]) > 0.1 * (R - C_R)
    assert simulated[settled].mean() < R
    assert simulated[settled].mean() == pytest.approx(integrated_radius[settled].mean(), rel=0.01)
