"""The controller: four bearing axes under PID, eight sensors Fourier-transformed, ROLAC on top.

One call of `step` is one sample: inputs at its beginning, currents held over it.
"""

from __future__ import annotations

import math

from fmi_export.jit import kernel
from fmi_export.model import Array, Model
from fmi_export.variables import Variable, input_, interface, output, parameter
from rolac_controller import fourier, pid, rolac
from rolac_controller.fourier import N_SENSORS
from rolac_controller.rolac import N_AXES

# Each axis is controlled by the sensor at its bearing; the other four only serve ROLAC.
AXES = (("mb1", "x", "s5"), ("mb1", "y", "s6"), ("mb2", "x", "s3"), ("mb2", "y", "s4"))
PLANES = ("motor end", "MB2", "MB1", "non-driven end")
SENSORS = tuple((f"s{k + 1}", f"{PLANES[k // 2]}, {'xy'[k % 2]} axis") for k in range(N_SENSORS))
SENSOR_NAMES = tuple(name for name, _ in SENSORS)

# 2.8 and 2.9 with Table 2.2: the linear law that the actuator starts with.
BEARING_K_S, BEARING_K_I = 2376955.7160887653, 563.1506658084571

LARGEST_ANGLE = 1e9  # rad, 18 days at full speed; it still resolves 1e-7 rad

TIMING = ("Omega", "theta")
SWITCHED = (*SENSOR_NAMES, *TIMING, "rolac_enable")


def _axis(bearing: str, axis: str) -> list[Variable]:
    """Variables of one axis; the order of the parameters is that of `pid`, of the outputs that of `step`."""
    b, a = bearing, axis
    at = f"{b.upper()}, {a} axis"
    return [
        parameter(f"{b}.k_b_{a}", "N/m", f"Net stiffness K_b of the closed bearing, {at} (5.1)", 1e6, tunable=True),
        parameter(
            f"{b}.c_b_{a}",
            "N.s/m",
            f"Damping C_b of the closed bearing, {at} (5.2)",
            5e3,
            minimum=0.0,
            tunable=True,
        ),
        parameter(
            f"{b}.k_integral_{a}",
            "N/(m.s)",
            f"Gain K_I of the integral, {at} (5.3)",
            0.0,
            minimum=0.0,
            tunable=True,
        ),
        parameter(
            f"{b}.k_s_{a}",
            "N/m",
            f"Negative stiffness K_s of the bearing, compensated, {at} (2.8)",
            BEARING_K_S,
            tunable=True,
        ),
        parameter(
            f"{b}.k_i_{a}",
            "N/A",
            f"Current stiffness K_i of the bearing, {at} (2.9)",
            BEARING_K_I,
            minimum=1.0,
            tunable=True,
        ),
        parameter(
            f"{b}.i_min_{a}",
            "A",
            f"Least control current, -(I_s + I_b), {at}",
            -5.57,
            maximum=0.0,
            tunable=True,
        ),
        parameter(f"{b}.i_max_{a}", "A", f"Largest control current, I_b, {at}", 4.43, minimum=0.0, tunable=True),
        output(f"{b}.i_{a}", "A", f"Demanded control current, {at}", depends_on=SWITCHED),
        output(f"{b}.u_{a}", "N", f"Amplitude of the synchronous ROLAC force, {at}", depends_on=SWITCHED),
        output(f"{b}.u_phase_{a}", "rad", f"Phase of the synchronous ROLAC force, {at}", depends_on=SWITCHED),
    ]


def _sensor(name: str, where: str) -> list[Variable]:
    """Variables of one sensor. The range of the displacement is generous; it finds mm and um given as m."""
    return [
        input_(name, "m", f"Measured displacement, {where}", minimum=-0.1, maximum=0.1),
        output(f"amplitude.{name}", "m", f"Synchronous amplitude, {where}", depends_on=(name, *TIMING)),
        output(f"phase.{name}", "rad", f"Phase of the synchronous part, {where}", depends_on=(name, *TIMING)),
    ]


