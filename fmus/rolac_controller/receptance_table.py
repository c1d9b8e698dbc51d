"""The table of receptances R and matrices H that the controller uses and updates.

Its array is the number of rows, then the rows, ascending in harmonic order and speed. The constants of the FMU hold the
table that it was built with; its state holds the one in use, which has room for more rows.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fmi_export.jit import kernel, views
from fmi_export.model import Array
from fmi_export.records import record, size_of
from rolac_controller.complex_numbers import Complex, copy_matrix
from rolac_controller.pseudo_inverse import negative_pseudo_inverse
from rolac_controller.rig_layout import N_AXES, N_SENSORS

ROW = record(
    ("order", "f8"),  # of the harmonic
    ("speed", "f8"),  # rad/s
    ("R", "c16", (N_SENSORS, N_AXES)),  # m/N
    ("H", "c16", (N_AXES, N_SENSORS)),  # N/m
)
SPARE_ROWS = 48  # for identifications: twelve speeds, four harmonics
SAME_SPEED = 0.005  # relative; an identification this close to a speed of the table replaces its row

MISSING, WITHIN, BEYOND = range(3)  # how the speeds of the table cover a speed


class TableViews(NamedTuple):
    """Views of a table: the number of rows in use, shape (1,), and all the rows there is room for."""

    n_rows: Array
    rows: NDArray[np.record]


class Bracket(NamedTuple):
    """Rows on both sides of a speed, the weight of the upper one, and how the table covers the speed."""

    lower: int
    upper: int
    weight: float
    coverage: int


@views
def table_of(array: Array) -> TableViews:
    """Return the table whose array this is."""
    return TableViews(array[:1], array[1:].view(ROW))


def table_size(constants: Array) -> int:
    """Return the size of the table in use, for the table an FMU was built with."""
    return 1 + (int(constants[0]) + SPARE_ROWS) * size_of(ROW)


@kernel
def load(built: TableViews, parameters: np.record, table: TableViews, svd: np.record) -> bool:
    """Copy the built table into use; return False if the sensor weights leave one of its receptances ill-conditioned.

    With weights that are not one, H is computed anew.

    Parameters
    ----------
    built, table
        The table that the FMU was built with and the one in use.
    parameters
        Record PARAMETERS.
    svd
        Record SVD_WORK; overwritten.
    """
    weights = parameters.sensor_weights
    all_one = True
    for s in range(N_SENSORS):
        all_one = all_one and weights[s] == 1.0
    table.n_rows[0] = built.n_rows[0]
    for k in range(int(built.n_rows[0])):
        row = table.rows[k]
        table.rows[k] = built.rows[k]
        if not all_one:
            condition = negative_pseudo_inverse(row.R, weights, row.H, svd)
            if condition > parameters.identification.max_condition:
                return False
    return True


@kernel
def find_bracket(table: TableViews, order: float, speed: float) -> Bracket:
    """Return the rows of a harmonic on both sides of a speed (rad/s).

    Beyond the first and the last speed both rows are the nearest one.
    """
    lower = upper = -1
    for k in range(int(table.n_rows[0])):
        row = table.rows[k]
        if row.order != order:
            continue
        if row.speed <= speed:
            lower = k
        if row.speed >= speed:
            upper = k
            break
    if lower < 0 and upper < 0:
        return Bracket(0, 0, 0.0, MISSING)
    if lower < 0:
        return Bracket(upper, upper, 0.0, BEYOND)
    if upper < 0:
        return Bracket(lower, lower, 0.0, BEYOND)
    low, high = table.rows[lower].speed, table.rows[upper].speed
    weight = (speed - low) / (high - low) if high > low else 0.0
    return Bracket(lower, upper, weight, WITHIN)


@kernel
def interpolate(lower: Complex, upper: Complex, weight: float, matrix: Complex) -> None:
    """Compute the matrix between two others of the same shape, linear in the weight of the upper one."""
    for i in range(matrix.shape[0]):
        for j in range(matrix.shape[1]):
            matrix[i, j] = (1.0 - weight) * lower[i, j] + weight * upper[i, j]


@kernel
def store(table: TableViews, order: float, speed: float, R: Complex, H: Complex) -> bool:
    """Replace the row of that order and speed, or insert one; return False if the table is full.

    Parameters
    ----------
    table
        The table in use.
    order, speed
        Order of the harmonic and speed (rad/s).
    R, H
        Shapes (N_SENSORS, N_AXES) (m/N) and (N_AXES, N_SENSORS) (N/m).
    """
    n_rows = int(table.n_rows[0])
    place, same = 0, -1
    nearest = SAME_SPEED * speed
    for k in range(n_rows):
        row = table.rows[k]
        if row.order == order and abs(row.speed - speed) <= nearest:
            same, nearest = k, abs(row.speed - speed)
        if row.order < order or (row.order == order and row.speed < speed):
            place = k + 1
    if same >= 0:
        place = same
    else:
        if n_rows == table.rows.shape[0]:
            return False
        for k in range(n_rows, place, -1):
            table.rows[k] = table.rows[k - 1]
        table.n_rows[0] = n_rows + 1
    new = table.rows[place]
    new.order = order
    new.speed = speed
    copy_matrix(R, new.R)
    copy_matrix(H, new.H)
    return True
