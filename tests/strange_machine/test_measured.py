"""A measurement of a heavier expander, with noise, over the model of its drawing; records of its runs."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from amb_analysis.measured.records import Channel, FrequencyResponse, Measurement
from amb_analysis.measured.run_data import read_run
from amb_analysis.studies.frequency_responses import laid_over
from amb_cosim import studies
from rotor_analysis.rotor_file import load_rotor
from tests.support.messages import raises_naming

FOLDER = Path(__file__).parent
ROTOR = FOLDER / "expander.toml"
F = np.arange(50.0, 2500.0, 2.0)
CHANNELS = ("turbine.x", "0.2 m.x", "blower.x")


def impact_test(rotor, noise=0.02, seed=0):
    """Accelerations by a hammer at the turbine of the free rotor."""
    rng = np.random.default_rng(seed)
    force = Channel("turbine.f_x", "N")
    curves = [FrequencyResponse(Channel(name, "m/s2"), force, F, np.ones(len(F), complex)) for name in CHANNELS]
    exact = studies.response(rotor=rotor, measured=Measurement(tuple(curves))).responses.values()
    noises = (noise * (rng.standard_normal(len(F)) + 1j * rng.standard_normal(len(F))) for _ in curves)
    return Measurement(
        tuple(replace(c, values=e.computed * (1 + n)) for c, e, n in zip(curves, exact, noises, strict=True))
    )


@pytest.fixture(scope="module")
def overlay():
    drawn = load_rotor(ROTOR)
    heavier = replace(drawn, bodies=(replace(drawn.bodies[0], mass=0.95), drawn.bodies[1]))
    return studies.response(rotor=drawn, measured=impact_test(heavier))


def test_overlay_lists_modes_of_model_and_measurement(overlay):
    drawn = load_rotor(ROTOR)
    assert len(overlay.modes) == 3
    free = studies.modes(replace(drawn, bearings=(), seals=(), sites=()), count=20).frequencies.speeds[0.0]
    elastic = sorted({round(f / (2 * np.pi), 3) for f in free.frequencies})[:3]
    for mode, hertz in zip(overlay.modes, elastic, strict=True):
        assert mode.computed == pytest.approx(hertz, rel=1e-3)
        assert 0.3 < mode.percent < 1.5  # the drawing is lighter than the rotor
        assert mode.mac > 0.98
        assert mode.measured_damping == pytest.approx(mode.computed_damping, rel=0.1)


def test_equal_models_deviate_only_by_the_noise():
    drawn = load_rotor(ROTOR)
    result = studies.response(rotor=drawn, measured=impact_test(drawn, noise=0.05))
    assert all(abs(mode.percent) < 0.2 for mode in result.modes)
    assert all(item.deviation.decibel == pytest.approx(0.43, abs=0.05) for item in result.responses.values())


def test_channels_are_selected_and_refused_by_name():
    drawn = load_rotor(ROTOR)
    measured = impact_test(drawn)
    one = studies.response(rotor=drawn, measured=measured, outputs=["blower.x"], up_to="1500 Hz")
    assert list(one.responses) == ["blower.x/turbine.f_x"]
    assert next(iter(one.responses.values())).frequencies[-1] == 1500.0
    with raises_naming(ValueError, "response", "turbine.x/turbine.f_x"):
        studies.response(rotor=drawn, measured=measured, outputs=["shroud.x"])
    with raises_naming(ValueError, "outputs"):
        studies.response(rotor=drawn, inputs=["turbine.f_x"])


def test_frequencies_below_and_above_are_cut():
    drawn = load_rotor(ROTOR)
    measured = impact_test(drawn)
    cut = studies.response(rotor=drawn, measured=measured, lowest="400 Hz", up_to="1500 Hz")
    f = next(iter(cut.responses.values())).frequencies
    assert (f[0], f[-1]) == (400.0, 1500.0)
    ends = {"inputs": ["turbine.f_x"], "outputs": ["blower.x"]}
    (curve,) = studies.response(rotor=drawn, lowest="1500 Hz", **ends).responses.values()
    assert (curve.frequencies[0], curve.frequencies[-1]) == (pytest.approx(1500.0), pytest.approx(3000.0))
    with raises_naming(ValueError, "lowest", "800 Hz", "< 700 Hz"):
        studies.response(rotor=drawn, measured=measured, lowest="800 Hz", up_to="700 Hz")


def test_a_response_that_was_measured_again_has_a_number():
    curve = FrequencyResponse(Channel("blower.x", "m"), Channel("turbine.f_x", "N"), F, np.ones(len(F), complex))
    result = laid_over("expander", "free", 0.0, [curve, curve], [curve.values, 2.0 * curve.values])
    deviations = {name: item.deviation.decibel for name, item in result.responses.items()}
    assert deviations == pytest.approx({curve.name: 0.0, f"{curve.name} (2)": 6.0206})


def test_the_levitated_rotor_responds_to_forces_and_currents():
    result = studies.response(
        FOLDER / "levitation.toml",
        inputs=["turbine.f_x", "north.i_x"],
        outputs=["north_east", "0.2 m.y [m/s2]"],
        up_to="800 Hz",
    )
    assert {item.unit for item in result.responses.values()} == {"m/N", "m/A", "(m/s2)/N", "(m/s2)/A"}
    pushed = result.responses["north_east/turbine.f_x"].computed
    assert pushed[0].real > 0.0  # at low frequency it moves along the force
    assert str(result).count("north_east") == 2


@pytest.mark.parametrize(
    ("given", "missing", "present"),
    [("inputs", "outputs", "inputs"), ("outputs", "inputs", "outputs")],
)
def test_a_response_without_a_channel_names_the_argument_for_it(given, missing, present):
    with raises_naming(ValueError, missing, "without a measurement") as caught:
        studies.response(
            rotor=FOLDER / "expander.toml", **{given: ["turbine.x" if given == "outputs" else "turbine.f_x"]}
        )
    assert present not in str(caught.value)


def test_runs_are_records_of_all_channels_with_units(levitation, tmp_path):
    levitation.save(tmp_path, plots=False)
    record = read_run(tmp_path)
    names = {channel.name: channel.unit for channel in record.signals}
    assert names["rotor_contact.north_east"] == "m"
    assert {"N", "A"} <= set(names.values())
    assert record.sample_time == pytest.approx(50e-6)
