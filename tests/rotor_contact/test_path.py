"""The path between two states: a bound of its radius that fails only where the journal may touch."""

import numpy as np
import pytest
from numpy.polynomial import Polynomial
from rotor_cases import BEARINGS, CLEARANCE, H, plant, run, scratch
from scipy.interpolate import BPoly, PPoly
from scipy.optimize import brentq

from rotor_contact.contact.path import (
    Point,
    keeps_distance,
    leaves_or_stays_within,
    point_of,
    share_before_touch,
    touch_time,
)
from rotor_contact.matrices.matrix_schedule import STEPS_BEFORE_BUILD
from rotor_contact.matrices.matrix_sizes import FIRST_CONSTANT
from rotor_contact.pieces.site_in_piece import clear_share, close_margin
from rotor_contact.shaft.lobatto import LOBATTO_POINTS

ALONG = np.linspace(0.0, 1.0, 2001)[:, None]


@pytest.fixture(scope="module")
def site():
    """A retainer around the origin."""
    return scratch(plant()).sites[0]


@pytest.fixture(scope="module")
def off_centre():
    """The same, its centre not in the origin."""
    return scratch(plant({"rb1.offset_x": 2e-4, "rb1.offset_y": -3e-4})).sites[0]


def cubic(begin, end, dt):
    """The course over time through two points with their velocities, by SciPy."""
    a, u, b, w = (np.array(pair) for pair in (begin[:2], begin[2:], end[:2], end[2:]))
    return BPoly.from_derivatives([0.0, dt], [[a, u], [b, w]])


def radii(begin, end, dt):
    """Radii along the cubic through two points with their velocities."""
    return np.hypot(*cubic(begin, end, dt)(ALONG[:, 0] * dt).T)


def random_ends(rng, spread):
    return tuple(Point(*rng.normal(0, spread * CLEARANCE, 2), *rng.normal(0, 2.0, 2)) for _ in range(2))


def ends_near_the_circle(rng):
    """Ends for which each of the Bezier points decides now and then."""
    radii, angles = CLEARANCE * rng.uniform(0.7, 1.0, 2), rng.normal(0, 0.2, 2)
    return tuple(
        Point(r * np.cos(a), r * np.sin(a), *rng.normal(0, 2.0, 2)) for r, a in zip(radii, angles, strict=True)
    )


def states_of(site, *points, n=8):
    """States with the journal of a site at points that are given from the centre of its retainer."""
    states = [np.zeros(2 * n) for _ in points]
    for z, point in zip(states, points, strict=True):
        z[site.row : site.row + 2] = point[0] + site.offset_x, point[1] + site.offset_y
        z[n + site.row : n + site.row + 2] = point[2:]
    return states


def bezier_points_of_the_square(begin, end):
    """Bezier points of the squared radius, from the powers of its polynomial, by numpy and SciPy."""
    powers = [
        Polynomial(np.polynomial.polynomial.polyfit(np.linspace(0, 1, 4), axis, 3))
        for axis in cubic(begin, end, H)(np.linspace(0, 1, 4) * H).T
    ]
    square = sum((axis * axis).coef for axis in powers)
    from_highest = np.asarray(square)[::-1].reshape(-1, 1)
    return BPoly.from_power_basis(PPoly(from_highest, [0.0, 1.0])).c[:, 0]


def leaving(whirl, inward, gap=0.0):
    """Ends of a step in which a journal that whirls (rad/s) on its circle, or near it, is accelerated to the centre."""
    v = whirl * CLEARANCE
    x, y = CLEARANCE - gap - 0.5 * inward * H**2, v * H
    return Point(CLEARANCE - gap, 0.0, 0.0, v), Point(x, y, -inward * H, v)


def test_a_path_classified_as_inside_is_inside(site):
    rng = np.random.default_rng(3)
    result = 0
    for _ in range(3000):
        begin, end = random_ends(rng, 0.6)
        if leaves_or_stays_within(site, begin, end, H, 0.0):
            result += 1
            assert np.max(radii(begin, end, H)) <= CLEARANCE * (1 + 1e-10)
    assert result > 300


def test_the_bound_is_the_largest_bezier_point_of_the_squared_radius(site):
    rng = np.random.default_rng(5)
    result = []
    for k in range(3000):
        begin, end = random_ends(rng, 0.5) if k % 2 else ends_near_the_circle(rng)
        points = bezier_points_of_the_square(begin, end) / CLEARANCE**2
        inside = np.max(points[:3]) <= 1.0 and np.max(points[3:]) < 0.81
        if min(abs(np.max(points[:3]) - 1.0), abs(np.max(points[3:]) - 0.81)) > 1e-9:
            result.append(inside)
            assert leaves_or_stays_within(site, begin, end, H, 0.1) is bool(inside)
    assert 300 < sum(result) < 2700


