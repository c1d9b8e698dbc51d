"""First-order lag with everything that an export can get wrong: state, all types, ranges, faults, a NaN."""

import math

from fmi_export.interface import interface
from fmi_export.jit import kernel
from fmi_export.model import Array, Model
from fmi_export.variables import input_, output, parameter

INTERFACE = interface(
    parameter("time_constant", "s", "Time constant", 1e-3, minimum=1e-6),
    parameter("gain", "1", "Gain, may change at any time", 1.0, tunable=True),
    parameter("offset", "1", "Added to the output in whole numbers", 0, type="Integer", minimum=-5, maximum=5),
    input_("u", "V", "What the output follows", minimum=-10.0, maximum=10.0),
    input_("hold", "1", "Stop following", type="Boolean"),
    output("y", "V", "Output", depends_on=()),
    output("level", "V", "Twice the input, declared to stay below 12", maximum=12.0, depends_on=("u",)),
    output("steps", "1", "Steps since the start", type="Integer", over_step="largest"),
    output("held", "1", "The hold input of the last step", type="Boolean", depends_on=("hold",)),
    output(
        "high",
        "1",
        "The input is above 3 V",
        type="Boolean",
        depends_on=("u",),
        warning="u = {u} V is above 3 V, half of what is allowed (100 %)",
    ),
    output("fault_code", "1", "0 while all is well", type="Integer"),
)
TOO_MUCH = 1
NOT_A_NUMBER_AT = -7.0


@kernel
def outputs_of(parameters: Array, inputs: Array, state: Array, outputs: Array) -> int:
    if inputs[0] == 5.0:
        return TOO_MUCH
    outputs[0] = math.nan if inputs[0] == NOT_A_NUMBER_AT else state[0] + parameters[2]
    outputs[1] = 2.0 * inputs[0]
    outputs[2] = state[1]
    outputs[3] = inputs[1]
    outputs[4] = inputs[0] > 3.0
    return 0


@kernel
def initialise(constants: Array, parameters: Array, inputs: Array, state: Array, work: Array, outputs: Array) -> int:
    state[0] = constants[0]
    return outputs_of(parameters, inputs, state, outputs)


@kernel
def step(
    constants: Array,
    parameters: Array,
    inputs: Array,
    state: Array,
    work: Array,
    outputs: Array,
    time: float,
    step_size: float,
) -> int:
    state[1] += 1.0
    if inputs[1] == 0.0:
        share = 1.0 - math.exp(-step_size / parameters[0])
        state[0] += share * (parameters[1] * inputs[0] - state[0])
    return outputs_of(parameters, inputs, state, outputs)


MODEL = Model(
    name="probe_lag",
    description="First-order lag for the tests of the export",
    interface=INTERFACE,
    initialise=initialise,
    step=step,
    n_state=2,
    n_work=0,
    packages=("probe_lag", "fmi_export"),
    faults={TOO_MUCH: "u = {u} V is 100 % too much (%s %n)"},
)
