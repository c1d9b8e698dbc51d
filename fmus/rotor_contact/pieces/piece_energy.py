"""Heat and work in one piece: in closed form as far as the exact motion permits, and the rest by quadrature.

Modes of the rotor may vibrate several times in a piece. Two quantities are therefore computed in closed form: the
energy D that the dampers take from the motion (`matrix_dampers`), and the work of steady forces f and of magnets with
gradients k. In a piece, this work is f^T (q_1 - q_0) + k (q_1^2 - q_0^2)/2. The spin supplies the power -Omega M to the
damping that rotates with it, so the heat is D - int Omega M dt. The work of the unbalance at a prescribed speed is

    int p . v dt = [p . q] - int p' . q dt,
    p = exp(i theta) (Omega^2 - i Omega'),    p' = exp(i theta) (3 Omega Omega' + i Omega^3)

This form is used because fast modes count less in q than in v. The rest is smooth and needs only Lobatto's quadrature.
The power P of seals is known only at the ends of a piece, with its slope (Hermite's quadrature):

    int P dt = h (P_0 + P_1)/2 + h^2 (P_0' - P_1')/12

The symmetric part of their stiffness contributes the difference of q^T K q/2, with K at the mean speed.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from fmi_export.flat import copy, same_bits
from fmi_export.jit import kernel, noinline_kernel
from fmi_export.model import Array
from rotor_contact.contact.bodies import drive_torque, race_drag
from rotor_contact.contact.face_forces import add_accelerations, is_any_pressing
from rotor_contact.contact.site import is_constrained
from rotor_contact.contact.site_totals import collect_piece
from rotor_contact.contact.workspace import Workspace, energy_integrals, site_integrals, stages_of
from rotor_contact.forces.dynamics import accelerations, forces, unbalance_direction
from rotor_contact.matrices.matrix_dampers import energy_of_dampers
from rotor_contact.matrices.speed_grid import levels_around, slot_of
from rotor_contact.matrices.step_matrices import StepMatrices, coefficients_at
from rotor_contact.pieces.face_in_piece import add_heat_of_faces
from rotor_contact.pieces.piece import Piece, piece_of, unbalance_place
from rotor_contact.pieces.piece_ports import magnet_force
from rotor_contact.shaft.lobatto import LOBATTO_WEIGHTS, N_LOBATTO
from rotor_contact.shaft.products import row_combination
from rotor_contact.shaft.seals import seal_power, slopes_of_seal_power, stored_by_seals


class ShaftDamping(NamedTuple):
    """Torque (N m) of the shaft's damping on the spin; heat and skew-stiffness power of seals (W), with rates (W/s)."""

    torque: float
    heat: float
    slope: float
    of_skew: float
    skew_slope: float


@noinline_kernel
def damping_of_shaft(w: Workspace, Omega: float, z: Array) -> ShaftDamping:
    """Return the torque (J q)^T R (v - Omega J q) of the shaft's damping at z, and the seals' power without slopes."""
    if not w.motion.is_damped:
        return ShaftDamping(0.0, 0.0, 0.0, 0.0, 0.0)
    n, stages = w.Minv.shape[0], stages_of(w.stages)
    q, v = z[:n], z[w.n : w.n + n]
    turned, of_turned = stages.trial[:n], stages.k_4[:n]
    for i in range(0, n, 2):
        turned[i], turned[i + 1] = v[i] + Omega * q[i + 1], v[i + 1] - Omega * q[i]
    row_combination(turned, w.forms[2 * n : 3 * n], of_turned, n)
    torque = 0.0
    for i in range(0, n, 2):
        torque += q[i] * of_turned[i + 1] - q[i + 1] * of_turned[i]
    in_seals, _, of_skew = seal_power(w.motion.seals, Omega, q, v)
    return ShaftDamping(torque, in_seals, 0.0, of_skew, 0.0)


