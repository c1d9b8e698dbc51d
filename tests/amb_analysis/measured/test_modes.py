"""Modes from responses with noise, against the poles and shapes that made them; pairs and deviations."""

from __future__ import annotations

import numpy as np
import pytest

from amb_analysis.measured.deviation import assurance, curve_deviation, mode_deviations, octaves
from amb_analysis.measured.modal_fit import FittedMode, fitted_modes
from amb_analysis.measured.records import Channel, FrequencyResponse
from tests.support.messages import raises_naming

F = np.arange(5.0, 300.0, 0.25)
POLES = ((31.0, 0.004), (64.0, 0.02), (150.0, 0.008), (163.0, 0.006))
SHAPES = np.array([[1.0, 0.7, -0.5, 0.3], [1.0, -0.4, 0.8, -0.6], [1.0, -1.2, -0.3, 1.0]])  # places by modes
FORCE = Channel("fan.f_x", "N")


def responses(noise=0.0, seed=0, unit="m", scale=1.0):
    rng = np.random.default_rng(seed)
    s = 2j * np.pi * F
    result = []
    for k, shape in enumerate(SHAPES):
        H = np.zeros(len(F), complex)
        for (f, zeta), here, there in zip(POLES, shape, SHAPES[0], strict=True):
            omega = 2 * np.pi * f * scale
            H += here * there / (s**2 + 2 * zeta * omega * s + omega**2)
        if unit == "m/s2":
            H = s**2 * H
        spread = noise * np.abs(H)
        H = H + spread * (rng.standard_normal(len(F)) + 1j * rng.standard_normal(len(F)))
        result.append(FrequencyResponse(Channel(f"p{k}.x", unit), FORCE, F, H))
    return result


@pytest.mark.parametrize("unit", ["m", "m/s2"])
@pytest.mark.parametrize("noise", [0.0, 0.03])
def test_estimated_poles_are_those_of_the_system(unit, noise):
    modes = fitted_modes(responses(noise, unit=unit))
    assert len(modes) == len(POLES)
    for mode, (f, zeta), shape in zip(modes, POLES, SHAPES.T, strict=True):
        damped = f * np.sqrt(1.0 - zeta**2)
        assert mode.frequency == pytest.approx(damped, rel=1e-3)
        assert mode.damping_ratio == pytest.approx(zeta, rel=0.05)
        assert assurance(mode.shape, shape.astype(complex)) > 0.99


def test_a_growing_vibration_is_no_mode():
    (curve,) = responses()[:1]
    turned = FrequencyResponse(curve.output, curve.input, F, curve.values.conj())
    assert fitted_modes([turned]) == ()


def test_responses_with_other_frequencies_are_refused():
    first, second, _ = responses()
    with raises_naming(ValueError, "different frequencies"):
        fitted_modes([first, second.between(10.0, 50.0)])


def test_shapes_that_differ_by_a_factor_do_not_deviate():
    curve = responses()[1]
    a = curve.values
    assert curve_deviation(curve, (3 - 4j) * a).frac == pytest.approx(1.0)
    assert curve_deviation(curve, (3 - 4j) * a).decibel == pytest.approx(20 * np.log10(5.0))
    assert curve_deviation(curve, a).decibel == pytest.approx(0.0, abs=1e-12)


def free_beam(unit, stiffness=1.0):
    """A free rotor: a rigid part 1/(m s^2) and two bending modes, from 1 Hz to 1 kHz."""
    f = np.arange(1.0, 1000.0)
    s, root = 2j * np.pi * f, np.sqrt(stiffness)
    H = 1 / s**2 + sum(1 / (s**2 + 2 * 0.004 * w * s + w**2) for w in (2 * np.pi * root * np.array([300.0, 700.0])))
    return FrequencyResponse(Channel("end.x", unit), FORCE, f, s ** {"m": 0, "m/s": 1, "m/s2": 2}[unit] * H)


@pytest.mark.parametrize("stiffness", [0.5, 1.5])
def test_frac_of_a_free_rotor_does_not_depend_on_the_unit_and_shows_a_wrong_modulus(stiffness):
    """In m/N the first lines decided alone, and half the modulus had a FRAC of 1.000."""
    found = [curve_deviation(free_beam(u), free_beam(u, stiffness).values) for u in ("m", "m/s", "m/s2")]
    assert [d.frac for d in found] == pytest.approx([found[0].frac] * 3, rel=1e-9)
    assert found[0].frac < 0.4  # a quarter of the lines are below the modes
    assert found[0].least < 0.05
    assert 128.0 <= found[0].band[0] < found[0].band[1] < 1000.0


def test_octaves_contain_all_lines_once():
    f = np.r_[np.arange(0.5, 40.0, 0.5), np.geomspace(40.0, 3000.0, 30)]
    bands = octaves(f)
    assert [k for band in bands for k in range(len(f))[band]] == list(range(len(f)))
    assert min(band.stop - band.start for band in bands) >= 8
    assert octaves(f[:3]) == [slice(0, 3)]