INTERFACE = interface(
    parameter(
        "sample_time",
        "s",
        "Time between samples, equal to the communication step",
        250e-6,
        minimum=1e-6,
        maximum=0.1,
    ),
    parameter(
        "derivative_time",
        "s",
        "Time constant of the derivative's filter; 0: plain backward difference",
        0.0,
        minimum=0.0,
        tunable=True,
    ),
    parameter(
        "rolac.alpha",
        "1/s",
        "Adaptation rate of ROLAC; 0 holds the force (5.22)",
        7.0,
        minimum=0.0,
        tunable=True,
    ),
    parameter(
        "rolac.min_speed",
        "rad/s",
        "Speed below which there is no synchronous signal and no ROLAC",
        2.0 * math.pi * 5.0,
        minimum=0.0,
        tunable=True,
    ),
    *(_axis(bearing, axis) for bearing, axis, _ in AXES),
    *(_sensor(name, where) for name, where in SENSORS),
    input_("Omega", "rad/s", "Rotor speed", minimum=0.0),
    input_(
        "theta", "rad", "Rotor angle, wrapped to a revolution or not", minimum=-LARGEST_ANGLE, maximum=LARGEST_ANGLE
    ),
    input_("rolac_enable", "1", "Switches ROLAC on", type="Boolean"),
    output(
        "rolac_active",
        "1",
        "ROLAC is adapting its force",
        type="Boolean",
        depends_on=(*TIMING, "rolac_enable"),
    ),
    output(
        "window_valid",
        "1",
        "The synchronous signals span a full revolution",
        type="Boolean",
        depends_on=TIMING,
    ),
    output("fault_code", "1", "0 while all is well; the log says what else means", type="Integer"),
)

SAMPLE_TIME = INTERFACE.parameter_index("sample_time")
DERIVATIVE_TIME = INTERFACE.parameter_index("derivative_time")
ALPHA = INTERFACE.parameter_index("rolac.alpha")
MIN_SPEED = INTERFACE.parameter_index("rolac.min_speed")
GAINS = INTERFACE.parameter_index("mb1.k_b_x")
OMEGA = INTERFACE.input_index("Omega")
THETA = INTERFACE.input_index("theta")
ENABLE = INTERFACE.input_index("rolac_enable")
AXIS_OUTPUTS = 3
CURRENT, FORCE, FORCE_PHASE = range(AXIS_OUTPUTS)
AMPLITUDE = INTERFACE.output_index("amplitude.s1")
PHASE = AMPLITUDE + 1  # amplitude and phase alternate
ACTIVE = INTERFACE.output_index("rolac_active")
VALID = INTERFACE.output_index("window_valid")
SENSOR_OF_AXIS = tuple(SENSOR_NAMES.index(sensor) for _, _, sensor in AXES)

# Layout of the state: whether a sample was taken, memory of the axes, synchronous forces, window.
STARTED = 0
MEMORY = 1
SYNCHRONOUS_FORCE = MEMORY + N_AXES * pid.N_MEMORY
WINDOW = SYNCHRONOUS_FORCE + 2 * N_AXES
N_STATE = WINDOW + fourier.N_WINDOW

# Layout of the scratch array: synchronous displacements.
N_WORK = 2 * N_SENSORS

STEP_TOLERANCE = 1e-9  # relative; a master that subtracts times also rounds in the last digits of the time
ROUNDING = 4.5e-16
SPEED_RATIO = 2.0  # between the input Omega and the speed over the window's revolution

FAULT_STEP, FAULT_NO_TABLE = 1, 2


@kernel
def transform(parameters: Array, inputs: Array, window: Array, q: Array) -> bool:
    """Take in this sample and put the synchronous displacements into `q`; whether they are valid.

    Valid means: a full revolution is in the window, the speed is at least `rolac.min_speed`, and the
    revolution took the time that this speed says within a factor `SPEED_RATIO`. The last excludes a rotor
    angle that does not turn with the speed, and revolutions from before a large change of speed. Otherwise
    `q` is zero.
    """
    fourier.record(window, inputs[THETA], inputs[:N_SENSORS])
    turned = fourier.synchronous(window, q) * parameters[SAMPLE_TIME] * inputs[OMEGA] / (2.0 * math.pi)
    valid: bool = inputs[OMEGA] >= parameters[MIN_SPEED] and 1.0 / SPEED_RATIO < turned < SPEED_RATIO
    if not valid:
        q[:] = 0.0
    return valid


