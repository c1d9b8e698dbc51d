"""The matrices of a controller, as its constants contain them, and products with these matrices.

The law is one matrix, M = [A B; C D], with [x(n+1); u(n)] = M [x(n); e(n)], where e contains the readings minus the
setpoints. This matrix and three others are stored as dense blocks in column order, so the cost of a block-diagonal
matrix depends only on its blocks. Each speed of the table has its own values; the positions of the blocks are the same
for all speeds.

    law        M, shape (n_states + n_demands, n_states + n_signals)
    tracking   L, (n_states, n_demands): feedback of a demand's excess to the states, see `law`
    rest       S, (n_states, n_signals): steady states under a constant signal, with integrators at zero
    slow       P, (n_states, n_states): the part of the states that `reset` removes

Between two speeds of the table, M = (1 - w) M_lower + w M_upper with w from 0 to 1. M is therefore a continuous
function of the speed. The states keep their values when the speed changes. Outside the table, the values of the nearest
speed apply.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from fmi_export.jit import inlined_kernel, kernel, views
from fmi_export.model import Array
from fmi_export.parts import part
from fmi_export.records import record, size_of

Records = np.ndarray[tuple[int], np.dtype[np.record]]
REAL = np.dtype(np.float64)

# The constants begin with it; speeds, order of the states, blocks, values of each speed follow.
SIZES = record(
    ("n_states", "f8"),
    ("n_signals", "f8"),
    ("n_demands", "f8"),
    ("n_speeds", "f8"),
    ("n_values", "f8"),  # of a speed
    ("n_law", "f8"),  # numbers of blocks of the four matrices
    ("n_tracking", "f8"),
    ("n_rest", "f8"),
    ("n_slow", "f8"),
)
# Rows and columns that a block has from `row` and `column` on, and where its values begin among those of a speed.
BLOCK = record(("row", "f8"), ("n_rows", "f8"), ("column", "f8"), ("n_columns", "f8"), ("start", "f8"))
N_SIZES, N_BLOCK = size_of(SIZES), size_of(BLOCK)


class Sizes(NamedTuple):
    """Numbers of states, signals and demands."""

    n_states: int
    n_signals: int
    n_demands: int


class LawMatrices(NamedTuple):
    """Views into the constants.

    speeds
        Speeds of the table, ascending, shape (n_speeds,) (rad/s).
    order
        Index of each state in the coordinates of the law, shape (n_states,).
    law, tracking, rest, slow
        Records BLOCK of the four matrices.
    values
        Values of all blocks at each speed, shape (n_speeds, n_values).
    """

    speeds: Array
    order: Array
    law: Records
    tracking: Records
    rest: Records
    slow: Records
    values: Array


class TableRows(NamedTuple):
    """Two rows of the table, the weight of the upper one, and whether the speed is outside the table."""

    lower: int
    upper: int
    weight: float
    is_beyond: bool


@views
def sizes_of(constants: Array) -> Sizes:
    """Return the sizes of a controller with these constants."""
    head = part(constants, 0, SIZES, 1)[0]
    return Sizes(int(head.n_states), int(head.n_signals), int(head.n_demands))


@views
def matrices_of(constants: Array) -> LawMatrices:
    """Return views into the constants."""
    head = part(constants, 0, SIZES, 1)[0]
    n_speeds, n_states, n_values = int(head.n_speeds), int(head.n_states), int(head.n_values)
    n_law, n_tracking, n_rest, n_slow = int(head.n_law), int(head.n_tracking), int(head.n_rest), int(head.n_slow)
    law = N_SIZES + n_speeds + n_states
    tracking = law + n_law * N_BLOCK
    rest = tracking + n_tracking * N_BLOCK
    slow = rest + n_rest * N_BLOCK
    return LawMatrices(
        part(constants, N_SIZES, REAL, n_speeds),
        part(constants, N_SIZES + n_speeds, REAL, n_states),
        part(constants, law, BLOCK, n_law),
        part(constants, tracking, BLOCK, n_tracking),
        part(constants, rest, BLOCK, n_rest),
        part(constants, slow, BLOCK, n_slow),
        part(constants, slow + n_slow * N_BLOCK, REAL, (n_speeds, n_values)),
    )


@kernel
def find_bracket(speeds: Array, Omega: float) -> TableRows:
    """Return the rows of the table on both sides of a speed (rad/s)."""
    last = speeds.shape[0] - 1
    if last == 0:
        return TableRows(0, 0, 0.0, False)
    if Omega <= speeds[0]:
        return TableRows(0, 0, 0.0, Omega < speeds[0])
    if Omega >= speeds[last]:
        return TableRows(last, last, 0.0, Omega > speeds[last])
    lower = 0
    while speeds[lower + 1] <= Omega:
        lower += 1
    weight = (Omega - speeds[lower]) / (speeds[lower + 1] - speeds[lower])
    return TableRows(lower, lower + 1, weight, False)


@kernel
def add_blocks(blocks: Records, values: Array, factor: float, source: Array, target: Array) -> None:
    """Add the product of `factor`, a matrix and `source` to `target`.

    Four columns are processed at once, which reduces the loads and stores of `target` to a quarter. The sums of
    different rows remain independent.
    """
    for k in range(blocks.shape[0]):
        block = blocks[k]
        row, n, column = int(block.row), int(block.n_rows), int(block.column)
        at, end = int(block.start), column + int(block.n_columns)
        to = part(target, row, REAL, n)
        while column + 4 <= end:
            p, q = factor * source[column], factor * source[column + 1]
            r, s = factor * source[column + 2], factor * source[column + 3]
            a, b = part(values, at, REAL, n), part(values, at + n, REAL, n)
            c, d = part(values, at + 2 * n, REAL, n), part(values, at + 3 * n, REAL, n)
            for i in range(n):
                to[i] = to[i] + a[i] * p + b[i] * q + c[i] * r + d[i] * s
            at += 4 * n
            column += 4
        while column < end:
            p = factor * source[column]
            a = part(values, at, REAL, n)
            for i in range(n):
                to[i] += a[i] * p
            at += n
            column += 1


@inlined_kernel
def add_product(blocks: Records, values: Array, bracket: TableRows, source: Array, target: Array) -> None:
    """Interpolate a matrix of the table, and add the product of this matrix and `source` to `target`."""
    if blocks.shape[0] > 0:
        add_blocks(blocks, values[bracket.lower], 1.0 - bracket.weight, source, target)
        if bracket.weight > 0.0:
            add_blocks(blocks, values[bracket.upper], bracket.weight, source, target)
