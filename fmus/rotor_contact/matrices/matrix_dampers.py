"""Heat of all dampers over a piece, as a quadratic form of x (`step_matrices`).

    D(h) = int_0^h [v^T C v + (v - Omega J q)^T R (v - Omega J q)] dt = x^T H x

C contains the dampers of passive bearings, of mounts, of seals, and between shaft and ground; R contains the dampers
that rotate with the shaft. Quadrature over a piece would not resolve modes that vibrate several times in
it; H covers these modes. The H of the shortest piece follows from Lobatto's quadrature, and the H of longer pieces from
doubling. With x' and x'' at the beginnings of the two halves (`matrix_rows`),

    D(2 T) = x'^T H(T) x' + x''^T H(T) x''

Only the lower triangle is stored, and its elements off the diagonal are doubled. For an isotropic rotor, rows for y
equal the rows for x with each pair turned by a right angle, as in P and S.
"""

from __future__ import annotations

import math

from fmi_export.flat import copy
from fmi_export.jit import kernel, noinline_kernel
from fmi_export.model import Array
from rotor_contact.contact.site import Sites
from rotor_contact.forces.dynamics import Motion
from rotor_contact.forces.passive_bearings import is_damping
from rotor_contact.matrices.step_matrices import StepMatrices, inner_motion, level_of, rows_of_x, unbalances_of
from rotor_contact.shaft.lobatto import FIRST_HALF, LOBATTO_WEIGHTS, N_LOBATTO, SECOND_PART
from rotor_contact.shaft.products import (
    dot,
    dot_between,
    four_dots,
    isotropic_dots,
    isotropic_dots_between,
    row_combination,
    two_dots_between,
    two_isotropic_dots_between,
)
from rotor_contact.shaft.seals import add_seal_heat
from rotor_contact.shaft.structure import Structure


@kernel
def are_there_dampers(structure: Structure, motion: Motion, sites: Sites) -> bool:
    """Return whether shaft, passive bearings or mounts dissipate energy."""
    m = structure.K.shape[0]
    for i in range(m):
        if structure.forms[m + i, i] != 0.0 or structure.forms[2 * m + i, i] != 0.0:
            return True
    for bearing in motion.bearings:
        if is_damping(bearing):
            return True
    for site in sites:
        if site.housing >= 0 and (site.mount_damping_x != 0.0 or site.mount_damping_y != 0.0):
            return True
    return False


@noinline_kernel
def integrate_heat_row(
    structure: Structure,
    motion: Motion,
    sites: Sites,
    matrices: StepMatrices,
    slot: int,
    level: int,
    row: int,
    Omega: float,
    room: Array,
) -> None:
    """Write a row of H of the shortest piece, from the motion at its Lobatto points."""
    n = int(matrices.sizes[0].n)
    y, damped, rest = room[: 2 * n], room[2 * n : 4 * n], room[4 * n :]
    target = level_of(matrices, slot, level).H[row]
    target[: row + 1] = 0.0
    for point in range(N_LOBATTO):
        move_to(matrices, slot, level, row, point, y)
        _apply_dampers(structure, motion, sites, Omega, y, damped, rest)
        add_point(matrices, slot, level, row, point, damped, target)


@kernel
def move_to(matrices: StepMatrices, slot: int, level: int, row: int, point: int, y: Array) -> None:
    """Write (q, v) at a Lobatto point of a piece that starts with a 1 in this row of x and zeros in all others."""
    P, inner = level_of(matrices, slot, level).P, inner_motion(matrices, slot, level)
    if point > 0:
        copy((P if point == N_LOBATTO - 1 else (inner.first if point == 1 else inner.second))[row], y)
    else:
        y[:] = 0.0
        if row < y.shape[0]:
            y[row] = 1.0


@kernel
def add_point(
    matrices: StepMatrices, slot: int, level: int, row: int, point: int, applied: Array, target: Array
) -> None:
    """Add a Lobatto point's part to a row of a form; `applied` is the symmetric matrix times the row's motion."""
    P, inner = level_of(matrices, slot, level).P, inner_motion(matrices, slot, level)
    share = matrices.sizes[0].step_size * 0.5**level * LOBATTO_WEIGHTS[point]
    for s in range(row + 1):
        weight = share if s == row else 2.0 * share
        if point > 0:
            other = (P if point == N_LOBATTO - 1 else (inner.first if point == 1 else inner.second))[s]
            target[s] += weight * dot(applied, other)
        elif s < applied.shape[0]:
            target[s] += weight * applied[s]


