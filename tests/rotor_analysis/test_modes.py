"""Modes against closed forms: frequency, damping ratio and its sign, direction of whirl."""

from dataclasses import replace

import numpy as np
import pytest
from analysis_cases import I_D, I_P, MASS, STEEL, L, disc_between, jeffcott, rigid, spring, tensor
from hypothesis import example, given, settings
from hypothesis import strategies as st

from rotor_analysis.assembly import assemble, on_bearings
from rotor_analysis.modes import damped_frequencies, modes, overdamped_modes, translations
from rotor_analysis.parts import Bearing, Disc
from rotor_analysis.rigid_body import rigid_body
from rotor_analysis.rotor import Rotor
from rotor_analysis.rotor_file import load_rotor
from rotor_analysis.shaft import Shaft
from rotor_analysis.supported_rotor import supported_rotor
from tests.support.messages import raises_naming


@pytest.mark.parametrize("damping", [0.0, 40.0, 900.0])
@pytest.mark.parametrize("Omega", [0.0, 250.0])
def test_jeffcott_rotor_has_its_frequency_and_damping_ratio_at_any_speed(damping, Omega):
    k = spring()
    natural, ratio = np.sqrt(k / MASS), damping / (2.0 * np.sqrt(k * MASS))
    result = modes(jeffcott(damping=damping).model, Omega)
    assert [mode.whirl for mode in result] == ["backward", "forward"]
    for mode in result:
        assert mode.damping_ratio == pytest.approx(ratio, abs=1e-9)
        assert mode.frequency == pytest.approx(natural * np.sqrt(1.0 - ratio**2), rel=1e-8)


@pytest.mark.parametrize("Omega", [0.0, 80.0, 600.0])
def test_tilting_of_a_rigid_rotor_is_split_by_the_gyroscopic_moment(Omega):
    k, c = 3e6, 200.0
    result = modes(rigid(tensor(k), tensor(c)).model, Omega)
    tilt = np.roots([I_D, c * L**2 / 2 - 1j * Omega * I_P, k * L**2 / 2])  # forward where Im > 0
    translation = np.roots([MASS, 2 * c, 2 * k])
    expected = [(value if value.imag > 0 else value.conjugate()) for value in (*tilt, *translation)]
    expected = sorted(expected, key=lambda value: value.imag)
    np.testing.assert_allclose([mode.eigenvalue for mode in result], expected, rtol=1e-7)
    forward_tilt = max(tilt, key=lambda value: value.imag)
    (mode,) = [
        m for m in result if abs(m.eigenvalue - forward_tilt) < 1e-6 * abs(forward_tilt) and m.whirl == "forward"
    ]
    left, right = translations(rigid(tensor(k)).model, mode.shape)
    np.testing.assert_allclose(left, -right, atol=1e-6)
    np.testing.assert_allclose(left[1], -1j * left[0], atol=1e-6)  # y follows x


@pytest.mark.parametrize(("share", "growing"), [(0.95, []), (1.05, ["forward"]), (-1.05, ["backward"])])
def test_cross_coupling_beyond_c_omega_makes_whirl_grow_in_its_sense(share, growing):
    """Jeffcott rotor: m r'' + c r' + (k - i k_xy) r = 0 is stable as long as k_xy < c sqrt(k / m)."""
    k, c = 2e6, 300.0
    threshold = c * np.sqrt(2 * k / MASS)
    model = rigid(tensor(k, share * threshold), tensor(c)).model
    expected = np.roots([MASS, 2 * c, 2 * (k - 1j * share * threshold)])
    result = modes(model, 0.0)
    (forward,) = (m for m in result if m.whirl == "forward" and m.frequency < 1.2 * np.sqrt(2 * k / MASS))
    upper = expected[np.argmax(expected.imag)]
    assert forward.eigenvalue == pytest.approx(upper, rel=1e-8)
    assert forward.damping_ratio == pytest.approx(-upper.real / abs(upper), rel=1e-6)
    assert [mode.whirl for mode in result if mode.damping_ratio < 0.0] == growing


