"""True frequencies of the poles of a sampled loop, in which aliasing makes fast motions look slow.

    z = exp(s T),   s = ln(z)/T + 2 pi i m/T,   m any whole number                                 (1)

The poles alone do not determine m, because a motion of the plant faster than half the sample rate looks slow. The
plant's part of the eigenvector determines m. If the plant obeys (q, v)' = A (q, v) between samples and has the mass
matrix M,

    s_e = (v^H M a)/(v^H M v),   a the lower half of A (q, v)                                      (2)

is an estimate of the eigenvalue of the motion that has most of the kinetic energy. The estimate ignores the forces that
are held over a sample. s is the value of (1) nearest to s_e. A weighting by displacement would be misleading. A
controller that mistakes a fast motion for a slow one also shakes the rotor slowly, with a large amplitude but little
energy.
"""

from __future__ import annotations

import math

import numpy as np

from array_types import Array, Complex

EXTINCT = 1e-9  # modulus below which a pole is 0
AT_REST = 1e-20  # v^H M v over the squared norm of an eigenvector up to which the plant is at rest in it


def logarithms(z: Complex, sample_time: float) -> Complex:
    """Return s of (1) with m = 0, so that its frequency is at most half the sample rate; s is 0 for z = 0."""
    nonzero, s = np.abs(z) > EXTINCT, np.zeros(len(z), dtype=np.complex128)
    s[nonzero] = np.log(z[nonzero]) / sample_time
    return s


def continuous_poles(z: Complex, sample_time: float, states: Complex, A: Array, mass: Array) -> Complex:
    """Return s of (1) for the poles z, with m determined from the plant's motion (2); s is 0 for z = 0.

    Parameters
    ----------
    z
        Poles, shape (n,).
    sample_time
        T (s).
    states
        Displacements q of the plant, followed by its velocities v, in the eigenvector of each pole, shape (2 m, n).
    A, mass
        State matrix A of the plant, shape (2 m, 2 m), and mass matrix M, shape (m, m).
    """
    s, m = logarithms(z, sample_time), len(mass)
    v, a = states[m:], A[m:] @ states
    momenta = (mass @ v).conj()
    energy, power = (momenta * v).sum(axis=0).real, (momenta * a).sum(axis=0)
    moves = (s != 0.0) & (energy > AT_REST * np.einsum("ij,ij->j", states.conj(), states).real)
    turns = np.zeros(len(z))
    turns[moves] = np.round((power[moves] / energy[moves] - s[moves]).imag * sample_time / (2.0 * math.pi))
    return np.asarray(s + 2j * math.pi * turns / sample_time)
