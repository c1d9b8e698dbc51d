"""The expander's file fitted to measurements of a rotor that differs from it."""

import tomllib
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from amb_analysis.measured.records import Channel, FrequencyResponse, Measurement, Modes
from amb_analysis.studies.rotor_parameters import RotorParameters, free_bounds, number_of_file
from amb_cosim import studies
from rotor_analysis.rotor_file import load_rotor
from tests.support.messages import raises_naming

ROTOR = Path(__file__).parent / "expander.toml"
F = np.arange(300.0, 1500.0, 25.0)
FORCE = Channel("turbine.f_x", "N")
TRUE = {"bodies.turbine.mass": 0.97, "damping.stiffness": 3e-6}
FREE = {"bodies.turbine.mass": (0.7, 1.2), "damping.stiffness": (5e-7, 1e-5)}


@pytest.fixture(scope="module")
def exact():
    """Accelerations of the rotor with the true parameters."""
    built = RotorParameters.load(ROTOR, list(TRUE)).rotor_with(list(TRUE.values()))
    curves = [
        FrequencyResponse(Channel(n, "m/s2"), FORCE, F, np.ones(len(F), complex)) for n in ("blower.x", "0.2 m.x")
    ]
    result = studies.response(rotor=built, measured=Measurement(tuple(curves)))
    return [replace(c, values=r.computed) for c, r in zip(curves, result.responses.values(), strict=True)]


def with_noise(curves, seed, noise=0.03):
    rng = np.random.default_rng(seed)

    def noisy(values):
        return values * np.exp(noise * (rng.standard_normal(len(F)) + 1j * rng.standard_normal(len(F))))

    return Measurement(tuple(replace(curve, values=noisy(curve.values)) for curve in curves))


def contain_truth(result):
    return [p.lower <= true <= p.upper for p, true in zip(result.fit.parameters.values(), TRUE.values(), strict=True)]


def test_the_fit_returns_the_rotor_that_was_measured(exact, tmp_path):
    result = studies.fit(ROTOR, measured=with_noise(exact, 0), free=FREE)
    assert contain_truth(result) == [True, True]
    assert result.fit.rms_after == pytest.approx(0.03, rel=0.2)
    assert result.fit.rms_before > 3.0 * result.fit.rms_after
    assert all(abs(mode.percent) < 0.1 for mode in result.after.modes)
    assert all(mode.percent > 0.3 for mode in result.before.modes)
    studies.save(result, tmp_path)
    text = (tmp_path / "rotor.toml").read_text()
    assert "# bodies.turbine.mass = 0.9" in text
    fitted = load_rotor(tmp_path / "rotor.toml")
    assert fitted.bodies[0].mass == result.fit.parameters["bodies.turbine.mass"].value
    drawn, written = tomllib.loads(ROTOR.read_text()), tomllib.loads(text)
    assert written["sites"] == drawn["sites"]
    assert "bodies.turbine.mass" in str(result)


def test_a_parameter_without_effect_on_the_data_is_refused(exact):
    measured = with_noise(exact, 1)
    with raises_naming(ValueError, "bearings.north.stiffness"):
        studies.fit(ROTOR, measured=measured, free=[*texts(FREE), "bearings.north.stiffness=1e5:1e6"])
    few = {f"bodies.{name}.mass": (0.3, 1.5) for name in ("turbine", "blower")}
    with raises_naming(ValueError, "2 residuals", "2 parameters"):
        studies.fit(ROTOR, measured=modes_of(ROTOR, 2), free=few)


@pytest.mark.parametrize(
    ("changed", "facts"), [(np.negative, ("180 degrees", "reversed")), (np.conj, ("exp(-j omega t)", "phases"))]
)
def test_a_measurement_of_another_sign_is_not_fitted(exact, changed, facts):
    """The fit ended at its start, with an interval of 1e-5."""
    measured = Measurement(tuple(replace(curve, values=changed(curve.values)) for curve in exact))
    with raises_naming(ValueError, exact[0].name, *facts):
        studies.fit(ROTOR, measured=measured, free=FREE)


def texts(free):
    return [f"{name}={low}:{high}" for name, (low, high) in free.items()]


def modes_of(rotor, count):
    free = replace(load_rotor(rotor), bearings=(), seals=(), sites=())
    hertz = [f / (2 * np.pi) for f in studies.modes(free, count=2 * count + 4).frequencies.speeds[0.0].frequencies]
    elastic = np.array(sorted({round(f, 6) for f in hertz if f > 10.0}))[:count]
    return Measurement(modes=Modes(elastic * np.array([1.001, 0.999, 1.0005, 1.0][:count]), np.full(count, np.nan)))


def test_frequencies_alone_fit_a_stiffness():
    measured = modes_of(ROTOR, 3)
    result = studies.fit(ROTOR, measured=measured, free={"materials.steel.youngs_modulus": (1.8e11, 2.4e11)})
    modulus = result.fit.parameters["materials.steel.youngs_modulus"]
    assert modulus.lower < 2.08e11 < modulus.upper
    assert result.after is None
    assert studies.figure(result) is not None


@pytest.mark.parametrize(
    ("free", "facts"),
    [
        ([], ("parameter", "bounds")),
        (["bodies.turbine.mass"], ("NAME=LOWEST:HIGHEST",)),
        (["bodies.turbine.mass=2:1"], ("finite", "ascending")),
        (["bodies.turbine.mass=a:1"], ("bound in free",)),
        (["bodies.turbin.mass=1:2"], ("'turbin'",)),
        (["bodies.turbine.colour=1:2"], ("'colour'",)),
        (["bodies.turbine.name=1:2"], ("str", "number")),
        (["bodies.turbine.mass=2:3"], ("bodies.turbine.mass", "0.9", "2 to 3")),
    ],
)
def test_errors_name_the_faulty_parameter(exact, free, facts):
    with raises_naming(ValueError, *facts):
        studies.fit(ROTOR, measured=Measurement(tuple(exact)), free=free)


def test_a_parameter_that_is_named_twice_is_refused():
    """It was said to have no effect on the data."""
    with raises_naming(ValueError, "bodies.turbine.mass twice"):
        free_bounds(["bodies.turbine.mass=0.7:1.2", "bodies.turbine.mass=0.8:1"])


def test_a_response_of_zero_is_refused_with_its_frequency(exact):
    """A line that a file leaves at 0 has no logarithm: the deviation was 5844 dB, and a fit had no finite residual."""
    values = np.where(F == 425.0, 0.0, exact[1].values)
    measured = Measurement((exact[0], replace(exact[1], values=values)))
    for study in (studies.response, partial(studies.fit, free=FREE)):
        with raises_naming(ValueError, exact[1].name, "0 at 425 Hz"):
            study(rotor=ROTOR, measured=measured)


def test_bounds_are_read_from_texts_and_numbers():
    for free in (["a.b=1:2.5"], {"a.b": (1, "2.5")}):
        assert [number_of_file(name, raw) for name, pair in free_bounds(free).items() for raw in pair] == [1.0, 2.5]
