"""A first design that stands: its controller of five axes levitates it, and it lands on a face."""

import cmath
import math
import tomllib

import numpy as np
import pytest

import amb_cosim
from amb_analysis.linear.rotor_and_magnets import bearing_slopes
from amb_analysis.machine.machine import Machine
from amb_assessment.assessment.analyses import axial
from amb_assessment.assessment.engine.assess import check_machine
from amb_assessment.assessment.format.machine_file import load_machine
from amb_assessment.assessment.page.description import thrust_doubt
from amb_assessment.assessment.physics.axial_cases import load_cases
from amb_assessment.first_design import files
from amb_assessment.first_design.commands import _echo_axis
from amb_assessment.first_design.files import new_machine
from amb_assessment.first_design.levitation import TRIP
from amb_assessment.first_design.rotor_text import diameter_at, plain_shaft
from amb_assessment.first_design.sizing import MagnetData
from amb_cosim.controllers.linear_controller import linear_controller
from amb_cosim.cosim.system.values import RPM
from amb_cosim.results.component_names import ACTUATOR, CONTROLLER, PLANT
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.scenario import load_scenario
from rotor_analysis.rotor_file import load_rotor
from tests.support.any_gains import any_gains
from tests.support.messages import assert_names

SPEED = 20000.0 / RPM


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    folder = tmp_path_factory.mktemp("new") / "stand"
    text = plain_shaft("stand", 12.0, 0.4, SPEED)
    return new_machine(folder, text, SPEED, tilt=0.5 * math.pi, thrust_disc=True)


@pytest.fixture
def quick(monkeypatch):
    """Any gains instead of a search for them."""

    monkeypatch.setattr(files, "first_design", any_gains)


def text_with_disc():
    """A drawing of a shaft with a disc of its own, 10 mm from the centre of its wheel at 0.18 m."""
    return plain_shaft("fan", 12.0, 0.4, SPEED) + "\n[thrust_disc]\nz = 0.19\n"


def test_the_law_of_five_axes_has_the_gains_of_the_radial_design(made):
    """u = -(k + c (z - 1)/((tau + T) z - tau)) x/K_i, a sample late."""
    T, pid = made.design.sample_time, made.design.pid
    controller = linear_controller(made.folder / "control.toml")
    law, z = controller.law_at(), cmath.exp(2j * math.pi * 300.0 * T)
    K = law.C @ np.linalg.solve(z * np.eye(len(law.A)) - law.A, law.B) + law.D
    derivative = (z - 1.0) / ((pid.derivative_time + T) * z - pid.derivative_time)
    for k, demand in enumerate(controller.ports.demands[:4]):
        bearing = demand.partition(".")[0]
        point = made.points[bearing]
        expected = -(pid.k_b[bearing] + point.k_s + pid.c_b[bearing] * derivative) / point.k_i
        assert K[k, k] == pytest.approx(expected, rel=1e-4)


def test_it_levitates_from_standstill_to_its_trip_speed(made):
    loop = Machine(prepare_run(load_scenario(str(made.folder / "levitation.toml")).machine())).loop
    assert loop.least_stable(np.linspace(0.0, TRIP * SPEED, 4)).is_stable


def test_its_machine_file_states_the_axial_magnet(made):
    assert not (made.folder / "axial.toml").exists()  # its controller of five axes is assessed
    machine = check_machine(load_machine(made.folder / "machine.toml"))
    found = {item.quantity: item for item in axial.result_of(machine).quantities}
    assert 10.0 < found["axial_load"].value < 50.0  # it is sized for four times the weight
    assert found["spectral_radius"].value < 1.0
    assert found["decrement_anywhere"].value > 1.0


def test_runs_and_assessment_have_the_same_axial_operating_point(made):
    """Coils with I_0 + i and I_0 - i carry the weight: K_i as without load, and K_s (1 + (i/I_0)^2)."""
    parameters = Machine(prepare_run(load_scenario(str(made.folder / "levitation.toml")))).parameters[ACTUATOR]
    (case,) = load_cases(check_machine(load_machine(made.folder / "machine.toml")))
    k_s, k_i = bearing_slopes("thrust", "z", parameters)
    assert (k_s, k_i) == pytest.approx((case.point.k_s, case.point.k_i), rel=1e-4)
    lower, static = (parameters[f"thrust.{name}_z"] for name in ("bias_current", "static_current"))
    assert (lower + static, lower) == pytest.approx(made.axis.coils, rel=1e-4)
    row = next(line for line in (made.folder / "README.md").read_text().splitlines() if line.startswith("| thrust |"))
    assert [float(cell.split()[0]) for cell in row.split("|")[5:7]] == pytest.approx([k_s, k_i], rel=1e-3)