def test_modes_are_paired_by_shape():
    measured, computed = fitted_modes(responses()), fitted_modes(responses(scale=1.05))
    pairs = mode_deviations(measured, computed)
    assert [pair.percent for pair in pairs] == pytest.approx([5.0] * 4, abs=0.01)
    assert min(pair.mac for pair in pairs) > 0.999


def test_a_mode_without_counterpart_stays_unpaired():
    measured = [FittedMode(40.0, 0.01, np.ones(1, complex)), FittedMode(100.0, np.nan, np.ones(1, complex))]
    alone, pair = mode_deviations(measured, [FittedMode(101.0, 0.02, np.ones(1, complex))])
    assert (alone.computed, alone.percent, alone.measured_damping) == (None, None, 0.01)
    assert (pair.computed, pair.measured_damping, pair.mac) == (101.0, None, None)


def test_a_computed_mode_that_no_measured_one_matches_is_listed():
    """A mode more than 20 % off was not, as if the model had none."""
    measured = [FittedMode(100.0, 0.01, np.ones(1, complex))]
    computed = [FittedMode(hertz, 0.02, np.ones(1, complex)) for hertz in (99.0, 125.0)]
    pair, far = mode_deviations(measured, computed)
    assert (pair.measured, pair.computed) == (100.0, 99.0)
    assert (far.measured, far.computed, far.percent, far.computed_damping) == (None, 125.0, None, 0.02)
    (lone,) = mode_deviations([], computed[:1])
    assert (lone.measured, lone.computed) == (None, 99.0)


def integrated(seed, noise=0.05, modes=((600.0, 0.03),)):
    """Receptances of an accelerometer, whose noise is divided by omega^2."""
    rng, f = np.random.default_rng(seed), np.arange(1.0, 1001.0)
    w = 2 * np.pi * f
    H = sum(1 / ((2 * np.pi * hertz) ** 2 - w**2 + 2j * zeta * 2 * np.pi * hertz * w) for hertz, zeta in modes)
    N = noise * (rng.standard_normal(len(f)) + 1j * rng.standard_normal(len(f))) / w**2
    return FrequencyResponse(Channel("fan.x", "m"), FORCE, f, H + N)


@pytest.mark.parametrize("seed", range(4))
def test_noise_of_an_integrated_accelerometer_has_no_modes(seed):
    """There were 17 modes below 450 Hz, one of them at 3.5 Hz with a damping ratio of 0.18."""
    (mode,) = fitted_modes([integrated(seed)])
    assert mode.frequency == pytest.approx(600.0, rel=2e-3)
    assert mode.damping_ratio == pytest.approx(0.03, rel=0.05)
    assert fitted_modes([integrated(seed, modes=())]) == ()


@pytest.mark.parametrize("zeta", [2e-4, 1e-3, 0.01])
def test_light_modes_are_found_in_that_noise(zeta):
    """The first one is a fifth of a line wide."""
    found = [mode.frequency for mode in fitted_modes([integrated(1, 0.01, ((300.3, zeta), (800.2, zeta)))])]
    assert found == pytest.approx([300.3, 800.2], rel=1e-3)


def test_modes_at_the_edge_of_the_lines_are_not_listed():
    f = np.arange(100.0, 400.0)
    s, w = 2j * np.pi * f, 2 * np.pi * 103.0
    curve = FrequencyResponse(Channel("fan.x", "m"), FORCE, f, 1 / (s**2 + 0.1 * w * s + w**2))
    assert all(mode.frequency - mode.damping_ratio * mode.frequency >= 100.0 for mode in fitted_modes([curve]))


NEAR = np.arange(50.0, 200.0, 0.25)


def near_modes(poles, shapes, noise=0.0, seed=0):
    """Accelerances with the input at the first place."""
    rng, s = np.random.default_rng(seed), 2j * np.pi * NEAR
    result = []
    for k, shape in enumerate(shapes):
        terms = zip(poles, shape, shapes[0], strict=True)
        H = s**2 * sum(
            a * b / (s**2 + 2 * zeta * 2 * np.pi * f * s + (2 * np.pi * f) ** 2) for (f, zeta), a, b in terms
        )
        H = H + noise * np.abs(H) * (rng.standard_normal(len(H)) + 1j * rng.standard_normal(len(H)))
        result.append(FrequencyResponse(Channel(f"p{k}.x", "m/s2"), FORCE, NEAR, H))
    return result


@pytest.mark.parametrize("zeta", [0.001, 0.003, 0.005, 0.01, 0.015])
@pytest.mark.parametrize("shapes", [((1.0, 0.8), (0.7, -0.9)), ((1.0, 0.3), (0.5, -0.5), (0.2, 1.0))])
def test_two_modes_2_percent_apart_are_two(zeta, shapes):
    """They were one, between both and with the damping of both, unless their dip was 6 dB deep."""
    modes = fitted_modes(near_modes(((100.0, zeta), (102.0, zeta)), shapes, noise=0.01))
    assert [mode.frequency for mode in modes] == pytest.approx([100.0, 102.0], rel=5e-4)
    assert [mode.damping_ratio for mode in modes] == pytest.approx([zeta, zeta], rel=0.1)


