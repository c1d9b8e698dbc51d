"""Several sites of a flexible rotor at once, with housings, races and a free spin: forces and impacts at an instant.

The plant is put into a random state and makes one step too short to move; the same instant is solved here with one mass
matrix of everything that moves and rows of all constraints.
"""

import numpy as np
import pytest
from flexible_touchdown import FREE, ROLLING, SLIDING
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
H_AT = {site: N + 2 * k for k, site in enumerate(HOUSINGS)}
R_AT = {site: N + 2 * len(HOUSINGS) + k for k, site in enumerate(RACES)}
SPIN = N + 2 * len(HOUSINGS) + len(RACES)
SIZE = SPIN + 1


def row_of(site):
    return REDUCED.translations[RIG.site_nodes[SITES.index(site)]][0]


def turned(n):
    return np.array([-n[1], n[0]])


def rows(site, n):
    """Return the rows that give gap closing speed and slip from all velocities."""
    t, gap, slip = turned(n), np.zeros(SIZE), np.zeros(SIZE)
    at = row_of(site)
    gap[at : at + 2], slip[at : at + 2] = n, t
    if site in H_AT:
        gap[H_AT[site] : H_AT[site] + 2], slip[H_AT[site] : H_AT[site] + 2] = -n, -t
    if site in R_AT:
        slip[R_AT[site]] = -(RADIUS + CLEARANCE[site])
    slip[SPIN] = RADIUS
    return gap, slip


def mass_matrix(theta):
    M = np.zeros((SIZE, SIZE))
    M[:N, :N] = REDUCED.M
    for site, mass in HOUSINGS.items():
        M[H_AT[site], H_AT[site]] = M[H_AT[site] + 1, H_AT[site] + 1] = mass
    for site, inertia in RACES.items():
        M[R_AT[site], R_AT[site]] = inertia
    M[SPIN, SPIN] = INERTIA
    d1 = REDUCED.translations[RIG.disc_nodes[0]]
    M[d1, SPIN] = M[SPIN, d1] = UNBALANCE * np.array([-np.sin(theta), np.cos(theta)])
    return M


def loads(theta, q, v, pressed):
    """Forces without contact; `pressed` (N) on the planes of the sites, complex."""
    Q, Omega = np.zeros(SIZE), v[SPIN]
    Q[:N] = -REDUCED.K @ q[:N] - (REDUCED.C + Omega * REDUCED.G) @ v[:N]
    d1 = REDUCED.translations[RIG.disc_nodes[0]]
    Q[list(d1)] += UNBALANCE * Omega**2 * np.array([np.cos(theta), np.sin(theta)])
    for site, force in zip(SITES, pressed, strict=True):
        Q[row_of(site) : row_of(site) + 2] += force.real, force.imag
    for at in H_AT.values():
        Q[at : at + 2] -= np.array(STIFFNESS) * q[at : at + 2] + np.array(DAMPING) * v[at : at + 2]
    for at in R_AT.values():
        Q[at] -= DRAG * np.tanh(v[at])
    Q[SPIN] += DRIVE
    return Q


def plant_at(values, instant, modes, pressed):
    """The plant at this instant; sites slide in the direction of their slip."""
    theta, q, v, normals = instant
    values = {"Omega": v[SPIN], "d1.u": UNBALANCE, "spin.free": 1.0, "spin.inertia": INERTIA,
              "drive.torque": DRIVE, "drive.torque_limit": DRIVE} | UNWATCHED | values  # fmt: skip
    for site, force in zip(SITES, pressed, strict=True):
        values |= {f"{site}.enabled": 1.0, f"{site}.race_inertia": RACES.get(site, 0.0), f"{site}.race_drag": DRAG}
        values |= {f"{site}.housing_mass": HOUSINGS.get(site, 0.0)}
        for axis, stiffness, damping in zip("xy", STIFFNESS, DAMPING, strict=True):
            values |= {f"{site}.mount_stiffness_{axis}": stiffness, f"{site}.mount_damping_{axis}": damping}
        values |= {f"{LOADED_BY[site]}.f_x": force.real, f"{LOADED_BY[site]}.f_y": force.imag}
    rotor = plant(values)
    z, sites = state(rotor), memory(rotor).sites
    z[: 2 * SIZE] = np.concatenate([q, v])
    head(rotor).theta = theta
    sites["mode"] = modes
    sites["slip_sign"] = [np.sign(rows(site, n)[1] @ v) for site, n in zip(SITES, normals, strict=True)]
    return rotor


