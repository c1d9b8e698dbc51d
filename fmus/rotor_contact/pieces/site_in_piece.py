"""Whether a site keeps its mode over a piece of a step, judged by its state at the four Lobatto points."""

from __future__ import annotations

import math

from fmi_export.jit import kernel, noinline_kernel
from rotor_contact.contact.friction import STICK_SPEED, friction_limit, has_friction
from rotor_contact.contact.path import Point, leaves_or_stays_within, share_before_touch
from rotor_contact.contact.site import Site
from rotor_contact.contact.site_totals import Nodes
from rotor_contact.shaft.lobatto import LOBATTO_POINTS, positive_share
from rotor_contact.variables.enumerations import ROLLING

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
    first, second, last = points
    c_1, c_2 = LOBATTO_POINTS[1], LOBATTO_POINTS[2]
    if not leaves_or_stays_within(site, begin, first, h * c_1, margin):
        return share_before_touch(site, begin, first, h * c_1) * c_1
    if not leaves_or_stays_within(site, first, second, h * (c_2 - c_1), margin):
        return c_1 + share_before_touch(site, first, second, h * (c_2 - c_1)) * (c_2 - c_1)
    if not leaves_or_stays_within(site, second, last, h * (1.0 - c_2), margin):
        return c_2 + share_before_touch(site, second, last, h * (1.0 - c_2)) * (1.0 - c_2)
    return 1.0
