"""H-infinity control of the compressor: the least peak of all four blocks of sensitivity, on the sampled linear model.

    min_K || [1; K] (1 - G K)^-1 [1, G] ||,  G = plant times gain

Its optimum needs two Riccati equations and no search: D. C. McFarlane and K. Glover, A loop shaping design procedure
using H-infinity synthesis, IEEE Trans. Automatic Control 37 (1992) 759-769. G is the plant with held currents, in the
plane w = (2/T) (z - 1)/(z + 1), from which Tustin's method leads back to z: norm and stability are those of the sampled
loop. python-control's `mixsyn` would need slycot.
"""

from __future__ import annotations

import control
import numpy as np
from lqg import AXES, DEMANDS, SAMPLE_TIME, SCENARIO
from scipy.linalg import matrix_balance, solve_continuous_are

import amb_cosim

GAIN = 4e4  # A/m, where sensitivity to displacements and to currents count the same
SUBOPTIMAL = 1.1  # of the least norm


def h_infinity(scenario=SCENARIO):
    """Return the controller u = gain K y, and the norm that it reaches."""
    demands, shown = [f"amb_actuator.{name}" for name in DEMANDS], [f"rotor_contact.{name}" for name in AXES]
    machine = ["rotor_contact", "amb_actuator"]
    plant = amb_cosim.linearise(scenario, inputs=demands, outputs=shown, components=machine)
    A, B, C, D = in_w(*control.ssdata(control.sample_system(plant, SAMPLE_TIME, "zoh"))[:3], SAMPLE_TIME)
    B, D = GAIN * B, GAIN * D
    S, R = np.linalg.inv(np.eye(len(D.T)) + D.T @ D), np.linalg.inv(np.eye(len(D)) + D @ D.T)
    free = A - B @ S @ D.T @ C
    X = solve_continuous_are(free, B, C.T @ R @ C, np.linalg.inv(S))
    Z = solve_continuous_are(free.T, C.T, B @ S @ B.T, np.linalg.inv(R))
    norm = SUBOPTIMAL * np.sqrt(1.0 + np.linalg.eigvals(X @ Z).real.max())
    F = -S @ (D.T @ C + B.T @ X)
    L = norm**2 * np.linalg.solve(((1.0 - norm**2) * np.eye(len(A)) + X @ Z).T, Z @ C.T)
    law = control.ss(A + B @ F + L @ (C + D @ F), L, GAIN * B.T @ X, -GAIN * D.T)
    controller = amb_cosim.linear_controller(law, AXES, DEMANDS, SAMPLE_TIME, limits=(-6.5, 5.0))
    return controller, float(norm)


def in_w(A, B, C, T):
    """Return a sampled system without direct term in the plane of w, its states scaled to like sizes."""
    scale = matrix_balance(A, permute=False, separate=True)[1][0]
    A, B, C = A * scale / scale[:, None], B / scale[:, None], C * scale
    half = np.linalg.inv(np.eye(len(A)) + A)
    return 2.0 / T * half @ (A - np.eye(len(A))), half @ B, 4.0 / T * C @ half, -C @ half @ B


if __name__ == "__main__":
    controller, norm = h_infinity()
    print(controller.save("h_infinity.npz"), f"norm {norm:.2f}")
