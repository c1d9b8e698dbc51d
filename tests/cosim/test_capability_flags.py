"""Capability flags of FMI that have no effect, and functions that every FMU receives."""

from pathlib import Path

import pytest
from fmu_systems import write_system
from informed import SOURCE, description, informed_fmu

import amb_cosim
from tests.support.messages import raises_naming

UNUSED = {
    2: {
        **dict.fromkeys(("needsExecutionTool", "canInterpolateInputs", "canRunAsynchronuously"), "true"),
        **dict.fromkeys(("canNotUseMemoryManagementFunctions", "providesDirectionalDerivative"), "true"),
        "maxOutputDerivativeOrder": "2",
    },
    3: {
        **dict.fromkeys(("needsExecutionTool", "providesDirectionalDerivatives", "providesAdjointDerivatives"), "true"),
        **dict.fromkeys(("providesPerElementDependencies", "providesIntermediateUpdate", "hasEventMode"), "true"),
        **dict.fromkeys(("mightReturnEarlyFromDoStep", "canReturnEarlyAfterIntermediateUpdate"), "true"),
        "providesEvaluateDiscreteStates": "true",
        "maxOutputDerivativeOrder": "2",
        "recommendedIntermediateInputSmoothness": "1",
        "fixedInternalStepSize": "0.0005",
    },
}
BORROWED = """<fmiModelDescription fmiVersion="2.0" guid="{a}" modelName="Borrowed">
<CoSimulation modelIdentifier="borrowed"/><ModelVariables>
<ScalarVariable name="y" valueReference="0" causality="output"><Real/></ScalarVariable>
</ModelVariables><ModelStructure><Outputs><Unknown index="1"/></Outputs></ModelStructure></fmiModelDescription>"""


@pytest.fixture
def run(tmp_path):
    """`run(fmu)`: the data set of the FMU alone, in 10 steps of 1 ms."""

    def simulate(fmu):
        return amb_cosim.simulate(write_system(tmp_path, {"one": fmu}), isolated=False).dataset

    return simulate


@pytest.mark.parametrize("version", [2, 3])
def test_unused_capability_flags_change_no_value(run, fmu_from_c, tmp_path, version):
    plain, flagged = (run(informed_fmu(fmu_from_c, tmp_path, version, **flags)) for flags in ({}, UNUSED[version]))
    assert set(plain) == set(flagged)
    for name in set(plain) - {"one.instances"}:
        assert plain[name].values.tolist() == flagged[name].values.tolist(), name


def test_an_fmu_may_use_the_memory_functions_of_its_host(run, fmu_from_c):
    fmu = fmu_from_c(Path(__file__).parent / "support" / "borrowed.c", BORROWED)
    for _ in range(2):
        assert run(fmu)["one.y"].values.tolist() == [42.0] * 11


OLD = """<fmiModelDescription fmiVersion="1.0" modelName="Old" modelIdentifier="informed" guid="{a}"
numberOfContinuousStates="0" numberOfEventIndicators="0"><ModelVariables>
<ScalarVariable name="y" valueReference="3" causality="output"><Real/></ScalarVariable></ModelVariables>
<Implementation><CoSimulation_StandAlone><Capabilities canHandleVariableCommunicationStepSize="true"/>
</CoSimulation_StandAlone></Implementation></fmiModelDescription>"""
ONLY = {
    "model exchange of FMI 2.0": (2, description(2).replace("<CoSimulation", "<ModelExchange")),
    "model exchange of FMI 3.0": (3, description(3).replace("<CoSimulation", "<ModelExchange")),
    "schedules of FMI 3.0": (3, description(3).replace("<CoSimulation", "<ScheduledExecution")),
    "co-simulation of FMI 1.0": (2, OLD),
}


@pytest.mark.parametrize("kind", ONLY)
def test_an_fmu_without_co_simulation_is_refused_with_its_kind(run, fmu_from_c, kind):
    version, text = ONLY[kind]
    text = text if text is OLD else text.replace(' canHandleVariableCommunicationStepSize="true"', "")
    fmu = fmu_from_c(SOURCE, text, version, name=kind.replace(" ", "-"))
    with raises_naming(ValueError, "one", kind, "co-simulation of FMI 2.0 or 3.0"):
        run(fmu)