@kernel
def control(parameters: Array, inputs: Array, state: Array, sample_time: float, outputs: Array) -> None:
    """Currents of all axes, I = I_pid + u/K_i within their limits (5.1 to 5.4, 5.23)."""
    force = state[SYNCHRONOUS_FORCE:WINDOW]
    for k in range(N_AXES):
        gains = parameters[GAINS + k * pid.N_GAINS : GAINS + (k + 1) * pid.N_GAINS]
        memory = state[MEMORY + k * pid.N_MEMORY : MEMORY + (k + 1) * pid.N_MEMORY]
        x = inputs[SENSOR_OF_AXIS[k]]
        if state[STARTED] == 0.0:
            memory[pid.POSITION] = x
        pid.differentiate(memory, x, parameters[DERIVATIVE_TIME], parameters[SAMPLE_TIME])
        demand = pid.pid_current(gains, memory) + rolac.force_at(force, k, inputs[THETA]) / gains[pid.K_I]
        y = outputs[k * AXIS_OUTPUTS : (k + 1) * AXIS_OUTPUTS]
        y[CURRENT] = pid.limit_and_integrate(gains, memory, demand, sample_time)
        y[FORCE] = math.hypot(force[2 * k], force[2 * k + 1])
        y[FORCE_PHASE] = math.atan2(force[2 * k + 1], force[2 * k])


@kernel
def initialise(constants: Array, parameters: Array, inputs: Array, state: Array, work: Array, outputs: Array) -> int:
    """Currents for the first inputs: proportional terms alone. It is no sample; the first `step` is."""
    if inputs[ENABLE] != 0.0 and constants[0] < 1.0:
        return FAULT_NO_TABLE
    outputs[:] = 0.0
    control(parameters, inputs, state, 0.0, outputs)
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
    """One sample: synchronous signals, synchronous forces, currents to hold over the step."""
    h = parameters[SAMPLE_TIME]
    if abs(step_size - h) > STEP_TOLERANCE * h + ROUNDING * abs(time):
        return FAULT_STEP
    if inputs[ENABLE] != 0.0 and constants[0] < 1.0:
        return FAULT_NO_TABLE

    valid = transform(parameters, inputs, state[WINDOW:], work)
    active = valid and inputs[ENABLE] != 0.0
    force = state[SYNCHRONOUS_FORCE:WINDOW]
    if active:
        rolac.adapt(constants, inputs[OMEGA], parameters[ALPHA] * h, work, force)
    else:
        force[:] = 0.0

    control(parameters, inputs, state, h, outputs)
    state[STARTED] = 1.0
    for s in range(N_SENSORS):
        outputs[AMPLITUDE + 2 * s] = math.hypot(work[2 * s], work[2 * s + 1])
        outputs[PHASE + 2 * s] = math.atan2(work[2 * s + 1], work[2 * s])
    outputs[ACTIVE] = 1.0 if active else 0.0
    outputs[VALID] = 1.0 if valid else 0.0
    return 0


MODEL = Model(
    name="rolac_controller",
    description="Sampled PID of two magnetic bearings with adaptive control (ROLAC) of synchronous vibration",
    interface=INTERFACE,
    initialise=initialise,
    step=step,
    n_state=N_STATE,
    n_work=N_WORK,
    packages=("rolac_controller", "fmi_export"),
    variable_step=False,
    faults={
        FAULT_STEP: "the communication step size is not allowed; it must equal sample_time = {sample_time} s",
        FAULT_NO_TABLE: "rolac_enable = 1 is not allowed; this FMU was built without a table of receptances, "
        "so rolac_enable must be 0",
    },
)
