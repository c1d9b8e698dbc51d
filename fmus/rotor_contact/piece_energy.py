"""Heat and work in one piece, by Lobatto quadrature; those of shaft damping and seals by Hermite quadrature.

The power P of damping is known only at the ends of a piece, but with its slope:

    int P dt = h (P_0 + P_1)/2 + h^2 (P_0' - P_1')/12

The slope is used in short pieces after an impact; over consecutive whole steps it would cancel. With seals it is always
used. The symmetric part of their stiffness contributes the difference of q . K q/2, with K at the mean speed.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from fmi_export.flat import copy, same_bits
from fmi_export.jit import kernel, noinline_kernel
from fmi_export.model import Array
from rotor_contact.bodies import drive_torque, race_drag
from rotor_contact.dynamics import is_damped_to_ground, unbalance_direction
from rotor_contact.lobatto import LOBATTO_WEIGHTS, N_LOBATTO
from rotor_contact.node_forces import magnet_force, magnets_act, port_of_bearing, port_of_housing
from rotor_contact.passive_bearings import heat_per_second
from rotor_contact.piece import piece_of, unbalance_velocity
from rotor_contact.products import dot, row_combination
from rotor_contact.seals import seal_power, slopes_of_seal_power, stored_by_seals
from rotor_contact.site import is_constrained
from rotor_contact.site_in_piece import friction_heat
from rotor_contact.step_matrices import StepMatrices, coefficients_at, slot_of, velocity_index
from rotor_contact.workspace import Workspace, energy_integrals, site_integrals, stages_of


class ShaftDamping(NamedTuple):
    """Dissipation (W), torque on the spin (N m), and skew power of seals (W), with rates (W/s).

    `has_slope` marks whether the rates are known.
    """

    heat: float
    slope: float
    torque: float
    of_skew: float
    skew_slope: float
    has_slope: bool


@noinline_kernel
def damping_of_shaft(w: Workspace, Omega: float, z: Array) -> ShaftDamping:
    """Return the power of the shaft's damping at z (see `dynamics`), without its slope.

    With w = v - Omega J q the heat is v . C v + w . R w, the torque (J q) . R w. C v and R w are stored in stages.
    """
    if not w.motion.is_damped:
        return ShaftDamping(0.0, 0.0, 0.0, 0.0, 0.0, False)
    n, stages = w.Minv.shape[0], stages_of(w.stages)
    q, v = z[:n], z[w.n : w.n + n]
    turned, of_fixed, of_turned = stages.trial[:n], stages.k_3[:n], stages.k_4[:n]
    of_fixed[:] = 0.0
    if is_damped_to_ground(w.forms):
        row_combination(v, w.forms[n : 2 * n], of_fixed, n)
    for i in range(0, n, 2):
        turned[i], turned[i + 1] = v[i] + Omega * q[i + 1], v[i + 1] - Omega * q[i]
    row_combination(turned, w.forms[2 * n : 3 * n], of_turned, n)
    torque = 0.0
    for i in range(0, n, 2):
        torque += q[i] * of_turned[i + 1] - q[i + 1] * of_turned[i]
    in_seals, _, of_skew = seal_power(w.motion.seals, Omega, q, v)
    return ShaftDamping(dot(v, of_fixed) + dot(turned, of_turned) + in_seals, 0.0, torque, of_skew, 0.0, False)


@kernel
def known_damping(w: Workspace, matrices: StepMatrices, Omega: float, z: Array) -> ShaftDamping:
    """Return the same as `damping_of_shaft`, cached for the next step, which begins at this z.

    C v and R w are not stored in stages.
    """
    n, known = w.Minv.shape[0], matrices.damping
    if known[0] == Omega and same_bits(z[:n], known[4 : 4 + n]) and same_bits(z[w.n : w.n + n], known[4 + n :]):
        return ShaftDamping(known[1], 0.0, known[2], known[3], 0.0, False)
    damping = damping_of_shaft(w, Omega, z)
    known[0], known[1], known[2], known[3] = Omega, damping.heat, damping.torque, damping.of_skew
    copy(z[:n], known[4:])
    copy(z[w.n : w.n + n], known[4 + n :])
    return damping


@noinline_kernel
def add_slope(
    w: Workspace, matrices: StepMatrices, z: Array, index: float, theta: float, Omega: float, damping: ShaftDamping
) -> ShaftDamping:
    """Return the power with its slopes, for the shaft 2 (a . C v + (a - Omega J v) . R w), after `damping_of_shaft`.

    Requires the contact forces at z in the sites.
    """
    n, stages = w.Minv.shape[0], stages_of(w.stages)
    v, a, of_fixed, of_turned = z[w.n : w.n + n], stages.k_2[:n], stages.k_3[:n], stages.k_4[:n]
    _accelerate(w, matrices, z, index, theta, Omega, a)
    slope = 0.0
    for i in range(0, n, 2):
        slope += a[i] * of_fixed[i] + a[i + 1] * of_fixed[i + 1]
        slope += (a[i] + Omega * v[i + 1]) * of_turned[i] + (a[i + 1] - Omega * v[i]) * of_turned[i + 1]
    in_seals, of_skew = slopes_of_seal_power(w.motion.seals, Omega, z[:n], v, a)
    return ShaftDamping(damping.heat, 2.0 * slope + in_seals, damping.torque, damping.of_skew, of_skew, True)


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
    steady, A, B = matrices.effects[2], direction.real, direction.imag
    for i in range(n):
        a[i] = steady[i] + A * matrices.effects[0, i] + B * matrices.effects[1, i] - a[i]
    for b in range(w.motion.bearings.shape[0]):
        for axis in range(2):
            row = w.motion.bearings[b].row + axis
            force = magnet_force(w, b, axis, z[row])
            if force != 0.0:
                for i in range(n):
                    a[i] += w.Minv[row, i] * force
    for site in w.sites:
        if is_constrained(site):
            f_x = -site.f_n * site.n_x - site.f_t * site.n_y
            f_y = -site.f_n * site.n_y + site.f_t * site.n_x
            for i in range(n):
                a[i] += w.Minv[site.row, i] * f_x + w.Minv[site.row + 1, i] * f_y


@kernel
def mean_heat(before: ShaftDamping, after: ShaftDamping, h: float) -> float:
    """Return the mean dissipation (W) of shaft and seals in a piece of length h (s)."""
    return _mean(before.heat, after.heat, before.slope - after.slope, before.has_slope and after.has_slope, h)


@kernel
def mean_skew_power(before: ShaftDamping, after: ShaftDamping, h: float) -> float:
    """Return the mean power (W) of the seals' skew stiffness in a piece of length h (s)."""
    bent = before.skew_slope - after.skew_slope
    return _mean(before.of_skew, after.of_skew, bent, before.has_slope and after.has_slope, h)


