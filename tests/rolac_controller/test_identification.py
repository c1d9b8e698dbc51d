"""Identification inside the controller: receptance, duration, failures, and the stored table."""

import math

import numpy as np
import pytest
from controller_bench import Plant, synchronous
from rig import AXES, DONE, FAILED, SLOT_AFTER, identified_receptance, pack
from sampled_loop import zoh_response
from slow import slow_but_first

from rolac_controller.enumerations import (
    ADAPTING,
    CONTACT_OCCURRED,
    CURRENT_LIMITED,
    IDENTIFYING,
    ILL_CONDITIONED,
    NO_ERROR,
    NOT_STARTED,
    SLOT_BEFORE,
    SPEED_CHANGED,
    SWITCHED_OFF,
    VIBRATION_CHANGED,
    WAITING,
    WINDOW_LOST,
)
from rolac_controller.excitation import amplitude_at

pytestmark = pytest.mark.gate

SAMPLES, FREQUENCY = 20, 15.0
FAST = 1.0 / (SAMPLES * FREQUENCY)  # s, so few samples that a slot of 45 periods takes 900
SLOT = 45 * SAMPLES
SPEED = 2.0 * math.pi * FREQUENCY


@pytest.fixture
def tested(bench, discrete_plant):
    """A controller on a discrete plant with unbalance, by default at 20 samples per revolution and 15 Hz."""

    def make(constants=None, frequency=FREQUENCY, plant=None, **parameters):
        values = {"sample_time": FAST, **parameters}
        b = bench(constants, Omega=2.0 * math.pi * frequency, pid=False, **values)
        p = plant or discrete_plant()
        p.disturbance = lambda theta: 1e-5 * np.cos(theta + np.arange(8.0)) + 2e-5 * np.arange(8.0)
        p.run(b, 3 * SAMPLES)
        return b, p

    return make


def test_receptance_of_a_discrete_plant_is_identified(tested):
    b, plant = tested()
    b["identify"] = 1.0
    plant.run(b, 6 * SLOT + 1)
    assert (b["identification_state"], b["identification_error"]) == (DONE, NO_ERROR)
    expected = plant.receptance(b)
    assert np.abs(b.receptance() - expected).max() < 1e-9 * np.abs(expected).max()
    assert b["condition_number"] == pytest.approx(np.linalg.cond(expected), rel=1e-6)
    assert b["identification_speed"] == b["Omega"]


@pytest.mark.parametrize("frequency", slow_but_first([16.7, 16.0, 23.123]))
def test_fractional_samples_per_revolution_do_not_bias_the_receptance(tested, frequency):
    b, plant = tested(frequency=frequency, sample_time=1.0 / 2000.0)
    b["identify"] = 1.0
    plant.run(b, int(6 * math.ceil(3 * frequency + 1) / frequency * 2000))
    expected = plant.receptance(b)
    assert b["identification_state"] == DONE
    assert np.abs(b.receptance() - expected).max() < 1e-3 * np.abs(expected).max()


@pytest.mark.parametrize(("frequency", "slots"), [(5.0, 9.0), (10.0, 4.5), (15.0, 3.0), (35.0, 3.0)])
def test_identification_takes_six_slots_of_three_seconds_or_45_periods(tested, frequency, slots):
    """t_halt = 6 N_per/f with N_per = max(3 f, 45)."""
    h = 1.0 / (SAMPLES * frequency)
    b, plant = tested(frequency=frequency, sample_time=h)
    b["identify"] = 1.0
    stages, progress = [], []
    while b["identification_state"] != DONE:
        plant.run(b, 1)
        stages.append(b["identification_state"])
        progress.append(b["identification_progress"])
    lengths = [stages.count(stage) for stage in range(SLOT_BEFORE, SLOT_AFTER + 1)]
    assert np.array(lengths) * h == pytest.approx(np.full(6, slots), abs=1.01 * h)
    assert (len(stages) - 1) * h == pytest.approx(6.0 * slots, abs=1.01 * h)
    np.testing.assert_allclose(progress, np.arange(len(stages)) / (len(stages) - 1), atol=2.0 / len(stages))


