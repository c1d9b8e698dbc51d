"""The controller: at each sample, its law acts on readings minus setpoints; demands are limited and delayed."""

from __future__ import annotations

import math

from fmi_export.flat import copy
from fmi_export.jit import inlined_kernel, kernel
from fmi_export.model import UNCHANGED, Array, Model
from linear_controller import PACKAGES, delay, law
from linear_controller.interface import interface_of
from linear_controller.matrices import LawMatrices, TableRows, find_bracket, matrices_of, sizes_of
from linear_controller.ports import Ports
from linear_controller.records import (
    Inputs,
    Outputs,
    Parameters,
    State,
    Work,
    inputs_of,
    linear_state,
    outputs_of,
    parameters_of,
    state_of,
    state_size,
    work_of,
    work_size,
)
from signal_chain.presets import is_on
from signal_chain.readings import read
from signal_chain.sampling import aligned, is_due, is_too_long

FAULT_LONG_STEP = 1
FAULT_LIMITS = 10  # plus the number of the demand


@kernel
def first_crossed(parameters: Parameters) -> int:
    """Return the number of the first demand with lower > upper, or -1 if there is none."""
    for i in range(parameters.demands.shape[0]):
        if parameters.demands[i].lower > parameters.demands[i].upper:
            return i
    return -1


@inlined_kernel
def observe(parameters: Parameters, inputs: Inputs, state: State, work: Work, sampling: bool) -> bool:
    """Write the errors e into `work.law_inputs`; return whether a reading is beyond the ADC range."""
    errors = work.law_inputs[state.x.shape[0] :]
    for s in range(errors.shape[0]):
        errors[s] = parameters.scales[s] * inputs.signals[s].measured
    started = state.head[0].n_samples > 0.0
    is_beyond = read(parameters.common[0], inputs.faults, state.sensors, started, sampling, errors)
    for s in range(errors.shape[0]):
        errors[s] -= inputs.signals[s].setpoint
    return is_beyond


@inlined_kernel
def compute(
    parameters: Parameters, inputs: Inputs, state: State, work: Work, matrices: LawMatrices, sampling: bool
) -> TableRows:
    """Compute the errors, write the demands into `state.last`, and return the table rows that were used.

    `sampling` is false at initialisation, which takes no sample.
    """
    head, common = state.head[0], inputs.common[0]
    bracket = find_bracket(matrices.speeds, common.Omega)
    head.speed_extrapolated = bracket.is_beyond
    head.adc_limited = observe(parameters, inputs, state, work, sampling)
    if head.n_samples == 0.0:
        law.start_states(parameters, matrices, bracket, state, work)
    else:
        law.fade_jump(parameters.common[0], state)
    if common.reset != 0.0 or common.enable == 0.0:
        law.reset_slow(matrices, bracket, state, work)
    law.evaluate(matrices, bracket, state, work)
    starts = head.was_on == 0.0 or (common.reset != 0.0 and head.was_reset == 0.0)
    is_transfer = common.enable != 0.0 and head.n_samples > 0.0 and starts
    head.demand_limited = law.limit(parameters, inputs, state, work, is_transfer)
    return bracket


@inlined_kernel
def take_sample(parameters: Parameters, inputs: Inputs, state: State, work: Work, matrices: LawMatrices) -> None:
    """Take one sample: compute the errors, the demands and the next sample's states."""
    head = state.head[0]
    bracket = compute(parameters, inputs, state, work, matrices, True)
    law.advance(matrices, bracket, state, work)
    delay.store_demands(state.history, int(head.n_samples), state.last)
    head.was_on = inputs.common[0].enable
    head.was_reset = inputs.common[0].reset
    head.n_samples += 1.0


