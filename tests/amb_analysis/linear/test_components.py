"""Linear parts: connected, sampled, late, realised from their pulse responses; their responses and margins."""

from types import SimpleNamespace

import control
import numpy as np
import pytest

from amb_analysis.linear.components import (
    LinearComponent,
    connected,
    delayed_by_a_step,
    frequency_response,
    loop_of,
    sampled,
)
from amb_analysis.linear.foreign import realised, responses
from amb_analysis.linear.responses import disk_gain_and_phase, disk_margin, response
from amb_analysis.studies import stability_margin
from amb_analysis.studies.stability_margin import zone
from amb_cosim.controllers.laws import Law
from tests.support.messages import raises_naming

T = 1e-3
MASS = Law([[0.0, 1.0], [-400.0, -0.6]], [[0.0], [2.0]], [[1.0, 0.0]], [[0.0]])


def part(law, name, **options):
    return LinearComponent(law, (f"{name}.u",), (f"{name}.y",), **options)


def gain(k, time=None):
    return Law(np.zeros((0, 0)), np.zeros((0, 1)), np.zeros((1, 0)), [[k]], time)


def test_connected_parts_are_their_feedback():
    """The total force on the mass is 1/(1 - k G) of the injected force."""
    whole = connected([part(MASS, "mass"), part(gain(-30.0), "spring")], {"mass.u": "spring.y", "spring.u": "mass.y"})
    G = control.ss(MASS.A, MASS.B, MASS.C, MASS.D)
    for s in (0.0, 3j, 20j + 1.0):
        law = whole.selected(["mass.u"], ["mass.y", "mass.u"]).law
        result = control.ss(law.A, law.B, law.C, law.D)(s)[:, 0]
        np.testing.assert_allclose(result, np.array([G(s), 1.0]) / (1.0 + 30.0 * G(s)), rtol=1e-12)


def test_stiff_loop_without_delay_is_solved_in_any_unit():
    """N/m against m/N: f = 1e7 x, x = 3e-8 f + u."""
    loop = connected([part(gain(1e7), "k"), part(gain(3e-8), "h")], {"k.u": "h.y", "h.u": "k.y"})
    assert loop.selected(["k.u"], ["k.y"]).law.D[0, 0] == pytest.approx(1e7 / (1.0 - 0.3), rel=1e-12)


def test_loop_that_has_no_solution_is_refused():
    with raises_naming(ValueError, "loop", "delay"):
        connected([part(gain(2.0), "a"), part(gain(0.5), "b")], {"a.u": "b.y", "b.u": "a.y"})


def test_late_input_changes_within_the_sample():
    """0.25 of a sample late is one of four short samples late."""
    late, short = sampled(part(MASS, "mass"), T, {"mass.u": 0.25}).law, sampled(part(MASS, "mass"), T / 4).law
    rng = np.random.default_rng(1)
    x, fine, before = np.zeros(len(late.A)), np.zeros(2), 0.0
    for u in rng.standard_normal(20):
        assert (late.C @ x)[0] == pytest.approx((short.C @ fine)[0], rel=1e-12, abs=1e-18)
        x = late.A @ x + late.B[:, 0] * u
        for quarter in range(4):
            fine = short.A @ fine + short.B[:, 0] * (u if quarter else before)
        before = u


def test_poles_are_continuous_as_a_fractional_delay_becomes_whole():
    """As the share tends to one, the loop tends to that of a sample of delay; poles move on without a jump."""

    def radius(law, late):
        parts = [part(MASS, "mass"), LinearComponent(law, ("k.u",), ("k.y",), late)]
        return np.abs(np.linalg.eigvals(loop_of(parts, {"mass.u": "k.y", "k.u": "mass.y"}).law.A)).max()

    held = Law([[0.0]], [[1.0]], [[-30.0]], [[0.0]], T)
    assert radius(gain(-30.0, T), 1.0 - 1e-9) == pytest.approx(radius(held, 0.0), rel=1e-9)
    assert radius(gain(-30.0, T), 0.0) < radius(gain(-30.0, T), 0.5) < radius(held, 0.0)


