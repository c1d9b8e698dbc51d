"""The FMU: validation, equality with the core, state, refusals."""

from __future__ import annotations

import math
from contextlib import suppress
from typing import ClassVar

import fmpy
import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import FMU2Slave, fmi2True
from fmpy.validation import validate_fmu
from rig import CONTROLLER, pack

from fmi_export.building.identity import guid_of
from fmi_export.model import Instance
from rolac_controller.enumerations import ADAPTING, IDENTIFYING, NO_WINDOW, NOT_STARTED, SENSOR_SUSPECT, SLOT_BEFORE

INTERFACE = CONTROLLER.interface

H = 250e-6
SPEED = 2.0 * math.pi * 30.3
GIVEN = [f"s{k}" for k in range(1, 9)] + ["Omega", "theta"]
OUTPUTS = [v.name for v in INTERFACE.of("output") if v.type == "Real"]
NUMBERS = [v.name for v in INTERFACE.of("output") if v.type == "Integer"]


@pytest.fixture(scope="module")
def table():
    rng = np.random.default_rng(7)
    r = 1e-6 * (rng.normal(size=(2, 8, 4)) + 1j * rng.normal(size=(2, 8, 4)))
    return pack([50.0, 400.0], r)


@pytest.fixture(scope="module")
def fmu_file(table, build_fmu):
    return build_fmu(CONTROLLER, table)


@pytest.fixture(scope="module")
def unpacked(fmu_file, tmp_path_factory):
    folder = tmp_path_factory.mktemp("unpacked")
    fmpy.extract(fmu_file, folder)
    return folder


@pytest.fixture
def fmu(unpacked):
    """An instance in initialisation mode; terminated and freed whatever happens."""
    description = fmpy.read_model_description(unpacked)
    slave = FMU2Slave(
        guid=description.guid,
        unzipDirectory=str(unpacked),
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName="controller",
    )
    slave.instantiate()
    try:
        slave.setupExperiment(startTime=0.0)
        slave.enterInitializationMode()
        yield slave
        with suppress(FMICallException):  # after a fault
            slave.terminate()
    finally:
        slave.freeInstance()


def references(names):
    return [INTERFACE.position[name] for name in names]


def signals(n):
    theta = SPEED * n * H
    return [*(1e-4 * np.cos(theta + np.arange(8.0)) + 1e-5), SPEED, theta % (2.0 * math.pi)]


def advance(fmu, first, last):
    """Outputs of samples `first` to `last` - 1."""
    rows = []
    for n in range(first, last):
        fmu.setReal(references(GIVEN), signals(n))
        fmu.doStep(n * H, H)
        rows.append(fmu.getReal(references(OUTPUTS)))
    return np.array(rows)


def test_validation_finds_no_problems(fmu_file):
    assert validate_fmu(fmu_file) == []


def test_fmu_gives_what_the_core_gives(fmu, table):
    core = Instance(CONTROLLER, table)
    enable = references(["rolac_enable"])
    for name, value in [("mb1.k_integral_x", 1e6), ("derivative_time", 1e-3)]:
        fmu.setReal(references([name]), [value])
        core[name] = value
    fmu.exitInitializationMode()
    core.initialise()
    for n in range(1000):
        if n == 300:
            fmu.setBoolean(enable, [fmi2True])
            core["rolac_enable"] = 1.0
        row = advance(fmu, n, n + 1)[0]
        for name, value in zip(GIVEN, signals(n), strict=True):
            core[name] = value
        core.step(n * H, H)
        np.testing.assert_array_equal(row, [core[name] for name in OUTPUTS])
    assert core["rolac_active"] == 1.0
    assert core["harmonic1.force"] > 1.0
    assert list(fmu.getBoolean(references(["rolac_active", "window_valid"]))) == [fmi2True, fmi2True]
    assert core["mb1.u_x"] > 1.0


class Both:
    """The FMU and its core, set alike."""

    SETTERS: ClassVar = {"Real": "setReal", "Integer": "setInteger", "Boolean": "setBoolean"}

    def __init__(self, fmu, core):
        self.fmu, self.core = fmu, core

    def set(self, **values):
        for name, value in ((name.replace("__", "."), value) for name, value in values.items()):
            getattr(self.fmu, self.SETTERS[INTERFACE[name].type])(references([name]), [value])
            self.core[name] = value


