"""Inputs and outputs of the controller: names, units, ranges, and positions in the records that kernels use."""

from __future__ import annotations

from fmi_export.interface import repeated
from fmi_export.variables import FAULT, Array, Enumeration, Variable, enumerated, input_, output
from rolac_controller.control_loop import N_HARMONICS, ControlLoop
from rolac_controller.enumerations import ERRORS, STATUSES, stages
from signal_chain.variables import FAULT_INPUTS, sensor_faults

LARGEST_ANGLE = 1e9  # rad, 18 days at full speed; it still resolves 1e-7 rad
LARGEST_SPEED = 1e5  # rad/s, 955,000 rpm: beyond the bursting speed of any rotor of this kind
LARGEST_CONDITION = 1e16


def _displacement(name: str, where: str) -> list[Variable]:
    return [
        input_(name, "m", f"Displacement of the rotor {where}", minimum=-0.1, maximum=0.1, field=".", display_unit="um")
    ]


def _displacement_array(loop: ControlLoop) -> Array:
    return Array("sensors", f"Displacements of the rotor at the sensors {', '.join(loop.sensor_names)}")


def _setpoint(b: str, a: str) -> list[Variable]:
    description = f"Setpoint of the displacement at {b.upper()} in {a}"
    return [input_(f"{b}.set_{a}", "m", description, minimum=-0.1, maximum=0.1, field=".", display_unit="um")]


def input_variables(loop: ControlLoop) -> list[Variable]:
    """Return the inputs of a controller for this loop."""
    return [
        *_COMMON_INPUTS,
        _contact_state(loop.bearings),
        # The range is wide, but narrow enough to reject values in mm or um.
        *repeated("displacements", loop.sensors, _displacement, array=_displacement_array(loop)),
        *repeated("setpoints", [(bearing, axis) for bearing, axis, _ in loop.axes], _setpoint),
        *repeated("faults", loop.sensors, sensor_faults),
    ]


def _contact_state(bearings: tuple[str, ...]) -> Variable:
    """Input for the journals in contact: the sum of 2^k over all bearings k that are in contact."""
    parts = ", ".join(f"{2**k} for {bearing.upper()}" for k, bearing in enumerate(bearings))
    description = (
        f"Contact with the retainers, as the sum of {parts}, or 0 without contact, used if contact.source is 2 (given)"
    )
    largest = 2 ** len(bearings) - 1
    return input_("contact_state", "1", description, type="Integer", minimum=0, maximum=largest)


_COMMON_INPUTS = (
    input_(
        "Omega",
        "rad/s",
        "Rotor speed, which must be positive for synchronous control",
        minimum=-LARGEST_SPEED,
        maximum=LARGEST_SPEED,
    ),
    input_(
        "theta",
        "rad",
        "Rotor angle, which may be wrapped to one revolution",
        minimum=-LARGEST_ANGLE,
        maximum=LARGEST_ANGLE,
    ),
    input_("rolac_enable", "1", "Whether ROLAC is switched on", type="Boolean"),
    input_(
        "identify",
        "1",
        "Request that starts an identification when it becomes true and aborts it when it becomes false",
        type="Boolean",
    ),
    input_(
        "shown_harmonic",
        "1",
        "Number of the harmonic whose amplitudes, phases, forces and receptance are in the outputs",
        type="Integer",
        start=1,
        minimum=1,
        maximum=N_HARMONICS,
    ),
)

SELECTION_INPUTS = ("shown_harmonic",)
ROTATION_INPUTS = ("Omega", "theta")


def _sensor_inputs(loop: ControlLoop) -> tuple[str, ...]:
    names = loop.sensor_names
    return (*names, *(f"{name}.{fault}" for name in names for fault in FAULT_INPUTS))


def _inputs_of_sensor(loop: ControlLoop, sensor: int) -> tuple[str, ...]:
    """Inputs that affect a sensor: its faults and, due to axial offsets, displacements along its axis at all planes."""
    names = loop.sensor_names
    return (*names[sensor % 2 :: 2], *(f"{names[sensor]}.{fault}" for fault in FAULT_INPUTS))


# Parameters that the measured displacements at the start depend on, in addition to inputs and scales of the sensors.
MEASURED = ("chain.preset", "chain.adc", "chain.sensitivity", "chain.adc_range")
DAC = ("chain.preset", "chain.dac", "chain.dac_bits", "chain.dac_range", "chain.amplifier_gain")
GAINS = ("k_b", "k_s", "k_i", "k_p", "i_min", "i_max")  # parameters that a current at rest depends on


