"""Hysteretic damping of the shaft: equal loss at any frequency, and a force on slow whirl that drives it forward."""

from dataclasses import replace

import numpy as np
import pytest
from analysis_cases import MASS, NOTHING, STEEL, D, E, L, disc_between, spring, tensor

from rotor_analysis.analysis_model import analysis_model
from rotor_analysis.assembly import assemble
from rotor_analysis.campbell import campbell
from rotor_analysis.damping import Damping
from rotor_analysis.harmonic import harmonic_model
from rotor_analysis.modes import modes, overdamped_modes
from rotor_analysis.pairs import turned
from rotor_analysis.parts import Bearing, Disc
from rotor_analysis.reduced_rotor import reduced_rotor
from rotor_analysis.response import dynamic_stiffness, unbalance_response
from rotor_analysis.rotor import ReductionOptions, Rotor
from rotor_analysis.shaft import Shaft
from rotor_analysis.spectrum import eigenvalues
from rotor_analysis.supported_rotor import supported_rotor

ETA, STIFF = 0.02, 1e14
SHAFT = 48.0 * E * np.pi * D**4 / 64.0 / L**3  # stiffness (N/m) of the shaft at its middle
OMEGA = np.sqrt(SHAFT / MASS)
NODES = tuple(np.linspace(0.0, 1.2, 9).tolist())
FREE = Rotor("free", Shaft(NODES, 0.05, **STEEL), (Disc("end", 1, 5.0, 0.1, 0.02), Disc("inner", 4, 8.0, 0.1, 0.02)))


def jeffcott(c=0.0, k_bearing=STIFF, at_disc=NOTHING, **damping):
    """A disc on a weightless shaft, with a damper (N s/m) and springs (N/m) at the disc that do not turn."""
    held = [Bearing(name, node, tensor(k_bearing)) for name, node in (("left", 1), ("right", 3))]
    rotor = disc_between(*held, Bearing("damper", 2, at_disc, tensor(c)))
    return supported_rotor(replace(rotor, damping=Damping(**({"loss_factor": ETA} | damping))), planes=(2,))


def ratios(model, Omega):
    """Return the damping ratios of the lowest modes by their whirl."""
    return {mode.whirl: mode.damping_ratio for mode in modes(model, Omega, 2)}


def ratio(c, loss):
    """Return -Re lambda / |lambda| of MASS lambda^2 + c lambda + k (1 + i loss) = 0, the root with Im lambda > 0."""
    (root,) = (r for r in np.roots([MASS, c, SHAFT * (1.0 + 1j * loss)]) if r.imag > 0.0)
    return -root.real / abs(root)


@pytest.mark.parametrize("c", [0.0, 10.0, 300.0])
@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_loss_damps_fast_whirl_and_drives_slow_forward_whirl(c, sense):
    """m r'' + c r' + k (1 + i eta sgn(omega - Omega)) r = 0 of a Jeffcott rotor, forward: omega > 0."""
    model = jeffcott(c).model
    names = ("forward", "backward") if sense > 0.0 else ("backward", "forward")
    for Omega in (0.5 * OMEGA, 0.99 * OMEGA):
        expected = dict.fromkeys(names, pytest.approx(ratio(c, ETA), rel=1e-6))
        assert ratios(model, sense * Omega) == expected
    for Omega in (1.01 * OMEGA, 3.0 * OMEGA, 30.0 * OMEGA):
        slow = [pytest.approx(ratio(c, loss), rel=1e-6) for loss in (-ETA, ETA)]
        assert ratios(model, sense * Omega) == dict(zip(names, slow, strict=True))


@pytest.mark.filterwarnings("error")
def test_weightless_nodes_of_a_full_model_do_not_disturb_its_lowest_modes():
    """Their eigenvalues are infinite."""
    full = jeffcott(k_bearing=1e9).full
    assert ratios(full, 0.5 * OMEGA) == dict.fromkeys(("forward", "backward"), pytest.approx(0.5 * ETA, rel=1e-3))
    assert ratios(full, 2.0 * OMEGA)["forward"] == pytest.approx(-0.5 * ETA, rel=1e-3)


@pytest.mark.parametrize("k_bearing", [STIFF, SHAFT, 0.1 * SHAFT])
def test_ratio_is_half_the_loss_factor_times_the_share_of_strain_energy(k_bearing):
    """Springs in series: the shaft has k / k_shaft of the energy, all of it on stiff bearings."""
    share = spring(k_bearing) / SHAFT
    for mode in modes(jeffcott(k_bearing=k_bearing).model, 0.0):
        assert mode.damping_ratio == pytest.approx(0.5 * ETA * share, rel=ETA**2 + 1e-3)


