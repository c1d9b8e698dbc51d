"""The table of receptances R and matrices H that the controller uses and updates.

The array of a table contains the number of rows, the key of each row (ascending in harmonic order and speed), all R,
and all H. The constants of an FMU contain the table with which it was built. The state contains the table in use, which
has room for more rows.
"""

from __future__ import annotations

from typing import NamedTuple

from fmi_export.jit import inlined_kernel, kernel, views
from fmi_export.model import Array
from fmi_export.parts import copy_all, part
from rolac_controller.complex_numbers import COMPLEX, REAL, Complex
from rolac_controller.inner_loop import InnerLoop, table_start
from rolac_controller.pseudo_inverse import SvdWork, negative_pseudo_inverse
from rolac_controller.records import Parameters
from rolac_controller.sizes import KEY, N_KEY, Records, Sizes, sizes_of

SPARE_ROWS = 48  # for identifications: twelve speeds, four harmonics
SAME_SPEED = 0.005  # relative; an identification this close to a speed of the table replaces its row

MISSING, WITHIN, BEYOND = range(3)  # whether the speeds of the table cover a speed


class TableViews(NamedTuple):
    """Views of a table: the number of rows in use, shape (1,), and the contents of all rows.

    keys
        Records KEY, shape (n,).
    R, H
        Matrices R, shape (n, n_sensors, n_axes) (m/N), and H, shape (n, n_axes, n_sensors) (N/m).
    """

    n_rows: Array
    keys: Records
    R: Complex
    H: Complex


class Bracket(NamedTuple):
    """The rows on both sides of a speed, the weight of the upper row, and whether the table covers the speed."""

    lower: int
    upper: int
    weight: float
    coverage: int


@views
def table_of(array: Array, start: int, capacity: int, sizes: Sizes) -> TableViews:
    """Return the table that begins at `start` in an array and has room for `capacity` rows."""
    n_axes, n_sensors = sizes.n_axes, sizes.n_sensors
    keys = start + 1
    R = keys + capacity * N_KEY
    H = R + 2 * capacity * n_axes * n_sensors
    return TableViews(
        part(array, start, REAL, 1),
        part(array, keys, KEY, capacity),
        part(array, R, COMPLEX, (capacity, n_sensors, n_axes)),
        part(array, H, COMPLEX, (capacity, n_axes, n_sensors)),
    )


@views
def built_rows(constants: Array, sizes: Sizes) -> int:
    """Return the number of rows of the table that was built into an FMU with these constants."""
    return int(constants[table_start(constants, sizes)])


@views
def built_table(constants: Array, sizes: Sizes) -> TableViews:
    """Return the table that was built into an FMU with these constants."""
    return table_of(constants, table_start(constants, sizes), built_rows(constants, sizes), sizes)


@views
def table_in_use(state: Array, start: int, constants: Array, sizes: Sizes) -> TableViews:
    """Return the table that begins at `start` in the state of an FMU with these constants."""
    return table_of(state, start, built_rows(constants, sizes) + SPARE_ROWS, sizes)


def table_size(constants: Array) -> int:
    """Return the size of the table in use for a controller with these constants."""
    sizes = sizes_of(constants)
    n_rows = built_rows(constants, sizes) + SPARE_ROWS
    return 1 + n_rows * (N_KEY + 4 * sizes.n_axes * sizes.n_sensors)


@kernel
def copy_row(source: TableViews, k: int, target: TableViews, place: int) -> None:
    """Copy row k of a table to a row of another table, or of the same table."""
    target.keys[place].order = source.keys[k].order
    target.keys[place].speed = source.keys[k].speed
    copy_all(source.R[k], target.R[place])
    copy_all(source.H[k], target.H[place])


@kernel
def load(built: TableViews, parameters: Parameters, table: TableViews, svd: SvdWork) -> bool:
    """Copy the FMU's built-in table to the table in use; return False if the sensor weights make it ill-conditioned.

    If any weight differs from one, H is recomputed.

    Parameters
    ----------
    built, table
        The table with which the FMU was built, and the table in use.
    svd
        Overwritten.
    """
    weights = parameters.sensor_weights
    is_unweighted = True
    for s in range(weights.shape[0]):
        is_unweighted = is_unweighted and weights[s] == 1.0
    table.n_rows[0] = built.n_rows[0]
    for k in range(int(built.n_rows[0])):
        copy_row(built, k, table, k)
        if not is_unweighted:
            condition = negative_pseudo_inverse(table.R[k], weights, table.H[k], svd)
            if condition > parameters.common[0].identification.max_condition:
                return False
    return True


@inlined_kernel
def find_bracket(table: TableViews | InnerLoop, order: float, speed: float) -> Bracket:
    """Return the rows of a harmonic on both sides of a speed (rad/s).

    If the speed is outside the table, both rows are the nearest one.
    """
    lower = upper = -1
    for k in range(int(table.n_rows[0])):
        row = table.keys[k]
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
    low, high = table.keys[lower].speed, table.keys[upper].speed
    weight = (speed - low) / (high - low) if high > low else 0.0
    return Bracket(lower, upper, weight, WITHIN)


@kernel
def interpolate(lower: Complex, upper: Complex, weight: float, matrix: Complex) -> None:
    """Interpolate linearly between two matrices of the same shape; `weight` is the weight of `upper`."""
    for i in range(matrix.shape[0]):
        for j in range(matrix.shape[1]):
            matrix[i, j] = (1.0 - weight) * lower[i, j] + weight * upper[i, j]


@kernel
def store(table: TableViews, order: float, speed: float, R: Complex, H: Complex) -> bool:
    """Replace or insert the row with this order and speed; return False if the table is full.

    Parameters
    ----------
    table
        The table in use.
    order, speed
        Order of the harmonic and speed (rad/s).
    R, H
        Matrices R, shape (n_sensors, n_axes) (m/N), and H, shape (n_axes, n_sensors) (N/m).
    """
    n_rows = int(table.n_rows[0])
    place, same = 0, -1
    nearest = SAME_SPEED * speed
    for k in range(n_rows):
        row = table.keys[k]
        if row.order == order and abs(row.speed - speed) <= nearest:
            same, nearest = k, abs(row.speed - speed)
        if row.order < order or (row.order == order and row.speed < speed):
            place = k + 1
    if same >= 0:
        place = same
    else:
        if n_rows == table.keys.shape[0]:
            return False
        for k in range(n_rows, place, -1):
            copy_row(table, k - 1, table, k)
        table.n_rows[0] = n_rows + 1
    table.keys[place].order = order
    table.keys[place].speed = speed
    copy_all(R, table.R[place])
    copy_all(H, table.H[place])
    return True
