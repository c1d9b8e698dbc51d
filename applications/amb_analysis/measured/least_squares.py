"""Parameters from measured data by least squares, with confidence intervals and tests of identifiability.

    min_p sum r_k(p)^2,   s^2 = sum r_k^2/(n - m),   cov = s^2 (J^T J)^-1                           (1)

The interval of a parameter is p +- t sqrt(cov_pp), where t is the quantile of Student's distribution with n - m degrees
of freedom. This is linear theory. It holds if the model is right and if the residuals are independent and have equal
variance. G. A. F. Seber, C. J. Wild, Nonlinear Regression, Wiley, 2003, sec. 5.1. lmfit is not used for two reasons. It
gives standard errors without Student's distribution, so intervals from few residuals are too narrow. It also raises no
error if the data do not determine a parameter.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares
from scipy.stats import t as student

from array_types import Array

Residuals = Callable[[Array], Array]

CONFIDENCE = 0.95
STEP = 1e-4  # of the range of a parameter, for differences
NO_INFLUENCE = 1e-9  # of the largest influence of any parameter
INSEPARABLE = 0.98  # correlation above which an error names both parameters
AT_BOUND = 1e-6  # of the range


@dataclass(frozen=True)
class FreeParameter:
    """A parameter to be fitted: its name and its bounds, in any unit."""

    name: str
    lowest: float
    highest: float

    def __post_init__(self) -> None:
        if not (np.isfinite([self.lowest, self.highest]).all() and self.lowest < self.highest):
            bounds = f"{self.lowest:g} to {self.highest:g}"
            raise ValueError(f"{self.name}: bounds {bounds} are not allowed; they must be finite and ascending")


@dataclass(frozen=True)
class FittedParameter:
    """A fitted parameter: value, bounds of its 95 % interval, and whether it is at a bound of its range."""

    value: float
    lower: float
    upper: float
    at_bound: bool


@dataclass(frozen=True, eq=False)
class Fit:
    """Fitted parameters.

    parameters
        Parameters by name.
    correlation
        Correlation of the parameters, in the order of `parameters`, shape (m, m).
    rms_before, rms_after
        Root mean square of the residuals before and after the fit.
    residuals
        Number of residuals.
    """

    parameters: dict[str, FittedParameter]
    correlation: Array
    rms_before: float
    rms_after: float
    residuals: int


def fit(residuals: Residuals, free: Sequence[FreeParameter], start: Sequence[float]) -> Fit:
    """Return the parameters that minimise the sum of squares (1), with intervals.

    Parameters
    ----------
    residuals
        Function of the parameter values that returns residuals of equal expected size, shape (n,).
    free
        Parameters with bounds.
    start
        Initial values, within the bounds.

    Raises
    ------
    ValueError
        If there are not more residuals than parameters, if the start is outside the bounds, or if the data do not
        determine a parameter. A parameter is not determined if it has no influence, or if its interval is wider than
        its bounds.
    """
    first = residuals(np.asarray(start, np.float64))
    best = minimised(residuals, free, start)
    before, after = (float(np.sqrt(np.mean(r**2))) for r in (first, residuals(best)))
    parameters, correlation = intervals(residuals, free, best)
    return Fit(parameters, correlation, before, after, len(first))


def minimised(residuals: Residuals, free: Sequence[FreeParameter], start: Sequence[float] | Array) -> Array:
    """Return the values of the parameters that minimise (1); arguments and errors as for `fit`."""
    scaled, jacobian, low, span = _scaled(residuals, free)
    u0 = (np.asarray(start, np.float64) - low) / span
    for p, value, u in zip(free, start, u0, strict=True):
        if not 0.0 <= u <= 1.0:
            raise ValueError(
                f"{p.name} = {value:g} is not allowed; its start value must be from {p.lowest:g} to {p.highest:g}"
            )
    n, m = len(scaled(u0)), len(free)
    if n <= m:
        raise ValueError(
            f"{n} residuals are not enough for {m} parameters; measure more points, or fit fewer parameters"
        )
    _refuse_without_influence(free, jacobian(np.clip(u0, 0.02, 0.98)))
    result = least_squares(scaled, np.clip(u0, 1e-3, 1.0 - 1e-3), jacobian, bounds=(0.0, 1.0), x_scale=1.0)
    return np.asarray(low + span * result.x)


def intervals(
    residuals: Residuals,
    free: Sequence[FreeParameter],
    best: Array,
    inflation: float = 1.0,
    equivalent: float | None = None,
    least: float = 0.0,
) -> tuple[dict[str, FittedParameter], Array]:
    """Return the parameters with intervals by (1), and their correlation, shape (m, m).

    Parameters
    ----------
    residuals, free
        As for `fit`.
    best
        Values at the minimum.
    inflation
        Factor on the covariance, above 1 if residuals depend on each other.
    equivalent
        Number of residuals that determine the parameters, if not all of them do.
    least
        Lower bound of s^2, which is 1 if the residuals are divided by standard deviations that may be too large.

    Raises
    ------
    ValueError
        If an interval is wider than the bounds of its parameter.
    """
    scaled, jacobian, low, span = _scaled(residuals, free)
    u = (best - low) / span
    J, r = jacobian(u), scaled(u)
    n, m = len(r), len(free)
    variance = inflation * max(float(r @ r) / (n - m), least)
    values, vectors = np.linalg.eigh(J.T @ J)
    cov = (vectors * (variance / np.maximum(values, 1e-300))) @ vectors.T
    deviation = np.sqrt(np.diag(cov))
    correlation = cov / np.maximum(np.outer(deviation, deviation), 1e-300)
    freedom = max(min(n, n if equivalent is None else equivalent) - m, 1.0)
    half = float(student.ppf(0.5 + 0.5 * CONFIDENCE, freedom)) * deviation
    _refuse_uncertain(free, half, correlation)
    fitted = {
        p.name: FittedParameter(float(v), float(v - h), float(v + h), bool(min(x, 1.0 - x) < AT_BOUND))
        for p, v, h, x in zip(free, best, half * span, u, strict=True)
    }
    return fitted, correlation


def leverages(residuals: Residuals, free: Sequence[FreeParameter], best: Array) -> Array:
    """Return the leverages of the residuals, which are the diagonal of J (J^T J)^-1 J^T, shape (n,)."""
    _, jacobian, low, span = _scaled(residuals, free)
    U, sizes, _ = np.linalg.svd(jacobian((best - low) / span), full_matrices=False)
    return np.asarray(np.sum(U[:, sizes > 1e-12 * sizes[0]] ** 2, axis=1))


def _scaled(residuals: Residuals, free: Sequence[FreeParameter]) -> tuple[Residuals, Residuals, Array, Array]:
    """Return residuals and Jacobian as functions of parameters from 0 to 1, and each parameter's minimum and range."""
    low, span = (np.array(v) for v in ([p.lowest for p in free], [p.highest - p.lowest for p in free]))

    def scaled(u: Array) -> Array:
        return residuals(low + span * u)

    def jacobian(u: Array) -> Array:
        columns, at = [], scaled(u)
        for k, h in enumerate(np.where(u < 0.5, STEP, -STEP)):
            shifted = u.copy()
            shifted[k] += h
            columns.append((scaled(shifted) - at) / h)
        return np.stack(columns, axis=1)

    return scaled, jacobian, low, span


def _refuse_without_influence(free: Sequence[FreeParameter], J: Array) -> None:
    sizes = np.linalg.norm(J, axis=0)
    for p, size in zip(free, sizes, strict=True):
        if size <= NO_INFLUENCE * max(float(sizes.max()), np.sqrt(len(J)) * 1e-6):
            raise ValueError(f"the data do not determine {p.name}: the residuals do not depend on it; leave it out")


def _refuse_uncertain(free: Sequence[FreeParameter], half: Array, correlation: Array) -> None:
    """Raise ValueError if the interval of a parameter is wider than its bounds."""
    for k, (p, width) in enumerate(zip(free, half, strict=True)):
        if width > 0.5:
            others = np.abs(correlation[k]).copy()
            others[k] = 0.0
            j = int(np.argmax(others))
            pair = f"; it cannot be separated from {free[j].name}" if others[j] > INSEPARABLE else ""
            range_ = f"{p.lowest:g} to {p.highest:g}"
            raise ValueError(
                f"the data do not determine {p.name}: its 95 % interval is wider than its allowed range, {range_}{pair}"
                "; leave it out, or measure at other points"
            )
