"""Faces in a piece: the forces of their seats at the Lobatto points, which depend on the motion at these points.

In a sweep, these forces are taken as known, like the forces of magnets. Newton's method then corrects them. If J are
the derivatives of a seat's forces F with respect to the motion, and B F is the motion that these forces cause, this
method solves

    (1 - J B) dF = F(motion) - F

Newton's method is necessary because the damping of a ring, and friction at small slip, are stiff compared with the end
of a flexible shaft.
"""

from __future__ import annotations

from fmi_export.jit import kernel, noinline_kernel
from fmi_export.model import Array
from rotor_contact.contact.face_forces import FaceMotion, add_heat, face_motion, forces_at, housing_below, is_pressing
from rotor_contact.contact.faces import LEAST_SLIP, faces_of
from rotor_contact.contact.workspace import Workspace, energy_integrals, stages_of
from rotor_contact.matrices.matrix_sizes import place_index, velocity_index
from rotor_contact.matrices.speed_grid import LevelsAround
from rotor_contact.matrices.step_matrices import StepMatrices
from rotor_contact.pieces.piece import piece_of
from rotor_contact.pieces.piece_ports import port_of_face, port_of_housing
from rotor_contact.shaft.linear_solver import solve
from rotor_contact.shaft.lobatto import LOBATTO_WEIGHTS, N_LOBATTO, third_difference

N_FORCES = 4  # of a seat: forces and moments in x and y, which come first in `FaceForces`
N_VARIABLES = 6  # on which a seat's forces depend: lean, its rate and slip velocity
OF_CLEARANCE, OF_SLIP = 1e-4, 0.1  # steps for the slopes: rise of the rim over the clearance, slip over `LEAST_SLIP`


@noinline_kernel
def begin_face_forces(w: Workspace, matrices: StepMatrices, h: float) -> None:
    """Write the forces of all seats at z to all points of a piece of length h (s), and find their derivatives at z."""
    records, added = faces_of(w.faces, w.Minv.shape[0]).records, matrices.equations.right_side[:N_FORCES]
    z, Omega = stages_of(w.stages).z, piece_of(matrices).spin[0, 0]
    for k in range(records.shape[0]):
        face = records[k]
        if not is_pressing(face):
            continue
        motion = face_motion(w, k, z, Omega)
        at = forces_at(face, motion)
        for i in range(N_FORCES):
            added[i] = at[i]
        for point in range(N_LOBATTO):
            _add_forces(w, matrices, k, point, added)
        lean = OF_CLEARANCE * face.clearance / face.radius
        for i in range(N_VARIABLES):
            step = lean if i < 2 else (lean / h if i < 4 else OF_SLIP * LEAST_SLIP)
            moved = forces_at(face, _moved(motion, i, step))
            for j in range(N_FORCES):
                face.slopes[N_VARIABLES * j + i] = (moved[j] - at[j]) / step


@kernel
def _moved(at: FaceMotion, i: int, step: float) -> FaceMotion:
    """Return a motion with its variable i increased by `step`."""
    return FaceMotion(
        at.u_x + (step if i == 0 else 0.0),
        at.u_y + (step if i == 1 else 0.0),
        at.rate_x + (step if i == 2 else 0.0),
        at.rate_y + (step if i == 3 else 0.0),
        at.v_x + (step if i == 4 else 0.0),
        at.v_y + (step if i == 5 else 0.0),
        at.omega,
    )


