"""A first design that stands: its controller of five axes levitates it, and it lands on a face."""

import cmath
import math

import numpy as np
import pytest

import amb_cosim
from amb_analysis.machine.machine import Machine
from amb_assessment.assessment.analyses import axial
from amb_assessment.assessment.engine.assess import check_machine
from amb_assessment.assessment.format.machine_file import load_machine
from amb_assessment.first_design.files import new_machine
from amb_assessment.first_design.levitation import TRIP
from amb_assessment.first_design.rotor_text import plain_shaft
from amb_cosim.controllers.linear_controller import linear_controller
from amb_cosim.cosim.system.values import RPM
from amb_cosim.results.component_names import PLANT
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.scenario import load_scenario
from rotor_analysis.rotor_file import load_rotor

SPEED = 20000.0 / RPM


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    folder = tmp_path_factory.mktemp("new") / "stand"
    text = plain_shaft("stand", 12.0, 0.4, SPEED)
    return new_machine(folder, text, SPEED, tilt=0.5 * math.pi, thrust_disc=True)


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


def test_it_falls_onto_its_face_and_is_lifted_off_again(made):
    signals = amb_cosim.run(str(made.folder / "relevitation.toml"), progress=False).signals
    t, force, z = (signals[name].values for name in ("time", f"{PLANT}.seat.f_n_mean", f"{PLANT}.thrust.z"))
    fallen = (t > 0.2) & (t < 0.25)
    weight = load_rotor(str(made.folder / "rotor.toml")).mass * 9.80665
    assert np.mean(force[fallen]) == pytest.approx(weight, rel=0.02)
    assert abs(z[-1]) < 0.1 * abs(z[fallen][-1])