def random_instant(seed, resting, rolling):
    """A nearly straight rotor with journals on their retainers, moving along them; angle, state and normals."""
    rng = np.random.default_rng(seed)
    theta = rng.uniform(0, 6)
    q, v = 1e-5 * rng.normal(size=SIZE), 0.1 * rng.normal(size=SIZE)
    q[SPIN], v[SPIN] = theta, 80.0
    normals = []
    for site in SITES:
        angle = rng.uniform(0, 2 * np.pi)
        n = np.array([np.cos(angle), np.sin(angle)])
        normals.append(n)
        if site not in resting:
            continue
        at = row_of(site)
        q[at : at + 2] = CLEARANCE[site] * n + (q[H_AT[site] : H_AT[site] + 2] if site in H_AT else 0.0)
        gap, slip = rows(site, n)
        v[at : at + 2] -= (gap @ v) * n
        if site in rolling:
            v[at : at + 2] -= (slip @ v) * turned(n)
    return theta, q, v, normals


CHOICES = [
    (("rb1",), ()), (("rb1", "rb2"), ()), (SITES, ()), (("rb1", "eb1"), ("eb1",)), (SITES, ("rb2",)),
    (SITES, ("rb1", "eb2")), (("rb1", "rb2"), ("rb1", "rb2")),
]  # fmt: skip


@pytest.mark.parametrize(("resting", "rolling"), CHOICES)
@pytest.mark.parametrize("seed", range(3))
def test_forces_at_several_sites_are_coupled_through_all_bodies(resting, rolling, seed):
    theta, q, v, normals = instant = random_instant(seed, resting, rolling)
    mu = {site: 5.0 if site in rolling else 0.05 for site in SITES}
    pressed = [(3e6 if site in resting else 0.0) * complex(*n) for site, n in zip(SITES, normals, strict=True)]
    A, b, directions, names = [], [], [], []
    for site, n in zip(SITES, normals, strict=True):
        if site not in resting:
            continue
        gap, slip = rows(site, n)
        across = slip[: min(R_AT.values())] @ v[: min(R_AT.values())]
        A.append(gap)
        b.append(-(across**2) / CLEARANCE[site])
        names.append(f"{site}.f_n")
        if site in rolling:
            A.append(slip)
            b.append(0.0)
            names.append(f"{site}.f_t")
            directions += [-gap, slip]
        else:
            directions.append(-gap - mu[site] * np.sign(slip @ v) * slip)
    A, directions, Minv = np.array(A), np.array(directions).T, np.linalg.inv(mass_matrix(theta))
    forces = np.linalg.solve(A @ Minv @ directions, b - A @ Minv @ loads(theta, q, v, pressed))

    modes = [FREE if s not in resting else ROLLING if s in rolling else SLIDING for s in SITES]
    rotor = plant_at({f"{site}.mu": value for site, value in mu.items()}, instant, modes, pressed)
    rotor.step(0.0, 1e-10)
    assert [rotor[f"{site}.mode"] for site in SITES] == modes
    np.testing.assert_allclose([rotor[name] for name in names], forces, rtol=1e-7, atol=2.0)


@pytest.mark.parametrize("struck", [("rb1",), ("rb1", "rb2"), SITES])
@pytest.mark.parametrize("mu", [0.0, 0.02])
@pytest.mark.parametrize("e", [0.0, 0.7])
def test_impacts_at_several_sites_conserve_the_momentum_of_all_bodies(struck, mu, e):
    """All gaps close at once, and friction is too small to end the slip: one impulse at each site."""
    moment = 1e-12
    theta, q, v, normals = instant = random_instant(7, struck, ())
    A, directions = [], []
    for site, n in zip(SITES, normals, strict=True):
        if site in struck:
            gap, slip = rows(site, n)
            at = row_of(site)
            v[at : at + 2] += (0.3 - gap @ v) * n
            q[at : at + 2] -= 0.5 * moment * 0.3 * n
            A.append(gap)
            directions.append(-gap - mu * np.sign(slip @ v) * slip)
    A, directions, Minv = np.array(A), np.array(directions).T, np.linalg.inv(mass_matrix(theta))
    impulses = np.linalg.solve(A @ Minv @ directions, -(1 + e) * (A @ v))
    assert np.all(impulses > 0.0)
    after = v + Minv @ directions @ impulses

    rotor = plant_at({f"{s}.mu": mu for s in SITES} | {f"{s}.restitution": e for s in SITES}, instant, FREE, [0j] * 4)
    rotor.step(0.0, moment)
    np.testing.assert_allclose([rotor[f"{site}.impulse"] for site in struck], impulses, rtol=1e-6)
    np.testing.assert_allclose(state(rotor)[SIZE : 2 * SIZE], after, atol=1e-6)
