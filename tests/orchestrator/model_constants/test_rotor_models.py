"""Actuator and controller of a rotor: names and places of its file, and a table of its model."""

from dataclasses import replace

import numpy as np
import pytest
from machines import machine

from amb_cosim.model_constants.controller_data import no_table
from amb_cosim.model_constants.plant_data import plant_structure
from amb_cosim.model_constants.receptance_file import empty_table
from amb_cosim.model_constants.rotor_models import actuator, control_loop, controller
from fmi_export.model import Instance
from rotor_analysis.packaged_rotors import packaged_rotors
from rotor_analysis.parts import Sensor
from rotor_analysis.rotor_file import load_rotor
from tests.support.messages import raises_naming


def own_polar_inertia(rotor):
    """Return the polar inertias of bodies and layers, rho int 2 I dz, by Gauss's rule, which is exact for cones."""
    points, weights = np.polynomial.legendre.leggauss(3)
    layers = [layer for element in rotor.elements for layer in element]
    local = [np.dot(weights, [e.second_moment_at(0.5 + 0.5 * s) for s in points]) for e in layers]
    shaft = sum(e.material.density * e.length * moment for e, moment in zip(layers, local, strict=True))
    return shaft + sum(body.polar_inertia for body in rotor.bodies)


@pytest.mark.parametrize("name", packaged_rotors())
def test_spin_inertia_is_the_sum_of_the_polar_inertias_of_the_parts(name):
    rotor = load_rotor(name)
    _, planes = plant_structure(rotor)
    assert planes.polar_inertia == pytest.approx(own_polar_inertia(rotor), rel=1e-12)


def test_rig_measures_each_bearing_in_its_plane():
    loop = control_loop(load_rotor())
    assert [tuple(axis) for axis in loop.axes] == [
        *(("mb1", "x", "s5"), ("mb1", "y", "s6"), ("mb2", "x", "s3"), ("mb2", "y", "s4"))
    ]
    assert [plane.position for plane in loop.planes] == [1.948, 1.321, 0.624, 0.0]


def test_nearest_plane_closes_the_loop_of_a_bearing():
    loop = control_loop(machine())
    assert loop.feedback == ("probe1", "probe2", "probe3")
    assert loop.sensor_names == ("probe1.x", "probe1.y", "probe2.x", "probe2.y", "probe3.x", "probe3.y")
    assert loop.shape == (6, 6)


def test_two_bearings_next_to_one_plane_are_refused():
    rotor = machine(sensors=(Sensor("far", 1), Sensor("between", 18), Sensor("beyond", 25)))
    rotor = replace(rotor, sensors=tuple(s for s in rotor.sensors if s.name != "beyond"))
    with raises_naming(ValueError, "'mb3'", "'between'"):
        control_loop(rotor)


def test_rotor_without_sensors_is_refused_with_its_bearing():
    with raises_naming(ValueError, "'mb1'"):
        control_loop(machine(sensors=()))


def test_both_models_of_a_machine_run_with_its_names():
    rotor = machine()
    magnets, control = Instance(*actuator(rotor)), Instance(*controller(rotor))
    control["probe2.x"] = 1e-5
    control.initialise()
    assert control["mb2.i_x"] < 0.0 == control["mb1.i_x"] == control["mb3.i_x"]
    magnets["mb2.i_x"] = control["mb2.i_x"]
    magnets.initialise()
    assert magnets["mb2.f_x"] < 0.0 == magnets["mb3.f_x"]


def test_table_of_different_sensors_is_refused(tmp_path):
    rng = np.random.default_rng(3)
    loop, rig = control_loop(machine()), control_loop()
    table = empty_table("machine", loop).updated(100.0, rng.normal(size=(6, 6)) + 1j * rng.normal(size=(6, 6)))
    with raises_naming(ValueError, "probe1.x, probe1.y", "s1, s2"):
        table.constants(rig)
    renamed = replace(loop, bearings=("mb1", "mb2", "outboard"))
    with raises_naming(ValueError, "mb1.x", "mb3.y", "outboard.y"):
        table.constants(renamed)
    assert table.constants(loop).size == no_table(loop).size + 2 + 4 * 36
