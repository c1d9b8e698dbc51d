"""Products of a matrix and a vector, with independent partial sums."""

from __future__ import annotations

from fmi_export.flat import copy
from fmi_export.jit import inlined_kernel, kernel, noinline_kernel
from fmi_export.model import Array
from fmi_export.parts import part
from rotor_contact.shaft.structure import REAL


@kernel
def are_any(a: float, b: float, c: float, d: float) -> bool:
    """Return whether at least one of four numbers is not zero."""
    return a != 0.0 or b != 0.0 or c != 0.0 or d != 0.0


@noinline_kernel
def row_combination(x: Array, A: Array, y: Array, size: int) -> None:
    """Write the first `size` numbers of x A (rows of A weighted with x) into `y`, which must not overlap the rows.

    The matrix is read in order, four rows at once; rows with weight zero are skipped.
    """
    inlined_row_combination(x, A, y, size)


@inlined_kernel
def inlined_row_combination(x: Array, A: Array, y: Array, size: int) -> None:
    """Do the same as `row_combination` without a call, for short rows of a known size."""
    for i in range(size):
        y[i] = 0.0
    j = 0
    while j + 4 <= x.shape[0]:
        v, w, p, q = x[j], x[j + 1], x[j + 2], x[j + 3]
        if are_any(v, w, p, q):
            a, b, c, d = A[j], A[j + 1], A[j + 2], A[j + 3]
            for i in range(size):
                y[i] += (v * a[i] + w * b[i]) + (p * c[i] + q * d[i])
        j += 4
    while j < x.shape[0]:
        v, a = x[j], A[j]
        for i in range(size):
            y[i] += v * a[i]
        j += 1


@noinline_kernel
def combination(x: Array, A: Array, y: Array, first: int, size: int) -> None:
    """Write `size` numbers of x A, from column `first`, into y.

    As in `row_combination`, four rows are read at once, and rows with weight zero are skipped.
    """
    for i in range(size):
        y[i] = 0.0
    add_combination(x, A, y, first, size)


@noinline_kernel
def add_combination(x: Array, A: Array, y: Array, first: int, size: int) -> None:
    """Add `size` numbers of x A, from column `first`, to y."""
    j = 0
    while j + 4 <= x.shape[0]:
        v, w, p, q = x[j], x[j + 1], x[j + 2], x[j + 3]
        if are_any(v, w, p, q):
            a, b, c, d = A[j, first:], A[j + 1, first:], A[j + 2, first:], A[j + 3, first:]
            for i in range(size):
                y[i] += (v * a[i] + w * b[i]) + (p * c[i] + q * d[i])
        j += 4
    while j < x.shape[0]:
        v, a = x[j], A[j, first:]
        for i in range(size):
            y[i] += v * a[i]
        j += 1


@noinline_kernel
def add_multiples(x: Array, a: float, y: Array, b: float, z: Array, target: Array, size: int) -> None:
    """Write `size` numbers of x + a y + b z into `target`."""
    for i in range(size):
        target[i] = x[i] + a * y[i] + b * z[i]


@noinline_kernel
def interpolate(low: Array, high: Array, share: float, target: Array, size: int) -> None:
    """Write `size` numbers of (1 - share) low + share high into `target`."""
    if share == 0.0:
        copy(low[:size], target)
        return
    rest = 1.0 - share
    for i in range(size):
        target[i] = rest * low[i] + share * high[i]


@noinline_kernel
def combination_between(x: Array, A: Array, B: Array, share: float, y: Array, first: int, size: int) -> None:
    """Write x [(1 - share) A + share B], from column `first`, into y, with the same bits as `combination`."""
    rest = 1.0 - share
    for i in range(size):
        y[i] = 0.0
    j = 0
    while j + 4 <= x.shape[0]:
        v, w, p, q = x[j], x[j + 1], x[j + 2], x[j + 3]
        if are_any(v, w, p, q):
            a, b, c, d = A[j, first:], A[j + 1, first:], A[j + 2, first:], A[j + 3, first:]
            e, f, g, h = B[j, first:], B[j + 1, first:], B[j + 2, first:], B[j + 3, first:]
            for i in range(size):
                r_1, r_2 = rest * a[i] + share * e[i], rest * b[i] + share * f[i]
                r_3, r_4 = rest * c[i] + share * g[i], rest * d[i] + share * h[i]
                y[i] += (v * r_1 + w * r_2) + (p * r_3 + q * r_4)
        j += 4
    while j < x.shape[0]:
        v, a, b = x[j], A[j, first:], B[j, first:]
        for i in range(size):
            y[i] += v * (rest * a[i] + share * b[i])
        j += 1


