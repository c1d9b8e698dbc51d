"""A whole step at a constant speed by one product: free flight, or contact that persists (`whole_step`).

Its contact forces are cubics over the step (`collocation`). A step in which a contact may begin, end, stick or slip, or
whose motion is too fast for such cubics, is left to pieces (`matrix_step`).
"""

from __future__ import annotations

from fmi_export.flat import copy
from fmi_export.jit import inlined_kernel, kernel, noinline_kernel
from fmi_export.model import Array
from rotor_contact.contact.constraints import is_any_constrained
from rotor_contact.contact.path import Point, journal_of, keeps_distance
from rotor_contact.contact.site import Site, can_touch
from rotor_contact.contact.workspace import Workspace, stages_of
from rotor_contact.matrices.matrix_sizes import FIRST_CONSTANT
from rotor_contact.matrices.speed_grid import CONSTANT
from rotor_contact.matrices.step_matrices import StepMatrices
from rotor_contact.pieces.piece import advance_rotations, start_rotations
from rotor_contact.pieces.piece_energy import Damping, add_energies
from rotor_contact.pieces.piece_ports import gradients_change
from rotor_contact.pieces.site_in_piece import stays_clear
from rotor_contact.shaft.products import row_combination, triangular_form
from rotor_contact.whole_steps.collocation import find_end_forces, find_first_forces, find_forces
from rotor_contact.whole_steps.flight import fly
from rotor_contact.whole_steps.whole_step import begin_whole_step
from rotor_contact.whole_steps.whole_step_rows import WholeStep, first_contact, first_held, observed, whole_step_of

LONGEST_REACH = 2.0  # of a step in contact: its length times the highest rate of change
# Of the clearance, within which the path over a step is observed at Lobatto points: in free flight, and in contact,
# whose motion is slower than `LONGEST_REACH`.
FLIGHT_MARGIN, CONTACT_MARGIN = 0.02, 1e-4


@inlined_kernel
def take_whole_step(w: Workspace, matrices: StepMatrices, h: float) -> bool:
    """Advance z over a step of length h (s) at a constant speed; return False, with z unchanged, if it needs pieces."""
    motion, stages, in_contact = w.motion, stages_of(w.stages), is_any_constrained(w.sites)
    if not _can_be_whole(w, matrices, in_contact):
        return False
    begin_whole_step(w, matrices)
    whole = whole_step_of(matrices, int(matrices.sizes[0].place - CONSTANT))
    if in_contact and not find_first_forces(w, matrices, whole):
        return False
    if not (_keep_contact(w, matrices, whole) if in_contact else fly(w, matrices, whole, h)):
        return False
    for k in range(w.sites.shape[0]):
        if can_touch(w.sites[k]) and not _is_clear(w, whole, k, h, CONTACT_MARGIN if in_contact else FLIGHT_MARGIN):
            return False
    if in_contact and not find_end_forces(w, whole, stages.z_new):
        return False
    x, n, heat = whole.x, int(matrices.sizes[0].n), 0.0
    work = x[2 * n + 2] * whole.end[2 * n] + x[2 * n + 3] * whole.end[2 * n + 1]
    if matrices.sizes[0].damped != 0.0:
        size = first_held(matrices) + matrices.gradients.shape[0]
        if in_contact:
            size = x.shape[0]
        elif gradients_change(motion, matrices):
            size = first_contact(matrices)
        heat = triangular_form(whole.H, x, size)
        if matrices.sizes[0].powered != 0.0:
            work += triangular_form(whole.G, x, size)
    start_rotations(w, matrices, motion.theta, motion.Omega)
    advance_rotations(w, matrices, h, 0.0)
    add_energies(w, matrices, h, Damping(heat, 0.0, 0.0), work)
    copy(stages.z_new, stages.z)
    return True


@kernel
def _can_be_whole(w: Workspace, matrices: StepMatrices, in_contact: bool) -> bool:
    """Return whether the speed is constant, no race turns, and any contact is slow enough and in fixed retainers."""
    place = matrices.sizes[0].place
    if place == 0.0:
        return False
    if in_contact:
        reach = matrices.slots[FIRST_CONSTANT + int(place - CONSTANT)].reach
        return w.n == w.Minv.shape[0] and reach <= LONGEST_REACH and not gradients_change(w.motion, matrices)
    v = stages_of(w.stages).z[w.n :]
    for site in w.sites:
        if site.race >= 0 and v[site.race] != 0.0:
            return False
    return True


@noinline_kernel
def _keep_contact(w: Workspace, matrices: StepMatrices, whole: WholeStep) -> bool:
    """Write the state at the end of a step in contact to z_new; return False if the contact may change in the step."""
    stages = stages_of(w.stages)
    if not find_forces(w, matrices, whole):
        return False
    row_combination(whole.x, whole.F, whole.end, whole.end.shape[0])
    copy(stages.z, stages.z_new)
    copy(whole.end[: 2 * w.n], stages.z_new)
    return True


@kernel
def _is_clear(w: Workspace, whole: WholeStep, k: int, h: float, margin: float) -> bool:
    """Return whether a free journal stays clear of its retainer over a step from z to z_new.

    This is so if the path between both ends keeps a distance of `margin` times the clearance, or if the path between
    the Lobatto points is clear. The second path is not known relative to a housing that can move.
    """
    site, stages = w.sites[k], stages_of(w.stages)
    begin, end = journal_of(site, stages.z, w.n), journal_of(site, stages.z_new, w.n)
    if keeps_distance(site, begin, end, h, margin):
        return True
    if site.housing >= 0:
        return False
    response = whole.free_response[k]
    row_combination(whole.x, whole.S[k], response, response.shape[0])
    points = _journal(site, response, 0), _journal(site, response, 1), _journal(site, response, 2)
    clear: bool = stays_clear(site, begin, points, h)
    return clear


@kernel
def _journal(site: Site, response: Array, number: int) -> Point:
    """Return the motion of the journal relative to its retainer's centre, at a Lobatto point after the first."""
    at = observed(response).journal[number]
    return Point(at.x - site.offset_x, at.y - site.offset_y, at.v_x, at.v_y)
