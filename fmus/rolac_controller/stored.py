"""The table of receptances and matrices H that the controller carries and renews.

A table is its number of rows, then the rows, ascending in harmonic order and speed. A row is the order, the speed, R
and H. The constants of the FMU hold the table that it was built with; its state holds the one in use, with room for
more.
"""

from __future__ import annotations

from fmi_export.flat import copy
from fmi_export.jit import kernel
from fmi_export.model import Array
from rolac_controller.inverse import N_MATRIX, invert
from rolac_controller.names import N_SENSORS

N_ROW = 2 + 2 * N_MATRIX
ORDER, SPEED, R = 0, 1, 2
H = R + N_MATRIX
SPARE_ROWS = 48  # for identifications: twelve speeds, four harmonics
SAME_SPEED = 0.005  # relative; an identification this close to a speed of the table takes its place

MISSING, WITHIN, BEYOND = range(3)  # what `bracket` finds


def rows_of(constants: Array) -> int:
    """Largest number of rows of the table in use, for the table an FMU was built with."""
    return int(constants[0]) + SPARE_ROWS


def size_of(constants: Array) -> int:
    """Size of the table in use, for the table an FMU was built with."""
    return 1 + rows_of(constants) * N_ROW


@kernel
def row(number: int) -> int:
    """Where a row begins."""
    return 1 + number * N_ROW


@kernel
def load(constants: Array, weights: Array, max_condition: float, table: Array, scratch: Array) -> bool:
    """Put the built table into use; False if the sensor weights leave one of its receptances ill-conditioned."""
    end = row(int(constants[0]))
    copy(constants[:end], table)
    unit = True
    for s in range(N_SENSORS):
        unit = unit and weights[s] == 1.0
    if not unit:
        for number in range(int(table[0])):
            at = row(number)
            if invert(table[at + R : at + H], weights, table[at + H : at + N_ROW], scratch) > max_condition:
                return False
    return True


@kernel
def bracket(table: Array, order: float, speed: float) -> tuple[int, int, float, int]:
    """Rows of a harmonic on both sides of a speed (rad/s), the share of the upper one, and whether there are any.

    Beyond the first and the last speed both rows are the nearest one.
    """
    low = high = -1
    for number in range(int(table[0])):
        at = row(number)
        if table[at + ORDER] != order:
            continue
        if table[at + SPEED] <= speed:
            low = number
        if table[at + SPEED] >= speed:
            high = number
            break
    if low < 0 and high < 0:
        return 0, 0, 0.0, MISSING
    if low < 0:
        return high, high, 0.0, BEYOND
    if high < 0:
        return low, low, 0.0, BEYOND
    width = table[row(high) + SPEED] - table[row(low) + SPEED]
    share = (speed - table[row(low) + SPEED]) / width if width > 0.0 else 0.0
    return low, high, share, WITHIN


@kernel
def interpolate(table: Array, what: int, low: int, high: int, share: float, matrix: Array) -> None:
    """Matrix R or H (`what`) between two rows, linear in the speed, into `matrix`, shape (N_MATRIX,)."""
    a, b = row(low) + what, row(high) + what
    for i in range(N_MATRIX):
        matrix[i] = (1.0 - share) * table[a + i] + share * table[b + i]


@kernel
def store(table: Array, order: float, speed: float, receptance: Array, h: Array) -> bool:
    """Replace the row of that order and speed, or insert one; False if the table is full.

    Parameters
    ----------
    table
        The table in use; its size says how many rows it can have.
    order, speed
        Order of the harmonic and speed (rad/s).
    receptance, h
        R and H, shape (N_MATRIX,) each.
    """
    count = int(table[0])
    place = 0
    same = -1
    nearest = SAME_SPEED * speed
    for number in range(count):
        at = row(number)
        if table[at + ORDER] == order and abs(table[at + SPEED] - speed) <= nearest:
            same, nearest = number, abs(table[at + SPEED] - speed)
        if table[at + ORDER] < order or (table[at + ORDER] == order and table[at + SPEED] < speed):
            place = number + 1
    if same >= 0:
        place = same
    else:
        if row(count + 1) > table.shape[0]:
            return False
        for i in range(row(count) - 1, row(place) - 1, -1):
            table[i + N_ROW] = table[i]
        table[0] = count + 1
    at = row(place)
    table[at + ORDER], table[at + SPEED] = order, speed
    copy(receptance, table[at + R :])
    copy(h, table[at + H :])
    return True
