"""Scatter of measured frequency responses, estimated from the differences between a model and the measurement.

The difference at a line k is resolved along the response H of the model and across it, which are the deviations of
amplitude and phase,

    e_k = (H_k - H_mk) exp(-j arg H_k),     Re e_k ~ N(0, v_k/2),   Im e_k ~ N(0, w_k/2)             (1)
    v_k = a + b |H_k|^2 + d |H_mk|^2 (1 - gamma_k^2)/gamma_k^2                                      (2)
    w_k = a + c |H_k|^2 + d |H_mk|^2 (1 - gamma_k^2)/gamma_k^2                                      (3)

The coefficient a is a noise floor, b and c describe scatter of amplitude and of phase in proportion to the response,
and d describes the scatter of an estimate with the coherence gamma^2. The part of a noisy force in the latter is left
out (`force_noise`). If the noise of the output is known from a quiet part of the record, its effect on H replaces the
factor of d, and b and c are 0. Each response has its own coefficients >= 0. They maximise the likelihood. Each
coefficient is multiplied repeatedly by (sum x_k q_k/v_k^2 / sum x_k/v_k)^(1/2), where x is its factor in (2) and (3),
and q is 2 (Re e)^2 or 2 (Im e)^2, until v and w converge. The terms of b and c have the response of the model: with
the measured |H_m|, values that are small by chance would receive too much weight. The term of d has |H_m|, because
S_yy (1 - gamma^2)/S_uu is the scatter about the estimate and independent of its error.

An average over N segments knows its own scatter x = |H_m|^2 (1 - gamma^2)/gamma^2 with a relative variance rho of about
1/(N - 1). The variance of ln x is psi'(1/rho), nearly rho/(1 - rho/2). It is estimated from neighbouring lines, where
the true scatter is nearly equal:

    D = mean (ln x_(k+1) - ln x_k)^2/2,     rho = D/(1 + D/2)                                       (4)

If the term of d is the share s of v, |e|^2/v has the distribution F(2, nu) instead of an exponential distribution, with

    nu_k = 2/(rho s_k^2)                                                                            (5)

A share that is small by chance hides scatter that is not small. Therefore s_k is at least its mean over the lines.

J. S. Bendat, A. G. Piersol, Random Data, 4th ed., Wiley, 2010, sec. 9.2; F. E. Satterthwaite, Biometrics 2 (1946) 110.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from amb_analysis.measured.blows import NOISE_SEGMENTS
from amb_analysis.measured.records import FrequencyResponse
from array_types import Array, Complex

WEIGHINGS = 500  # steps of the largest likelihood
LEAST_SCATTER = 1e-9  # relative, of rounding
LEAST_RATIO = 0.1  # of the standard deviations of amplitude and phase, smaller over larger
LEAST_OWN = 0.05  # share of the scatter that the coherence states, which is not that of the force
MOST_SHARE = 0.9  # of a residual in the fit


@dataclass(frozen=True, eq=False)
class Scatter:
    """Estimated scatter of a response with n lines.

    direction
        exp(j arg H) of the model, shape (n,).
    terms
        Terms of (2), then of (3), shape (2 n, terms).
    uncertainty
        rho of (4); 0 without coherence.
    """

    direction: Complex
    terms: Array
    uncertainty: float

    @cached_property
    def variances(self) -> Array:
        """v, then w, shape (2 n,)."""
        return np.asarray(self.terms.sum(axis=1))

    def residuals(self, differences: Complex) -> Array:
        """Return e/sqrt(v/2) and e/sqrt(w/2) of differences H - H_m, shape (2 n,)."""
        return along_and_across(differences, self.direction) / np.sqrt(0.5 * self.variances)

    def differences(self, residuals: Array) -> Complex:
        """Return the differences H - H_m that have some residuals, shape (n,)."""
        along, across = (residuals * np.sqrt(0.5 * self.variances)).reshape(2, -1)
        return np.asarray(self.direction * (along + 1j * across))

    def noise(self, residuals: Array) -> Complex:
        """Return residuals of unit variance as complex numbers z with normal parts, in the axes of H, shape (n,).

        The number u = |z|^2/2 has the distribution F(2, nu) by (5). The number (nu/2) ln(1 + 2 u/nu), which has the
        same probability, has an exponential distribution.
        """
        parts = residuals.reshape(2, -1)
        z = self.direction * (parts[0] + 1j * parts[1])
        share = np.mean((self.terms[:, -1] / self.variances).reshape(2, -1), axis=0)
        x = 0.5 * self.uncertainty * np.maximum(share, np.mean(share)) ** 2 * np.abs(z) ** 2  # 2 u/nu
        return np.asarray(z * np.sqrt(np.divide(np.log1p(x), x, out=np.ones_like(x), where=x > 0.0)))


def scatter_of(H: Complex, curve: FrequencyResponse, differences: Complex, leverages: Array) -> tuple[Scatter, float]:
    """Return the scatter of a response, and -2 times the logarithm of the likelihood.

    A residual is too small, because it affects the fit. Its square is therefore divided by 1 - h, where h is its
    leverage.

    Parameters
    ----------
    H
        Response of the model, shape (n,).
    curve
        Measured response with n lines.
    differences
        H - H_m, without what all lines share, shape (n,).
    leverages
        Leverages of the residuals, shape (2 n,).
    """
    direction = np.exp(1j * np.angle(H))
    squares = along_and_across(differences, direction) ** 2
    squares = 2.0 * squares / (1.0 - np.minimum(leverages, MOST_SHARE))
    scatter = _most_likely(H, direction, curve, squares)
    return scatter, float(np.sum(np.log(scatter.variances) + squares / scatter.variances))


def along_and_across(values: Complex, direction: Complex) -> Array:
    """Return the components along exp(j arg H), then the components across it, shape (2 n,)."""
    turned = values * direction.conj()
    return np.concatenate([turned.real, turned.imag])


def _most_likely(H: Complex, direction: Complex, curve: FrequencyResponse, squares: Array) -> Scatter:
    """Return the scatter that maximises the likelihood of the squares q, shape (2 n,)."""
    power = np.abs(H) ** 2
    none, floor = np.zeros(len(H)), np.full(len(H), np.mean(power))
    columns = [(floor, floor)]
    if curve.scatter is None:
        columns += [(power, none), (none, power)]
    else:
        columns.append((curve.scatter, curve.scatter))
    if curve.scatter is None and curve.coherence is not None:
        gamma = np.clip(curve.coherence, 1e-3, 1.0)
        stated = (1.0 - gamma) / gamma
        if curve.force_noise is not None:
            stated = np.maximum(stated - curve.force_noise.power, LEAST_OWN * stated)
        columns.append((np.abs(curve.values) ** 2 * stated,) * 2)
    terms = np.stack([np.concatenate(column) for column in columns], axis=1)
    least = LEAST_SCATTER**2 * np.tile(power, 2)
    factors = float(np.mean(squares)) / np.maximum(np.mean(terms, axis=0), 1e-300) / len(columns)
    v = terms @ factors + least
    for _ in range(WEIGHINGS):
        factors = factors * np.sqrt((squares / v**2) @ terms / np.maximum((1.0 / v) @ terms, 1e-300))
        new = terms @ factors + least
        settled = np.allclose(new, v, rtol=1e-4, atol=0.0)
        v = new
        if settled:
            break
    if curve.scatter is None:
        factors[1:3] = np.maximum(factors[1:3], LEAST_RATIO**2 * factors[2:0:-1])
    found = terms * factors
    found[:, 0] += least
    return Scatter(direction, found, _uncertainty(curve))


def _uncertainty(curve: FrequencyResponse) -> float:
    """Return the relative variance (4) of the scatter that coherence or quiet part state; 0 without either."""
    if curve.scatter is not None:
        return 1.0 / NOISE_SEGMENTS
    if curve.coherence is None:
        return 0.0
    gamma = np.clip(curve.coherence, 1e-3, 1.0 - 1e-6)
    logarithms = np.log(np.abs(curve.values) ** 2 * (1.0 - gamma) / gamma)
    D = 0.5 * float(np.mean(np.diff(logarithms) ** 2))
    return D / (1.0 + 0.5 * D)