def test_bending_modes_of_free_rotor_have_half_the_loss_factor():
    """Root of lambda^2 = -omega^2 (1 + i eta): zeta = eta/2 (1 + O(eta^2)); driven where they whirl below the spin."""
    rotor = replace(FREE, bodies=(), damping=Damping(loss_factor=ETA))
    model = supported_rotor(rotor).model
    bending = [mode for mode in modes(model, 0.0) if mode.frequency > 100.0][:6]
    assert [mode.damping_ratio for mode in bending] == pytest.approx([0.5 * ETA] * 6, rel=1e-3)
    middle = 0.5 * (bending[1].frequency + bending[2].frequency)
    turning = [mode for mode in modes(model, middle) if mode.frequency > 100.0][:4]
    assert [mode.damping_ratio < 0.0 for mode in turning] == [
        m.whirl == "forward" and m.frequency < middle for m in turning
    ]
    assert [abs(mode.damping_ratio) for mode in turning] == pytest.approx([0.5 * ETA] * 4, rel=0.01)


def test_rigid_motion_dissipates_nothing():
    model = assemble(replace(FREE, damping=Damping(loss_factor=ETA)))
    motion = np.zeros((model.size, 2))
    motion[::4, 0], motion[::4, 1], motion[2::4, 1] = 1.0, NODES, 1.0
    for omega in (0.0, 50.0, 500.0):
        force = dynamic_stiffness(model, 100.0, omega) - dynamic_stiffness(assemble(FREE), 100.0, omega)
        assert np.max(np.abs(force @ motion)) < 1e-9 * np.max(np.abs(force))


@pytest.mark.parametrize(("rotating", "slow"), [(0.0, 1.0), (0.25, 0.5), (0.5, 0.0), (1.0, -1.0)])
def test_share_that_does_not_rotate_damps_whirl_of_any_speed(rotating, slow):
    """zeta = eta/2 (1 - rotating) + eta/2 rotating sgn(omega - Omega)."""
    model = jeffcott(rotating=rotating).model
    assert ratios(model, 2.0 * OMEGA)["forward"] == pytest.approx(0.5 * ETA * slow, rel=1e-3, abs=1e-9)
    assert ratios(model, 0.5 * OMEGA)["forward"] == pytest.approx(0.5 * ETA, rel=1e-3)


