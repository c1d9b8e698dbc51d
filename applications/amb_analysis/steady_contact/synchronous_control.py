"""A rotor under converged synchronous control, whose steady currents minimise the sensor readings.

Synchronous control such as ROLAC adapts its currents by I' = alpha H y until H y = 0. Here, H = -(Y^H W Y)^-1 Y^H W,
and Y is the receptance from injected currents to the readings y. With y = Y_F F + Y_u u Omega^2 + Y I, the control
converges to

    I = H (Y_F F + Y_u u Omega^2)                                                                     (1)

This control therefore changes only the rotor's receptances, so the states are computed in the same way as without it.
About a state in contact, the readings respond by dy = J dI, where J is the real Jacobian under the constraints. The
state is stable if all eigenvalues of H J have negative real parts. H comes from the linear model, with unit weights.
Force limits are not modelled, so compare the computed currents with the limits of the bearings.
"""

from __future__ import annotations

import numpy as np

from amb_analysis.steady_contact.forward_loop import Complex
from amb_analysis.steady_contact.receptances import Receptances
from amb_analysis.steady_contact.synchronous_states import States
from array_types import Array

CANCELLED = 1e-9  # receptance, over that of the feedback alone, that is rounding of zero: the control cancels it


def adaptation(at: Receptances) -> Complex:
    """Return H = -(Y^H Y)^-1 Y^H (A/m), shape (n_bearings, n_readings)."""
    return np.asarray(-np.linalg.pinv(at.readings[2]))


def settled(at: Receptances) -> Receptances:
    """Return the receptances of a rotor whose synchronous control has converged (1)."""
    Y_F, Y_u, Y = at.readings
    R_i, P_i, S_i = at.currents
    H = adaptation(at)
    by_force, by_unbalance = H @ Y_F, H @ Y_u
    readings = Y_F + Y @ by_force, Y_u + Y @ by_unbalance, Y
    currents = R_i + S_i @ by_force, P_i + S_i @ by_unbalance, S_i
    R = at.R + at.S @ by_force
    R[np.abs(R) < CANCELLED * np.abs(at.R).max()] = 0.0
    return Receptances(at.Omega, R, at.P + at.S @ by_unbalance, at.S, readings, currents)


def adaptation_rates(at: Receptances, states: States, n: int, c: Array, mu: Array) -> Complex:
    """Return the eigenvalues of H J about a state; multiplied by alpha, they are its growth rates (1/s).

    With the forces (1) of `stability`, the equations a = 0 and d q = S dI + R dF give dF as a function of dI.

    Parameters
    ----------
    at
        Receptances with the feedback alone.
    states, n
        States, and the index of one state among them.
    c, mu
        Clearances (m) and friction coefficients of all sites.
    """
    contact, H = list(states.contact), adaptation(at)
    b, m = at.S.shape[1], len(contact)
    turn = np.exp(1j * states.psi[n])
    S, R = at.S[contact] / turn[:, None], at.R[np.ix_(contact, contact)] * turn / turn[:, None]
    moved = np.hstack([S, 1j * S])  # over the real and the imaginary parts of currents
    stiffness = (1.0 + mu[contact] ** 2) * states.N[n] / c[contact]
    # a + i b = moved dI - R ((1 + i mu) lambda + i stiffness b), a = 0: unknown lambda and b
    by_lambda, by_b = R * (1.0 + 1j * mu[contact]), R * (1j * stiffness)
    left = np.block([[by_lambda.real, by_b.real], [by_lambda.imag, by_b.imag + np.eye(m)]])
    unknown = np.linalg.solve(left, np.vstack([moved.real, moved.imag]))
    dF = -((1.0 + 1j * mu[contact])[:, None] * unknown[:m] + (1j * stiffness)[:, None] * unknown[m:])
    Y_F, _, Y = at.readings
    rates = H @ (np.hstack([Y, 1j * Y]) + (Y_F[:, contact] * turn) @ dF)
    return np.asarray(np.linalg.eigvals(np.vstack([rates.real, rates.imag])).reshape(2 * b))
