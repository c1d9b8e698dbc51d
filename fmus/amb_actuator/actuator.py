"""The actuator: four bearing axes, from demanded currents and displacements to forces and their gradients."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from amb_actuator.amplifier import (
    CoilPair,
    CoilResponse,
    coil_step,
    commanded_current,
    demanded_current,
    steady_coil,
)
from amb_actuator.force import Coils, force, is_beyond_knee
from amb_actuator.interface import AXES, DYNAMIC, INPUTS, INTERFACE, N_AXES, OUTPUTS, PARAMETERS
from fmi_export.jit import kernel
from fmi_export.model import Array, Model
from fmi_export.records import record, size_of

__all__ = ["INTERFACE", "MODEL", "STATE"]

# Deviations of the coil currents of an axis from the operating point (A), see `Coils`.
DEVIATIONS = record(("upper", "f8"), ("lower", "f8"))
STATE = record(("axes", DEVIATIONS, N_AXES))

FAULT_GAP, FAULT_BIAS, FAULT_VOLTAGE = 1, 11, 21  # plus the position of the axis, 0 to 3


class AxisResponse(NamedTuple):
    """Commanded control current of an axis (A) and how its two coil pairs respond to it."""

    i_c: float
    upper: CoilResponse
    lower: CoilResponse


@kernel
def check(p: np.record, u: np.record) -> int:
    """Return the first fault among the axes, or 0.

    Parameters
    ----------
    p, u
        Parameters and inputs of the actuator.
    """
    for k in range(N_AXES):
        axis = p.axes[k]
        operating_current = axis.static_current + axis.bias_current
        if abs(u.axes[k].displacement) >= axis.gap:
            return FAULT_GAP + k
        if operating_current > axis.current_limit:
            return FAULT_BIAS + k
        if p.amplifier == DYNAMIC and axis.resistance * operating_current > axis.voltage_limit:
            return FAULT_VOLTAGE + k
    return 0


@kernel
def write_outputs(p: np.record, axis: np.record, u: np.record, response: AxisResponse, y: np.record) -> None:
    """Write the outputs of one axis from the response of its two coil pairs.

    Parameters
    ----------
    p
        Parameters of the actuator, for those that all axes share.
    axis, u, y
        Parameters, inputs and outputs of the axis.
    response
        Its coil pairs, with deviations from the operating point as currents.
    """
    x, upper, lower = u.displacement, response.upper, response.lower
    coils = Coils(upper.current, lower.current, 1.0 - u.coil_loss_upper, 1.0 - u.coil_loss_lower)
    if p.mean_current != 0.0:
        coils = Coils(upper.mean, lower.mean, coils.upper_turns, coils.lower_turns)
    y.force, y.gradient = force(p.force_law, axis, x, coils)
    y.reference = x
    upper_current = axis.static_current + axis.bias_current + upper.current
    lower_current = axis.bias_current - lower.current
    y.upper_current, y.lower_current = upper_current, lower_current
    y.clipped = 1.0 if response.i_c != demanded_current(axis, u) else 0.0
    y.saturated = 1.0 if is_beyond_knee(axis, x, coils) else 0.0
    y.voltage_limited = max(upper.limited, lower.limited)
    y.upper_voltage = upper.voltage
    y.lower_voltage = lower.voltage
    y.copper_loss = axis.resistance * (upper_current * upper_current + lower_current * lower_current)


@kernel
def initialise(constants: Array, parameters: Array, inputs: Array, state: Array, work: Array, outputs: Array) -> int:
    """Set the coil currents to the steady state of the first command, and return the fault code."""
    p, u = parameters.view(PARAMETERS)[0], inputs.view(INPUTS)[0]
    s, y = state.view(STATE)[0], outputs.view(OUTPUTS)[0]
    fault = check(p, u)
    if fault != 0:
        return fault
    for k in range(N_AXES):
        axis = p.axes[k]
        i_c = commanded_current(axis, u.axes[k], p.amplifier)
        upper = steady_coil(axis, u.axes[k], CoilPair(axis.static_current + axis.bias_current, 1.0, 0.0), i_c)
        lower = steady_coil(axis, u.axes[k], CoilPair(axis.bias_current, -1.0, 0.0), i_c)
        s.axes[k].upper, s.axes[k].lower = upper.current, lower.current
        write_outputs(p, axis, u.axes[k], AxisResponse(i_c, upper, lower), y.axes[k])
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
    """Advance the coil currents by `step_size` (s) under constant inputs, and return the fault code.

    The force is that at the displacement that was given.
    """
    p, u = parameters.view(PARAMETERS)[0], inputs.view(INPUTS)[0]
    s, y = state.view(STATE)[0], outputs.view(OUTPUTS)[0]
    fault = check(p, u)
    if fault != 0:
        return fault
    for k in range(N_AXES):
        axis, deviation = p.axes[k], s.axes[k]
        i_c = commanded_current(axis, u.axes[k], p.amplifier)
        upper_pair = CoilPair(axis.static_current + axis.bias_current, 1.0, deviation.upper)
        lower_pair = CoilPair(axis.bias_current, -1.0, deviation.lower)
        upper = coil_step(axis, u.axes[k], upper_pair, i_c, p.amplifier, step_size)
        lower = coil_step(axis, u.axes[k], lower_pair, i_c, p.amplifier, step_size)
        deviation.upper, deviation.lower = upper.current, lower.current
        write_outputs(p, axis, u.axes[k], AxisResponse(i_c, upper, lower), y.axes[k])
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
    n_state=size_of(STATE),
    n_work=0,
    packages=("amb_actuator", "fmi_export"),
    faults=_fault_sentences(),
)
