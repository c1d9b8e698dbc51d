"""Views of an instance's arrays for kernels: records of single variables, and arrays of repeated variables."""

from __future__ import annotations

from typing import NamedTuple

from fmi_export.jit import views
from fmi_export.linear_state import LinearState
from fmi_export.model import Array
from fmi_export.parts import part
from fmi_export.records import record, size_of
from linear_controller.delay import N_HISTORY
from linear_controller.interface import SMALLEST
from linear_controller.matrices import REAL, Records, Sizes, sizes_of
from signal_chain.readings import N_STREAM, SensorMemory, sensor_memory_of, sensor_memory_size

PARAMETERS, INPUTS, OUTPUTS = (SMALLEST.common_record(kind) for kind in ("parameter", "input", "output"))
DEMAND = SMALLEST.element_record("parameter", "demands")
SIGNAL = SMALLEST.element_record("input", "signals")
SENSOR_FAULTS = SMALLEST.element_record("input", "faults")
HEAD = record(
    ("begin", "f8"),  # time of the first sample (s)
    ("n_samples", "f8"),  # samples taken
    ("was_on", "f8"),  # whether the law was on at the last sample
    ("was_reset", "f8"),  # whether the integrators were held at zero
    ("adc_limited", "f8"),  # flags of the last sample, for the outputs
    ("demand_limited", "f8"),
    ("speed_extrapolated", "f8"),
)
N_PARAMETERS, N_INPUTS, N_OUTPUTS, N_HEAD = (size_of(r) for r in (PARAMETERS, INPUTS, OUTPUTS, HEAD))
N_DEMAND, N_SIGNAL, N_FAULTS = size_of(DEMAND), size_of(SIGNAL), size_of(SENSOR_FAULTS)


class Parameters(NamedTuple):
    """The parameters: record `PARAMETERS`, in an array of length 1; scales of the sensors; records `DEMAND`."""

    common: Records
    scales: Array
    demands: Records


class Inputs(NamedTuple):
    """The inputs: record `INPUTS` (length 1); records `SIGNAL` and `SENSOR_FAULTS`; currents to add to demands (A)."""

    common: Records
    signals: Records
    faults: Records
    feedforward: Array


class Outputs(NamedTuple):
    """The outputs: record `OUTPUTS`, in an array of length 1; demands (A); states."""

    common: Records
    demands: Array
    states: Array


class State(NamedTuple):
    """The state.

    head
        Record HEAD, in an array of length 1.
    x
        States of the law, in the order of the blocks, shape (n_states,).
    jump
        Remainder of the jump at switch-on, shape (n_demands,) (A).
    last
        Demands computed at the last sample, shape (n_demands,) (A).
    history
        Demands of the last samples, see `delay`, shape (N_HISTORY, n_demands) (A).
    sensors
        Memory of the sensors.
    """

    head: Records
    x: Array
    jump: Array
    last: Array
    history: Array
    sensors: SensorMemory


class Work(NamedTuple):
    """The work array: states and errors [x; e]; states of the next sample and demands of the law [x; u]; excess (A)."""

    law_inputs: Array
    law_outputs: Array
    excess: Array


@views
def parameters_of(parameters: Array, sizes: Sizes) -> Parameters:
    """Return views into the parameters."""
    demands = N_PARAMETERS + sizes.n_signals
    return Parameters(
        part(parameters, 0, PARAMETERS, 1),
        part(parameters, N_PARAMETERS, REAL, sizes.n_signals),
        part(parameters, demands, DEMAND, sizes.n_demands),
    )


@views
def inputs_of(inputs: Array, sizes: Sizes) -> Inputs:
    """Return views into the inputs."""
    faults = N_INPUTS + sizes.n_signals * N_SIGNAL
    return Inputs(
        part(inputs, 0, INPUTS, 1),
        part(inputs, N_INPUTS, SIGNAL, sizes.n_signals),
        part(inputs, faults, SENSOR_FAULTS, sizes.n_signals),
        part(inputs, faults + sizes.n_signals * N_FAULTS, REAL, sizes.n_demands),
    )


@views
def outputs_of(outputs: Array, sizes: Sizes) -> Outputs:
    """Return views into the outputs."""
    return Outputs(
        part(outputs, 0, OUTPUTS, 1),
        part(outputs, N_OUTPUTS, REAL, sizes.n_demands),
        part(outputs, N_OUTPUTS + sizes.n_demands, REAL, sizes.n_states),
    )


@views
def state_size(sizes: Sizes) -> int:
    """Return the size of the state."""
    return N_HEAD + sizes.n_states + (2 + N_HISTORY) * sizes.n_demands + sensor_memory_size(sizes.n_signals)


@views
def state_of(state: Array, sizes: Sizes) -> State:
    """Return views into the state."""
    n = sizes.n_demands
    jump = N_HEAD + sizes.n_states
    return State(
        part(state, 0, HEAD, 1),
        part(state, N_HEAD, REAL, sizes.n_states),
        part(state, jump, REAL, n),
        part(state, jump + n, REAL, n),
        part(state, jump + 2 * n, REAL, (N_HISTORY, n)),
        sensor_memory_of(state, jump + (2 + N_HISTORY) * n, sizes.n_signals),
    )


@views
def work_size(sizes: Sizes) -> int:
    """Return the size of the work array."""
    return 2 * sizes.n_states + sizes.n_signals + 2 * sizes.n_demands


@views
def work_of(work: Array, sizes: Sizes) -> Work:
    """Return views into the work array."""
    n_in, n_out = sizes.n_states + sizes.n_signals, sizes.n_states + sizes.n_demands
    return Work(
        part(work, 0, REAL, n_in),
        part(work, n_in, REAL, n_out),
        part(work, n_in + n_out, REAL, sizes.n_demands),
    )


def linear_state(constants: Array) -> LinearState:
    """Return the linear part of the state if there is no delay: states of the law, last demands, and filters."""
    sizes = sizes_of(constants)
    sensors = state_size(sizes) - sensor_memory_size(sizes.n_signals)
    return LinearState(
        ((N_HEAD, N_HEAD + sizes.n_states + 2 * sizes.n_demands), (sensors + N_STREAM, state_size(sizes)))
    )
