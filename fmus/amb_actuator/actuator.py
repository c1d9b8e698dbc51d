"""The actuator: four bearing axes, from demanded currents and displacements to forces and their gradients."""

from __future__ import annotations

from amb_actuator.amplifier import Drive, coil_at_start, coil_step, commanded_current, demanded_current
from amb_actuator.force import Coils, beyond_knee, force
from amb_actuator.interface import (
    AMPLIFIER,
    AXES,
    AXIS,
    AXIS_INPUTS,
    AXIS_OUTPUTS,
    AXIS_PARAMETERS,
    BIAS,
    CLIPPED,
    COPPER_LOSS,
    CURRENT_LIMIT,
    DISPLACEMENT,
    DYNAMIC,
    FORCE,
    FORCE_LAW,
    GAP,
    GRADIENT,
    INTERFACE,
    LOWER,
    LOWER_LOSS,
    LOWER_VOLTAGE,
    MEAN_CURRENT,
    N_AXES,
    REFERENCE,
    RESISTANCE,
    SATURATED,
    STATIC,
    UPPER,
    UPPER_LOSS,
    UPPER_VOLTAGE,
    VOLTAGE_LIMIT,
    VOLTAGE_LIMITED,
)
from fmi_export.jit import kernel
from fmi_export.model import Array, Model

__all__ = ["INTERFACE", "MODEL"]

# State of an axis: how far the coil currents are from the operating point, see `Coils`.
AXIS_STATE = 2
UPPER_DEVIATION, LOWER_DEVIATION = range(AXIS_STATE)

FAULT_GAP, FAULT_BIAS, FAULT_VOLTAGE = 1, 11, 21  # plus the axis


@kernel
def check(parameters: Array, inputs: Array) -> int:
    """First fault among the axes, or 0."""
    for k in range(N_AXES):
        p = parameters[AXIS + k * AXIS_PARAMETERS : AXIS + (k + 1) * AXIS_PARAMETERS]
        operating = p[STATIC] + p[BIAS]
        if abs(inputs[k * AXIS_INPUTS + DISPLACEMENT]) >= p[GAP]:
            return FAULT_GAP + k
        if operating > p[CURRENT_LIMIT]:
            return FAULT_BIAS + k
        if parameters[AMPLIFIER] == DYNAMIC and p[RESISTANCE] * operating > p[VOLTAGE_LIMIT]:
            return FAULT_VOLTAGE + k
    return 0


@kernel
def write_outputs(mode: Array, p: Array, u: Array, i_c: float, upper: Drive, lower: Drive, y: Array) -> None:
    """Outputs of one axis from its two coil pairs.

    Parameters
    ----------
    mode
        The parameters that all axes share, at the positions of the table.
    p, u, y
        Parameters, inputs and outputs of the axis, in the order of the table.
    i_c
        Commanded control current (A).
    upper, lower
        Its coil pairs, with deviations from the operating point as currents.
    """
    x = u[DISPLACEMENT]
    coils = Coils(upper.current, lower.current, 1.0 - u[UPPER_LOSS], 1.0 - u[LOWER_LOSS])
    if mode[MEAN_CURRENT] != 0.0:
        coils = Coils(upper.mean, lower.mean, coils.upper_turns, coils.lower_turns)
    y[FORCE], y[GRADIENT] = force(mode[FORCE_LAW], p, x, coils)
    y[REFERENCE] = x
    y[UPPER] = p[STATIC] + p[BIAS] + upper.current
    y[LOWER] = p[BIAS] - lower.current
    y[CLIPPED] = 1.0 if i_c != demanded_current(p, u) else 0.0
    y[SATURATED] = 1.0 if beyond_knee(p, x, coils) else 0.0
    y[VOLTAGE_LIMITED] = max(upper.limited, lower.limited)
    y[UPPER_VOLTAGE] = upper.voltage
    y[LOWER_VOLTAGE] = lower.voltage
    y[COPPER_LOSS] = p[RESISTANCE] * (y[UPPER] * y[UPPER] + y[LOWER] * y[LOWER])


