"""The controller: four bearing axes under PID, eight sensors Fourier-transformed, synchronous control on top.

One call of `step` is one sample: inputs at its beginning, currents constant over it.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from fmi_export.jit import kernel
from fmi_export.model import Array, Model
from rolac_controller import identification, sensors
from rolac_controller.adaptation import forces_at
from rolac_controller.chain import is_on
from rolac_controller.contact import update_contact_share
from rolac_controller.converters import quantised, resolution
from rolac_controller.enumerations import NOT_STARTED
from rolac_controller.fourier import add_sample, last_delta_theta, samples_of_revolution, transform
from rolac_controller.interface import INPUTS, INTERFACE, OUTPUTS, PARAMETERS
from rolac_controller.outputs import write_identification, write_synchronous
from rolac_controller.pid import CurrentLimits, differentiate, limit_and_integrate, pid_current
from rolac_controller.receptance_table import TableViews, load, table_of
from rolac_controller.rig_layout import N_AXES, N_HARMONICS, N_PLANES, SENSOR_NAMES, SENSOR_OF_AXIS
from rolac_controller.sensor_check import suspect_sensor
from rolac_controller.state import STATE, STATE_SIZE, WORK, WORK_SIZE, n_state
from rolac_controller.synchronous import permitted_status, update_forces

__all__ = ["INTERFACE", "MODEL", "SENSOR_NAMES", "initialise", "step"]

STEP_TOLERANCE = 1e-9  # relative; a master that subtracts times also rounds in the last digits of the time
ROUNDING = 4.5e-16
SPEED_RATIO = 2.0  # between the input Omega and the speed over the window's revolution

FAULT_STEP, FAULT_NO_TABLE, FAULT_HARMONICS, FAULT_WEIGHTS, FAULT_PLANES = range(1, 6)


@kernel
def orders_ascend(harmonics: NDArray[np.record]) -> bool:
    """Return whether the orders of the harmonics ascend until the first 0, and are 0 from there on."""
    for k in range(1, N_HARMONICS):
        order, before = harmonics[k].order, harmonics[k - 1].order
        if order != 0.0 and (order <= before or before == 0.0):
            return False
    return True


@kernel
def planes_differ(positions: Array) -> bool:
    """Return whether no two sensor planes are at the same place; positions of shape (N_PLANES,) (m)."""
    for k in range(N_PLANES):
        for other in range(k):
            if positions[k] == positions[other]:
                return False
    return True


@kernel
def lacks_table(inputs: np.record, state: np.record, table: TableViews) -> bool:
    """Return whether ROLAC is on without any H, and no identification that could find one was made or requested."""
    never_identified = state.identification.stage == NOT_STARTED and not inputs.identify
    return bool(inputs.rolac_enable != 0.0 and table.n_rows[0] == 0.0 and never_identified)


@kernel
def window_is_valid(parameters: np.record, inputs: np.record, window: np.record) -> bool:
    """Return whether the window shows the synchronous displacements at this speed.

    It does if it holds a full revolution, the speed is at least `rolac.min_speed`, and the revolution took the time
    that this speed suggests, within a factor `SPEED_RATIO`. The last condition excludes a rotor angle that does not
    turn with the speed, and revolutions from before a large change of speed.
    """
    turns = samples_of_revolution(window) * parameters.sample_time * inputs.Omega / (2.0 * math.pi)
    return bool(inputs.Omega >= parameters.rolac.min_speed and 1.0 / SPEED_RATIO < turns < SPEED_RATIO)


@kernel
def observe(parameters: np.record, inputs: np.record, state: np.record, work: np.record) -> None:
    """Find the displacements and synchronous components at this sample, contact, and sensors that are suspect."""
    sensors.measure(parameters, inputs, state.sensors, state.started != 0.0, True, work.displacements)
    add_sample(state.window, parameters.harmonics, inputs.theta, work.displacements)
    valid = window_is_valid(parameters, inputs, state.window)
    work.window_valid = valid
    work.Q[:] = 0.0
    if valid:
        transform(state.window, parameters.harmonics, work.Q)
    work.delta_theta = last_delta_theta(state.window)
    work.suspect_sensor = suspect_sensor(work.displacements, samples_of_revolution(state.window), state.sensor_check)
    work.in_contact = update_contact_share(
        parameters.contact, inputs.contact_state, work.displacements, work.delta_theta, state.contact_shares
    )


@kernel
def current_limits(gains: np.record, chain: np.record) -> CurrentLimits:
    """Return the limits of the current of an axis: those of the coil, and of the DAC where that is on (A)."""
    if not is_on(chain.preset, chain.dac):
        return CurrentLimits(gains.i_min, gains.i_max)
    lowest = -chain.amplifier_gain * chain.dac_range
    highest = chain.amplifier_gain * (chain.dac_range - resolution(chain.dac_bits, chain.dac_range))
    return CurrentLimits(max(gains.i_min, lowest), min(gains.i_max, highest))


@kernel
def control(
    parameters: np.record, inputs: np.record, state: np.record, work: np.record, sample_time: float, outputs: np.record
) -> None:
    """Compute the currents of all axes, I = I_pid + u/K_i within their limits (5.1 to 5.4, 5.23), through the DAC.

    `sample_time` (s) is 0 at the initialisation, which integrates nothing.
    """
    chain, direct = parameters.chain, parameters.pid.direct
    dac, delayed = is_on(chain.preset, chain.dac), is_on(chain.preset, chain.delay) and sample_time > 0.0
    state.current_limited = 0.0
    forces_at(state.U, parameters.harmonics, inputs.theta, work.u)
    identification.add_test_force(parameters, state.identification, inputs.theta, work.u)
    for k in range(N_AXES):
        gains, memory = parameters.axes[k], state.axes[k]
        displacement, setpoint = work.displacements[SENSOR_OF_AXIS[k]], inputs.setpoints[k]
        if not state.started:
            memory.displacement = displacement
        differentiate(memory, displacement, parameters.derivative_time, parameters.sample_time)
        demand = pid_current(gains, direct, memory, setpoint) + work.u[k] / gains.k_i
        limits = current_limits(gains, chain)
        if not limits.low <= demand <= limits.high:
            state.current_limited = 1.0
        current = limit_and_integrate(gains, memory, setpoint, demand, limits, sample_time)
        if dac:
            current = chain.amplifier_gain * quantised(current / chain.amplifier_gain, chain.dac_bits, chain.dac_range)
        outputs.axes[k].current = state.currents[k] if delayed else current
        state.currents[k] = current
    outputs.current_limited = state.current_limited


@kernel
def start(
    parameters: np.record,
    inputs: np.record,
    state: np.record,
    work: np.record,
    table: TableViews,
    outputs: np.record,
) -> int:
    """Compute the currents for the first inputs, proportional terms alone; return a fault code. It is no sample."""
    if lacks_table(inputs, state, table):
        return FAULT_NO_TABLE
    sensors.measure(parameters, inputs, state.sensors, False, False, work.displacements)
    work.status = permitted_status(parameters, inputs, state, work)
    control(parameters, inputs, state, work, 0.0, outputs)
    write_synchronous(inputs, state, work, table, outputs)
    write_identification(inputs, state.identification, outputs)
    return 0


@kernel
def take_sample(
    parameters: np.record,
    inputs: np.record,
    state: np.record,
    work: np.record,
    table: TableViews,
    outputs: np.record,
) -> int:
    """Compute one sample: measured signals, synchronous components and forces, currents; return a fault code."""
    if lacks_table(inputs, state, table):
        return FAULT_NO_TABLE
    observe(parameters, inputs, state, work)
    identification.advance(parameters, inputs, state, work, table)
    work.status = permitted_status(parameters, inputs, state, work)
    update_forces(parameters, inputs, state, work, table)
    control(parameters, inputs, state, work, parameters.sample_time, outputs)
    state.started = 1.0
    write_synchronous(inputs, state, work, table, outputs)
    write_identification(inputs, state.identification, outputs)
    return 0


@kernel
def initialise(constants: Array, parameters: Array, inputs: Array, state: Array, work: Array, outputs: Array) -> int:
    """Compute state and outputs at the start; arguments as of every model (`Model.initialise`)."""
    work[:] = 0.0
    outputs[:] = 0.0
    given, table = parameters.view(PARAMETERS)[0], table_of(state[STATE_SIZE:])
    if not orders_ascend(given.harmonics):
        return FAULT_HARMONICS
    if not planes_differ(given.plane_positions):
        return FAULT_PLANES
    if not load(table_of(constants), given, table, work.view(WORK)[0].svd):
        return FAULT_WEIGHTS
    return start(
        given,
        inputs.view(INPUTS)[0],
        state[:STATE_SIZE].view(STATE)[0],
        work.view(WORK)[0],
        table,
        outputs.view(OUTPUTS)[0],
    )


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
    """Compute one sample, the currents to apply during the step; arguments as of every model (`Model.step`)."""
    given = parameters.view(PARAMETERS)[0]
    h = given.sample_time
    if abs(step_size - h) > STEP_TOLERANCE * h + ROUNDING * abs(time):
        return FAULT_STEP
    return take_sample(
        given,
        inputs.view(INPUTS)[0],
        state[:STATE_SIZE].view(STATE)[0],
        work.view(WORK)[0],
        table_of(state[STATE_SIZE:]),
        outputs.view(OUTPUTS)[0],
    )


MODEL = Model(
    name="rolac_controller",
    description="Sampled PID of two magnetic bearings with adaptive control (ROLAC) of synchronous vibration",
    interface=INTERFACE,
    initialise=initialise,
    step=step,
    n_state=n_state,
    n_work=WORK_SIZE,
    packages=("rolac_controller", "fmi_export"),
    variable_step=False,
    faults={
        FAULT_STEP: "the communication step size is not allowed; it must equal sample_time = {sample_time} s",
        FAULT_NO_TABLE: "rolac_enable = 1 is not allowed; this FMU was built without a table of receptances, "
        "so rolac_enable must be 0 until an identification has been requested",
        FAULT_HARMONICS: "the orders of the harmonics, {harmonic1.order}, {harmonic2.order}, {harmonic3.order}, "
        "{harmonic4.order}, are not allowed; they must ascend, and be 0 after the last",
        FAULT_WEIGHTS: "the sensor weights leave a receptance of the table with a condition number beyond "
        "identification.max_condition = {identification.max_condition}; more sensors must count",
        FAULT_PLANES: "plane1.z = {plane1.z} m, plane2.z = {plane2.z} m, plane3.z = {plane3.z} m, "
        "plane4.z = {plane4.z} m is not allowed; they must differ",
    },
)
