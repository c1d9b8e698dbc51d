"""Matrices that depend on the speed."""

import control
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from linear_bench import Bench, T, names

from amb_cosim import linear_controller


def notch(omega):
    """A notch of damping 0.1 at a speed (rad/s)."""
    return control.tf([1.0, 0.0, omega**2], [1.0, 0.2 * omega, omega**2])


TABLE = {100.0: notch(100.0), 200.0: notch(200.0), 400.0: notch(400.0)}


def table(**options):
    return linear_controller(TABLE, ["y"], ["u"], T, method="zoh", **options)


@pytest.mark.parametrize("speed", [100.0, 200.0, 400.0])
def test_law_at_a_speed_of_the_table_is_exact(speed):
    given_signal = np.random.default_rng(1).uniform(-0.1, 0.1, size=(50, 1))
    result = Bench(table(), Omega=speed).run(given_signal)
    alone = Bench(linear_controller(TABLE[speed], ["y"], ["u"], T, method="zoh")).run(given_signal)
    np.testing.assert_allclose(result, alone, rtol=0.0, atol=1e-14)


@pytest.mark.parametrize("speed", [100.0, 150.0, 200.0, 300.0])
def test_law_between_two_points_has_the_mean_of_their_matrices(speed):
    controller = table()
    laws, speeds = controller.laws, list(controller.laws)
    mean = {
        name: np.stack(
            [
                np.interp(speed, speeds, [getattr(law, name)[i, j] for law in laws.values()])
                for i in range(getattr(laws[100.0], name).shape[0])
                for j in range(getattr(laws[100.0], name).shape[1])
            ]
        ).reshape(getattr(laws[100.0], name).shape)
        for name in "ABCD"
    }
    between = linear_controller(tuple(mean.values()), ["y"], ["u"], T, sampled_arrays=True)
    given_signal = np.random.default_rng(1).uniform(-0.1, 0.1, size=(50, 1))
    result = Bench(controller, Omega=speed, start_at_rest=0).run(given_signal)
    np.testing.assert_allclose(result, Bench(between, start_at_rest=0).run(given_signal), rtol=0.0, atol=1e-12)


@settings(max_examples=30)
@given(st.sampled_from([100.0, 200.0, 400.0]), st.integers(0, 1000))
def test_passing_a_point_of_the_table_makes_no_jump(point, seed):
    """A hair before and behind it, with the same states, the demand is the same."""
    signals = np.random.default_rng(seed).uniform(-0.1, 0.1, size=(30, 1))
    result = []
    for speed in (point * (1.0 - 1e-12), point, point * (1.0 + 1e-12)):
        bench = Bench(table(), Omega=0.9 * point)
        bench.run(signals)
        result.append([bench.step([0.01], Omega=speed)[0], *bench.states()])
    np.testing.assert_allclose(result, np.tile(result[1], (3, 1)), rtol=1e-9, atol=1e-12)


def test_demand_changes_smoothly_in_a_run_up_through_the_table():
    bench = Bench(table(), Omega=50.0)
    bench.run(np.full((200, 1), 0.01))
    demands = [bench.step([0.01], Omega=speed)[0] for speed in np.linspace(50.0, 500.0, 20_000)]
    assert np.abs(np.diff(demands)).max() < 5e-5


def test_beyond_the_table_the_nearest_law_applies_with_a_warning():
    signals = np.random.default_rng(1).uniform(-0.1, 0.1, size=(20, 1))
    for beyond, nearest in ((20.0, 100.0), (900.0, 400.0)):
        bench, at = Bench(table(), Omega=beyond), Bench(table(), Omega=nearest)
        np.testing.assert_array_equal(bench.run(signals), at.run(signals))
        assert (bench.instance["speed_extrapolated"], at.instance["speed_extrapolated"]) == (1.0, 0.0)


def test_a_single_law_has_no_range_of_speeds():
    bench = Bench(linear_controller(1.0, ["y"], ["u"], T), Omega=5000.0)
    bench.step([0.0])
    assert bench.instance["speed_extrapolated"] == 0.0


def test_integrators_keep_their_value_when_the_speed_changes():
    """Gains over speed with a common integrator, whose state is not changed."""
    laws = {speed: control.tf([gain, 100.0 * gain], [1.0, 0.0]) for speed, gain in ((100.0, 1.0), (300.0, 2.0))}
    bench = Bench(linear_controller(laws, names("y", 1), names("u", 1), T), Omega=100.0)
    bench.run(np.full((100, 1), 0.01))
    held = bench.states()
    bench.step([0.0], Omega=300.0)
    np.testing.assert_allclose(bench.states(), held, rtol=1e-12)


def test_speeds_may_come_in_any_order():
    turned = dict(reversed(TABLE.items()))
    a, b = (linear_controller(t, ["y"], ["u"], T).model_and_constants[1] for t in (TABLE, turned))
    np.testing.assert_array_equal(a, b)
