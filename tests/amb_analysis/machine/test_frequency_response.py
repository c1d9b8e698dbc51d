"""Responses between any channels of the expander, against its linear models."""

from pathlib import Path

import numpy as np
import pytest

from amb_analysis.linear.linearise import model_of
from amb_analysis.linear.responses import response
from amb_analysis.machine.channels import place_of
from amb_analysis.machine.frequency_response import Structure, frequency_response, refined
from amb_analysis.machine.machine import machine_of
from amb_cosim.results.component_names import ACTUATOR, PLANT
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.scenario import as_scenario
from rotor_analysis.rotor_file import load_rotor
from tests.support.messages import raises_naming

FOLDER = Path(__file__).parents[2] / "strange_machine"
PASSIVE = "nelson_mcvaugh_free"
F = np.geomspace(5.0, 2000.0, 40)
STEP = 50e-6


@pytest.fixture(scope="module")
def machine():
    return machine_of(prepare_run(as_scenario(FOLDER / "levitation.toml", None), None))


def test_a_rotor_without_magnets_is_named_with_what_it_lacks():
    prepared = prepare_run(as_scenario(PASSIVE, None), None)
    with raises_naming(ValueError, f"scenario {PASSIVE}", ACTUATOR):
        machine_of(prepared, ACTUATOR)
    with raises_naming(ValueError, f"system {prepared.assembly.system.name}", ACTUATOR):
        _ = machine_of(prepared).loop


def places(rotor, *channels, is_input):
    return [place_of(name, unit, rotor, is_input=is_input) for name, unit in channels]


def test_the_closed_loop_is_the_linear_model_before_its_hold(machine):
    inputs = places(machine.rotor, ("turbine.f_x", "N"), ("north.i_x", "A"), is_input=True)
    outputs = places(machine.rotor, ("north_east", "m"), ("south.i_x", "A"), is_input=False)
    result = frequency_response(Structure(machine.rotor, "closed", machine.Omega, machine), inputs, outputs, F)
    demand = machine.loop.sources[machine.loop.axis_names.index("south.x")]
    names = [f"{PLANT}.turbine.f_x", f"{ACTUATOR}.north.i_x"]
    sampled = np.moveaxis(
        response(model_of(machine.linear_components, names, [f"{PLANT}.north_east", demand]), F), -1, 0
    )
    held = (1.0 - np.exp(-2j * np.pi * F * STEP)) / (2j * np.pi * F * STEP)  # of the injected signals there
    error = np.abs(result * held[:, None, None] / sampled - 1.0)
    assert np.median(error) < 1e-3
    assert np.max(error[F < 500.0]) < 0.02  # images of the sampling where the response is small


def test_the_open_loop_is_rotor_and_magnets(machine):
    inputs = places(machine.rotor, ("blower.f_y", "N"), ("south.i_y", "A"), is_input=True)
    outputs = places(machine.rotor, ("south_up", "m"), ("guide_up", "m"), is_input=False)
    result = frequency_response(Structure(machine.rotor, "open", machine.Omega, machine), inputs, outputs, F)
    names = [f"{PLANT}.blower.f_y", f"{ACTUATOR}.south.i_y"]
    shown = [f"{PLANT}.south_up", f"{PLANT}.guide_up"]
    model = model_of(machine.linear_components, names, shown, components=[PLANT, ACTUATOR])
    exact = np.moveaxis(response_of_continuous(model), -1, 0)
    error = np.linalg.norm(result - exact, axis=(1, 2)) / np.linalg.norm(exact, axis=(1, 2))
    assert np.max(error[F < 500.0]) < 0.01  # the reduction of the rotor file leaves modes out above


def response_of_continuous(model):
    s = 2j * np.pi * F
    return np.stack([model.C @ np.linalg.solve(w * np.eye(len(model.A)) - model.A, model.B) + model.D for w in s], -1)


def test_velocity_and_acceleration_are_derivatives_at_any_position():
    rotor = load_rotor(FOLDER / "expander.toml")
    inputs = places(rotor, ("0.055 m.f_x", "N"), is_input=True)
    outputs = places(rotor, ("133 mm.x", "m"), ("133 mm.x", "m/s"), ("133 mm.x", "m/s2"), is_input=False)
    fine = refined(rotor, [*inputs, *outputs])
    x, v, a = frequency_response(Structure(fine, "free"), inputs, outputs, F)[:, :, 0].T
    s = 2j * np.pi * F
    np.testing.assert_allclose(v, s * x, rtol=1e-12)
    np.testing.assert_allclose(a, s * s * x, rtol=1e-12)
    swapped_in = places(rotor, ("133 mm.f_x", "N"), is_input=True)
    swapped_out = places(rotor, ("0.055 m.x", "m"), is_input=False)
    back = frequency_response(Structure(fine, "free"), swapped_in, swapped_out, F)[:, 0, 0]
    assert np.max(np.abs(back - x) / np.abs(x)) < 0.05  # reciprocity, by two reductions, close to antiresonances
    assert np.median(np.abs(back - x) / np.abs(x)) < 1e-3


@pytest.mark.parametrize(
    ("name", "unit", "is_input", "facts"),
    [
        ("turbin.x", "m", False, ("turbin", "turbine")),
        ("eye", "m", False, ("eye", "expander")),
        ("0.2.x", "m", False, ("0.2.x", "unit", "channels")),
        ("1e-3.f_y", "N", True, ("1e-3.f_y", "unit", "channels")),
        ("turbine.x", "m", True, ("input", "m")),
        ("turbine.x", "N", False, ("output", "N")),
    ],
)
def test_unknown_places_and_wrong_units_of_channels_are_refused(name, unit, is_input, facts):
    rotor = load_rotor(FOLDER / "expander.toml")
    with raises_naming(ValueError, *facts):
        place_of(name, unit, rotor, is_input=is_input)


def test_positions_off_the_shaft_and_missing_magnets_are_refused(machine):
    rotor = machine.rotor
    beside = places(rotor, ("0.5 m.x", "m"), is_input=False)
    with raises_naming(ValueError, "0.5 m.x", "0 m", "0.42 m"):
        refined(rotor, beside)
    current, force = places(rotor, ("north.i_x", "A"), ("turbine.f_x", "N"), is_input=True)
    eye = places(rotor, ("north_east", "m"), is_input=False)
    with raises_naming(ValueError, "loop", "'open'", "'closed'"):
        frequency_response(Structure(rotor, "free"), [current], eye, F)
    guide = places(rotor, ("guide.i_x", "A"), is_input=True)
    with raises_naming(ValueError, "north.x", "north.y", "south.x", "south.y"):
        frequency_response(Structure(rotor, "closed", 0.0, machine), guide, eye, F)
    demand = places(rotor, ("north.i_x", "A"), is_input=False)
    with raises_naming(ValueError, "open", "current"):
        frequency_response(Structure(rotor, "open", 0.0, machine), [force], demand, F)
