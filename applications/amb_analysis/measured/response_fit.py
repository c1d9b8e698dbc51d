"""Parameters of a model from measured frequency responses, whose scatter is estimated from the data.

The fit begins with the residuals ln(H/H_m), with which it finds the resonances even from a distant start. However,
these residuals are biased near a noise floor. The fit therefore ends with the deviations of amplitude and phase,
divided by their standard deviations,

    r_k = Re e_k/sqrt(v_k/2) and Im e_k/sqrt(w_k/2),     e_k = (H_k - H_mk) exp(-j arg H_k)          (1)

where the variances v and w are estimated from these deviations (`scatter`). They differ, for example, if only the
amplitudes scatter. In exp(-j arg H), v and w, H is the model of the previous step.

Residuals r of neighbouring lines should be independent. If they have correlations rho_l at a distance of l lines, the
covariance of the parameters grows by the factor

    1 + 2 sum rho_l,   l = 1, 2, ... while rho_l > 3/sqrt(n)                                         (2)

If the model lacks something, such as a soft suspension, a few lines may deviate strongly. These lines shift the
parameters, but hardly change (2). Let z be the complex number formed by both parts of r, turned back by exp(j arg H).
If z is noise, its parts are independent and have the variance 1, because each is divided by its own standard deviation.
The following quantity for L neighbouring lines,

    |sum z_k|^2/(2 L)                                                                                (3)

is then exponentially distributed. Scatter that comes from the coherence of few averages is itself uncertain, so that
large z are more frequent; `Scatter.noise` corrects their size. The quantity (3) is computed for all groups of L = 1, 2,
4, ... neighbouring lines. If the model explains the measurements, the largest value, divided by (2), exceeds
ln(groups/0.01) in fewer than one measurement in a hundred.

G. A. F. Seber, C. J. Wild, Nonlinear Regression, Wiley, 2003, sec. 2.8.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from amb_analysis.measured.force_noise import SharedScatter, shared_scatter
from amb_analysis.measured.least_squares import Fit, FreeParameter, Residuals, intervals, leverages, minimised
from amb_analysis.measured.records import FrequencyResponse
from amb_analysis.measured.scatter import LEAST_SCATTER, Scatter, scatter_of
from array_types import Array, Complex

Model = Callable[[Array], Sequence[Complex]]

STEPS = 10  # of weights and parameters in turn
SETTLED = 0.01  # change of the logarithm of the likelihood
MOST_WEIGHT = 30.0  # of a line by its coherence, in the fit of logarithms
LAGS = 20
EXACT = 1e-4  # relative deviation below which residuals are those of rounding in a file
DEPENDENT = 0.2  # correlation of neighbours above which residuals are not noise
FALSE_ALARMS = 0.01  # share of measurements that the model explains, with a warning by (3)


def fit_responses(
    model: Model, curves: Sequence[FrequencyResponse], free: Sequence[FreeParameter], start: Sequence[float]
) -> tuple[Fit, tuple[str, ...]]:
    """Return the parameters that fit some responses, with intervals by (1) and (2), and warnings by (2) and (3).

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

    def over(scatters: Sequence[Scatter]) -> tuple[Residuals, Residuals, SharedScatter]:
        """Return the residuals (1) as functions of the parameters, and made independent; and what they share."""
        shared = _shared(curves, scatters, model(best))

        def differences(p: Array) -> Array:
            values = zip(model(p), curves, scatters, strict=True)
            return np.concatenate([scatter.residuals(H - c.values) for H, c, scatter in values])

        return differences, lambda p: shared.independent(differences(p)), shared

    best = minimised(logarithms, free, start)
    scatters = [_floor(H, curve) for H, curve in zip(model(best), curves, strict=True)]
    differences, residuals, shared = over(scatters)
    best, likelihood = minimised(residuals, free, best), np.inf
    for _ in range(STEPS):
        shares = _by_response(leverages(residuals, free, best) + shared.leverages(), curves)
        rest = _by_response(shared.rest(differences(best)), curves)
        found = [
            scatter_of(H, curve, scatter.differences(r), h)
            for H, curve, scatter, r, h in zip(model(best), curves, scatters, rest, shares, strict=True)
        ]
        new = sum(of_one for _, of_one in found)
        if new > likelihood - SETTLED:
            break
        scatters, likelihood = [scatter for scatter, _ in found], new
        differences, residuals, shared = over(scatters)
        best = minimised(residuals, free, best)
    of_responses = zip(scatters, _by_response(residuals(best), curves), strict=True)
    z = [scatter.noise(r) for scatter, r in of_responses]
    inflation, neighbour = _dependence(z)
    equivalent = _equivalent(scatters, _by_response(leverages(residuals, free, best), curves))
    parameters, correlation = intervals(residuals, free, best, inflation, equivalent, least=1.0)
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


