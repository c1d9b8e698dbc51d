"""The controller: a PID law for each axis, the Fourier transform of all sensor signals, and the synchronous control.

A call of `step` takes a sample if one is due (see `sampling`). The sample uses the inputs at the beginning of the step,
and the currents stay constant until the next sample.
"""

from __future__ import annotations

import math

from fmi_export.flat import copy
from fmi_export.jit import inlined_kernel, kernel
from fmi_export.model import UNCHANGED, Array, Model
from fmi_export.parts import clear
from rolac_controller import PACKAGES, identification, sensors
from rolac_controller.adaptation import forces_at, turn_forces
from rolac_controller.contact import update_contact_share
from rolac_controller.control_loop import N_HARMONICS, ControlLoop
from rolac_controller.enumerations import NOT_STARTED
from rolac_controller.fourier import add_sample, angle_jump, last_delta_theta, samples_of_revolution, transform
from rolac_controller.interface import interface_of
from rolac_controller.outputs import write_identification, write_synchronous
from rolac_controller.pid import differentiate, limit_and_integrate, pid_current
from rolac_controller.prediction import predict
from rolac_controller.receptance_table import TableViews, built_table, load, table_in_use
from rolac_controller.records import Inputs, Outputs, Parameters, inputs_of, outputs_of, parameters_of
from rolac_controller.sensor_check import suspect_sensor
from rolac_controller.sizes import Records, sizes_of
from rolac_controller.state import State, Work, linear_state, n_state, n_work, state_of, state_size, work_of
from rolac_controller.synchronous import permitted_status, update_forces
from signal_chain.demands import converted, dac_of, within_converter
from signal_chain.presets import is_on
from signal_chain.sampling import aligned, is_due, is_too_long

SPEED_RATIO = 2.0  # between the input Omega and the speed over the window's revolution

FAULT_LONG_STEP, FAULT_NO_TABLE, FAULT_HARMONICS, FAULT_WEIGHTS, FAULT_PLANES = range(1, 6)


@kernel
def orders_ascend(harmonics: Records) -> bool:
    """Return whether the orders of the harmonics ascend up to the first order 0, and all later orders are 0."""
    for k in range(1, N_HARMONICS):
        order, before = harmonics[k].order, harmonics[k - 1].order
        if order != 0.0 and (order <= before or before == 0.0):
            return False
    return True


@kernel
def planes_differ(positions: Array) -> bool:
    """Return whether all sensor planes are at different `positions`, shape (n_planes,) (m)."""
    for k in range(positions.shape[0]):
        for other in range(k):
            if positions[k] == positions[other]:
                return False
    return True


@inlined_kernel
def lacks_table(inputs: Inputs, state: State, table: TableViews) -> bool:
    """Return whether ROLAC is on, no H is available, and no identification has been made or requested."""
    common = inputs.common[0]
    never_identified = state.identification.course[0].stage == NOT_STARTED and not common.identify
    return bool(common.rolac_enable != 0.0 and table.n_rows[0] == 0.0 and never_identified)


@inlined_kernel
def window_is_valid(parameters: Parameters, Omega: float, samples: float) -> bool:
    """Return whether the synchronous displacements from a window of this length are valid at a speed.

    The window must contain a full revolution, and the speed must be at least `rolac.min_speed`. The time of the
    revolution must differ from the time that the speed implies by less than a factor of `SPEED_RATIO`. This last
    condition excludes a rotor angle that does not advance at the given speed, and revolutions that began before a large
    change of speed.
    """
    common = parameters.common[0]
    turns = samples * common.sample_time * Omega / (2.0 * math.pi)
    return bool(common.rolac.min_speed <= Omega and 1.0 / SPEED_RATIO < turns < SPEED_RATIO)


@inlined_kernel
def observe(parameters: Parameters, inputs: Inputs, state: State, work: Work) -> None:
    """Compute displacements and synchronous components at this sample, and detect contact and faulty sensors."""
    common, findings, window = inputs.common[0], work.findings[0], state.window
    findings.adc_limited = sensors.measure(
        parameters, inputs, state.sensors, state.head[0].n_samples > 0.0, True, work.displacements
    )
    jump = angle_jump(window, common.theta)
    if jump != 0.0:
        turn_forces(state.U, parameters.harmonics, jump - common.Omega * parameters.common[0].sample_time)
    add_sample(window, parameters.harmonics, common.theta, work.displacements)
    samples = samples_of_revolution(window)
    valid = window_is_valid(parameters, common.Omega, samples)
    findings.window_valid = valid
    clear(work.Q)
    if valid:
        transform(window, parameters.harmonics, work.Q)
    findings.delta_theta = last_delta_theta(window)
    findings.suspect_sensor = suspect_sensor(work.displacements, samples, state.checks)
    findings.in_contact = update_contact_share(
        parameters, common.contact_state, work.displacements, findings.delta_theta, state.contact_shares
    )


@inlined_kernel
def control(
    parameters: Parameters, inputs: Inputs, state: State, work: Work, sample_time: float, outputs: Outputs
) -> None:
    """Compute the currents of all axes, I = I_pid + u/K_i (5.1 to 5.4, 5.23); then limit and convert them (DAC).

    `sample_time` (s) is 0 at initialisation, so nothing is integrated.
    """
    common, head, theta = parameters.common[0], state.head[0], inputs.common[0].theta
    chain, direct, dac = common.chain, common.pid.direct, dac_of(common.chain)
    delayed = is_on(chain.preset, chain.delay) and sample_time > 0.0
    head.current_limited = 0.0
    forces_at(state.U, parameters.harmonics, theta, work.u)
    identification.add_test_force(parameters, state.identification, theta, work.u)
    for k in range(work.u.shape[0]):
        gains, memory = parameters.axes[k], state.axes[k]
        displacement, setpoint = work.displacements[int(parameters.sensor_of_axis[k])], inputs.setpoints[k]
        if head.n_samples == 0.0:
            memory.displacement = displacement
        differentiate(memory, displacement, common.derivative_time, common.sample_time)
        demand = pid_current(gains, direct, memory, setpoint) + work.u[k] / gains.k_i
        limits = within_converter(gains.i_min, gains.i_max, chain, dac)
        if not limits.low <= demand <= limits.high:
            head.current_limited = 1.0
        limited = limit_and_integrate(gains, memory, setpoint, demand, limits, sample_time)
        current = converted(limited, chain, dac)
        outputs.axes[k].current = state.currents[k] if delayed else current
        state.currents[k] = current
    outputs.common[0].current_limited = head.current_limited