@kernel
def known_damping(w: Workspace, matrices: StepMatrices, Omega: float, z: Array) -> ShaftDamping:
    """Return the result of `damping_of_shaft`, which is cached because the next step begins at this z."""
    n, cached = w.Minv.shape[0], matrices.damping
    if cached[0] == Omega and same_bits(z[:n], cached[4 : 4 + n]) and same_bits(z[w.n : w.n + n], cached[4 + n :]):
        return ShaftDamping(cached[1], cached[2], 0.0, cached[3], 0.0)
    damping = damping_of_shaft(w, Omega, z)
    cached[0], cached[1], cached[2], cached[3] = Omega, damping.torque, damping.heat, damping.of_skew
    copy(z[:n], cached[4:])
    copy(z[w.n : w.n + n], cached[4 + n :])
    return damping


@noinline_kernel
def add_slope(
    w: Workspace, matrices: StepMatrices, z: Array, index: float, theta: float, Omega: float, damping: ShaftDamping
) -> ShaftDamping:
    """Return `damping` with the slopes of the seals' power; the sites must contain the contact forces at z."""
    n = w.Minv.shape[0]
    v, a = z[w.n : w.n + n], stages_of(w.stages).k_2[:n]
    _accelerate(w, matrices, z, index, theta, Omega, a)
    in_seals, of_skew = slopes_of_seal_power(w.motion.seals, Omega, z[:n], v, a)
    return ShaftDamping(damping.torque, damping.heat, in_seals, damping.of_skew, of_skew)


@kernel
def _accelerate(
    w: Workspace, matrices: StepMatrices, z: Array, index: float, theta: float, Omega: float, a: Array
) -> None:
    """Write the approximate acceleration of the shaft at z, with the matrices of the next lower speed of the grid."""
    n, size = w.Minv.shape[0], int(matrices.sizes[0].n)
    room = piece_of(matrices).x[: 2 * size]
    copy(z[:size], room)
    copy(z[w.n : w.n + size], room[size:])
    row_combination(room, coefficients_at(matrices, slot_of(math.floor(index))).columns, a, n)
    direction = unbalance_direction(theta, Omega, w.motion.Omega_dot)
    caused, A, B = accelerations(w.motion), direction.real, direction.imag
    for i in range(n):
        a[i] = caused.without_magnets[i] + A * caused.cosine[i] + B * caused.sine[i] - a[i]
    for b in range(w.motion.bearings.shape[0]):
        for axis in range(2):
            row = w.motion.bearings[b].row + axis
            force = magnet_force(w, matrices, b, axis, z[row])
            if force != 0.0:
                for i in range(n):
                    a[i] += w.Minv[row, i] * force
    if is_any_pressing(w):
        add_accelerations(w, z, Omega, a)
    for site in w.sites:
        if is_constrained(site):
            f_x = -site.f_n * site.n_x - site.f_t * site.n_y
            f_y = -site.f_n * site.n_y + site.f_t * site.n_x
            for i in range(n):
                a[i] += w.Minv[site.row, i] * f_x + w.Minv[site.row + 1, i] * f_y


@kernel
def mean_heat(before: ShaftDamping, after: ShaftDamping, h: float) -> float:
    """Return the mean dissipation (W) of seals in a piece of length h (s)."""
    return 0.5 * (before.heat + after.heat) + h * (before.slope - after.slope) / 12.0


@kernel
def mean_skew_power(before: ShaftDamping, after: ShaftDamping, h: float) -> float:
    """Return the mean power (W) of the seals' skew stiffness in a piece of length h (s)."""
    return 0.5 * (before.of_skew + after.of_skew) + h * (before.skew_slope - after.skew_slope) / 12.0


@kernel
def energy_taken(matrices: StepMatrices, level: int, index: float) -> float:
    """Return the energy (J) that dampers take from the motion in a piece whose x is complete (`end_piece`)."""
    if matrices.sizes[0].damped == 0.0:
        return 0.0
    around, isotropic = levels_around(matrices, level, index), matrices.sizes[0].isotropic != 0.0
    return energy_of_dampers(piece_of(matrices).x, around.low.H, around.high.H, around.share, isotropic)


@kernel
def _work_of_magnets(w: Workspace, z: Array, z_new: Array) -> float:
    """Return the work (J) of the magnetic bearings in a piece."""
    excitation, work = forces(w.motion), 0.0
    for bearing in w.motion.bearings:
        for axis in range(2):
            i = bearing.row + axis
            force = (
                excitation.steady[i] - excitation.without_magnets[i] + 0.5 * bearing.gradient[axis] * (z[i] + z_new[i])
            )
            work += force * (z_new[i] - z[i])
    return work


