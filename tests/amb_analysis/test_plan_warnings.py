"""Studies of a machine and its assessment show the warnings of its plan, as a run does."""

import pytest

from amb_analysis.linear.linearise import linearise
from amb_assessment.assessment.engine.assess import assess, check_machine
from amb_assessment.assessment.format.machine_file import load_machine
from amb_assessment.assessment.page.description import description
from amb_assessment.assessment.page.page import page
from amb_cosim import studies
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.scenario import load_scenario
from tests.support.messages import assert_names

MACHINE = "compressor_levitated"
IDLE = {"rolac_controller.chain.noise": True}  # without effect under the preset `ideal`
STUDIES = {
    "poles": {"up_to": 300.0, "count": 1},
    "response": {"inputs": ["impeller3.f_x"], "outputs": ["seal.x"], "up_to": "50 Hz"},
    "unbalance_response": {"up_to": 200.0},
    "linearisation": {},
    "sensitivity": {},
    "identify": {"speeds": "9000 rpm", "computed": True},
    "waterfall": {"window": "6 ms"},
    "coupling": {},
    "robustness": {},
}
BY_RUNS = ("waterfall", "coupling", "robustness")  # a revolution is enough


@pytest.mark.usefixtures("few_speeds")
@pytest.mark.parametrize("name", STUDIES)
def test_studies_show_the_warnings_of_a_run(name):
    machine = load_scenario(MACHINE).changed(settle_cycles=0, end_cycle=1)
    source = {"source" if name == "waterfall" else "scenario": machine if name in BY_RUNS else MACHINE}
    expected = prepare_run(machine, IDLE).warnings
    assert_names(expected[0], "rolac_controller.chain.noise", "rolac_controller.chain.preset")
    result = getattr(studies, name)(**source, set=IDLE, **STUDIES[name])
    assert [shown.removesuffix(" (parameters)") for shown in result.warnings] == [*expected]  # the suffix of a summary
    assert result.as_dict()["warnings"] == [*result.warnings]
    assert [part for part in result.text() if isinstance(part, str)][-1] == f"warning: {result.warnings[-1]}"


def test_an_assessment_shows_the_warnings_of_a_run():
    file = load_machine("compressor")
    parameters = {**file.parameters, "rolac_controller": file.parameters["rolac_controller"] | {"chain.noise": True}}
    file = file.model_copy(update={"parameters": parameters})
    result = assess(file, only=["free_modes"])
    assert_names(result.warnings[0], "rolac_controller.chain.noise", "rolac_controller.chain.preset")
    assert result.as_dict()["warnings"] == [*result.warnings]
    assert result.warnings[0] in page(result)
    assert description(check_machine(file), ())[-1] == f"warning: {result.warnings[0]}"
    assert assess("compressor", only=["free_modes"]).warnings == ()


def test_a_linear_model_has_the_warnings_of_a_run():
    expected = prepare_run(load_scenario(MACHINE), IDLE).warnings
    model = linearise(MACHINE, set=IDLE, components=["rotor_contact"])
    assert model.warnings == expected
    assert model.text()[-1] == f"warning: {expected[0]}"