@noinline_kernel
def isotropic_combination(x: Array, A: Array, y: Array, turned: Array, first: int, size: int) -> None:
    """Write the same as `combination` for rows that are alternately responses to x and y.

    The responses to y are not read, because the response to (v, w) is v times the response to x, plus w times the
    response to x turned by a right angle. `turned` is scratch of the size of y.
    """
    for i in range(size):
        y[i] = turned[i] = 0.0
    j = 0
    while j + 8 <= x.shape[0]:
        v_1, w_1, v_2, w_2 = x[j], x[j + 1], x[j + 2], x[j + 3]
        v_3, w_3, v_4, w_4 = x[j + 4], x[j + 5], x[j + 6], x[j + 7]
        if are_any(v_1, w_1, v_2, w_2) or are_any(v_3, w_3, v_4, w_4):
            a, b, c, d = A[j, first:], A[j + 2, first:], A[j + 4, first:], A[j + 6, first:]
            for i in range(size):
                y[i] += (v_1 * a[i] + v_2 * b[i]) + (v_3 * c[i] + v_4 * d[i])
                turned[i] += (w_1 * a[i] + w_2 * b[i]) + (w_3 * c[i] + w_4 * d[i])
        j += 8
    while j < x.shape[0]:
        v, w, a = x[j], x[j + 1], A[j, first:]
        for i in range(size):
            y[i] += v * a[i]
            turned[i] += w * a[i]
        j += 2
    for i in range(0, size, 2):
        y[i] -= turned[i + 1]
        y[i + 1] += turned[i]


@noinline_kernel
def isotropic_combination_between(
    x: Array, A: Array, B: Array, share: float, y: Array, turned: Array, first: int, size: int
) -> None:
    """Write the same as `combination_between`, bit-identical to `isotropic_combination` of interpolated rows."""
    rest = 1.0 - share
    for i in range(size):
        y[i] = turned[i] = 0.0
    j = 0
    while j + 8 <= x.shape[0]:
        v_1, w_1, v_2, w_2 = x[j], x[j + 1], x[j + 2], x[j + 3]
        v_3, w_3, v_4, w_4 = x[j + 4], x[j + 5], x[j + 6], x[j + 7]
        if are_any(v_1, w_1, v_2, w_2) or are_any(v_3, w_3, v_4, w_4):
            a, b, c, d = A[j, first:], A[j + 2, first:], A[j + 4, first:], A[j + 6, first:]
            e, f, g, h = B[j, first:], B[j + 2, first:], B[j + 4, first:], B[j + 6, first:]
            for i in range(size):
                r_1, r_2 = rest * a[i] + share * e[i], rest * b[i] + share * f[i]
                r_3, r_4 = rest * c[i] + share * g[i], rest * d[i] + share * h[i]
                y[i] += (v_1 * r_1 + v_2 * r_2) + (v_3 * r_3 + v_4 * r_4)
                turned[i] += (w_1 * r_1 + w_2 * r_2) + (w_3 * r_3 + w_4 * r_4)
        j += 8
    while j < x.shape[0]:
        v, w, a, b = x[j], x[j + 1], A[j, first:], B[j, first:]
        for i in range(size):
            r = rest * a[i] + share * b[i]
            y[i] += v * r
            turned[i] += w * r
        j += 2
    for i in range(0, size, 2):
        y[i] -= turned[i + 1]
        y[i + 1] += turned[i]


