"""Seals in the plant: their motion is that of the analyses at every speed, in every way to step; energies balance."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from rotor_cases import STEEL, both, plant, plant_rotor, run, size_of, state
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline
from scipy.linalg import expm

from amb_analysis.linear.rotor_and_magnets import rotor_component
from amb_cosim.model_constants.plant_data import plant_structure
from rotor_analysis.parts import AtSpeed, Bearing, Disc
from rotor_analysis.shaft import Shaft
from rotor_analysis.supported_rotor import supported_plant
from rotor_contact.shaft.seals import seal_at
from rotor_contact.shaft.structure import structure_of
from tests.support.messages import raises_naming

HELD = both("mb.k_b", 2e6) | both("mb.c_b", 600.0) | both("rb.enabled", 0.0)
H = 2e-4
ENERGIES = ("energy.kinetic", "energy.work", "energy.damping", "energy.balance")


def turned(direct, cross):
    return ((direct, cross), (-cross, direct))


OVER_SPEED = tuple(
    AtSpeed(speed, turned(k, Q), turned(c, 0.1 * c), turned(2.0, 0.0))
    for speed, k, Q, c in (
        (50.0, 4e5, 1e5, 900.0),
        (150.0, 6e5, 4e5, 700.0),
        (250.0, 7e5, 9e5, 600.0),
        (400.0, 5e5, 2e6, 300.0),
    )
)
UNLIKE = Bearing("ring", 2, ((3e5, 5e4), (2e4, -1e5)), ((400.0, 30.0), (10.0, 200.0)))


def sealed_rotor(*seals):
    """Node 3 is no master: a seal there acts through the shape of the shaft between masters."""
    shaft = Shaft(diameter=(0.05,), nodes=(0.0, 0.25, 0.5, 0.75, 1.0), **STEEL)
    bodies = tuple(Disc(f"b{node}", node, 8.0, 0.12, 0.03) for node in (2, 4))
    rotor = plant_rotor("sealed", shaft, bodies, (1, 2, 4, 5), (1, 5), (2, 4, 2, 4), (2, 4, 2, 4))
    return replace(rotor, seals=seals)


ROTOR = sealed_rotor(Bearing("piston", 3, at_speed=OVER_SPEED), UNLIKE)


def matrices(rotor, Omega):
    """The rotor on its bearings and seals by the analyses, as x' = A x."""
    held = replace(
        rotor,
        bearings=tuple(replace(b, stiffness=turned(2e6, 0.0), damping=turned(600.0, 0.0)) for b in rotor.bearings),
    )
    model = supported_plant(held).model.at(Omega)
    zero, eye = np.zeros_like(model.M), np.eye(model.size)
    return np.block(
        [[zero, eye], [-np.linalg.solve(model.M, model.K), -np.linalg.solve(model.M, model.C + Omega * model.G)]]
    )


def started(values, rotor=ROTOR):
    x = plant(HELD | {"solver.max_substep": 1e-5} | values, rotor)
    rng, n = np.random.default_rng(7), size_of(x)
    state(x)[:n] = 1e-4 * rng.standard_normal(n)
    x["solver.energy_limit"] = 1e9  # the balance does not know of the first state
    return x, state(x)[: 2 * n].copy()


def gain(x, steps, h=H, dOmega=0.0, Omega=0.0):
    """Step, and return the change of all energies from after the first step, and the largest so far."""
    seen = []
    for k in range(steps):
        if dOmega:
            x["Omega"], x["Omega_dot"] = Omega + dOmega * k * h, dOmega
        x.step(k * h, h)
        seen.append([x[name] for name in ENERGIES])
    seen = np.array(seen)
    return np.ptp(seen[:, 3]), np.max(np.abs(seen[:, :3]))


@pytest.mark.parametrize("Omega", [20.0, 200.0, 333.0, 500.0])
def test_coefficients_match_the_rotor_file_at_every_speed(Omega):
    seals = plant_structure(ROTOR)[0].seals
    for k, seal in enumerate(ROTOR.seals):
        K, C, _ = seal.at(Omega)
        np.testing.assert_allclose(np.array(seal_at(seals, k, Omega)), [*K.ravel(), *C.ravel()], rtol=1e-9, atol=1e-6)


