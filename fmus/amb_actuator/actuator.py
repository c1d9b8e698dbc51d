"""The actuator: four bearing axes, each with a linear force law, its gradient and a current limit."""

from __future__ import annotations

import math

from amb_actuator.force import current_stiffness, limited_current, negative_stiffness
from fmi_export.jit import kernel
from fmi_export.model import Array, Model
from fmi_export.variables import Variable, input_, interface, output, parameter

AXES = (("mb1", "x"), ("mb1", "y"), ("mb2", "x"), ("mb2", "y"))
LINEAR, MEASURED = 0, 1  # values of `force_law`

# Fig. 2.5: constants measured on the rig.
MEASURED_K_S = {"mb1": 1.944e6, "mb2": 2.156e6}
MEASURED_K_I = {"mb1": 544.0, "mb2": 539.0}


def _axis(bearing: str, axis: str) -> list[Variable]:
    """Variables of one axis; within each causality their order is the layout that `step` reads."""
    b, a = bearing, axis
    at = f"{b.upper()}, {a} axis"
    return [
        parameter(f"{b}.turns_{a}", "1", f"Turns per pole, {at} (Table 2.2)", 158.0, minimum=1.0),
        parameter(f"{b}.pole_area_{a}", "m2", f"Pole face area, {at} (Table 2.2)", 1399e-6, minimum=1e-9),
        parameter(f"{b}.gap_{a}", "m", f"Air gap, {at} (Table 2.2)", 1.2e-3, minimum=1e-6),
        parameter(
            f"{b}.half_angle_{a}",
            "rad",
            f"Half angle between the double pole faces, {at} (2.2)",
            math.radians(22.5),
            minimum=0.0,
            maximum=1.5,
        ),
        parameter(f"{b}.bias_current_{a}", "A", f"Bias current, {at} (Table 2.2)", 4.43, minimum=0.0),
        parameter(f"{b}.static_current_{a}", "A", f"Static current, {at} (Table 2.2)", 1.14, minimum=0.0),
        parameter(f"{b}.current_limit_{a}", "A", f"Largest coil current, {at} (Table 2.4)", 10.0, minimum=0.0),
        parameter(
            f"{b}.k_s_measured_{a}",
            "N/m",
            f"Negative stiffness for force_law 1, {at} (Fig. 2.5)",
            MEASURED_K_S[b],
        ),
        parameter(
            f"{b}.k_i_measured_{a}",
            "N/A",
            f"Current stiffness for force_law 1, {at} (Fig. 2.5)",
            MEASURED_K_I[b],
        ),
        input_(f"{b}.i_{a}", "A", f"Demanded control current, {at}"),
        input_(f"{b}.{a}", "m", f"Rotor displacement from the centre, {at}"),
        output(
            f"{b}.f_{a}",
            "N",
            f"Force on the rotor in excess of the static load, {at}",
            depends_on=(f"{b}.i_{a}", f"{b}.{a}"),
        ),
        output(f"{b}.k_{a}{a}", "N/m", f"Gradient of the force over displacement, {at}"),
        output(f"{b}.{a}_ref", "m", f"Displacement where the force was evaluated, {at}", depends_on=(f"{b}.{a}",)),
        output(f"{b}.i_upper_{a}", "A", f"Current of the upper coil pair, {at}", depends_on=(f"{b}.i_{a}",)),
        output(f"{b}.i_lower_{a}", "A", f"Current of the lower coil pair, {at}", depends_on=(f"{b}.i_{a}",)),
        output(
            f"{b}.clipped_{a}",
            "1",
            f"The demanded current was cut to the coil limits, {at}",
            type="Boolean",
            depends_on=(f"{b}.i_{a}",),
        ),
    ]


INTERFACE = interface(
    parameter(
        "force_law",
        "1",
        "Linear force law: 0 constants from the geometry (2.8, 2.9), 1 measured constants (Fig. 2.5)",
        LINEAR,
        minimum=0,
        maximum=1,
        type="Integer",
    ),
    *(_axis(bearing, axis) for bearing, axis in AXES),
    output("fault_code", "1", "0 while all is well; the log says what else means", type="Integer"),
)

