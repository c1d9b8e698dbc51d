"""The law itself: samples as python-control has them, the order of states, gains and sums, sizes from 0 to many."""

import warnings

import control
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from linear_bench import Bench, T, names, random_law, response

from amb_cosim import linear_controller
from linear_controller.matrices import SIZES


def signals(seed, count, n):
    return np.random.default_rng(seed).uniform(-0.1, 0.1, size=(count, n))


def controller(law, *arguments, **options):
    p, m = law.noutputs, law.ninputs
    return linear_controller(law, names("y", m), names("u", p), T, *arguments, **options)


@settings(max_examples=40)
@given(
    st.integers(0, 10**6),
    st.integers(0, 9),
    st.integers(1, 4),
    st.integers(1, 4),
    st.sampled_from(["tustin", "zoh", "foh", "euler", "backward_diff", "impulse"]),
)
def test_samples_agree_with_python_control(seed, n_states, n_demands, n_signals, method):
    law = random_law(seed, n_states, n_demands, n_signals)
    if method == "impulse":  # the impulse-invariant method has no direct feedthrough
        law = control.ss(law.A, law.B, law.C, 0.0 * law.D)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        sampled = law.sample(T, method) if n_states else control.ss([], [], [], law.D, T)
    values = signals(seed, 60, n_signals)
    expected = response(sampled, values)
    result = Bench(controller(law, method=method, allow_unstable=True), start_at_rest=0).run(values)
    np.testing.assert_allclose(result, expected, rtol=0.0, atol=1e-12 * max(1.0, np.abs(expected).max()))


@given(st.floats(100.0, 25_000.0), st.integers(0, 1000))
def test_prewarped_response_is_exact_at_its_frequency(omega, seed):
    law = random_law(seed, 4, 1, 1)
    retained = controller(law, method="tustin", prewarp=omega).state_space()
    expected = law(1j * omega)
    assert abs(retained(np.exp(1j * omega * T)) - expected) < 1e-9 * max(abs(expected), 1.0)


def test_matched_poles_are_where_the_sample_time_puts_them():
    law = control.tf([1.0, 500.0], [1.0, 300.0, 2e6])
    result = linear_controller(law, ["y"], ["u"], T, method="matched").state_space()
    np.testing.assert_allclose(sorted(result.poles(), key=abs), sorted(np.exp(law.poles() * T), key=abs), rtol=1e-9)
    assert result(1.0).real == pytest.approx(law(0.0).real, rel=1e-9)


def test_a_lag_much_faster_than_the_sample_needs_no_warning():
    """exp(-100) = 3.7e-44 beside an integrator: balanced, the states differ by a factor of 1e43."""
    law = control.series(control.ss(control.tf([1.0, 10.0], [1.0, 0.0])), control.ss(control.tf([1.0], [T / 100, 1.0])))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        made = controller(law, method="zoh")
        values = signals(2, 30, 1)
        result = Bench(made, start_at_rest=0).run(values)
    assert sorted(np.abs(made.state_space().poles())) == pytest.approx([np.exp(-100.0), 1.0], rel=1e-9)
    np.testing.assert_allclose(result, response(law.sample(T, "zoh"), values), rtol=0.0, atol=1e-12)


def test_step_response_of_an_integrator_is_a_ramp():
    ramp = Bench(linear_controller(([0.0, 1.0], [1.0, 0.0]), ["y"], ["u"], T, method="euler")).run(
        np.full((50, 1), 0.1)
    )
    np.testing.assert_allclose(ramp[:, 0], 0.1 * T * np.arange(50), rtol=1e-12)


