"""Several sites of a flexible rotor at once, with housings, races and a free spin: forces and impacts at an instant.

The plant is put into a random state and makes one step too short to move; `flexible_touchdown` solves the same instant
with one mass matrix of everything that moves and rows of all constraints.
"""

import numpy as np
import pytest
from flexible_touchdown import FREE, ROLLING, SLIDING, FlexibleTouchdown, Retainer
from rotor_cases import UNWATCHED, head, memory, plant, state

from rotor_analysis.assembly import assemble
from rotor_analysis.reduction import msdc
from rotor_analysis.rotor_file import load_rotor

RIG = load_rotor()
REDUCED = msdc(assemble(RIG, "diagonal"), RIG.masters).model
N = REDUCED.size
CLEARANCE = {"rb1": 0.75e-3, "rb2": 0.75e-3, "eb1": 0.9e-3, "eb2": 0.9e-3}
SITES = tuple(CLEARANCE)
LOADED_BY = dict(zip(SITES, ("mb1", "mb2", "d1", "d4"), strict=True))  # what has an input of force in that plane
UNBALANCE, INERTIA, RADIUS, DRIVE = 0.02, 0.5, 0.025, 3.0
HOUSINGS = {"rb1": 5.0, "eb1": 2.0}  # kg
RACES = {"rb1": 1e-3, "rb2": 2e-3}  # kg m2
STIFFNESS, DAMPING, DRAG = (3e6, 5e6), (200.0, 400.0), 0.01


def model_of(pressed, mu, e=0.0):
    """The machine with forces on the planes of its sites (N, complex) and their friction."""
    row_of = {site: REDUCED.translations[node][0] for site, node in zip(SITES, RIG.site_nodes, strict=True)}
    unbalance, force = np.zeros(N), np.zeros(N)
    unbalance[REDUCED.translations[RIG.disc_nodes[0]][0]] = UNBALANCE
    for site, f in zip(SITES, pressed, strict=True):
        force[row_of[site] : row_of[site] + 2] += f.real, f.imag
    retainers = tuple(
        Retainer(row, CLEARANCE[site], RADIUS, mu[site], HOUSINGS.get(site, 0.0), STIFFNESS, DAMPING,
                 RACES.get(site, 0.0), DRAG, restitution=e)
        for site, row in row_of.items()
    )  # fmt: skip
    shaft = REDUCED.M, REDUCED.C, np.zeros((N, N)), REDUCED.G, REDUCED.K
    return FlexibleTouchdown(*shaft, unbalance, force, retainers, INERTIA, torque=DRIVE)


ANY = model_of([0j] * len(SITES), dict.fromkeys(SITES, 0.0))


def signs(q, v):
    """Directions of the slip."""
    return [float(np.sign(ANY.rows(k, q)[1] @ v)) for k in range(len(SITES))]


def plant_at(values, q, v, modes, pressed):
    """The plant at this instant; sites slide in the direction of their slip."""
    values = {"Omega": v[-1], "d1.u": UNBALANCE, "spin.free": 1.0, "spin.inertia": INERTIA,
              "drive.torque": DRIVE, "drive.torque_limit": DRIVE} | UNWATCHED | values  # fmt: skip
    for site, force in zip(SITES, pressed, strict=True):
        values |= {f"{site}.enabled": 1.0, f"{site}.race_inertia": RACES.get(site, 0.0), f"{site}.race_drag": DRAG}
        values |= {f"{site}.housing_mass": HOUSINGS.get(site, 0.0)}
        for axis, stiffness, damping in zip("xy", STIFFNESS, DAMPING, strict=True):
            values |= {f"{site}.mount_stiffness_{axis}": stiffness, f"{site}.mount_damping_{axis}": damping}
        values |= {f"{LOADED_BY[site]}.f_x": force.real, f"{LOADED_BY[site]}.f_y": force.imag}
    rotor = plant(values)
    z, sites = state(rotor), memory(rotor).sites
    z[: 2 * ANY.size] = np.concatenate([q, v])
    head(rotor).theta = q[-1]
    sites["mode"], sites["slip_sign"] = modes, signs(q, v)
    return rotor


