"""The linear model of a compressor's loop against its co-simulation, and the arguments of `linearise`."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.io import loadmat
from strange_machine import LEVITATION, ROTOR

import amb_cosim
from amb_analysis.linear.foreign import foreign_component
from amb_analysis.linear.linear_source import linear_source
from amb_analysis.linear.linearise import model_of
from rotor_analysis.damping import Damping
from rotor_analysis.rotor_file import load_rotor
from tests.support.messages import assert_names, raises_naming

pytestmark = pytest.mark.gate

COMPRESSOR = "compressor_levitated"
H = 1e-4
AXES = [f"{bearing}.{axis}" for bearing in ("mb1", "mb2") for axis in "xy"]
DEMANDS = [f"{bearing}.i_{axis}" for bearing in ("mb1", "mb2") for axis in "xy"]
SHOWN = [f"rotor_contact.{axis}" for axis in AXES]
FORCES = ["rotor_contact.impeller3.f_x", "rotor_contact.impeller3.f_y"]
BLOW = {"impeller3.f_x": 5e4, "impeller3.f_y": -2.5e4}  # N, for one sample


@pytest.fixture(scope="module")
def compressor():
    return linear_source(COMPRESSOR)


def free_decay(**changes):
    """Displacements after a blow, from where the plant's exact solution holds on, shape (n, 4)."""
    blow, none = ({"rotor_contact": {name: factor * f for name, f in BLOW.items()}} for factor in (1.0, 0.0))
    scenario = amb_cosim.Scenario.load(COMPRESSOR).machine(
        end_time=860 * H,
        communication_step=H,
        inputs=none,
        event=[{"time": 0.0, "set": blow}, {"time": H, "set": none}],
        record={"variables": SHOWN},
    )
    result = amb_cosim.run(scenario, progress=False, **changes)
    assert result.outcome.failure is None
    return np.array([result.signals[name].values for name in SHOWN]).T[60:]


def fitted_poles(motion, order, rows=60):
    """Poles of a motion, x(n+1) = z x(n), by a matrix pencil of that order."""
    windows = np.array([motion[k : k + rows].ravel() for k in range(len(motion) - rows)])
    V = np.linalg.svd(windows, full_matrices=False)[2][:order].T
    return np.linalg.eigvals(np.linalg.lstsq(windows[:-1] @ V, windows[1:] @ V, rcond=None)[0])


def test_poles_of_the_model_are_those_of_the_free_decay(compressor):
    """All poles slow enough to be visible, to 1e-9 of their s = ln(z)/T, where 1e-6 is required."""
    model = model_of(compressor, FORCES, SHOWN)
    seen = np.array([pole for pole in model.poles() if abs(pole) > 0.9])
    assert len(seen) == 28
    result = fitted_poles(free_decay(), len(seen))
    for pole in seen:
        nearest = result[np.argmin(np.abs(result - pole))]
        assert abs(np.log(nearest) / np.log(pole) - 1.0) < 1e-9


def test_positive_force_and_current_move_the_rotor_towards_positive(compressor):
    """Signs: a signal injected in x of a bearing pushes its journal to +x, before the loop responds."""
    for name in ("rotor_contact.mb1.f_x", "amb_actuator.mb1.i_x"):
        model = model_of(compressor, [name], ["rotor_contact.mb1.x"])
        assert (model.C @ model.B)[0, 0] > 0.0


def test_opened_loop_and_sensitivity_agree(compressor):
    """S = (1 - L)^-1 with L from the demands that arrive to those that the controller answers with."""
    demands = [f"amb_actuator.{name}" for name in DEMANDS]
    answers = [f"rolac_controller.{name}" for name in DEMANDS]
    S, L = model_of(compressor, demands, demands), model_of(compressor, demands, answers, opened=demands)
    for z in np.exp(1j * np.array([0.01, 0.3, 1.0])):
        np.testing.assert_allclose(S(z), np.linalg.inv(np.eye(4) - L(z)), rtol=1e-8, atol=1e-10)


def test_plant_alone_and_with_magnets_are_continuous(compressor):
    rotor = model_of(compressor, components=["rotor_contact"])
    plant = model_of(compressor, ["amb_actuator.*.i_?"], SHOWN, components=["rotor_contact", "amb_actuator"])
    assert rotor.dt == plant.dt == 0.0
    assert max(rotor.poles().real) < 1.0
    assert sum(plant.poles().real > 100.0) == 4  # two bearings of negative stiffness, in x and y
    assert "base.a_x" in " ".join(rotor.input_names)