def test_the_hull_of_the_path_is_that_of_its_bezier_points(off_centre):
    rng = np.random.default_rng(6)
    result = []
    for _ in range(3000):
        begin, end = random_ends(rng, 0.5)
        hull = np.hypot(*cubic(begin, end, H).c[:, 0].T) / CLEARANCE
        result.append(bool(np.max(hull) < 0.9))
        assert keeps_distance(off_centre, begin, end, H, 0.1) is result[-1]
    assert 300 < sum(result) < 2700


def test_path_of_a_journal_is_relative_to_the_centre_of_its_retainer(off_centre):
    (begin, end) = random_ends(np.random.default_rng(7), 0.5)
    for point, z in zip((begin, end), states_of(off_centre, begin, end), strict=True):
        assert point_of(off_centre, z, 8) == pytest.approx(point, rel=1e-12)


def test_the_time_of_touch_is_where_the_path_crosses_the_circle(off_centre):
    rng = np.random.default_rng(8)
    crossed = 0
    while crossed < 300:
        begin, end = random_ends(rng, 0.7)
        along = radii(begin, end, H)
        if not (along[0] < CLEARANCE < along[-1]) or np.sum(np.diff(along > CLEARANCE)) != 1:
            continue
        crossed += 1
        path = cubic(begin, end, H)
        expected = brentq(lambda t, path=path: np.hypot(*path(t)) - CLEARANCE, 0.0, H, xtol=1e-18)
        result = touch_time(off_centre, begin, end, H)
        assert result == pytest.approx(expected, abs=1e-10 * H)


@pytest.mark.parametrize("whirl", [60.0, 260.0, 420.0])
@pytest.mark.parametrize(("share", "leaves"), [(1.5, True), (0.5, False)])
def test_a_journal_leaves_its_circle_if_it_turns_faster_than_the_circle(site, whirl, share, leaves):
    """On the circle the acceleration is v^2/c; with more of it the journal leaves, with less it cannot."""
    begin, end = leaving(whirl, share * whirl**2 * CLEARANCE)
    assert leaves_or_stays_within(site, begin, end, H, 0.0) is leaves
    assert bool(np.max(radii(begin, end, H)) <= CLEARANCE * (1 + 1e-10)) is leaves


def test_at_another_speed_the_matrices_grow_by_a_few_rows_in_each_step():
    x = plant(BEARINGS | {"Omega": 150.0, "d1.u": 1e-4})
    run(x, 2)
    matrices = scratch(x).matrices
    n_rows = matrices.sizes[0].n_rows * matrices.sizes[0].n_built
    slot = matrices.slots[FIRST_CONSTANT]
    assert slot.n_rows == n_rows
    x["Omega"] = 160.0
    run(x, 1, start=2 * H)
    rows = [0.0]
    for n in range(3, STEPS_BEFORE_BUILD + 4):
        run(x, 1, start=n * H)
        rows.append(float(slot.n_rows) if matrices.constant[0, 0] == 160.0 else 0.0)
    assert rows[-1] == rows[STEPS_BEFORE_BUILD] == n_rows
    assert max(np.diff(rows)) <= n_rows / STEPS_BEFORE_BUILD + 4


def test_share_before_touch_ends_just_before_contact(site):
    begin = Point(0.6 * CLEARANCE, 0.1 * CLEARANCE, 1.5, 0.8)
    end = Point(1.05 * CLEARANCE, 0.4 * CLEARANCE, 1.7, 0.9)
    course = cubic(begin, end, H)
    touch = brentq(lambda t: np.hypot(*course(t)) - CLEARANCE, 0.0, H)
    assert 0.0 <= touch / H - share_before_touch(site, begin, end, H) <= 1e-3
    assert share_before_touch(site, end, begin, H) == 0.0


def test_a_journal_that_lifts_off_slowly_is_clear_a_short_piece_later(site):
    """Otherwise it would be integrated for as long as the bound over a whole step cannot exclude contact."""
    h, inwards = H / 32, 1.0

    def at(t):
        return Point(CLEARANCE - 0.5 * inwards * t * t, 0.0, -inwards * t, 0.0)

    points = tuple(at(h + c * h) for c in LOBATTO_POINTS[1:])
    assert clear_share(site, at(h), points, h, close_margin(h / H)) == 1.0
    assert clear_share(site, at(h), points, h, close_margin(1.0)) == 0.0
    approach = tuple(Point(CLEARANCE + 2e-9 * (c - 0.5), 0.0, 2e-9 / h, 0.0) for c in LOBATTO_POINTS)
    assert clear_share(site, approach[0], approach[1:], h, close_margin(h / H)) == pytest.approx(0.5, abs=1e-3)