@noinline_kernel
def settle_face_forces(w: Workspace, matrices: StepMatrices, of_forces: Array) -> tuple[bool, float, float]:
    """Correct the forces of all seats at the Lobatto points after the first, by Newton's method for each face.

    Returns whether this succeeds, the largest error of the forces before the correction, and the largest normal force
    (N). A moment counts as the force that causes it at the radius of the ring.
    """
    known, axes = piece_of(matrices).magnets, 2 * int(matrices.sizes[0].n_ports)
    records, error, largest = faces_of(w.faces, w.Minv.shape[0]).records, 0.0, 0.0
    b = matrices.equations.right_side
    for k in range(records.shape[0]):
        face = records[k]
        if not is_pressing(face):
            continue
        largest = max(largest, face.force)
        for point in range(1, N_LOBATTO):
            at, row = forces_at(face, _motion_at(w, matrices, k, point)), N_FORCES * (point - 1)
            for i in range(N_FORCES):
                b[row + i] = at[i] - known[axes * point + _unit_of(matrices, k, i)]
                error = max(error, abs(b[row + i]) / (1.0 if i < 2 else face.radius))
        _write_equations(w, matrices, of_forces, k)
        if not solve(matrices.equations, N_FORCES * (N_LOBATTO - 1)):
            return False, error, largest
        for point in range(1, N_LOBATTO):
            _add_forces(w, matrices, k, point, b[N_FORCES * (point - 1) :])
    return True, error, largest


