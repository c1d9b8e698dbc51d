"""Limited demands and anti-windup; switching on, resetting; delays."""

import control
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from linear_bench import Bench, T, names, random_law

from amb_cosim import linear_controller
from amb_cosim.controllers.laws import Law
from amb_cosim.controllers.slow_modes import slow_modes
from fmi_export.model import Fault
from tests.support.messages import raises_naming

PI = control.ss(control.tf([100.0, 5e4], [1.0, 0.0]))  # 100 + 5e4/s
PID = control.ss(control.tf([100.0, 5e4], [1.0, 0.0]) + control.tf([0.2, 0.0], [2e-4, 1.0]))


def single_axis(law, **options):
    return linear_controller(law, ["y"], ["u"], T, **options)


def test_demand_stays_within_its_limits_and_is_flagged():
    bench = Bench(single_axis(1e3, limits=(-5.0, 3.0)))
    for signal, expected in ((0.1, 3.0), (-0.1, -5.0), (0.001, 1.0)):
        assert bench.step([signal])[0] == expected
        assert bench.instance["demand_limited"] == (abs(signal) > 0.01)


@pytest.mark.parametrize("law", [PI, PID])
def test_integrator_does_not_wind_up_while_the_demand_is_limited(law):
    """After a second at the limit the demand leaves it within twice slow_time of the sign's change, not a second."""
    bench = Bench(single_axis(law, limits=(-1.0, 1.0), slow_time=0.01))
    bench.run(np.full((10_000, 1), 0.05))
    after = bench.run(np.full((200, 1), -0.002))[:, 0]
    assert after[-1] < 0.9
    free = Bench(single_axis(law))
    free.run(np.full((10_000, 1), 0.05))
    assert free.run(np.full((200, 1), -0.002))[-1, 0] > 1000.0, "without limits the integral is what it is"


def test_filters_follow_their_signals_while_the_demand_is_limited():
    """The derivative's filter of a limited controller is that of an unlimited one, to the last bit."""
    law = control.append(PI, control.ss(control.tf([0.2, 0.0], [2e-4, 1.0])))
    rng = np.random.default_rng(2)
    limited, free = (
        Bench(linear_controller(law, names("y", 2), names("u", 2), T, limits=limits)) for limits in ((-0.1, 0.1), None)
    )
    for row in rng.uniform(-0.05, 0.05, size=(50, 2)):
        limited.step(row)
        free.step(row)
    assert limited.states()[1] == free.states()[1]
    assert limited.states()[0] != free.states()[0]


@pytest.mark.parametrize("ratio", [1e-9, 1e-6, 1.0, 1e9])
def test_units_of_a_state_do_not_change_how_its_integrator_is_limited(ratio):
    """Two independent integrators, of states whose sizes differ: both decay by alpha^2 in a sample."""
    alpha = np.exp(-T / 0.02)
    law = Law(np.eye(2), np.diag([1.0 / ratio, 1.0]), np.diag([ratio, 1.0]), np.zeros((2, 2)), T)
    tracking = slow_modes(law, T, 0.02).tracking
    np.testing.assert_allclose(np.diagonal(law.A - tracking @ law.C), alpha**2, rtol=1e-12)
    assert tracking[0, 1] == tracking[1, 0] == 0.0


@given(st.integers(0, 10**6), st.integers(1, 3), st.integers(0, 4))
def test_slow_modes_of_a_limited_law_are_reflected(seed, n_slow, n_fast):
    """A_s - W L C_s has alpha^2 / conj(lambda) for each slow mode, and fast modes stay where they are."""
    rng = np.random.default_rng(seed)
    n, slow_time = n_slow + n_fast, 0.02
    alpha = np.exp(-T / slow_time)
    modes = np.concatenate([1.0 - 0.002 * rng.uniform(size=n_slow), rng.uniform(-0.9, 0.9, size=n_fast)])
    V = np.linalg.qr(rng.normal(size=(n, n)))[0] + 0.1 * rng.normal(size=(n, n))
    A = V @ np.diag(modes) @ np.linalg.inv(V)
    law = Law(A, rng.normal(size=(n, 2)), rng.normal(size=(3, n)), rng.normal(size=(3, 2)), T)
    result = slow_modes(law, T, slow_time)
    expected = np.where(modes >= alpha, alpha**2 / modes, modes)
    closed = np.linalg.eigvals(A - result.tracking @ law.C)
    np.testing.assert_allclose(np.sort(closed.real), np.sort(expected), atol=1e-6)
    np.testing.assert_allclose(result.slow @ result.slow, result.slow, atol=1e-7)
    np.testing.assert_allclose(A @ result.slow, result.slow @ A, atol=1e-7)


@given(st.integers(0, 10**6))
def test_rest_states_are_fixed_points_of_the_law(seed):
    law = random_law(seed, 5, 2, 2).sample(T, "zoh")
    given_law = Law(law.A, law.B, law.C, law.D, T)
    rest = slow_modes(given_law, T, 1e6).rest
    np.testing.assert_allclose(law.A @ rest + law.B, rest, atol=1e-9 * np.abs(rest).max())