@inlined_kernel
def write_outputs(matrices: LawMatrices, state: State, outputs: Outputs) -> None:
    """Write all outputs except the demands; the states are reordered from the blocks to the coordinates of the law."""
    head, common = state.head[0], outputs.common[0]
    common.adc_limited = head.adc_limited
    common.demand_limited = head.demand_limited
    common.speed_extrapolated = head.speed_extrapolated
    for k in range(state.x.shape[0]):
        outputs.states[int(matrices.order[k])] = state.x[k]


@kernel
def initialise(constants: Array, parameters: Array, inputs: Array, state: Array, work: Array, outputs: Array) -> int:
    """Compute the state and the outputs at the start, without taking a sample; arguments as in `Model.initialise`."""
    sizes, matrices = sizes_of(constants), matrices_of(constants)
    p, memory, y = parameters_of(parameters, sizes), state_of(state, sizes), outputs_of(outputs, sizes)
    crossed = first_crossed(p)
    if crossed >= 0:
        return FAULT_LIMITS + crossed
    compute(p, inputs_of(inputs, sizes), memory, work_of(work, sizes), matrices, False)
    delay.fill(memory.history, memory.last)
    write_outputs(matrices, memory, y)
    copy(memory.last, y.demands)
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
    """Take the sample that is due in the step, if any; for the arguments see `Model.step`."""
    sizes = sizes_of(constants)
    p, memory = parameters_of(parameters, sizes), state_of(state, sizes)
    common, head = p.common[0], memory.head[0]
    if is_too_long(time, step_size, common.sample_time):
        return FAULT_LONG_STEP
    head.begin = aligned(head.begin, head.n_samples, time, step_size, common.sample_time)
    late = common.delay + (1.0 if is_on(common.chain.preset, common.chain.delay) else 0.0)
    fraction = late - math.floor(late)
    due = is_due(head.begin + head.n_samples * common.sample_time, time, step_size, common.sample_time)
    if not due and fraction == 0.0:
        return UNCHANGED
    y, matrices = outputs_of(outputs, sizes), matrices_of(constants)
    if due:
        crossed = first_crossed(p)
        if crossed >= 0:
            return FAULT_LIMITS + crossed
        take_sample(p, inputs_of(inputs, sizes), memory, work_of(work, sizes), matrices)
    newest = head.n_samples - 1.0
    last = earlier = 1.0
    if fraction > 0.0:
        change = head.begin + (newest + fraction) * common.sample_time
        last = delay.share_after(change, time, step_size)
        earlier = delay.share_after(change - common.sample_time, time, step_size)
    write_outputs(matrices, memory, y)
    delay.write_delayed(memory.history, int(newest), late, (last, earlier), y.demands)
    return 0


def n_state(constants: Array) -> int:
    """Return the size of the state of a controller with these constants."""
    return state_size(sizes_of(constants))


def n_work(constants: Array) -> int:
    """Return the size of the work array of a controller with these constants."""
    return work_size(sizes_of(constants))


def model_for(ports: Ports, sample_time: float) -> Model:
    """Return the controller with these ports; its constants are laid out as in `matrices`.

    Parameters
    ----------
    ports
        Names of signals and demands, and number of states.
    sample_time
        Time between samples (s); the matrices must be designed for it.
    """
    crossed = {
        FAULT_LIMITS + i: f"{name}.lower = {{{name}.lower}} A is not allowed; it must be <= {name}.upper = "
        f"{{{name}.upper}} A"
        for i, name in enumerate(ports.demands)
    }
    long_step = (
        "step size = {step_size} s is not allowed; it must be <= sample_time = {sample_time} s, because the inputs of "
        "a step serve one sample"
    )
    return Model(
        name="linear_controller",
        description="Sampled linear controller with limits, a delay and a signal chain",
        author="The amb-cosim authors",
        interface=interface_of(ports, sample_time),
        initialise=initialise,
        step=step,
        n_state=n_state,
        n_work=n_work,
        packages=PACKAGES,
        faults={FAULT_LONG_STEP: long_step, **crossed},
        step_size=sample_time,
        layout=ports.layout(),
        linear_state=linear_state,
    )
