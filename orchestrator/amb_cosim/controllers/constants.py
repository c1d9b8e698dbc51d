"""The constants of a linear controller, in the layout of `linear_controller.matrices`: dense blocks for each speed."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from amb_cosim.controllers.laws import Law
from amb_cosim.controllers.slow_modes import SlowModes, groups_of
from array_types import Array, Bools
from linear_controller.matrices import BLOCK, SIZES

Block = tuple[int, int, int, int]  # row, rows, column, columns

OVERHEAD = 150  # fixed cost of a block, in products


def constants_of(speeds: Sequence[float], laws: Sequence[Law], modes: Sequence[SlowModes]) -> Array:
    """Return the constants of a controller.

    Parameters
    ----------
    speeds
        Ascending speeds (rad/s).
    laws, modes
        Sampled laws of the same shapes, and their slow modes, at each speed.
    """
    n, (p, m) = len(laws[0].A), laws[0].D.shape
    groups = groups_of(np.any([law.A != 0.0 for law in laws], axis=0))
    order = np.concatenate([*groups, np.zeros(0, np.intp)]).astype(np.intp)
    ends = np.cumsum([0, *_joined([len(group) for group in groups])]).tolist()
    states, signals, demands = list(pairwise(ends)), [(0, m)], [(0, p)]
    columns, rows = (states, [(n, n + m)]), (states, [(n, n + p)])
    law = np.array([np.block([[x.A[np.ix_(order, order)], x.B[order]], [x.C[:, order], x.D]]) for x in laws])
    parts = {
        "n_law": (law, [block for r in rows for c in columns for block in _cheapest(law, r, c)]),
        "n_tracking": _with_blocks([x.tracking[order] for x in modes], states, demands),
        "n_rest": _with_blocks([x.rest[order] for x in modes], states, signals),
        "n_slow": _with_blocks([x.slow[np.ix_(order, order)] for x in modes], states, states),
    }
    table, values, start, counts = [], [], 0, {}
    for name, (matrices, blocks) in parts.items():
        counts[name] = len(blocks)
        for row, height, column, width in blocks:
            table.append((row, height, column, width, start))
            block = matrices[:, row : row + height, column : column + width]
            values.append(block.transpose(0, 2, 1).reshape(len(laws), -1))
            start += height * width
    head = np.zeros(1, dtype=SIZES)
    sizes = {"n_states": n, "n_signals": m, "n_demands": p, "n_speeds": len(laws), "n_values": start, **counts}
    for name, value in sizes.items():
        head[name] = value
    pieces = (
        head,
        np.asarray(speeds, dtype=np.float64),
        order.astype(np.float64),
        np.array(table, dtype=BLOCK),
        np.hstack([*values, np.zeros((len(laws), 0))]),
    )
    return np.concatenate([np.ascontiguousarray(piece).ravel().view(np.float64) for piece in pieces])


def _with_blocks(
    matrices: Sequence[Array], rows: Sequence[tuple[int, int]], columns: Sequence[tuple[int, int]]
) -> tuple[Array, list[Block]]:
    stacked = np.array(matrices)
    return stacked, _cheapest(stacked, rows, columns)


def _cheapest(matrices: Array, rows: Sequence[tuple[int, int]], columns: Sequence[tuple[int, int]]) -> list[Block]:
    """Return blocks that cover all nonzero entries: one block, or one per pair of ranges, whichever costs less."""
    if not rows or not columns:
        return []
    filled = np.any(matrices != 0.0, axis=0)
    single = _filled(filled, (rows[0][0], rows[-1][1]), (columns[0][0], columns[-1][1]))
    several = [block for row in rows for column in columns for block in _filled(filled, row, column)]
    return min(single, several, key=lambda blocks: sum(rows * columns + OVERHEAD for _, rows, _, columns in blocks))


def _filled(filled: Bools, rows: tuple[int, int], columns: tuple[int, int]) -> list[Block]:
    """Return the smallest block with all nonzero entries of a range of rows and columns; none if all are zero."""
    at = np.argwhere(filled[slice(*rows), slice(*columns)])
    if not len(at):
        return []
    (row, column), (last_row, last_column) = at.min(axis=0), at.max(axis=0)
    height, width = last_row - row + 1, last_column - column + 1
    return [(int(rows[0] + row), int(height), int(columns[0] + column), int(width))]


def _joined(sizes: Sequence[int]) -> list[int]:
    """Return the sizes of groups; to save cost, neighbours are joined into groups of n states with n^2 <= OVERHEAD."""
    joined: list[int] = []
    for size in sizes:
        if joined and (joined[-1] + size) ** 2 <= OVERHEAD:
            joined[-1] += size
        else:
            joined.append(size)
    return joined
