"""Matrices of a whole step at a constant speed, derived from the matrices of the step (`step_matrices`).

    (q, v, w_A, w_B)(h) = x F,    x = (q, v, 1, 0, A, B, f, d_1, d_2, d_3, c_0, .., c_3)(0)

f are the magnet forces for the gradients in the matrices (`constant_speed`); they are held over the step. d_j are their
changes at the later Lobatto points if the present gradients differ from these (`flight`), and c_j are the contact
forces of all sites at Lobatto point j (`collocation`). A w_A + B w_B is the work of the unbalance (`piece_energy`), x^T
H x the heat of all damping, and x^T G x the work of the spin and of seals (`matrix_dampers`, `matrix_powers`). S
observes each site: its acceleration without contact at both ends, and its position and velocity at the later Lobatto
points.
"""

from __future__ import annotations

import math

from fmi_export.flat import copy
from fmi_export.jit import kernel, noinline_kernel
from fmi_export.model import Array
from fmi_export.parts import part
from rotor_contact.contact.site import Sites
from rotor_contact.contact.workspace import Workspace, stages_of
from rotor_contact.forces.dynamics import Motion, accelerations, forces, unbalance_direction
from rotor_contact.matrices.matrix_inputs import combine, is_derived, note_derived
from rotor_contact.matrices.matrix_sizes import FIRST_CONSTANT, place_index
from rotor_contact.matrices.speed_grid import CONSTANT
from rotor_contact.matrices.step_matrices import Level, StepMatrices, coefficients_at, level_of, powers_of
from rotor_contact.pieces.piece_ports import magnet_force, port_of_site
from rotor_contact.shaft.lobatto import LOBATTO_POINTS, LOBATTO_WEIGHTS, N_LOBATTO
from rotor_contact.shaft.structure import REAL
from rotor_contact.whole_steps.whole_step_rows import (
    WholeStep,
    count_of,
    first_held,
    is_of_inputs,
    observed,
    row_of,
    whole_step_of,
)


@noinline_kernel
def derive_whole_step(
    Minv: Array, motion: Motion, sites: Sites, matrices: StepMatrices, which: int, is_new: bool
) -> None:
    """Derive F, H, G and S at a constant speed, whose slot is complete, for the present amplitudes of the inputs.

    If the slot is not new, only the parts that depend on these amplitudes are written.
    """
    combine(matrices, FIRST_CONSTANT + which, 0)
    note_derived(matrices, which)
    whole, level = whole_step_of(matrices, which), level_of(matrices, FIRST_CONSTANT + which, 0)
    summed = part(matrices.pieces, 0, REAL, (whole.F.shape[0], N_LOBATTO))
    for row in range(whole.F.shape[0]):
        for i in range(N_LOBATTO):
            summed[row, i] = row_of(matrices, row, i) if i < count_of(matrices, row) else -1.0
    turns = part(matrices.pieces, N_LOBATTO * whole.F.shape[0], REAL, (2, N_LOBATTO))
    for point in range(N_LOBATTO):
        phi = motion.Omega * matrices.sizes[0].step_size * LOBATTO_POINTS[point]
        turns[0, point], turns[1, point] = math.cos(phi), math.sin(phi)
    for row in range(whole.F.shape[0]):
        if is_new or is_of_inputs(matrices, row):
            _sum_motion(matrices, level, whole, row)
            _observe_ends(Minv, motion, sites, matrices, which, whole, row)
        _observe_work(motion, matrices, level, whole, row)
    if is_new:
        whole.H[:, :] = 0.0  # `triangular_form` reads some elements above the diagonal
        whole.G[:, :] = 0.0
    if matrices.sizes[0].damped != 0.0:
        _sum_form(matrices, level.H, whole.H, 1.0, False, is_new)
    if matrices.sizes[0].powered != 0.0:
        spin, Omega = powers_of(matrices, FIRST_CONSTANT + which, 0).spin, matrices.constant[which, 0]
        _sum_form(matrices, spin, whole.G, -Omega, False, is_new)
    if matrices.sizes[0].powered == 2.0:
        _sum_form(matrices, powers_of(matrices, FIRST_CONSTANT + which, 0).seals, whole.G, 1.0, True, is_new)


@kernel
def _sum_form(matrices: StepMatrices, form: Array, target: Array, weight: float, adds: bool, is_new: bool) -> None:
    """Write or add `weight` times the lower triangle of a form of a step; elements off the diagonal are doubled."""
    summed = part(matrices.pieces, 0, REAL, (target.shape[0], N_LOBATTO))
    for row in range(target.shape[0]):
        first, end = 0, row + 1
        if not (is_new or is_of_inputs(matrices, row)):
            first, end = 2 * int(matrices.sizes[0].n), min(row + 1, 2 * int(matrices.sizes[0].n) + 4)
        for other in range(first, end):
            total = 0.0
            for i in range(N_LOBATTO):
                u = int(summed[row, i])
                if u < 0:
                    break
                for j in range(N_LOBATTO):
                    v = int(summed[other, j])
                    if v < 0:
                        break
                    total += form[u, u] if u == v else 0.5 * form[max(u, v), min(u, v)]
            total *= weight if row == other else 2.0 * weight
            target[row, other] = target[row, other] + total if adds else total


