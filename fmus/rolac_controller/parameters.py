"""Parameters of the controller: names, units, defaults, ranges, and positions in the records that kernels use."""

from __future__ import annotations

import math
from functools import partial

from fmi_export.interface import repeated
from fmi_export.variables import Array, Variable, at_place, enumerated, parameter
from rolac_controller.control_loop import N_HARMONICS, ControlLoop, SensorPlane
from rolac_controller.enumerations import MODES, NO_SOURCE, ROLAC, SOURCES
from signal_chain.variables import CHAIN, sensor_scale

# 2.8 and 2.9 with Table 2.2: the actuator's default linear law.
BEARING_K_S, BEARING_K_I = 2376955.7160887653, 563.1506658084571

LARGEST_ORDER = 50


def _switch(name: str, description: str, start: bool = False, **options: object) -> Variable:
    return parameter(name, "1", description, float(start), type="Boolean", **options)


def _choice(name: str, description: str, start: int, minimum: int, maximum: int, **options: object) -> Variable:
    return parameter(name, "1", description, start, minimum=minimum, maximum=maximum, type="Integer", **options)


def _tunable(name: str, unit: str, description: str, start: float, **options: object) -> Variable:
    return parameter(name, unit, description, start, tunable=True, **({"minimum": 0.0} | options))


GENERAL = (
    parameter(
        "sample_time",
        "s",
        "Time between samples; the longest communication step",
        250e-6,
        minimum=1e-6,
        maximum=0.1,
    ),
    parameter(
        "prediction_time",
        "s",
        "Extrapolation of displacements and angle, for masters with delayed connections: two communication steps in "
        "Jacobi order",
        0.0,
        minimum=0.0,
        maximum=0.1,
    ),
    _tunable(
        "derivative_time",
        "s",
        "Time constant of the derivative's filter; 0: backward difference",
        0.0,
    ),
    _switch("pid.direct", "PID with the gains k_p and k_d instead of K_b + K_s and C_b"),
)


def _axis(b: str, a: str) -> list[Variable]:
    declare, *_ = at_place(f"{b}.{{}}_{a}", f"{b.upper()}, {a} axis")
    gain = partial(declare, tunable=True)
    return [
        gain("k_b", "N/m", "Net stiffness K_b of the closed bearing, {} (5.1)", 1e6),
        gain("c_b", "N.s/m", "Damping C_b of the closed bearing, {} (5.2)", 5e3, minimum=0.0),
        gain("k_integral", "N/(m.s)", "Gain K_I of the integral, {} (5.3)", 0.0, minimum=0.0),
        gain("k_s", "N/m", "Negative stiffness K_s of the bearing, compensated, {} (2.8)", BEARING_K_S),
        gain("k_i", "N/A", "Current stiffness K_i of the bearing, {} (2.9)", BEARING_K_I, minimum=1.0),
        gain("i_min", "A", "Smallest control current, -(I_s + I_b), {}", -5.57, maximum=0.0),
        gain("i_max", "A", "Largest control current, I_b, {}", 4.43, minimum=0.0),
        gain("k_p", "N/m", "Proportional gain with pid.direct, {}", 2.7e6),
        gain("k_d", "N.s/m", "Derivative gain with pid.direct, {}", 5e3, minimum=0.0),
    ]


def _harmonic(number: int) -> list[Variable]:
    first = number == 1
    return [
        _choice(
            f"harmonic{number}.order",
            f"Harmonic number {number} that is transformed and controlled, a multiple of the speed"
            + ("" if first else "; 0: off, like all later harmonics"),
            1 if first else 0,
            1 if first else 0,
            LARGEST_ORDER,
        ),
        parameter(
            f"harmonic{number}.power",
            "1",
            f"Share of harmonic number {number} in the power of a multi-harmonic test force",
            1.0,
            minimum=0.0,
            maximum=1e6,
        ),
    ]


def _weight(sensor: str, where: str) -> list[Variable]:
    description = f"Weight of the sensor in W, {where} (5.10)"
    return [parameter(f"{sensor}.weight", "1", description, 1.0, minimum=0.0, maximum=1e6, field=".")]


