"""Motion without contact on passive bearings, and its independent integration."""

import numpy as np
from rotor_cases import OnePlane, both
from scipy.integrate import solve_ivp

from rotor_analysis.rotor_file import load_rotor

ROTOR = load_rotor()
WIDE = both("rb.clearance", 0.1)
UNBALANCE = {"d1.u": 5e-3, "d2.u": 2e-3, "d2.phi": 2.0, "d3.u": 4e-3, "d3.phi": -1.0, "d4.u": 1e-3, "d4.phi": 0.5}
COMPLEX_UNBALANCE = [5e-3, 2e-3 * np.exp(2j), 4e-3 * np.exp(-1j), 1e-3 * np.exp(0.5j)]
START = 1e-4 * np.array([1 + 0.5j, -0.3j, 0.2 + 0.1j, 0.4, -0.6 + 0.2j, 0.1 - 0.7j])
START_VELOCITY = 0.02 * np.array([0.3j, 1 - 0.2j, -0.5, 0.4 + 0.4j, -0.1j, 0.7])


def exact_motion(Omega, duration, k_b=1e6, c_b=5000.0, unbalance=COMPLEX_UNBALANCE):
    """Masters at the end, by an eighth-order method at tight tolerance on the complex model."""
    model = OnePlane.of(ROTOR, k_b, c_b)
    rotating = Omega**2 * model.unbalance(unbalance)

    def derivative(t, z):
        r, v = np.split(z, 2)
        return np.concatenate([v, model.acceleration(Omega, r, v, rotating * np.exp(1j * Omega * t))])

    start = np.concatenate([START, START_VELOCITY])
    solution = solve_ivp(derivative, (0.0, duration), start, method="DOP853", rtol=1e-12, atol=1e-15)
    return np.split(solution.y[:, -1], 2)
