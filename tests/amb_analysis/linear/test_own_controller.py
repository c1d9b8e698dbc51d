"""A controller of one's own, an FMU with a law over speed and without a parameter `sample_time`, in linear analyses."""

import json
from pathlib import Path

import numpy as np
import pytest

from amb_analysis.machine.machine import machine_of
from amb_analysis.studies.injection import STEPS_OF_A_SAMPLE, plan_measurement
from amb_analysis.studies.inputs import controlled
from amb_analysis.studies.stability_margin import _check_agreement
from amb_cosim import linear_controller, studies
from amb_cosim.results.component_names import CONTROLLER
from amb_cosim.scenario.prepare_run import prepare_run
from tests.support.messages import raises_naming

FILE = Path(__file__).parents[3] / "examples" / "controllers" / "cross_feedback.toml"
SCENARIO = "compressor_levitated"
SPEEDS = (0.0, 500.0, 942.0)
SCRIPT = '''
import json
from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Real

TABLE = json.loads("""{table}""")  # speed, and A, B, C, D there


def times(matrix, vector):
    return [sum(a * b for a, b in zip(row, vector)) for row in matrix]


class Own(Fmi2Slave):
    """A sample in each step."""

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.inputs, self.outputs = {inputs}, {outputs}
        self.v = dict.fromkeys([*self.inputs, *self.outputs, "Omega"], 0.0)
        for name in [*self.inputs, "Omega"]:
            self.add(name, Fmi2Causality.input, Fmi2Variability.continuous)
        for name in self.outputs:
            self.add(name, Fmi2Causality.output, Fmi2Variability.discrete)
        self.x = [0.0] * len(TABLE[0][1])

    def add(self, name, causality, variability):
        self.register_variable(
            Real(
                name,
                causality=causality,
                variability=variability,
                getter=lambda: self.v[name],
                setter=lambda value: self.v.__setitem__(name, value),
            )
        )

    def do_step(self, current_time, step_size):
        Omega = self.v["Omega"]
        k = max(n for n, row in enumerate(TABLE[:-1]) if n == 0 or row[0] <= Omega)
        share = (Omega - TABLE[k][0]) / (TABLE[k + 1][0] - TABLE[k][0])
        A, B, C, D = (
            [[(1.0 - share) * a + share * b for a, b in zip(*rows)] for rows in zip(low, high)]
            for low, high in zip(TABLE[k][1:], TABLE[k + 1][1:])
        )
        u = [self.v[name] for name in self.inputs]
        self.v.update((n, a + b) for n, a, b in zip(self.outputs, times(C, self.x), times(D, u)))
        self.x = [a + b for a, b in zip(times(A, self.x), times(B, u))]
        return True
'''


@pytest.fixture(scope="module")
def own(tmp_path_factory):
    """The FMU, and the controller file of the same law."""
    from pythonfmu.builder import FmuBuilder

    folder = tmp_path_factory.mktemp("own")
    controller = linear_controller(FILE)
    table = [[Omega, *(m.tolist() for m in (law.A, law.B, law.C, law.D))] for Omega, law in controller.laws.items()]
    ports = {"inputs": [*controller.ports.signals], "outputs": [*controller.ports.demands]}
    script = folder / "own.py"
    script.write_text(SCRIPT.format(table=json.dumps(table), **ports), encoding="utf-8")
    fmu = FmuBuilder.build_FMU(str(script), dest=str(folder))
    return Path(fmu), FILE


def loop_of(controller):
    return machine_of(prepare_run(controlled(SCENARIO, None, controller))).loop


def test_an_own_controller_is_linearised_at_each_speed(own):
    """Cross-feedback that grows with the speed: the poles are those of the same law in a controller file."""
    found, expected = ([loop.poles(Omega).stability for Omega in SPEEDS] for loop in map(loop_of, own))
    assert [s.growth_rate for s in found] == pytest.approx([s.growth_rate for s in expected], rel=1e-3)
    assert [s.frequency for s in found] == pytest.approx([s.frequency for s in expected], rel=1e-4)
    at_rest = loop_of(own[0]).linear_components
    laws = [at_rest.at(Omega).parts([CONTROLLER])[0].law for Omega in SPEEDS]
    assert not np.allclose(laws[0].D, laws[2].D, rtol=1e-3)
    assert loop_of(own[0]).readings == loop_of(own[1]).readings  # the FMU declares no units


@pytest.mark.parametrize("amplifier", [False, True])
def test_an_own_controller_steps_in_a_measurement_as_in_a_run(own, amplifier):
    """With dynamic amplifiers the steps of the measurement are a quarter of a sample; the FMU makes every fourth."""
    prepared = plan_measurement(controlled(SCENARIO, None, own[0]), {}, amplifier=amplifier)
    (controller,) = (c for c in prepared.system.components if c.name == CONTROLLER)
    sample_time = linear_controller(FILE).sample_time
    assert controller.every == (STEPS_OF_A_SAMPLE if amplifier else 1)
    assert controller.every * prepared.step_size == pytest.approx(sample_time)
    assert machine_of(prepared).loop.sample_time == pytest.approx(sample_time)


@pytest.mark.slow
def test_the_sensitivity_of_an_own_controller_is_that_of_its_law(own):
    found, expected = (studies.sensitivity(SCENARIO, controller=controller) for controller in own)
    for name, axis in found.axes.items():
        assert axis.peak == pytest.approx(expected.axes[name].peak, rel=1e-3)
        assert axis.measured_peak == pytest.approx(axis.peak, rel=0.01)
    for place, margin in found.disk_margins.items():
        assert margin.least == pytest.approx(expected.disk_margins[place].least, rel=1e-3)


def test_a_measurement_that_contradicts_the_linear_model_fails():
    frequencies, computed = np.array([[10.0, 20.0]]), np.array([[1.0 + 0.0j, 2.0j]])
    _check_agreement(["left.x"], frequencies, computed, 1.09 * computed)
    for wrong in (1.2, 0.8, np.exp(0.2j)):
        with raises_naming(ValueError, "left.x", "20.0 Hz", "co-simulation"):
            _check_agreement(["left.x"], frequencies, computed, computed * [1.0, wrong])
