"""A whole step of free flight (`whole_step`).

If the present gradients g of the magnets differ from the gradients g_0 in the matrices, the forces change by

    d_j = (g - g_0) (q(c_j h) - q(0)),    q(c_j h) by the cubic through q and q' at both ends
"""

from __future__ import annotations

from fmi_export.flat import copy
from fmi_export.jit import kernel
from rotor_contact.contact.workspace import Workspace, stages_of
from rotor_contact.matrices.matrix_sizes import whole_columns
from rotor_contact.matrices.step_matrices import StepMatrices
from rotor_contact.pieces.piece_ports import gradient_change, gradients_change
from rotor_contact.shaft.lobatto import LOBATTO_POINTS, N_LOBATTO
from rotor_contact.shaft.products import add_combination, row_combination
from rotor_contact.whole_steps.whole_step_rows import WholeStep, first_contact, first_held

SETTLED = 1e-6  # of the largest force: how far a force at the end may be from that at the end of the cubic
# The cubic at the later Lobatto points: shares of the rise, of h v(0) and of h v(h).
OF_RISE = tuple(s * s * (3.0 - 2.0 * s) for s in LOBATTO_POINTS[1:])
OF_START = tuple(s * (1.0 - s) * (1.0 - s) for s in LOBATTO_POINTS[1:])
OF_END = tuple(-s * s * (1.0 - s) for s in LOBATTO_POINTS[1:])


@kernel
def fly(w: Workspace, matrices: StepMatrices, whole: WholeStep, h: float) -> bool:
    """Write the state after a step of h (s) without contact to z_new; return False if the result is not accurate."""
    stages, n = stages_of(w.stages), int(matrices.sizes[0].n)
    x, end, held = whole.x, whole.end, first_held(matrices) + matrices.gradients.shape[0]
    row_combination(x[:held], whole.F, end, 2 * n + 2)
    if gradients_change(w.motion, matrices):
        _predict_changes(w, matrices, whole, h)
        rows = first_contact(matrices)
        add_combination(x[held:rows], whole.F[held:rows], end, 0, whole_columns(n))
        if not _have_settled(w, matrices, whole):
            return False
    copy(stages.z, stages.z_new)
    copy(end[:n], stages.z_new)
    copy(end[n : 2 * n], stages.z_new[w.n :])
    return True


@kernel
def _predict_changes(w: Workspace, matrices: StepMatrices, whole: WholeStep, h: float) -> None:
    """Write d_j to x."""
    x, end, n = whole.x, whole.end, int(matrices.sizes[0].n)
    axes = matrices.gradients.shape[0]
    for b in range(w.motion.bearings.shape[0]):
        for axis in range(2):
            row, change = w.motion.bearings[b].row + axis, gradient_change(w.motion, matrices, b, axis)
            rise, start, last = end[row] - x[row], h * x[n + row], h * end[n + row]
            for k in range(N_LOBATTO - 1):
                place = OF_RISE[k] * rise + OF_START[k] * start + OF_END[k] * last
                x[first_held(matrices) + axes * (k + 1) + 2 * b + axis] = change * place


@kernel
def _have_settled(w: Workspace, matrices: StepMatrices, whole: WholeStep) -> bool:
    """Return whether the changes of force at the end agree with the motion that these changes cause."""
    x, axes, first = whole.x, matrices.gradients.shape[0], first_held(matrices)
    largest = 0.0
    for unit in range(axes):
        largest = max(largest, abs(x[first + unit]))
    for b in range(w.motion.bearings.shape[0]):
        for axis in range(2):
            row, change = w.motion.bearings[b].row + axis, gradient_change(w.motion, matrices, b, axis)
            missed = change * (whole.end[row] - x[row]) - x[first + axes * (N_LOBATTO - 1) + 2 * b + axis]
            if not abs(missed) <= SETTLED * largest:
                return False
    return True