@pytest.mark.parametrize("Omega", [60.0, 500.0])
def test_orbits_on_anisotropic_bearings_have_the_closed_form_axes(Omega):
    """I_d a'' + Omega I_p b' + k_x a = 0, I_d b'' - Omega I_p a' + k_y b = 0: b = i beta a in a mode."""
    k_x, k_y = 1e6, 3e6
    lever = L**2 / 2
    result = modes(rigid(((k_x, 0.0), (0.0, k_y))).model, Omega)
    tilting = [mode for mode in result if np.allclose(mode.shape[:2], -mode.shape[2:], atol=1e-6)]
    assert len(tilting) == 2
    for mode, whirl in zip(tilting, ("backward", "forward"), strict=True):
        w = mode.frequency
        assert (k_x * lever - I_D * w**2) * (k_y * lever - I_D * w**2) == pytest.approx(
            (w * Omega * I_P) ** 2, rel=1e-6
        )
        beta = (k_x * lever - I_D * w**2) / (w * Omega * I_P)
        expected = -2.0 * beta / (1.0 + beta**2)
        assert mode.whirl_sense == pytest.approx({1: expected, 3: expected}, rel=1e-6)
        assert mode.whirl == whirl


def test_sense_of_whirl_is_the_sign_of_the_area_of_an_orbit():
    """On strongly cross-coupled, unequal bearings some nodes of a mode whirl forward and others backward."""
    oil = ((1.3e7, 1.6e7), (-2.5e7, 8.8e6)), ((2.3e5, -8.2e4), (-8.2e4, 2.9e5))
    shaft = Shaft(tuple(np.linspace(0.0, 1.5, 7)), (0.05,), **STEEL)
    discs = (Disc("left", 3, 32.6, 0.14, 0.07), Disc("right", 5, 51.5, 0.175, 0.07))
    model = supported_rotor(Rotor("oil", shaft, discs, (Bearing("a", 1, *oil), Bearing("b", 7, *oil)))).model
    angle = np.exp(1j * np.linspace(0.0, 2.0 * np.pi, 721))
    kinds = set()
    for mode in modes(model, 157.0, 12):
        place = translations(model, mode.shape)
        x, y = np.outer(place[:, 0], angle).real, np.outer(place[:, 1], angle).real
        area = 0.5 * np.sum(x[:, :-1] * y[:, 1:] - x[:, 1:] * y[:, :-1], axis=1)
        seen = np.array([sense != 0.0 for sense in mode.whirl_sense.values()])
        size = np.pi / 2.0 * np.sum(np.abs(place) ** 2, axis=1)
        np.testing.assert_allclose(area[seen] / size[seen], np.array(list(mode.whirl_sense.values()))[seen], atol=1e-4)
        signs = set(np.sign(area[seen]))
        assert mode.whirl == {(1.0,): "forward", (-1.0,): "backward"}.get(tuple(signs), "mixed")
        kinds.add(mode.whirl)
    assert kinds == {"forward", "backward", "mixed"}


def test_motion_along_straight_lines_is_neither_forward_nor_backward():
    result = modes(rigid(((1e6, 0.0), (0.0, 3e6))).model, 0.0)
    assert [mode.whirl for mode in result] == ["mixed"] * 4


def test_coinciding_modes_at_rest_are_separated_into_circles():
    rotor = load_rotor()
    for mode in modes(supported_rotor(rotor).model, 0.0, 8):
        sense = {"forward": 1.0, "backward": -1.0}[mode.whirl]
        np.testing.assert_allclose(list(mode.whirl_sense.values()), sense, atol=1e-6)
    assert [mode.whirl for mode in modes(supported_rotor(rotor).model, 0.0, 8)] == ["backward", "forward"] * 4


@pytest.mark.parametrize("Omega", [0.0, 80.0, 600.0])
def test_largest_displacement_of_a_shape_is_real_and_positive(Omega):
    """A circle is (sense i, 1); a tilt has the opposite sign at the other end."""
    model = rigid(tensor(3e6)).model
    for mode in modes(model, Omega):
        left, right = translations(model, mode.shape)
        sense = {"forward": 1.0, "backward": -1.0}[mode.whirl]
        np.testing.assert_allclose(left, [1j * sense, 1.0], atol=1e-6)
        np.testing.assert_allclose(np.abs(right), 1.0, atol=1e-6)
        assert np.abs(right - left).max() < 1e-6 or np.abs(right + left).max() < 1e-6


def test_largest_displacement_of_a_line_is_real_and_positive():
    """Without spin, stiffnesses of 1 and 3 MN/m separate the planes; neither has a displacement in the other."""
    model = rigid(((1e6, 0.0), (0.0, 3e6))).model
    for mode in modes(model, 0.0):
        left, _ = translations(model, mode.shape)
        np.testing.assert_allclose(np.sort(left.real), [0.0, 1.0], atol=1e-6)
        np.testing.assert_allclose(left.imag, 0.0, atol=1e-6)


