"""Whether sites keep their modes over a piece, and how smooth its forces are, judged at its four Lobatto points."""

from __future__ import annotations

import math

from fmi_export.jit import kernel, noinline_kernel
from rotor_contact.contact.face_forces import is_any_pressing
from rotor_contact.contact.friction import STICK_SPEED, friction_limit, has_friction
from rotor_contact.contact.path import Point, journal_of, leaves_or_stays_within, share_before_touch
from rotor_contact.contact.site import Site, can_touch, is_constrained
from rotor_contact.contact.site_totals import Nodes
from rotor_contact.contact.workspace import Workspace, stages_of
from rotor_contact.matrices.step_matrices import StepMatrices
from rotor_contact.pieces.face_in_piece import bend_of_face_forces
from rotor_contact.pieces.piece import phase_error, piece_of
from rotor_contact.pieces.piece_contact import observed_journal
from rotor_contact.shaft.lobatto import LOBATTO_POINTS, N_LOBATTO, positive_share, third_difference
from rotor_contact.variables.enumerations import ROLLING

MAX_PHASE = 1e-5  # rad, by which the unbalance may be ahead or behind in the middle of a piece
MAX_ROUGHNESS = 4e-3  # of the largest force: how far the cubic of a force may be from a parabola
LEAST_FORCE = 1e-3  # N, that counts as none in judging forces
BEND = 0.05  # t^3 is within a twentieth of a parabola
MAX_DEVIATION = 1e-6  # of the clearance, from the circle at the inner points
CLOSE_MARGIN = 4e-6  # of the clearance, within which the path between Lobatto points is not trusted over a step

Points = tuple[Point, Point, Point]  # the journal from the centre of its retainer, at the points after the first


@kernel
def keeps_mode(site: Site, nodes: Nodes) -> bool:
    """Return whether a constrained site keeps its mode (no opening, sticking or slipping) in the piece."""
    return share_in_mode(site, nodes) == 1.0


@kernel
def share_in_mode(site: Site, nodes: Nodes) -> float:
    """Return the share of the piece over which a constrained site certainly keeps its mode."""
    a, b, c, d = nodes[0], nodes[1], nodes[2], nodes[3]
    share = positive_share(a.f_n, b.f_n, c.f_n, d.f_n)
    if site.mode == ROLLING:
        limit_a, limit_b = friction_limit(site, a.f_n), friction_limit(site, b.f_n)
        limit_c, limit_d = friction_limit(site, c.f_n), friction_limit(site, d.f_n)
        for s in (1.0, -1.0):
            rest = positive_share(limit_a - s * a.f_t, limit_b - s * b.f_t, limit_c - s * c.f_t, limit_d - s * d.f_t)
            share = min(share, rest)
    elif has_friction(site):
        s, v = site.slip_sign, STICK_SPEED
        share = min(share, positive_share(s * a.slip - v, s * b.slip - v, s * c.slip - v, s * d.slip - v))
    return share


@kernel
def follows_circle(site: Site, first: Point, second: Point) -> bool:
    """Return whether the journal of a constrained site is close enough to its circle at both inner points."""
    return bool(off_circle(site, first, second) <= 1.0)


@kernel
def off_circle(site: Site, first: Point, second: Point) -> float:
    """Return the distance of a constrained journal from its circle at the inner points, relative to the limit."""
    farthest = max(
        abs(math.hypot(first.x, first.y) - site.clearance), abs(math.hypot(second.x, second.y) - site.clearance)
    )
    deviation: float = farthest / (MAX_DEVIATION * site.clearance)
    return deviation


@noinline_kernel
def stays_clear(site: Site, begin: Point, points: Points, h: float) -> bool:
    """Return whether a free journal stays clear of its retainer in a piece of length h (s), judged by its path."""
    return clear_share(site, begin, points, h, CLOSE_MARGIN) == 1.0


@kernel
def close_margin(share: float) -> float:
    """Return the distance from the retainer, relative to the clearance, within which a piece's path is not trusted.

    `share` is the length of the piece as a share of the step. The error of the path is of fourth order in the length.
    The returned distance is proportional to the square of the length, so that a journal that has just left its circle
    slowly is clear of it within a few short pieces.
    """
    return CLOSE_MARGIN * share * share


@kernel
def clear_share(site: Site, begin: Point, points: Points, h: float, margin: float) -> float:
    """Return the share of a piece of length h (s) over which a free journal stays clear.

    A touch is located on the path between two Lobatto points. If the journal may graze its retainer, within the
    fraction `margin` of the clearance, the result is the last point before the graze.
    """
    start = begin
    for number in range(N_LOBATTO - 1):
        c, end = LOBATTO_POINTS[number], points[number]
        length = LOBATTO_POINTS[number + 1] - c
        if not leaves_or_stays_within(site, start, end, h * length, margin):
            return c + share_before_touch(site, start, end, h * length) * length
        start = end
    return 1.0


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
            first, second = observed_journal(site, matrices, k, 1), observed_journal(site, matrices, k, 2)
            points = first, second, observed_journal(site, matrices, k, 3)
            share = min(share, clear_share(site, journal_of(site, z, w.n), points, h, margin))
        elif is_constrained(site):
            a, b, c, d = matrices.nodes[k, 0], matrices.nodes[k, 1], matrices.nodes[k, 2], matrices.nodes[k, 3]
            rough_n = third_difference(a.f_n, b.f_n, c.f_n, d.f_n)
            rough_t = third_difference(a.f_t, b.f_t, c.f_t, d.f_t)
            roughness = max(roughness, BEND * max(rough_n, rough_t) / allowed)
            first, second = observed_journal(site, matrices, k, 1), observed_journal(site, matrices, k, 2)
            roughness = max(roughness, off_circle(site, first, second))
            share = min(share, share_in_mode(site, matrices.nodes[k]))
    if is_any_pressing(w):
        bend, force = bend_of_face_forces(w, matrices)
        roughness = max(roughness, BEND * bend / (MAX_ROUGHNESS * max(force, LEAST_FORCE)))
    return share, roughness
