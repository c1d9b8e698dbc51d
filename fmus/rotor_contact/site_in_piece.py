"""A site over one piece of a step, by its state at the four Lobatto points: whether its mode lasts, and its heat."""

from __future__ import annotations

import math

import numpy as np

from fmi_export.jit import kernel, kernel_apart
from rotor_contact.enumerations import ROLLING, SLIDING
from rotor_contact.friction import STICK_SPEED, has_friction, static_coefficient
from rotor_contact.lobatto import LOBATTO_POINTS, LOBATTO_WEIGHTS, N_LOBATTO, greatest_of_cubic, least_of_cubic
from rotor_contact.path import Point, leaves_or_stays_within
from rotor_contact.site import Site

MAX_DEVIATION = 1e-6  # of the clearance, from the circle at the inner points
CLOSE_MARGIN = 4e-6  # of the clearance, within which the path between Lobatto points is not trusted

Nodes = np.ndarray[tuple[int], np.dtype[np.record]]  # of type `propagator.NODE`, those of one site
Points = tuple[Point, Point, Point]  # the journal from the centre of its retainer, at the points after the first


@kernel
def keeps_mode(site: Site, nodes: Nodes) -> bool:
    """Return whether a constrained site neither opens nor sticks nor slips in the piece."""
    a, b, c, d = nodes[0], nodes[1], nodes[2], nodes[3]
    if not least_of_cubic(a.f_n, b.f_n, c.f_n, d.f_n) > 0.0:
        return False
    if site.mode == ROLLING:
        mu = static_coefficient(site)
        for s in (1.0, -1.0):
            rest = least_of_cubic(
                mu * a.f_n - s * a.f_t, mu * b.f_n - s * b.f_t, mu * c.f_n - s * c.f_t, mu * d.f_n - s * d.f_t
            )
            if not rest > 0.0:
                return False
        return True
    s = site.slip_sign
    return not has_friction(site) or least_of_cubic(s * a.slip, s * b.slip, s * c.slip, s * d.slip) > STICK_SPEED


@kernel
def follows_circle(site: Site, first: Point, second: Point) -> bool:
    """Return whether the journal of a constrained site is close enough to its circle at both inner points."""
    limit = MAX_DEVIATION * site.clearance
    return bool(
        abs(math.hypot(first.x, first.y) - site.clearance) <= limit
        and abs(math.hypot(second.x, second.y) - site.clearance) <= limit
    )


@kernel_apart
def stays_clear(site: Site, begin: Point, points: Points, h: float) -> bool:
    """Return whether the journal of a free site stays clear in a piece of length h (s), by the path between points."""
    first, second, last = points
    span = LOBATTO_POINTS[2] - LOBATTO_POINTS[1]
    return bool(
        leaves_or_stays_within(site, begin, first, h * LOBATTO_POINTS[1], CLOSE_MARGIN)
        and leaves_or_stays_within(site, first, second, h * span, CLOSE_MARGIN)
        and leaves_or_stays_within(site, second, last, h * (1.0 - LOBATTO_POINTS[2]), CLOSE_MARGIN)
    )


@kernel
def friction_heat(site: Site, nodes: Nodes, h: float, of_site: np.record) -> float:
    """Return the heat of friction (J) at a constrained site; add its normal impulse to its integrals, note its peak.

    Heat is -int T v_slip dt.
    """
    a, b, c, d = nodes[0], nodes[1], nodes[2], nodes[3]
    site.f_n_peak = max(site.f_n_peak, greatest_of_cubic(a.f_n, b.f_n, c.f_n, d.f_n))
    heat = 0.0
    for point in range(N_LOBATTO):
        share = h * LOBATTO_WEIGHTS[point]
        of_site.f_n += share * nodes[point].f_n
        if site.mode == SLIDING:
            heat -= share * nodes[point].f_t * nodes[point].slip
    return heat
