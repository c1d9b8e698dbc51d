"""A controller of one's own, an FMU with a law over speed and without a parameter `sample_time`, in linear analyses."""

import json
from pathlib import Path

import numpy as np
import pytest

from amb_analysis.linear import linear_source
from amb_analysis.linear.foreign import foreign_component
from amb_analysis.machine.feedback import bearing_forces
from amb_analysis.machine.machine import machine_of
from amb_analysis.studies.injection import STEPS_OF_A_SAMPLE, plan_measurement
from amb_analysis.studies.inputs import controlled
from amb_analysis.studies.stability_margin import _check_agreement
from amb_assessment.assessment.engine.assess import assess
from amb_assessment.assessment.format.machine_file import packaged_machines
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


PER_AXIS = """
inputs = ["probe_lower.x", "probe_lower.y", "probe_upper.x", "probe_upper.y", "thrust.z"]
outputs = ["lower.i_x", "lower.i_y", "upper.i_x", "upper.i_y", "thrust.i_z"]
sample_time = "50 us"

[[channel]]
from = ["probe_lower.x", "probe_lower.y"]
to = ["lower.i_x", "lower.i_y"]
gain = -1
blocks = [{ type = "pid", kp = "7.9e3 A/m", kd = "48 A.s/m", roll_off = "600 Hz" }]

[[channel]]
from = ["probe_upper.x", "probe_upper.y"]
to = ["upper.i_x", "upper.i_y"]
gain = -1
blocks = [{ type = "pid", kp = "1e4 A/m", kd = "85 A.s/m", roll_off = "600 Hz" }]

[[channel]]
from = "thrust.z"
to = "thrust.i_z"
gain = -1
blocks = [{ type = "pid", kp = "1.6e4 A/m", ki = "1e5 A/(m.s)", kd = "32 A.s/m", roll_off = "2 kHz" }]
"""
FIVE_AXES = "turbo_pump_levitation"


def fmu_of(file, folder, name="Own", coupling=0.0):
    """Return the FMU of a controller file; a share of its last gain acts on its first input, too."""
    from pythonfmu.builder import FmuBuilder

    controller = linear_controller(file)
    table = [[Omega, *(m.tolist() for m in (law.A, law.B, law.C, law.D))] for Omega, law in controller.laws.items()]
    table = table if len(table) > 1 else [[0.0, *table[0][1:]], [1e4, *table[0][1:]]]
    for _, *_, D in table:
        D[-1][0] += coupling * D[-1][-1]
    ports = {"inputs": [*controller.ports.signals], "outputs": [*controller.ports.demands]}
    script = folder / f"{name.lower()}.py"
    text = SCRIPT.format(table=json.dumps(table), **ports).replace("class Own", f"class {name}")
    script.write_text(text, encoding="utf-8")
    return Path(FmuBuilder.build_FMU(str(script), dest=str(folder)))


@pytest.fixture(scope="module")
def own(tmp_path_factory):
    """The FMU, and the controller file of the same law."""
    return fmu_of(FILE, tmp_path_factory.mktemp("own")), FILE


@pytest.fixture(scope="module")
def per_axis(tmp_path_factory):
    """An FMU with one PID per axis of a rotor on five axes, and the controller file of the same law."""
    folder = tmp_path_factory.mktemp("axes")
    (folder / "axes.toml").write_text(PER_AXIS, encoding="utf-8")
    return fmu_of(folder / "axes.toml", folder, "Axes"), folder / "axes.toml"


def loop_of(controller, scenario=SCENARIO):
    return machine_of(prepare_run(controlled(scenario, None, controller))).loop


def test_an_own_controller_is_linearised_at_each_speed(own):
    """Cross-feedback that grows with the speed: the poles are those of the same law in a controller file."""
    found, expected = ([loop.poles(Omega).stability for Omega in SPEEDS] for loop in map(loop_of, own))
    assert [s.growth_rate for s in found] == pytest.approx([s.growth_rate for s in expected], rel=1e-3)
    assert [s.frequency for s in found] == pytest.approx([s.frequency for s in expected], rel=1e-4)
    at_rest = loop_of(own[0]).linear_components
    laws = [at_rest.at(Omega).parts([CONTROLLER])[0].law for Omega in SPEEDS]
    assert not np.allclose(laws[0].D, laws[2].D, rtol=1e-3)
    assert loop_of(own[0]).readings == loop_of(own[1]).readings  # the FMU declares no units