@pytest.mark.parametrize("n_groups", [1, 3])
def test_states_are_shown_in_the_order_of_the_law(n_groups):
    """Interleaved groups of uncoupled states: the blocks are stored in another order."""
    rng = np.random.default_rng(3)
    n = 4 * n_groups
    mix = rng.permutation(n)
    A = np.kron(np.eye(n_groups), rng.normal(size=(4, 4)) / 8.0)[np.ix_(mix, mix)]
    law = control.ss(A, rng.normal(size=(n, 2)), rng.normal(size=(3, n)), rng.normal(size=(3, 2)), T)
    bench, x = Bench(controller(law), start_at_rest=0), np.zeros(n)
    for row in signals(5, 20, 2):
        demands = bench.step(row)
        np.testing.assert_allclose(demands, law.C @ x + law.D @ row, atol=1e-14)
        x = law.A @ x + law.B @ row
        np.testing.assert_allclose(bench.states(), x, atol=1e-14)


def test_a_bank_of_notches_is_stored_as_blocks():
    """Eight axes with six notches each have 12 states an axis: a twelfth of the products of a full matrix."""
    axis = control.ss(np.diag(np.full(11, 0.1), 1) + 0.5 * np.eye(12), np.ones((12, 1)), np.ones((1, 12)), 1.0, T)
    alone = control.ss(
        0.5 * np.eye(96), np.kron(np.eye(8), np.ones((12, 1))), np.kron(np.eye(8), np.ones((1, 12))), np.eye(8), T
    )
    full = control.ss(np.full((96, 96), 1e-3), np.ones((96, 8)), np.ones((8, 96)), np.ones((8, 8)), T)
    costs = []
    for law in (control.append(*[axis] * 8), alone, full):
        _, constants = controller(law).model_and_constants
        costs.append(constants[: len(SIZES.names)].view(SIZES)[0].n_values)
    assert max(costs[:2]) < costs[2] / 3.0


def test_gain_offset_and_feedforward_of_each_demand_add_up():
    bench = Bench(
        linear_controller(np.diag([2.0, 3.0]), ["a", "b"], ["u", "v"], T, gains=[1.0, 0.5], offsets=[0.1, 0.0])
    )
    np.testing.assert_allclose(bench.step([0.1, 0.1], v__feedforward=7.0), [0.3, 7.15], rtol=1e-14)
    np.testing.assert_allclose(bench.step([0.1, 0.1], u__gain=-1.0), [-0.1, 7.15], rtol=1e-14)


def test_state_space_has_the_gains_of_the_demands():
    made = controller(random_law(5, 3, 2, 2), gains=[-2.0, 0.5])
    values = signals(1, 30, 2)
    expected = response(made.state_space(), values)
    np.testing.assert_allclose(Bench(made, start_at_rest=0).run(values), expected, rtol=0.0, atol=1e-12)


def test_setpoint_is_subtracted_from_the_signal():
    bench = Bench(linear_controller(2.0, ["y"], ["u"], T))
    assert bench.step([0.03], y__setpoint=0.03)[0] == 0.0
    assert bench.step([0.03], y__setpoint=0.01)[0] == pytest.approx(0.04, rel=1e-14)


def test_filters_start_at_rest_and_integrators_at_zero():
    low_pass, integrator = control.tf([1.0], [1e-3, 1.0]), control.tf([1.0], [1.0, 0.0])
    law = control.append(control.ss(low_pass), control.ss(integrator))
    bench = Bench(controller(law, method="zoh"), signals=[0.05, 0.05])
    np.testing.assert_allclose(bench.demands(), [0.05, 0.0], atol=1e-14)
    result = bench.run(np.full((3, 2), 0.05))
    np.testing.assert_allclose(result[:, 0], 0.05, rtol=1e-12)
    np.testing.assert_allclose(result[:, 1], 0.05 * T * np.arange(3), atol=1e-14)


def test_sample_instants_do_not_depend_on_the_step():
    law = random_law(11, 4, 2, 2)
    values = signals(1, 40, 2)
    expected = Bench(controller(law)).run(values)
    fine, result = Bench(controller(law)), []
    for n in range(4 * len(values)):
        fine.read(values[n // 4])
        fine.instance.step(n * T / 4, T / 4)
        result.append(fine.demands())
    np.testing.assert_array_equal(result[::4], expected)
    np.testing.assert_array_equal(result[3::4], expected)
