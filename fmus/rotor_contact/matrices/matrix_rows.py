"""Rows of the matrices, computed by Taylor series in time for the shortest piece and by doubling for longer ones.

A piece of twice the length consists of two pieces in sequence. A force that is a cubic over the piece is also a cubic
over either half. Therefore, with Y_i, the motion up to Lobatto point c_i of a piece of length T,

    Y_i(2 T): x -> Y_i(T) (y, e, F'') with y = Y_i(T) (q, v, e, F'),  F'_j = F(c_j/2),  F''_j = F((c_i + c_j)/2)

where F is the cubic over [0, 1] through the values, and e are the unit inputs (`excitation`); those that are unbalances
turn by Omega c_i T. P is Y_3.
"""

from __future__ import annotations

import math

from fmi_export.flat import copy
from fmi_export.jit import inlined_kernel, kernel, noinline_kernel
from fmi_export.model import Array
from rotor_contact.contact.site import Sites
from rotor_contact.forces.dynamics import Motion
from rotor_contact.forces.excitation import OF_HOUSINGS, component
from rotor_contact.matrices.matrix_dampers import double_form_row, integrate_heat_row
from rotor_contact.matrices.matrix_levels import begin_slot, can_be_built, terms_for
from rotor_contact.matrices.matrix_powers import double_power_rows, integrate_power_rows
from rotor_contact.matrices.matrix_sizes import PLANE_COLUMNS, PORT_COLUMNS, place_index
from rotor_contact.matrices.speed_grid import grid_speed
from rotor_contact.matrices.step_matrices import (
    StepMatrices,
    coefficients_at,
    inner_motion,
    level_of,
    powers_of,
    rows_of_x,
    unbalances_of,
)
from rotor_contact.shaft.lobatto import FIRST_HALF, LAGRANGE, LOBATTO_POINTS, N_LOBATTO, SECOND_PART
from rotor_contact.shaft.products import dot, rotate_row, row_combination
from rotor_contact.shaft.structure import ROWS_OF_FACE, Structure, row_of_face, rows_of_faces


@noinline_kernel
def build_slot(
    structure: Structure, motion: Motion, sites: Sites, matrices: StepMatrices, which: int, index: float, share: float
) -> None:
    """Build the levels for a speed of the grid in the slot `which`, until a share (0 to 1) of their rows is built."""
    sizes, slot = matrices.sizes[0], matrices.slots[which]
    n, rows, Omega = int(sizes.n), int(sizes.n_rows), grid_speed(matrices, index)
    if slot.index != index:
        begin_slot(structure, motion, sites, matrices, which, index, Omega)
    if not can_be_built(matrices, which):
        return
    x = matrices.pieces[:rows]
    room = matrices.pieces[rows:]
    while slot.n_rows < share * rows * sizes.n_built:
        done = int(slot.n_rows)
        level, row = int(sizes.n_built) - 1 - done // rows, done % rows
        if 2 * n <= row < 2 * n + 4:  # combined when they are used (`matrix_inputs`)
            _clear_row(matrices, which, level, row)
            slot.n_rows += 1.0
            continue
        _write_acceleration(structure, sites, matrices, which, level, row)
        if level == int(sizes.n_built) - 1:
            _integrate_row(structure, sites, matrices, which, level, row, Omega, room)
        else:
            _double_row(matrices, which, level, row, Omega, x)
        _observe_row(structure, matrices, which, level, row)
        if sizes.damped != 0.0:
            if level == int(sizes.n_built) - 1:
                integrate_heat_row(structure, motion, sites, matrices, which, level, row, Omega, room)
            else:
                finer, target = level_of(matrices, which, level + 1).H, level_of(matrices, which, level).H[row]
                double_form_row(matrices, which, level, row, Omega, x, room, finer, target)
        if sizes.powered != 0.0:
            if level == int(sizes.n_built) - 1:
                integrate_power_rows(structure, motion, matrices, which, level, row, Omega, room)
            else:
                double_power_rows(matrices, which, level, row, Omega, x, room)
        slot.n_rows += 1.0
        if slot.isotropic != 0.0:
            _rotate_rows(matrices, which, level, row)
            slot.n_rows += 1.0


@kernel
def _clear_row(matrices: StepMatrices, slot: int, level: int, row: int) -> None:
    """Set a row to zero."""
    (P, S, H, U), inner = level_of(matrices, slot, level), inner_motion(matrices, slot, level)
    P[row] = 0.0
    S[row] = 0.0
    H[row] = 0.0
    U[row] = 0.0
    inner.first[row] = 0.0
    inner.second[row] = 0.0
    if matrices.sizes[0].powered != 0.0:
        powers_of(matrices, slot, level).spin[row] = 0.0
        powers_of(matrices, slot, level).seals[row] = 0.0


