"""The controller: four bearing axes under PID, eight sensors Fourier-transformed, synchronous control on top.

One call of `step` is one sample: inputs at its beginning, currents held over it.
"""

from __future__ import annotations

import math

from fmi_export.jit import kernel
from fmi_export.model import Array, Model
from rolac_controller import identification, pid, sensors, stored, supervision, synchronous
from rolac_controller.adaptation import forces_at
from rolac_controller.arrays import LIMITED, N_WORK, STARTED, Scratch, State, n_state, scratch_of, state_of
from rolac_controller.chain import is_on
from rolac_controller.contact import watch
from rolac_controller.converters import converted, step_of
from rolac_controller.fourier import components, record, revolution, turned
from rolac_controller.interface import (
    AMPLIFIER_GAIN,
    AXIS_OUTPUTS,
    CHECK_SENSORS,
    CURRENT,
    CURRENT_LIMITED,
    DAC,
    DAC_BITS,
    DAC_RANGE,
    DELAY,
    DERIVATIVE_TIME,
    DIRECT,
    ENABLE,
    GAINS,
    HARMONIC,
    HARMONIC_PARAMETERS,
    I_MAX,
    I_MIN,
    IDENTIFY,
    INTERFACE,
    K_I,
    MAX_CONDITION,
    MIN_SPEED,
    N_GAINS,
    OMEGA,
    ORDER,
    PLANE_Z,
    POWER,
    SAMPLE_TIME,
    SETPOINT,
    THETA,
    WEIGHT,
)
from rolac_controller.names import (
    N_AXES,
    N_HARMONICS,
    N_PLANES,
    N_SENSORS,
    NONE,
    SENSOR_NAMES,
    SENSOR_OF_AXIS,
)
from rolac_controller.outputs import show_identification, show_synchronous

__all__ = ["INTERFACE", "MODEL", "SENSOR_NAMES", "initialise", "step"]

STEP_TOLERANCE = 1e-9  # relative; a master that subtracts times also rounds in the last digits of the time
ROUNDING = 4.5e-16
SPEED_RATIO = 2.0  # between the input Omega and the speed over the window's revolution

FAULT_STEP, FAULT_NO_TABLE, FAULT_HARMONICS, FAULT_WEIGHTS, FAULT_PLANES = range(1, 6)


@kernel
def read_harmonics(parameters: Array, x: Scratch) -> None:
    """Orders and powers of the harmonics, side by side."""
    for k in range(N_HARMONICS):
        x.orders[k] = parameters[HARMONIC + k * HARMONIC_PARAMETERS + ORDER]
        x.powers[k] = parameters[HARMONIC + k * HARMONIC_PARAMETERS + POWER]


@kernel
def ascending(orders: Array) -> bool:
    """Whether the orders of the harmonics ascend until the first 0, and are 0 from there on."""
    for k in range(1, N_HARMONICS):
        if orders[k] != 0.0 and (orders[k] <= orders[k - 1] or orders[k - 1] == 0.0):
            return False
    return True


@kernel
def distinct(parameters: Array) -> bool:
    """Whether no two sensor planes are at the same place."""
    for k in range(N_PLANES):
        for other in range(k):
            if parameters[PLANE_Z + k] == parameters[PLANE_Z + other]:
                return False
    return True


@kernel
def lacks_table(inputs: Array, s: State) -> bool:
    """Whether ROLAC is on without any H, and no identification was made or asked for that could find one."""
    never = s.identification[identification.STAGE] == NONE and inputs[IDENTIFY] == 0.0
    return bool(inputs[ENABLE] != 0.0 and s.table[0] == 0.0 and never)


@kernel
def transform(parameters: Array, inputs: Array, s: State, x: Scratch) -> bool:
    """Take in this sample and find the components of all harmonics; whether they are valid.

    Valid means: a full revolution is in the window, the speed is at least `rolac.min_speed`, and the
    revolution took the time that this speed says within a factor `SPEED_RATIO`. The last excludes a rotor
    angle that does not turn with the speed, and revolutions from before a large change of speed. Otherwise
    all components are zero.
    """
    record(s.window, x.orders, inputs[THETA], x.measured)
    turns = revolution(s.window) * parameters[SAMPLE_TIME] * inputs[OMEGA] / (2.0 * math.pi)
    valid: bool = inputs[OMEGA] >= parameters[MIN_SPEED] and 1.0 / SPEED_RATIO < turns < SPEED_RATIO
    x.q[:] = 0.0
    if valid:
        components(s.window, x.orders, x.q)
    return valid


