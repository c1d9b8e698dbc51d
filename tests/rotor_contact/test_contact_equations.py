"""Multipliers of sites in all modes, on a shaft whose mass couples every direction with every other."""

from functools import cache, partial
from itertools import product

import numpy as np
import pytest
from rotor_cases import both, plant, size_of, workspace

from rotor_contact.contact.constraints import apply_contact, project
from rotor_contact.contact.site import locate_journal, put_on_circle, radial_component, slip_velocity
from rotor_contact.substeps import contact_modes
from rotor_contact.variables.enumerations import FREE, ROLLING, SLIDING

OMEGA, OMEGA_DOT, CLEARANCE, MU = 300.0, 40.0, 0.5e-3, 0.2
NAMES = ("rb1", "rb2", "eb1", "eb2")
VALUES = {f"{name}.{what}": value for name in NAMES for what, value in (("mu", MU), ("clearance", CLEARANCE))}
VALUES |= {"eb1.enabled": 1.0, "eb2.enabled": 1.0, "rb1.offset_x": 1e-4, "eb2.offset_y": -2e-4}
BODIES = both("rb.housing_mass", 3.0) | both("rb.race_inertia", 2e-3)
RIGS = {"fixed": cache(partial(plant, VALUES)), "housings and races": cache(partial(plant, VALUES | BODIES))}
MODES = list(product((FREE, SLIDING, ROLLING), repeat=4))[1::3]


def contact(rig, modes, seed):
    """Sites in these modes, with random positions and velocities of all degrees of freedom, and a random mass."""
    rng = np.random.default_rng(seed)
    w = workspace(RIGS[rig](), OMEGA)
    m = size_of(RIGS[rig]())
    root = rng.normal(size=(m, m))
    w = w._replace(Minv=root @ root.T + 0.1 * np.eye(m), motion=w.motion._replace(Omega_dot=OMEGA_DOT))
    for site, mode in zip(w.sites, modes, strict=True):
        site["mode"], site["slip_sign"] = mode, rng.choice([-1.0, 1.0])
    q, v, a = rng.normal(size=(3, w.n))
    return w, q * CLEARANCE, v, a


def closed(w):
    return [site for site in w.sites if site.mode != FREE]


@pytest.mark.parametrize("rig", RIGS)
@pytest.mark.parametrize("modes", MODES, ids=str)
def test_projection_moves_along_the_constraint_forces_alone(rig, modes):
    w, q, v, _ = contact(rig, modes, seed=sum(modes))
    for site in closed(w):
        locate_journal(site, q)
        put_on_circle(site, q)
    q[: len(w.Minv)] += 1e-6 * CLEARANCE * np.random.default_rng(0).normal(size=len(w.Minv))
    before_q, before_v = q.copy(), v.copy()
    assert project(w, q, v, OMEGA)
    for site in closed(w):
        assert locate_journal(site, q) == pytest.approx(CLEARANCE, rel=1e-10)
        assert radial_component(site, v) == pytest.approx(0.0, abs=1e-8 * np.abs(v).max())
        if site.mode == ROLLING:
            assert slip_velocity(site, v, OMEGA) == pytest.approx(0.0, abs=1e-8 * np.abs(v).max())
    m = len(w.Minv)
    rows = [row for site in closed(w) for row in (site.row, site.row + 1)]
    for moved in (q - before_q, v - before_v):
        impulse = np.linalg.solve(w.Minv, moved[:m])
        np.testing.assert_allclose(np.delete(impulse, rows), 0.0, atol=1e-7 * np.abs(impulse).max(initial=1e-30))


def test_sites_that_no_force_moves_have_zero_multipliers():
    w, q, v, a = contact("fixed", (SLIDING, FREE, FREE, ROLLING), seed=0)
    held, before = w._replace(Minv=np.zeros_like(w.Minv)), (q.copy(), v.copy(), a.copy())
    assert not apply_contact(held, q, v, OMEGA, a)
    assert not project(held, q, v, OMEGA)
    for site in w.sites:
        site["mode"] = FREE
    assert apply_contact(held, q, v, OMEGA, a)
    assert project(held, q, v, OMEGA)
    np.testing.assert_array_equal((q, v, a), before)


def test_endless_changes_of_contact_modes_are_a_fault(monkeypatch):
    monkeypatch.setattr(contact_modes, "_open_tensile", lambda _: True)
    search = getattr(contact_modes.resolve_modes, "py_func", contact_modes.resolve_modes)
    w = contact("fixed", (FREE,) * 4, 0)[0]
    assert search(w, 0.0, 0.0) == contact_modes.FAULT_MODES