@kernel
def _rotate_rows(matrices: StepMatrices, slot: int, level: int, row: int) -> None:
    """Write the row for y of each matrix from `row`, which is the row for x."""
    (P, S, H, U), inner = level_of(matrices, slot, level), inner_motion(matrices, slot, level)
    rotate_row(P[row], P[row + 1])
    rotate_row(S[row], S[row + 1])
    rotate_row(U[row], U[row + 1])
    rotate_row(inner.first[row], inner.first[row + 1])
    rotate_row(inner.second[row], inner.second[row + 1])
    _rotate_form(H, row)
    if matrices.sizes[0].powered != 0.0:
        _rotate_form(powers_of(matrices, slot, level).spin, row)
    if matrices.sizes[0].powered == 2.0:
        _rotate_form(powers_of(matrices, slot, level).seals, row)


@kernel
def _rotate_form(H: Array, row: int) -> None:
    """Write the row for y of a form from `row`, which is the row for x."""
    H[row, row + 1] = 0.0
    rotate_row(H[row, : row + 2], H[row + 1])


@kernel
def share_of(matrices: StepMatrices, which: int, index: float) -> float:
    """Return the share of complete rows for a speed of the grid in the slot `which`."""
    sizes, slot = matrices.sizes[0], matrices.slots[which]
    if slot.index != index:
        return 0.0
    share: float = slot.n_rows / (sizes.n_rows * sizes.n_built)
    return share


@inlined_kernel
def is_complete(matrices: StepMatrices, which: int, index: float) -> bool:
    """Return whether all levels for a speed of the grid are complete in the slot `which`."""
    sizes, slot = matrices.sizes[0], matrices.slots[which]
    return bool(slot.index == index and slot.n_rows == sizes.n_rows * sizes.n_built)


@kernel
def _unit_of(matrices: StepMatrices, row: int) -> int:
    """Return the unit input of a row, or a negative number for a row of the state or of a node force."""
    return row - rows_of_x(matrices)


