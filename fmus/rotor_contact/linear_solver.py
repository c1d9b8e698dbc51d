"""Solution of small dense systems of linear equations."""

from __future__ import annotations

from fmi_export.jit import kernel
from fmi_export.model import Array

SMALLEST_PIVOT = 1e-300


@kernel
def solve(equations: Array, n: int, rhs: int) -> bool:
    """Solve the first `n` equations by Gaussian elimination with partial pivoting; return False if they are singular.

    The right-hand side is column `rhs` of `equations`; the solution replaces it.
    """
    for i in range(n):
        best = i
        for r in range(i + 1, n):
            if abs(equations[r, i]) > abs(equations[best, i]):
                best = r
        if not abs(equations[best, i]) > SMALLEST_PIVOT:
            return False
        if best != i:
            for c in range(i, n):
                equations[i, c], equations[best, c] = equations[best, c], equations[i, c]
            equations[i, rhs], equations[best, rhs] = equations[best, rhs], equations[i, rhs]
        for r in range(i + 1, n):
            ratio = equations[r, i] / equations[i, i]
            if ratio != 0.0:
                for c in range(i + 1, n):
                    equations[r, c] -= ratio * equations[i, c]
                equations[r, rhs] -= ratio * equations[i, rhs]
    for i in range(n - 1, -1, -1):
        for c in range(i + 1, n):
            equations[i, rhs] -= equations[i, c] * equations[c, rhs]
        equations[i, rhs] /= equations[i, i]
    return True
