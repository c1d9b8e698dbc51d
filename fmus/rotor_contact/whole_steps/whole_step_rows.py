"""Matrices of a whole step in memory, and the meaning of their rows (`whole_step`)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from fmi_export.jit import kernel, views
from fmi_export.model import Array
from fmi_export.parts import part
from rotor_contact.matrices.matrix_sizes import N_OBSERVED, OBSERVED, whole_columns, whole_rows
from rotor_contact.matrices.step_matrices import StepMatrices
from rotor_contact.pieces.piece_ports import port_of_bearing, port_of_site
from rotor_contact.shaft.lobatto import N_LOBATTO
from rotor_contact.shaft.structure import REAL


class WholeStep(NamedTuple):
    """The matrices of a whole step, with room for its variables.

    F, H, G, S
        Shapes (rows, 2 N + 2), (rows, rows), (rows, rows) and (n_sites, rows, N_OBSERVED).
    x, end
        The argument and the result of F.
    free_response, contact_response
        Observations of each site without contact, to which the effect of contact forces at the first point is added,
        and observations due to the contact forces at the other points, shape (n_sites, N_OBSERVED) each.
    """

    F: Array
    H: Array
    G: Array
    S: Array
    x: Array
    end: Array
    free_response: Array
    contact_response: Array


@views
def whole_step_of(matrices: StepMatrices, which: int) -> WholeStep:
    """Return the matrices of a whole step at a constant speed; `which` is the number of its slot."""
    n, memory, n_sites = int(matrices.sizes[0].n), matrices.whole_steps[which], matrices.nodes.shape[0]
    rows, columns = whole_rows(n, matrices.gradients.shape[0] // 2, n_sites), whole_columns(n)
    H = rows * columns
    G = H + rows * rows
    S = G + rows * rows
    x = S + n_sites * rows * N_OBSERVED
    free_response = x + rows + columns
    return WholeStep(
        part(memory, 0, REAL, (rows, columns)),
        part(memory, H, REAL, (rows, rows)),
        part(memory, G, REAL, (rows, rows)),
        part(memory, S, REAL, (n_sites, rows, N_OBSERVED)),
        part(memory, x, REAL, rows),
        part(memory, x + rows, REAL, columns),
        part(memory, free_response, REAL, (n_sites, N_OBSERVED)),
        part(memory, free_response + n_sites * N_OBSERVED, REAL, (n_sites, N_OBSERVED)),
    )


@views
def first_held(matrices: StepMatrices) -> int:
    """Return the first row of the magnets' forces, which are held over the step; the rows of their changes follow."""
    return 2 * int(matrices.sizes[0].n) + 4


@views
def first_contact(matrices: StepMatrices) -> int:
    """Return the first row of contact forces: x and y of all sites at the first point, then at the next ones."""
    return first_held(matrices) + N_LOBATTO * matrices.gradients.shape[0]


@views
def observed(response: Array) -> np.record:
    """Return a row of S, or a response made of such rows, as a record of type `OBSERVED`."""
    of_site: np.record = part(response, 0, OBSERVED, 1)[0]
    return of_site


@kernel
def is_of_inputs(matrices: StepMatrices, row: int) -> bool:
    """Return whether a row depends on the amplitudes of the inputs, as the rows of 1, 0, A and B do."""
    return bool(2 * matrices.sizes[0].n <= row < 2 * matrices.sizes[0].n + 4)


@kernel
def count_of(matrices: StepMatrices, row: int) -> int:
    """Return how many rows of a step's matrices are summed in a row of a whole step: four for held forces, else one."""
    return N_LOBATTO if 0 <= row - first_held(matrices) < matrices.gradients.shape[0] else 1


@kernel
def row_of(matrices: StepMatrices, row: int, number: int) -> int:
    """Return the index of the row of a step's matrices that is summand `number` of a row of a whole step."""
    first, n_ports = first_held(matrices), int(matrices.sizes[0].n_ports)
    if row < first:
        return row
    axes, start = matrices.gradients.shape[0], first
    if row >= first_contact(matrices):
        axes, start = 2 * matrices.nodes.shape[0], first_contact(matrices)
    axis, point = (row - start) % axes, (row - start) // axes + number
    port = port_of_bearing(matrices, axis // 2) if start == first else port_of_site(matrices, axis // 2)
    return first + 2 * (n_ports * point + port) + axis % 2
