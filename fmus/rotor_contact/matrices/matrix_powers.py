"""Impulse on the spin and work of seals over a piece, as quadratic forms of x (`step_matrices`).

    spin: int M dt,    seals: -int v^T K_s' q dt

M = (J q)^T R (v - Omega J q) is the torque on the spin by the damping R that rotates with the shaft; a spin at a
prescribed speed supplies the work -Omega int M dt. K_s' is the skew part of the stiffness of seals. The forms of the
shortest piece follow from Lobatto's quadrature, and the forms of longer pieces from doubling, as in `matrix_dampers`.
The heat there contains neither, so that the balance of energy fails if heat or work is wrong.
"""

from __future__ import annotations

from fmi_export.jit import kernel, noinline_kernel
from fmi_export.model import Array
from rotor_contact.forces.dynamics import Motion
from rotor_contact.matrices.matrix_dampers import add_point, double_form_row, move_to
from rotor_contact.matrices.step_matrices import StepMatrices, powers_of
from rotor_contact.shaft.lobatto import N_LOBATTO
from rotor_contact.shaft.products import row_combination
from rotor_contact.shaft.seals import add_seal_work
from rotor_contact.shaft.structure import Structure


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
    n, powers, has_seals = int(matrices.sizes[0].n), powers_of(matrices, slot, level), matrices.sizes[0].powered == 2.0
    y, applied, rest = room[: 2 * n], room[2 * n : 4 * n], room[4 * n :]
    powers.spin[row, : row + 1] = 0.0
    if has_seals:
        powers.seals[row, : row + 1] = 0.0
    for point in range(N_LOBATTO):
        move_to(matrices, slot, level, row, point, y)
        _apply_torque(structure.forms, Omega, y, applied, rest)
        add_point(matrices, slot, level, row, point, applied, powers.spin[row])
        if has_seals:
            applied[:] = 0.0
            add_seal_work(motion.seals, Omega, y, n, applied)
            add_point(matrices, slot, level, row, point, applied, powers.seals[row])


@kernel
def double_power_rows(
    matrices: StepMatrices, slot: int, level: int, row: int, Omega: float, second: Array, room: Array
) -> None:
    """Write a row of the forms from the level for half the piece; `second` is x'' if this row of x is 1."""
    powers, finer = powers_of(matrices, slot, level), powers_of(matrices, slot, level + 1)
    double_form_row(matrices, slot, level, row, Omega, second, room, finer.spin, powers.spin[row])
    if matrices.sizes[0].powered == 2.0:
        double_form_row(matrices, slot, level, row, Omega, second, room, finer.seals, powers.seals[row])


@kernel
def _apply_torque(forms: Array, Omega: float, y: Array, target: Array, room: Array) -> None:
    """Write the symmetric matrix of M times y = (q, v); J^T x has x_(i+1) at even i and -x_(i-1) at odd i."""
    n, m = y.shape[0] // 2, forms.shape[1]
    R, q, v = forms[2 * m : 3 * m], y[:n], y[n:]
    x, of_x = room[:m], room[m : 2 * m]
    target[:] = 0.0
    for i in range(0, m, 2):
        x[i], x[i + 1] = 0.5 * v[i] + Omega * q[i + 1], 0.5 * v[i + 1] - Omega * q[i]
    row_combination(x, R, of_x, m)
    for i in range(0, m, 2):
        target[i], target[i + 1] = of_x[i + 1], -of_x[i]
        x[i], x[i + 1] = -q[i + 1], q[i]
    row_combination(x, R, of_x, m)
    for i in range(m):
        target[n + i] = 0.5 * of_x[i]
