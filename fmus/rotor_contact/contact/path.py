"""The path of a journal between two states: the cubic that matches the positions and velocities at both ends.

Its error is the fourth derivative of the motion times dt^4/384, which is a few nanometres for usual steps.

If the path has the Bezier points b_0 to b_3, the square of its radius is a polynomial of degree 6 with the Bezier
points

    b_0.b_0,  b_0.b_1,  (2 b_0.b_2 + 3 b_1.b_1)/5,  (b_0.b_3 + 9 b_1.b_2)/10,
    (2 b_1.b_3 + 3 b_2.b_2)/5,  b_2.b_3,  b_3.b_3

and its values never exceed the largest of these points. This test also recognises a path that leaves the circle
tangentially, although such a path has Bezier points on the tangent, outside the circle.
"""

from __future__ import annotations

from typing import NamedTuple

from fmi_export.jit import kernel
from fmi_export.model import Array
from rotor_contact.contact.site import Site

EXACTLY = 2.0**-40  # share of the time, within which the touch of a path is located
ROUGHLY = 2.0**-12  # the same, where it is enough to know in which short piece that is
ON_CIRCLE = 2e-11  # of the clearance, by which a journal that an event has left on the circle may be beyond it


class Point(NamedTuple):
    """Displacement (m) and velocity (m/s) of a journal from the centre of its retainer."""

    x: float
    y: float
    v_x: float
    v_y: float


@kernel
def keeps_distance(site: Site, begin: Point, end: Point, dt: float, margin: float) -> bool:
    """Return whether the path between two points keeps a distance of `margin` times the clearance from the retainer.

    A cubic lies within the convex hull of its four Bezier points, so checking these suffices.
    """
    limit = (1.0 - margin) * site.clearance
    third = dt * (1.0 / 3.0)
    for point, lead in ((begin, 0.0), (begin, third), (end, -third), (end, 0.0)):
        r_x, r_y = point.x + lead * point.v_x, point.y + lead * point.v_y
        if not r_x * r_x + r_y * r_y < limit * limit:
            return False
    return True


@kernel
def point_of(site: Site, z: Array, n: int) -> Point:
    """Return the motion of a journal in a fixed retainer; z begins with n displacements (m) and n velocities (m/s)."""
    row = site.row
    return Point(z[row] - site.offset_x, z[row + 1] - site.offset_y, z[n + row], z[n + row + 1])


@kernel
def journal_of(site: Site, z: Array, n: int) -> Point:
    """Return the motion of a journal in its retainer, whose housing may move; for z see `point_of`."""
    at, row = point_of(site, z, n), site.housing
    if row >= 0:
        return Point(at.x - z[row], at.y - z[row + 1], at.v_x - z[n + row], at.v_y - z[n + row + 1])
    return at


@kernel
def leaves_or_stays_within(site: Site, begin: Point, end: Point, dt: float, margin: float) -> bool:
    """Return whether a path stays within its retainer, or starts on it and immediately moves away from it.

    The first three Bezier points of the squared radius may lie on the circle; the others must stay inside it by the
    fraction `margin` of the clearance.
    """
    third = dt * (1.0 / 3.0)
    x_1, y_1 = begin.x + third * begin.v_x, begin.y + third * begin.v_y
    x_2, y_2 = end.x - third * end.v_x, end.y - third * end.v_y
    d_0 = begin.x * begin.x + begin.y * begin.y
    d_1 = begin.x * x_1 + begin.y * y_1
    d_2 = 0.4 * (begin.x * x_2 + begin.y * y_2) + 0.6 * (x_1 * x_1 + y_1 * y_1)
    d_3 = 0.1 * (begin.x * end.x + begin.y * end.y) + 0.9 * (x_1 * x_2 + y_1 * y_2)
    d_4 = 0.4 * (x_1 * end.x + y_1 * end.y) + 0.6 * (x_2 * x_2 + y_2 * y_2)
    d_5 = x_2 * end.x + y_2 * end.y
    d_6 = end.x * end.x + end.y * end.y
    circle, limit = (1.0 + ON_CIRCLE) * site.clearance, (1.0 - margin) * site.clearance
    first, last = max(max(d_0, d_1), d_2), max(max(d_3, d_4), max(d_5, d_6))
    return bool(first <= circle * circle and last < limit * limit)


@kernel
def touch_time(site: Site, begin: Point, end: Point, dt: float) -> float:
    """Return the time (s), up to `dt`, at which a path that ends outside its retainer leaves it."""
    return _crossing(site.clearance, begin, end, dt, EXACTLY)[1] * dt


@kernel
def share_before_touch(site: Site, begin: Point, end: Point, dt: float) -> float:
    """Return the share of the time `dt` (s) that passes before the path between two points leaves the retainer.

    The result is 0 if the path begins outside the retainer, or if neither of its ends is outside.
    """
    square = site.clearance * site.clearance
    if not (end.x * end.x + end.y * end.y > square and begin.x * begin.x + begin.y * begin.y < square):
        return 0.0
    return _crossing(site.clearance, begin, end, dt, ROUGHLY)[0]


@kernel
def _crossing(clearance: float, begin: Point, end: Point, dt: float, width: float) -> tuple[float, float]:
    """Return bounds, at most `width` apart, of the share of `dt` (s) after which a path crosses a clearance (m)."""
    low, high = 0.0, 1.0
    while high - low > width:
        s = 0.5 * (low + high)
        rest = 1.0 - s
        of_begin, of_end = rest * rest * (1.0 + 2.0 * s), s * s * (3.0 - 2.0 * s)  # Hermite's cubics
        of_v, of_v_end = rest * rest * s * dt, -s * s * rest * dt
        x = of_begin * begin.x + of_end * end.x + of_v * begin.v_x + of_v_end * end.v_x
        y = of_begin * begin.y + of_end * end.y + of_v * begin.v_y + of_v_end * end.v_y
        if x * x + y * y > clearance * clearance:
            high = s
        else:
            low = s
    return low, high
