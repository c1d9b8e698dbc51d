"""A disc on a massless shaft in one circular clearance: m q'' + d q' + k q = u Omega^2 e^(i theta) + F."""

import numpy as np

from amb_analysis.steady_contact.forward_loop import ComplexLaw, ForwardLoop

MASS, STIFFNESS, DAMPING, CLEARANCE = 2.0, 8e4, 30.0, 1e-4  # kg, N/m, N s/m, m
OWN = (STIFFNESS / MASS) ** 0.5  # rad/s


def jeffcott(Omega, mass=MASS, stiffness=STIFFNESS, damping=DAMPING):
    """Return its loop of forward motion, without control; force and unbalance act on the disc."""
    A = np.array([[0.0, 1.0], [-stiffness / mass, -damping / mass]], dtype=complex)
    B = np.array([[0.0, 0.0], [1.0, 1.0]], dtype=complex) / mass
    C, D = np.array([[1.0, 0.0]], dtype=complex), np.zeros((1, 2), dtype=complex)
    plant = ComplexLaw(A, B, C, D)
    return ForwardLoop(Omega, plant, None, None, np.zeros(0), ("ring",), ("disc",), (), ())


def dynamic_stiffness(omega, mass=MASS, stiffness=STIFFNESS, damping=DAMPING):
    """Return k - m omega^2 + i omega d (N/m)."""
    return stiffness - mass * omega**2 + 1j * omega * damping
