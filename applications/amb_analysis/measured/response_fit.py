"""Parameters of a model from measured frequency responses, whose scatter is estimated from the data.

The fit begins with the residuals ln(H/H_m), with which it finds the resonances even from a distant start. However,
these residuals are biased near a noise floor. The fit therefore ends with differences divided by their standard
deviations,

    r_k = (H_k - H_mk)/sqrt(v_k/2), real and imaginary                                               (1)
    v_k = a + b |H_k|^2 + c |H_k|^2 (1 - gamma_k^2)/gamma_k^2                                        (2)

The coefficient a is a noise floor, b describes scatter that is proportional to the response, and c describes the
scatter of an estimate with the coherence gamma^2. Each response has its own coefficients a, b, c >= 0. They maximise
the likelihood under the assumption that e_k = |H_k - H_mk|^2/v_k is exponentially distributed. Each coefficient is
multiplied repeatedly by (sum x_k e_k/v_k / sum x_k/v_k)^(1/2), where x is its factor in (2), until the coefficient
converges. In (2), H is the model of the previous step. With the measured |H|, values that are small by chance would
receive too much weight.

Residuals r of neighbouring lines should be independent. If they have correlations rho_l at a distance of l lines, the
covariance of the parameters grows by the factor

    1 + 2 sum rho_l,   l = 1, 2, ... while rho_l > 3/sqrt(n)                                         (3)

If the model lacks something, such as a soft suspension, a few lines may deviate strongly. These lines shift the
parameters, but hardly change (3). Let z be the complex number formed by both parts of r. If z is noise, the following
quantity for L neighbouring lines,

    |sum z_k|^2/(2 L)                                                                                (4)

is exponentially distributed. This quantity is computed for all groups of L = 1, 2, 4, ... neighbouring lines. If the
model explains the measurements, the largest value, divided by (3), exceeds ln(groups/0.01) in fewer than one
measurement in a hundred.

G. A. F. Seber, C. J. Wild, Nonlinear Regression, Wiley, 2003, sec. 2.8; J. S. Bendat, A. G. Piersol, Random Data, 4th
ed., Wiley, 2010, sec. 9.2.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from amb_analysis.measured.least_squares import Fit, FreeParameter, Residuals, intervals, leverages, minimised
from amb_analysis.measured.records import FrequencyResponse
from array_types import Array, Complex

Model = Callable[[Array], Sequence[Complex]]

STEPS = 10  # of weights and parameters in turn
SETTLED = 0.01  # change of the logarithm of the likelihood
MOST_SHARE = 0.9  # of a line in the fit
WEIGHINGS = 500  # steps of the largest likelihood of (2)
LEAST_SCATTER = 1e-9  # relative, of rounding
MOST_WEIGHT = 30.0  # of a line by its coherence, in the fit of logarithms
LAGS = 20
EXACT = 1e-4  # relative deviation below which residuals are those of rounding in a file
DEPENDENT = 0.2  # correlation of neighbours above which residuals are not noise
FALSE_ALARMS = 0.01  # share of measurements that the model explains, with a warning by (4)


def fit_responses(
    model: Model, curves: Sequence[FrequencyResponse], free: Sequence[FreeParameter], start: Sequence[float]
) -> tuple[Fit, tuple[str, ...]]:
    """Return the parameters that fit some responses, with intervals by (1) to (3), and warnings by (3) and (4).

    Parameters
    ----------
    model
        Function of the parameters that returns the values of all responses, shape (n,) each.
    curves
        Measured responses.
    free, start
        Parameters with bounds, and initial values.

    Raises
    ------
    ValueError
        As for `least_squares.fit`.
    """
    weights = [_by_coherence(curve) for curve in curves]

    def logarithms(p: Array) -> Array:
        values = zip(model(p), curves, weights, strict=True)
        return np.concatenate([_parts(np.asarray(w * np.log(H / c.values), np.complex128)) for H, c, w in values])

    def over(scatter: Sequence[Array]) -> Residuals:
        def differences(p: Array) -> Array:
            values = zip(model(p), curves, scatter, strict=True)
            return np.concatenate([_parts((H - c.values) / np.sqrt(0.5 * v)) for H, c, v in values])

        return differences

    best = minimised(logarithms, free, start)
    residuals = over([_floor(H, curve) for H, curve in zip(model(best), curves, strict=True)])
    best, likelihood = minimised(residuals, free, best), np.inf
    terms: list[Array] = []
    for _ in range(STEPS):
        shares = _shares(leverages(residuals, free, best), curves)
        found, new = _scatters(model(best), curves, shares)
        if new > likelihood - SETTLED:
            break
        terms, likelihood = found, new
        residuals = over([item.sum(axis=1) for item in terms])
        best = minimised(residuals, free, best)
    z = [pair[0] + 1j * pair[1] for pair in _pairs(residuals(best), curves)]
    inflation, neighbour = _dependence(z)
    equivalent = _equivalent(terms, _shares(leverages(residuals, free, best), curves))
    parameters, correlation = intervals(residuals, free, best, inflation, equivalent)
    first, last = (_relative(model(np.asarray(p, np.float64)), curves) for p in (start, best))
    lacking = _systematic(z, curves, inflation)
    if not lacking and neighbour > DEPENDENT and inflation > 1.0:
        lacking = f"as the correlation of {neighbour:.2f} between residuals at neighbouring frequencies shows"
    warnings: tuple[str, ...] = ()
    if lacking and last > EXACT:
        warnings = (
            f"the model does not explain the data within their scatter, {lacking}; the intervals are not valid, "
            "because they do not include errors of the model itself",
        )
    return Fit(parameters, correlation, first, last, 2 * sum(len(c.values) for c in curves)), warnings


def _pairs(values: Array, curves: Sequence[FrequencyResponse]) -> list[Array]:
    """Return the residuals of each response, shape (2, n): the real parts, then the imaginary parts."""
    parts = np.split(values, np.cumsum([2 * len(c.values) for c in curves])[:-1])
    return [part.reshape(2, -1) for part in parts]


def _shares(values: Array, curves: Sequence[FrequencyResponse]) -> list[Array]:
    """Return the leverages of the lines in the fit, as an array of shape (n,) for each response."""
    return [np.asarray(pair.sum(axis=0)) for pair in _pairs(values, curves)]


def _scatters(
    values: Sequence[Complex], curves: Sequence[FrequencyResponse], shares: Sequence[Array]
) -> tuple[list[Array], float]:
    """Return the terms of (2) for each response, shape (n, terms), and -2 times the logarithm of the likelihood.

    The residual of a line is too small, because the line affects the fit. The square of the residual is therefore
    divided by 1 - h/2, where h is the leverage of the line, summed over its real and imaginary parts.
    """
    result, total = [], 0.0
    for H, curve, h in zip(values, curves, shares, strict=True):
        squares = np.abs(H - curve.values) ** 2 / (1.0 - np.minimum(0.5 * h, MOST_SHARE))
        result.append(_scatter(H, curve, squares))
        v = result[-1].sum(axis=1)
        total += float(np.sum(np.log(v) + squares / v))
    return result, total


def _equivalent(terms: Sequence[Array], shares: Sequence[Array]) -> float:
    """Return the effective number of residuals that determine the scatter of the lines on which the parameters depend.

    A term of (2) is determined by the lines at which it is large. Their number is about 2 (sum s)^2/sum s^2, where s is
    the term's fraction of v. The relative errors of the terms add up, weighted by the contributions of the terms to the
    fit (F. E. Satterthwaite, Biometrics 2 (1946) 110).
    """
    whole, error = max(sum(float(h.sum()) for h in shares), 1e-300), 0.0
    for item, h in zip(terms, shares, strict=True):
        for s in (item / item.sum(axis=1, keepdims=True)).T:
            known = 2.0 * float(s.sum()) ** 2 / max(float((s**2).sum()), 1e-300)
            error += (float((h * s).sum()) / whole) ** 2 / max(known, 1.0)
    return 1.0 / max(error, 1e-300)


def _by_coherence(curve: FrequencyResponse) -> Array:
    """Return the weights of the logarithms, which are inverse standard deviations up to a constant factor."""
    if curve.coherence is None:
        return np.ones(len(curve.values))
    square = np.clip(curve.coherence, 1e-3, 1.0 - 1e-6)
    return np.minimum(np.sqrt(square / (1.0 - square)), MOST_WEIGHT)


def _floor(H: Complex, curve: FrequencyResponse) -> Array:
    """Return equal v for all lines, shape (n,), so that a misfit at the resonances is not taken for scatter (2)."""
    squares = np.abs(H - curve.values) ** 2
    return np.full(len(H), max(float(np.median(squares)), LEAST_SCATTER**2 * float(np.mean(np.abs(H) ** 2))))


def _scatter(H: Complex, curve: FrequencyResponse, squares: Array) -> Array:
    """Return the terms of (2), shape (n, terms), that maximise the likelihood of the squares of residuals."""
    power = np.abs(H) ** 2
    columns = [np.full(len(H), np.mean(power)), power]
    if curve.coherence is not None:
        gamma = np.clip(curve.coherence, 1e-3, 1.0)
        columns.append(power * (1.0 - gamma) / gamma)
    terms = np.stack(columns, axis=1)
    least = LEAST_SCATTER**2 * power
    factors = float(np.mean(squares)) / np.mean(terms, axis=0) / len(columns)
    v = terms @ factors + least
    for _ in range(WEIGHINGS):
        factors = factors * np.sqrt((squares / v**2) @ terms / ((1.0 / v) @ terms))
        new = terms @ factors + least
        settled = np.allclose(new, v, rtol=1e-4, atol=0.0)
        v = new
        if settled:
            break
    found = terms * factors
    found[:, 1] += least
    return np.asarray(found)


def _dependence(residuals: Sequence[Complex]) -> tuple[float, float]:
    """Return the factor (3), and the correlation of the residuals of neighbouring lines."""
    size = sum(float(np.sum(np.abs(z) ** 2)) for z in residuals)
    n = sum(len(z) for z in residuals)
    total, neighbour = 1.0, 0.0
    for lag in range(1, LAGS + 1):
        rho = sum(float(np.sum((z[:-lag] * z[lag:].conj()).real)) for z in residuals) / max(size, 1e-300)
        neighbour = rho if lag == 1 else neighbour
        if rho <= 3.0 / np.sqrt(n):
            break
        total += 2.0 * rho
    return total, neighbour


def _systematic(residuals: Sequence[Complex], curves: Sequence[FrequencyResponse], inflation: float) -> str:
    """Return a text that states where (4) is largest, or an empty text if noise alone can explain this value."""
    runs, largest, where = 0, 0.0, ""
    for z, curve in zip(residuals, curves, strict=True):
        sums, L = np.concatenate([[0.0], np.cumsum(z)]), 1
        while len(z) >= L:
            sizes = np.abs(sums[L:] - sums[:-L]) ** 2 / (2.0 * L * inflation)
            k = int(np.argmax(sizes))
            if sizes[k] > largest:
                begin, end = curve.frequencies[k], curve.frequencies[k + L - 1]
                band = f"at {begin:.5g} Hz" if L == 1 else f"from {begin:.5g} to {end:.5g} Hz"
                largest, where = float(sizes[k]), f"above all {band} in {curve.name}"
            runs, L = runs + len(sizes), 2 * L
    return where if largest > np.log(runs / FALSE_ALARMS) else ""


def _relative(values: Sequence[Complex], curves: Sequence[FrequencyResponse]) -> float:
    """Return the root mean square of the real and imaginary parts of ln(H/H_m)."""
    r = np.concatenate([_parts(np.log(H / c.values)) for H, c in zip(values, curves, strict=True)])
    return float(np.sqrt(np.mean(r**2)))


def _parts(values: Complex) -> Array:
    return np.concatenate([values.real, values.imag])
