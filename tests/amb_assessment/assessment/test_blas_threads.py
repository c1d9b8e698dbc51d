"""The number of BLAS threads changes no bit of the constants, currents and unbalance with which runs begin."""

from pathlib import Path

import pytest
from slow import slow_but_first
from threadpoolctl import threadpool_limits

from amb_assessment.assessment.engine import assess as assessing
from amb_assessment.assessment.engine.assess import assess, check_machine
from amb_assessment.assessment.format.machine_file import load_machine
from amb_assessment.assessment.format.quantities import AnalysisResult
from amb_assessment.assessment.physics.runs import worst_inputs
from amb_cosim.cosim.fmu.fmus import model_source
from amb_cosim.results.component_names import ACTUATOR

BLOWER = Path(__file__).parent / "blower"
THREADS = (1, 2)


def with_threads(number, function):
    with threadpool_limits(number, user_api="blas"):
        return function()


def constants():
    return model_source("rotor_contact", rotor=BLOWER / "rotor.toml")[1].tobytes()


def static_currents():
    parameters = check_machine(load_machine(BLOWER / "machine.toml")).prepared.parameters[ACTUATOR]
    return {name: value.hex() for name, value in parameters.items() if ".static_current_" in name}


@pytest.mark.parametrize("function", slow_but_first([constants, static_currents]))
def test_threads_change_no_bit_of_the_constants_of_a_run(function):
    results = [with_threads(number, function) for number in THREADS]
    assert results[0]
    assert all(result == results[0] for result in results)


def test_threads_change_no_bit_of_the_unbalance_of_a_landing(monkeypatch):
    """An assessment from Python is that of the command, which sets one thread before NumPy is loaded."""
    found = []

    def answer(subject):
        found.append({name: value.hex() for name, value in worst_inputs(subject).items()})
        return AnalysisResult()

    monkeypatch.setitem(assessing.ANALYSES, "landing", assessing.Analysis("Landing", answer))
    for number in THREADS:
        with_threads(number, lambda: assess(BLOWER / "machine.toml", only=["landing"]))
    assert len(found) == len(THREADS)
    assert all(inputs == found[0] for inputs in found)