def test_planes_that_differ_by_rounding_alone_leave_coinciding_modes_circles():
    """On a fine mesh of a small rotor, rounding separates pairs by up to 4e-7; here a stiffness does, by 5e-7."""
    k = 1e6
    result = modes(rigid(((k, 0.0), (0.0, k * (1.0 + 1e-6)))).model, 0.0)
    assert [mode.whirl for mode in result] == ["backward", "forward"] * 2


def test_reversed_spin_exchanges_forward_and_backward():
    model = supported_rotor(load_rotor()).model
    with_spin, with_reversed_spin = modes(model, 145.0, 8), modes(model, -145.0, 8)
    np.testing.assert_allclose([m.eigenvalue for m in with_spin], [m.eigenvalue for m in with_reversed_spin], rtol=1e-8)
    exchanged = {"forward": "backward", "backward": "forward"}
    assert [mode.whirl for mode in with_reversed_spin] == [exchanged[mode.whirl] for mode in with_spin]


def test_overdamped_motion_has_real_eigenvalues_and_no_frequency():
    k, c = 1e6, 8e3
    model = rigid(tensor(k), tensor(c)).model
    creeping = overdamped_modes(model, 0.0)
    translation, tilt = np.roots([MASS, 2 * c, 2 * k]), np.roots([I_D, c * L**2 / 2, k * L**2 / 2])
    expected = np.sort(np.repeat([*translation, *tilt], 2))  # in both planes
    np.testing.assert_allclose(np.sort([mode.eigenvalue.real for mode in creeping]), expected, rtol=1e-7)
    assert all(mode.damping_ratio == 1.0 and mode.frequency == 0.0 for mode in creeping)
    assert modes(model, 0.0) == []


def test_rotor_on_negative_stiffness_falls_away_without_oscillating():
    k = 2e6  # of a magnet without control
    falling = [mode for mode in overdamped_modes(rigid(tensor(-k)).model, 0.0) if mode.damping_ratio < 0.0]
    rates = sorted(mode.eigenvalue.real for mode in falling)
    translation, tilt = np.sqrt(2 * k / MASS), np.sqrt(k * L**2 / 2 / I_D)
    np.testing.assert_allclose(rates, [translation] * 2 + [tilt] * 2, rtol=1e-7)
    assert all(mode.damping_ratio == -1.0 for mode in falling)


def test_unsupported_rotor_drifts_with_eigenvalue_zero():
    free = assemble(load_rotor())
    drifting = overdamped_modes(free, 0.0)
    assert len(drifting) == 8  # two translations and two rotations, each with a constant velocity
    assert all(mode.eigenvalue == 0.0 and mode.damping_ratio == 0.0 for mode in drifting)
    assert modes(free, 0.0, 1)[0].frequency > 100.0


@pytest.mark.parametrize("Omega", [20.0, 500.0])
def test_spinning_free_rotor_precesses_and_drifts_with_nothing_near_zero(Omega):
    """Six eigenvalues are 0: translations with their velocities, and tilts; the velocities of tilts precess."""
    rotor = load_rotor("compressor")
    free, body = assemble(rotor, "consistent"), rigid_body(rotor)
    drifting = overdamped_modes(free, Omega)
    assert len(drifting) == 6
    assert all(mode.eigenvalue == 0.0 for mode in drifting)
    precession = modes(free, Omega, 1)[0]
    assert precession.whirl == "forward"
    assert precession.frequency == pytest.approx(Omega * body.polar_inertia / body.diametral_inertia, rel=1e-3)


def test_damper_alone_lets_a_rotor_rest_anywhere():
    """A damper at each end stops translations and tilts, each with one eigenvalue 0 and one decaying rate."""
    drifting = overdamped_modes(rigid(tensor(0.0), tensor(50.0)).model, 0.0)
    rates = np.array([mode.eigenvalue.real for mode in drifting])
    decays = np.repeat(sorted([-100.0 / MASS, -25.0 * L**2 / I_D]), 2)
    np.testing.assert_allclose(np.sort(rates), [*decays, *[0.0] * 4], rtol=1e-9, atol=1e-9)


def on_stiff_supports(rotor):
    ends = [Bearing(f"b{node}", node, tensor(1e15)) for node in (1, len(rotor.shaft.nodes))]
    return on_bearings(assemble(rotor, "consistent"), replace(rotor, bearings=tuple(ends)))