def random_instant(seed, resting, rolling):
    """A nearly straight rotor with journals on their retainers, moving along them; coordinates, velocities, normals."""
    rng = np.random.default_rng(seed)
    theta = rng.uniform(0, 6)
    q, v = 1e-5 * rng.normal(size=ANY.size), 0.1 * rng.normal(size=ANY.size)
    q[-1], v[-1] = theta, 80.0
    normals = []
    for k, (name, site) in enumerate(zip(SITES, ANY.sites, strict=True)):
        angle = rng.uniform(0, 2 * np.pi)
        n = np.array([np.cos(angle), np.sin(angle)])
        normals.append(n)
        if name not in resting:
            continue
        journal = slice(site.row, site.row + 2)
        q[journal] += site.clearance * n - ANY.apart(k, q)
        outward, slip = ANY.rows(k, q)
        v[journal] -= (outward @ v) * n
        if name in rolling:
            v[journal] -= (slip @ v) * np.array([-n[1], n[0]])
    return q, v, normals


CHOICES = [
    (("rb1",), ()), (("rb1", "rb2"), ()), (SITES, ()), (("rb1", "eb1"), ("eb1",)), (SITES, ("rb2",)),
    (SITES, ("rb1", "eb2")), (("rb1", "rb2"), ("rb1", "rb2")),
]  # fmt: skip


@pytest.mark.parametrize(("resting", "rolling"), CHOICES)
@pytest.mark.parametrize("seed", range(3))
def test_forces_at_several_sites_are_coupled_through_all_bodies(resting, rolling, seed):
    q, v, normals = random_instant(seed, resting, rolling)
    mu = {site: 5.0 if site in rolling else 0.05 for site in SITES}
    pressed = [(3e6 if site in resting else 0.0) * complex(*n) for site, n in zip(SITES, normals, strict=True)]
    modes = [FREE if s not in resting else ROLLING if s in rolling else SLIDING for s in SITES]
    contact = {k: (mode, sign) for k, (mode, sign) in enumerate(zip(modes, signs(q, v), strict=True)) if mode != FREE}
    forces = model_of(pressed, mu).forces(q, v, contact)[1]

    rotor = plant_at({f"{site}.mu": value for site, value in mu.items()}, q, v, modes, pressed)
    rotor.step(0.0, 1e-10)
    assert [rotor[f"{site}.mode"] for site in SITES] == modes
    found = [[rotor[f"{SITES[k]}.{name}"] for name in ("f_n", "f_t")] for k in forces]
    np.testing.assert_allclose(found, list(forces.values()), rtol=1e-7, atol=2.0)


@pytest.mark.parametrize("struck", [("rb1",), ("rb1", "rb2"), SITES])
@pytest.mark.parametrize("mu", [0.0, 0.02])
@pytest.mark.parametrize("e", [0.0, 0.7])
def test_impacts_at_several_sites_conserve_the_momentum_of_all_bodies(struck, mu, e):
    """All gaps close at once, and friction is too small to end the slip: one impulse at each site."""
    moment = 1e-12
    q, v, normals = random_instant(7, struck, ())
    for k, (name, site) in enumerate(zip(SITES, ANY.sites, strict=True)):
        if name in struck:
            journal, n = slice(site.row, site.row + 2), normals[k]
            v[journal] += (0.3 - ANY.rows(k, q)[0] @ v) * n
            q[journal] -= 0.5 * moment * 0.3 * n
    contact = {k: (SLIDING, sign) for k, sign in enumerate(signs(q, v)) if SITES[k] in struck}
    model = model_of([0j] * len(SITES), dict.fromkeys(SITES, mu), e)
    after, impulses = model.impulses(q, v, contact, rebounds=True)
    normal = [P for P, _ in impulses.values()]
    assert min(normal) > 0.0

    values = {f"{s}.mu": mu for s in SITES} | {f"{s}.restitution": e for s in SITES}
    rotor = plant_at(values, q, v, FREE, [0j] * len(SITES))
    rotor.step(0.0, moment)
    np.testing.assert_allclose([rotor[f"{site}.impulse"] for site in struck], normal, rtol=1e-6)
    np.testing.assert_allclose(state(rotor)[ANY.size : 2 * ANY.size], after, atol=1e-6)
