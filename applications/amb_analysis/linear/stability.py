"""Stability of a sampled loop, determined by its pole of largest modulus.

    x(n+1) = A x(n),   z the eigenvalues of A,   s = ln(z)/T = sigma + j omega

The loop is stable if no |z| exceeds 1. Every pole counts, whatever its frequency. For example, a real pole z > 1
represents a rotor that drifts into its retainer without vibration, and a vibration above half the sample rate is
aliased but still grows.

Motions with poles on the unit circle neither grow nor decay. A loop that levitates a rotor may have the following poles
on the circle, none of which moves the rotor away:

- z = 1 of an integrator outside the loop, such as an integrator whose input or output is not connected, or one of
  several integrators that act on the same motion. Its state remains constant.
- z = 1, twice, of an unsupported rigid motion, such as that of a rotor on springs of zero stiffness. Its velocity
  remains constant.
- |z| = 1 of a mode without damping whose nodes are at the magnets or the sensors.

The angle of the shaft is not a state of the linear model, so its free rotation adds no pole. Rounding moves poles off
the circle; a double pole moves by about the square root of the machine precision. To first order, an error E of the
matrix moves a pole by

    |dz| <= kappa |E|,   kappa = |y| |x| / |y^H x|                                                   (1)

with its left and right eigenvectors y and x (J. H. Wilkinson, The Algebraic Eigenvalue Problem, Oxford 1965, chapter
2). For the two halves of a split double pole, kappa is about the inverse of their distance, so (1) covers them as well.
A pole is considered to be on the circle if an error of `ROUNDING` times the machine precision could move it there. Such
poles are counted, and the largest of the other poles determines stability.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eig, matrix_balance

from amb_cosim.results.loop_stability import LoopStability
from array_types import Array, Complex

NEAR = 1e-5  # distance from the unit circle within which rounding is examined
OVERDAMPED = 0.995  # damping ratio from which a pole is not a vibration
ROUNDING = 1e4  # error of the matrix over its norm and the precision: of matrix exponentials and condensed stiffnesses
DRIFT = 0.1  # |omega/sigma| up to which a pole is a drift, not a vibration


class Eigensystem(NamedTuple):
    """Eigenvalues z of a matrix, shape (n,), and its right and left eigenvectors in columns, shape (n, n)."""

    z: Complex
    right: Complex
    left: Complex


def eigensystem(A: Array) -> Eigensystem:
    """Return eigenvalues and eigenvectors of a real matrix."""
    z, left, right = eig(A, left=True, right=True)
    return Eigensystem(*(np.asarray(item, np.complex128) for item in (z, right, left)))


def stability_of(A: Array, sample_time: float) -> LoopStability:
    """Return the stability of x(n+1) = A x(n) with a sample time (s)."""
    return deciding_pole(A, eigensystem(A), sample_time)[0]


def deciding_pole(A: Array, poles: Eigensystem, sample_time: float) -> tuple[LoopStability, int]:
    """Return the stability of x(n+1) = A x(n) with the poles of A, and the index of the pole that determines it.

    If all poles are on the unit circle, the radius is 0 and the index is 0.
    """
    circle = _on_circle(A, poles)
    radii = np.where(circle, 0.0, np.abs(poles.z))
    number = int(radii.argmax())
    radius = float(radii[number])
    sigma = math.log(max(radius, np.finfo(float).tiny)) / sample_time
    omega = float(abs(np.angle(poles.z[number]))) / sample_time
    frequency = 0.0 if omega <= DRIFT * abs(sigma) else omega
    return LoopStability(radius, sigma, frequency, on_circle=int(circle.sum())), number


def _on_circle(A: Array, poles: Eigensystem) -> NDArray[np.bool_]:
    """Return which poles lie on the unit circle, except for the rounding error estimated by (1).

    With the balanced matrix D^-1 A D, whose units are alike, x becomes D^-1 x, and y becomes D y.
    """
    near = np.abs(np.abs(poles.z) - 1.0) < NEAR
    if not near.any():
        return near
    balanced, (scale, _) = matrix_balance(A, permute=False, separate=True)
    x, y = poles.right[:, near] / scale[:, None], poles.left[:, near] * scale[:, None]
    overlap = np.abs((y.conj() * x).sum(axis=0)) / (np.linalg.norm(x, axis=0) * np.linalg.norm(y, axis=0))
    error = ROUNDING * np.finfo(float).eps * np.linalg.norm(balanced, 2)
    near[near] = np.abs(np.abs(poles.z[near]) - 1.0) <= error / np.maximum(overlap, np.finfo(float).eps)
    return near
