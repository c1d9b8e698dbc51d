"""The path between two states: a bound of its radius that fails only where the journal may touch."""

import numpy as np
import pytest
from rotor_cases import BEARINGS, CLEARANCE, H, memory, plant, run

from rotor_contact.layout import scratch_of
from rotor_contact.path import Point, leaves_or_stays_within, stays_within
from rotor_contact.propagator import STEPS_BEFORE_BUILD
from rotor_contact.structure import structure_of

ALONG = np.linspace(0.0, 1.0, 2001)[:, None]


def scratch(x):
    return scratch_of(x.work, structure_of(x.constants))


@pytest.fixture(scope="module")
def site():
    """A retainer around the origin."""
    return scratch(plant()).sites[0]


def radii(begin, end, dt):
    """Radii along the cubic through two points with their velocities."""
    s = ALONG
    a, u, b, w = (np.array(pair) for pair in (begin[:2], begin[2:], end[:2], end[2:]))
    course = (1 + 2 * s) * (1 - s) ** 2 * a + s * (1 - s) ** 2 * dt * u
    course = course + s**2 * (3 - 2 * s) * b + s**2 * (s - 1) * dt * w
    return np.hypot(*course.T)


def leaving(whirl, inward, gap=0.0):
    """Ends of a step in which a journal that whirls (rad/s) on its circle, or near it, is accelerated to the centre."""
    v = whirl * CLEARANCE
    x, y = CLEARANCE - gap - 0.5 * inward * H**2, v * H
    return Point(CLEARANCE - gap, 0.0, 0.0, v), Point(x, y, -inward * H, v)


def test_a_path_that_is_found_inside_is_inside(site):
    rng = np.random.default_rng(3)
    found = 0
    for _ in range(3000):
        begin, end = (Point(*rng.normal(0, 0.6 * CLEARANCE, 2), *rng.normal(0, 2.0, 2)) for _ in range(2))
        if leaves_or_stays_within(site, begin, end, H, 0.0):
            found += 1
            assert np.max(radii(begin, end, H)) <= CLEARANCE * (1 + 1e-10)
    assert found > 300


@pytest.mark.parametrize("whirl", [60.0, 260.0, 420.0])
@pytest.mark.parametrize(("share", "leaves"), [(1.5, True), (0.5, False)])
def test_a_journal_leaves_its_circle_if_it_turns_faster_than_the_circle(site, whirl, share, leaves):
    """On the circle the acceleration is v^2/c; with more of it the journal leaves, with less it cannot."""
    begin, end = leaving(whirl, share * whirl**2 * CLEARANCE)
    assert leaves_or_stays_within(site, begin, end, H, 0.0) is leaves
    assert bool(np.max(radii(begin, end, H)) <= CLEARANCE * (1 + 1e-10)) is leaves


def test_the_hull_of_the_path_itself_cannot_tell_that_a_journal_leaves(site):
    begin, end = leaving(260.0, 1.5 * 260.0**2 * CLEARANCE)
    states = [np.zeros(2 * 8) for _ in range(2)]
    for z, point in zip(states, (begin, end), strict=True):
        z[site.row : site.row + 2], z[8 + site.row : 10 + site.row] = point[:2], point[2:]
    assert not stays_within(site, *states, H, 8, 0.0)


def test_the_propagator_grows_a_few_rows_a_step_so_that_no_step_is_long():
    x = plant(BEARINGS | {"Omega": 150.0, "d1.u": 1e-4})
    rows = []
    for n in range(STEPS_BEFORE_BUILD + 2):
        run(x, 1, start=n * H)
        rows.append(scratch(x).propagator.built[0].n_rows)
    n_rows = scratch(x).propagator.P.shape[0]
    assert rows[-1] == rows[STEPS_BEFORE_BUILD] == n_rows
    assert max(np.diff(rows)) <= n_rows / STEPS_BEFORE_BUILD + 1


def test_a_plant_that_goes_on_from_a_saved_state_builds_all_at_once_and_agrees():
    x = plant(BEARINGS | {"Omega": 150.0, "d1.u": 1e-4})
    run(x, STEPS_BEFORE_BUILD + 5)
    other = plant(BEARINGS | {"Omega": 150.0, "d1.u": 1e-4})
    other.state[:] = x.state
    for each in (x, other):
        run(each, 3, start=(STEPS_BEFORE_BUILD + 5) * H)
    assert np.array_equal(x.state, other.state)
    assert memory(other).head[0].n_steps == STEPS_BEFORE_BUILD