@pytest.mark.parametrize("Omega", [0.0, 2000.0, 8000.0])
def test_rotating_rayleigh_beam_has_its_whirl_frequencies(Omega):
    """(rho A + rho I b^2) w^2 - 2 rho I b^2 Omega w - E I b^4 = 0 with b = n pi / L: forward > 0, backward < 0."""
    shaft = Shaft(tuple(np.linspace(0.0, 1.2, 25)), (0.15,), **STEEL, theory="rayleigh")
    result = modes(on_stiff_supports(Rotor("beam", shaft)), Omega, 6)
    ((e,), *_), rho, E = shaft.elements({}), shaft.density, shaft.youngs_modulus
    for n in (1, 2, 3):
        b = n * np.pi / 1.2
        inertia = rho * e.second_moment * b**2
        roots = np.roots([rho * e.area + inertia, -2 * inertia * Omega, -E * e.second_moment * b**4])
        pair = {mode.whirl: mode.frequency for mode in result[2 * n - 2 : 2 * n]}
        assert pair["forward"] == pytest.approx(np.max(roots), rel=1e-4)
        assert pair["backward"] == pytest.approx(-np.min(roots), rel=1e-4)


def test_timoshenko_beam_with_diagonal_mass_is_of_second_order():
    """E I b^4 - rho A w^2 - rho I (1 + E / (kappa G)) b^2 w^2 + rho^2 I / (kappa G) w^4 = 0."""
    length, errors = 1.2, []
    for count in (8, 16, 32):
        shaft = Shaft(tuple(np.linspace(0.0, length, count + 1)), (0.15,), **STEEL)
        ends = tuple(Bearing(f"b{node}", node, tensor(1e15)) for node in (1, count + 1))
        result = damped_frequencies(supported_rotor(Rotor("beam", shaft, (), ends)).model, 0.0, 6)[::2]
        ((e,), *_), rho, E = shaft.elements({}), shaft.density, shaft.youngs_modulus
        b = np.arange(1, 4) * np.pi / length
        EI, shear = E * e.second_moment, e.shear_coefficient * e.material.shear_modulus
        rotary = rho * e.second_moment * (1.0 + E / shear)
        a, h, q = (rho**2 * e.second_moment / shear, rho * e.area + rotary * b**2, EI * b**4)
        exact = np.sqrt(2.0 * q / (h + np.sqrt(h**2 - 4.0 * a * q)))
        errors.append(np.abs(result / exact - 1.0))
    without_shear = np.sqrt(q / (rho * (e.area + e.second_moment * b**2)))
    assert np.all(errors[-1] < 0.05 * (without_shear / exact - 1.0))
    order = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    np.testing.assert_allclose(order, 2.0, atol=0.3)


@settings(max_examples=25)
@given(
    k=st.tuples(*[st.floats(1e5, 1e7)] * 2),
    cross=st.tuples(*[st.floats(-5e5, 5e5)] * 2),
    c=st.floats(0.0, 5e3),
    Omega=st.floats(0.0, 600.0),
)
@example(k=(1e5, 1e5), cross=(0.0, 1.0), c=0.0, Omega=0.0)  # defective: two equal eigenvalues with one shape
@example(k=(1e5, 1e5), cross=(1e-3, 1.0), c=0.0, Omega=0.0)
@example(k=(1e5, 1e5), cross=(0.0, 10.0), c=0.0, Omega=0.0)
def test_every_mode_solves_the_eigenproblem_on_any_bearings(k, cross, c, Omega):
    rotor = disc_between(
        Bearing("left", 1, ((k[0], cross[0]), (cross[1], k[1])), tensor(c)),
        Bearing("right", 3, tensor(k[1]), tensor(c)),
    )
    rotor = replace(rotor, shaft=replace(rotor.shaft, density=7800.0))
    model = supported_rotor(rotor).model
    for mode in modes(model, Omega, 6):
        s, shape = mode.eigenvalue, mode.shape
        terms = [s**2 * (model.M @ shape), s * ((model.C + Omega * model.G) @ shape), model.K @ shape]
        assert np.linalg.norm(sum(terms)) < 1e-6 * max(np.linalg.norm(term) for term in terms)
        assert np.max(np.abs(translations(model, shape))) == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("call", "facts"),
    [(lambda m: modes(m, np.nan), ("Omega", "nan rad/s", "finite")), (lambda m: modes(m, 0.0, 0), ("count", "0", "1"))],
)
def test_invalid_arguments_are_refused(call, facts):
    with raises_naming(ValueError, *facts):
        call(jeffcott().model)
