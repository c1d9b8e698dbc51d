"""Iterative coupling, and the order of every coupling, on components that are a line of arithmetic."""

import numpy as np
import pytest
from interfaces import interface
from scipy.linalg import expm

from amb_cosim.cosim.errors import StepFailed
from amb_cosim.cosim.fmu.fmu_interface import Port
from amb_cosim.cosim.master.master import Master
from amb_cosim.cosim.system.assembly import Assembly
from amb_cosim.cosim.system.signal_map import SignalMap
from amb_cosim.cosim.system.system import Component, Connection, System
from tests.support.messages import raises_naming

A = np.array([[-1.0, 2.0], [-3.0, -0.5]])
START = np.array([1.0, 0.5])


class Lag:
    """x' = a x + b u with u held, solved exactly; y = x. It counts its calls."""

    every = 1

    def __init__(self, name, a, b, x):
        self.name, self.a, self.b, self.x = name, a, b, x
        self.inputs, self.outputs = np.zeros(1), np.zeros(1)
        self.steps = self.restores = 0
        self.kept = None

    def enter(self, start_time): ...
    def leave(self): ...
    def close(self): ...

    def write(self):
        self.u = self.inputs[0]

    def read(self):
        self.outputs[0] = self.x

    def step(self, time, step_size):
        self.steps += 1
        self.x = np.exp(self.a * step_size) * self.x + np.expm1(self.a * step_size) / self.a * self.b * self.u

    def save(self):
        self.kept = self.x

    def restore(self):
        self.restores += 1
        self.x = self.kept


class Gain(Lag):
    """y = b u, without a state."""

    def step(self, time, step_size):
        self.steps += 1
        self.x = self.b * self.u


def pair(weights=(0.5, 0.5)):
    lags = [Lag("ab"[i], A[i, i], A[i, 1 - i], START[i]) for i in (0, 1)]
    wiring = SignalMap(("a", "b"), 0, (np.array([1]), np.array([0])), ((), ()), tuple(np.array([w]) for w in weights))
    return lags, wiring


def end(components, wiring, steps, duration=1.0, coupling="iterative"):
    master = Master(components, wiring, duration / steps, coupling)
    master.initialise()
    master.run(0, steps)
    return master.values.copy()


def implicit(h, weight):
    """One step of the pair as one linear system: x+ = E x + B ((1 - w) x + w x+), solved for x+."""
    local = np.diag(A)
    E = np.diag(np.exp(local * h))
    B = (np.expm1(local * h) / local)[:, None] * (A - np.diag(local))
    return np.linalg.solve(np.eye(2) - weight * B, E + (1.0 - weight) * B)


@pytest.mark.parametrize("weight", [0.5, 1.0])
def test_an_iterated_step_solves_the_implicit_equations(weight):
    expected = np.linalg.matrix_power(implicit(0.05, weight), 20) @ START
    np.testing.assert_allclose(end(*pair((weight, weight)), steps=20), expected, rtol=1e-8)


@pytest.mark.parametrize(
    ("coupling", "weight", "order"),
    [
        ("iterative", 0.5, 2.0),
        ("iterative", 1.0, 1.0),
        ("iterative", 0.0, 1.0),
        ("gauss_seidel", 0.5, 1.0),
        ("jacobi", 0.5, 1.0),
    ],
)
def test_each_coupling_has_its_order_of_convergence(coupling, weight, order):
    exact = expm(A) @ START
    results = [end(*pair((weight, weight)), steps=steps, coupling=coupling) for steps in (100, 200, 400, 800)]
    errors = np.linalg.norm(results - exact, axis=1)
    assert errors[-1] < 5e-3
    np.testing.assert_allclose(np.log2(errors[:-1] / errors[1:]), order, atol=0.06)


def test_inputs_from_the_beginning_of_the_step_need_no_repetition():
    """With weights 0 the steps are those of Jacobi order."""
    lags, wiring = pair((0.0, 0.0))
    result = end(lags, wiring, steps=10)
    assert [(lag.steps, lag.restores) for lag in lags] == [(10, 0), (10, 0)]
    np.testing.assert_array_equal(result, end(*pair(), steps=10, coupling="jacobi"))