def test_interpolated_damping_between_positive_values_is_positive():
    """A cubic spline through these is -1937 N s/m between two speeds with 500."""
    damping = (2e4, 2e4, 2e4, 500.0, 500.0, 500.0)
    rows = zip((100.0, 200.0, 300.0, 400.0, 500.0, 600.0), damping, strict=True)
    table = tuple(AtSpeed(speed, turned(1e7, 0.0), turned(c, 0.0)) for speed, c in rows)
    seals = plant_structure(sealed_rotor(Bearing("gas", 3, at_speed=table)))[0].seals
    for Omega in (400.0, 425.0, 450.0, 475.0, 500.0):
        assert seal_at(seals, 0, Omega).c_xx == pytest.approx(500.0, rel=1e-9)


@pytest.mark.parametrize(("exact", "tolerance"), [(0.0, 3e-6), (1.0, 1e-10)], ids=["runge_kutta", "exact"])
def test_free_motion_at_a_speed_agrees_with_the_analyses(exact, tolerance):
    """The exact motion begins after 32 equal steps."""
    Omega, steps = 210.0, 20
    x, _ = started({"Omega": Omega, "solver.exact_motion": exact})
    run(x, 40, h=H)
    A = matrices(ROTOR, Omega)
    first = state(x)[: len(A)].copy()
    off, largest = gain(x, steps)
    result, expected = state(x)[: len(A)], expm(A * steps * H) @ first
    for half in np.split(np.arange(len(A)), 2):
        assert np.max(np.abs(result[half] - expected[half])) < tolerance * np.max(np.abs(first[half]))
    assert off < 1e-8 * largest