def test_late_loop_has_its_whole_delay_in_sensitivity_and_opened():
    """With the demand 0.3 samples late, w/e = 1/(1 - K P) and u/e = K P, P from ten short samples."""
    law = Law([[0.5]], [[1.0]], [[4.0]], [[-30.0]], T)
    parts = [part(MASS, "mass"), LinearComponent(law, ("k.u",), ("k.y",), 0.3)]
    feeds = {"mass.u": "k.y", "k.u": "mass.y"}
    short, ends = sampled(part(MASS, "mass"), T / 10).law, ["mass.u"]
    pushes = [np.linalg.matrix_power(short.A, 9 - j) @ short.B for j in range(10)]
    closed = loop_of(parts, feeds).selected(ends, ends).law
    cut = {name: source for name, source in feeds.items() if name != "mass.u"}
    opened = loop_of(parts, cut, {"mass.u": "k.y"}).selected(ends, ["k.y"]).law
    for z in np.exp(1j * np.array([0.01, 0.3, 2.0])):
        forced = sum(push / z if j < 3 else push for j, push in enumerate(pushes))
        P = (short.C @ np.linalg.solve(z * np.eye(2) - np.linalg.matrix_power(short.A, 10), forced))[0, 0]
        L = (4.0 / (z - 0.5) - 30.0) * P
        assert frequency_response(opened, z)[0, 0] == pytest.approx(L, rel=1e-9)
        assert frequency_response(closed, z)[0, 0] == pytest.approx(1.0 / (1.0 - L), rel=1e-9)


def test_parts_of_different_sample_times_are_refused():
    with raises_naming(ValueError, "0.001 s", "0.002 s"):
        loop_of([part(gain(1.0, T), "a"), part(gain(1.0, 2 * T), "b")], {})


def test_output_at_the_end_of_a_step_reaches_the_first_a_step_later():
    law = Law([[0.5]], [[1.0]], [[2.0]], [[3.0]], T)
    later, names = delayed_by_a_step(part(law, "a"), ["a.y"])
    result = responses(later.selected(["a.u"], [names["a.y"]]).law, 6)[:, 0, 0]
    np.testing.assert_allclose(result, [0.0, *responses(law, 5)[:, 0, 0]])


def test_pulse_response_identifies_order_and_poles_of_a_law():
    """Poles from 0.2 to an integrator, two inputs and outputs of units that are far apart."""
    poles = np.array([1.0, 0.98, 0.6, 0.2])
    rng = np.random.default_rng(2)
    B, C = rng.standard_normal((4, 2)) * [1.0, 1e6], rng.standard_normal((2, 4)) * [[1.0], [1e-7]]
    law = Law(np.diag(poles), B, C, [[0.0, 1.0], [0.0, 0.0]], T)
    result = realised(responses(law, 120), T)
    np.testing.assert_allclose(np.sort(np.linalg.eigvals(result.A).real), np.sort(poles), rtol=1e-8)


@pytest.mark.parametrize("rounding", [0.0, 1e-12])
def test_pulse_response_identifies_independent_laws_without_coupling(rounding):
    """Two laws of one signal each, and an output and an input that nothing connects; exact zeros between them."""
    laws = [Law([[0.5]], [[2.0]], [[3.0]], [[1.0]]), Law([[0.9]], [[1.0]], [[-4e5]], [[2e5]])]
    markov = np.zeros((120, 3, 3))
    markov[:, 2, 1], markov[:, 0, 2] = (responses(law, 120)[:, 0, 0] for law in laws)
    noise = rounding * np.random.default_rng(0).standard_normal(markov.shape)
    noise *= np.outer([4e5, 0.0, 1.0], [0.0, 1.0, 1.0])
    result = realised(markov + noise, T)
    first, second = (result.B[:, k] != 0.0 for k in (1, 2))
    assert (int(first.sum()), int(second.sum())) == (1, 1)
    assert not np.any(first & second)
    assert not result.A[np.ix_(first, second)].any()
    np.testing.assert_allclose(responses(result, 120), markov, atol=1e-9 * np.abs(markov).max())