def test_no_repetition_restores_a_state_before_the_current_point():
    """By FMI a step may then say that no earlier state follows (noSetFMUStatePriorToCurrentPoint)."""

    class Timed(Lag):
        now = begin = 0.0

        def step(self, time, step_size):
            super().step(time, step_size)
            self.begin, self.now = time, time + step_size

        def save(self):
            super().save()
            self.saved_at = self.now

        def restore(self):
            super().restore()
            assert self.saved_at == pytest.approx(self.begin, abs=1e-12)

    lags, wiring = pair()
    timed = [Timed(lag.name, lag.a, lag.b, lag.x) for lag in lags]
    end(timed, wiring, steps=10)
    assert timed[0].restores > 10


def test_only_components_with_changed_inputs_repeat_their_step():
    lags, wiring = pair((0.0, 0.5))
    end(lags, wiring, steps=10)
    first, second = lags
    assert (first.steps, first.restores) == (10, 0)
    assert second.restores == 0, "the first has stepped before it, and does not change any more"


def test_outputs_with_direct_feedthrough_have_weight_one():
    """A lag under its own output through a gain: the trapezoidal rule, with the gain's weight 1 and the lag's 1/2."""
    a, k, h, steps = -1.0, -3.0, 0.01, 100
    lag, gain = Lag("lag", a, 1.0, 1.0), Gain("gain", 0.0, k, 1.0 * k)
    weights = (np.array([1.0]), np.array([0.5]))
    wiring = SignalMap(("lag", "gain"), 0, (np.array([1]), np.array([0])), ((), (0,)), weights)
    E, B = np.exp(a * h), np.expm1(a * h) / a * k
    expected = ((E + 0.5 * B) / (1.0 - 0.5 * B)) ** steps
    assert end([lag, gain], wiring, steps)[0] == pytest.approx(expected, rel=1e-8)


def test_a_step_that_does_not_converge_fails_and_names_the_source():
    """A gain of -2 around two components without states: each repetition doubles the difference."""
    gains = [Gain(name, 0.0, b, 1.0) for name, b in (("a", -2.0), ("b", 1.0))]
    wiring = SignalMap(("a.y", "b.y"), 0, (np.array([1]), np.array([0])), ((), ()), (np.array([1.0]), np.array([1.0])))
    with raises_naming(StepFailed, "a", "0 s", "b.y", "30"):
        end(gains, wiring, steps=10)


def test_a_component_with_a_slower_rate_cannot_be_iterated():
    lags, wiring = pair()
    lags[1].every = 2
    with raises_naming(ValueError, "b", "2 communication points", "iterative"):
        end(lags, wiring, steps=10)


def test_weights_follow_from_the_dependencies_of_outputs():
    interfaces = {
        "plant": interface(
            Port("f", "Real", "input", 0), Port("x", "Real", "output", 1), Port("contact", "Integer", "output", 2)
        ),
        "actuator": interface(
            Port("x", "Real", "input", 0),
            Port("i", "Real", "input", 1),
            Port("contact", "Integer", "input", 2),
            Port("f", "Real", "output", 3, depends_on=("x", "i")),
        ),
        "controller": interface(
            Port("sample_time", "Real", "parameter", 0),
            Port("x", "Real", "input", 1),
            Port("u", "Real", "input", 2),
            Port("i", "Real", "output", 3, depends_on=("x",)),
        ),
    }
    links = [("plant.x", "actuator.x"), ("plant.contact", "actuator.contact"), ("controller.i", "actuator.i")]
    links += [("actuator.f", "plant.f"), ("plant.x", "controller.x")]
    components = tuple(Component(name, name) for name in interfaces)
    system = System("s", "d", components, tuple(Connection(*link) for link in links))
    wiring = Assembly(system, {}, interfaces).wiring(["controller.u"])
    weights = {
        f"{name}.{variable}": weight
        for (name, variables), of_one in zip(wiring.inputs.items(), wiring.weights, strict=True)
        for variable, weight in zip(variables, of_one.tolist(), strict=True)
    }
    assert weights == {
        "plant.f": 1.0,
        "actuator.x": 0.5,
        "actuator.i": 1.0,
        "actuator.contact": 0.0,
        "controller.x": 0.0,
        "controller.u": 0.0,
    }