@kernel
def _sum_motion(matrices: StepMatrices, level: Level, whole: WholeStep, row: int) -> None:
    """Write the final state due to a row, and the observations at the start and at the later Lobatto points."""
    n, n_ports = int(matrices.sizes[0].n), int(matrices.sizes[0].n_ports)
    motion = whole.F[row]
    motion[: 2 * n] = 0.0
    whole.S[:, row] = 0.0
    for i in range(count_of(matrices, row)):
        u = row_of(matrices, row, i)
        of_step, observations = level.P[u], level.S[u]
        for c in range(2 * n):
            motion[c] += of_step[c]
        for k in range(whole.S.shape[0]):
            port, at_site = port_of_site(matrices, k), observed(whole.S[k, row])
            at_site.a_start[0] += observations[2 + 2 * port]
            at_site.a_start[1] += observations[3 + 2 * port]
            for point in range(N_LOBATTO - 1):
                at, journal = place_index(n_ports, point + 1, port), at_site.journal[point]
                journal.x += observations[at]
                journal.y += observations[at + 1]
                journal.v_x += observations[at + 2]
                journal.v_y += observations[at + 3]


@kernel
def _observe_ends(
    Minv: Array, motion: Motion, sites: Sites, matrices: StepMatrices, which: int, whole: WholeStep, row: int
) -> None:
    """Write the sites' contact-free acceleration at the end: -K q - C v plus the effect of the present force.

    By then the unbalance has turned by the angle phi = Omega h. A = 1 has therefore become cos(phi) times the first
    direction plus sin(phi) times the second; B = 1 has become -sin(phi) times the first plus cos(phi) times the second.
    """
    n, caused, end = int(matrices.sizes[0].n), accelerations(motion), whole.F[row]
    KC = coefficients_at(matrices, FIRST_CONSTANT + which).columns
    phi = matrices.constant[which, 0] * matrices.sizes[0].step_size
    first, axes = first_held(matrices), matrices.gradients.shape[0]
    held = row - first if row < first + axes else row - first - (N_LOBATTO - 1) * axes
    for k in range(sites.shape[0]):
        at_site = observed(whole.S[k, row])
        for axis in range(2):
            i, a = sites[k].row + axis, 0.0
            for j in range(2 * n):
                a -= KC[j, i] * end[j]
            if row == 2 * n:
                a += caused.without_magnets[i]
            elif row == 2 * n + 2:
                a += math.cos(phi) * caused.cosine[i] + math.sin(phi) * caused.sine[i]
            elif row == 2 * n + 3:
                a += math.cos(phi) * caused.sine[i] - math.sin(phi) * caused.cosine[i]
            elif 0 <= held < axes:
                a += Minv[motion.bearings[held // 2].row + held % 2, i]
            at_site.a_end[axis] = a


@kernel
def _observe_work(motion: Motion, matrices: StepMatrices, level: Level, whole: WholeStep, row: int) -> None:
    """Write w_A and w_B of a row.

    With C = cosine . q and S = sine . q at an angle phi from the beginning, and D = A + i B,

        p . q = A (C cos(phi) + S sin(phi)) + B (S cos(phi) - C sin(phi)),    p' = i Omega p
    """
    n, n_ports, force = int(matrices.sizes[0].n), int(matrices.sizes[0].n_ports), forces(motion)
    turn = motion.Omega * matrices.sizes[0].step_size
    turns = part(matrices.pieces, N_LOBATTO * whole.F.shape[0], REAL, (2, N_LOBATTO))
    a = b = 0.0
    for i in range(count_of(matrices, row)):
        u = row_of(matrices, row, i)
        for point in range(N_LOBATTO):
            cosine = sine = 0.0
            if point > 0:
                at = place_index(n_ports, point, -1)
                cosine, sine = level.S[u, at], level.S[u, at + 1]
            elif u < force.cosine.shape[0]:
                cosine, sine = force.cosine[u], force.sine[u]
            share = turn * LOBATTO_WEIGHTS[point]
            along = cosine * turns[0, point] + sine * turns[1, point]
            across = sine * turns[0, point] - cosine * turns[1, point]
            a -= share * across
            b += share * along
            if point == 0:
                a -= along
                b -= across
            elif point == N_LOBATTO - 1:
                a += along
                b += across
    whole.F[row, 2 * n], whole.F[row, 2 * n + 1] = a, b


@kernel
def begin_whole_step(w: Workspace, matrices: StepMatrices) -> None:
    """Write x at z, without contact forces or changes of magnet forces; derive the matrices for the present inputs."""
    motion, z, which = w.motion, stages_of(w.stages).z, int(matrices.sizes[0].place - CONSTANT)
    if not is_derived(matrices, which):
        derive_whole_step(w.Minv, motion, w.sites, matrices, which, False)
    n = int(matrices.sizes[0].n)
    x, direction = whole_step_of(matrices, which).x, unbalance_direction(motion.theta, motion.Omega, 0.0)
    copy(z[:n], x)
    copy(z[w.n : w.n + n], x[n:])
    x[2 * n], x[2 * n + 1], x[2 * n + 2], x[2 * n + 3] = 1.0, 0.0, direction.real, direction.imag
    x[2 * n + 4 :] = 0.0
    for b in range(motion.bearings.shape[0]):
        for axis in range(2):
            force = magnet_force(w, matrices, b, axis, z[motion.bearings[b].row + axis])
            x[2 * n + 4 + 2 * b + axis] = force
