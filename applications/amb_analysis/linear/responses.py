"""Frequency responses of sampled models, and the disk margins that follow from a sensitivity."""

from __future__ import annotations

import math
from typing import NamedTuple

import control
import numpy as np

from amb_analysis.linear.components import StateSpace
from array_types import Array, Complex

NYQUIST = 1.0 - 1e-9  # of half the sample rate: python-control warns if rounding takes a frequency beyond it
BALANCING = 60  # steps of Osborne's iteration
CHECKED = 8  # frequencies at which a response by eigenvectors is compared with that by solution
CLOSE_RESPONSE = 1e-7  # largest difference of both, over the largest value of an output over an input


class Modes(NamedTuple):
    """The eigenvalues lambda of A, and the products C V and V^-1 B, where V has the eigenvectors of A as columns."""

    poles: Complex
    of_outputs: Complex
    of_inputs: Complex

    def response(self, z: Complex) -> Complex:
        """Return C (z - A)^-1 B at points z, shape (n, outputs, inputs)."""
        residues = self.of_outputs.T[:, :, None] * self.of_inputs[:, None, :]
        return np.tensordot(1.0 / (z[:, None] - self.poles), residues, axes=1)


def modes_of(system: StateSpace) -> Modes | None:
    """Return the modes of a model; None if it has no states, or if two of its eigenvectors are parallel."""
    if not len(system.A):
        return None
    poles, V = np.linalg.eig(system.A)
    try:
        of_inputs = np.linalg.solve(V, system.B.astype(np.complex128))
    except np.linalg.LinAlgError:
        return None
    return Modes(poles.astype(np.complex128), (system.C @ V).astype(np.complex128), of_inputs)


def response(system: control.StateSpace, frequencies: Array, modes: Modes | None = None) -> Complex:
    """Return the frequency response of a system, shape (outputs, inputs, n), at frequencies (Hz), shape (n,).

        H(z) = C (z - A)^-1 B + D = (C V) (z - lambda)^-1 (V^-1 B) + D                                (1)

    with eigenvalues lambda and eigenvectors V of A. If the eigenvectors are nearly parallel, python-control computes
    the response at each frequency instead. `modes` are the modes of the system, if they are already known. Frequencies
    above half the sample rate are replaced by half the sample rate.
    """
    omega = 2.0 * math.pi * np.minimum(frequencies, NYQUIST * 0.5 / system.dt)
    known = (modes or modes_of(system)) if len(omega) > CHECKED else None
    if known is not None:
        z = np.exp(1j * omega * system.dt)
        result = np.moveaxis(known.response(z) + np.asarray(system.D), 0, -1)
        largest = int(np.abs(result).max(axis=(0, 1)).argmax())
        compared = np.unique([*np.linspace(0, len(z) - 1, CHECKED, dtype=int), largest])
        expected = _solved_response(system, omega[compared])
        sizes = np.abs(expected).max(axis=2, keepdims=True)
        if (np.abs(result[:, :, compared] - expected) <= CLOSE_RESPONSE * sizes).all():
            return np.asarray(result, dtype=np.complex128)
    return _solved_response(system, omega)


def _solved_response(system: control.StateSpace, omega: Array) -> Complex:
    full = control.frequency_response(system, omega, squeeze=False)
    return np.asarray(full.magnitude * np.exp(1j * full.phase), dtype=np.complex128)


def diagonal_response(system: control.StateSpace, frequencies: Array, modes: Modes | None = None) -> Complex:
    """Return the diagonal of a frequency response, shape (axes, n); arguments as for `response`."""
    return np.einsum("kkn->kn", response(system, frequencies, modes))


def disk_margin(S: Complex) -> Array:
    """Return a lower bound on the disk margin alpha for all loops at once, at each frequency.

    The loops stay stable if each is multiplied by any complex factor f in the disk whose diameter extends from (2 -
    alpha)/(2 + alpha) to (2 + alpha)/(2 - alpha):

        1/alpha = mu(S - 1/2) <= min_D sigma_max(D (S - 1/2) D^-1),  D diagonal

    J. D. Blight, R. L. Dailey, D. Gangsaas, Practical control law design for aircraft using multivariable techniques,
    Int. J. Control 59 (1994) 93-137; P. Seiler, A. Packard, P. Gahinet, IEEE Control Systems 40 (2020) 78-95. D is
    found by balancing rows and columns (E. E. Osborne, J. ACM 7 (1960) 338-345). For a single loop, the bound is alpha
    itself. python-control's `disk_margins` is not used, because it requires slycot for several loops.

    Parameters
    ----------
    S
        Sensitivity, shape (loops, loops, n).
    """
    M = np.moveaxis(S, -1, 0) - 0.5 * np.eye(len(S))
    power = np.abs(M) ** 2
    scale = np.ones((len(M), len(S)))
    off = power * (1.0 - np.eye(len(S)))
    for _ in range(BALANCING if len(S) > 1 else 0):
        weighted = off * scale[:, :, None] / scale[:, None, :]  # scale is d^2
        rows, columns = weighted.sum(axis=2), weighted.sum(axis=1)
        scale *= np.sqrt(np.where(rows > 0.0, columns, 1.0) / np.where(columns * rows > 0.0, rows, 1.0))
        scale = np.clip(scale / scale.max(axis=1, keepdims=True), 1e-12, 1.0)
    d = np.sqrt(scale)
    return np.asarray(1.0 / np.linalg.norm(M * d[:, :, None] / d[:, None, :], 2, axis=(1, 2)))


def disk_gain_and_phase(alpha: float) -> tuple[float, float]:
    """Return the gain margin (1) and phase margin (deg) that a disk margin guarantees, for one loop or all at once."""
    gain = (2.0 + alpha) / (2.0 - alpha) if alpha < 2.0 else math.inf
    return gain, math.degrees(2.0 * math.atan(alpha / 2.0))