@kernel
def _work_of_unbalance(w: Workspace, matrices: StepMatrices, piece: Piece, h: float) -> float:
    """Return the work (J) of the unbalance at a prescribed speed in a piece of length h (s)."""
    work, Omega_dot = 0.0, w.motion.Omega_dot
    for point in range(N_LOBATTO):
        theta, Omega = piece.spin[1, point], piece.spin[0, point]
        cosine, sine = unbalance_place(w, matrices, point)
        if point == 0 or point == N_LOBATTO - 1:
            direction = unbalance_direction(theta, Omega, Omega_dot)
            at_end = direction.real * cosine + direction.imag * sine
            work += at_end if point > 0 else -at_end
        turn = complex(math.cos(theta), math.sin(theta)) * complex(3.0 * Omega * Omega_dot, Omega * Omega * Omega)
        work -= h * LOBATTO_WEIGHTS[point] * (turn.real * cosine + turn.imag * sine)
    return work


@kernel
def add_energies(
    w: Workspace,
    matrices: StepMatrices,
    h: float,
    taken: float,
    supplied: float,
    before: ShaftDamping,
    after: ShaftDamping,
) -> None:
    """Add the heat and work of a piece of length h (s) from z to z_new; update the peak forces.

    `taken` is the result of `energy_taken`. `supplied` is the work of the unbalance at a prescribed speed, or NaN if it
    is not computed yet. `before` and `after` are the damping torque and the power of the seals at the two ends. For a
    whole step, `taken` and `supplied` already include the effects of this torque and this power.
    """
    n, stages = w.Minv.shape[0], stages_of(w.stages)
    z, z_new, piece = stages.z, stages.z_new, piece_of(matrices)
    integrals, speeds = energy_integrals(z_new, w.n), piece.spin[0]
    is_free = w.spin[0].row >= 0
    torque = before.torque if is_free else 0.5 * (before.torque + after.torque)  # a free spin has it (`solve_piece`)
    steady, damping, friction = forces(w.motion).without_magnets, taken, 0.0
    work = _work_of_magnets(w, z, z_new)
    if w.motion.seals.records.shape[1] > 0:
        mean_speed = 0.5 * (speeds[0] + speeds[N_LOBATTO - 1])
        damping += h * mean_heat(before, after, h)
        work += h * mean_skew_power(before, after, h) + stored_by_seals(w.motion.seals, mean_speed, z)
        work -= stored_by_seals(w.motion.seals, mean_speed, z_new)
    for i in range(n):
        work += steady[i] * (z_new[i] - z[i])
    for k in range(w.sites.shape[0]):
        site, of_site = w.sites[k], site_integrals(z_new, w.n, k)
        if site.housing >= 0:
            x = site.housing
            work -= site.housing_mass * (site.base_x * (z_new[x] - z[x]) + site.base_y * (z_new[x + 1] - z[x + 1]))
        heat = collect_piece(site, matrices.nodes[k], h, of_site) if is_constrained(site) else 0.0
        for point in range(N_LOBATTO):
            share = h * LOBATTO_WEIGHTS[point]
            if is_constrained(site) and not is_free:
                work -= share * matrices.nodes[k, point].f_t * site.journal_radius * speeds[point]
            if site.race >= 0:
                heat += share * race_drag(site, piece.races[k, point]) * piece.races[k, point]
        friction += heat
        of_site.heat += heat
    for point in range(N_LOBATTO):
        share = h * LOBATTO_WEIGHTS[point]
        Omega = speeds[point]
        damping -= share * torque * Omega
        if is_free:
            damping += share * w.spin[0].drag * Omega * Omega
            work += share * drive_torque(w.spin[0], Omega) * Omega
        else:
            work -= share * torque * Omega
    if not is_free:
        work += _work_of_unbalance(w, matrices, piece, h) if math.isnan(supplied) else supplied
    integrals.damping_heat += damping
    integrals.friction_heat += friction
    integrals.work += work
    if is_any_pressing(w):
        add_heat_of_faces(w, matrices, h)