@kernel
def rotate_row(of_x: Array, of_y: Array) -> None:
    """Write the response to y, which is the response to x turned by a right angle; both alternate between x and y."""
    for i in range(0, of_x.shape[0], 2):
        of_y[i], of_y[i + 1] = -of_x[i + 1], of_x[i]


@kernel
def subtract_products(A: Array, x: Array, B: Array, y: Array, target: Array) -> None:
    """Subtract x A + y B (rows of square A and B, weighted with x and y) from the beginning of `target`."""
    n = A.shape[1]
    i = 0
    while i + 8 <= n:
        t = part(target, i, REAL, 8)
        a, b, c, d, e, f, g, h = t[0], t[1], t[2], t[3], t[4], t[5], t[6], t[7]
        for j in range(n):
            v, w, p, q = x[j], y[j], part(A, j * n + i, REAL, 8), part(B, j * n + i, REAL, 8)
            a -= p[0] * v + q[0] * w
            b -= p[1] * v + q[1] * w
            c -= p[2] * v + q[2] * w
            d -= p[3] * v + q[3] * w
            e -= p[4] * v + q[4] * w
            f -= p[5] * v + q[5] * w
            g -= p[6] * v + q[6] * w
            h -= p[7] * v + q[7] * w
        t[0], t[1], t[2], t[3], t[4], t[5], t[6], t[7] = a, b, c, d, e, f, g, h
        i += 8
    while i < n:
        a = target[i]
        for j in range(n):
            a -= A[j, i] * x[j] + B[j, i] * y[j]
        target[i] = a
        i += 1


@kernel
def dot(x: Array, y: Array) -> float:
    """Return x . y for two arrays of the same size."""
    a = b = c = d = 0.0
    i = 0
    while i + 4 <= x.shape[0]:
        u, v = part(x, i, REAL, 4), part(y, i, REAL, 4)
        a += u[0] * v[0]
        b += u[1] * v[1]
        c += u[2] * v[2]
        d += u[3] * v[3]
        i += 4
    while i < x.shape[0]:
        a += x[i] * y[i]
        i += 1
    return (a + b) + (c + d)


@kernel
def dot_between(x: Array, y: Array, z: Array, share: float) -> float:
    """Return x . [(1 - share) y + share z] with the same bits as `dot`."""
    rest = 1.0 - share
    a = b = c = d = 0.0
    i = 0
    while i + 4 <= x.shape[0]:
        u, v, w = part(x, i, REAL, 4), part(y, i, REAL, 4), part(z, i, REAL, 4)
        a += u[0] * (rest * v[0] + share * w[0])
        b += u[1] * (rest * v[1] + share * w[1])
        c += u[2] * (rest * v[2] + share * w[2])
        d += u[3] * (rest * v[3] + share * w[3])
        i += 4
    while i < x.shape[0]:
        a += x[i] * (rest * y[i] + share * z[i])
        i += 1
    return (a + b) + (c + d)


@kernel
def four_dots(x: Array, A: Array, B: Array, C: Array, D: Array) -> tuple[float, float, float, float]:
    """Return x . A, x . B, x . C and x . D."""
    a = b = c = d = e = f = g = h = 0.0
    i = 0
    while i + 2 <= x.shape[0]:
        u, p, q = part(x, i, REAL, 2), part(A, i, REAL, 2), part(B, i, REAL, 2)
        r, s = part(C, i, REAL, 2), part(D, i, REAL, 2)
        a += u[0] * p[0]
        b += u[1] * p[1]
        c += u[0] * q[0]
        d += u[1] * q[1]
        e += u[0] * r[0]
        f += u[1] * r[1]
        g += u[0] * s[0]
        h += u[1] * s[1]
        i += 2
    if i < x.shape[0]:
        a += x[i] * A[i]
        c += x[i] * B[i]
        e += x[i] * C[i]
        g += x[i] * D[i]
    return a + b, c + d, e + f, g + h


