"""Directional derivatives that the plant of a compressor gives over a step, against its linear model; and contact."""

from ctypes import byref
from functools import partial

import fmpy
import numpy as np
import pytest
from fmpy.fmi1 import FMICallException, printLogMessage
from fmpy.fmi2 import FMU2Slave, defaultCallbacks, fmi2CallbackFunctions, fmi2CallbackLoggerTYPE
from fmpy.logging import addLoggerProxy

import amb_cosim
from amb_analysis.linear.components import LinearComponent, sampled
from amb_cosim.controllers.laws import Law
from amb_cosim.cosim.fmu.fmus import provide

H = 1e-4
OUTPUTS = [f"{bearing}.{axis}" for bearing in ("mb1", "mb2") for axis in "xy"]
INPUTS = ["impeller3.f_x", "mb1.f_x", "mb2.f_y", "base.a_x"]
OMEGA = 942.5  # rad/s
SETTLING = 100  # steps


@pytest.fixture
def plant():
    """The plant, at rest for so long that it moves exactly, and references by name."""
    fmu = provide("rotor_contact", rotor="compressor")
    described = fmpy.read_model_description(str(fmu.folder))
    identifier = described.coSimulation.modelIdentifier
    slave = FMU2Slave(
        guid=described.guid, unzipDirectory=str(fmu.folder), modelIdentifier=identifier, instanceName="plant"
    )
    # Those of fmpy forward to the logger of whoever used it last in this process, which may be gone.
    callbacks = fmi2CallbackFunctions()
    callbacks.logger = fmi2CallbackLoggerTYPE(printLogMessage)
    callbacks.allocateMemory, callbacks.freeMemory = defaultCallbacks.allocateMemory, defaultCallbacks.freeMemory
    addLoggerProxy(byref(callbacks))
    slave.instantiate(callbacks=callbacks)
    slave.setupExperiment()
    slave.enterInitializationMode()
    references = {v.name: v.valueReference for v in described.modelVariables}
    slave.setReal([references["Omega"]], [OMEGA])
    slave.exitInitializationMode()
    for n in range(SETTLING):
        slave.doStep(n * H, H)
    yield slave, references
    slave.freeInstance()


def derivatives(plant, unknowns, knowns):
    """J, shape (unknowns, knowns), a direction for each column."""
    slave, references = plant
    outputs = [references[name] for name in unknowns]
    return np.array([slave.getDirectionalDerivative(outputs, [references[name]], [1.0]) for name in knowns]).T


def test_derivatives_of_the_plant_are_its_linear_model_over_a_step(plant):
    """To 1e-9 of the largest; D of the sampled model at the end of the step is C Gamma."""
    model = amb_cosim.linearise("compressor_levitated", OMEGA, components=["rotor_contact"])
    names = partial(map, "rotor_contact.{}".format)
    law = sampled(LinearComponent(Law(model.A, model.B, model.C, model.D), model.input_names, model.output_names), H)
    part = law.selected(list(names(INPUTS)), list(names(OUTPUTS))).law
    result = derivatives(plant, OUTPUTS, INPUTS)
    expected = part.C @ part.B
    size = np.abs(expected).max(axis=0)
    assert size.min() > 0.0
    np.testing.assert_allclose(result / size, expected / size, rtol=0.0, atol=1e-9)


def test_no_derivative_exists_where_contact_begins(plant):
    """An impulse that takes the journal to its retainer at the end of a step; with a larger one it rebounds."""
    slave, references = plant
    start, push, touching = slave.getFMUstate(), references["mb1.f_x"], references["contact_state"]
    low, high = 0.0, 1e8  # N
    for _ in range(80):
        middle = 0.5 * (low + high)
        slave.setFMUstate(start)
        slave.setReal([push], [middle])
        slave.doStep(SETTLING * H, H)
        low, high = (low, middle) if slave.getInteger([touching])[0] else (middle, high)
    slave.setFMUstate(start)
    slave.setReal([push], [0.9 * low])
    free = derivatives(plant, ["mb1.x"], ["mb1.f_x"])
    slave.setReal([push], [0.0])
    np.testing.assert_allclose(derivatives(plant, ["mb1.x"], ["mb1.f_x"]), free, rtol=1e-7)  # of 1e8 N
    slave.setReal([push], [low])
    with pytest.raises(FMICallException):
        derivatives(plant, ["mb1.x"], ["mb1.f_x"])
    slave.freeFMUstate(start)
