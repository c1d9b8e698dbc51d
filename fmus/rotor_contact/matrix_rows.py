"""Rows of the matrices: the shortest level by Taylor series in time, the others by doubling.

A piece of twice the length is two pieces in sequence. The cubic force over it is a cubic over either half, so
with Y_i, the motion up to Lobatto point c_i of a piece of length T,

    Y_i(2 T): x -> Y_i(T) (y, e, F'') with y = Y_i(T) (q, v, e, F'),  F'_j = F(c_j/2),  F''_j = F((c_i + c_j)/2)

where F is the cubic over [0, 1] through the values, and e the effect of steady forces and unbalance, the latter turned
by Omega c_i T. P is Y_3.
"""

from __future__ import annotations

import math

from fmi_export.flat import copy
from fmi_export.jit import kernel, noinline_kernel
from fmi_export.model import Array
from rotor_contact.dynamics import Motion
from rotor_contact.lobatto import FIRST_HALF, LAGRANGE, LOBATTO_POINTS, N_LOBATTO, SECOND_PART
from rotor_contact.matrix_dampers import double_heat_row, integrate_heat_row
from rotor_contact.matrix_levels import begin_slot
from rotor_contact.products import rotate_row, row_combination
from rotor_contact.site import Sites
from rotor_contact.speed_grid import grid_speed
from rotor_contact.step_matrices import (
    PORT_COLUMNS,
    StepMatrices,
    coefficients_at,
    inner_motion,
    level_of,
    n_rows,
    place_index,
    velocity_index,
)
from rotor_contact.structure import Structure


@noinline_kernel
def build_slot(
    structure: Structure, motion: Motion, sites: Sites, matrices: StepMatrices, which: int, index: float, share: float
) -> None:
    """Build the levels for a speed of the grid, in the slot `which`, until a share of their rows (0 to 1) is built."""
    sizes, slot = matrices.sizes[0], matrices.slots[which]
    n, Omega = int(sizes.n), grid_speed(matrices, index)
    rows = n_rows(n, int(sizes.n_ports))
    if slot.index != index:
        begin_slot(structure, motion, sites, matrices, which, index, Omega)
    x = matrices.pieces[:rows]
    room = matrices.pieces[rows:]
    while slot.n_rows < share * rows * sizes.n_built:
        done = int(slot.n_rows)
        level, row = int(sizes.n_built) - 1 - done // rows, done % rows
        _write_acceleration(structure, sites, matrices, which, level, row)
        if level == int(sizes.n_built) - 1:
            _integrate_row(structure, sites, matrices, which, level, row, Omega, room)
        else:
            _double_row(matrices, which, level, row, Omega, x)
        _observe_row(matrices, which, level, row)
        if sizes.damped != 0.0:
            if level == int(sizes.n_built) - 1:
                integrate_heat_row(structure, motion, sites, matrices, which, level, row, Omega, room)
            else:
                double_heat_row(matrices, which, level, row, Omega, x, room)
        slot.n_rows += 1.0
        if slot.isotropic != 0.0:
            _rotate_rows(matrices, which, level, row)
            slot.n_rows += 1.0


@kernel
def _rotate_rows(matrices: StepMatrices, slot: int, level: int, row: int) -> None:
    """Write the rows for y from the last rows, which are for x."""
    (P, S, H), inner = level_of(matrices, slot, level), inner_motion(matrices, slot, level)
    rotate_row(P[row], P[row + 1])
    rotate_row(S[row], S[row + 1])
    rotate_row(inner.first[row], inner.first[row + 1])
    rotate_row(inner.second[row], inner.second[row + 1])
    H[row, row + 1] = 0.0
    rotate_row(H[row, : row + 2], H[row + 1])


@kernel
def share_of(matrices: StepMatrices, which: int, index: float) -> float:
    """Return the share of rows complete for a speed of the grid in the slot `which`."""
    sizes, slot = matrices.sizes[0], matrices.slots[which]
    if slot.index != index:
        return 0.0
    share: float = slot.n_rows / (n_rows(int(sizes.n), int(sizes.n_ports)) * sizes.n_built)
    return share


