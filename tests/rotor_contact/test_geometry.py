"""A journal in its retainer, against the same in complex numbers: z = x + i y, n = z/|z|, t = i n."""

import numpy as np
import pytest

from rotor_contact.contact.site import (
    SITE,
    can_impact,
    can_touch,
    is_constrained,
    locate_journal,
    put_on_circle,
    radial_component,
    remove_radial_velocity,
    slip_velocity,
    square_of_velocity,
    tangential_component,
)
from rotor_contact.variables.contact_laws import CONSTRAINT, LAWS
from rotor_contact.variables.enumerations import FREE, ROLLING, SLIDING

SIZE, JOURNAL = 12, 4
HOUSINGS = {"fixed": -1, "first": 0, "last": SIZE - 2}
SPINS = {"fixed race, given speed": (-1, -1), "race and free spin": (8, 7), "race and spin of row 0": (0, 0)}


def random_site(rng, housing=-1, race=-1, spin=-1):
    """A site with random geometry, off its centre."""
    site = np.zeros(1, SITE).view(np.recarray)[0]
    site.row, site.housing, site.race, site.spin = JOURNAL, housing, race, spin
    site.offset_x, site.offset_y = rng.normal(size=2)
    site.clearance, site.journal_radius = rng.uniform(0.5, 2.0, 2)
    return site


def relative(site, values):
    """x + i y of the journal from the retainer."""
    local = values[JOURNAL] + 1j * values[JOURNAL + 1]
    return local - (values[site.housing] + 1j * values[site.housing + 1] if site.housing >= 0 else 0.0)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("housing", HOUSINGS.values(), ids=HOUSINGS)
def test_normal_and_velocities_are_relative_to_the_retainer(housing, seed):
    rng = np.random.default_rng(seed)
    site, (q, v) = random_site(rng, housing), rng.normal(size=(2, SIZE))
    z = relative(site, q) - (site.offset_x + 1j * site.offset_y)
    n = z / abs(z)
    assert locate_journal(site, q) == pytest.approx(abs(z), rel=1e-14)
    assert site.radius == pytest.approx(abs(z), rel=1e-14)
    assert site.n_x + 1j * site.n_y == pytest.approx(n, rel=1e-14)
    along = relative(site, v) / n
    assert radial_component(site, v) + 1j * tangential_component(site, v) == pytest.approx(along, rel=1e-13)
    assert square_of_velocity(site, v) == pytest.approx(abs(along) ** 2, rel=1e-13)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(("race", "spin"), SPINS.values(), ids=SPINS)
def test_slip_is_that_of_the_journal_surface_over_the_race(race, spin, seed):
    rng = np.random.default_rng(seed)
    site, (q, v), Omega = random_site(rng, -1, race, spin), rng.normal(size=(2, SIZE)), 3.0
    locate_journal(site, q)
    speed = v[spin] if spin >= 0 else Omega
    surface = speed * site.journal_radius + tangential_component(site, v)
    ring = v[race] * (site.journal_radius + site.clearance) if race >= 0 else 0.0
    assert slip_velocity(site, v, Omega) == pytest.approx(surface - ring, rel=1e-13)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("housing", HOUSINGS.values(), ids=HOUSINGS)
def test_projection_onto_the_circle_moves_along_the_normal_alone(housing, seed):
    rng = np.random.default_rng(seed)
    site, q = random_site(rng, housing), rng.normal(size=SIZE)
    locate_journal(site, q)
    moved = q.copy()
    put_on_circle(site, moved)
    n, others = (site.n_x, site.n_y), np.delete(np.arange(SIZE), (JOURNAL, JOURNAL + 1))
    assert locate_journal(site, moved) == pytest.approx(site.clearance, rel=1e-14)
    assert (site.n_x, site.n_y) == pytest.approx(n, rel=1e-13)
    np.testing.assert_array_equal(moved[others], q[others])


def test_removing_radial_velocity_keeps_the_tangential_one():
    rng = np.random.default_rng(0)
    site, (q, v) = random_site(rng), rng.normal(size=(2, SIZE))
    locate_journal(site, q)
    before = radial_component(site, v), tangential_component(site, v)
    assert remove_radial_velocity(site, v) == before[0]
    assert (radial_component(site, v), tangential_component(site, v)) == pytest.approx((0.0, before[1]), abs=1e-15)


def test_a_journal_at_the_centre_has_a_defined_direction():
    site = random_site(np.random.default_rng(0))
    site.offset_x = site.offset_y = 0.0
    assert locate_journal(site, np.zeros(SIZE)) == 0.0
    assert (site.n_x, site.n_y) == (1.0, 0.0)


@pytest.mark.parametrize("enabled", [0.0, 1.0])
@pytest.mark.parametrize("law", [CONSTRAINT, LAWS.index("hertz")])
@pytest.mark.parametrize("mode", [FREE, SLIDING, ROLLING])
def test_a_free_site_can_touch_and_a_rigid_one_is_held_or_struck(mode, law, enabled):
    site = random_site(np.random.default_rng(0))
    site.mode, site.law, site.enabled = mode, law, enabled
    assert can_touch(site) == (mode == FREE and enabled == 1.0)
    assert can_impact(site) == (mode == FREE and enabled == 1.0 and law == CONSTRAINT)
    assert is_constrained(site) == (mode != FREE and law == CONSTRAINT)
