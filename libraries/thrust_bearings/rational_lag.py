"""A half-order lag as a sum of first-order lags, with its error over a band.

    G(s) = 1/(1 + sqrt(s/omega_e)) = int_0^inf r(p)/(s + p) dp                                                (1)
    r(p) = sqrt(p/omega_e)/(pi (1 + p/omega_e)) > 0

so that G is a sum of first-order lags with positive weights. The approximation has the same form and static gain 1:

    G_n(s) = d + sum c_k p_k/(s + p_k),   c_k > 0,   d = 1 - sum c_k >= 0                                     (2)

Poles are spaced evenly on a logarithmic axis, from a decade below the band to two above it. The weights c_k >= 0
minimise the squares of the relative error of 1 - G_n(s) = sum c_k s/(s + p_k) on the imaginary axis. Such a lag is
passive at any order: a poor fit cannot make an unstable or active bearing. The order is the least whose largest error
|G_n/G - 1| within the band is below a tolerance.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.optimize import nnls

from amb_files.checks import require
from array_types import Array, Complex
from thrust_bearings.eddy_currents import half_order_lag

TOLERANCE = 1e-3
BELOW, ABOVE = 10.0, 100.0  # by which the poles exceed the band
MOST_POLES = 40
POINTS = 40  # per decade, at which the error is evaluated


@dataclass(frozen=True)
class RationalLag:
    """A sum of first-order lags (2).

    poles, weights
        p_k (rad/s) and c_k (1), shape (n,) each; no pole is the lag 1.
    error
        Largest relative error within the band (1).
    """

    poles: Array
    weights: Array
    error: float = 0.0

    @property
    def feedthrough(self) -> float:
        """d of (2), the part without lag (1)."""
        return 1.0 - float(self.weights.sum())

    def response(self, s: Complex) -> Complex:
        """Return G_n (1) at complex frequencies s (rad/s)."""
        s = np.asarray(s, dtype=np.complex128)[..., None]
        return np.asarray(self.feedthrough + np.sum(self.weights * self.poles / (s + self.poles), axis=-1))

    def state_space(self) -> tuple[Array, Array, Array, Array]:
        """Return A, B, C, D of a realisation in parallel, x_k' = p_k (u - x_k), y = sum c_k x_k + d u."""
        D = np.array([[self.feedthrough]])
        return np.diag(-self.poles), self.poles[:, None], self.weights[None, :], D


NO_LAG = RationalLag(np.zeros(0), np.zeros(0))


@lru_cache(maxsize=16)  # every loop of a bearing has the same one
def rational_lag(omega_e: float, band: tuple[float, float], tolerance: float = TOLERANCE) -> RationalLag:
    """Return the sum of the fewest first-order lags that approximates a half-order lag within a band.

    Parameters
    ----------
    omega_e
        Corner frequency of the half-order lag (rad/s).
    band
        Lowest and highest frequency of the band (rad/s).
    tolerance
        Largest relative error within it (1).

    Raises
    ------
    ValueError
        If a number is not allowed, or `MOST_POLES` poles do not suffice.
    """
    low, high = band
    require(0.0 < omega_e < math.inf, "omega_e", f"{omega_e:g} rad/s", "> 0 rad/s")
    require(0.0 < low < high < math.inf, "band", f"{low:g} to {high:g} rad/s", "of ascending frequencies > 0 rad/s")
    require(1e-6 <= tolerance < 1.0, "tolerance", f"{tolerance:g}", ">= 1e-6 and < 1")
    decades = math.log10(high / low)
    s = (1j * np.geomspace(low, high, 1 + math.ceil(POINTS * max(decades, 1.0)))).astype(np.complex128)
    for n in range(2, MOST_POLES + 1):
        lag = _fitted(omega_e, s, np.geomspace(low / BELOW, high * ABOVE, n))
        if lag.error <= tolerance and lag.feedthrough >= 0.0:
            return lag
    raise ValueError(
        f"tolerance = {tolerance:g} is not allowed over {decades:.1f} decades; {MOST_POLES} poles reach {lag.error:.2g}"
    )


def _fitted(omega_e: float, s: Complex, poles: Array) -> RationalLag:
    """Return the sum of lags with these poles and the best weights on points of the imaginary axis."""
    exact = half_order_lag(s, omega_e)
    columns = (s[:, None] / (s[:, None] + poles)) / exact[:, None]
    target = (1.0 - exact) / exact
    weights, _ = nnls(np.vstack([columns.real, columns.imag]), np.concatenate([target.real, target.imag]))
    lag = RationalLag(poles, weights)
    error = float(np.abs(lag.response(s) / exact - 1.0).max())
    used = weights > 0.0
    return RationalLag(poles[used], weights[used], error)
