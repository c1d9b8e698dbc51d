"""Generalised notch and synchronous force rejection on a levitated rotor."""

import math

import numpy as np
import pytest
from controller_bench import Plant
from rig import AXES, LOOP, identified_receptance, pack
from sampled_loop import zoh_response

from amb_cosim.model_constants.controller_data import pack_rows
from rolac_controller.enumerations import FORCE_FREE, NOTCH
from rolac_controller.notch import solve_in_place

H, K_S = 250e-6, 2e6
OMEGA = 2.0 * math.pi * 25.0
GAINS = {f"{b}__k_s_{a}": K_S for b, a in AXES}


@pytest.fixture
def rotor():
    """Four independent axes of 40 to 55 kg; sensors at the bearings, and beyond them by their mean."""
    mass = np.array([40.0, 45.0, 50.0, 55.0])
    a = np.zeros((8, 8))
    a[:4, 4:] = np.eye(4)
    a[4:, :4] = np.diag(K_S / mass)
    b = np.vstack([np.zeros((4, 4)), np.diag(1.0 / mass)])
    c = np.zeros((8, 8))
    for k, sensor in enumerate((4, 5, 2, 3)):
        c[sensor, k] = 1.0
        c[(6, 7, 0, 1)[k], [k, (k + 2) % 4]] = 0.7, 0.4
    return a, b, c


def settled(b, rotor, seconds, K0, K1):
    """Phasors of the whole force and displacements that a controller settles to on the rotor under synchronous forces.

    Beside its own force, that of an inner loop acts: -(K0 q + K1 (q - q_before)).
    """
    plant, before = Plant.sampled(*rotor, H), np.zeros(8)
    unbalance, forces = 300.0 * np.exp(1j * np.arange(4.0)), []
    for n in range(round(seconds / H)):
        q = plant.c @ plant.x
        b["rolac_enable"] = float(n > 1000)
        b.sense(q)
        turning = (unbalance * np.exp(1j * b.theta)).real
        b.sample()
        whole = b.axis_forces() - K0 @ q - K1 @ (q - before)
        plant.x, before = plant.a @ plant.x + plant.b @ (whole + turning), q
        forces.append(whole)
    turn = np.exp(-1j * OMEGA * H * np.arange(len(forces)))[-1600:]
    return 2.0 * np.mean(np.array(forces)[-1600:] * turn[:, None], axis=0), b.components()[[4, 5, 2, 3]]


def run(bench, rotor, mode, seconds=2.0):
    """Return a controller in that mode on the rotor, after settling, and its steady values."""
    values = {name.replace("__", "."): value for name, value in GAINS.items()}
    receptance = identified_receptance(zoh_response(*rotor, OMEGA, H), OMEGA, values)
    b = bench(pack([OMEGA], [receptance]), Omega=OMEGA, rolac__mode=mode, **GAINS)
    return b, *settled(b, rotor, seconds, np.zeros((4, 8)), np.zeros((4, 8)))


def test_notch_removes_the_synchronous_currents(bench, rotor):
    b, force, _ = run(bench, rotor, NOTCH)
    _, pid, _ = run(bench, rotor, NOTCH, 0.25)
    assert b["rolac_active"] == 1.0
    assert np.abs(pid).min() > 50.0
    assert np.abs(force).max() < 1e-4 * np.abs(pid).max()


def test_force_rejection_removes_the_synchronous_force_of_the_bearing(bench, rotor):
    """K_i I + K_s x vanishes, the rotor turns about its axis of inertia: m Omega^2 q = -F_unbalance."""
    _, force, position = run(bench, rotor, FORCE_FREE, 3.0)
    whole = force + K_S * position
    assert np.abs(force).min() > 100.0
    assert np.abs(whole).max() < 2e-2 * np.abs(force).max()  # the hold of half a sample is not in K_s x


def test_rate_is_alpha(bench, rotor):
    """The synchronous current of the PID decays as exp(-alpha t), apart from the mean over the last revolution."""
    _, early, _ = run(bench, rotor, NOTCH, 0.55)
    _, late, _ = run(bench, rotor, NOTCH, 0.75)
    rate = -np.log(np.abs(late) / np.abs(early)) / 0.2
    np.testing.assert_allclose(rate, 7.0, rtol=0.35)


@pytest.mark.parametrize("seed", range(5))
def test_equations_are_solved_as_numpy_solves_them(seed):
    rng = np.random.default_rng(seed)
    A, b = rng.normal(size=(4, 4)) + 1j * rng.normal(size=(4, 4)), rng.normal(size=4) + 1j * rng.normal(size=4)
    A[0, 0] = 0.0  # needs a pivot
    solution = b.copy()
    assert solve_in_place(A.copy(), solution)
    np.testing.assert_allclose(solution, np.linalg.solve(A, b), rtol=1e-9)


def test_equations_without_a_solution_change_nothing(bench):
    A = np.zeros((4, 4), dtype=complex)
    A[:, 0] = 1.0
    assert not solve_in_place(A, np.ones(4, dtype=complex))


def beneath_an_inner_loop(bench, rotor, mode, known=True, seconds=2.5):
    """Without a PID, on top of another controller, u = -(K0 q + K1 (q - q_before)): its whole force vanishes."""
    K0, K1 = np.zeros((4, 8)), np.zeros((4, 8))
    for k, (local, far) in enumerate(zip((4, 5, 2, 3), (6, 7, 0, 1), strict=True)):
        K0[k, local], K0[k, far], K1[k, local] = 2.7e6, 3e5, 5e3 / H
    C = K0 + K1 * (1.0 - np.exp(-1j * OMEGA * H))
    P = zoh_response(*rotor, OMEGA, H)
    receptance = P @ np.linalg.inv(np.eye(4) + C @ P)
    constants = pack_rows(LOOP, [(1, OMEGA, receptance)], [(1, 0.5 * OMEGA, 0.5 * C), (1, 1.5 * OMEGA, 1.5 * C)])
    gains = {f"{name}__{gain}_{a}": 0.0 for name, a in AXES for gain in ("k_p", "k_d")}
    values = {"Omega": OMEGA, "rolac__mode": mode, "pid__direct": 1.0, **GAINS, **gains}
    b = bench(constants if known else pack([OMEGA], [receptance]), pid=False, **values)
    return settled(b, rotor, seconds, K0, K1)


def test_notch_removes_the_synchronous_force_of_an_inner_loop_too(bench, rotor):
    force, _ = beneath_an_inner_loop(bench, rotor, NOTCH)
    without, _ = beneath_an_inner_loop(bench, rotor, NOTCH, known=False)
    assert np.abs(without).min() > 50.0
    assert np.abs(force).max() < 1e-4 * np.abs(without).max()


def test_force_rejection_on_top_of_an_inner_loop_frees_the_rotor(bench, rotor):
    force, position = beneath_an_inner_loop(bench, rotor, FORCE_FREE, seconds=3.0)
    assert np.abs(force).min() > 100.0
    assert np.abs(force + K_S * position).max() < 2e-2 * np.abs(force).max()