def test_model_carries_names_units_and_speed(compressor, tmp_path):
    model = model_of(compressor.at(500.0), FORCES[:1], [*SHOWN[:1], "rolac_controller.mb1.i_x"])
    assert (model.input_names, model.input_units) == (("rotor_contact.impeller3.f_x",), ("N",))
    assert model.output_units == ("m", "A")
    assert model.input_labels == ["rotor_contact_impeller3_f_x"]
    assert model.operating_point["Omega"] == 500.0
    content = loadmat(model.save(tmp_path / "model.mat"))
    np.testing.assert_array_equal(content["A"], model.A)
    assert content["Ts"][0, 0] == pytest.approx(H)
    assert content["output_units"].ravel()[1].item() == "A"


def test_displacement_raises_the_negative_stiffness(compressor):
    """Of the nonlinear law; nearer to one magnet both slopes grow."""
    settings = {"amb_actuator.force_law": "nonlinear"}
    centred, moved = (
        model_of(
            linear_source(COMPRESSOR, at, set=settings),
            ["amb_actuator.mb1.x"],
            ["amb_actuator.mb1.f_x"],
            components=["amb_actuator"],
        ).D[0, 0]
        for at in ({}, {"amb_actuator.mb1.x": "0.15 mm"})
    )
    assert moved > 1.2 * centred > 0.0


@pytest.mark.slow
def test_external_fmu_is_linearised_by_differences():
    """A controller as an FMU file has the poles that it has from its constants."""
    lead = amb_cosim.linear_controller(
        (np.diag([0.5] * 4), np.eye(4), 1e3 * np.eye(4), -3e4 * np.eye(4)), AXES, DEMANDS, H, sampled_arrays=True
    )
    local = linear_source(COMPRESSOR, fmu={"rolac_controller": lead})
    interface, folder = local.plan.interfaces["rolac_controller"], local.plan.fmus["rolac_controller"].folder
    part = foreign_component("rolac_controller", folder, interface, {"Omega": 900.0}, (AXES, DEMANDS), H)
    (exact,) = local.parts(["rolac_controller"])
    exact = exact.selected(part.inputs, part.outputs)
    for z in np.exp(1j * np.array([0.0, 0.1, 2.0])):
        answers = [p.law.C @ np.linalg.solve(z * np.eye(4) - p.law.A, p.law.B) + p.law.D for p in (part, exact)]
        np.testing.assert_allclose(*answers, rtol=1e-9, atol=1e-6)
    assert_names(part.notes[0], "responses to pulses", "4 states")
    with raises_naming(ValueError, "rolac_controller", f"{H / 2:g} s", "communication step", "sample time"):
        foreign_component("rolac_controller", folder, interface, {"Omega": 900.0}, (AXES, DEMANDS), H / 2)


@pytest.mark.slow
@pytest.mark.parametrize("step", [H, H / 2], ids=["sample", "half a sample"])
def test_controller_given_as_fmu_file_closes_the_same_loop(tmp_path, step):
    """Also where the components exchange values more often than it samples."""
    lead = amb_cosim.linear_controller(
        (np.diag([0.0] * 4), np.eye(4), 3.6e5 * np.eye(4), -3.85e5 * np.eye(4)), AXES, DEMANDS, H, sampled_arrays=True
    )
    poles = []
    for fmu in (lead, lead.build(tmp_path)):
        scenario = amb_cosim.Scenario.load(COMPRESSOR).changed(communication_step=step)
        model = amb_cosim.linearise(scenario, inputs=FORCES, outputs=SHOWN, fmu={"rolac_controller": fmu})
        poles.append(np.sort_complex(model.poles()))
    np.testing.assert_allclose(*poles, rtol=0.0, atol=1e-9)


