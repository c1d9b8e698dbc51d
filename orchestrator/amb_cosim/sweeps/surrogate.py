"""A Gaussian process over points of a sweep: expected values and their uncertainty.

    k(a, b) = s^2 M(|D (a - b)|) + n^2,  M(r) = (1 + sqrt(5) r + 5/3 r^2) exp(-sqrt(5) r)          (1)

Matern's kernel of 5/2 with a length for each axis and noise n, fitted by maximum likelihood: C. E. Rasmussen and C. K.
I. Williams, Gaussian Processes for Machine Learning (2006), chapters 2, 4 and 5. A periodic axis is a circle; its two
coordinates share a length.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from typing import Any

import numpy as np
from sklearn.exceptions import ConvergenceWarning
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import ConstantKernel, Matern, WhiteKernel

from array_types import Array

LENGTHS = (0.02, 0.5)  # of the kernel, in lengths of an axis
SCATTER = (1e-10, 0.1)  # n^2, over the variance of the values
JITTER = 1e-10  # added for numerical stability with equal points
SIZES = (0.1, 100.0)  # s^2, over the variance of the values


class _Shared(Matern):  # type: ignore[misc]  # scikit-learn has no types
    """Matern's kernel with a length per axis; `axis` is the axis of each coordinate."""

    def __init__(
        self,
        length_scale: Any = 1.0,
        length_scale_bounds: Any = LENGTHS,
        nu: float = 2.5,
        axis: tuple[int, ...] = (0,),
    ) -> None:
        super().__init__(length_scale, length_scale_bounds, nu)
        self.axis = axis

    def __call__(self, X: Any, Y: Any = None, eval_gradient: bool = False) -> Any:
        axis = np.asarray(self.axis)
        of_coordinates = Matern(np.atleast_1d(self.length_scale)[axis], nu=self.nu)
        if not eval_gradient:
            return of_coordinates(X, Y)
        K, slopes = of_coordinates(X, Y, eval_gradient=True)
        shared = (slopes[:, :, axis == k].sum(axis=2) for k in range(axis.max() + 1))
        return K, np.stack(list(shared), axis=2)


def coordinates(values: Sequence[Array], periods: Sequence[float | None]) -> tuple[Array, tuple[int, ...]]:
    """Return coordinates of points, shape (points, coordinates), and the axis of each.

    Parameters
    ----------
    values
        Values of each axis at the points.
    periods
        Period of each axis in its unit; None if it is not periodic.
    """
    columns: list[Array] = []
    axes: list[int] = []
    for k, (settings, period) in enumerate(zip(values, periods, strict=True)):
        if period is None:
            span = np.ptp(settings)
            columns.append((settings - settings.min()) / (span if span > 0.0 else 1.0))
        else:
            angle = 2.0 * np.pi * settings / period
            columns += [np.cos(angle) / (2.0 * np.pi), np.sin(angle) / (2.0 * np.pi)]
        axes += [k] * (1 if period is None else 2)
    return np.column_stack(columns), tuple(axes)


class Surrogate:
    """A Gaussian process (1) fitted to values at points.

    Parameters
    ----------
    points
        Coordinates, shape (n, coordinates).
    axis
        Axis of each coordinate.
    values
        Shape (n,), finite.
    """

    def __init__(self, points: Array, axis: tuple[int, ...], values: Array) -> None:
        lengths = np.full(max(axis) + 1, 0.3)
        kernel = ConstantKernel(1.0, SIZES) * _Shared(lengths, LENGTHS, axis=axis) + WhiteKernel(1e-6, SCATTER)
        search = {"n_restarts_optimizer": 2, "random_state": 0}
        self._process = GaussianProcessRegressor(kernel, alpha=JITTER, normalize_y=True, **search)
        self._points, self._values = points, values
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ConvergenceWarning)  # a length at its bound, or an early end of the fit
            self._process.fit(points, values)

    def with_values(self, points: Array, values: Array) -> Surrogate:
        """Return the process for other values, with the same lengths."""
        other = object.__new__(Surrogate)
        kernel = self._process.kernel_
        other._process = GaussianProcessRegressor(kernel, alpha=JITTER, optimizer=None, normalize_y=True)
        other._process.fit(points, values)
        other._points, other._values = points, values
        return other

    def believing(self, points: Array) -> Surrogate:
        """Return the process with its own means added as values at more points."""
        if not len(points):
            return self
        values = np.concatenate([self._values, self.at(points)[0]])
        return self.with_values(np.vstack([self._points, points]), values)

    def at(self, points: Array) -> tuple[Array, Array]:
        """Return mean and standard deviation at points."""
        mean, deviation = self._process.predict(points, return_std=True)
        return np.asarray(mean, np.float64), np.asarray(deviation, np.float64)