N_AXES = len(AXES)
FORCE_LAW, AXIS = INTERFACE.parameter_index("force_law"), INTERFACE.parameter_index("mb1.turns_x")
AXIS_PARAMETERS = (INTERFACE.n_parameters - AXIS) // N_AXES
TURNS, POLE_AREA, GAP, HALF_ANGLE, BIAS, STATIC, LIMIT, K_S_MEASURED, K_I_MEASURED = range(AXIS_PARAMETERS)
AXIS_INPUTS = INTERFACE.n_inputs // N_AXES
DEMAND, DISPLACEMENT = range(AXIS_INPUTS)
AXIS_OUTPUTS = (INTERFACE.n_outputs - 1) // N_AXES
FORCE, GRADIENT, REFERENCE, UPPER, LOWER, CLIPPED = range(AXIS_OUTPUTS)

FAULT_GAP, FAULT_BIAS = 1, 11  # plus the axis


@kernel
def evaluate(parameters: Array, inputs: Array, outputs: Array) -> int:
    """All outputs for the present currents and displacements; F = K_s x + K_i I_c (2.7)."""
    for k in range(N_AXES):
        p = parameters[AXIS + k * AXIS_PARAMETERS : AXIS + (k + 1) * AXIS_PARAMETERS]
        u = inputs[k * AXIS_INPUTS : (k + 1) * AXIS_INPUTS]
        y = outputs[k * AXIS_OUTPUTS : (k + 1) * AXIS_OUTPUTS]
        if abs(u[DISPLACEMENT]) >= p[GAP]:
            return FAULT_GAP + k
        if p[STATIC] + p[BIAS] > p[LIMIT]:
            return FAULT_BIAS + k
        if parameters[FORCE_LAW] == MEASURED:
            k_s, k_i = p[K_S_MEASURED], p[K_I_MEASURED]
        else:
            k_s = negative_stiffness(p[TURNS], p[POLE_AREA], p[GAP], p[HALF_ANGLE], p[BIAS], p[STATIC])
            k_i = current_stiffness(p[TURNS], p[POLE_AREA], p[GAP], p[HALF_ANGLE], p[BIAS], p[STATIC])
        current = limited_current(u[DEMAND], p[BIAS], p[STATIC], p[LIMIT])
        y[FORCE] = k_s * u[DISPLACEMENT] + k_i * current
        y[GRADIENT] = k_s
        y[REFERENCE] = u[DISPLACEMENT]
        y[UPPER] = p[STATIC] + p[BIAS] + current
        y[LOWER] = p[BIAS] - current
        y[CLIPPED] = 1.0 if current != u[DEMAND] else 0.0
    return 0


@kernel
def initialise(constants: Array, parameters: Array, inputs: Array, state: Array, work: Array, outputs: Array) -> int:
    """The bearing has no memory: the outputs of the first inputs."""
    return evaluate(parameters, inputs, outputs)


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
    """Force at the beginning of the step, to be held, or extrapolated with its gradient, over the step."""
    return evaluate(parameters, inputs, outputs)


MODEL = Model(
    name="amb_actuator",
    description="Two radial active magnetic bearings: linear force law with current limits, force gradient",
    interface=INTERFACE,
    initialise=initialise,
    step=step,
    n_state=0,
    n_work=0,
    packages=("amb_actuator", "fmi_export"),
    faults={
        **{
            FAULT_GAP + k: f"{b}.{a} = {{{b}.{a}}} m is not allowed; the rotor must stay within the air gap, "
            f"|{b}.{a}| < {{{b}.gap_{a}}} m"
            for k, (b, a) in enumerate(AXES)
        },
        **{
            FAULT_BIAS + k: f"{b}.bias_current_{a} = {{{b}.bias_current_{a}}} A plus "
            f"{b}.static_current_{a} = {{{b}.static_current_{a}}} A is not allowed; "
            f"the sum must be <= {{{b}.current_limit_{a}}} A"
            for k, (b, a) in enumerate(AXES)
        },
    },
)