def test_test_force_is_a_cos_theta_on_each_axis_in_turn(tested):
    b, plant = tested()
    b["identify"] = 1.0
    for axis in (None, 0, 1, 2, 3, None):
        plant.run(b, SLOT // 2)
        theta = b.theta - b["Omega"] * b.h
        expected = np.zeros(4)
        if axis is not None:
            expected[axis] = amplitude_at(FREQUENCY) * math.cos(theta)
        np.testing.assert_allclose(b.axis_forces(), expected, rtol=1e-9, atol=1e-9)
        plant.run(b, SLOT - SLOT // 2)


def test_force_scale_changes_the_next_test_force_and_not_the_receptance(tested):
    b, plant = tested(identification__force_scale=0.1)
    b["identify"] = 1.0
    for slots in (1.5, 1.0):
        plant.run(b, int(slots * SLOT))
        expected = 0.1 * amplitude_at(FREQUENCY) * math.cos(b.theta - b["Omega"] * b.h)
        assert b.axis_forces().sum() == pytest.approx(expected, rel=1e-9)
        b["identification.force_scale"] = 0.5
    plant.run(b, 6 * SLOT - int(2.5 * SLOT) + 1)
    assert b["identification_state"] == DONE
    np.testing.assert_allclose(b.receptance(), plant.receptance(b), rtol=1e-6, atol=1e-12)


def test_all_harmonics_are_identified_at_once(tested):
    orders = (1, 2, 4)
    b, plant = tested(
        identification__multi=1, harmonic2__order=2, harmonic3__order=4, harmonic2__power=0.5, harmonic3__power=2.0
    )
    b["identify"] = 1.0
    plant.run(b, 6 * SLOT + 1)
    assert b["identification_state"] == DONE
    for number, order in enumerate(orders, 1):
        b["shown_harmonic"] = number
        plant.run(b, 1)
        expected = plant.receptance(b, order)
        assert np.abs(b.receptance() - expected).max() < 1e-8 * np.abs(expected).max()
        assert b["condition_number"] == pytest.approx(np.linalg.cond(expected), rel=1e-6)
    assert b["table_rows"] == 3


def levitated_rotor():
    """A, B, C of two rigid masses in each direction, coupled, that the bearings' negative stiffness drives out."""
    mass = np.kron([[55.0, 6.0], [6.0, 42.0]], np.eye(2))
    k_s, gyroscopic = 2e6, 3.0 * np.kron(np.eye(2), [[0.0, 1.0], [-1.0, 0.0]])
    planes = np.array([[-0.9, 1.9], [0.0, 1.0], [1.0, 0.0], [1.9, -0.9]])  # at the planes, from MB1 and MB2
    inverse, none = np.linalg.inv(mass), np.zeros((4, 4))
    a = np.block([[none, np.eye(4)], [k_s * inverse, -inverse @ gyroscopic]])
    return a, np.vstack([none, inverse]), np.hstack([np.kron(planes, np.eye(2)), np.zeros((8, 4))])


def identified(bench, chain, **disturbance):
    """What is found on that rotor, and the receptance of its sampled loop."""
    h, rotor = 250e-6, levitated_rotor()
    values = {f"{b}.k_s_{a}": 2e6 for b, a in AXES} | chain
    b = bench(Omega=2.0 * math.pi * 40.0, **{name.replace(".", "__"): v for name, v in values.items()})
    plant = Plant.sampled(*rotor, h)
    vars(plant).update(disturbance)
    plant.run(b, 3000)
    b["identify"] = 1.0
    plant.run(b, 6 * 120 * 100 + 9)
    assert (b["identification_state"], b["identification_error"]) == (DONE, NO_ERROR)
    return b.receptance(), identified_receptance(zoh_response(*rotor, b["Omega"], h), b["Omega"], values)


CHAINS = {
    "ideal": {},
    "delay": {"chain.preset": 2, "chain.delay": 1},
    "filter": {"chain.preset": 2, "chain.filter": 1, "chain.cutoff": 800.0},
    "rig, without noise": {"chain.preset": 1, "chain.noise_rms": 0.0, "chain.adc_bits": 30, "chain.dac_bits": 30},
    "offset sensors": {"plane2.offset": 0.05, "plane3.offset": -0.06, "s5.scale": 0.97},
    "integral, filtered derivative": {"mb1.k_integral_x": 3e6, "mb2.k_integral_y": 5e6, "derivative_time": 2e-4},
    "direct gains": {"pid.direct": 1},
}


@pytest.mark.parametrize("chain", slow_but_first(CHAINS))
def test_levitated_rotor_gives_the_receptance_of_its_sampled_loop(bench, chain):
    """Hold, delay, filter, sensor offsets and PID as modelled in `closed_loop`, element by element."""
    result, model = identified(bench, CHAINS[chain], disturbance=lambda theta: 0.2 * synchronous(theta))
    assert np.abs(result - model).max() < 1e-6 * np.abs(model).max()


@pytest.mark.slow
def test_noise_of_the_rig_changes_the_receptance_by_less_than_a_percent(bench):
    result, model = identified(bench, {"chain.preset": 1})
    large = np.abs(model) > 0.1 * np.abs(model).max(axis=0)
    ratio = result[large] / model[large]
    assert 0.0 < np.abs(np.abs(ratio) - 1.0).max() < 0.01
    assert np.degrees(np.abs(np.angle(ratio))).max() < 1.0


def test_rolac_uses_the_identified_table(tested):
    """From an empty table to the least-squares optimum, in one run."""
    b, plant = tested(rolac__alpha=2.0)
    b["identify"] = 1.0
    b["rolac_enable"] = 1.0
    plant.run(b, 6 * SLOT + 1)
    assert b["table_rows"] == 1.0
    b["identify"] = 0.0
    plant.run(b, 40 * SLOT // 10)
    assert b["rolac_status"] == ADAPTING
    unbalance = 1e-5 * np.exp(1j * np.arange(8.0))
    expected = np.linalg.lstsq(plant.receptance(b), -unbalance, rcond=None)[0]
    np.testing.assert_allclose(b.forces(), expected, rtol=1e-5)


def test_forces_of_rolac_are_constant_and_do_not_enter_the_receptance(tested, discrete_plant):
    plant = discrete_plant()
    z = np.exp(1j * SPEED * FAST)
    exact = plant.c @ np.linalg.solve(z * np.eye(12) - plant.a, plant.b.astype(complex))
    b, plant = tested(pack([SPEED], [1.2 * exact]), plant=plant, rolac__alpha=1.0)
    b["rolac_enable"] = 1.0
    plant.run(b, 10 * SAMPLES)
    b["identify"] = 1.0
    plant.run(b, 1)
    held = b.forces()
    assert np.abs(held).min() > 0.1
    for _ in range(6):
        plant.run(b, SLOT - 2)
        assert b["rolac_status"] == IDENTIFYING
        assert b["rolac_active"] == 0.0
        np.testing.assert_array_equal(b.forces(), held)
        plant.run(b, 2)
    plant.run(b, 1)
    assert b["identification_state"] == DONE
    np.testing.assert_allclose(b.receptance(), exact, rtol=1e-6, atol=1e-13)
    assert b["rolac_status"] == ADAPTING
    assert b["table_rows"] == 1.0  # it replaces the initial row


def test_identification_waits_for_a_valid_window(bench, discrete_plant):
    b = bench(Omega=SPEED, pid=False, sample_time=FAST, identify=1.0)
    plant = discrete_plant()
    plant.run(b, SAMPLES)
    assert b["identification_state"] == WAITING
    plant.run(b, 1)
    assert b["identification_state"] == SLOT_BEFORE


def test_waiting_ends_with_the_request(bench):
    b = bench(Omega=1.0)
    b["identify"] = 1.0
    b.sample()
    assert b["identification_state"] == WAITING
    b["identify"] = 0.0
    b.sample()
    assert b["identification_state"] == NOT_STARTED


def test_a_request_starts_a_single_identification(tested):
    b, plant = tested()
    b["identify"] = 1.0
    plant.run(b, 8 * SLOT)
    assert b["identification_state"] == DONE
    b["identify"] = 0.0
    plant.run(b, 1)
    assert b["identification_state"] == DONE
    b["identify"] = 1.0
    plant.run(b, 1)
    assert b["identification_state"] == SLOT_BEFORE


def fails(b, plant, expected, before=2 * SLOT):
    """Check that the identification fails with a reason and leaves the table unchanged."""
    rows = b["table_rows"]
    for _ in range(6 * SLOT - before + 2):
        plant.run(b, 1)
        if b["identification_state"] == FAILED:
            break
    assert (b["identification_state"], b["identification_error"]) == (FAILED, expected)
    assert b["table_rows"] == rows
    assert np.abs(b.axis_forces()).max() < 1e-9
    return True


@pytest.mark.parametrize(
    ("reason", "variable", "value"),
    [
        (SWITCHED_OFF, "identify", 0.0),
        (SPEED_CHANGED, "Omega", 1.018 * SPEED),
        (CURRENT_LIMITED, "mb2.i_max_x", 0.01),
        (CONTACT_OCCURRED, "contact_state", 2.0),
    ],
)
def test_change_in_the_second_slot_ends_the_identification(tested, reason, variable, value):
    """That of the speed by less than a percent does not."""
    b, plant = tested(contact__source=2)
    b["identify"] = 1.0
    plant.run(b, 2 * SLOT)
    b["Omega"] = 1.009 * SPEED
    plant.run(b, 1)
    assert b["identification_state"] < DONE
    b[variable] = value
    assert fails(b, plant, reason)


@pytest.mark.parametrize("reason", [WINDOW_LOST, VIBRATION_CHANGED])
def test_jump_of_angle_or_unbalance_ends_the_identification(tested, reason):
    b, plant = tested()
    b["identify"] = 1.0
    plant.run(b, 2 * SLOT)
    if reason == WINDOW_LOST:
        b.theta += 2.0
    else:
        plant.disturbance = synchronous
    assert fails(b, plant, reason)


def test_dependent_forces_fail_with_a_large_condition_number(tested, discrete_plant):
    plant = discrete_plant()
    plant.b[:, 3] = plant.b[:, 2]
    b, plant = tested(plant=plant)
    b["identify"] = 1.0
    assert fails(b, plant, ILL_CONDITIONED, before=0)
    assert b["condition_number"] > 1e4


def test_identification_of_a_plant_without_response_fails(tested, discrete_plant):
    """The apparent response is no larger than the change without a force."""
    plant = discrete_plant()
    plant.b[:] = 0.0
    b, plant = tested(plant=plant)
    b["identify"] = 1.0
    assert fails(b, plant, VIBRATION_CHANGED, before=0)


def test_failure_is_cleared_at_the_next_request(tested):
    b, plant = tested()
    b["identify"] = 1.0
    plant.run(b, 2 * SLOT)
    b["identify"] = 0.0
    plant.run(b, 1)
    b["identify"] = 1.0
    plant.run(b, 6 * SLOT + 1)
    assert (b["identification_state"], b["identification_error"]) == (DONE, NO_ERROR)