def test_a_law_that_is_off_demands_its_offset_and_feedforward():
    bench = Bench(single_axis(PI, offsets=0.5), enable=0)
    assert bench.step([0.01])[0] == 0.5
    assert bench.step([0.01], u__feedforward=-0.2)[0] == pytest.approx(0.3)


def test_switching_on_is_bumpless_and_the_law_takes_over():
    bench, always = Bench(single_axis(PID, offsets=0.5), enable=0), Bench(single_axis(PID))
    before = bench.run(np.full((100, 1), 0.01))
    first = bench.step([0.01], enable=1)
    assert first[0] == pytest.approx(before[-1, 0], abs=1e-14)
    demands = np.array([first, *bench.run(np.full((3000, 1), 0.01))])[:, 0]
    assert np.abs(np.diff(demands)).max() < 0.07, "an integral of 0.05 A a sample, and the jump within 0.01 s"
    rates = [np.diff(b.run(np.full((5, 1), 0.01))[:, 0])[-1] for b in (bench, always)]
    assert rates[0] == pytest.approx(rates[1], rel=1e-6)


def test_without_a_transfer_time_the_law_acts_at_once():
    bench = Bench(single_axis(100.0), enable=0, transfer_time=0)
    bench.step([0.01])
    assert bench.step([0.01], enable=1)[0] == pytest.approx(1.0)


def test_a_law_switched_on_has_its_full_gain_from_the_first_sample():
    """Only the jump fades: a change of the signal has the full gain at once."""
    bench = Bench(single_axis(100.0), enable=0)
    bench.step([0.01])
    first = bench.step([0.01], enable=1)[0]
    jump = first - 1.0
    second = bench.step([0.02])[0]
    assert second == pytest.approx(2.0 + jump * np.exp(-T / 0.01), rel=1e-12)


def test_reset_zeroes_integrators_and_leaves_filters():
    law = control.append(PI, control.ss(control.tf([1.0], [1e-3, 1.0])))
    bench = Bench(linear_controller(law, names("y", 2), names("u", 2), T))
    bench.run(np.full((500, 2), 0.01))
    before, u = bench.states(), bench.demands()
    after = bench.step([0.01, 0.01], reset=1)
    np.testing.assert_allclose(after, u, atol=0.06)
    assert abs(bench.states()[0]) < 0.01 * abs(before[0])
    assert bench.states()[1] == pytest.approx(before[1], rel=1e-3)
    held = bench.run(np.full((2000, 2), 0.01))[:, 0]
    assert held[-1] == pytest.approx(100.0 * 0.01 + 2.5e4 * 0.01 * T, rel=1e-6), "the proportional part alone"


@given(st.floats(0.0, 32.0), st.sampled_from([1, 2, 4, 5]), st.integers(0, 100))
def test_a_delayed_demand_is_its_mean_over_the_step(delay, parts, seed):
    """Each communication step shows the mean over it of u at its sample's instant plus the delay."""
    rng, count = np.random.default_rng(seed), 45
    values = rng.uniform(-0.1, 0.1, size=count)
    bench = Bench(single_axis(1.0), signals=[values[0]], delay=delay)
    whole = int(delay)
    for n in range(count * parts):
        k = n // parts
        bench.read([values[k]])
        bench.instance.step(n * T / parts, T / parts)
        begin, end = n / parts - k, (n + 1) / parts - k
        share = min(max((end - (delay - whole)) / (end - begin), 0.0), 1.0)
        newest, before = values[max(k - whole, 0)], values[max(k - whole - 1, 0)]
        assert bench.instance["u"] == pytest.approx(share * newest + (1.0 - share) * before, abs=1e-9)


def test_delay_of_the_chain_adds_a_sample():
    rng = np.random.default_rng(4).uniform(-0.1, 0.1, size=(20, 1))
    late = Bench(single_axis(1.0), signals=rng[0], delay=2, chain__preset=2, chain__delay=1).run(rng)
    np.testing.assert_array_equal(late[3:], rng[:-3])


def test_dac_shows_levels_within_its_range():
    bench = Bench(single_axis(1e3), chain__preset=2, chain__dac=1, chain__dac_bits=8, chain__dac_range=10.0)
    step = 0.5 * 20.0 / 256.0
    result = bench.run(np.linspace(-0.1, 0.1, 41)[:, None])[:, 0]
    np.testing.assert_allclose(result / step, np.round(result / step), atol=1e-9)
    assert (result.min(), result.max()) == (pytest.approx(-5.0), pytest.approx(5.0 - step))


def test_crossed_limits_are_refused_by_name():
    bench = Bench(single_axis(1.0))
    with raises_naming(Fault, "u.lower", "2 A", "u.upper", "1 A"):
        bench.step([0.0], u__lower=2.0, u__upper=1.0)


def test_step_longer_than_a_sample_is_refused():
    bench = Bench(single_axis(1.0))
    with raises_naming(Fault, "step size = 0.00015 s", "sample_time = 0.0001 s"):
        bench.instance.step(0.0, 1.5 * T)


def test_sample_time_is_that_of_the_matrices():
    with raises_naming(Fault, "sample_time", "0.0002 s"):
        Bench(single_axis(1.0), sample_time=2e-4)