@pytest.mark.parametrize("omega", [30.0, 90.0, 400.0])
def test_line_and_circle_lose_the_loss_factor_of_their_strain_energy(omega):
    """Work per cycle pi Im(Q* D Q) is 2 pi eta U: zero for a line slower than the spin, -2 pi eta U for a circle."""
    Omega, damped = 100.0, assemble(replace(FREE, damping=Damping(loss_factor=ETA)))
    D = dynamic_stiffness(damped, Omega, omega) - dynamic_stiffness(assemble(FREE), Omega, omega)
    bend = np.arange(1.0, damped.size // 2 + 1) ** 2
    line, forward, backward = (np.kron(bend, pair) for pair in ([1.0, 0.0], [1.0, -1j], [1.0, 1j]))
    slow = omega < Omega
    for Q, loss in ((line, 0.0 if slow else ETA), (forward, -ETA if slow else ETA), (backward, ETA)):
        twice_energy = (Q.conj() @ damped.K @ Q).real
        assert (Q.conj() @ D @ Q).imag == pytest.approx(loss * twice_energy, rel=1e-9, abs=1e-9 * twice_energy)


def test_turning_shaft_sags_sideways_by_the_loss_factor():
    """Under a steady load along x a shaft that turns from x to y also deflects along +y, by eta times as much."""
    deflection = np.linalg.solve(dynamic_stiffness(jeffcott().model, 50.0, 0.0), [1.0, 0.0])
    assert deflection[1] / deflection[0] == pytest.approx(ETA, rel=1e-3)
    assert deflection[0] == pytest.approx(1.0 / SHAFT, rel=1e-3)
    at_rest = np.linalg.solve(dynamic_stiffness(jeffcott().model, 0.0, 0.0), [1.0, 0.0])
    assert at_rest[1] == 0.0


def test_loss_does_not_limit_the_synchronous_whirl_of_an_isotropic_rotor():
    """At the critical speed only the fixed damper does: amplitude Omega u / c."""
    c, u = 40.0, 1e-3
    at_disc = np.abs(unbalance_response(jeffcott(c), {2: u}, np.array([OMEGA]), (2,)))[0, 0, 0]
    assert at_disc == pytest.approx(OMEGA * u / c, rel=1e-3)


@pytest.mark.parametrize("split", [0.99, 1.01])
def test_anisotropic_stiffness_stabilises_a_rotor_driven_by_hysteresis(split):
    """[[k_x, -q], [q, k_y]] without damping has real eigenvalues if |k_x - k_y| > 2 q, q = eta k of the shaft."""
    apart = 2.0 * split * ETA * SHAFT
    model = jeffcott(at_disc=((0.5 * SHAFT + apart, 0.0), (0.0, 0.5 * SHAFT))).model
    growth = np.max(eigenvalues(model, 10.0 * OMEGA).real)
    assert (growth > 0.01) == (split < 1.0)
    assert np.max(eigenvalues(model, 0.1 * OMEGA).real) < 0.0


@pytest.mark.parametrize("split", [0.0, 3.0 * ETA])
def test_every_mode_is_present_at_every_speed_near_critical(split):
    model = jeffcott(200.0, at_disc=((split * SHAFT, 0.0), (0.0, 0.0))).model
    (low, high) = (mode.frequency for mode in modes(model, 0.0, 2))
    for Omega in np.concatenate([np.linspace(0.999, 1.001, 81) * frequency for frequency in (low, high)]):
        assert len(modes(model, Omega)) == 2


def test_campbell_diagram_follows_modes_over_the_change_of_sign():
    """The critical speed has the damping of the fixed damper alone, since loss does not resist synchronous whirl."""
    c = 20.0
    diagram = campbell(jeffcott(c).model, np.linspace(0.0, 3.0 * OMEGA, 8), 2)
    forward = next(k for k, track in enumerate(diagram.tracks) if track[-1].whirl == "forward")
    signs = np.where(diagram.speeds < OMEGA, 1.0, -1.0)
    assert diagram.damping_ratios[forward] == pytest.approx([ratio(c, s * ETA) for s in signs], rel=1e-6)
    assert diagram.damping_ratios[1 - forward] == pytest.approx([ratio(c, ETA)] * 8, rel=1e-6)
    critical = next(item for item in diagram.critical_speeds if item.whirl == "forward")
    assert critical.Omega == pytest.approx(OMEGA, rel=1e-3)
    assert critical.damping_ratio == pytest.approx(c / (2.0 * MASS * OMEGA), rel=1e-3)


def test_hysteresis_gives_overdamped_motion_no_frequency():
    """At rest both roots of MASS s^2 + c s + k = 0 stay real, c twice the critical damping."""
    c = 4.0 * MASS * OMEGA
    model = jeffcott(c).model
    roots = np.sort(np.abs(np.roots([MASS, c, SHAFT]).repeat(2)))
    assert modes(model, 0.0) == []
    assert [abs(mode.eigenvalue) for mode in overdamped_modes(model, 0.0)] == pytest.approx(roots, rel=1e-3)


def test_reduced_models_have_the_ratios_of_the_full_one():
    bearings = (Bearing("a", 2, tensor(1e6)), Bearing("b", 8, tensor(3e6)))
    rotor = replace(FREE, bearings=bearings, damping=Damping(loss_factor=ETA))
    exact = supported_rotor(rotor).model
    for Omega in (0.0, 200.0, 900.0):
        expected = [mode.eigenvalue for mode in modes(exact, Omega, 4)]
        reduced = analysis_model(rotor, None, np.array([Omega]), 4, 1e-4).supported.model
        assert reduced.size < exact.size
        np.testing.assert_allclose([mode.eigenvalue for mode in modes(reduced, Omega, 4)], expected, rtol=2e-4)
        response = harmonic_model(rotor, (4,), 2000.0, bearings)
        unit = np.eye(2 * len(NODES))[:, [6]]
        result = response.response(np.array([250.0]), Omega, unit, unit.T, None)[0, 0, 0]
        at = exact.translations[4][0]
        assert result == pytest.approx(np.linalg.inv(dynamic_stiffness(exact, Omega, 250.0))[at, at], rel=1e-3)


def test_viscous_equivalent_has_equal_loss_in_the_free_modes_at_rest():
    rotor = replace(FREE, damping=Damping(loss_factor=ETA, rotating=0.25), reduction=ReductionOptions("none"))
    model = reduced_rotor(rotor).model.viscous()
    assert model.hysteresis is None
    np.testing.assert_allclose(model.R, (model.C + model.R) / 4.0, rtol=1e-9, atol=1e-6)
    bending = [mode for mode in modes(model, 0.0) if mode.frequency > 100.0][:8]
    assert [mode.damping_ratio for mode in bending] == pytest.approx([0.5 * ETA] * 8, rel=1e-7)
    J = turned(model.size)
    np.testing.assert_allclose(model.R @ J, J @ model.R, atol=1e-9 * np.max(np.abs(model.R)))
