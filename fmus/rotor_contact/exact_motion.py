"""Exact motion at constant speed under constant inputs, by matrices that all steps share.

Without contact the rotor is linear,

    q'' = -K q - C q' + M^-1 [ f + p cos(Omega t) + r sin(Omega t) + F(t) ]        (3.1, unbalance in p and r)

and with contact forces that are polynomials through their values at Lobatto points, F = sum_j l_j(t/h) F_j
(`collocation`), the state at a time h later is linear in the present one and in these:

    (q, v, o)(h) = P x,  (V_c, V_s) = V x,  x = (q, v, f, A, B, F_j)(0),    V_c - i V_s = int_0^h v exp(-i Omega t) dt

A + i B is the direction of the unbalance at the beginning, from which p and r follow (`series.direct_unbalance`). V_c
and V_s give its work, p V_c + r V_s; o are the values at Gauss points that give the heat of damping: the velocities at
the bearings, or q and v if the shaft is damped.

A communication step is divided into equal pieces, short enough for the series. If a contact might begin, end, stick or
slip in one of them, `events` integrates the step.
"""

from __future__ import annotations

import math

import numpy as np

from fmi_export.flat import copy
from fmi_export.jit import kernel
from fmi_export.model import Array
from rotor_contact.collocation import find_end_forces, find_forces
from rotor_contact.compliant import is_any_compliant
from rotor_contact.contact import is_any_constrained
from rotor_contact.dynamics import collect_coefficients, forces
from rotor_contact.over_step import forget_pieces
from rotor_contact.passive_bearings import is_damping
from rotor_contact.path import Point, point_of, stays_within
from rotor_contact.piece_energy import add_contact_energies, add_free_energies
from rotor_contact.products import row_combination
from rotor_contact.propagator import (
    N_GAUSS,
    N_OBSERVED,
    STEPS_BEFORE_BUILD,
    Key,
    Propagator,
    is_built,
    n_free,
    observed,
)
from rotor_contact.series import build_rows, direct_unbalance, n_observed
from rotor_contact.site import Site, can_touch
from rotor_contact.site_in_piece import stays_clear
from rotor_contact.structure import Structure
from rotor_contact.workspace import N_INTEGRALS, Workspace, stages_of

TOUCH_MARGIN = 1e-4  # of the clearance, within which the path over a piece is not trusted


@kernel
def propagate(
    structure: Structure,
    w: Workspace,
    propagator: Propagator,
    key: Key,
    before: Array,
    n_steps: float,
    step_size: float,
) -> bool:
    """Write the state a communication step after `before` to z; return False if an event may be in the step.

    P is built for `key` over the first STEPS_BEFORE_BUILD steps, of which `n_steps` are done. Also returns False until
    then, and while a compliant site is in contact.
    """
    if not is_built(propagator, key):
        collect_coefficients(structure, w.motion)
        build_rows(structure.Minv, w.motion, w.sites, key, propagator, n_steps / STEPS_BEFORE_BUILD)
    pieces = int(propagator.built[0].n_pieces)
    if n_steps < STEPS_BEFORE_BUILD or pieces == 0 or is_any_compliant(w.sites):
        return False
    in_contact = is_any_constrained(w.sites)
    n, z = w.n, stages_of(w.stages).z
    start, end = propagator.start, propagator.end
    copy(before[: 2 * n], start)
    copy(before[2 * n : 2 * n + N_INTEGRALS], z[2 * n :])
    z[2 * n + N_INTEGRALS :] = 0.0
    h = step_size / pieces
    direct_unbalance(w.motion, propagator)
    for piece in range(pieces):
        if piece > 0:
            copy(end[: 2 * n], start)
        if not _propagate_piece(w, propagator, piece * h, h, in_contact):
            for site in w.sites:
                forget_pieces(site)
            return False
    copy(end[: 2 * n], z)
    return True


@kernel
def _propagate_piece(w: Workspace, propagator: Propagator, tau: float, h: float, in_contact: bool) -> bool:
    """Find the end of a piece of length h (s) that begins at `tau` (s) with the state in x.

    Heat and work go to z. Returns False if an event may be in the piece.
    """
    n = w.n
    motion, end = w.motion, propagator.end
    theta = motion.theta + motion.Omega * tau
    square = motion.Omega * motion.Omega
    start = propagator.start[: n_free(n)]
    copy(forces(motion).steady, start[2 * n :])
    start[3 * n], start[3 * n + 1] = square * math.cos(theta), square * math.sin(theta)
    if in_contact:
        if not find_forces(w, propagator):
            return False
        start = propagator.start
    damped = motion.is_damped
    for bearing in motion.bearings:
        damped = damped or is_damping(bearing)
    row_combination(start, propagator.P, end, 2 * n + (N_GAUSS * n_observed(motion) if damped else 0))
    for k in range(w.sites.shape[0]):
        site = w.sites[k]
        if can_touch(site) and not stays_within(site, start, end, h, n, TOUCH_MARGIN):
            row_combination(start, propagator.S[k], propagator.free_response[k], N_OBSERVED)
            response = observed(propagator.free_response[k])
            points = _journal(site, response, 0), _journal(site, response, 1), _journal(site, response, 2)
            if not stays_clear(site, point_of(site, start, n), points, h):
                return False
    if in_contact and not find_end_forces(w, propagator, end):
        return False
    add_free_energies(w, propagator, start, damped, h)
    if in_contact:
        add_contact_energies(w, propagator, h)
    return True


@kernel
def _journal(site: Site, response: np.record, number: int) -> Point:
    """Return the journal position relative to its retainer's centre at a Lobatto point after the first."""
    at = response.journal[number]
    return Point(at.x - site.offset_x, at.y - site.offset_y, at.v_x, at.v_y)