@kernel
def _apply_dampers(
    structure: Structure, motion: Motion, sites: Sites, Omega: float, y: Array, damped: Array, room: Array
) -> None:
    """Multiply y = (q, v) by the symmetric matrix of the dampers' heat; write the product into `damped`."""
    n, m = y.shape[0] // 2, structure.K.shape[0]
    C, R = structure.forms[m : 2 * m], structure.forms[2 * m : 3 * m]
    q, v, x, of_x = y[:n], y[n:], room[:m], room[m : 2 * m]
    damped[:] = 0.0
    copy(v[:m], x)
    row_combination(x, C, of_x, m)
    copy(of_x, damped[n : n + m])
    for i in range(0, m, 2):
        x[i], x[i + 1] = v[i] + Omega * q[i + 1], v[i + 1] - Omega * q[i]
    row_combination(x, R, of_x, m)
    for i in range(0, m, 2):
        damped[i], damped[i + 1] = -Omega * of_x[i + 1], Omega * of_x[i]
    for i in range(m):
        damped[n + i] += of_x[i]
    for bearing in motion.bearings:
        for i in range(bearing.row, bearing.row + 2):
            damped[n + i] += bearing.c_b * v[i]
    for site in sites:
        if site.housing >= 0:
            damped[n + site.housing] += site.mount_damping_x * v[site.housing]
            damped[n + site.housing + 1] += site.mount_damping_y * v[site.housing + 1]
    add_seal_heat(motion.seals, Omega, y, n, damped)


@noinline_kernel
def double_form_row(
    matrices: StepMatrices,
    slot: int,
    level: int,
    row: int,
    Omega: float,
    second: Array,
    room: Array,
    finer: Array,
    target: Array,
) -> None:
    """Write a row of a form from `finer`, the form for half the piece; `second` is x'' if this row of x is 1."""
    sizes, P = matrices.sizes[0], level_of(matrices, slot, level + 1).P
    n, axes, size = int(sizes.n), 2 * int(sizes.n_ports), second.shape[0]
    forces, units = 2 * n + 4, rows_of_x(matrices)
    unbalances = units + 2 * unbalances_of(matrices)
    end = 2 * n if row < 2 * n else (units if row < units else size)  # of the elements that the row requires
    of_first, of_second, carried = room[:end], room[size : size + end], room[2 * size : 2 * size + end]
    of_first[:] = 0.0
    if row < 2 * n or row >= units:
        _add_row(finer, row, 1.0, of_first)
    else:
        for j in range(N_LOBATTO):
            point, axis = (row - forces) // axes, (row - forces) % axes
            _add_row(finer, forces + axes * j + axis, FIRST_HALF[j][point], of_first)
    _multiply(finer, second, 2 * n, of_second)
    of_motion = of_second[: 2 * n]
    for s in range(end):
        carried[s] = dot(of_motion, P[s])
    angle = Omega * sizes.step_size * 0.5 ** (level + 1)
    c, s_ = math.cos(angle), math.sin(angle)
    for s in range(units, min(unbalances, end)):
        carried[s] += of_second[s]
    for s in range(unbalances, end, 2):
        a, b = of_second[s], of_second[s + 1]
        carried[s] += c * a + s_ * b
        carried[s + 1] += c * b - s_ * a
    for s in range(row + 1):
        value = 0.0
        if s < 2 * n or s >= units:
            value = of_first[s] + carried[s]
        elif s >= forces:
            point, axis = (s - forces) // axes, (s - forces) % axes
            for j in range(N_LOBATTO):
                at = forces + axes * j + axis
                value += FIRST_HALF[j][point] * (of_first[at] + carried[at])
                value += SECOND_PART[N_LOBATTO - 2][j][point] * of_second[at]
        target[s] = value if s == row else 2.0 * value


@kernel
def _add_row(H: Array, row: int, weight: float, y: Array) -> None:
    """Add the first elements of `weight` times a row of the symmetric matrix to y."""
    half, end = 0.5 * weight, y.shape[0]
    for s in range(min(row, end)):
        y[s] += half * H[row, s]
    if row < end:
        y[row] += weight * H[row, row]
    for s in range(row + 1, end):
        y[s] += half * H[s, row]