@pytest.mark.slow
def test_fractional_delay_is_exact_where_steps_meet_it():
    """Demands 0.3 samples late, in a co-simulation at a tenth of a sample; an undamped rotor would not be stable."""
    rotor = replace(load_rotor("compressor"), damping=Damping(modal=0.02))
    law = (np.zeros((4, 4)), np.eye(4), 3.6e5 * np.eye(4), -3.85e5 * np.eye(4))
    controller = amb_cosim.linear_controller(law, AXES, DEMANDS, H, sampled_arrays=True, delay=0.3)
    model = amb_cosim.linearise(
        COMPRESSOR, inputs=FORCES, outputs=SHOWN, rotor=rotor, fmu={"rolac_controller": controller}
    )
    blow, none = ({"rotor_contact": {name: factor * f for name, f in BLOW.items()}} for factor in (1.0, 0.0))
    scenario = amb_cosim.Scenario.load(COMPRESSOR).machine(
        end_time=600 * H,
        communication_step=H / 10,
        inputs=none,
        event=[{"time": 0.0, "set": blow}, {"time": H, "set": none}],
        record={"variables": SHOWN},
        fmu={"rolac_controller": controller},
    )
    result = amb_cosim.run(scenario, rotor=rotor, progress=False)
    motion = np.array([result.signals[name].values for name in SHOWN]).T[::10][60:]
    seen = np.array([pole for pole in model.poles() if abs(pole) > 0.95])
    matches = fitted_poles(motion, 28)
    for pole in seen:
        assert np.abs(np.log(matches[np.argmin(np.abs(matches - pole))]) / np.log(pole) - 1.0) < 1e-6


@pytest.mark.parametrize(
    ("make", "facts"),
    [
        (lambda _: linear_source(COMPRESSOR, {"speed": 3.0}), ("speed", "component.variable")),
        (
            lambda _: linear_source(COMPRESSOR, {"amb_actuator.mb1.gap_x": 3.0}),
            ("amb_actuator.mb1.gap_x", "parameter", "input"),
        ),
        (
            lambda _: model_of(
                linear_source(COMPRESSOR, {"amb_actuator.mb1.x": 5.1e-4}, set={"amb_actuator.force_law": 2})
            ),
            ("x", "0.00051 m"),
        ),
        (lambda c: model_of(c, components=["rotor"]), ("rotor", "rotor_contact")),
        (lambda c: model_of(c, ["rotor_contact.mb1.k_xx"]), ("inputs", "'rotor_contact.mb1.k_xx'")),
        (
            lambda c: model_of(c, outputs=["*.gap"]),
            ("'*.gap'", "rotor_contact.td1.gap", "without a derivative at the centre", "r = 0"),
        ),
        (lambda c: model_of(c, ["rotor_contact.td1.clearance"]), ("rotor_contact.td1.clearance", "a parameter")),
        (lambda c: model_of(c, ["rotor_contact.mb1.x"]), ("rotor_contact.mb1.x", "an output")),
        (lambda c: model_of(c, ["*.amplifier_off_x"]), ("amb_actuator.mb1.amplifier_off_x", "faults")),
        (
            lambda c: model_of(c, outputs=["rotor_contact.mb1.x"], components=["amb_actuator"]),
            ("rotor_contact.mb1.x", "components"),
        ),
    ],
)
def test_an_invalid_argument_of_a_model_is_refused_with_the_cause(compressor, make, facts):
    with raises_naming(ValueError, *facts):
        make(compressor)


def test_system_and_its_scenario_have_the_same_linear_model():
    """The expander: its middle bearing is a passive ring, its loop is sampled every 50 us."""
    system, rotor = amb_cosim.load_system(ROTOR.parent / "levitated_expander.toml"), str(ROTOR)
    scenario = amb_cosim.Scenario.load(LEVITATION)
    values = scenario.parameters["rolac_controller"] | {"sample_time": "50 us"}
    settings = {f"rolac_controller.{name}": value for name, value in values.items()}
    settings |= {f"amb_actuator.{name}": value for name, value in scenario.parameters["amb_actuator"].items()}
    # What a scenario works out from gravity, and a system does not know.
    settings |= {"amb_actuator.*.static_current_?": 0.5}
    settings |= {"rolac_controller.*.k_s_?": 3e5, "rolac_controller.*.k_i_?": 40.0}
    of_system = amb_cosim.linearise(system, scenario.Omega, rotor=rotor, set=settings)
    of_scenario = amb_cosim.linearise(scenario, set=settings)
    assert of_system.dt == pytest.approx(5e-5)
    assert of_system.input_names == of_scenario.input_names
    np.testing.assert_allclose(of_system.A, of_scenario.A, rtol=1e-12)
