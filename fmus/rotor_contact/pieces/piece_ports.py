"""Ports of a piece, at which forces act and motion is observed, and the forces of the magnets at them.

The planes of sites and bearings and the housings have ports for x and y; a face has one for its place and one for its
slope.
"""

from __future__ import annotations

from fmi_export.flat import is_near
from fmi_export.jit import kernel
from rotor_contact.contact.face_forces import is_any_pressing
from rotor_contact.contact.faces import faces_of
from rotor_contact.contact.workspace import Workspace, stages_of
from rotor_contact.forces.dynamics import ROUNDING, Motion, forces
from rotor_contact.matrices.matrix_sizes import PORT_COLUMNS, place_index
from rotor_contact.matrices.step_matrices import StepMatrices
from rotor_contact.pieces.piece import piece_of


@kernel
def port_of_site(matrices: StepMatrices, k: int) -> int:
    """Return the port of the plane of site k."""
    return int(matrices.ports[first_port_number(matrices) + k])


@kernel
def port_of_housing(matrices: StepMatrices, k: int) -> int:
    """Return the port of the housing of site k, or -1 if there is none."""
    return int(matrices.ports[first_port_number(matrices) + matrices.nodes.shape[0] + k])


@kernel
def port_of_bearing(matrices: StepMatrices, b: int) -> int:
    """Return the port of bearing b."""
    return int(matrices.ports[first_port_number(matrices) + 2 * matrices.nodes.shape[0] + b])


@kernel
def port_of_face(matrices: StepMatrices, k: int, of_slope: int) -> int:
    """Return a port of face k: the port of its slope if `of_slope` is 1, the port of its place if it is 0."""
    n_others = 2 * matrices.nodes.shape[0] + matrices.gradients.shape[0] // 2
    return int(matrices.ports[first_port_number(matrices) + n_others + 2 * k + of_slope])


@kernel
def first_port_number(matrices: StepMatrices) -> int:
    """Return the index of the first port number in `ports`, where the coordinates of all possible ports come first."""
    return matrices.ports.shape[0] // 2


@kernel
def gradient_change(motion: Motion, matrices: StepMatrices, b: int, axis: int) -> float:
    """Return the gradient (N/m) of a magnet minus the gradient in the matrices; 0 if they agree within rounding."""
    gradient, known = motion.bearings[b].gradient[axis], matrices.gradients[2 * b + axis]
    return 0.0 if is_near(gradient, known, ROUNDING) else gradient - known


@kernel
def gradients_change(motion: Motion, matrices: StepMatrices) -> bool:
    """Return whether the gradient of any magnet differs from its gradient in the matrices."""
    for b in range(motion.bearings.shape[0]):
        for axis in range(2):
            if gradient_change(motion, matrices, b, axis) != 0.0:
                return True
    return False


@kernel
def magnets_act(w: Workspace, matrices: StepMatrices) -> bool:
    """Return whether any bearing exerts a magnetic force, or whether the matrices still contain a magnetic gradient."""
    excitation = forces(w.motion)
    for b in range(w.motion.bearings.shape[0]):
        bearing = w.motion.bearings[b]
        for axis in range(2):
            row, known = bearing.row + axis, matrices.gradients[2 * b + axis]
            if bearing.gradient[axis] != 0.0 or known != 0.0:
                return True
            if excitation.steady[row] != excitation.without_magnets[row]:
                return True
    return False


@kernel
def columns_in_use(w: Workspace, matrices: StepMatrices) -> tuple[int, int]:
    """Return the first column of S after the accelerations, and the number of columns that belong to relevant ports.

    Observations at bearings and faces are not computed if no force depends on them.
    """
    sizes = matrices.sizes[0]
    n_ports = sizes.n_site_ports
    if gradients_change(w.motion, matrices):
        n_ports = sizes.n_ports
    elif is_any_pressing(w):
        n_ports += 2 * faces_of(w.faces, w.Minv.shape[0]).records.shape[0]
    return 2 * (1 + int(sizes.n_ports)), PORT_COLUMNS * (1 + int(n_ports))


@kernel
def magnet_force(w: Workspace, matrices: StepMatrices, b: int, axis: int, displacement: float) -> float:
    """Return a magnetic bearing's force (N) at a displacement (m) along an axis, minus its part in the matrices."""
    excitation, row = forces(w.motion), w.motion.bearings[b].row + axis
    force: float = excitation.steady[row] - excitation.without_magnets[row]
    force += gradient_change(w.motion, matrices, b, axis) * displacement
    return force


@kernel
def set_magnet_forces(w: Workspace, matrices: StepMatrices, point: int) -> float:
    """Write the magnets' forces at a Lobatto point; return their largest change (N)."""
    piece, n_ports = piece_of(matrices), int(matrices.sizes[0].n_ports)
    z, change = stages_of(w.stages).z, 0.0
    for b in range(w.motion.bearings.shape[0]):
        port = port_of_bearing(matrices, b)
        for axis in range(2):
            if point == 0:
                displacement = z[w.motion.bearings[b].row + axis]
            else:
                displacement = piece.observed[6, place_index(n_ports, point, port) + axis]
            unit = 2 * (n_ports * point + port) + axis
            force = magnet_force(w, matrices, b, axis, displacement)
            change = max(change, abs(force - piece.magnets[unit]))
            piece.magnets[unit] = force
    return change
