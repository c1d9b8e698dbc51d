"""Heat and work in one piece: in closed form as far as the exact motion permits, and the rest by quadrature.

Modes of the rotor may vibrate several times in a piece. These quantities are therefore computed in closed form: the
heat of all dampers (`matrix_dampers`), the work of the spin and of the skew stiffness of seals (`matrix_powers`), and
the work of steady forces f and of magnets with gradients k, f^T (q_1 - q_0) + k (q_1^2 - q_0^2)/2 in a piece. The work
of the unbalance at a prescribed speed is

    int p . v dt = [p . q] - int p' . q dt,
    p = exp(i theta) (Omega^2 - i Omega'),    p' = exp(i theta) (3 Omega Omega' + i Omega^3)

This form is used because fast modes count less in q than in v. The rest is smooth and needs only Lobatto's quadrature.
The symmetric part of the stiffness of seals contributes the difference of q^T K q/2, with K at the mean speed.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from fmi_export.jit import kernel, noinline_kernel
from fmi_export.model import Array
from rotor_contact.contact.bodies import drive_torque, race_drag
from rotor_contact.contact.face_forces import is_any_pressing
from rotor_contact.contact.site import is_constrained
from rotor_contact.contact.site_totals import collect_piece
from rotor_contact.contact.workspace import Workspace, energy_integrals, site_integrals, stages_of
from rotor_contact.forces.dynamics import forces, shaft_damping, unbalance_direction
from rotor_contact.matrices.matrix_dampers import form_of_piece, four_forms, heat_and_impulse_between
from rotor_contact.matrices.speed_grid import grid_speed, levels_around, powers_around, slot_of
from rotor_contact.matrices.step_matrices import StepMatrices, level_of, powers_of
from rotor_contact.pieces.face_in_piece import add_heat_of_faces
from rotor_contact.pieces.piece import Piece, piece_of, unbalance_place
from rotor_contact.shaft.lobatto import LOBATTO_WEIGHTS, N_LOBATTO
from rotor_contact.shaft.seals import seal_power, stored_by_seals


class Damping(NamedTuple):
    """Heat of all dampers (J), impulse of the rotating damping on the spin (N m s), and work of spin and seals (J)."""

    heat: float
    impulse: float
    work: float


@noinline_kernel
def torque_of_damping(w: Workspace, Omega: float, z: Array) -> float:
    """Return the torque (N m) of rotating damping on a free spin at z; a prescribed spin does not need it."""
    if w.spin[0].row < 0 or not w.motion.is_damped:
        return 0.0
    n = w.Minv.shape[0]
    return shaft_damping(w.forms, Omega, z[:n], z[w.n : w.n + n])[1]


@noinline_kernel
def damping_in_piece(w: Workspace, matrices: StepMatrices, level: int, index: float) -> Damping:
    """Return heat, impulse and work of damping and seals in a piece whose x is complete (`complete_forces`).

    The heat between two speeds d apart is a parabola of the speed, because the velocity relative to the turning shaft
    is; its curvature follows from the difference of the impulses.
    """
    sizes = matrices.sizes[0]
    if sizes.damped == 0.0 and (sizes.powered == 0.0 or w.spin[0].row < 0):
        return Damping(0.0, 0.0, 0.0)
    isotropic, x, low = sizes.isotropic != 0.0, piece_of(matrices).x, math.floor(index)
    if sizes.powered != 0.0 and w.spin[0].row >= 0 and index > low:
        return _damping_of_free_spin(matrices, level, index, isotropic)
    around, Omega = levels_around(matrices, level, index), grid_speed(matrices, index)
    share, H_low, H_high = around.share, around.low.H, around.high.H
    if sizes.powered == 0.0:
        return Damping(form_of_piece(x, H_low, H_high, share, isotropic), 0.0, 0.0)
    below, above = powers_around(matrices, level, index)
    if share > 0.0:
        weight = share * (1.0 - share) * sizes.spacing
        heat, impulse = heat_and_impulse_between(x, H_low, H_high, below.spin, above.spin, share, weight, isotropic)
    else:
        heat = form_of_piece(x, H_low, H_low, 0.0, isotropic)
        impulse = form_of_piece(x, below.spin, below.spin, 0.0, isotropic)
    work = 0.0 if w.spin[0].row >= 0 else -Omega * impulse
    if sizes.powered == 2.0:
        work += form_of_piece(x, below.seals, above.seals, share, isotropic)
    return Damping(heat, impulse, work)


@kernel
def _damping_of_free_spin(matrices: StepMatrices, level: int, index: float, isotropic: bool) -> Damping:
    """Return the result of `damping_in_piece` between two speeds of the grid, if the spin is free.

    Levels that are interpolated for a speed are not used, because a free spin has another speed in each piece.
    """
    sizes, x, low = matrices.sizes[0], piece_of(matrices).x, math.floor(index)
    share, slow, fast = index - low, slot_of(low), slot_of(low + 1.0)
    H_low, H_high = level_of(matrices, slow, level).H, level_of(matrices, fast, level).H
    below, above = powers_of(matrices, slow, level), powers_of(matrices, fast, level)
    heat_low, heat_high, low_impulse, high_impulse = four_forms(x, H_low, H_high, below.spin, above.spin, isotropic)
    gain = high_impulse - low_impulse
    heat = heat_low + share * (heat_high - heat_low) + share * (1.0 - share) * sizes.spacing * gain
    work = form_of_piece(x, below.seals, above.seals, share, isotropic) if sizes.powered == 2.0 else 0.0
    return Damping(heat, low_impulse + share * gain, work)


@noinline_kernel
def with_missed(w: Workspace, matrices: StepMatrices, index: float, h: float, of_damping: Damping) -> Damping:
    """Return heat and work of a piece with what interpolation of the seals between two speeds misses at its ends."""
    stages, low = stages_of(w.stages), math.floor(index)
    slow, fast, Omega = grid_speed(matrices, low), grid_speed(matrices, low + 1.0), grid_speed(matrices, index)
    heat, work = of_damping.heat, of_damping.work
    for z in (stages.z, stages.z_new):
        missed_heat, missed_work = _missed_by_seals(w, slow, fast, Omega, index - low, z)
        heat += 0.5 * h * missed_heat
        work += 0.5 * h * missed_work
    return Damping(heat, of_damping.impulse, work)


@kernel
def _missed_by_seals(
    w: Workspace, low: float, high: float, Omega: float, share: float, z: Array
) -> tuple[float, float]:
    """Return the power (W) that interpolation between two speeds misses: of dissipation and of skew stiffness."""
    q, v = z[: w.Minv.shape[0]], z[w.n :]
    heat, _, work = seal_power(w.motion.seals, Omega, q, v)
    heat_low, _, work_low = seal_power(w.motion.seals, low, q, v)
    heat_high, _, work_high = seal_power(w.motion.seals, high, q, v)
    return heat - heat_low - share * (heat_high - heat_low), work - work_low - share * (work_high - work_low)


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
def collect_sites(w: Workspace, matrices: StepMatrices, h: float) -> float:
    """Add forces and heat of a piece of length h (s) to the totals of the sites; return the heat of friction (J)."""
    piece, z_new, friction = piece_of(matrices), stages_of(w.stages).z_new, 0.0
    for k in range(w.sites.shape[0]):
        site, of_site = w.sites[k], site_integrals(z_new, w.n, k)
        heat = collect_piece(site, matrices.nodes[k], h, of_site) if is_constrained(site) else 0.0
        if site.race >= 0:
            for point in range(N_LOBATTO):
                share = h * LOBATTO_WEIGHTS[point]
                heat += share * race_drag(site, piece.races[k, point]) * piece.races[k, point]
        friction += heat
        of_site.heat += heat
    return friction


@kernel
def add_energies(
    w: Workspace,
    matrices: StepMatrices,
    h: float,
    of_damping: Damping,
    supplied: float,
) -> None:
    """Add the heat and work of a piece of length h (s) from z to z_new; update the peak forces.

    `supplied` is the work of the unbalance at a prescribed speed, or NaN if it is not computed yet.
    """
    n, stages = w.Minv.shape[0], stages_of(w.stages)
    z, z_new, piece = stages.z, stages.z_new, piece_of(matrices)
    integrals, speeds = energy_integrals(z_new, w.n), piece.spin[0]
    is_free = w.spin[0].row >= 0
    steady, damping, friction = forces(w.motion).without_magnets, of_damping.heat, collect_sites(w, matrices, h)
    work = of_damping.work + _work_of_magnets(w, z, z_new)
    if w.motion.seals.records.shape[1] > 0:
        mean_speed = 0.5 * (speeds[0] + speeds[N_LOBATTO - 1])
        work += stored_by_seals(w.motion.seals, mean_speed, z) - stored_by_seals(w.motion.seals, mean_speed, z_new)
    for i in range(n):
        work += steady[i] * (z_new[i] - z[i])
    for k in range(w.sites.shape[0]):
        site = w.sites[k]
        if site.housing >= 0:
            x = site.housing
            work -= site.housing_mass * (site.base_x * (z_new[x] - z[x]) + site.base_y * (z_new[x + 1] - z[x + 1]))
        if is_constrained(site) and not is_free:
            for point in range(N_LOBATTO):
                share = h * LOBATTO_WEIGHTS[point]
                work -= share * matrices.nodes[k, point].f_t * site.journal_radius * speeds[point]
    if is_free:
        for point in range(N_LOBATTO):
            share, Omega = h * LOBATTO_WEIGHTS[point], speeds[point]
            damping += share * w.spin[0].drag * Omega * Omega
            work += share * drive_torque(w.spin[0], Omega) * Omega
    else:
        work += _work_of_unbalance(w, matrices, piece, h) if math.isnan(supplied) else supplied
    integrals.damping_heat += damping
    integrals.friction_heat += friction
    integrals.work += work
    if is_any_pressing(w):
        add_heat_of_faces(w, matrices, h)
