"""Modes over speed: critical speeds in closed form, and modes that keep their identity."""

from dataclasses import replace

import numpy as np
import pytest
from analysis_cases import I_D, I_P, MASS, NOTHING, E, L, clamped, jeffcott, rigid, spring, tensor
from rotor_cases import one_plane_matrices
from scipy.linalg import eigh

from rotor_analysis import tracking
from rotor_analysis.analysis_model import ACCURACY, analysis_model
from rotor_analysis.assembly import assemble
from rotor_analysis.campbell import campbell
from rotor_analysis.modes import modes
from rotor_analysis.parts import Bearing, Body
from rotor_analysis.rotor import Rotor
from rotor_analysis.rotor_file import load_rotor
from rotor_analysis.shaft import Shaft
from rotor_analysis.spectrum import eigenvalues, slowest_eigenvalues
from rotor_analysis.supported_rotor import supported_rotor
from rotor_analysis.tracking import ModesOverSpeed, modal_assurance, pair_modes, track_modes
from tests.support.messages import raises_naming


def criticals(diagram, whirl):
    return [c.Omega for c in diagram.critical_speeds if c.whirl == whirl]


@pytest.mark.parametrize(("step", "c"), [(7.0, 0.0), (90.0, 0.0), (45.0, 700.0)])
def test_critical_speed_of_the_jeffcott_rotor_is_that_of_its_spring(step, c):
    result = campbell(jeffcott(damping=c).model, np.arange(0.0, 900.0, step), 2).critical_speeds
    ratio = c / (2.0 * np.sqrt(spring() * MASS))
    assert sorted(critical.whirl for critical in result) == ["backward", "forward"]
    for critical in result:
        assert critical.Omega == pytest.approx(np.sqrt(spring() / MASS * (1.0 - ratio**2)), rel=1e-9)
        assert critical.damping_ratio == pytest.approx(ratio, rel=1e-8, abs=1e-9)


def test_tilting_rotor_has_its_gyroscopic_critical_speeds():
    """(I_d -+ I_p) Omega^2 = k L^2 / 2: a disc (I_p > I_d) has no forward one, a drum has both."""
    k, speeds = 3e6, np.linspace(0.0, 6000.0, 61)
    for i_d, i_p in ((I_D, I_P), (0.12, 0.05)):
        diagram = campbell(rigid(tensor(k), i_d=i_d, i_p=i_p).model, speeds, 4)
        translation = np.sqrt(2 * k / MASS)
        tilt = k * L**2 / 2
        np.testing.assert_allclose(criticals(diagram, "backward"), sorted([translation, np.sqrt(tilt / (i_d + i_p))]))
        forward = sorted([translation, np.sqrt(tilt / (i_d - i_p))]) if i_d > i_p else [translation]
        np.testing.assert_allclose(criticals(diagram, "forward"), forward)


def test_overhung_disc_has_the_critical_speeds_of_its_flexibility():
    """Whirl at Omega = p (forward) or -p: force m p^2 w and moment (I_d p^2 - I_p Omega p) slope on a, b; b, c."""
    length, d, i_d, i_p = 0.6, 0.04, 0.3, 0.2
    shaft = Shaft((0.0, length), (d,), E, 1e-9, 0.3, theory="rayleigh")
    model = clamped(assemble(Rotor("overhung", shaft, (Body("disc", 2, MASS, i_d, i_p),))))
    EI = E * np.pi * d**4 / 64
    a, b, c = length**3 / (3 * EI), length**2 / (2 * EI), length / EI
    diagram = campbell(model, np.linspace(0.0, 1500.0, 40), 4)
    for whirl, inertia in (("forward", i_d - i_p), ("backward", i_d + i_p)):
        squared = np.roots([(a * c - b**2) * MASS * inertia, -(a * MASS + c * inertia), 1.0])
        np.testing.assert_allclose(criticals(diagram, whirl), np.sort(np.sqrt(squared)), rtol=1e-8)


def test_undamped_critical_speeds_solve_the_synchronous_eigenproblem():
    """K r = Omega^2 (M -+ G_1) r in one plane, forward and backward: no iteration over speed."""
    rotor = load_rotor()
    M, G, K = one_plane_matrices(rotor)
    for node in rotor.bearing_nodes:
        K[2 * node - 2, 2 * node - 2] += 1e6
    diagram = campbell(supported_rotor(rotor.on_equal_bearings(1e6, 0.0)).model, np.linspace(0.0, 600.0, 31), 8)
    for whirl, sign in (("forward", -1.0), ("backward", 1.0)):
        inverse = eigh(M + sign * G, K, eigvals_only=True)  # of M -+ G, which need not be positive definite
        exact = np.sort(1.0 / np.sqrt(inverse[inverse > 0]))[:4]
        np.testing.assert_allclose(criticals(diagram, whirl), exact, rtol=1e-6)