@kernel
def _add_force(
    structure: Structure, sites: Sites, matrices: StepMatrices, row: int, cosine: float, sine: float, a: Array
) -> None:
    """Add to `a` the acceleration due to the force of a row of x; this force is `cosine` times its initial value.

    An unbalance force also turns: `sine` times the force that is a right angle ahead of it is added.
    """
    sizes = matrices.sizes[0]
    n, m, unit = int(sizes.n), structure.K.shape[0], _unit_of(matrices, row)
    if row < 2 * n:
        return
    if unit >= 0:
        pair, axis = unit // 2, unit % 2
        if pair == OF_HOUSINGS:
            for site in sites:
                if site.housing >= 0:
                    a[site.housing + axis] -= cosine
            return
        of_other = (sine if axis == 0 else -sine) if pair >= unbalances_of(matrices) else 0.0
        for j in range(m):
            force = cosine * component(structure, pair, axis, j)
            if of_other != 0.0:
                force += of_other * component(structure, pair, 1 - axis, j)
            if force != 0.0:
                for i in range(m):
                    a[i] += structure.Minv[j, i] * force
        return
    number = (row - 2 * n - 4) % (2 * int(sizes.n_ports))
    place = int(matrices.ports[number // 2])
    column = place + number % 2
    if place < 0:
        caused = rows_of_faces(structure).values[ROWS_OF_FACE // 2 + row_of_face(place) + number % 2]
        for i in range(m):
            a[i] += caused[i] * cosine
    elif column < m:
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
    _, S, _, U = level_of(matrices, slot, level)
    KC = coefficients_at(matrices, slot).columns
    n = KC.shape[1]
    a = matrices.pieces[matrices.pieces.shape[0] - n :]
    for i in range(n):
        a[i] = -KC[row, i] if row < 2 * n else 0.0
    if row < 2 * n + 4 + 2 * int(matrices.sizes[0].n_ports) or _unit_of(matrices, row) >= 0:
        _add_force(structure, sites, matrices, row, 1.0, 0.0, a)  # node forces at later points begin at zero
    _observe(structure, matrices, a, S[row], 2, 2)
    _observe_planes(structure, a, U[row], 0)


@kernel
def _observe(structure: Structure, matrices: StepMatrices, x: Array, observed: Array, first: int, stride: int) -> None:
    """Write the displacements, velocities or accelerations x at each port k to the columns from first + stride k."""
    for port in range(int(matrices.sizes[0].n_ports)):
        row, at = int(matrices.ports[port]), first + stride * port
        if row < 0:
            rows, row, of_shaft = rows_of_faces(structure).values, row_of_face(row), x[: structure.K.shape[0]]
            observed[at], observed[at + 1] = dot(rows[row], of_shaft), dot(rows[row + 1], of_shaft)
        else:
            observed[at], observed[at + 1] = x[row], x[row + 1]


@kernel
def _observe_planes(structure: Structure, x: Array, observed: Array, at: int) -> None:
    """Write b_x . x and b_y . x, for the unit forces of each unbalance, to the columns of its plane, from `at`."""
    n_discs, of_shaft = structure.B_disc.shape[0] // 2, x[: structure.K.shape[0]]
    for d in range(n_discs):
        for axis in range(2):
            observed[PLANE_COLUMNS * d + at + axis] = dot(structure.B_disc[2 * d + axis], of_shaft)
    for b in range(structure.bearings.shape[0]):
        for axis in range(2):
            observed[PLANE_COLUMNS * (n_discs + b) + at + axis] = x[int(structure.bearings[b]) + axis]


@kernel
def _observe_row(structure: Structure, matrices: StepMatrices, slot: int, level: int, row: int) -> None:
    """Write the observations (S, U) at the Lobatto points after the first."""
    P, S, _, U = level_of(matrices, slot, level)
    n, n_ports = P.shape[1] // 2, int(matrices.sizes[0].n_ports)
    inner = inner_motion(matrices, slot, level)
    for point in range(N_LOBATTO - 1):
        motion = P[row] if point == N_LOBATTO - 2 else (inner.first if point == 0 else inner.second)[row]
        for of_velocity in range(2):
            x, offset = motion[n * of_velocity : n * (of_velocity + 1)], 2 * of_velocity
            _observe(structure, matrices, x, S[row], place_index(n_ports, point + 1, 0) + offset, PORT_COLUMNS)
            _observe_planes(structure, x, U[row], 2 + 4 * point + offset)


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
    """Integrate the motion over the shortest piece, which starts with a 1 in this row of x, by Taylor series in t/h."""
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
    unit = _unit_of(matrices, row)
    point = (row - 2 * n - 4) // (2 * int(sizes.n_ports)) if row >= 2 * n + 4 and unit < 0 else -1
    turns = unit >= 2 * unbalances_of(matrices)
    cosine, sine = 1.0, 0.0  # terms of cos(Omega t) and sin(Omega t)
    p_1 = p_2 = 1.0
    for term in range(1, terms_for(matrices.slots[slot].reach * 0.5**level) + 1):
        dt = h / term
        row_combination(y, KC, a, n)
        for i in range(n):
            a[i] = -a[i]
        if point >= 0:
            if term <= N_LOBATTO:
                _add_force(structure, sites, matrices, row, LAGRANGE[point][term - 1], 0.0, a)
        elif turns or term == 1:
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
    """Write a row of a level from the level for half the piece."""
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
    """Write x at the time c_i T if this row of x is 1 at the start; T is half the length of a piece of the level."""
    sizes = matrices.sizes[0]
    n, axes, unit = int(sizes.n), 2 * int(sizes.n_ports), _unit_of(matrices, row)
    forces = 2 * n + 4
    point, axis = (row - forces) // axes, (row - forces) % axes
    finer, ends = inner_motion(matrices, slot, level + 1), level_of(matrices, slot, level + 1).P
    Y = ends if i == 2 else (finer.first if i == 0 else finer.second)
    x[:] = 0.0
    if row < 2 * n or unit >= 0:
        copy(Y[row], x)
    else:
        for j in range(N_LOBATTO):
            weight = FIRST_HALF[j][point]
            for c in range(2 * n):
                x[c] += weight * Y[forces + axes * j + axis, c]
            x[forces + axes * j + axis] = SECOND_PART[i][j][point]
    if 0 <= unit < 2 * unbalances_of(matrices):
        x[row] = 1.0
    elif unit >= 0:
        angle = Omega * LOBATTO_POINTS[i + 1] * (sizes.step_size * 0.5 ** (level + 1))
        if unit % 2 == 0:
            x[row], x[row + 1] = math.cos(angle), math.sin(angle)
        else:
            x[row - 1], x[row] = -math.sin(angle), math.cos(angle)
