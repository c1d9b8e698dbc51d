"""Solution of small dense systems of linear equations."""

from __future__ import annotations

from typing import NamedTuple

from fmi_export.jit import kernel, views
from fmi_export.model import Array
from fmi_export.parts import part
from rotor_contact.shaft.structure import REAL

SMALLEST_PIVOT = 1e-300


class Equations(NamedTuple):
    """Room for A x = b: `matrix` A, shape (n, n), and `right_side` b, shape (n,), which the solution replaces."""

    matrix: Array
    right_side: Array


@views
def equations_of(work: Array, start: int, n: int) -> Equations:
    """Return room for n equations, which consists of n (n + 1) numbers of an array from `start`."""
    return Equations(part(work, start, REAL, (n, n)), part(work, start + n * n, REAL, n))


@kernel
def solve(equations: Equations, n: int) -> bool:
    """Solve the first `n` equations by Gaussian elimination with pivoting; return False if they are singular."""
    A, b = equations
    for i in range(n):
        best = i
        for r in range(i + 1, n):
            if abs(A[r, i]) > abs(A[best, i]):
                best = r
        if not abs(A[best, i]) > SMALLEST_PIVOT:
            return False
        if best != i:
            for c in range(i, n):
                A[i, c], A[best, c] = A[best, c], A[i, c]
            b[i], b[best] = b[best], b[i]
        A[i, i] = 1.0 / A[i, i]
        for r in range(i + 1, n):
            ratio = A[r, i] * A[i, i]
            if ratio != 0.0:
                for c in range(i + 1, n):
                    A[r, c] -= ratio * A[i, c]
                b[r] -= ratio * b[i]
    for i in range(n - 1, -1, -1):
        for c in range(i + 1, n):
            b[i] -= A[i, c] * b[c]
        b[i] *= A[i, i]
    return True