@kernel
def _unit_of(matrices: StepMatrices, k: int, i: int) -> int:
    """Return the place of number i of forces and moments of face k among the forces at a Lobatto point."""
    return 2 * port_of_face(matrices, k, i // 2) + i % 2


@kernel
def _add_forces(w: Workspace, matrices: StepMatrices, k: int, point: int, added: Array) -> None:
    """Add forces and moments of face k on the shaft at a Lobatto point; the housing receives the opposite forces."""
    known, port, axes = piece_of(matrices).magnets, _port_of_seat(w, matrices, k), 2 * int(matrices.sizes[0].n_ports)
    for i in range(N_FORCES):
        known[axes * point + _unit_of(matrices, k, i)] += added[i]
    if port >= 0:
        for i in range(2):
            known[axes * point + 2 * port + i] -= added[i]


@kernel
def _port_of_seat(w: Workspace, matrices: StepMatrices, k: int) -> int:
    """Return the port of the housing that carries face k, or -1 if there is none."""
    face = faces_of(w.faces, w.Minv.shape[0]).records[k]
    return port_of_housing(matrices, int(face.site)) if housing_below(w, face) >= 0 else -1


@noinline_kernel
def _write_equations(w: Workspace, matrices: StepMatrices, of_forces: Array, k: int) -> None:
    """Write the matrix of Newton's equations for face k, which describes how the face's forces affect themselves."""
    A, n_ports = matrices.equations.matrix, int(matrices.sizes[0].n_ports)
    slopes = faces_of(w.faces, w.Minv.shape[0]).records[k].slopes
    place, slope, seat = port_of_face(matrices, k, 0), port_of_face(matrices, k, 1), _port_of_seat(w, matrices, k)
    for source in range(1, N_LOBATTO):
        for j in range(4):
            column, port = 4 * (source - 1) + j, place if j < 2 else slope
            caused = of_forces[2 * (n_ports * source + port) + j % 2]
            of_seat = of_forces[2 * (n_ports * source + max(seat, 0)) + j % 2]
            for point in range(1, N_LOBATTO):
                lean, face = place_index(n_ports, point, slope), velocity_index(n_ports, point, place)
                u_x, u_y, rate_x, rate_y = caused[lean], caused[lean + 1], caused[lean + 2], caused[lean + 3]
                v_x, v_y = caused[face], caused[face + 1]
                if seat >= 0:
                    housing = velocity_index(n_ports, point, seat)
                    v_x -= caused[housing]
                    v_y -= caused[housing + 1]
                    if j < 2:
                        u_x -= of_seat[lean]
                        u_y -= of_seat[lean + 1]
                        rate_x -= of_seat[lean + 2]
                        rate_y -= of_seat[lean + 3]
                        v_x -= of_seat[face] - of_seat[housing]
                        v_y -= of_seat[face + 1] - of_seat[housing + 1]
                for i in range(4):
                    row, s = 4 * (point - 1) + i, slopes[N_VARIABLES * i :]
                    effect = s[0] * u_x + s[1] * u_y + s[2] * rate_x + s[3] * rate_y + s[4] * v_x + s[5] * v_y
                    A[row, column] = (1.0 if row == column else 0.0) - effect


@kernel
def _motion_at(w: Workspace, matrices: StepMatrices, k: int, point: int) -> FaceMotion:
    """Return the motion of face k at a Lobatto point."""
    piece, n_ports = piece_of(matrices), int(matrices.sizes[0].n_ports)
    if point == 0:
        return face_motion(w, k, stages_of(w.stages).z, piece.spin[0, 0])
    face, observed = faces_of(w.faces, w.Minv.shape[0]).records[k], piece.observed[6]
    place = place_index(n_ports, point, port_of_face(matrices, k, 0))
    lean = place_index(n_ports, point, port_of_face(matrices, k, 1))
    v_x, v_y, omega = observed[place + 2], observed[place + 3], piece.spin[0, point]
    seat = _port_of_seat(w, matrices, k)
    if seat >= 0:
        housing = velocity_index(n_ports, point, seat)
        v_x -= observed[housing]
        v_y -= observed[housing + 1]
    if face.site >= 0.0 and w.sites[int(face.site)].race >= 0:
        omega -= piece.races[int(face.site), point]
    return FaceMotion(observed[lean], observed[lean + 1], observed[lean + 2], observed[lean + 3], v_x, v_y, omega)


@noinline_kernel
def observe_face_forces(
    w: Workspace, matrices: StepMatrices, around: LevelsAround, z: Array, Omega: float, observed: Array
) -> None:
    """Add the effect of the seats that push at z to the observations in the first columns of S."""
    records, first = faces_of(w.faces, w.Minv.shape[0]).records, 2 * int(matrices.sizes[0].n) + 4
    for k in range(records.shape[0]):
        face = records[k]
        if not is_pressing(face):
            continue
        at, seat = forces_at(face, face_motion(w, k, z, Omega)), _port_of_seat(w, matrices, k)
        for i in range(N_FORCES):
            _add_row(around, first + _unit_of(matrices, k, i), at[i], observed)
        if seat >= 0:
            for i in range(2):
                _add_row(around, first + 2 * seat + i, -at[i], observed)


@kernel
def _add_row(around: LevelsAround, row: int, force: float, observed: Array) -> None:
    low, high, share = around.low.S[row], around.high.S[row], around.share
    for c in range(observed.shape[0]):
        observed[c] += force * ((1.0 - share) * low[c] + share * high[c])


@kernel
def bend_of_face_forces(w: Workspace, matrices: StepMatrices) -> tuple[float, float]:
    """Return the largest third difference of the forces of all seats in a piece, and the largest force (N).

    A moment counts as the force that causes it at the radius of the ring.
    """
    f, axes = piece_of(matrices).magnets, 2 * int(matrices.sizes[0].n_ports)
    records, bend, largest = faces_of(w.faces, w.Minv.shape[0]).records, 0.0, 0.0
    for k in range(records.shape[0]):
        face = records[k]
        if is_pressing(face):
            largest = max(largest, face.force)
            for i in range(N_FORCES):
                unit = _unit_of(matrices, k, i)
                bent = third_difference(f[unit], f[unit + axes], f[unit + 2 * axes], f[unit + 3 * axes])
                bend = max(bend, bent / (1.0 if i < 2 else face.radius))
    return bend, largest


@noinline_kernel
def add_heat_of_faces(w: Workspace, matrices: StepMatrices, h: float) -> None:
    """Add the heat and work of the faces in a piece of length h (s) to the integrals in z_new, the end of the piece."""
    z_new, records = stages_of(w.stages).z_new, faces_of(w.faces, w.Minv.shape[0]).records
    integrals, spin = energy_integrals(z_new, w.n), piece_of(matrices).spin
    for k in range(records.shape[0]):
        face = records[k]
        if not is_pressing(face):
            continue
        sliding = rocking = 0.0
        for point in range(N_LOBATTO):
            share, at = h * LOBATTO_WEIGHTS[point], forces_at(face, _motion_at(w, matrices, k, point))
            sliding += share * at.sliding
            rocking += share * at.rocking
            if w.spin[0].row < 0:
                integrals.work -= share * face.torque * spin[0, point]
        integrals.friction_heat += sliding
        integrals.impact_heat += rocking
        add_heat(w, k, z_new, sliding + rocking)
