"""Rows and columns of the matrices that depend on the inputs' amplitudes, computed from the rows for unit inputs.

With the amplitudes a of `excitation`, the row for c, one of the entries 1, 0, A and B of x, combines the rows of the
unit inputs u,

    P_c = sum_u T_cu P_u,    T_1 = T_A = (a_x, a_y),    T_0 = T_B = (-a_y, a_x)                   (1)

where the inputs u are the steady forces for the rows 1 and 0, and the unbalances for the rows A and B. S is combined
likewise; H is a quadratic form, so H_cc = T H T^T. The columns of S that contain cosine . q and sine . q combine the
observations U, which are the products of the motion with the unit forces of each unbalance:

    cosine . q = sum a_x b_x . q + a_y b_y . q,    sine . q = sum a_x b_y . q - a_y b_x . q                    (2)

A level is combined when it is used for the first time with the present amplitudes. Equations (1) and (2) are linear, so
a level between built speeds is interpolated from the speeds for which it is combined.
"""

from __future__ import annotations

import math

from fmi_export.jit import kernel, noinline_kernel
from fmi_export.model import Array
from rotor_contact.matrices.matrix_sizes import (
    ALL_SLOTS,
    MAX_LEVELS,
    N_NEAR,
    PLANE_COLUMNS,
    PORT_COLUMNS,
    place_index,
)
from rotor_contact.matrices.speed_grid import (
    BLENDS,
    built_slot_of,
    interpolate_from_built,
    interpolate_level,
    is_blended,
    middle_of,
    slot_of,
)
from rotor_contact.matrices.step_matrices import StepMatrices, level_of, powers_of, rows_of_x, unbalances_of

TURNS = 2  # first of the four combined rows that is due to unbalances


@kernel
def combine_around(matrices: StepMatrices, level: int, index: float) -> None:
    """Combine a level at the grid speeds around a point (`levels_around`), unless this has been done.

    The combined rows are interpolated like all others, so that an interpolated level gives the same bits as a product
    with interpolated rows.
    """
    low, place, inputs = math.floor(index), BLENDS * MAX_LEVELS + level, matrices.sizes[0].inputs
    is_between = index > low
    if is_between and is_blended(matrices, level, index) and matrices.combined[place] == inputs:
        return
    combine(matrices, slot_of(low), level)
    if is_between:
        combine(matrices, slot_of(low + 1.0), level)
        if is_blended(matrices, level, index):
            interpolate_level(matrices, level, index)
            matrices.combined[place] = inputs


@kernel
def combine(matrices: StepMatrices, slot: int, level: int) -> None:
    """Combine a level of a slot for the present amplitudes, or interpolate it, unless this has been done."""
    if matrices.combined[slot * MAX_LEVELS + level] == matrices.sizes[0].inputs:
        return
    if slot < N_NEAR and matrices.sizes[0].stride > 1.0:
        index = matrices.slots[slot].index
        for i in range(3):
            _combine_built(matrices, built_slot_of(middle_of(index) - 1.0 + i), level)
        interpolate_from_built(matrices, level, index)
        matrices.combined[slot * MAX_LEVELS + level] = matrices.sizes[0].inputs
    else:
        _combine_built(matrices, slot, level)


@kernel
def _combine_built(matrices: StepMatrices, slot: int, level: int) -> None:
    """Combine a level of a slot whose rows are built, unless this has been done."""
    place, inputs = slot * MAX_LEVELS + level, matrices.sizes[0].inputs
    if matrices.combined[place] != inputs:
        matrices.combined[place] = inputs
        _combine_columns(matrices, slot, level)
        _combine_rows(matrices, slot, level)
        if matrices.sizes[0].damped != 0.0:
            _combine_form(matrices, level_of(matrices, slot, level).H)
        if matrices.sizes[0].powered != 0.0:
            _combine_form(matrices, powers_of(matrices, slot, level).spin)
        if matrices.sizes[0].powered == 2.0:
            _combine_form(matrices, powers_of(matrices, slot, level).seals)


@kernel
def combine_ahead(matrices: StepMatrices, slot: int) -> bool:
    """Combine or interpolate one level of a slot before it is used; return False if there is none left."""
    inputs = matrices.sizes[0].inputs
    for level in range(int(matrices.sizes[0].n_levels)):
        if matrices.combined[slot * MAX_LEVELS + level] != inputs:
            if slot < N_NEAR and matrices.sizes[0].stride > 1.0:
                for i in range(3):
                    built = built_slot_of(middle_of(matrices.slots[slot].index) - 1.0 + i)
                    if matrices.combined[built * MAX_LEVELS + level] != inputs:
                        _combine_built(matrices, built, level)
                        return True
            combine(matrices, slot, level)
            return True
    return False