def _by_response(values: Array, curves: Sequence[FrequencyResponse]) -> list[Array]:
    """Return the values of each response's residuals, shape (2 n,): those of amplitudes, then those of phases."""
    return np.split(values, np.cumsum([2 * len(c.values) for c in curves])[:-1])


def _shared(
    curves: Sequence[FrequencyResponse], scatters: Sequence[Scatter], values: Sequence[Complex]
) -> SharedScatter:
    """Return the scatter that residuals share because of the noise of the force; `values` are those of the model."""
    columns = []
    for curve, scatter, H in zip(curves, scatters, values, strict=True):
        noise, changes = curve.force_noise, np.empty((2 * len(H), 0))
        if noise is not None:
            moved = (-H[:, None] * noise.changes(curve.frequencies)).T
            changes = np.stack([scatter.residuals(of_sample) for of_sample in moved], axis=1)
        columns.append((noise, changes))
    return shared_scatter(columns)


def _equivalent(scatters: Sequence[Scatter], shares: Sequence[Array]) -> float:
    """Return the effective number of residuals that determine the scatter of the lines on which the parameters depend.

    A term of v and w is determined by the residuals in which it is large. Their number is about (sum s)^2/sum s^2,
    where s is the term's fraction of v or w. The relative errors of the terms add up, weighted by the contributions of
    the terms to the fit (F. E. Satterthwaite, Biometrics 2 (1946) 110).
    """
    whole, error = max(sum(float(h.sum()) for h in shares), 1e-300), 0.0
    for scatter, h in zip(scatters, shares, strict=True):
        for s in (scatter.terms / scatter.variances[:, None]).T:
            known = float(s.sum()) ** 2 / max(float((s**2).sum()), 1e-300)
            error += (float((h * s).sum()) / whole) ** 2 / max(known, 1.0)
    return 1.0 / max(error, 1e-300)


def _by_coherence(curve: FrequencyResponse) -> Array:
    """Return the weights of the logarithms, which are inverse standard deviations up to a constant factor."""
    if curve.coherence is None:
        return np.ones(len(curve.values))
    square = np.clip(curve.coherence, 1e-3, 1.0 - 1e-6)
    return np.minimum(np.sqrt(square / (1.0 - square)), MOST_WEIGHT)


def _floor(H: Complex, curve: FrequencyResponse) -> Scatter:
    """Return equal scatter of all lines, so that a misfit at the resonances is not taken for scatter."""
    squares = np.abs(H - curve.values) ** 2
    v = max(float(np.median(squares)), LEAST_SCATTER**2 * float(np.mean(np.abs(H) ** 2)))
    return Scatter(np.ones(len(H), np.complex128), np.full((2 * len(H), 1), v), 0.0)


def _dependence(residuals: Sequence[Complex]) -> tuple[float, float]:
    """Return the factor (2), and the correlation of the residuals of neighbouring lines."""
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
    """Return a text that states where (3) is largest, or an empty text if noise alone can explain this value."""
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