def test_forward_critical_speeds_of_the_rig_are_near_the_measured_ones():
    """10, 17 and 28 Hz were measured under PID; the model's bearings are those of chapter 3."""
    diagram = campbell(supported_rotor(load_rotor()).model, np.linspace(0.0, 628.0, 64), 8)
    result = np.array(criticals(diagram, "forward")[:3]) / (2.0 * np.pi)
    np.testing.assert_allclose(result, [10.0, 17.0, 28.0], rtol=0.05)


def test_modes_keep_their_identity_where_frequencies_cross():
    """Backward tilting falls through the translation of the same rotor; by order of frequency they would swap."""
    k, i_d, i_p, speeds = 1.2e6, 0.5, 0.9, np.linspace(0.0, 1500.0, 16)
    diagram = campbell(rigid(tensor(k), i_d=i_d, i_p=i_p).model, speeds, 4)
    translation, half = np.sqrt(2 * k / MASS), speeds * i_p / i_d / 2
    tilt = np.sqrt(half**2 + k * L**2 / 2 / i_d)
    assert tilt[0] - half[0] > translation > tilt[-1] - half[-1]
    tracks = sorted(diagram.frequencies.tolist())
    expected = sorted([(tilt - half).tolist(), (tilt + half).tolist(), *[[translation] * len(speeds)] * 2])
    np.testing.assert_allclose(tracks, expected, rtol=1e-8)
    assert all(len({mode.whirl for mode in track}) == 1 for track in diagram.tracks)


def test_tracks_do_not_depend_on_the_step_in_speed():
    """Strong gyroscopic moments on anisotropic bearings: at 2000 rad/s no shape is what it was at rest."""
    rotor = load_rotor()
    bodies = tuple(Body(b.name, b.node, b.mass, b.diametral_inertia, 5.0 * b.polar_inertia) for b in rotor.bodies)
    tensors = (((2e6, 0.0), (0.0, 3e5)), ((8e5, 0.0), (0.0, 1.5e6)))
    bearings = tuple(replace(b, stiffness=k) for b, k in zip(rotor.bearings, tensors, strict=True))
    model = supported_rotor(replace(rotor, bodies=bodies, bearings=bearings)).model
    fine, at_once = (track_modes(ModesOverSpeed(model), np.linspace(0.0, 2000.0, n), 8) for n in (101, 2))
    for fine_track, coarse_track in zip(fine, at_once, strict=True):
        assert fine_track[-1].eigenvalue == pytest.approx(coarse_track[-1].eigenvalue, rel=1e-8)


def test_each_speed_is_solved_once(monkeypatch):
    """Whether modes are followed up, down from the last speed, or over halves of a step."""
    solved = []
    monkeypatch.setattr(tracking, "modes", lambda model, Omega: solved.append(Omega) or modes(model, Omega))
    model = rigid(tensor(1e4), tensor(100.0)).model
    assert len(campbell(model, np.linspace(0.0, 3000.0, 16), 2).tracks) == 3
    assert len(solved) == len(set(solved)) >= 16


def test_modal_assurance_separates_whirl_senses_despite_size_and_phase():
    M = np.diag([2.0, 2.0, 1.0, 1.0])
    forward, backward = np.array([1.0, -1j, 0.5, -0.5j]), np.array([1.0, 1j, 0.5, 0.5j])
    np.testing.assert_allclose(
        modal_assurance(M, [forward], [backward, (3.0 - 4.0j) * forward]), [[0.0, 1.0]], atol=1e-15
    )
    assert pair_modes(M, [forward, backward], [2j * backward]) == [(None, 0.0), (0, pytest.approx(1.0))]


@pytest.mark.parametrize("speeds", [[0.0, 2.0, 1.0], [], [0.0, np.nan]])
def test_speeds_that_do_not_rise_are_refused(speeds):
    with raises_naming(ValueError, "finite", "ascending"):
        campbell(jeffcott().model, np.array(speeds))


@pytest.mark.parametrize("name", [pytest.param("compressor", marks=pytest.mark.slow), "nelson_mcvaugh"])
def test_critical_speeds_of_the_reduced_and_full_model_agree(name):
    rotor, speeds = load_rotor(name), np.linspace(0.0, 1200.0, 5)
    analysed = analysis_model(rotor, None, speeds, 8)
    full = analysed.supported.full
    assert analysed.supported.model.size < full.size / 2
    reduced = campbell(analysed.supported.model, speeds, 8)
    whole = campbell(full, speeds, 8)
    assert 0.0 < analysed.error <= ACCURACY
    assert [c.whirl for c in reduced.critical_speeds] == [c.whirl for c in whole.critical_speeds]
    for result, exact in zip(reduced.critical_speeds, whole.critical_speeds, strict=True):
        assert result.Omega == pytest.approx(exact.Omega, rel=3 * ACCURACY)
        assert result.damping_ratio == pytest.approx(exact.damping_ratio, rel=3 * ACCURACY, abs=ACCURACY)


def fan(stiffness, diameter=0.05):
    """A shaft of 41 nodes in two bearings, with a heavy disc at an end."""
    nodes = tuple(np.linspace(0.0, 1.0, 41))
    shaft = Shaft(nodes, (diameter,), youngs_modulus=210e9, density=7850.0, poissons_ratio=0.3)
    bearings = tuple(Bearing(f"b{node}", node, stiffness=stiffness, damping=1e-5 * stiffness) for node in (5, 35))
    return Rotor("fan", shaft, (Body("wheel", 41, 20.0, 0.6, 0.3),), bearings)