def test_disk_margin_of_one_loop_agrees_with_python_control():
    L = control.tf([25.0], [1.0, 10.0, 10.0, 10.0])
    omega = np.geomspace(0.1, 100.0, 200)
    S = (1.0 / (1.0 + L(1j * omega)))[None, None, :]
    least = disk_margin(S).min()
    alpha, gain_db, phase = control.disk_margins(L, omega)
    assert least == pytest.approx(alpha, rel=1e-9)
    gain_margin, phase_margin = disk_gain_and_phase(least)
    assert 20.0 * np.log10(gain_margin) == pytest.approx(gain_db, rel=1e-6)
    assert phase_margin == pytest.approx(phase, rel=1e-6)


def test_disk_margin_does_not_depend_on_the_units_of_the_loops():
    """Two loops coupled in one direction have the smaller of both margins, for any coupling."""
    S = np.array([[0.5 + 1.0j, 1e4], [0.0, 2.0 - 0.5j]])[:, :, None]
    expected = 1.0 / max(abs(0.5 + 1.0j - 0.5), abs(2.0 - 0.5j - 0.5))
    assert disk_margin(S)[0] == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize("pole", [0.0, 0.7])
def test_response_of_repeated_poles_is_that_of_the_chain(pole):
    """1/(z - p)^4, whose eigenvectors are one; of a delay line for p = 0. Different poles are in the tests below."""
    chain = control.ss(np.diag(np.full(4, pole)) + np.eye(4, k=1), np.eye(4)[:, 3:], np.eye(4)[:1], [[0.0]], 1e-3)
    frequencies = np.geomspace(1.0, 499.0, 200)
    z = np.exp(2j * np.pi * frequencies * 1e-3)
    np.testing.assert_allclose(response(chain, frequencies)[0, 0], (z - pole) ** -4, rtol=1e-6)


def test_a_response_by_eigenvectors_is_the_sum_of_its_poles():
    poles, gains = np.array([0.9, -0.5, 0.99 * np.exp(0.3j), 0.99 * np.exp(-0.3j)]), np.array([1.0, 2.0, 1j, -1j])
    A = np.zeros((4, 4))
    A[[0, 1], [0, 1]], A[2:, 2:] = (
        poles[:2].real,
        0.99 * np.array([[np.cos(0.3), -np.sin(0.3)], [np.sin(0.3), np.cos(0.3)]]),
    )
    system = control.ss(A, [[1.0], [2.0], [1.0], [0.0]], [[1.0, 1.0, 0.0, -2.0]], [[0.25]], 1e-3)
    frequencies = np.geomspace(1.0, 499.0, 200)
    z = np.exp(2j * np.pi * frequencies * 1e-3)
    expected = 0.25 + (gains[:, None] / (z - poles[:, None])).sum(axis=0)
    np.testing.assert_allclose(response(system, frequencies)[0, 0], expected, rtol=1e-9)


def test_zones_begin_at_their_limits():
    assert [zone(peak) for peak in (1.0, 2.999, 3.0, 3.999, 4.0, 4.999, 5.0, 40.0, np.inf)] == list("AABBCCDDD")


@pytest.mark.parametrize(("at", "width"), [(333.0, 10.0), (0.2, 0.05), (0.0, 0.4)])
def test_least_disk_margin_is_that_between_the_frequencies(monkeypatch, at, width):
    """alpha = 1/|S - 1/2| of a loop alone: 0.5 at 333 Hz, with frequencies that are 13 Hz apart there, or below all."""

    def closed(model, hertz):
        S = 0.5 + 2.0 / (1.0 + 1j * (hertz - at) / width)
        return np.stack([np.stack([S, S]), np.stack([S, S])])

    monkeypatch.setattr(stability_margin, "response", closed)
    frequencies = np.geomspace(1.0, 2000.0, 200)
    gang, margins = stability_margin._all_loops(SimpleNamespace(demands=("i",), closed=None), frequencies)
    assert len(gang.S) == len(frequencies)
    for margin in margins.values():
        assert len(margin.alpha) == len(frequencies)
        assert margin.least == pytest.approx(0.5, rel=1e-3)
        assert margin.frequency == pytest.approx(at, abs=0.1 * width)
