"""Synchronous response of a levitated rotor: complex receptances of its sampled loop.

Forces F exp(i Omega t) at the sites, unbalance u, and currents I injected at the bearings give, in the rotating frame,

    q = R F + P u Omega^2 + S I,      i = R_i F + P_i u Omega^2 + S_i I                               (1)

where q are the displacements at the sites (m), and i are the demanded currents (A). G(i Omega) is the plant's response
to a force. The sampled readings are exactly y = G_y F + H_y i, with z = exp(i Omega T), and the held current moves the
sites by its first harmonic,

    H_q = G_q(i Omega) exp(-i Omega f T) (1 - exp(-i Omega T))/(i Omega T)                            (2)

where f is the delay as a fraction of a sample. The harmonics of the held current, at Omega plus multiples of the
sampling frequency, change a contact force within a sample but not its mean.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from amb_analysis.linear.components import frequency_response
from amb_analysis.steady_contact.forward_loop import Complex, ForwardLoop


@dataclass(frozen=True, eq=False)
class Receptances:
    """Receptances (1) at one speed.

    Omega
        Spin speed (rad/s).
    R, P, S
        Displacements at m sites per force (m/N), per unbalance force at d places (m/N), and per injected current at b
        bearings (m/A): shapes (m, m), (m, d), (m, b).
    readings
        Readings of r pairs of sensors per force, unbalance force and current: shapes (r, m), (r, d), (r, b).
    currents
        Demanded currents per force, unbalance force and injected current (A/N, A/N, 1).
    """

    Omega: float
    R: Complex
    P: Complex
    S: Complex
    readings: tuple[Complex, Complex, Complex]
    currents: tuple[Complex, Complex, Complex]


def receptances(loop: ForwardLoop, whirl: float | None = None) -> Receptances:
    """Return the receptances at a whirl frequency (rad/s); by default, the whirl frequency is the spin speed.

    The frequency of a backward whirl is negative.

    Raises
    ------
    ValueError
        If the frequency is zero.
    """
    omega = loop.Omega if whirl is None else whirl
    if omega == 0.0:
        raise ValueError("a frequency of 0 rad/s is not allowed")
    at_sites, at_unbalance, at_currents = loop.columns
    m = len(loop.sites)
    G = frequency_response(loop.plant, 1j * omega)
    G_force, G_unbalance = G[:, at_sites], G[:, at_unbalance]
    if loop.controller is None or loop.sample_time is None:
        no_currents, empty = np.zeros((m, 0), dtype=complex), np.zeros((0, m), dtype=complex)
        no_control = (empty, np.zeros((0, G_unbalance.shape[1]), dtype=complex), np.zeros((0, 0), dtype=complex))
        return Receptances(omega, G_force, G_unbalance, no_currents, no_control, no_control)
    T, z = loop.sample_time, np.exp(1j * omega * loop.sample_time)
    harmonic = np.exp(-1j * omega * loop.late * T) * (1.0 - 1.0 / z) / (1j * omega * T)
    H_q = G[:m, at_currents] * harmonic
    H_y = sampled_response(loop, z)[m:]
    K = frequency_response(loop.controller, z)
    closed = np.linalg.inv(np.eye(len(K)) - K @ H_y)
    S_i = closed
    R_i, P_i = closed @ K @ G_force[m:], closed @ K @ G_unbalance[m:]
    readings = G_force[m:] + H_y @ R_i, G_unbalance[m:] + H_y @ P_i, H_y @ S_i
    R, P, S = G_force[:m] + H_q @ R_i, G_unbalance[:m] + H_q @ P_i, H_q @ S_i
    return Receptances(omega, R, P, S, readings, (R_i, P_i, S_i))


def sampled_response(loop: ForwardLoop, z: complex) -> Complex:
    """Return the sampled response of all plant outputs to held currents, shape (n_outputs, n_currents).

    x(n+1) = Phi x(n) + Gamma_1 u(n-1) + Gamma_0 u(n), with currents u held (2)
    """
    Phi, Gamma_0, Gamma_1 = loop.held
    x = np.linalg.solve(z * np.eye(len(Phi)) - Phi, Gamma_0 + Gamma_1 / z)
    direct_delay = np.where(loop.late > 0.0, 1.0 / z, 1.0)
    return np.asarray(loop.plant.C @ x + loop.plant.D[:, loop.columns[2]] * direct_delay)