@kernel
def two_dots_between(
    x: Array, A: Array, B: Array, C: Array, D: Array, share: float, weight: float
) -> tuple[float, float]:
    """Return x . [(1 - share) A + share B + weight (D - C)] and x . [(1 - share) C + share D], bits as `dot`."""
    rest = 1.0 - share
    a = b = c = d = e = f = g = h = 0.0
    i = 0
    while i + 4 <= x.shape[0]:
        u, p, q = part(x, i, REAL, 4), part(A, i, REAL, 4), part(B, i, REAL, 4)
        r, s = part(C, i, REAL, 4), part(D, i, REAL, 4)
        a += u[0] * (rest * p[0] + share * q[0] + weight * (s[0] - r[0]))
        b += u[1] * (rest * p[1] + share * q[1] + weight * (s[1] - r[1]))
        c += u[2] * (rest * p[2] + share * q[2] + weight * (s[2] - r[2]))
        d += u[3] * (rest * p[3] + share * q[3] + weight * (s[3] - r[3]))
        e += u[0] * (rest * r[0] + share * s[0])
        f += u[1] * (rest * r[1] + share * s[1])
        g += u[2] * (rest * r[2] + share * s[2])
        h += u[3] * (rest * r[3] + share * s[3])
        i += 4
    while i < x.shape[0]:
        a += x[i] * (rest * A[i] + share * B[i] + weight * (D[i] - C[i]))
        e += x[i] * (rest * C[i] + share * D[i])
        i += 1
    return (a + b) + (c + d), (e + f) + (g + h)


@kernel
def isotropic_dots(x: Array, y: Array) -> complex:
    """Return x . y + i x . y', where y' is y with each pair (u, v) turned back by a right angle, (v, -u)."""
    a = b = c = d = e = f = g = h = 0.0
    i = 0
    while i + 4 <= x.shape[0]:
        u, v = part(x, i, REAL, 4), part(y, i, REAL, 4)
        a += u[0] * v[0]
        b += u[1] * v[1]
        c += u[2] * v[2]
        d += u[3] * v[3]
        e += u[0] * v[1]
        f += u[1] * v[0]
        g += u[2] * v[3]
        h += u[3] * v[2]
        i += 4
    while i < x.shape[0]:
        a += x[i] * y[i]
        b += x[i + 1] * y[i + 1]
        e += x[i] * y[i + 1]
        f += x[i + 1] * y[i]
        i += 2
    return complex((a + b) + (c + d), (e + g) - (f + h))


@kernel
def isotropic_dots_between(x: Array, z: Array, share: float, y: Array) -> complex:
    """Return `isotropic_dots` of (1 - share) x + share z and y, identical in every bit."""
    rest = 1.0 - share
    a = b = c = d = e = f = g = h = 0.0
    i = 0
    while i + 4 <= x.shape[0]:
        u, w, v = part(x, i, REAL, 4), part(z, i, REAL, 4), part(y, i, REAL, 4)
        r_1, r_2 = rest * u[0] + share * w[0], rest * u[1] + share * w[1]
        r_3, r_4 = rest * u[2] + share * w[2], rest * u[3] + share * w[3]
        a += r_1 * v[0]
        b += r_2 * v[1]
        c += r_3 * v[2]
        d += r_4 * v[3]
        e += r_1 * v[1]
        f += r_2 * v[0]
        g += r_3 * v[3]
        h += r_4 * v[2]
        i += 4
    while i < x.shape[0]:
        r_1, r_2 = rest * x[i] + share * z[i], rest * x[i + 1] + share * z[i + 1]
        a += r_1 * y[i]
        b += r_2 * y[i + 1]
        e += r_1 * y[i + 1]
        f += r_2 * y[i]
        i += 2
    return complex((a + b) + (c + d), (e + g) - (f + h))