ADAPTATION = (
    parameter("rolac.mode", "1", "Law of the synchronous control", ROLAC, **enumerated(MODES)),
    _tunable(
        "rolac.alpha",
        "1/s",
        "Adaptation rate of ROLAC, notch and force_free on amplitudes, (5.22) with (6.2); 0 holds the force",
        7.0,
    ),
    _tunable(
        "rolac.fade",
        "1/s",
        "Rate at which the force fades while ROLAC is off or suspended; at 1/sample_time or more, immediately",
        20.0,
    ),
    _tunable(
        "rolac.min_speed",
        "rad/s",
        "Speed below which there is no synchronous signal and no ROLAC",
        2.0 * math.pi * 5.0,
    ),
    _tunable(
        "rolac.force_limit",
        "N",
        "Largest synchronous force of an axis, amplitudes of all harmonics added (Table 2.2)",
        1700.0,
    ),
    _switch(
        "rolac.extrapolate",
        "Outside the table, use H of its nearest speed; otherwise ROLAC is off there",
        True,
        tunable=True,
    ),
    _switch(
        "rolac.check_sensors", "Suspend ROLAC if one reading stays constant for a revolution while others change", True
    ),
    _tunable(
        "olac.steadiness",
        "1",
        "Relative change of the vibration between revolutions that counts as steady for OLAC",
        0.02,
    ),
    _choice("olac.updates", "Number of updates after OLAC is switched on; 0: unlimited", 0, 0, 10**6),
    parameter("contact.source", "1", "Method of contact detection", NO_SOURCE, **enumerated(SOURCES)),
    _switch("contact.aware", "Contact-aware adaptation; contact.source selects how contact is detected", False),
    _tunable(
        "contact.lead",
        "rad",
        "Lead, relative to the displacement, of the contact-aware step for a journal in contact",
        math.pi / 6.0,
        maximum=math.pi / 2.0,
    ),
    parameter(
        "contact.clearance",
        "m",
        "Radial clearance of the retainer bearings (2.1)",
        0.75e-3,
        minimum=1e-6,
        maximum=0.1,
    ),
    _tunable(
        "contact.threshold",
        "1",
        "Ratio of displacement to clearance above which contact.source sensors detects contact",
        0.98,
        maximum=1.0,
    ),
)

IDENTIFICATION = (
    _switch(
        "identification.multi", "Identify all harmonics at once, Schroeder-phased; otherwise only harmonic number 1"
    ),
    _tunable(
        "identification.force_scale",
        "1",
        "Ratio of the test force to A(f)",
        1.0,
        maximum=1e3,
    ),
    _choice(
        "identification.average",
        "Revolutions at the end of a slot over which the vibration is averaged",
        15,
        1,
        40,
    ),
    _tunable(
        "identification.max_drift",
        "1",
        "Largest accepted change of the vibration without force, relative to the largest response",
        0.05,
    ),
    parameter(
        "identification.max_condition",
        "1",
        "Largest condition number of a receptance that is inverted",
        1e4,
        minimum=1.0,
        maximum=1e12,
    ),
)


def _plane_position(number: int, plane: SensorPlane) -> list[Variable]:
    description = f"Axial position of the inputs {plane.x}, {plane.y}, {plane.name}"
    return [parameter(f"plane{number}.z", "m", description, plane.position, field=".")]


def _plane_offset(number: int, plane: SensorPlane) -> list[Variable]:
    description = f"Axial offset of the sensors from that position, {plane.name}"
    return [parameter(f"plane{number}.offset", "m", description, 0.0, minimum=-1.0, maximum=1.0, field=".")]


def parameter_variables(loop: ControlLoop) -> list[Variable]:
    """Return the parameters of a controller of this loop."""
    planes = list(enumerate(loop.planes, 1))
    sensors, where = ", ".join(loop.sensor_names), ", ".join(plane.name for plane in loop.planes)
    return [
        *GENERAL,
        *ADAPTATION,
        *IDENTIFICATION,
        *CHAIN,
        *repeated("axes", [(bearing, axis) for bearing, axis, _ in loop.axes], _axis),
        *repeated("harmonics", [(k + 1,) for k in range(N_HARMONICS)], _harmonic),
        *repeated(
            "sensor_weights",
            loop.sensors,
            _weight,
            array=Array("sensor_weights", f"Weights in the synchronous control, {sensors}"),
        ),
        *repeated(
            "sensor_scales",
            loop.sensors,
            sensor_scale,
            array=Array("sensor_scales", f"Sensitivities relative to the nominal value, {sensors}"),
        ),
        *repeated(
            "plane_positions",
            planes,
            _plane_position,
            array=Array("plane_positions", f"Axial positions of the sensor planes, {where}"),
        ),
        *repeated(
            "plane_offsets",
            planes,
            _plane_offset,
            array=Array("plane_offsets", f"Axial offsets of the sensors from these positions, {where}"),
        ),
    ]
