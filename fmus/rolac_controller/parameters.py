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
        "Time between samples, which is also the longest allowed communication step",
        250e-6,
        minimum=1e-6,
        maximum=0.1,
    ),
    parameter(
        "prediction_time",
        "s",
        "Time by which displacements and angle are extrapolated if the master delays connections; in Jacobi order, two "
        "communication steps",
        0.0,
        minimum=0.0,
        maximum=0.1,
    ),
    _tunable(
        "derivative_time",
        "s",
        "Time constant of the filter of the derivative, or 0 for a backward difference",
        0.0,
    ),
    _switch("pid.direct", "Whether the PID uses the gains k_p and k_d instead of k_b + k_s and c_b"),
)


def _axis(b: str, a: str) -> list[Variable]:
    declare, *_ = at_place(f"{b}.{{}}_{a}", f"at {b.upper()} in {a}")
    gain = partial(declare, tunable=True)
    return [
        gain("k_b", "N/m", "Net stiffness of the controlled bearing {}", 1e6),
        gain("c_b", "N.s/m", "Damping of the controlled bearing {}", 5e3, minimum=0.0),
        gain("k_integral", "N/(m.s)", "Gain of the integral of the displacement error {}", 0.0, minimum=0.0),
        gain("k_s", "N/m", "Negative stiffness of the bearing {}, which the PID compensates", BEARING_K_S),
        gain("k_i", "N/A", "Current stiffness of the bearing {}", BEARING_K_I, minimum=1e-6),
        gain("i_min", "A", "Lower limit of the control current {}", -5.57, maximum=0.0),
        gain("i_max", "A", "Upper limit of the control current {}", 4.43, minimum=0.0),
        gain("k_p", "N/m", "Proportional gain {}, used with pid.direct", 2.7e6),
        gain("k_d", "N.s/m", "Derivative gain {}, used with pid.direct", 5e3, minimum=0.0),
    ]


def _harmonic(number: int) -> list[Variable]:
    first = number == 1
    return [
        _choice(
            f"harmonic{number}.order",
            f"Order of harmonic number {number} as a multiple of the speed"
            + ("" if first else ", or 0 to omit this harmonic and all later ones"),
            1 if first else 0,
            1 if first else 0,
            LARGEST_ORDER,
        ),
        parameter(
            f"harmonic{number}.power",
            "1",
            f"Relative power of harmonic number {number} in a test force with several harmonics",
            1.0,
            minimum=0.0,
            maximum=1e6,
        ),
    ]


def _weight(sensor: str, where: str) -> list[Variable]:
    description = f"Weight of the sensor {where} in the synchronous control"
    return [parameter(f"{sensor}.weight", "1", description, 1.0, minimum=0.0, maximum=1e6, field=".")]


ADAPTATION = (
    parameter("rolac.mode", "1", "Law of the control of the synchronous vibration", ROLAC, **enumerated(MODES)),
    _tunable(
        "rolac.alpha",
        "1/s",
        "Rate at which ROLAC, notch and force_free adapt the force, or 0 to hold the force",
        7.0,
    ),
    _tunable(
        "rolac.fade",
        "1/s",
        "Rate at which the force fades while ROLAC is off or suspended (1/sample_time or more removes it at once)",
        20.0,
    ),
    _tunable(
        "rolac.min_speed",
        "rad/s",
        "Lowest speed at which synchronous signals are computed and ROLAC acts",
        2.0 * math.pi * 5.0,
    ),
    _tunable(
        "rolac.force_limit",
        "N",
        "Largest synchronous force of an axis, as the sum of the amplitudes of all harmonics",
        1700.0,
    ),
    _switch(
        "rolac.extrapolate",
        "Whether ROLAC uses the matrix H of the nearest speed outside the table, instead of being off there",
        True,
        tunable=True,
    ),
    _switch(
        "rolac.check_sensors",
        "Whether ROLAC is suspended if one reading stays constant for a revolution while others change",
        True,
    ),
    _tunable(
        "olac.steadiness",
        "1",
        "Relative change of the vibration between revolutions up to which OLAC considers it steady",
        0.02,
    ),
    _choice("olac.updates", "Number of updates after OLAC is switched on, or 0 for an unlimited number", 0, 0, 10**6),
    parameter("contact.source", "1", "Source of the information on contact", NO_SOURCE, **enumerated(SOURCES)),
    _switch(
        "contact.aware", "Whether the adaptation takes into account the contact that contact.source reports", False
    ),
    _tunable(
        "contact.lead",
        "rad",
        "Phase lead of the contact-aware step for a journal in contact over the direction opposite to its displacement",
        math.pi / 6.0,
        maximum=math.pi / 2.0,
    ),
    parameter(
        "contact.clearance",
        "m",
        "Radial clearance of the retainer bearings",
        0.75e-3,
        minimum=1e-6,
        maximum=0.1,
    ),
    _tunable(
        "contact.threshold",
        "1",
        "Ratio of displacement to contact.clearance from which the sensors report contact",
        0.98,
        maximum=1.0,
    ),
)

IDENTIFICATION = (
    _switch(
        "identification.multi",
        "Whether all harmonics are identified at once, with phases by Schroeder's rule, instead of only the first",
    ),
    _tunable(
        "identification.force_scale",
        "1",
        "Ratio of the test force to its built-in amplitude, which depends on the frequency",
        1.0,
        maximum=1e3,
    ),
    _choice(
        "identification.average",
        "Number of revolutions at the end of each slot of an identification over which the vibration is averaged",
        15,
        1,
        40,
    ),
    _tunable(
        "identification.max_drift",
        "1",
        "Largest accepted change of the vibration without test force, relative to the largest response",
        0.05,
    ),
    parameter(
        "identification.max_condition",
        "1",
        "Largest condition number at which a receptance is inverted",
        1e4,
        minimum=1.0,
        maximum=1e12,
    ),
)


def _plane_position(number: int, plane: SensorPlane) -> list[Variable]:
    description = f"Axial position of sensor plane {plane.name} with the inputs {plane.x} and {plane.y}"
    return [parameter(f"plane{number}.z", "m", description, plane.position, field=".")]


def _plane_offset(number: int, plane: SensorPlane) -> list[Variable]:
    description = f"Axial offset of the sensors of plane {plane.name} from plane{number}.z"
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
            array=Array("sensor_weights", f"Weights of the sensors {sensors} in the synchronous control"),
        ),
        *repeated(
            "sensor_scales",
            loop.sensors,
            sensor_scale,
            array=Array("sensor_scales", f"Sensitivities of the sensors {sensors} relative to the nominal value"),
        ),
        *repeated(
            "plane_positions",
            planes,
            _plane_position,
            array=Array("plane_positions", f"Axial positions of the sensor planes {where}"),
        ),
        *repeated(
            "plane_offsets",
            planes,
            _plane_offset,
            array=Array("plane_offsets", f"Axial offsets of the sensors from the positions of the planes {where}"),
        ),
    ]
