"""The FMU: validation, equality with the core to the last bit, state."""

import pytest
from fmpy.validation import validate_fmu

from amb_cosim.design.plant_data import plant

STEPS = 200


@pytest.fixture(scope="module")
def fmu_file(build_fmu):
    return build_fmu(*plant())


def drive(fmu, steps):
    """Run FMU and core side by side into hard contact; what differed, and the states of contact seen."""
    import fmpy
    from fmpy.fmi2 import FMU2Slave

    from amb_cosim.design.plant_data import plant
    from fmi_export.model import Instance

    h = 250e-6
    fixed = {"rb1.mu": 0.3, "rb2.mu": 0.3, "rb1.restitution": 0.2, "mb1.c_b": 5000.0, "mb2.c_b": 5000.0}
    given = {"Omega": 180.0, "d1.u": 0.06, "d3.u": 0.03, "d3.phi": 1.0, "mb1.k_xx": -1e6, "mb1.k_yy": -1e6}
    given |= {"mb2.k_xx": -1e6, "mb2.k_yy": -1e6, "mb1.f_x": 50.0, "base.a_y": 2.0}
    folder = fmpy.extract(fmu)
    description = fmpy.read_model_description(folder)
    slave = FMU2Slave(
        guid=description.guid,
        unzipDirectory=folder,
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName="rotor",
    )
    core = Instance(*plant())
    interface = core.model.interface
    reals = [v.name for v in interface.of("output") if v.type == "Real"]
    integers = [v.name for v in interface.of("output") if v.type == "Integer"]

    def references(names):
        return [interface.position[name] for name in names]

    def outputs():
        return [*slave.getReal(references(reals)), *slave.getInteger(references(integers))]

    slave.instantiate()
    try:
        slave.setupExperiment(startTime=0.0)
        slave.setReal(references(fixed), list(fixed.values()))
        slave.setInteger(references(["contact.impact_law"]), [1])
        slave.enterInitializationMode()
        slave.exitInitializationMode()
        for name, value in fixed.items():
            core[name] = value
        core.initialise()
        different, modes = 0, set()
        for n in range(steps):
            inputs = dict(given) if n < steps // 2 else given | {"mb1.f_x": -50.0}
            slave.setReal(references(inputs), list(inputs.values()))
            slave.doStep(n * h, h)
            for name, value in inputs.items():
                core[name] = value
            core.step(n * h, h)
            different += outputs() != [core[name] for name in reals + integers]
            modes |= {core[f"{site}.mode"] for site in ("rb1", "rb2", "eb1", "eb2")}
        saved = slave.getFMUstate()
        slave.doStep(steps * h, h)
        once = outputs()
        slave.setFMUstate(saved)
        slave.freeFMUstate(saved)
        slave.doStep(steps * h, h)
        repeated = outputs() == once
        slave.terminate()
    finally:
        slave.freeInstance()
    return [different, sorted(modes), repeated]


def test_fmu_gives_bit_for_bit_what_the_core_gives_in_and_out_of_contact(fmu_file, run_python):
    different, modes, repeated = run_python(drive, timeout=120, fmu=str(fmu_file), steps=STEPS)
    assert different == 0
    assert {0.0, 1.0} <= set(modes)
    assert repeated


def test_validation_finds_no_problems(fmu_file):
    assert validate_fmu(str(fmu_file)) == []
