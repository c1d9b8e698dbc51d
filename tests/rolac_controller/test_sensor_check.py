"""Sensors that do not change: found, named, and ROLAC switched off."""

import numpy as np
import pytest
from controller_bench import SAMPLES
from controller_bench import synchronous as signal

from rolac_controller.enumerations import ADAPTING, SENSOR_SUSPECT


@pytest.mark.parametrize("fault", ["fault_dead", "fault_stuck"])
@pytest.mark.parametrize("sensor", [1, 4, 8])
def test_constant_reading_for_a_revolution_disables_rolac_alone(adapting, sensor, fault):
    b = adapting(rolac__fade=1e4)
    b[f"s{sensor}.{fault}"] = 1.0
    b.follow(signal, SAMPLES - 1)
    assert b["rolac_status"] == ADAPTING
    b.follow(signal, 3)
    assert (b["rolac_status"], b["suspect_sensor"], b["rolac_active"]) == (SENSOR_SUSPECT, sensor, 0.0)
    assert not b.forces().any()
    b[f"s{sensor}.{fault}"] = 0.0
    b.follow(signal, 2)
    assert (b["rolac_status"], b["suspect_sensor"]) == (ADAPTING, 0.0)


def test_first_of_several_suspect_sensors_is_named(adapting):
    b = adapting()
    for sensor in (7, 3):
        b[f"s{sensor}.fault_dead"] = 1.0
    b.follow(signal, SAMPLES + 2)
    assert b["suspect_sensor"] == 3


def test_check_can_be_switched_off_and_still_names_the_sensor(adapting):
    b = adapting(rolac__check_sensors=0)
    b["s2.fault_dead"] = 1.0
    b.follow(signal, SAMPLES + 2)
    assert (b["rolac_status"], b["suspect_sensor"]) == (ADAPTING, 2)


def test_rotor_without_any_vibration_is_no_reason_for_suspicion(adapting):
    b = adapting()
    b.follow(lambda theta: np.zeros(8), 3 * SAMPLES)
    assert (b["rolac_status"], b["suspect_sensor"]) == (ADAPTING, 0.0)


@pytest.mark.parametrize("fault", ["fault_offset", "fault_noise"])
def test_sensor_that_moves_is_not_suspected(adapting, fault):
    b = adapting()
    b[f"s5.{fault}"] = 1e-4
    b.follow(signal, 3 * SAMPLES)
    assert (b["rolac_status"], b["suspect_sensor"]) == (ADAPTING, 0.0)


def test_offset_reaches_the_pid_and_not_the_synchronous_signal(adapting):
    b = adapting()
    b["s5.fault_offset"] = 1e-5
    b.follow(signal, 2 * SAMPLES)
    np.testing.assert_allclose(np.abs(b.components()), 1e-4, rtol=1e-9)
    sound = adapting()
    sound.follow(signal, 2 * SAMPLES)
    assert b["mb1.i_x"] - sound["mb1.i_x"] == pytest.approx(-(1e6 + b["mb1.k_s_x"]) * 1e-5 / b["mb1.k_i_x"], rel=1e-4)
