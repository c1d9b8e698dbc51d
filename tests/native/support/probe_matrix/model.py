"""A matrix times a vector, and one array of each type."""

from fmi_export.interface import interface, repeated
from fmi_export.jit import kernel
from fmi_export.model import Array as Numbers
from fmi_export.model import Model
from fmi_export.variables import Array, Variable, input_, output, parameter

ROWS, COLUMNS = 2, 3
CELLS = [(i, j) for i in range(ROWS) for j in range(COLUMNS)]
PAIRS = [(i, j) for i in range(2) for j in range(2)]
TOO_MUCH = 1


def gain(i: int, j: int) -> list[Variable]:
    return [parameter(f"g{i}{j}", "N/m", "Gain", 10.0 * i + j, tunable=True, field=".")]


def displacement(j: int) -> list[Variable]:
    return [input_(f"u{j}", "m", "Displacement", minimum=-10.0, maximum=10.0, field=".")]


def count(i: int) -> list[Variable]:
    return [input_(f"n{i}", "1", "Number", type="Integer", field=".")]


def switch(i: int) -> list[Variable]:
    return [input_(f"on{i}", "1", "Switch", type="Boolean", field=".")]


def force(i: int) -> list[Variable]:
    return [output(f"f{i}", "N", "Force", depends_on=tuple(f"u{j}" for j in range(COLUMNS)), field=".")]


def counted(i: int) -> list[Variable]:
    return [output(f"twice{i}", "1", "Twice the number", type="Integer", depends_on=(f"n{i}",), field=".")]


def switched(i: int) -> list[Variable]:
    return [output(f"off{i}", "1", "The switch is off", type="Boolean", depends_on=(f"on{i}",), field=".")]


def product(i: int, j: int) -> list[Variable]:
    depends_on = (f"u{i}", f"u{j}")
    return [output(f"z.{i}{j}.{part}", "m2", "Product", depends_on=depends_on) for part in ("re", "im")]


INTERFACE = interface(
    parameter("limit", "m", "Largest first displacement", 5.0),
    repeated("gains", CELLS, gain, shape=(ROWS, COLUMNS), array=Array("gains", "Gains, by force and displacement")),
    repeated("u", [(j,) for j in range(COLUMNS)], displacement, array=Array("u", "Displacements")),
    repeated("n", [(0,), (1,)], count, array=Array("n", "Numbers")),
    repeated("on", [(0,), (1,)], switch, array=Array("on", "Switches")),
    output("elapsed", "s", "Time that was stepped"),
    repeated("f", [(0,), (1,)], force, array=Array("f", "Forces")),
    repeated("twice", [(0,), (1,)], counted, array=Array("twice", "Twice the numbers")),
    repeated("off", [(0,), (1,)], switched, array=Array("off", "Switches that are off")),
    repeated("z", PAIRS, product, shape=(2, 2), array=Array("z", "Products, real and imaginary")),
    output("fault_code", "1", "0 while all is well", type="Integer"),
)


@kernel
def outputs_of(parameters: Numbers, inputs: Numbers, state: Numbers, outputs: Numbers) -> int:
    if inputs[0] > parameters[0]:
        return TOO_MUCH
    outputs[0] = state[0]
    for i in range(2):
        outputs[1 + i] = 0.0
        for j in range(3):
            outputs[1 + i] += parameters[1 + 3 * i + j] * inputs[j]
        outputs[3 + i] = 2.0 * inputs[3 + i]
        outputs[5 + i] = 1.0 - inputs[5 + i]
        for j in range(2):
            outputs[7 + 4 * i + 2 * j] = inputs[i] * inputs[j]
            outputs[8 + 4 * i + 2 * j] = inputs[i] - inputs[j]
    return 0


@kernel
def initialise(
    constants: Numbers, parameters: Numbers, inputs: Numbers, state: Numbers, work: Numbers, outputs: Numbers
) -> int:
    return outputs_of(parameters, inputs, state, outputs)


@kernel
def step(
    constants: Numbers,
    parameters: Numbers,
    inputs: Numbers,
    state: Numbers,
    work: Numbers,
    outputs: Numbers,
    time: float,
    step_size: float,
) -> int:
    state[0] += step_size
    return outputs_of(parameters, inputs, state, outputs)


MODEL = Model(
    name="probe_matrix",
    description="A matrix times a vector",
    interface=INTERFACE,
    initialise=initialise,
    step=step,
    n_state=1,
    n_work=0,
    packages=("probe_matrix", "fmi_export"),
    faults={TOO_MUCH: "u0 = {u0} m is above {limit} m, 100 % #1"},
)