@pytest.mark.parametrize(
    ("exact", "Omega", "tolerance"),
    [(0.0, 120.0, 1e-5), (1.0, 120.0, 2e-6), (1.0, 390.0, 2e-4)],
    ids=["runge_kutta", "pieces", "pieces_beyond_the_table"],
)
def test_motion_in_a_run_up_agrees_with_the_analyses(exact, Omega, tolerance):
    """Pieces with coefficients on the line between two speeds of their grid would err by 6e-5, and by 8e-3 beyond."""
    faster, steps = 400.0, 150
    x, result = started({"Omega": Omega, "solver.exact_motion": exact})
    off, largest = gain(x, steps, dOmega=faster, Omega=Omega)
    last = Omega + faster * steps * H
    ends = [Omega, *(table.speed for table in OVER_SPEED if Omega < table.speed < last), last]
    for begin, end in pairwise(ends):
        over = np.linspace(begin + 1e-9, end - 1e-9, 9)
        A = CubicSpline(over, [matrices(ROTOR, speed) for speed in over])
        time = (end - begin) / faster
        result = solve_ivp(
            lambda t, z, A=A, begin=begin: A(begin + faster * t) @ z,
            (0.0, time),
            result,
            "DOP853",
            rtol=1e-11,
            atol=1e-17,
        ).y[:, -1]
    scale = np.repeat([500.0, 1.0], len(result) // 2)  # 1/s, about the rotor's frequencies: displacements as velocities
    error = scale * (state(x)[: len(result)] - result)
    assert np.linalg.norm(error) < tolerance * np.linalg.norm(scale * result)
    assert off < 2e-3 * largest


SPINS = {"run-up": {"Omega": 120.0}, "free spin": {"Omega": 300.0, "spin.free": 1.0, "spin.inertia": 0.3, "d1.u": 2e-3}}


@pytest.mark.parametrize("spin", SPINS)
def test_energies_of_seals_in_contact_are_those_of_short_substeps(spin):
    """Of friction and impacts, too; pieces know the power of seals at their ends, with its slope."""
    rubs = both("rb.enabled", 1.0) | both("rb.clearance", 1.5e-4) | both("rb.mu", 0.1) | both("mb.f_x", 800.0)
    names = [f"energy.{name}" for name in ("damping", "work", "friction", "impact")] + ["mb1.x", "mb2.y", "rb1.f_n"]
    found = {}
    for exact in (0.0, 1.0):
        x, _ = started(rubs | SPINS[spin] | {"solver.exact_motion": exact, "solver.tolerance": 1e-9})
        rows = []
        for k in range(150):
            if spin == "run-up":
                x["Omega"], x["Omega_dot"] = 120.0 + 400.0 * k * H, 400.0
            x.step(k * H, H)
            rows.append([x[name] for name in names])
        found[exact] = np.array(rows)
    assert np.count_nonzero(found[0.0][:, 6]) > 20
    largest = np.max(np.abs(found[0.0]), axis=0)
    assert np.all(np.abs(found[1.0] - found[0.0]) < 1e-4 * largest)


def test_cross_coupling_works_on_forward_whirl_and_resists_backward():
    rotor = sealed_rotor(Bearing("piston", 3, turned(0.0, 5e5)))
    work = {}
    for sense in (1.0, -1.0):
        x = plant(HELD | {"Omega": 0.0, "solver.energy_limit": 1e9}, rotor)
        n = size_of(x)
        z = state(x)
        z[:n:2], z[n + 1 : 2 * n : 2] = 1e-4, sense * 1e-4 * 300.0
        for k in range(20):
            x.step(k * H, H)
        work[sense] = x["energy.work"]
    assert work[1.0] > 0.0 > work[-1.0]


@pytest.mark.parametrize("exact", [0.0, 1.0], ids=["runge_kutta", "pieces"])
@pytest.mark.parametrize("faster", [0.0, 300.0])
def test_energy_balances_in_contact(exact, faster):
    """The rotor falls onto its retainers, bounces and slides; the cross coupling drives it."""
    values = (
        {"Omega": 180.0, "gravity": 9.81, "solver.exact_motion": exact} | both("rb.mu", 0.1) | both("rb.enabled", 1.0)
    )
    x = plant(HELD | both("mb.k_b", 0.0) | both("rb.clearance", 2e-5) | values, ROTOR)
    off, largest = gain(x, 400, dOmega=faster, Omega=180.0)
    assert x["energy.friction"] > 0.0
    assert off < 1e-3 * largest


@pytest.mark.parametrize("Omega", [20.0, 210.0])
def test_linear_model_has_the_seals_of_its_speed(Omega):
    x = plant(HELD, ROTOR)
    layout = {"bearings": ["mb1", "mb2"], "discs": ["d1", "d2", "d3", "d4"], "sensors": [], "sites": []}
    values = {name: x[name] for name in ("mb1.k_b", "mb2.k_b", "mb1.c_b", "mb2.c_b")}
    A = rotor_component("rotor", layout, x.constants, values, Omega).law.A
    np.testing.assert_allclose(A, matrices(ROTOR, Omega), rtol=1e-7, atol=1e-3)


def test_speed_beyond_a_table_warns():
    x = plant(HELD | {"Omega": 410.0}, ROTOR)
    x.step(0.0, H)
    assert x["piston.beyond_table"] == 1.0
    assert x["ring.beyond_table"] == 0.0
    inside = plant(HELD | {"Omega": 100.0}, ROTOR)
    inside.step(0.0, H)
    assert inside["piston.beyond_table"] == 0.0


def test_mass_is_in_the_plant_and_must_be_constant_and_symmetric():
    bare, sealed = (structure_of(plant(HELD, rotor).constants).forms[:8].sum() for rotor in (sealed_rotor(), ROTOR))
    assert sealed - bare == pytest.approx(4.0, rel=1e-6)  # 2 kg along x, 2 kg along y
    varied = (replace(OVER_SPEED[0], mass=turned(1.0, 0.0)), *OVER_SPEED[1:])
    for seal, facts in (
        (Bearing("piston", 3, at_speed=varied), ("mass", "seal piston", "speed-dependent")),
        (Bearing("piston", 3, mass=((1.0, 0.5), (0.0, 1.0))), ("mass", "seal piston", "symmetric")),
        (Bearing("piston", 3, mass=turned(-200.0, 0.0)), ("positive",)),
    ):
        with raises_naming(ValueError, *facts):
            plant(HELD, sealed_rotor(seal))