def _measured_at_start(loop: ControlLoop, sensor: int) -> tuple[str, ...]:
    """Parameters (except the ADC's bits) and inputs that determine a sensor's measured displacement at the start."""
    name = loop.sensor_names[sensor]
    faults = tuple(f"{name}.fault_{kind}" for kind in ("dead", "stuck", "offset"))  # noise begins with the samples
    others = (*loop.sensor_names[sensor % 2 :: 2], f"plane{sensor // 2 + 1}.offset", "plane_positions[*]")
    return (name, *(others if len(loop.planes) > 1 else ()), *faults, f"{name}.scale", *MEASURED)


def _current_at_start(loop: ControlLoop, b: str, a: str, sensor: str) -> tuple[str, ...]:
    """Parameters and inputs that determine the current of an axis at the start."""
    measured = _measured_at_start(loop, loop.sensor_names.index(sensor))
    gains = (f"{b}.{gain}_{a}" for gain in GAINS)
    return (*measured, "chain.adc_bits", "pid.direct", *gains, f"{b}.set_{a}", *DAC)


def _later(name: str, unit: str, what: str, depends_on: tuple[str, ...], **options: object) -> Variable:
    """Declare an output that is valid from the first sample and always starts with the same value."""
    return output(name, unit, what, depends_on=depends_on, initially_depends_on=(), **options)


def _axis(b: str, a: str, adaptation: tuple[str, ...], start: tuple[str, ...]) -> list[Variable]:
    at, reached = f"at {b.upper()} in {a}", (*adaptation, *SELECTION_INPUTS)
    return [
        output(
            f"{b}.i_{a}",
            "A",
            f"Demanded control current {at}, positive for a force towards positive displacements",
            depends_on=(*adaptation, f"{b}.set_{a}"),
            initially_depends_on=start,
            field="current",
        ),
        _later(f"{b}.u_{a}", "N", f"Amplitude of the synchronous force {at}", reached, field="force_amplitude"),
        _later(
            f"{b}.u_phase_{a}",
            "rad",
            f"Phase of the synchronous force {at}, positive if it leads theta",
            reached,
            field="force_phase",
        ),
    ]


def _sensor(name: str, where: str, signal_inputs: tuple[str, ...]) -> list[Variable]:
    reached = (*signal_inputs, *ROTATION_INPUTS, *SELECTION_INPUTS)
    amplitude, phase = (
        f"Amplitude of the synchronous displacement {where}",
        f"Phase of the synchronous displacement {where}",
    )
    return [
        _later(f"amplitude.{name}", "m", amplitude, reached, field="amplitude", display_unit="um"),
        _later(f"phase.{name}", "rad", f"{phase}, positive if it leads theta", reached, field="phase"),
    ]


def _harmonic(number: int, sensors: tuple[str, ...], adaptation: tuple[str, ...]) -> list[Variable]:
    moved, pushed = (
        f"Root of the sum of the squared {of} for harmonic number {number}"
        for of in ("displacement amplitudes of all sensors", "force amplitudes of all axes")
    )
    rotating = (*sensors, *ROTATION_INPUTS)
    return [
        _later(f"harmonic{number}.displacement", "m", moved, rotating, display_unit="um"),
        _later(f"harmonic{number}.force", "N", pushed, adaptation),
    ]


def _receptance(sensor: str, b: str, a: str, adaptation: tuple[str, ...]) -> list[Variable]:
    what = f"part of the identified receptance from a force at {b}.{a} to the sensor {sensor}"
    reached = (*adaptation, *SELECTION_INPUTS)
    parts = (("re", "Real"), ("im", "Imaginary"))
    return [_later(f"r.{sensor}.{b}_{a}.{part}", "m/N", f"{word} {what}", reached) for part, word in parts]


def _receptance_array(loop: ControlLoop) -> Array:
    rows, columns = ", ".join(loop.sensor_names), ", ".join(loop.axis_names)
    description = f"Identified receptance, by sensor ({rows}), force ({columns}), and real and imaginary part"
    return Array("receptance", description)


def _contact_share(b: str, sensors: tuple[str, ...]) -> list[Variable]:
    what = f"Fraction of time in contact at {b.upper()}, averaged over about one revolution"
    reached = (*sensors, "theta", "contact_state")
    return [_later(f"{b}.contact_share", "1", what, reached, minimum=0.0, maximum=1.0, field=".")]