@pytest.mark.parametrize(("tilt", "end"), [(90.0, "upper"), (-60.0, "lower"), (0.0, None)])
def test_axial_demand_ends_where_the_coil_with_less_current_does(tmp_path, quick, tilt, end):
    machine = new_machine(tmp_path / "fan", text_with_disc(), SPEED, tilt=math.radians(tilt))
    prepared = prepare_run(load_scenario(str(machine.folder / "levitation.toml")))
    limits = {side: abs(prepared.parameters[CONTROLLER].get(f"thrust.i_z.{side}", 0.0)) for side in ("lower", "upper")}
    whole = machine.sizes.bias_current
    least = whole - machine.sizes.mass * 9.81 * abs(math.sin(math.radians(tilt))) / machine.axis.point.k_i
    for side, limit in limits.items():
        if side == end:
            assert limit == pytest.approx(least, rel=1e-4)
        else:
            assert limit in (0.0, pytest.approx(whole))  # 0: that of the controller file
    k_s, k_i = bearing_slopes("thrust", "z", Machine(prepared).parameters[ACTUATOR])
    assert (k_s, k_i) == pytest.approx((machine.axis.point.k_s, machine.axis.point.k_i), rel=1e-4)


def test_radial_demands_on_five_axes_end_where_the_lower_coils_do(tmp_path, quick):
    magnet = MagnetData(60.0, 6e5, gap=0.4e-3)
    machine = new_machine(tmp_path / "fan", text_with_disc(), SPEED, magnet=magnet, gap=0.4e-3)
    prepared = prepare_run(load_scenario(str(machine.folder / "levitation.toml")))
    for bearing, load in machine.sizes.loads.items():
        least = 0.4e-3 * 6e5 / 60.0 - load / 60.0
        assert prepared.parameters[CONTROLLER][f"{bearing}.i_y.upper"] == pytest.approx(least, rel=1e-4)


def test_a_disc_of_the_drawing_gets_its_axial_bearing(tmp_path, quick, capsys):
    """It is at the part nearest to the disc, and its poles begin at the shaft's surface; the output says so."""
    machine = new_machine(tmp_path / "fan", text_with_disc(), SPEED, tilt=0.5 * math.pi)
    assert machine.assumed == ("bearings", "damping")
    stated = tomllib.loads((machine.folder / "machine.toml").read_text())["thrust_bearing"]
    assert stated["at"] == "wheel"
    check_machine(load_machine(machine.folder / "machine.toml"))
    diameter = diameter_at(load_rotor(str(machine.folder / "rotor.toml")), 0.19)
    _echo_axis(machine.axis, is_drawn=True)
    printed = capsys.readouterr().out
    for fact in ("wheel", f"from {500.0 * diameter:.3g} to", "[thrust_bearing]", "machine.toml", "117.7 N"):
        assert fact in printed


def test_axial_magnets_of_scenario_and_machine_file_that_differ_are_named(tmp_path, quick):
    """The coil without load has I_0 - W/K_i; with I_0 the scenario has another magnet than the machine file."""
    machine = new_machine(tmp_path / "fan", text_with_disc(), SPEED, tilt=0.5 * math.pi)
    file, scenario = machine.folder / "machine.toml", machine.folder / "levitation.toml"
    assert thrust_doubt(check_machine(load_machine(file))) == []
    _, lower = machine.axis.coils
    text = scenario.read_text()
    assert text.count(f"{lower:.6g} A") == 1
    scenario.write_text(text.replace(f"{lower:.6g} A", f"{machine.sizes.bias_current} A"))
    (doubt,) = thrust_doubt(check_machine(load_machine(file)))
    k_s, k_i = machine.axis.point.k_s, machine.axis.point.k_i
    assert_names(
        doubt, "117.7 N", f"{1e-6 * k_s:.4g} MN/m", f"{k_i:.4g} N/A", "thrust.bias_current_z", f"{lower:.4g} A"
    )


def test_it_falls_onto_its_face_and_is_lifted_off_again(made):
    signals = amb_cosim.run(str(made.folder / "relevitation.toml"), progress=False).signals
    t, force, z = (signals[name].values for name in ("time", f"{PLANT}.seat.f_n_mean", f"{PLANT}.thrust.z"))
    fallen = (t > 0.2) & (t < 0.25)
    weight = load_rotor(str(made.folder / "rotor.toml")).mass * 9.80665
    assert np.mean(force[fallen]) == pytest.approx(weight, rel=0.02)
    assert abs(z[-1]) < 0.1 * abs(z[fallen][-1])
