"""From displacements to readings: position, scale, noise, quantisation, and every fault."""

import math

import numpy as np
import pytest
from rig import CONTROLLER, NO_TABLE, SENSOR_NAMES, SIZES

from rolac_controller.records import inputs_of, parameters_of
from rolac_controller.sensors import measure
from signal_chain.readings import sensor_memory_of, sensor_memory_size

INTERFACE = CONTROLLER.interface
N_SENSORS = 8

LSB = 20.0 / 65536.0 / 8000.0  # m
POSITIONS = np.array([1.948, 1.321, 0.624, 0.0])


class Chain:
    """The signal chain alone; parameters and inputs by name with `__` for the dot."""

    def __init__(self, **values):
        self.values = INTERFACE.start.copy()
        self.parameters = parameters_of(self.values[: INTERFACE.n_parameters], NO_TABLE, SIZES)
        self.inputs = inputs_of(self.values[INTERFACE.n_parameters :], SIZES)
        self.memory = sensor_memory_of(np.zeros(sensor_memory_size(N_SENSORS)), 0, N_SENSORS)
        self.started = False
        self.set(**values)

    def set(self, **values):
        for name, value in values.items():
            self.values[INTERFACE.position[name.replace("__", ".")]] = value

    def read(self, displacements=None):
        if displacements is not None:
            self.set(**dict(zip(SENSOR_NAMES, displacements, strict=True)))
        measured = np.zeros(N_SENSORS)
        self.beyond_range = measure(self.parameters, self.inputs, self.memory, self.started, True, measured)
        self.started = True
        return measured

    def record(self, count, displacements=None):
        return np.array([self.read(displacements) for _ in range(count)])


def custom(**values):
    return Chain(chain__preset=2, **values)


X = 1e-4 * np.array([1.0, -2.0, 3.0, -4.0, 5.0, -6.0, 7.0, -8.0]) + 1.234567e-9


@pytest.mark.parametrize("chain", [{"noise": 1, "adc": 1, "filter": 1}, {"preset": 2}])
def test_ideal_chain_and_one_without_effects_read_the_displacement(chain):
    np.testing.assert_array_equal(Chain(**{f"chain__{name}": value for name, value in chain.items()}).read(X), X)


def test_rig_chain_has_all_effects_regardless_of_switches():
    rig, all_on = Chain(chain__preset=1), custom(chain__noise=1, chain__adc=1, chain__filter=1)
    np.testing.assert_array_equal(rig.record(20, X), all_on.record(20, X))


def test_adc_saturates_at_1_25_mm():
    read = custom(chain__adc=1).read(np.tile([5e-3, -5e-3], 4))
    np.testing.assert_allclose(read, np.tile([1.25e-3 - LSB, -1.25e-3], 4), rtol=1e-12)


@pytest.mark.parametrize(("largest", "limited"), [(1.24e-3, False), (1.26e-3, True), (-1.26e-3, True)])
def test_the_adc_flags_a_displacement_beyond_its_range(largest, limited):
    chain = custom(chain__adc=1)
    chain.read([0.0, largest, *[0.0] * 6])
    assert chain.beyond_range == limited
    ideal = custom()
    ideal.read([0.0, largest, *[0.0] * 6])
    assert not ideal.beyond_range


def test_noise_has_the_stated_deviation_and_is_white_and_independent():
    noise = custom(chain__noise=1, chain__noise_rms=2e-6).record(20_000, X) - X
    np.testing.assert_allclose(noise.std(axis=0), 2e-6, rtol=0.03)
    assert np.abs(noise.mean(axis=0)).max() < 4.5 * 2e-6 / math.sqrt(20_000)
    correlation = np.corrcoef(noise.T) - np.eye(8)
    assert np.abs(correlation).max() < 4.5 / math.sqrt(20_000)
    lagged = [np.corrcoef(noise[1:, s], noise[:-1, s])[0, 1] for s in range(8)]
    assert np.abs(lagged).max() < 4.5 / math.sqrt(20_000)


def test_noise_depends_on_the_seed_alone():
    def noise(seed):
        return custom(chain__noise=1, chain__seed=seed).record(100, X)

    np.testing.assert_array_equal(noise(4), noise(4))
    assert np.abs(np.corrcoef(noise(4).T[0], noise(5).T[0])[0, 1]) < 0.4


def test_scale_multiplies_a_reading():
    chain = Chain(s3__scale=1.02)
    np.testing.assert_allclose(chain.read(X) / X, [1, 1, 1.02, 1, 1, 1, 1, 1], rtol=1e-15)


@pytest.mark.parametrize("power", [0, 1, 2, 3])
def test_sensors_beside_their_planes_read_a_bent_shaft_to_third_order(power):
    offsets = np.array([-0.03, 0.05, -0.04, 0.02])
    chain = Chain(**{f"plane{k + 1}__offset": d for k, d in enumerate(offsets)})
    deflection = np.repeat(1e-4 * POSITIONS**power, 2) * np.tile([1.0, -0.5], 4)
    expected = np.repeat(1e-4 * (POSITIONS + offsets) ** power, 2) * np.tile([1.0, -0.5], 4)
    np.testing.assert_allclose(chain.read(deflection), expected, rtol=1e-12, atol=1e-18)


@pytest.mark.parametrize("sensor", range(8))
@pytest.mark.parametrize(
    ("fault", "value", "shown"), [("dead", 1.0, lambda x: 0.0), ("stuck", 1.0, lambda x: x), ("offset", 2e-5, None)]
)
def test_fault_affects_one_sensor_until_it_recovers(fault, value, shown, sensor):
    """A dead sensor reads 0, a stuck one its last value, and one with an offset adds it."""
    chain, name = Chain(), f"s{sensor + 1}__fault_{fault}"
    chain.read(X)
    chain.set(**{name: value})
    for factor in (2.0, 3.0):
        expected = factor * X
        expected[sensor] = shown(X[sensor]) if shown else expected[sensor] + value
        np.testing.assert_allclose(chain.read(factor * X), expected, rtol=1e-15)
    chain.set(**{name: 0.0})
    np.testing.assert_array_equal(chain.read(4.0 * X), 4.0 * X)


@pytest.mark.parametrize("sensor", range(8))
def test_burst_of_noise_affects_one_sensor_and_ends(sensor):
    chain = Chain(**{f"s{sensor + 1}__fault_noise": 1e-5})
    deviation = (chain.record(4000, X) - X).std(axis=0)
    assert deviation[sensor] == pytest.approx(1e-5, rel=0.06)
    assert not np.delete(deviation, sensor).any()
    chain.set(**{f"s{sensor + 1}__fault_noise": 0.0})
    np.testing.assert_array_equal(chain.read(X), X)


def test_noise_and_a_burst_add_as_independent_signals():
    chain = custom(chain__noise=1, chain__noise_rms=3e-6, s1__fault_noise=4e-6)
    assert (chain.record(8000, X) - X).std(axis=0)[0] == pytest.approx(5e-6, rel=0.04)


def test_sensor_that_starts_stuck_shows_its_first_displacement():
    chain = Chain(s2__fault_stuck=1.0)
    chain.read(X)
    assert chain.read(2.0 * X)[1] == X[1]


def test_filter_starts_at_rest_at_the_first_reading():
    np.testing.assert_allclose(custom(chain__filter=1).record(10, X), np.tile(X, (10, 1)), rtol=1e-13)