@inlined_kernel
def start(parameters: Parameters, inputs: Inputs, state: State, work: Work, table: TableViews, outputs: Outputs) -> int:
    """Compute the initial currents from the proportional terms, without taking a sample; return a fault code."""
    if lacks_table(inputs, state, table):
        return FAULT_NO_TABLE
    findings = work.findings[0]
    findings.adc_limited = sensors.measure(parameters, inputs, state.sensors, False, False, work.displacements)
    findings.status = permitted_status(parameters, inputs, state, work)
    control(parameters, inputs, state, work, 0.0, outputs)
    write_synchronous(parameters, inputs, state, work, table, outputs)
    write_identification(inputs, state.identification, outputs)
    return 0


@inlined_kernel
def take_sample(
    parameters: Parameters, inputs: Inputs, state: State, work: Work, table: TableViews, outputs: Outputs
) -> int:
    """Take a sample: compute the measured signals, synchronous components, forces and currents; return a fault code."""
    if lacks_table(inputs, state, table):
        return FAULT_NO_TABLE
    observe(parameters, inputs, state, work)
    identification.advance(parameters, inputs, state, work, table)
    work.findings[0].status = permitted_status(parameters, inputs, state, work)
    update_forces(parameters, inputs, state, work, table)
    control(parameters, inputs, state, work, parameters.common[0].sample_time, outputs)
    state.head[0].n_samples += 1.0
    write_synchronous(parameters, inputs, state, work, table, outputs)
    write_identification(inputs, state.identification, outputs)
    return 0


@kernel
def initialise(constants: Array, parameters: Array, inputs: Array, state: Array, work: Array, outputs: Array) -> int:
    """Compute the state and the outputs at the start; for the arguments see `Model.initialise`."""
    work[:] = 0.0
    outputs[:] = 0.0
    sizes = sizes_of(constants)
    p, w = parameters_of(parameters, constants, sizes), work_of(work, sizes)
    table = table_in_use(state, state_size(sizes), constants, sizes)
    if not orders_ascend(p.harmonics):
        return FAULT_HARMONICS
    if not planes_differ(p.plane_positions):
        return FAULT_PLANES
    if not load(built_table(constants, sizes), p, table, w.svd):
        return FAULT_WEIGHTS
    return start(p, inputs_of(inputs, sizes), state_of(state, sizes), w, table, outputs_of(outputs, sizes))


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
    p, memory = parameters_of(parameters, constants, sizes), state_of(state, sizes)
    sample_time, prediction_time, head = p.common[0].sample_time, p.common[0].prediction_time, memory.head[0]
    if is_too_long(time, step_size, sample_time):
        return FAULT_LONG_STEP
    head.begin = aligned(head.begin, head.n_samples, time, step_size, sample_time)
    due = is_due(head.begin + head.n_samples * sample_time, time, step_size, sample_time)
    if not due and prediction_time == 0.0:
        return UNCHANGED
    w = work_of(work, sizes)
    copy(inputs, w.inputs)
    used = inputs_of(w.inputs, sizes)
    if prediction_time > 0.0:
        predict(used, prediction_time, time, head, memory.last_displacements)
    if not due:
        return UNCHANGED
    table = table_in_use(state, state_size(sizes), constants, sizes)
    return take_sample(p, used, memory, w, table, outputs_of(outputs, sizes))


def model_for(loop: ControlLoop) -> Model:
    """Return the controller of this loop; `sizes` and `receptance_table` describe the layout of its constants."""
    return Model(
        name="rolac_controller",
        description="Sampled PID of magnetic bearings with adaptive control (ROLAC) of the synchronous vibration",
        author="The amb-cosim authors",
        interface=interface_of(loop),
        initialise=initialise,
        step=step,
        n_state=n_state,
        n_work=n_work,
        packages=PACKAGES,
        faults=_faults(loop),
        layout=loop.layout(),
        linear_state=linear_state,
    )


def _faults(loop: ControlLoop) -> dict[int, str]:
    orders = ", ".join(f"{{harmonic{k + 1}.order}}" for k in range(N_HARMONICS))
    positions = ", ".join(f"plane{k + 1}.z = {{plane{k + 1}.z}} m" for k in range(len(loop.planes)))
    return {
        FAULT_LONG_STEP: "step size = {step_size} s is not allowed; it must be <= sample_time = {sample_time} s, "
        "because the inputs of a step serve one sample",
        FAULT_NO_TABLE: "rolac_enable = 1 is not allowed; this FMU was built without a table of receptances, "
        "so rolac_enable must be 0 until an identification has been requested",
        FAULT_HARMONICS: f"the orders of the harmonics, {orders}, are not allowed; they must ascend, with 0 for every "
        "harmonic after the last",
        FAULT_WEIGHTS: "with these sensor weights, a receptance of the table has a condition number above "
        "identification.max_condition = {identification.max_condition}; give weight to more sensors",
        FAULT_PLANES: f"{positions} are not allowed; the positions of the sensor planes must differ",
    }