@kernel
def is_derived(matrices: StepMatrices, which: int) -> bool:
    """Return whether the matrices of a whole step at a constant speed were derived for the present amplitudes."""
    return bool(matrices.combined[ALL_SLOTS * MAX_LEVELS + which] == matrices.sizes[0].inputs)


@kernel
def note_derived(matrices: StepMatrices, which: int) -> None:
    """Record that the matrices of a whole step were derived for the present amplitudes."""
    matrices.combined[ALL_SLOTS * MAX_LEVELS + which] = matrices.sizes[0].inputs


@kernel
def _share(matrices: StepMatrices, c: int, unit: int) -> float:
    """Return T of equation (1) for a row c and a unit input."""
    amplitudes, pair, axis = matrices.amplitudes, unit // 2, unit % 2
    if (c >= TURNS) != (pair >= unbalances_of(matrices)):
        return 0.0
    share: float = amplitudes[unit]
    if c % 2 == 1:
        share = -amplitudes[unit + 1] if axis == 0 else amplitudes[unit - 1]
    return share


@noinline_kernel
def _combine_columns(matrices: StepMatrices, slot: int, level: int) -> None:
    """Write the columns of S that observe the unbalance (2); the combined rows follow from the rows of unit inputs."""
    of_level, amplitudes = level_of(matrices, slot, level), matrices.amplitudes
    S, U, first = of_level.S, of_level.U, unbalances_of(matrices)
    at = place_index(int(matrices.sizes[0].n_ports), 1, -1)
    for row in range(S.shape[0]):
        S[row, 0] = S[row, 1] = 0.0
        S[row, at : at + PORT_COLUMNS] = 0.0
    for pair in range(first, amplitudes.shape[0] // 2):
        a_x, a_y, place = amplitudes[2 * pair], amplitudes[2 * pair + 1], PLANE_COLUMNS * (pair - first)
        if a_x == 0.0 and a_y == 0.0:
            continue
        for row in range(S.shape[0]):
            of_row, observed = S[row], U[row, place : place + PLANE_COLUMNS]
            of_row[0] += a_x * observed[0] + a_y * observed[1]
            of_row[1] += a_x * observed[1] - a_y * observed[0]
            for c in range(0, PORT_COLUMNS, 2):
                x, y = observed[2 + c], observed[3 + c]
                of_row[at + c] += a_x * x + a_y * y
                of_row[at + c + 1] += a_x * y - a_y * x


@noinline_kernel
def _combine_rows(matrices: StepMatrices, slot: int, level: int) -> None:
    """Write the combined rows of P and S (1)."""
    P, S, _, _ = level_of(matrices, slot, level)
    first = 2 * int(matrices.sizes[0].n)
    units = rows_of_x(matrices)
    for c in range(4):
        of_motion, observed = P[first + c], S[first + c]
        of_motion[:] = 0.0
        observed[:] = 0.0
        for unit in range(matrices.amplitudes.shape[0]):
            share = _share(matrices, c, unit)
            if share != 0.0:
                _add_multiple(share, P[units + unit], of_motion)
                _add_multiple(share, S[units + unit], observed)


@noinline_kernel
def _combine_form(matrices: StepMatrices, H: Array) -> None:
    """Write the combined rows and columns of a quadratic form, whose lower triangle is stored."""
    sizes, n_units = matrices.sizes[0], matrices.amplitudes.shape[0]
    first, units = 2 * int(sizes.n), rows_of_x(matrices)
    for c in range(4):
        row = H[first + c]
        row[:] = 0.0
        for r in range(first + 4, units):
            H[r, first + c] = 0.0
        for unit in range(n_units):
            share = _share(matrices, c, unit)
            if share != 0.0:
                of_unit = H[units + unit]
                for s in range(first):
                    row[s] += share * of_unit[s]
                for r in range(first + 4, units):
                    H[r, first + c] += share * of_unit[r]
                for other in range(n_units):
                    if matrices.amplitudes[other] == 0.0 and matrices.amplitudes[other ^ 1] == 0.0:
                        continue
                    pair = share * H[units + max(unit, other), units + min(unit, other)]
                    for d in range(c + 1):
                        row[first + d] += pair * _share(matrices, d, other) * _weight(c == d, unit == other)


@kernel
def _weight(same_row: bool, same_unit: bool) -> float:
    """Return the factor of a unit-input element of H in a combined element; elements off the diagonal are doubled."""
    if same_row == same_unit:
        return 1.0
    return 0.5 if same_row else 2.0


@kernel
def _add_multiple(share: float, x: Array, y: Array) -> None:
    """Add share times x to y."""
    for i in range(x.shape[0]):
        y[i] += share * x[i]
