"""Falls of whole machines onto their retainers against an independent integration with located events.

Every fall begins at the centre, at rest, and goes on for many impacts. On rigid retainers the orbit of a small rotor is
chaotic: a difference grows tenfold every few impacts, so these cases end sooner.
"""

from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np
import pytest
from flexible_touchdown import ROLLING, SLIDING, FlexibleTouchdown, Retainer, fall
from instances import initialised
from rotor_cases import UNWATCHED, state
from strange_machine import ROTOR

from amb_cosim.model_constants.plant_data import plant
from rotor_analysis.rotor_file import load_rotor
from rotor_contact.shaft.structure import structure_of

MU = 0.12
MOUNT = {
    "housing_mass": 0.3,
    "mount_stiffness_x": 5e6,
    "mount_stiffness_y": 8e6,
    "mount_damping_x": 600.0,
    "mount_damping_y": 900.0,
}
RACE = {"race_inertia": 2e-5, "race_drag": 0.01}
LIGHT_RACE = {"race_inertia": 3e-7, "race_drag": 0.001}
WHEELS = {"expander_wheel": (2e-6, 0.3), "compressor_wheel": (3e-6, 1.5)}


@dataclass(frozen=True)
class Case:
    """A machine, its speed (rad/s), steps of `h` (s) to `end`, and the unbalance (kg m, rad) of its discs."""

    rotor: str
    Omega: float
    h: float
    end: float
    impacts: int
    unbalance: dict = field(default_factory=dict)
    site: dict = field(default_factory=dict)
    Omega_dot: float | None = None  # None: the spin is free
    rolls: bool = False
    orbit: float = 1e-5  # of the clearance


CASES = {
    "compressor": Case("compressor", 1000.0, 1e-4, 0.0155, 7, {"impeller1": (1e-4, 0.0), "impeller5": (1e-4, 2.0)}),
    "mounts and races": Case("turbo_expander", 4000.0, 5e-5, 0.025, 200, WHEELS, MOUNT | RACE),
    "races that roll": Case(
        "turbo_expander", 4000.0, 5e-5, 0.0079, 40, WHEELS, MOUNT | LIGHT_RACE, rolls=True, orbit=2e-4
    ),
    "speed ramp": Case("turbo_expander", 4000.0, 5e-5, 0.0083, 9, WHEELS, Omega_dot=-3000.0),
    "constant speed": Case("turbo_expander", 4000.0, 5e-5, 0.0063, 9, WHEELS, Omega_dot=0.0, orbit=3e-5),
    "cross-coupled seal": Case(str(ROTOR), 3000.0, 5e-5, 0.016, 70),
    "rig with four sites": Case("bath_rig", 260.0, 2.5e-4, 0.032, 70, {"d1": (1e-3, 0.0), "d3": (5e-4, 2.0)}),
}
QUICK = ("compressor", "constant speed")


def fallen_plant(case):
    """The plant at rest, and its rotor."""
    rotor = load_rotor(case.rotor)
    values = UNWATCHED | {"gravity": 9.81, "Omega": case.Omega, "spin.free": float(case.Omega_dot is None)}
    if case.Omega_dot is not None:
        values["Omega_dot"] = case.Omega_dot
    for site in rotor.sites:
        values |= {f"{site.name}.{name}": value for name, value in ({"mu": MU} | case.site).items()}
    for disc, (u, phi) in case.unbalance.items():
        values |= {f"{disc}.u": u, f"{disc}.phi": phi}
    return initialised(*plant(rotor), values), rotor


