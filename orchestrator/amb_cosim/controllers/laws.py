"""Conversion of a law u = K y in the usual forms to state-space matrices.

    python-control   StateSpace, TransferFunction (zpk gives one)
    scipy.signal     StateSpace, TransferFunction, ZerosPolesGain, dlti of these
    tuples           (A, B, C, D); (zeros, poles, gain); (numerator, denominator); D alone

Each library is imported only for its own objects.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from array_types import Array

FORMS = "a StateSpace or TransferFunction of control or scipy.signal, or arrays (A, B, C, D), (z, p, k) or (num, den)"


@dataclass(frozen=True)
class Law:
    """Matrices A, B, C, D; `sample_time` is None for a continuous law, and 0 if the time of a sampled law is unknown.

    Raises
    ------
    ValueError
        If the shapes do not match, or a number is complex or not finite.
    """

    A: Array
    B: Array
    C: Array
    D: Array
    sample_time: float | None = None

    def __post_init__(self) -> None:
        for name in "ABCD":
            object.__setattr__(self, name, _matrix(name, getattr(self, name)))
        n, (p, m) = len(self.A), self.D.shape
        for name, shape in {"A": (n, n), "B": (n, m), "C": (p, n)}.items():
            actual = getattr(self, name).shape
            if actual != shape:
                raise ValueError(
                    f"{name} of shape {actual} is not allowed; with A of shape {self.A.shape} and D of shape "
                    f"{self.D.shape} it must be {shape}"
                )


def law_of(K: Any, sampled: bool = False) -> Law:
    """Return the matrices of a law.

    Parameters
    ----------
    K
        The law in one of the forms above.
    sampled
        Whether arrays describe a sampled law.

    Raises
    ------
    ValueError
        If K has another form or numbers that are not allowed, or is a transfer function with more zeros than poles.
    """
    library = type(K).__module__.partition(".")[0]
    kind = type(K).__name__
    if isinstance(K, Law):
        return K
    if library == "control" and kind in ("StateSpace", "LinearICSystem"):
        return Law(K.A, K.B, K.C, K.D, _step_of(K.dt, 0.0))
    if library == "control" and kind == "TransferFunction":
        rows = [[_of_ratio(K.num[i][j], K.den[i][j]) for j in range(K.ninputs)] for i in range(K.noutputs)]
        return replace(_assembled(rows), sample_time=_step_of(K.dt, 0.0))
    if library == "scipy" and kind.startswith(("StateSpace", "TransferFunction", "ZerosPolesGain")):
        if kind.startswith("StateSpace"):
            return Law(K.A, K.B, K.C, K.D, _step_of(K.dt, None))
        parts = (K.num, K.den) if kind.startswith("TransferFunction") else (K.zeros, K.poles, K.gain)
        return replace(_of_arrays(parts), sample_time=_step_of(K.dt, None))
    if isinstance(K, tuple | list) and len(K) in (2, 3, 4) and not _is_matrix(K):
        return replace(_of_arrays(K), sample_time=0.0 if sampled else None)
    if isinstance(K, int | float | np.ndarray | list | tuple):
        D = np.atleast_2d(_numbers("D", K))
        return Law(np.zeros((0, 0)), np.zeros((0, D.shape[1])), np.zeros((D.shape[0], 0)), D, 0.0)
    raise ValueError(f"a controller of type {type(K).__name__} is not allowed; it must be {FORMS}")


def balancing_factors(A: Array) -> Array:
    """Return a factor for each state, a power of two, so that the rows and columns of A get similar norms."""
    from scipy.linalg import matrix_balance

    with np.errstate(invalid="ignore"):  # SciPy converts the factors to integers, too, which are not used
        _, (factors, _) = matrix_balance(A, permute=False, separate=True)
    return np.asarray(factors)


def series_of_sections(zeros: Any, poles: Any, gain: float) -> Law:
    """Return k prod(s - z) / prod(s - p) as sections of second order in series.

    Each section has two zeros and two poles, because a polynomial of high order would lose digits. A section with n
    poles and m zeros has the gain a^((n - m)/n), where a is the product of the magnitudes of its poles, so that the
    signals between sections are of similar size. The first section also has the remaining factor of k. If the first
    section had the whole factor k, the states of a low-pass of order 8 would differ by a factor of 1e26, and frequency
    responses would have no correct digit.
    """
    from scipy.signal import zpk2sos

    z, p = np.atleast_1d(np.asarray(zeros)), np.atleast_1d(np.asarray(poles))
    for name, roots in (("zeros", z), ("poles", p)):
        if not np.isfinite(roots).all():
            raise ValueError(f"{name} = {roots} is not allowed; they must be finite")
    if len(z) > len(p):
        raise ValueError(
            f"{len(z)} zeros with {len(p)} poles is not allowed; there must be at least as many poles as zeros"
        )
    if not np.isfinite(gain):
        raise ValueError(f"gain = {gain} is not allowed; it must be finite")
    if not len(p):
        return law_of(float(gain))
    try:
        sections = zpk2sos(z, p, 1.0, analog=True)
    except ValueError as error:
        raise ValueError(f"zeros {z} and poles {p} are not allowed: {error}") from error
    gains = [_section_gain(section[:3], section[3:]) for section in sections[1:]]
    law = law_of(1.0)
    for section, of_section in zip(sections, [gain / math.prod(gains), *gains], strict=True):
        law = in_series(law, _of_ratio(of_section * section[:3], section[3:]))
    return law


def _section_gain(numerator: Array, denominator: Array) -> float:
    n, m = (len(np.trim_zeros(polynomial, "f")) - 1 for polynomial in (denominator, numerator))
    product = abs(float(denominator[-1]))
    return float(product ** ((n - m) / n)) if product > 0.0 else 1.0


def static(D: Array) -> Law:
    """Return a law without states."""
    p, m = D.shape
    return Law(np.zeros((0, 0)), np.zeros((0, m)), np.zeros((p, 0)), D)


def delayed(count: int, samples: int) -> Law:
    """Return a law that delays `count` signals by a number of samples."""
    unit_delay = Law(np.zeros((count, count)), np.eye(count), np.eye(count), np.zeros((count, count)))
    law = static(np.eye(count))
    for _ in range(samples):
        law = in_series(law, unit_delay)
    return law


def in_series(first: Law, then: Law) -> Law:
    """Return the laws `first` and `then` in series."""
    n, m = len(first.A), len(then.A)
    A = np.block([[first.A, np.zeros((n, m))], [then.B @ first.C, then.A]])
    return Law(A, np.vstack([first.B, then.B @ first.D]), np.hstack([then.D @ first.C, then.C]), then.D @ first.D)


def side_by_side(laws: Sequence[Law]) -> Law:
    """Return independent laws as one law with block-diagonal matrices."""
    from scipy.linalg import block_diag

    return Law(*(block_diag(*(getattr(law, name) for law in laws)) for name in "ABCD"))


def _assembled(rows: Sequence[Sequence[Law]]) -> Law:
    """Return a matrix of single-signal laws as one law."""
    stacked = side_by_side([law for row in rows for law in row])
    p, m = len(rows), len(rows[0])
    from_signals, to_demands = np.tile(np.eye(m), (p, 1)), np.kron(np.eye(p), np.ones((1, m)))
    return Law(stacked.A, stacked.B @ from_signals, to_demands @ stacked.C, to_demands @ stacked.D @ from_signals)


def _of_arrays(parts: Sequence[Any]) -> Law:
    if len(parts) == 4:
        A, B, C, D = (np.atleast_2d(_numbers(name, part)) for name, part in zip("ABCD", parts, strict=True))
        return Law(A, B, C, D)
    if len(parts) == 3:
        return series_of_sections(*parts)
    return _of_ratio(*parts)


def _of_ratio(numerator: Any, denominator: Any) -> Law:
    """Return a ratio of polynomials, highest power first, in controllable canonical form."""
    num = np.trim_zeros(np.atleast_1d(_numbers("numerator", numerator)), "f")
    den = np.trim_zeros(np.atleast_1d(_numbers("denominator", denominator)), "f")
    if not len(den):
        raise ValueError("denominator = 0 is not allowed; it must have a nonzero coefficient")
    if len(num) > len(den):
        raise ValueError(
            f"a numerator of degree {len(num) - 1} over a denominator of degree {len(den) - 1} is not allowed; a law "
            "must be proper: add poles, such as the roll-off of a derivative"
        )
    n = len(den) - 1
    a, b = den[1:] / den[0], np.concatenate([np.zeros(len(den) - len(num)), num]) / den[0]
    A = np.eye(n, k=-1)
    A[:1] = -a[None, :]
    return Law(A, np.eye(n, 1), (b[1:] - a * b[0])[None, :], np.array([[b[0]]]))


def _step_of(dt: Any, continuous: float | None) -> float | None:
    """Return the sample time that a library states: None for a continuous law, 0 if the time is unspecified."""
    if dt is None or dt is False or (dt == continuous and dt is not True):
        return None
    return 0.0 if dt is True else float(dt)


def _is_matrix(K: Any) -> bool:
    """Return whether a list is a matrix of numbers rather than a tuple of matrices."""
    return isinstance(K, list) and all(isinstance(row, list) and all(np.isscalar(x) for x in row) for row in K)


def _numbers(name: str, value: Any) -> Any:
    try:
        array = np.asarray(value)
        if np.iscomplexobj(array):
            if np.any(array.imag != 0.0):
                raise ValueError("complex")
            array = array.real
        return array.astype(np.float64)
    except (TypeError, ValueError):
        raise ValueError(f"{name} is not allowed; it must be an array of real numbers") from None


def _matrix(name: str, value: Any) -> Array:
    matrix = _numbers(name, value)
    if matrix.ndim != 2:
        raise ValueError(
            f"{name} of shape {matrix.shape} is not allowed; it must have two dimensions, rows and columns"
        )
    if not np.isfinite(matrix).all():
        raise ValueError(f"{name} contains numbers that are not finite")
    return np.ascontiguousarray(matrix)
