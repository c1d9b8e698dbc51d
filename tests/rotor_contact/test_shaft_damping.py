"""Damping of the shaft: decay in closed form, the exact solution, energies, and the rotating share."""

import math
from dataclasses import replace

import numpy as np
import pytest
from rotor_cases import BEARINGS, UNWATCHED, both, plant, plant_rotor, run, size_of, state

from rotor_analysis.damping import Damping
from rotor_analysis.parts import Body
from rotor_analysis.rotor_file import load_rotor
from rotor_analysis.shaft import Shaft

RIG = load_rotor()
FREE = both("rb.enabled", 0.0)
ENERGIES = ("energy.kinetic", "energy.strain", "energy.damping", "energy.work", "energy.balance")


def jeffcott(damping):
    """A disc of 10 kg in the middle of a massless shaft of 1 m, and 1 kg at the bearings."""
    shaft = Shaft(diameter=(0.02,), youngs_modulus=2.07e11, density=1e-3, poissons_ratio=0.3, nodes=(0.0, 0.5, 1.0))
    bodies = tuple(Body(f"body{node}", node, mass, 0.0, 0.0) for node, mass in ((1, 1.0), (2, 10.0), (3, 1.0)))
    rotor = plant_rotor("jeffcott", shaft, bodies, (1, 2, 3), (1, 3))
    return replace(rotor, damping=damping)


def stiff_shaft():
    """Stiffness of that shaft against the disc (N/m), both ends held."""
    return 48.0 * 2.07e11 * math.pi / 64.0 * 0.02**4 / 1.0**3


def growth(beta, Omega, external, h=5e-5, steps=6000):
    """Rate (1/s) at which a small forward whirl of a Jeffcott rotor grows, with damping `external` (N s/m) of the disc.

    The ends are held by very stiff passive bearings. The damping of the disc acts from outside, on the velocity: the
    plant's energy balance does not know of it.
    """
    x = plant(FREE | both("mb.k_b", 1e8) | {"Omega": Omega} | UNWATCHED, jeffcott(beta))
    n, z = size_of(x), state(x)
    omega = math.sqrt(stiff_shaft() / 10.0)
    middle = 2
    z[middle], z[n + middle + 1] = 1e-4, 1e-4 * omega
    sizes = []
    for k in range(steps):
        v = z[n + middle : n + middle + 2]
        z[n + middle : n + middle + 2] -= h * external / 10.0 * v
        x.step(k * h, h)
        sizes.append(math.hypot(z[middle], z[middle + 1]))
    first, last = np.mean(sizes[: steps // 10]), np.mean(sizes[-steps // 10 :])
    return math.log(last / first) / (0.9 * steps * h)


@pytest.mark.parametrize(("ratio", "grows"), [(0.6, False), (0.95, False), (1.05, True), (1.4, True)])
def test_jeffcott_rotor_is_unstable_beyond_its_damping_threshold(ratio, grows):
    """Omega_th = omega (1 + c_e/c_i); the forward mode grows as (c_i (Omega/omega - 1) - c_e) / (2 m)."""
    omega = math.sqrt(stiff_shaft() / 10.0)
    beta, c_e = 2e-4, 10.0
    c_i = beta * stiff_shaft()
    threshold = omega * (1.0 + c_e / c_i)
    rate = growth(Damping(stiffness=beta), ratio * threshold, c_e)
    expected = (c_i * (ratio * threshold / omega - 1.0) - c_e) / 20.0
    assert (rate > 0.0) == grows
    assert rate == pytest.approx(expected, abs=0.01 * c_e / 20.0)


def test_damping_in_the_fixed_frame_slows_whirl_at_every_speed():
    omega = math.sqrt(stiff_shaft() / 10.0)
    beta = 2e-4
    rates = [growth(Damping(stiffness=beta, rotating=0.0), ratio * omega, 0.0) for ratio in (0.0, 3.0)]
    np.testing.assert_allclose(rates, -0.5 * beta * omega**2, rtol=0.02)


@pytest.mark.parametrize("rotating", [0.0, 0.4, 1.0])
def test_free_flight_of_a_damped_shaft_equals_its_integration(rotating):
    rotor = replace(RIG, damping=Damping(modal=(0.01,), stiffness=1e-5, rotating=rotating))
    values = BEARINGS | {"Omega": 260.0, "d1.u": 1e-3, "d3.f_x": 30.0, "mb1.k_xx": 2e5, "solver.max_substep": 5e-6}
    exact = plant(values, rotor)
    integrated = plant(values | {"solver.exact_motion": 0.0}, rotor)
    names = ("mb1.x", "mb1.y", "mb2.x", "mb2.y", *ENERGIES)
    a, b = run(exact, 600, names), run(integrated, 600, names)
    np.testing.assert_allclose(a[:, :4], b[:, :4], atol=1e-12)
    scale = b[:, 4:8].max()
    np.testing.assert_allclose(a[:, 4:], b[:, 4:], atol=2e-7 * scale)
    assert np.abs(a[:, -1]).max() < 1e-7 * scale


@pytest.mark.parametrize("free", [0.0, 1.0])
@pytest.mark.parametrize("rotating", [0.0, 1.0])
def test_energy_of_a_damped_shaft_is_balanced_through_contact(rotating, free):
    rotor = replace(RIG, damping=Damping(stiffness=1e-5, rotating=rotating))
    values = BEARINGS | both("rb.mu", 0.1) | {"Omega": 200.0, "d1.u": 40e-3, "spin.free": free}
    x = plant(values | {"solver.tolerance": 5e-8, "solver.max_substep": 2e-5}, rotor)
    record = run(x, 1500, ("rb1.f_n", *ENERGIES))
    assert record[:, 0].max() > 100.0
    assert np.abs(record[:, -1]).max() < 1e-6 * record[:, 1:5].max()


@pytest.mark.parametrize("gain", [0.0, 1e-6, 300.0])
def test_heat_of_a_fast_mode_is_that_of_the_integration_in_whole_steps_and_in_pieces(gain):
    """A mode that vibrates within a step: the mean of both ends would miss its torque."""
    rotor = replace(RIG, damping=Damping(modal=(0.01,), stiffness=1e-5))
    values = BEARINGS | {"Omega": 260.0, "d1.u": 1e-3, "d3.f_x": 30.0, "solver.max_substep": 2e-6}

    def heat(settings):
        x = plant(values | {"Omega_dot": gain} | settings, rotor)
        for k in range(600):
            x["Omega"] = 260.0 + gain * 250e-6 * k
            x.step(k * 250e-6, 250e-6)
        return x["energy.damping"]

    assert heat({}) == pytest.approx(heat({"solver.exact_motion": 0.0}), rel=5e-5)
