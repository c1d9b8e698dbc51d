"""Smoothness of a piece: how long it certainly has no contact events, and how far its forces are from parabolas."""

from __future__ import annotations

from fmi_export.jit import kernel
from rotor_contact.contact.face_forces import is_any_pressing
from rotor_contact.contact.path import Point, journal_of
from rotor_contact.contact.site import Site, can_touch, is_constrained
from rotor_contact.contact.workspace import Workspace, stages_of
from rotor_contact.matrices.step_matrices import StepMatrices
from rotor_contact.pieces.face_in_piece import bend_of_face_forces
from rotor_contact.pieces.piece import phase_error, piece_of
from rotor_contact.pieces.piece_contact import observed_journal
from rotor_contact.pieces.site_in_piece import clear_share, close_margin, off_circle, share_in_mode
from rotor_contact.shaft.lobatto import N_LOBATTO, third_difference

MAX_PHASE = 1e-5  # rad, by which the unbalance may be ahead or behind in the middle of a piece
MAX_ROUGHNESS = 4e-3  # of the largest force: how far the cubic of a force may be from a parabola
LEAST_FORCE = 1e-3  # N, that counts as none in judging forces
BEND = 0.05  # t^3 is within a twentieth of a parabola


@kernel
def smooth_share(w: Workspace, matrices: StepMatrices, h: float) -> tuple[float, float]:
    """Return the share of a piece of length h (s) without contact events, and the ratio of its roughness to the limit.

    Twice the length gives eight times the roughness.
    """
    piece, z = piece_of(matrices), stages_of(w.stages).z
    share, roughness = 1.0, phase_error(piece) / MAX_PHASE
    margin: float = close_margin(h / matrices.sizes[0].step_size)
    largest = LEAST_FORCE
    for k in range(w.sites.shape[0]):
        if is_constrained(w.sites[k]):
            for point in range(N_LOBATTO):
                largest = max(largest, abs(matrices.nodes[k, point].f_n))
    allowed = MAX_ROUGHNESS * largest
    for k in range(w.sites.shape[0]):
        site = w.sites[k]
        if can_touch(site):
            points = _journal(site, matrices, k, 1), _journal(site, matrices, k, 2), _journal(site, matrices, k, 3)
            share = min(share, clear_share(site, journal_of(site, z, w.n), points, h, margin))
        elif is_constrained(site):
            a, b, c, d = matrices.nodes[k, 0], matrices.nodes[k, 1], matrices.nodes[k, 2], matrices.nodes[k, 3]
            rough_n = third_difference(a.f_n, b.f_n, c.f_n, d.f_n)
            rough_t = third_difference(a.f_t, b.f_t, c.f_t, d.f_t)
            roughness = max(roughness, BEND * max(rough_n, rough_t) / allowed)
            first, second = _journal(site, matrices, k, 1), _journal(site, matrices, k, 2)
            roughness = max(roughness, off_circle(site, first, second))
            share = min(share, share_in_mode(site, matrices.nodes[k]))
    if is_any_pressing(w):
        bend, force = bend_of_face_forces(w, matrices)
        roughness = max(roughness, BEND * bend / (MAX_ROUGHNESS * max(force, LEAST_FORCE)))
    return share, roughness


@kernel
def _journal(site: Site, matrices: StepMatrices, k: int, point: int) -> Point:
    """Return the motion of journal k relative to its retainer's centre, at a Lobatto point after the first."""
    at = observed_journal(site, matrices, piece_of(matrices).observed[6], k, point)
    return Point(at.x - site.offset_x, at.y - site.offset_y, at.v_x, at.v_y)