@kernel
def initialise(constants: Array, parameters: Array, inputs: Array, state: Array, work: Array, outputs: Array) -> int:
    """Currents as the first inputs command them, as if they had done so for long."""
    fault = check(parameters, inputs)
    if fault != 0:
        return fault
    for k in range(N_AXES):
        p = parameters[AXIS + k * AXIS_PARAMETERS : AXIS + (k + 1) * AXIS_PARAMETERS]
        u = inputs[k * AXIS_INPUTS : (k + 1) * AXIS_INPUTS]
        i_c = commanded_current(p, u, parameters[AMPLIFIER])
        upper = coil_at_start(p, u, p[STATIC] + p[BIAS], 1.0, i_c)
        lower = coil_at_start(p, u, p[BIAS], -1.0, i_c)
        state[k * AXIS_STATE + UPPER_DEVIATION] = upper.current
        state[k * AXIS_STATE + LOWER_DEVIATION] = lower.current
        write_outputs(parameters, p, u, i_c, upper, lower, outputs[k * AXIS_OUTPUTS : (k + 1) * AXIS_OUTPUTS])
    return 0


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
    """Advance the currents by `step_size` (s) under constant inputs; forces at the displacement that was given."""
    fault = check(parameters, inputs)
    if fault != 0:
        return fault
    amplifier = parameters[AMPLIFIER]
    for k in range(N_AXES):
        p = parameters[AXIS + k * AXIS_PARAMETERS : AXIS + (k + 1) * AXIS_PARAMETERS]
        u = inputs[k * AXIS_INPUTS : (k + 1) * AXIS_INPUTS]
        d = state[k * AXIS_STATE : (k + 1) * AXIS_STATE]
        i_c = commanded_current(p, u, amplifier)
        upper = coil_step(p, u, amplifier, p[STATIC] + p[BIAS], 1.0, d[UPPER_DEVIATION], i_c, step_size)
        lower = coil_step(p, u, amplifier, p[BIAS], -1.0, d[LOWER_DEVIATION], i_c, step_size)
        d[UPPER_DEVIATION] = upper.current
        d[LOWER_DEVIATION] = lower.current
        write_outputs(parameters, p, u, i_c, upper, lower, outputs[k * AXIS_OUTPUTS : (k + 1) * AXIS_OUTPUTS])
    return 0


def _fault_sentences() -> dict[int, str]:
    sentences = {}
    for k, (b, a) in enumerate(AXES):
        operating = f"{b}.bias_current_{a} = {{{b}.bias_current_{a}}} A plus "
        operating += f"{b}.static_current_{a} = {{{b}.static_current_{a}}} A"
        sentences[FAULT_GAP + k] = (
            f"{b}.{a} = {{{b}.{a}}} m is not allowed; the rotor must stay within the air gap, "
            f"|{b}.{a}| < {{{b}.gap_{a}}} m"
        )
        sentences[FAULT_BIAS + k] = f"{operating} is not allowed; the sum must be <= {{{b}.current_limit_{a}}} A"
        sentences[FAULT_VOLTAGE + k] = (
            f"{b}.voltage_limit_{a} = {{{b}.voltage_limit_{a}}} V is not allowed; it must drive {operating} "
            f"through {b}.resistance_{a} = {{{b}.resistance_{a}}} Ohm"
        )
    return sentences


MODEL = Model(
    name="amb_actuator",
    description="Two radial active magnetic bearings: force laws with gradient, saturation, amplifiers, faults",
    interface=INTERFACE,
    initialise=initialise,
    step=step,
    n_state=N_AXES * AXIS_STATE,
    n_work=0,
    packages=("amb_actuator", "fmi_export"),
    faults=_fault_sentences(),
)