@pytest.mark.parametrize("stiffness", [0.0, 3e7])
@pytest.mark.parametrize("Omega", [0.0, 900.0])
def test_slowest_eigenvalues_agree_with_the_full_spectrum(stiffness, Omega):
    """Without stiffness some eigenvalues are 0, in pairs of few digits."""
    model = supported_rotor(fan(stiffness)).full
    slowest, whole = slowest_eigenvalues(model, Omega, 8), eigenvalues(model, Omega)
    assert 32 <= len(slowest) < len(whole) / 3
    upper = [np.sort(of[(of.imag > 1.0) & np.isfinite(of)].imag)[:8] for of in (slowest, whole)]
    np.testing.assert_allclose(upper[0], upper[1], rtol=1e-7)


@pytest.mark.parametrize("stiffness", [0.0, 3e7])
def test_two_vibrations_need_the_coordinates_of_one_free_mode(stiffness):
    """Per plane: four free modes, two rigid motions, the shapes of two bearings, and five of gyroscopic moments."""
    analysed = analysis_model(fan(stiffness, 0.15), None, np.array([0.0, 3000.0]), 8)
    model, full = analysed.supported.model, analysed.supported.full
    assert model.size <= 2 * (4 + 2 + 2 + 5)
    for Omega in (750.0, 1500.0, 3000.0):
        result, exact = np.array([mode.eigenvalue for mode in modes(model, Omega, 8)]), eigenvalues(full, Omega)
        nearest = exact[np.argmin(np.abs(result[:, None] - exact), axis=1)]
        np.testing.assert_allclose(result, nearest, rtol=ACCURACY)


def test_with_zero_tolerance_the_full_model_is_analysed():
    rotor = load_rotor("nelson_mcvaugh")
    analysed = analysis_model(rotor, None, np.array([0.0, 100.0]), 4, 0.0)
    assert analysed.supported.model is analysed.supported.full


def light_shaft(density, k_bearing):
    """A disc of 10 kg in the middle of a light shaft of 1 m in equal bearings, with a damper at the disc."""
    shaft = Shaft((0.0, 0.25, 0.5, 0.75, 1.0), 0.03, 2e11, density, 0.3, theory="rayleigh")
    held = [Bearing(name, node, tensor(k_bearing)) for name, node in (("a", 1), ("b", 5))]
    disc = Body("disc", 3, 10.0, 1e-4, 2e-4)
    return Rotor("light", shaft, (disc,), (*held, Bearing("air", 3, NOTHING, tensor(20.0))))


@pytest.mark.parametrize("density", [1e-3, 1e-12, 1e-20, 1e-30, 0.0])
def test_critical_speed_of_a_shaft_with_little_or_no_mass(density):
    """omega^2 = k / m with 1/k = L^3 / (48 E I) + 1 / (2 k_b)."""
    rotor = light_shaft(density, 1e6)
    model = analysis_model(rotor, None, np.array([0.0, 400.0]), 2).supported.model
    result = campbell(model, np.linspace(0.0, 400.0, 9), 2).critical_speeds
    flexibility = 64.0 / (48.0 * 2e11 * np.pi * 0.03**4) + 0.5e-6
    omega = np.sqrt(1.0 / (10.0 * flexibility) - (20.0 / 20.0) ** 2)
    assert [item.whirl for item in result] == ["backward", "forward"]
    assert [item.Omega for item in result] == pytest.approx([omega, omega], rel=1e-5)


def test_equal_whirls_on_stiff_bearings_are_separated_at_every_speed():
    """Rounding on the scale of bearings of 1e11 N/m parts the eigenvalues of a disc in the middle, which are equal."""
    rotor = light_shaft(0.01, 1e11)
    model = analysis_model(rotor, None, np.array([0.0, 1000.0]), 4).supported.model
    for Omega in np.linspace(0.0, 100.0, 401)[1:]:
        assert {mode.whirl for mode in modes(model, Omega, 2)} == {"backward", "forward"}


def test_precession_of_a_well_damped_disc_begins_above_rest():
    """I_D a'' + (c L^2/2 - i Omega I_P) a' + k L^2/2 a = 0 creeps at rest, and whirls backward at speed."""
    k, c, speeds = 1e4, 100.0, np.linspace(0.0, 3000.0, 16)
    diagram = campbell(rigid(tensor(k), tensor(c)).model, speeds, 2)
    slow, _ = sorted(np.roots([I_D, c * L**2 / 2 - 1j * speeds[-1] * I_P, k * L**2 / 2]), key=abs)
    assert slow.imag < 0.0
    precession = diagram.tracks[2]
    assert precession[0] is None
    assert precession[-1].whirl == "backward"
    assert precession[-1].eigenvalue == pytest.approx(slow.conjugate(), rel=1e-6)
    assert len(diagram.tracks) == 3
