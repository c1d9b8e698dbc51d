"""States of foreign FMUs: of one that serialises, and of one that keeps them only in memory."""

import pytest
from strange_machine import RUB

import amb_cosim
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.scenario import Scenario
from amb_sweeps.worker import Runner, Task
from tests.support.changed_archive import with_text
from tests.support.messages import raises_naming


def assert_shared_past_changes_nothing(scenario: Scenario, step: str) -> None:
    """Fail if two sizes of a step at `step` end otherwise, to the last bit, where they share their past."""
    endings = []
    for labels in ((), ("step",)):
        runner = Runner(Task(scenario, labels=labels))
        results = [runner.run(n, {step: size}) for n, size in enumerate(("90 g.mm", "110 g.mm"))]
        runner.close()
        shared = [result.metrics.pop("shared", 0.0) for result in results]
        endings.append([(r.outcome, r.reason, str(r.metrics)) for r in results])
    assert endings[0] == endings[1]
    assert endings[0][0] != endings[0][1], "the points differ"
    assert shared[0] == 0.0 < shared[1]


SHORT = Scenario.load(RUB).changed(end_cycle=6, settle_cycles=1)
SIZE = "step.rotor_contact.turbine.u"
PLACE = "rotor_contact.labyrinth.x"


@pytest.fixture(scope="module")
def actuator_fmu():
    """The FMU of the actuators."""
    return prepare_run(SHORT).fmus["amb_actuator"].path


@pytest.fixture(scope="module")
def in_memory(actuator_fmu, tmp_path_factory):
    """Return the scenario with that FMU, declared as unable to serialise."""
    file, flag = tmp_path_factory.mktemp("memory") / "Actuator.fmu", 'canSerializeFMUstate="{}"'
    with_text(actuator_fmu, file, "modelDescription.xml", flag.format("true"), flag.format("false"))
    return SHORT.changed(fmu={"amb_actuator": str(file)})


@pytest.fixture(scope="module")
def plain(in_memory):
    return amb_cosim.run(in_memory, isolated=False)


def test_a_foreign_fmu_that_serialises_continues_with_the_same_bits(actuator_fmu, plain, tmp_path):
    scenario = SHORT.changed(fmu={"amb_actuator": str(actuator_fmu)})
    state = amb_cosim.run(scenario, isolated=False, save_at=["cycle 5"]).checkpoint().save(tmp_path / "rub.npz")
    result = amb_cosim.run(scenario, isolated=False, start=state)
    for name, samples in plain.signals.variables.items():
        assert result.signals[name].values.tobytes() == samples.values.tobytes(), name


def test_an_fmu_that_does_not_serialise_writes_no_checkpoint(in_memory, plain, tmp_path):
    with raises_naming(ValueError, "amb_actuator", "canSerializeFMUstate"):
        amb_cosim.run(in_memory, isolated=False, save_at=["cycle 5"])
    file = tmp_path / "auto.npz"
    result = amb_cosim.run(in_memory, isolated=False, autosave=file, autosave_every=1e-3)
    assert not file.exists()
    assert result.signals[PLACE].values.tobytes() == plain.signals[PLACE].values.tobytes()


def test_points_share_states_that_an_fmu_keeps_in_memory(in_memory):
    assert_shared_past_changes_nothing(in_memory, SIZE)