@kernel
def _mean(before: float, after: float, bent: float, has_slope: bool, h: float) -> float:
    """Return the mean of the cubic through two values a time h apart, whose slopes differ by `bent` if known."""
    mean = 0.5 * (before + after)
    return mean + h * bent / 12.0 if has_slope else mean


@kernel
def add_energies(w: Workspace, matrices: StepMatrices, h: float, before: ShaftDamping, after: ShaftDamping) -> None:
    """Add heat and work of a piece of length h (s) from z to z_new; update the peak forces.

    Arguments include the power of shaft damping and seals at both ends.
    """
    n, stages = w.Minv.shape[0], stages_of(w.stages)
    z, z_new, piece = stages.z, stages.z_new, piece_of(matrices)
    integrals, speeds = energy_integrals(z_new, w.n), piece.spin[0]
    is_free, torque = w.spin[0].row >= 0, 0.5 * (before.torque + after.torque)
    steady, damping, friction, work = matrices.key.forces[0], h * mean_heat(before, after, h), 0.0, 0.0
    if w.motion.seals.records.shape[1] > 0:
        mean_speed = 0.5 * (speeds[0] + speeds[N_LOBATTO - 1])
        work += h * mean_skew_power(before, after, h) + stored_by_seals(w.motion.seals, mean_speed, z)
        work -= stored_by_seals(w.motion.seals, mean_speed, z_new)
    for i in range(n):
        work += steady[i] * (z_new[i] - z[i])
    for k in range(w.sites.shape[0]):
        site, of_site = w.sites[k], site_integrals(z_new, w.n, k)
        if site.housing >= 0:
            x = site.housing
            work -= site.housing_mass * (site.base_x * (z_new[x] - z[x]) + site.base_y * (z_new[x + 1] - z[x + 1]))
        heat = friction_heat(site, matrices.nodes[k], h, of_site) if is_constrained(site) else 0.0
        for point in range(N_LOBATTO):
            share = h * LOBATTO_WEIGHTS[point]
            if is_constrained(site) and not is_free:
                work -= share * matrices.nodes[k, point].f_t * site.journal_radius * speeds[point]
            if site.race >= 0:
                heat += share * race_drag(site, piece.races[k, point]) * piece.races[k, point]
            if site.housing >= 0:
                port = port_of_housing(matrices, k)
                v_x, v_y = _velocity(w, matrices, port, point, 0), _velocity(w, matrices, port, point, 1)
                damping += share * (site.mount_damping_x * v_x * v_x + site.mount_damping_y * v_y * v_y)
        friction += heat
        of_site.heat += heat
    n_bearings = w.motion.bearings.shape[0] if magnets_act(w) else 0
    for point in range(N_LOBATTO):
        share = h * LOBATTO_WEIGHTS[point]
        Omega = speeds[point]
        for b in range(n_bearings):
            port = port_of_bearing(matrices, b)
            v = _velocity(w, matrices, port, point, 0), _velocity(w, matrices, port, point, 1)
            damping += share * heat_per_second(w.motion.bearings[b], v[0], v[1])
            for axis in range(2):
                unit = 2 * (int(matrices.sizes[0].n_ports) * point + port) + axis
                work += share * piece.known[unit] * v[axis]
        if is_free:
            damping += share * w.spin[0].drag * Omega * Omega
            work += share * drive_torque(w.spin[0], Omega) * Omega
        else:
            cosine, sine = unbalance_velocity(matrices, point)
            direction = unbalance_direction(piece.spin[1, point], Omega, w.motion.Omega_dot)
            work += share * (direction.real * cosine + direction.imag * sine - torque * Omega)
    integrals.damping_heat += damping
    integrals.friction_heat += friction
    integrals.work += work


@kernel
def _velocity(w: Workspace, matrices: StepMatrices, port: int, point: int, axis: int) -> float:
    """Return the velocity (m/s) of a port at a Lobatto point."""
    if point == 0:
        at_start: float = stages_of(w.stages).z[w.n + int(matrices.ports[port]) + axis]
        return at_start
    at = velocity_index(int(matrices.sizes[0].n_ports), point, port) + axis
    velocity: float = piece_of(matrices).observed[6, at]
    return velocity
