"""Damping under an exponential window, whose decay the study takes out of the modes and puts into the model."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from amb_analysis.measured.modal_fit import fitted_modes
from amb_analysis.measured.records import Channel, FrequencyResponse, Measurement
from amb_cosim import studies
from tests.support.messages import raises_naming

MACHINE = Path(__file__).parents[2] / "strange_machine"
FORCE = Channel("wheel.f_x", "N")
FAN = """
name = "fan"
[shaft]
youngs_modulus = 2.1e11
density = 7800.0
poissons_ratio = 0.3
[[shaft.sections]]
length = 0.6
diameter = 0.03
[[bodies]]
name = "wheel"
z = 0.4
mass = MASS
radius = 0.1
width = 0.02
[damping]
modal = 0.004
"""
RATE, N, TAU = 2048.0, 4096, 0.2


@pytest.fixture(scope="module")
def rotor(tmp_path_factory):
    """Returns the file of a rotor with a wheel of a mass (kg)."""

    def written(mass):
        path = tmp_path_factory.mktemp("fan") / "fan.toml"
        path.write_text(FAN.replace("MASS", str(mass)))
        return path

    return written


@pytest.fixture(scope="module")
def blow(rotor):
    """A blow at the wheel of 4.2 kg, the accelerations of two places, and the frequencies (Hz)."""
    f = np.fft.rfftfreq(N, 1 / RATE)
    ones = np.ones(len(f) - 2, complex)
    curves = tuple(FrequencyResponse(Channel(n, "m/s2"), FORCE, f[1:-1], ones) for n in ("wheel.x", "0.1 m.x"))
    exact = studies.response(rotor=rotor(4.2), measured=Measurement(curves)).responses.values()
    t = np.arange(N) / RATE
    u = np.where((t >= 0.01) & (t < 0.013), 200 * np.sin(np.pi * (t - 0.01) / 0.003), 0.0)
    Y = [np.pad(item.computed, 1) * np.fft.rfft(u) for item in exact]
    return t, u, [np.fft.irfft(y, N) for y in Y], curves


@pytest.fixture(scope="module")
def windowed(blow):
    """Responses as an analyser estimates them from 1 s of the records, with and without its exponential window."""
    t, u, motions, curves = blow
    n = round(RATE)
    f = np.fft.rfftfreq(n, 1 / RATE)
    on = (f >= 20.0) & (f <= 450.0)

    def estimated(weights):
        U = np.fft.rfft(u[:n] * weights)[on]
        values = [np.fft.rfft(y[:n] * weights)[on] / U for y in motions]
        return tuple(replace(c, frequencies=f[on], values=v) for c, v in zip(curves, values, strict=True))

    return estimated(np.exp(-t[:n] / TAU)), estimated(np.ones(n))


def test_the_window_adds_its_decay_to_the_damping_and_the_stated_one_is_subtracted(windowed):
    """1/(tau omega) = 0.00265 was in the damping ratio of 0.004; high is the unsafe side."""
    curves, without = windowed
    (raw,), (mode,), (plain,) = (
        fitted_modes(items) for items in (curves, [replace(c, decay=1 / TAU) for c in curves], without)
    )
    omega = 2 * np.pi * raw.frequency
    assert raw.damping_ratio == pytest.approx(0.004 + 1 / (TAU * omega), rel=0.01)
    assert mode.damping_ratio == pytest.approx(0.004, rel=0.01)
    assert plain.damping_ratio == pytest.approx(0.004, rel=0.01)
    assert mode.frequency == pytest.approx(plain.frequency, rel=1e-5)
    assert mode.is_resolved


def test_computed_responses_have_the_window_of_the_measured_ones(rotor, windowed):
    result = studies.response(rotor=rotor(4.2), measured=Measurement(windowed[0]), exponential_window=f"{TAU} s")
    for item in result.responses.values():
        assert item.deviation.decibel < 0.02
        assert item.deviation.frac > 0.9999
    (mode,) = result.modes
    assert mode.measured_damping == pytest.approx(mode.computed_damping, rel=1e-3)
    assert mode.computed_damping == pytest.approx(0.004, rel=0.01)
    assert "exponential window of 0.2 s" in str(result)
    fitted = studies.fit(rotor(4.0), measured=Measurement(windowed[0]), exponential_window=TAU,
                         free=["bodies.wheel.mass=3:6", "damping.modal=0.001:0.02"])  # fmt: skip
    assert [p.value for p in fitted.fit.parameters.values()] == [
        pytest.approx(4.2, rel=1e-3), pytest.approx(0.004, rel=0.01)]  # fmt: skip


def test_responses_of_a_file_ask_for_the_window(rotor, windowed):
    text = str(studies.response(rotor=rotor(4.2), measured=Measurement(windowed[1])))
    assert "exponential_window" in text


def test_damping_below_a_tenth_of_that_of_the_window_is_unknown(windowed):
    (mode,) = fitted_modes([replace(c, decay=7.5 + 1 / TAU) for c in windowed[0]])
    assert not mode.is_resolved


@pytest.mark.parametrize("loop", ["closed", "linear"])
def test_the_window_shifts_the_response_of_a_loop_as_it_does_its_impulse_response(loop):
    """y(t) exp(-a t) is the response at j omega + a; a sampled controller and its delay are in the loop."""
    a, n, top = 60.0, 2048, 4000.0
    f = np.fft.rfftfreq(n, 0.5 / top)[1:]
    source = Channel("turbine.f_x", "N")
    curve = FrequencyResponse(Channel("turbine.x", "m"), source, f, np.ones(len(f), complex))
    plain, shifted = (
        next(iter(studies.response(MACHINE / "levitation.toml", measured=Measurement((item,)), loop=loop)
                  .responses.values())).computed for item in (curve, replace(curve, decay=a)))  # fmt: skip
    impulse = np.fft.irfft(np.r_[0.0, plain], n)
    impulse -= impulse[-n // 8 :].mean()  # the line at 0 Hz
    expected = np.fft.rfft(impulse * np.exp(-a * np.arange(n) * 0.5 / top))[1:]
    low = (f > 20.0) & (f < 600.0)
    np.testing.assert_allclose(shifted[low], expected[low], atol=0.02 * np.abs(expected[low]).max())
    assert np.abs(shifted - plain)[low].max() > 0.1 * np.abs(plain[low]).max()


def test_a_blow_is_fitted_without_any_option(rotor, blow, tmp_path):
    """A Hann window over an eighth of the record gave 4.60 kg, from 4.39 to 4.81 kg, and an error of the model."""
    t, u, motions, _ = blow
    rng = np.random.default_rng(1)
    columns = [s + 1e-3 * np.abs(s).max() * rng.standard_normal(N) for s in (u, *motions)]
    heads = "time [s],hammer [N],acc1 [m/s2],acc2 [m/s2]"
    np.savetxt(tmp_path / "blow.csv", np.column_stack([t, *columns]), delimiter=",", comments="", header=heads)
    channels = {"hammer": "wheel.f_x", "acc1": "wheel.x", "acc2": "0.1 m.x"}
    free = ["bodies.wheel.mass=3:6"]
    result = studies.fit(rotor(4.0), measured=tmp_path / "blow.csv", inputs=["hammer"], free=free, channels=channels)
    (mass,) = result.fit.parameters.values()
    assert mass.value == pytest.approx(4.2, abs=1e-3)
    assert mass.upper - mass.lower < 0.01
    assert result.after.estimate.blows == 1
    assert "1 blow of a hammer" in str(result)


def test_a_time_constant_must_be_positive(rotor, windowed):
    with raises_naming(ValueError, "exponential_window", "-1 s", "> 0 s"):
        studies.response(rotor=rotor(4.2), measured=Measurement(windowed[0]), exponential_window=-1)