@kernel
def _multiply(H: Array, x: Array, n_dense: int, y: Array) -> None:
    """Write the first elements of the symmetric matrix times x into y; few elements of x after `n_dense` are not 0."""
    dense = x[:n_dense]
    for r in range(n_dense):
        row, half = H[r], 0.5 * x[r]
        y[r] = 0.5 * dot(row[:r], x[:r]) + row[r] * x[r]
        for s in range(r):
            y[s] += half * row[s]
    for r in range(n_dense, y.shape[0]):
        y[r] = 0.5 * dot(H[r, :n_dense], dense)
    for r in range(n_dense, x.shape[0]):
        if x[r] != 0.0:
            _add_row(H, r, x[r], y)


@noinline_kernel
def form_of_piece(x: Array, low: Array, high: Array, share: float, isotropic: bool) -> float:
    """Return x^T H x, with H interpolated between two speeds; an isotropic rotor requires only every second row."""
    energy = 0.0
    if isotropic:
        for r in range(0, x.shape[0], 2):
            if x[r] != 0.0 or x[r + 1] != 0.0:
                part_of_x, row = x[: r + 2], low[r, : r + 2]
                if share == 0.0:
                    of_x = isotropic_dots(row, part_of_x)
                else:
                    of_x = isotropic_dots_between(row, high[r, : r + 2], share, part_of_x)
                energy += x[r] * of_x.real + x[r + 1] * of_x.imag
        return energy
    for r in range(x.shape[0]):
        if x[r] != 0.0:
            part_of_x, row = x[: r + 1], low[r, : r + 1]
            of_x = dot(part_of_x, row) if share == 0.0 else dot_between(part_of_x, row, high[r, : r + 1], share)
            energy += x[r] * of_x
    return energy


@noinline_kernel
def heat_and_impulse_between(
    x: Array, H_low: Array, H_high: Array, T_low: Array, T_high: Array, share: float, weight: float, isotropic: bool
) -> tuple[float, float]:
    """Return x^T H x and x^T T x at a point between two speeds, in one pass: H + weight (T_high - T_low), and T."""
    heat = impulse = 0.0
    if isotropic:
        for r in range(0, x.shape[0], 2):
            if x[r] != 0.0 or x[r + 1] != 0.0:
                end = r + 2
                of_H, of_T = two_isotropic_dots_between(
                    x[:end], H_low[r, :end], H_high[r, :end], T_low[r, :end], T_high[r, :end], share, weight
                )
                heat += x[r] * of_H.real + x[r + 1] * of_H.imag
                impulse += x[r] * of_T.real + x[r + 1] * of_T.imag
        return heat, impulse
    for r in range(x.shape[0]):
        if x[r] != 0.0:
            end = r + 1
            heat_of_x, impulse_of_x = two_dots_between(
                x[:end], H_low[r, :end], H_high[r, :end], T_low[r, :end], T_high[r, :end], share, weight
            )
            heat += x[r] * heat_of_x
            impulse += x[r] * impulse_of_x
    return heat, impulse


@noinline_kernel
def four_forms(x: Array, A: Array, B: Array, C: Array, D: Array, isotropic: bool) -> tuple[float, float, float, float]:
    """Return x^T A x, x^T B x, x^T C x and x^T D x in one pass."""
    a = b = c = d = 0.0
    if isotropic:
        for r in range(0, x.shape[0], 2):
            if x[r] != 0.0 or x[r + 1] != 0.0:
                end, u, v = r + 2, x[r], x[r + 1]
                of_A, of_B = isotropic_dots(A[r, :end], x[:end]), isotropic_dots(B[r, :end], x[:end])
                of_C, of_D = isotropic_dots(C[r, :end], x[:end]), isotropic_dots(D[r, :end], x[:end])
                a += u * of_A.real + v * of_A.imag
                b += u * of_B.real + v * of_B.imag
                c += u * of_C.real + v * of_C.imag
                d += u * of_D.real + v * of_D.imag
        return a, b, c, d
    for r in range(x.shape[0]):
        if x[r] != 0.0:
            end, u = r + 1, x[r]
            in_a, in_b, in_c, in_d = four_dots(x[:end], A[r, :end], B[r, :end], C[r, :end], D[r, :end])
            a += u * in_a
            b += u * in_b
            c += u * in_c
            d += u * in_d
    return a, b, c, d