@kernel
def is_complete(matrices: StepMatrices, which: int, index: float) -> bool:
    """Return whether all levels for a speed of the grid are complete in the slot `which`."""
    sizes, slot = matrices.sizes[0], matrices.slots[which]
    return bool(slot.index == index and slot.n_rows == n_rows(int(sizes.n), int(sizes.n_ports)) * sizes.n_built)


@kernel
def _add_force(
    structure: Structure, sites: Sites, matrices: StepMatrices, row: int, cosine: float, sine: float, a: Array
) -> None:
    """Add to `a` the acceleration due to the force of a row of x, which is `cosine` times its initial value.

    The unbalance force has turned: `sine` times the force of the other direction is added.
    """
    sizes = matrices.sizes[0]
    n, m = int(sizes.n), structure.K.shape[0]
    port_forces = matrices.key.forces
    if row < 2 * n:
        return
    if row == 2 * n:
        if cosine != 0.0:
            for j in range(m):
                force = cosine * port_forces[0, j]
                if force != 0.0:
                    for i in range(m):
                        a[i] += structure.Minv[j, i] * force
            for site in sites:
                if site.housing >= 0:
                    a[site.housing] -= cosine * site.base_x
                    a[site.housing + 1] -= cosine * site.base_y
    elif row == 2 * n + 1:
        return
    elif row < 2 * n + 4:
        turned = sine if row == 2 * n + 2 else -sine
        for j in range(m):
            c, s = port_forces[1, j], port_forces[2, j]
            force = cosine * c + turned * s if row == 2 * n + 2 else cosine * s + turned * c
            if force != 0.0:
                for i in range(m):
                    a[i] += structure.Minv[j, i] * force
    else:
        number = (row - 2 * n - 4) % (2 * int(sizes.n_ports))
        column = int(matrices.ports[number // 2]) + number % 2
        if column < m:
            for i in range(m):
                a[i] += structure.Minv[column, i] * cosine
        else:
            for site in sites:
                if site.housing >= 0 and site.housing == column - number % 2:
                    a[column] += site.mobility * cosine


@kernel
def _write_acceleration(
    structure: Structure, sites: Sites, matrices: StepMatrices, slot: int, level: int, row: int
) -> None:
    """Write the observations (S) of the initial acceleration."""
    S = level_of(matrices, slot, level).S
    KC = coefficients_at(matrices, slot).columns
    n = KC.shape[1]
    a = matrices.pieces[matrices.pieces.shape[0] - n :]
    for i in range(n):
        a[i] = -KC[row, i] if row < 2 * n else 0.0
    if row < 2 * n + 4 + 2 * int(matrices.sizes[0].n_ports):  # later forces begin at zero
        _add_force(structure, sites, matrices, row, 1.0, 0.0, a)
    _observe(matrices, a, S[row], 0, 2, 2)


@kernel
def _observe(matrices: StepMatrices, x: Array, observed: Array, unbalance: int, first: int, stride: int) -> None:
    """Write the observations of displacements, velocities or accelerations x to `observed`.

    Unbalance is written to the columns from `unbalance`, port k to those from first + stride k.
    """
    n_ports, port_forces = int(matrices.sizes[0].n_ports), matrices.key.forces
    for port in range(n_ports):
        row, at = int(matrices.ports[port]), first + stride * port
        observed[at], observed[at + 1] = x[row], x[row + 1]
    cosine = sine = 0.0
    for i in range(port_forces.shape[1]):
        cosine += port_forces[1, i] * x[i]
        sine += port_forces[2, i] * x[i]
    observed[unbalance], observed[unbalance + 1] = cosine, sine


@kernel
def _observe_row(matrices: StepMatrices, slot: int, level: int, row: int) -> None:
    """Write the observations (S) at the Lobatto points after the first."""
    P, S, _ = level_of(matrices, slot, level)
    n, n_ports = P.shape[1] // 2, int(matrices.sizes[0].n_ports)
    inner = inner_motion(matrices, slot, level)
    for point in range(N_LOBATTO - 1):
        motion = P[row] if point == N_LOBATTO - 2 else (inner.first if point == 0 else inner.second)[row]
        place, velocity = place_index(n_ports, point + 1, 0), velocity_index(n_ports, point + 1, 0)
        _observe(matrices, motion[:n], S[row], place - PORT_COLUMNS, place, PORT_COLUMNS)
        _observe(matrices, motion[n:], S[row], velocity - PORT_COLUMNS, velocity, PORT_COLUMNS)


@kernel
def _integrate_row(
    structure: Structure,
    sites: Sites,
    matrices: StepMatrices,
    slot: int,
    level: int,
    row: int,
    Omega: float,
    room: Array,
) -> None:
    """Taylor-integrate the motion due to a unit of x over the shortest piece, term by term in t/h."""
    sizes = matrices.sizes[0]
    n = int(sizes.n)
    h = sizes.step_size * 0.5**level
    KC = coefficients_at(matrices, slot).columns
    end = level_of(matrices, slot, level).P[row]
    inner = inner_motion(matrices, slot, level)
    first, second = inner.first[row], inner.second[row]
    y, a = room[: 2 * n], room[2 * n : 3 * n]
    y[:] = 0.0
    if row < 2 * n:
        y[row] = 1.0
    copy(y, first)
    copy(y, second)
    copy(y, end)
    point = (row - 2 * n - 4) // (2 * int(sizes.n_ports)) if row >= 2 * n + 4 else -1
    cosine, sine = 1.0, 0.0  # terms of cos(Omega t) and sin(Omega t)
    p_1 = p_2 = 1.0
    for term in range(1, int(matrices.slots[slot].n_terms) + 1):
        dt = h / term
        row_combination(y, KC, a, n)
        for i in range(n):
            a[i] = -a[i]
        if point >= 0:
            if term <= N_LOBATTO:
                _add_force(structure, sites, matrices, row, LAGRANGE[point][term - 1], 0.0, a)
        elif row > 2 * n or term == 1:
            _add_force(structure, sites, matrices, row, cosine, sine, a)
        angle = Omega * dt
        cosine, sine = -angle * sine, angle * cosine
        p_1 *= LOBATTO_POINTS[1]
        p_2 *= LOBATTO_POINTS[2]
        for i in range(n):
            y[i] = dt * y[n + i]
            y[n + i] = dt * a[i]
        for i in range(2 * n):
            first[i] += p_1 * y[i]
            second[i] += p_2 * y[i]
            end[i] += y[i]


@kernel
def _double_row(matrices: StepMatrices, slot: int, level: int, row: int, Omega: float, x: Array) -> None:
    """Write a row of a level from the level of half its length."""
    n = int(matrices.sizes[0].n)
    target_motion, new_ends = inner_motion(matrices, slot, level), level_of(matrices, slot, level).P
    finer, ends = inner_motion(matrices, slot, level + 1), level_of(matrices, slot, level + 1).P
    for i in range(N_LOBATTO - 1):
        _begin_part(matrices, slot, level, row, Omega, i, x)
        Y = ends if i == 2 else (finer.first if i == 0 else finer.second)
        target = (new_ends if i == 2 else (target_motion.first if i == 0 else target_motion.second))[row]
        row_combination(x, Y, target, 2 * n)


@kernel
def _begin_part(matrices: StepMatrices, slot: int, level: int, row: int, Omega: float, i: int, x: Array) -> None:
    """Write x after the time c_i T, due to a unit in this row at the beginning; T is half the length of the level."""
    sizes = matrices.sizes[0]
    n, axes = int(sizes.n), 2 * int(sizes.n_ports)
    forces = 2 * n + 4
    point, axis = (row - forces) // axes, (row - forces) % axes
    finer, ends = inner_motion(matrices, slot, level + 1), level_of(matrices, slot, level + 1).P
    Y = ends if i == 2 else (finer.first if i == 0 else finer.second)
    x[:] = 0.0
    if row < forces:
        copy(Y[row], x)
    else:
        for j in range(N_LOBATTO):
            weight = FIRST_HALF[j][point]
            for c in range(2 * n):
                x[c] += weight * Y[forces + axes * j + axis, c]
            x[forces + axes * j + axis] = SECOND_PART[i][j][point]
    angle = Omega * LOBATTO_POINTS[i + 1] * (sizes.step_size * 0.5 ** (level + 1))
    if row == 2 * n or row == 2 * n + 1:
        x[row] = 1.0
    elif row == 2 * n + 2:
        x[2 * n + 2], x[2 * n + 3] = math.cos(angle), math.sin(angle)
    elif row == 2 * n + 3:
        x[2 * n + 2], x[2 * n + 3] = -math.sin(angle), math.cos(angle)