def _flag(
    name: str, what: str, depends_on: tuple[str, ...], warning: str = "", initially_depends_on: tuple[str, ...] = ()
) -> Variable:
    return output(
        name,
        "1",
        what,
        type="Boolean",
        depends_on=depends_on,
        initially_depends_on=initially_depends_on,
        warning=warning,
    )


def _number(name: str, what: str, maximum: float, depends_on: tuple[str, ...]) -> Variable:
    return _later(name, "1", what, depends_on, type="Integer", minimum=0, maximum=maximum)


def _choice(
    name: str, what: str, values: Enumeration, depends_on: tuple[str, ...], initially_depends_on: tuple[str, ...] = ()
) -> Variable:
    return output(
        name, "1", what, depends_on=depends_on, initially_depends_on=initially_depends_on, **enumerated(values)
    )


def output_variables(loop: ControlLoop) -> list[Variable]:
    """Return the outputs of a controller for this loop."""
    axes = [(bearing, axis) for bearing, axis, _ in loop.axes]
    currents = {(b, a): _current_at_start(loop, b, a, sensor) for b, a, sensor in loop.axes}
    measured = {name for k in range(len(loop.sensors)) for name in _measured_at_start(loop, k)}
    sensors = _sensor_inputs(loop)
    adaptation = (*sensors, *ROTATION_INPUTS, "rolac_enable", "identify", "contact_state")
    setpoints = tuple(f"{b}.set_{a}" for b, a in axes)
    return [
        _flag("rolac_active", "Whether ROLAC is adapting its force", adaptation),
        _flag("window_valid", "Whether the synchronous signals cover a full revolution", ROTATION_INPUTS),
        _choice(
            "rolac_status",
            "State of ROLAC",
            STATUSES,
            adaptation,
            initially_depends_on=("rolac_enable", "Omega", "rolac.min_speed"),
        ),
        _flag(
            "rolac_limited",
            "Whether a synchronous force is at rolac.force_limit",
            adaptation,
            "a synchronous force is at its limit, {rolac.force_limit} N",
        ),
        _flag(
            "h_extrapolated",
            "Whether the speed is outside the table, so that the matrix H of the nearest speed is used",
            adaptation,
            "Omega = {Omega} rad/s is outside the table, so that the matrix H of the nearest speed is used",
        ),
        _flag(
            "current_limited",
            "Whether a demanded current is at its limit",
            (*adaptation, *setpoints),
            "a demanded current is at its limit, set by i_min and i_max of its axis, or by the range of the DAC",
            initially_depends_on=tuple(sorted({name for start in currents.values() for name in start})),
        ),
        _flag(
            "adc_limited",
            "Whether a displacement is beyond the range of the ADC",
            sensors,
            "a displacement is beyond the range of the ADC, {chain.adc_range} V at {chain.sensitivity} V/m",
            initially_depends_on=tuple(sorted(measured)),
        ),
        _number(
            "suspect_sensor",
            "Number of the first sensor whose reading stays constant while others change, or 0 if there is none",
            len(loop.sensors),
            sensors,
        ),
        _number("table_rows", "Number of rows in the table of H, one for each speed and harmonic", 1e6, adaptation),
        _choice("identification_state", "Stage of the identification", stages(loop.axis_names), adaptation),
        _choice("identification_error", "Cause for which the identification failed", ERRORS, adaptation),
        _later(
            "identification_progress",
            "1",
            "Completed fraction of the identification",
            adaptation,
            minimum=0.0,
            maximum=1.0,
        ),
        _later("identification_speed", "rad/s", "Speed of the last completed identification", adaptation),
        _later(
            "condition_number",
            "1",
            "Condition number of the last identified receptance, including the weights of the sensors",
            (*adaptation, *SELECTION_INPUTS),
            minimum=0.0,
            maximum=LARGEST_CONDITION,
        ),
        *repeated("axes", [(b, a, adaptation, currents[b, a]) for b, a in axes], _axis),
        *repeated("sensors", [(*s, _inputs_of_sensor(loop, k)) for k, s in enumerate(loop.sensors)], _sensor),
        *repeated("harmonics", [(k + 1, sensors, adaptation) for k in range(N_HARMONICS)], _harmonic),
        *repeated("contact_shares", [(b, sensors) for b in loop.bearings], _contact_share),
        *repeated(
            "receptance",
            [(sensor, b, a, adaptation) for sensor in loop.sensor_names for b, a in axes],
            _receptance,
            shape=loop.shape,
            array=_receptance_array(loop),
        ),
        FAULT,
    ]
