"""Heat and work of the spin and of seals over a piece at a constant speed, as quadratic forms of x (`step_matrices`).

    heat: int v^T C_s v dt - W,    work: -int v^T K_s' q dt - W,    W = int Omega M dt

M = (J q)^T R (v - Omega J q) is the torque of the damping R that rotates with the shaft; this damping thus supplies -W
to the motion. C_s is the damping of the seals, and K_s' is the skew part of their stiffness. Together with the energy
that the dampers take (`matrix_dampers`), this heat covers all damping. The forms of the shortest piece follow from
Lobatto's quadrature, and the forms of longer pieces from doubling, as in `matrix_dampers`.
"""

from __future__ import annotations

from fmi_export.flat import copy
from fmi_export.jit import kernel, noinline_kernel
from fmi_export.model import Array
from rotor_contact.forces.dynamics import Motion
from rotor_contact.matrices.matrix_dampers import add_point, double_form_row, move_to
from rotor_contact.matrices.matrix_sizes import FIRST_CONSTANT
from rotor_contact.matrices.step_matrices import StepMatrices, powers_of
from rotor_contact.shaft.lobatto import N_LOBATTO
from rotor_contact.shaft.products import row_combination
from rotor_contact.shaft.seals import add_seal_forms
from rotor_contact.shaft.structure import Structure


@kernel
def has_powers(matrices: StepMatrices, slot: int) -> bool:
    """Return whether a slot contains the quadratic forms of this module."""
    return bool(slot >= FIRST_CONSTANT and matrices.powers.shape[0] > 0)


@noinline_kernel
def integrate_power_rows(
    structure: Structure,
    motion: Motion,
    matrices: StepMatrices,
    slot: int,
    level: int,
    row: int,
    Omega: float,
    room: Array,
) -> None:
    """Write a row of the forms of the shortest piece, from the motion at its Lobatto points."""
    n, powers = int(matrices.sizes[0].n), powers_of(matrices, slot, level)
    y, heat, work, rest = room[: 2 * n], room[2 * n : 4 * n], room[4 * n : 6 * n], room[6 * n :]
    powers.heat[row, : row + 1] = 0.0
    powers.work[row, : row + 1] = 0.0
    for point in range(N_LOBATTO):
        move_to(matrices, slot, level, row, point, y)
        _apply_rotating_damping(structure.forms, Omega, y, heat, rest)
        copy(heat, work)
        add_seal_forms(motion.seals, Omega, y, n, heat, work)
        add_point(matrices, slot, level, row, point, heat, powers.heat[row])
        add_point(matrices, slot, level, row, point, work, powers.work[row])


@kernel
def double_power_rows(
    matrices: StepMatrices, slot: int, level: int, row: int, Omega: float, second: Array, room: Array
) -> None:
    """Write a row of the forms from the level for half the piece; `second` is x'' if this row of x is 1."""
    powers, finer = powers_of(matrices, slot, level), powers_of(matrices, slot, level + 1)
    double_form_row(matrices, slot, level, row, Omega, second, room, finer.heat, powers.heat[row])
    double_form_row(matrices, slot, level, row, Omega, second, room, finer.work, powers.work[row])


@kernel
def _apply_rotating_damping(forms: Array, Omega: float, y: Array, target: Array, room: Array) -> None:
    """Write the symmetric matrix of -Omega M times y = (q, v); J^T x has x_(i+1) at even i and -x_(i-1) at odd i."""
    n, m = y.shape[0] // 2, forms.shape[1]
    R, q, v = forms[2 * m : 3 * m], y[:n], y[n:]
    x, of_x = room[:m], room[m : 2 * m]
    target[:] = 0.0
    for i in range(0, m, 2):
        x[i], x[i + 1] = 0.5 * v[i] + Omega * q[i + 1], 0.5 * v[i + 1] - Omega * q[i]
    row_combination(x, R, of_x, m)
    for i in range(0, m, 2):
        target[i], target[i + 1] = -Omega * of_x[i + 1], Omega * of_x[i]
        x[i], x[i + 1] = -q[i + 1], q[i]
    row_combination(x, R, of_x, m)
    for i in range(m):
        target[n + i] = -0.5 * Omega * of_x[i]
