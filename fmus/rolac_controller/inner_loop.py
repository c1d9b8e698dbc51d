"""Tabulated response of a controller that closes the loop instead of the PID, or in addition to it.

The constants contain the number of rows, the key of each row (ascending in harmonic order and speed), and the matrix C
of each row. In

    u = -C q,   C of shape (n_axes, n_sensors) (N/m),

u is the force K_i i of the inner controller's currents in response to the sensor readings q at the harmonic.
"""

from __future__ import annotations

from typing import NamedTuple

from fmi_export.jit import views
from fmi_export.model import Array
from fmi_export.parts import part
from rolac_controller.complex_numbers import COMPLEX, REAL, Complex
from rolac_controller.sizes import KEY, N_KEY, N_SIZES, Records, Sizes


class InnerLoop(NamedTuple):
    """Views of the table: number of rows, shape (1,); records KEY, (n,); matrices C, (n, n_axes, n_sensors) (N/m)."""

    n_rows: Array
    keys: Records
    C: Complex


@views
def inner_loop_of(constants: Array, sizes: Sizes) -> InnerLoop:
    """Return the table from the constants of a controller with these sizes."""
    start = N_SIZES + sizes.n_axes
    n = int(constants[start])
    keys = start + 1
    return InnerLoop(
        part(constants, start, REAL, 1),
        part(constants, keys, KEY, n),
        part(constants, keys + n * N_KEY, COMPLEX, (n, sizes.n_axes, sizes.n_sensors)),
    )


@views
def table_start(constants: Array, sizes: Sizes) -> int:
    """Return the index in the constants at which the table of receptances begins, after the table of the inner loop."""
    start = N_SIZES + sizes.n_axes
    return start + 1 + int(constants[start]) * (N_KEY + 2 * sizes.n_axes * sizes.n_sensors)