@kernel
def control(parameters: Array, inputs: Array, s: State, x: Scratch, sample_time: float, outputs: Array) -> None:
    """Currents of all axes, I = I_pid + u/K_i within their limits (5.1 to 5.4, 5.23), through the DAC."""
    direct = parameters[DIRECT] != 0.0
    dac, late = is_on(parameters, DAC), is_on(parameters, DELAY)
    gain, bits, reach = parameters[AMPLIFIER_GAIN], parameters[DAC_BITS], parameters[DAC_RANGE]
    s.flags[LIMITED] = 0.0
    forces_at(s.forces, x.orders, inputs[THETA], x.u)
    identification.add_test_force(parameters, x.orders, x.powers, s.identification, inputs[THETA], x.u)
    for k in range(N_AXES):
        gains = parameters[GAINS + k * N_GAINS : GAINS + (k + 1) * N_GAINS]
        memory = s.axes[k * pid.N_MEMORY : (k + 1) * pid.N_MEMORY]
        displacement, setpoint = x.measured[SENSOR_OF_AXIS[k]], inputs[SETPOINT + k]
        if s.flags[STARTED] == 0.0:
            memory[pid.POSITION] = displacement
        pid.differentiate(memory, displacement, parameters[DERIVATIVE_TIME], parameters[SAMPLE_TIME])
        demand = pid.pid_current(gains, direct, memory, setpoint) + x.u[k] / gains[K_I]
        low, high = gains[I_MIN], gains[I_MAX]
        if dac:
            low, high = max(low, -gain * reach), min(high, gain * (reach - step_of(bits, reach)))
        if not low <= demand <= high:
            s.flags[LIMITED] = 1.0
        current = pid.limit_and_integrate(gains, memory, setpoint, demand, low, high, sample_time)
        if dac:
            current = gain * converted(current / gain, bits, reach)
        outputs[k * AXIS_OUTPUTS + CURRENT] = s.currents[k] if late and sample_time > 0.0 else current
        s.currents[k] = current
    outputs[CURRENT_LIMITED] = s.flags[LIMITED]


@kernel
def initialise(constants: Array, parameters: Array, inputs: Array, state: Array, work: Array, outputs: Array) -> int:
    """Currents for the first inputs: proportional terms alone. It is no sample; the first `step` is."""
    s, x = state_of(state), scratch_of(work)
    read_harmonics(parameters, x)
    if not ascending(x.orders):
        return FAULT_HARMONICS
    if not distinct(parameters):
        return FAULT_PLANES
    weights = parameters[WEIGHT : WEIGHT + N_SENSORS]
    if not stored.load(constants, weights, parameters[MAX_CONDITION], s.table, x.rest):
        return FAULT_WEIGHTS
    if lacks_table(inputs, s):
        return FAULT_NO_TABLE
    outputs[:] = 0.0
    x.q[:] = 0.0
    sensors.measure(parameters, inputs, s.sensors, False, False, x.measured)
    status = synchronous.permitted(parameters, inputs, False, False, False)
    control(parameters, inputs, s, x, 0.0, outputs)
    show_synchronous(inputs, s, x, False, status, False, False, 0, outputs)
    show_identification(inputs, s, outputs)
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
    """One sample: measured signals, synchronous components and forces, currents to hold over the step."""
    h = parameters[SAMPLE_TIME]
    if abs(step_size - h) > STEP_TOLERANCE * h + ROUNDING * abs(time):
        return FAULT_STEP
    s, x = state_of(state), scratch_of(work)
    if lacks_table(inputs, s):
        return FAULT_NO_TABLE
    read_harmonics(parameters, x)

    sensors.measure(parameters, inputs, s.sensors, s.flags[STARTED] != 0.0, True, x.measured)
    valid = transform(parameters, inputs, s, x)
    turn = turned(s.window)
    suspect = supervision.suspect(x.measured, revolution(s.window), s.supervision)
    contact = watch(parameters, inputs, x.measured, turn, s.contact)
    identification.advance(
        parameters,
        inputs,
        x.orders,
        x.powers,
        inputs[IDENTIFY] != 0.0,
        valid,
        s.flags[LIMITED] != 0.0,
        contact,
        turn,
        x.q,
        s.identification,
        s.table,
        x.inversion,
    )
    identifying = identification.running(s.identification)
    bad = parameters[CHECK_SENSORS] != 0.0 and suspect > 0
    status = synchronous.permitted(parameters, inputs, valid, bad, identifying)
    status, extrapolated, limited = synchronous.update(parameters, inputs, status, turn, s, x)
    control(parameters, inputs, s, x, h, outputs)
    s.flags[STARTED] = 1.0

    show_synchronous(inputs, s, x, valid, status, extrapolated, limited, suspect, outputs)
    show_identification(inputs, s, outputs)
    return 0


MODEL = Model(
    name="rolac_controller",
    description="Sampled PID of two magnetic bearings with adaptive control (ROLAC) of synchronous vibration",
    interface=INTERFACE,
    initialise=initialise,
    step=step,
    n_state=n_state,
    n_work=N_WORK,
    packages=("rolac_controller", "fmi_export"),
    variable_step=False,
    faults={
        FAULT_STEP: "the communication step size is not allowed; it must equal sample_time = {sample_time} s",
        FAULT_NO_TABLE: "rolac_enable = 1 is not allowed; this FMU was built without a table of receptances, "
        "so rolac_enable must be 0 until an identification has been asked for",
        FAULT_HARMONICS: "the orders of the harmonics, {harmonic1.order}, {harmonic2.order}, {harmonic3.order}, "
        "{harmonic4.order}, are not allowed; they must ascend, and be 0 after the last",
        FAULT_WEIGHTS: "the sensor weights leave a receptance of the table with a condition number beyond "
        "identification.max_condition = {identification.max_condition}; more sensors must count",
        FAULT_PLANES: "plane1.z = {plane1.z} m, plane2.z = {plane2.z} m, plane3.z = {plane3.z} m, "
        "plane4.z = {plane4.z} m is not allowed; they must differ",
    },
)
