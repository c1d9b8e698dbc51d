"""Noise of a hammer's force, which moves all lines of the responses to its blows together.

The force acts for a few samples, so its noise there is smooth over frequency: in a pulse of 3 ms, over hundreds of Hz.
The noise sigma xi, xi ~ N(0, 1), of sample k in blow b changes an averaged response H = <Y U^*>/<|U|^2> by

    dH/H = -xi sigma w(t_k) exp(-j omega t_k) U_b^*/sum_b |U_b|^2                                    (1)

where w is the window. Residuals r whose other scatter has the variance 1 therefore have the covariance I + A A^T, with
a column of A for each sample. Let A = U S V^T. Then

    r' = r - U (1 - (1 + S^2)^(-1/2)) U^T r                                                          (2)

has the covariance I, so that least squares with r' are those of generalised least squares, and

    r'' = r - U S^2 (1 + S^2)^(-1) U^T r                                                             (3)

is what remains of r without the most likely noise of the force.

G. A. F. Seber, C. J. Wild, Nonlinear Regression, Wiley, 2003, sec. 2.1.4.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from array_types import Array, Bools, Complex, Indices


@dataclass(frozen=True, eq=False)
class ForceNoise:
    """Noise of the force in blows of a hammer.

    times, sizes
        Time of each sample at which the hammer acts, from the beginning of its block (s), and sigma w(t) there (N),
        shape (m,).
    blows
        Blow of each sample, shape (m,).
    shares
        U_b^*/sum_b |U_b|^2 (1/N) of each blow, at the lines of a response, shape (n, blows).
    """

    times: Array
    sizes: Array
    blows: Indices
    shares: Complex

    def at(self, k: Indices | Bools) -> ForceNoise:
        """Return the noise at the lines that indices or a mask select."""
        return replace(self, shares=self.shares[k])

    @property
    def power(self) -> Array:
        """Expected |dH/H|^2 of each blow alone, in the mean over the blows, shape (n,)."""
        blows = self.shares.shape[1]
        energies = np.bincount(self.blows, self.sizes**2, blows)
        return np.asarray(blows * (np.abs(self.shares) ** 2 @ energies))

    def changes(self, frequencies: Array) -> Complex:
        """Return dH/H by (1) for xi = 1, at the lines' frequencies (Hz), shape (n, m)."""
        turns = np.exp(-2j * np.pi * frequencies[:, None] * self.times)
        return np.asarray(-self.sizes * turns * self.shares[:, self.blows])


@dataclass(frozen=True, eq=False)
class SharedScatter:
    """Directions U in which residuals scatter together, shape (n, m), and their variances S^2, shape (m,)."""

    directions: Array
    variances: Array

    def independent(self, residuals: Array) -> Array:
        """Return residuals with the covariance I, by (2)."""
        return self._without(residuals, 1.0 - 1.0 / np.sqrt(1.0 + self.variances))

    def rest(self, residuals: Array) -> Array:
        """Return residuals without the most likely noise of the force, by (3)."""
        return self._without(residuals, self.variances / (1.0 + self.variances))

    def leverages(self) -> Array:
        """Return by how much (3) fits each residual, shape (n,)."""
        return np.asarray(self.directions**2 @ (self.variances / (1.0 + self.variances)))

    def _without(self, residuals: Array, shares: Array) -> Array:
        return np.asarray(residuals - self.directions @ (shares * (self.directions.T @ residuals)))


def shared_scatter(columns: Sequence[tuple[ForceNoise | None, Array]]) -> SharedScatter:
    """Return the scatter that responses share.

    Parameters
    ----------
    columns
        For each response, the noise of its force, and the changes of its residuals by that noise, shape (n, m).
        Responses to the same blows have noises with the same array of times.
    """
    sources = {id(noise.times): len(noise.times) for noise, _ in columns if noise is not None}
    begins = dict(zip(sources, np.cumsum([0, *sources.values()])[:-1], strict=True))
    A = np.zeros((sum(len(changes) for _, changes in columns), sum(sources.values())))
    row = 0
    for noise, changes in columns:
        if noise is not None:
            begin = begins[id(noise.times)]
            A[row : row + len(changes), begin : begin + changes.shape[1]] = changes
        row += len(changes)
    U, sizes, _ = np.linalg.svd(A, full_matrices=False)
    return SharedScatter(U, sizes**2)