def reference_of(case, x, rotor):
    """The same machine for the independent integration."""
    s = structure_of(x.constants)
    n, site = s.K.shape[0], case.site
    downward = -9.81 * np.array([np.cos(x["gravity_angle"]), np.sin(x["gravity_angle"])])
    unbalance, discs = np.zeros(n), [disc.name for disc in rotor.discs if disc.unbalance]
    for disc, (u, phi) in case.unbalance.items():
        k = discs.index(disc)
        unbalance += u * (np.cos(phi) * s.B_disc[2 * k] + np.sin(phi) * s.B_disc[2 * k + 1])
    retainers = [
        Retainer(
            int(row),
            x[f"{given.name}.clearance"],
            x[f"{given.name}.journal_radius"],
            site.get("mu", MU),
            site.get("housing_mass", 0.0),
            (site.get("mount_stiffness_x", 0.0), site.get("mount_stiffness_y", 0.0)),
            (site.get("mount_damping_x", 0.0), site.get("mount_damping_y", 0.0)),
            site.get("race_inertia", 0.0),
            site.get("race_drag", 0.0),
        )
        for row, given in zip(s.sites, rotor.sites, strict=True)
    ]
    seals = [
        (s.seals.rows[2 * k : 2 * k + 2], lambda Omega, seal=seal: tuple(map(np.asarray, seal.at(Omega)))[:2])
        for k, seal in enumerate(rotor.seals)
    ]
    M, C, R = np.split(s.forms, 3)
    return FlexibleTouchdown(
        M,
        C,
        R,
        M @ s.over_speed[:n],
        s.K,
        unbalance,
        downward @ s.B_base,
        tuple(retainers),
        x["spin.inertia"] if case.Omega_dot is None else None,
        case.Omega_dot or 0.0,
        seals=seals,
    )


@pytest.mark.parametrize(
    "name", [name if name in QUICK else pytest.param(name, marks=pytest.mark.slow) for name in CASES]
)
def test_a_machine_falls_onto_its_retainers_as_integrated_independently(name):
    case = CASES[name]
    x, rotor = fallen_plant(case)
    model = reference_of(case, x, rotor)
    steps = round(case.end / case.h)
    sites, moving = [site.name for site in rotor.sites], model.size - (case.Omega_dot is not None)
    q, v = np.zeros((2, steps, model.size))
    impulse = np.zeros((steps, len(sites)))
    for k in range(steps):
        if case.Omega_dot is not None:
            x["Omega"] = case.Omega + case.Omega_dot * k * case.h
        x.step(k * case.h, case.h)
        q[k, :moving], v[k, :moving] = np.split(state(x)[: 2 * moving], 2)
        impulse[k] = [x[f"{site}.f_n_mean"] * case.h for site in sites]
    impulse = np.cumsum(impulse, axis=0)

    at_rest, spinning = np.zeros((2, model.size))
    spinning[-1] = case.Omega
    expected = fall(model, case.h * np.arange(1, steps + 1), at_rest, spinning)
    assert len(expected.impacts) >= case.impacts
    assert expected.modes == ({SLIDING, ROLLING} if case.rolls else {SLIDING})
    for k, site in enumerate(model.sites):
        apart = np.hypot(*(q - expected.q)[:, site.row : site.row + 2].T)
        assert apart.max() < case.orbit * site.clearance, sites[k]
    np.testing.assert_allclose(impulse[-1], expected.impulse[-1], rtol=1e-4, atol=1e-9)
    heat = x["energy.friction"] + x["energy.impact"]
    assert heat == pytest.approx(expected.heat[-1], rel=1e-4)
    assert abs(x["energy.balance"]) < 5e-6 * heat
    if case.Omega_dot is None:
        np.testing.assert_allclose(v[:, -1], expected.v[:, -1], rtol=1e-3 * case.orbit)
    for at in model.races.values():
        np.testing.assert_allclose(
            v[:, at], expected.v[:, at], atol=10.0 * case.orbit * np.abs(expected.v[:, at]).max()
        )


def test_the_independent_fall_conserves_energy_without_friction():
    """Strain, motion, weight and the losses of impacts add up to nothing."""
    case = Case("compressor", 1000.0, 1e-4, 0.012, 4, site={"mu": 0.0})
    x, rotor = fallen_plant(case)
    model = reference_of(case, x, rotor)
    at_rest, spinning = np.zeros((2, model.size))
    spinning[-1] = case.Omega
    model = replace(model, C=0.0 * model.C, R=0.0 * model.R)
    found = fall(model, np.linspace(1e-3, case.end, 12), at_rest, spinning)
    total = [
        model.energy(q, v) - model.force @ q[: model.n] + heat
        for q, v, heat in zip(found.q, found.v, found.heat, strict=True)
    ]
    assert len(found.impacts) >= case.impacts
    assert found.heat[-1] > 0.1
    assert max(abs(b - a) for a, b in pairwise(total)) < 1e-7 * found.heat[-1]