@pytest.mark.parametrize("zeta", [0.001, 0.004, 0.02])
@pytest.mark.parametrize("noise", [0.01, 0.05])
def test_one_mode_with_noise_is_one(zeta, noise):
    counts = [len(fitted_modes(near_modes(((100.0, zeta),), ((1.0,), (0.7,)), noise, seed))) for seed in range(15)]
    assert set(counts) == {1}


@pytest.mark.parametrize("zeta", [0.15, 0.2, 0.3])
@pytest.mark.parametrize("unit", ["m", "m/s2"])
@pytest.mark.parametrize("noise", [0.0, 0.02])
def test_a_mode_with_a_damping_ratio_of_30_percent_is_found(zeta, unit, noise):
    """It has no peak of 6 dB."""
    f, rng = np.arange(2.0, 400.0, 2.0), np.random.default_rng(1)
    s, omega = 2j * np.pi * f, 2 * np.pi * 120.0
    values = (s**2 if unit == "m/s2" else 1.0) / (s**2 + 2 * zeta * omega * s + omega**2)
    values = values * (1 + noise * (rng.standard_normal(len(f)) + 1j * rng.standard_normal(len(f))))
    (mode,) = fitted_modes([FrequencyResponse(Channel("fan.x", unit), FORCE, f, values)])
    assert mode.frequency == pytest.approx(120.0 * np.sqrt(1 - zeta**2), rel=0.03)
    assert mode.damping_ratio == pytest.approx(zeta, rel=0.12)


def test_curves_without_a_resonance_have_no_mode():
    f, rng = np.arange(2.0, 400.0, 2.0), np.random.default_rng(1)
    s = 2j * np.pi * f
    noise = 1 + 0.02 * (rng.standard_normal(len(f)) + 1j * rng.standard_normal(len(f)))
    for values in (np.ones(len(f)), 1 / (1 + s / 300.0), np.exp(-1e-3 * s), s**2 / (s + 200.0)):
        for factor in (1.0, noise):
            curve = FrequencyResponse(Channel("fan.x", "m"), FORCE, f, np.asarray(factor * values, complex))
            assert fitted_modes([curve]) == ()


def many_modes(modes, shapes, noise=0.0, seed=1, unit="m"):
    """Responses of modes, (Hz, damping ratio) each, with their residues at some places, from 2 to 500 Hz."""
    f, rng = np.arange(2.0, 500.0), np.random.default_rng(seed)
    s, result = 2j * np.pi * f, []
    for k, residues in enumerate(shapes):
        parts = [
            r / (s**2 + 2 * z * (2 * np.pi * hz) * s + (2 * np.pi * hz) ** 2)
            for (hz, z), r in zip(modes, residues, strict=True)
        ]
        H = sum(parts) * (s**2 if unit == "m/s2" else 1.0)
        H = H * (1 + noise * (rng.standard_normal(len(f)) + 1j * rng.standard_normal(len(f))))
        result.append(FrequencyResponse(Channel(f"p{k}.x", unit), FORCE, f, H))
    return result


@pytest.mark.parametrize("zeta", [0.15, 0.3, 0.4])
@pytest.mark.parametrize("unit", ["m", "m/s2"])
@pytest.mark.parametrize("noise", [0.0, 0.02])
def test_a_heavily_damped_mode_beside_light_modes_is_found(zeta, unit, noise):
    """The light modes alone were found, since it has no peak of 6 dB."""
    light = ((260.0, 0.01), (380.0, 0.006))
    curves = many_modes(((120.0, zeta), *light), ((1.0, 0.5, 0.4), (0.8, -0.4, 0.3)), noise, unit=unit)
    heavy, *others = fitted_modes(curves)
    assert heavy.frequency == pytest.approx(120.0 * np.sqrt(1 - zeta**2), rel=0.05)
    assert heavy.damping_ratio == pytest.approx(zeta, rel=0.12)
    assert [mode.frequency for mode in others] == pytest.approx([260.0, 380.0], rel=1e-3)
    assert [mode.damping_ratio for mode in others] == pytest.approx([0.01, 0.006], rel=0.03)


def test_a_heavily_damped_mode_between_light_modes_is_found():
    curves = many_modes(((60, 0.01), (250, 0.3), (450, 0.005)), ((0.1, 3, 1), (0.05, -2, 1)), 0.02, unit="m/s2")
    assert [mode.damping_ratio for mode in fitted_modes(curves)] == pytest.approx([0.01, 0.3, 0.005], rel=0.12)


def test_light_modes_and_those_beyond_the_lines_are_not_a_heavily_damped_mode():
    for seed in range(40):
        rng = np.random.default_rng(seed)
        n = int(rng.integers(1, 5))
        hertz = np.append(np.linspace(40.0, 460.0, n) + rng.uniform(-10, 10, n), rng.uniform(520, 900))
        modes = [*zip(hertz, 10 ** rng.uniform(-3, -1.5, n + 1), strict=True)]
        curves = many_modes(modes, rng.standard_normal((2, n + 1)), 0.02, seed, ("m", "m/s2")[seed % 2])
        assert all(mode.damping_ratio < 0.05 for mode in fitted_modes(curves))