@pytest.mark.parametrize("mode", [0, 1, 2, 3])
def test_fmu_of_the_rig_equals_the_core_while_it_identifies_and_adapts(fmu, table, mode):
    """With noise, filter, converters, delay, a fault and contact; every output, bit for bit."""
    both = Both(fmu, Instance(CONTROLLER, table))
    core = both.core
    both.set(sample_time=1e-3, chain__preset=1, chain__seed=77, rolac__mode=mode, contact__source=2, contact__aware=1)
    both.set(rolac_enable=1, contact_state=1)
    fmu.exitInitializationMode()
    core.initialise()
    stages = set()
    for n in range(2000):
        if n == 600:
            both.set(contact_state=0)
        if n == 800:
            both.set(identify=1)
        if n == 1500:
            both.set(s3__fault_stuck=1)
        both.set(**dict(zip(GIVEN, signals(4 * n), strict=True)))  # 1 ms apart
        fmu.doStep(n * 1e-3, 1e-3)
        core.step(n * 1e-3, 1e-3)
        np.testing.assert_array_equal(fmu.getReal(references(OUTPUTS)), [core[name] for name in OUTPUTS])
        numbers = fmu.getInteger(references(NUMBERS))
        assert numbers == [core[name] for name in NUMBERS]
        stages.add((core["rolac_status"], core["identification_state"]))
    assert stages == {
        (NO_WINDOW, NOT_STARTED),
        (ADAPTING, NOT_STARTED),
        (IDENTIFYING, SLOT_BEFORE),
        (SENSOR_SUSPECT, SLOT_BEFORE),
    }
    assert core["mb1.contact_share"] > 0.0


def test_serialised_state_brings_back_window_and_forces(fmu):
    fmu.setBoolean(references(["rolac_enable"]), [fmi2True])
    fmu.exitInitializationMode()
    advance(fmu, 0, 400)
    state = fmu.getFMUstate()
    saved = fmu.serializeFMUstate(state)
    fmu.freeFMUstate(state)
    once = advance(fmu, 400, 600)
    assert fmu.getReal(references(["mb1.u_x"]))[0] > 1.0
    state = fmu.deSerializeFMUstate(saved)
    fmu.setFMUstate(state)
    fmu.freeFMUstate(state)
    np.testing.assert_array_equal(advance(fmu, 400, 600), once)


def test_initial_currents_are_those_of_the_first_displacements(fmu):
    fmu.setReal(references(["s5"]), [1e-5])
    current = fmu.getReal(references(["mb1.i_x"]))[0]
    assert current == pytest.approx(-(1e6 + 2376955.71608877) * 1e-5 / 563.150665808, rel=1e-9)
    fmu.exitInitializationMode()


def test_refused_step_sets_the_fault_code(fmu):
    fmu.exitInitializationMode()
    with pytest.raises(FMICallException):
        fmu.doStep(0.0, 2 * H)
    assert fmu.getInteger(references(["fault_code"])) == [1]


def test_guid_changes_with_the_table(table):
    assert guid_of(CONTROLLER, table) != guid_of(CONTROLLER, 1.01 * table)


def test_fmu_says_that_its_step_may_vary(unpacked):
    description = fmpy.read_model_description(unpacked)
    assert description.coSimulation.canHandleVariableCommunicationStepSize
    assert float(description.defaultExperiment.stepSize) == H


def test_wrong_parameters_are_refused_at_initialisation(fmu):
    fmu.setInteger(references(["harmonic2.order"]), [1])
    with pytest.raises(FMICallException):
        fmu.exitInitializationMode()
    assert fmu.getInteger(references(["fault_code"])) == [3]
    with pytest.raises(FMICallException):
        fmu.doStep(0.0, H)


def test_identified_receptance_can_be_read_and_comes_back_with_the_state(fmu):
    """A serialised state holds an identification that is under way, and the table that it will renew."""
    h = 1.0 / 300.0
    fmu.setReal(references(["sample_time", "rolac.min_speed"]), [h, 1.0])
    fmu.setBoolean(references(["identify"]), [fmi2True])
    fmu.exitInitializationMode()
    receptance = [
        f"r.s{k}.{b}_{a}.{part}" for k in range(1, 9) for b in ("mb1", "mb2") for a in "xy" for part in ("re", "im")
    ]
    currents = [f"{b}.i_{a}" for b in ("mb1", "mb2") for a in "xy"]
    k_i = INTERFACE["mb1.k_i_x"].start

    def run(first, last):
        force = np.zeros(4)
        for n in range(first, last):
            turn = 2.0 * math.pi * n / 20.0
            q = 1e-7 * (np.arange(1, 33).reshape(8, 4) % 7) @ force
            fmu.setReal(references(GIVEN), [*q, 2.0 * math.pi * 15.0, turn % (2.0 * math.pi)])
            fmu.doStep(n * h, h)
            force = k_i * np.array(fmu.getReal(references(currents)))
        return fmu.getReal(references([*receptance, "condition_number", "identification_progress"]))

    fmu.setReal(
        references([f"{b}.{g}_{a}" for b in ("mb1", "mb2") for a in "xy" for g in ("k_b", "k_s", "c_b")]), [0.0] * 12
    )
    run(0, 3000)
    state = fmu.getFMUstate()
    saved = fmu.serializeFMUstate(state)
    fmu.freeFMUstate(state)
    once = run(3000, 5500)
    assert once[-1] == 1.0
    assert np.abs(once[:64]).max() > 1e-8
    state = fmu.deSerializeFMUstate(saved)
    fmu.setFMUstate(state)
    fmu.freeFMUstate(state)
    assert run(3000, 5500) == once