def test_the_axis_along_the_shaft_has_the_law_of_its_pid_alone(per_axis):
    """Its two states and its delay, without those of the other axes that are identified together with it."""
    found, expected = (loop_of(controller, FIVE_AXES).axial_control for controller in per_axis)
    hertz = np.geomspace(0.1, 9e3, 40)
    assert len(found.law.A) == len(expected.law.A) == 2
    assert found.delay == expected.delay == 0.0
    np.testing.assert_allclose(found.response(hertz), expected.response(hertz), rtol=1e-6)


@pytest.mark.parametrize("coupling", [1e-4, 0.1])
def test_an_axis_along_the_shaft_that_reads_another_axis_is_refused(per_axis, tmp_path, coupling):
    coupled = fmu_of(per_axis[1], tmp_path, f"Coupled{coupling:g}".replace(".", "_").replace("-", "_"), coupling)
    with raises_naming(ValueError, "rolac_controller.thrust.i_z", "rolac_controller.thrust.z", "displacement"):
        _ = loop_of(coupled, FIVE_AXES).axial_control


def test_a_law_that_does_not_depend_on_the_speed_is_identified_once(per_axis, own, monkeypatch):
    """The FMU reads the speed, but does not use it; the law of cross-feedback depends on it."""
    identified = []

    def counted(*arguments):
        identified.append(arguments)
        return foreign_component(*arguments)

    monkeypatch.setattr(linear_source, "foreign_component", counted)
    for fmu, scenario, count in ((per_axis[0], FIVE_AXES, 1), (own[0], SCENARIO, 3)):
        components, before = loop_of(fmu, scenario).linear_components, len(identified)
        laws = [components.at(Omega).parts([CONTROLLER])[0].law for Omega in SPEEDS]
        assert len(identified) - before == count
        assert len({id(law) for law in laws}) == count


def test_forces_of_an_own_controller_are_those_of_its_law(own):
    """It is stepped before the magnets, so its demands reach them in the same step; a sample is 0.2 rad here."""
    found, expected = (
        bearing_forces(machine_of(prepare_run(controlled(SCENARIO, None, controller))), 2e3, 500.0)
        for controller in own
    )
    np.testing.assert_allclose(found, expected, rtol=1e-4, atol=1e-6 * np.abs(expected).max())


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


@pytest.mark.slow
def test_an_assessment_of_an_own_controller_gives_the_findings_of_its_law(per_axis, tmp_path):
    """The linear parts; the FMU has no sensor noise and no dead sensors, and these parts of the assessment say so."""
    parts = ("closed_loop", "unbalance", "envelope", "axial", "axial_margins", "vibration", "faults")
    text = packaged_machines()["turbo_pump"].read_text(encoding="utf-8")
    answered = []
    for controller in per_axis:
        machine = tmp_path / f"{controller.stem}.toml"
        machine.write_text(f'controller = "{controller.as_posix()}"\n{text}', encoding="utf-8")
        answered.append({part.key: part for part in assess(machine, only=parts).parts})
        assert not [part.reason for part in answered[-1].values() if part.reason]
    for key in parts[:-2]:
        found, expected = (part[key].findings for part in answered)
        assert expected
        assert [(f.measured.quantity, f.verdict) for f in found] == [(f.measured.quantity, f.verdict) for f in expected]
        np.testing.assert_allclose(*([f.measured.value for f in of] for of in (found, expected)), rtol=1e-3)
    notes = [{key: " ".join(part[key].result.notes) for key in parts[-2:]} for part in answered]
    assert "no sensor noise" in notes[0]["vibration"]
    assert "no sensor noise" not in notes[1]["vibration"]
    assert "thrust.z" in notes[0]["faults"]
    assert "thrust.z" not in notes[1]["faults"]


@pytest.mark.slow
def test_an_own_controller_lifts_the_rotor_as_its_law_without_anti_windup(per_axis, tmp_path):
    """The law of a file has anti-windup unless no mode is slow; the integral of the FMU winds up without power."""
    text = packaged_machines()["turbo_pump"].read_text(encoding="utf-8")
    slow = tmp_path / "slow.toml"
    slow.write_text(f'slow_time = "1e6 s"\n{PER_AXIS}', encoding="utf-8")
    answered = []
    for controller in (per_axis[0], slow, per_axis[1]):
        machine = tmp_path / f"{controller.stem}{controller.suffix[1:]}.toml"
        machine.write_text(f'controller = "{controller.as_posix()}"\n{text}', encoding="utf-8")
        (part,) = (part for part in assess(machine, only=["recovery"]).parts if part.key == "recovery")
        answered.append(([f.measured.value for f in part.findings], "anti-windup" in " ".join(part.result.notes)))
    np.testing.assert_allclose(answered[0][0], answered[1][0], rtol=1e-4)
    assert answered[0][0][0] > 100.0 > 10.0 > answered[2][0][0]
    assert [notes for _, notes in answered] == [True, True, False]