@kernel
def two_isotropic_dots_between(
    x: Array, A: Array, B: Array, C: Array, D: Array, share: float, weight: float
) -> tuple[complex, complex]:
    """Return `isotropic_dots` of x and the combinations of A to D in `two_dots_between`, identical in every bit."""
    rest = 1.0 - share
    a = b = c = d = e = f = g = h = 0.0
    k = s = m = n = o = p = q = r = 0.0
    i = 0
    while i + 4 <= x.shape[0]:
        v, of_A, of_B = part(x, i, REAL, 4), part(A, i, REAL, 4), part(B, i, REAL, 4)
        of_C, of_D = part(C, i, REAL, 4), part(D, i, REAL, 4)
        h_1 = rest * of_A[0] + share * of_B[0] + weight * (of_D[0] - of_C[0])
        h_2 = rest * of_A[1] + share * of_B[1] + weight * (of_D[1] - of_C[1])
        h_3 = rest * of_A[2] + share * of_B[2] + weight * (of_D[2] - of_C[2])
        h_4 = rest * of_A[3] + share * of_B[3] + weight * (of_D[3] - of_C[3])
        a += h_1 * v[0]
        b += h_2 * v[1]
        c += h_3 * v[2]
        d += h_4 * v[3]
        e += h_1 * v[1]
        f += h_2 * v[0]
        g += h_3 * v[3]
        h += h_4 * v[2]
        t_1, t_2 = rest * of_C[0] + share * of_D[0], rest * of_C[1] + share * of_D[1]
        t_3, t_4 = rest * of_C[2] + share * of_D[2], rest * of_C[3] + share * of_D[3]
        k += t_1 * v[0]
        s += t_2 * v[1]
        m += t_3 * v[2]
        n += t_4 * v[3]
        o += t_1 * v[1]
        p += t_2 * v[0]
        q += t_3 * v[3]
        r += t_4 * v[2]
        i += 4
    while i < x.shape[0]:
        h_1 = rest * A[i] + share * B[i] + weight * (D[i] - C[i])
        h_2 = rest * A[i + 1] + share * B[i + 1] + weight * (D[i + 1] - C[i + 1])
        a += h_1 * x[i]
        b += h_2 * x[i + 1]
        e += h_1 * x[i + 1]
        f += h_2 * x[i]
        t_1, t_2 = rest * C[i] + share * D[i], rest * C[i + 1] + share * D[i + 1]
        k += t_1 * x[i]
        s += t_2 * x[i + 1]
        o += t_1 * x[i + 1]
        p += t_2 * x[i]
        i += 2
    heat = complex((a + b) + (c + d), (e + g) - (f + h))
    return heat, complex((k + s) + (m + n), (o + q) - (p + r))


@kernel
def triangular_form(A: Array, x: Array, size: int) -> float:
    """Return x^T A x for the first `size` numbers of x, where A is lower triangular and `size` is even."""
    return _form(A, x, size, 1)


@kernel
def quadratic_form(A: Array, x: Array) -> float:
    """Return x^T A x for the first n numbers of x and the first n rows of A, which has n columns; n is even."""
    return _form(A, x, A.shape[1], 0)


@inlined_kernel
def _form(A: Array, x: Array, size: int, triangular: int) -> float:
    """Return x^T A x, eight columns at once; `triangular` is 1 if columns begin at the diagonal, else 0."""
    n = A.shape[1]
    total = rest = 0.0
    i = 0
    while i + 8 <= size:
        a = b = c = d = e = f = g = h = 0.0
        first = i * triangular
        for j in range(size - first):  # from 0: an index that may be negative is checked in each pass
            w, row = part(x, first + j, REAL, 1)[0], part(A, (first + j) * n + i, REAL, 8)
            a += w * row[0]
            b += w * row[1]
            c += w * row[2]
            d += w * row[3]
            e += w * row[4]
            f += w * row[5]
            g += w * row[6]
            h += w * row[7]
        y = part(x, i, REAL, 8)
        total += (a * y[0] + c * y[2]) + (e * y[4] + g * y[6])
        rest += (b * y[1] + d * y[3]) + (f * y[5] + h * y[7])
        i += 8
    while i < size:
        a = b = 0.0
        for j in range(i * triangular, size):
            w, row = x[j], part(A, j * n + i, REAL, 2)
            a += w * row[0]
            b += w * row[1]
        total += a * x[i]
        rest += b * x[i + 1]
        i += 2
    return total + rest
