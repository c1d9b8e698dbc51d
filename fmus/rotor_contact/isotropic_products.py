"""Products for an isotropic rotor: what looks the same from all sides answers to y as to x, turned."""

from __future__ import annotations

from fmi_export.jit import kernel
from fmi_export.model import Array
from fmi_export.parts import part
from rotor_contact.products import row_combination
from rotor_contact.structure import REAL


@kernel
def rotate_row(of_x: Array, of_y: Array) -> None:
    """Write the answer to y, which is that to x turned by a right angle; both are x and y in turn."""
    for i in range(0, of_x.shape[0], 2):
        of_y[i], of_y[i + 1] = -of_x[i + 1], of_x[i]


@kernel
def isotropic_combination(x: Array, A: Array, y: Array, size: int, isotropic: bool, single: int) -> None:
    """Write the first `size` numbers of x A, an even number, into `y`, as `row_combination` does.

    Of an isotropic rotor rows are answers to x and y in turn, but for row `single`, and those to y are not read.
    """
    if not isotropic:
        row_combination(x, A, y, size)
        return
    i = 0
    while i + 8 <= size:
        a = b = c = d = e = f = g = h = 0.0
        k = m = n = o = p = q = r = s = 0.0
        for j in range(0, single, 2):
            row, v, w = part(A, j * A.shape[1] + i, REAL, 8), x[j], x[j + 1]
            a += v * row[0]
            b += v * row[1]
            c += v * row[2]
            d += v * row[3]
            e += v * row[4]
            f += v * row[5]
            g += v * row[6]
            h += v * row[7]
            k += w * row[0]
            m += w * row[1]
            n += w * row[2]
            o += w * row[3]
            p += w * row[4]
            q += w * row[5]
            r += w * row[6]
            s += w * row[7]
        if single < x.shape[0]:
            row, v = part(A, single * A.shape[1] + i, REAL, 8), x[single]
            a += v * row[0]
            b += v * row[1]
            c += v * row[2]
            d += v * row[3]
            e += v * row[4]
            f += v * row[5]
            g += v * row[6]
            h += v * row[7]
        for j in range(single + 1, x.shape[0], 2):
            row, v, w = part(A, j * A.shape[1] + i, REAL, 8), x[j], x[j + 1]
            a += v * row[0]
            b += v * row[1]
            c += v * row[2]
            d += v * row[3]
            e += v * row[4]
            f += v * row[5]
            g += v * row[6]
            h += v * row[7]
            k += w * row[0]
            m += w * row[1]
            n += w * row[2]
            o += w * row[3]
            p += w * row[4]
            q += w * row[5]
            r += w * row[6]
            s += w * row[7]
        y[i], y[i + 1], y[i + 2], y[i + 3] = a - m, b + k, c - o, d + n
        y[i + 4], y[i + 5], y[i + 6], y[i + 7] = e - q, f + p, g - s, h + r
        i += 8
    while i < size:
        a = b = k = m = 0.0
        j = 0
        while j < x.shape[0]:
            v, w, of_x, of_y = x[j], 0.0, A[j, i], A[j, i + 1]
            if j == single:
                j += 1
            else:
                w = x[j + 1]
                j += 2
            a += v * of_x
            b += v * of_y
            k += w * of_x
            m += w * of_y
        y[i], y[i + 1] = a - m, b + k
        i += 2
