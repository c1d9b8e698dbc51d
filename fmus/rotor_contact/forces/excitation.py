"""Excitation of the rotor by base motion, weight, forces and unbalances, as amplitudes of unit forces.

Each input is a pair of amplitudes (a_x, a_y) of two unit forces b_x and b_y on the degrees of freedom. Steady inputs
act as a_x b_x + a_y b_y. The unbalance u exp(i phi) (kg m) of a plane has a_x + i a_y = u exp(i phi), and its force is

    f_x + i f_y = (A + i B) (a_x + i a_y),    A + i B = exp(i theta) (Omega^2 - i Omega')        (3.1 to 3.6)

The pairs have this order: the acceleration of the shaft (base acceleration minus gravity), the acceleration of the
housings (base acceleration), the force on each disc, the unbalance of each disc, and the unbalance of each bearing's
core.
"""

from __future__ import annotations

import math

from fmi_export.jit import kernel, noinline_kernel, views
from fmi_export.model import Array
from rotor_contact.forces.dynamics import Motion, accelerations, divide_by_mass, forces
from rotor_contact.shaft.structure import Structure
from rotor_contact.variables.signals import Inputs, Parameters

OF_SHAFT, OF_HOUSINGS, FIRST_DISC = range(3)  # pairs of steady inputs


@views
def n_pairs(structure: Structure) -> int:
    """Return the number of pairs of amplitudes."""
    return FIRST_DISC + structure.B_disc.shape[0] + structure.bearings.shape[0]


@views
def first_unbalance(number_of_pairs: int, n_bearings: int) -> int:
    """Return the first pair that is an unbalance."""
    return FIRST_DISC + (number_of_pairs - FIRST_DISC - n_bearings) // 2


@noinline_kernel
def collect_amplitudes(parameters: Parameters, inputs: Inputs, amplitudes: Array) -> bool:
    """Write the amplitudes of all inputs, shape (2 n_pairs,); return whether any of them has changed."""
    u, p, n_discs = inputs.scalars[0], parameters.scalars[0], inputs.discs.shape[0]
    g_x = g_y = 0.0
    if p.gravity != 0.0:
        across = p.gravity
        for thrust in parameters.thrust:
            across *= math.cos(thrust.tilt)
        g_x, g_y = across * math.cos(p.gravity_angle), across * math.sin(p.gravity_angle)
    a_x, a_y = u.base_acceleration.x, u.base_acceleration.y
    changed = _set_pair(amplitudes, OF_SHAFT, a_x - g_x, a_y - g_y)
    changed = _set_pair(amplitudes, OF_HOUSINGS, a_x, a_y) or changed
    for d in range(n_discs):
        disc = inputs.discs[d]
        changed = _set_pair(amplitudes, FIRST_DISC + d, disc.f_x, disc.f_y) or changed
        u_x, u_y = unbalance_xy(disc.u, disc.phi)
        changed = _set_pair(amplitudes, FIRST_DISC + n_discs + d, u_x, u_y) or changed
    for b in range(inputs.cores.shape[0]):
        u_x, u_y = unbalance_xy(inputs.cores[b].u, inputs.cores[b].phi)
        changed = _set_pair(amplitudes, FIRST_DISC + 2 * n_discs + b, u_x, u_y) or changed
    return changed


@kernel
def _set_pair(amplitudes: Array, pair: int, x: float, y: float) -> bool:
    """Set a pair of amplitudes; return whether it has changed."""
    changed = amplitudes[2 * pair] != x or amplitudes[2 * pair + 1] != y
    amplitudes[2 * pair], amplitudes[2 * pair + 1] = x, y
    return bool(changed)


@kernel
def unbalance_xy(unbalance: float, phase: float) -> tuple[float, float]:
    """Return the x and y components (kg m) of an unbalance at a rotor angle of zero."""
    if unbalance == 0.0:
        return 0.0, 0.0
    return unbalance * math.cos(phase), unbalance * math.sin(phase)


@noinline_kernel
def collect_forces(structure: Structure, amplitudes: Array, motion: Motion) -> None:
    """Write into a motion the non-magnetic forces of a step, their accelerations, and the rows of the bearings.

    The coefficients K and C and the accelerations due to magnets are written later. The pairs of the base contain
    accelerations, which act on the shaft through its inertia. The shaft's weight has the same effect as an upward
    acceleration of the base.
    """
    n_bearings, pairs = motion.bearings.shape[0], amplitudes.shape[0] // 2
    given, caused = forces(motion), accelerations(motion)
    cosine, sine, steady = given.cosine, given.sine, given.without_magnets
    cosine[:] = 0.0
    sine[:] = 0.0
    steady[:] = 0.0
    for pair in range(pairs):
        a_x, a_y = amplitudes[2 * pair], amplitudes[2 * pair + 1]
        if pair == OF_HOUSINGS or (a_x == 0.0 and a_y == 0.0):
            continue
        for i in range(structure.K.shape[0]):
            b_x, b_y = component(structure, pair, 0, i), component(structure, pair, 1, i)
            if pair < first_unbalance(pairs, n_bearings):
                steady[i] += b_x * a_x + b_y * a_y
            else:
                cosine[i] += b_x * a_x + b_y * a_y
                sine[i] += b_y * a_x - b_x * a_y
    for k in range(n_bearings):
        motion.bearings[k].row = int(structure.bearings[k])
    divide_by_mass(structure.Minv, cosine, caused.cosine)
    divide_by_mass(structure.Minv, sine, caused.sine)
    divide_by_mass(structure.Minv, steady, caused.without_magnets)


@kernel
def component(structure: Structure, pair: int, axis: int, i: int) -> float:
    """Return component i (a degree of freedom of the shaft) of an input's unit force along an axis."""
    n_discs, force = structure.B_disc.shape[0] // 2, 0.0
    if pair == OF_SHAFT:
        force = structure.B_base[axis, i]
    elif pair >= FIRST_DISC:
        plane = pair - FIRST_DISC
        if plane < 2 * n_discs:
            force = structure.B_disc[2 * (plane if plane < n_discs else plane - n_discs) + axis, i]
        elif i == int(structure.bearings[plane - 2 * n_discs]) + axis:
            force = 1.0
    return force
