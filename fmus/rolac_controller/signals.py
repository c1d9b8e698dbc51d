"""Inputs and outputs of the controller: names, units, ranges, and their places in the records that kernels see."""

from __future__ import annotations

from fmi_export.variables import Variable, input_, output, repeated
from rolac_controller.enumerations import ERRORS, STAGES, STATUSES
from rolac_controller.rig_layout import AXES, BEARINGS, N_AXES, N_HARMONICS, N_SENSORS, SENSOR_NAMES, SENSORS

LARGEST_ANGLE = 1e9  # rad, 18 days at full speed; it still resolves 1e-7 rad
LARGEST_SPEED = 1e4  # rad/s
LARGEST_CONDITION = 1e16

FAULT_INPUTS = ("fault_dead", "fault_stuck", "fault_offset", "fault_noise")


def _faults(name: str, where: str) -> list[Variable]:
    def fault(kind: str, unit: str, description: str, **options: object) -> Variable:
        return input_(f"{name}.fault_{kind}", unit, f"Fault: {description}, {where}", field=kind, **options)

    return [
        fault("dead", "1", "the sensor shows 0", type="Boolean"),
        fault("stuck", "1", "the sensor stays as it is", type="Boolean"),
        fault("offset", "m", "the sensor shows so much more", minimum=-0.1, maximum=0.1),
        fault("noise", "m", "standard deviation of a burst of noise", minimum=0.0, maximum=0.1),
    ]


def _displacement(name: str, where: str) -> list[Variable]:
    return [input_(name, "m", f"Displacement, {where}", minimum=-0.1, maximum=0.1, field=".")]


def _setpoint(b: str, a: str) -> list[Variable]:
    description = f"Setpoint of the displacement, {b.upper()}, {a} axis"
    return [input_(f"{b}.set_{a}", "m", description, minimum=-0.1, maximum=0.1, field=".")]


# The range of a displacement is wide, but narrow enough to reject values in mm or um.
INPUT_VARIABLES = (
    *repeated("displacements", SENSORS, _displacement),
    input_(
        "Omega",
        "rad/s",
        "Rotor speed; the synchronous control needs a positive one",
        minimum=-LARGEST_SPEED,
        maximum=LARGEST_SPEED,
    ),
    input_(
        "theta", "rad", "Rotor angle, wrapped to a revolution or not", minimum=-LARGEST_ANGLE, maximum=LARGEST_ANGLE
    ),
    input_("rolac_enable", "1", "Switches ROLAC on", type="Boolean"),
    input_("identify", "1", "Starts an identification when it becomes true, aborts it when false", type="Boolean"),
    input_(
        "contact_state",
        "1",
        "For contact.source 2: 0 no contact, 1 at MB1, 2 at MB2, 3 at both",
        type="Integer",
        minimum=0,
        maximum=3,
    ),
    input_(
        "shown_harmonic",
        "1",
        "Number of the harmonic whose amplitudes, phases, forces and receptance the outputs show",
        type="Integer",
        start=1,
        minimum=1,
        maximum=N_HARMONICS,
    ),
    *repeated("setpoints", [(b, a) for b, a, _ in AXES], _setpoint),
    *repeated("faults", SENSORS, _faults),
)

SELECTION_INPUTS = ("shown_harmonic",)
ROTATION_INPUTS = ("Omega", "theta")
SENSOR_INPUTS = tuple(v.name for v in INPUT_VARIABLES if v.name.split(".")[0] in SENSOR_NAMES)
ADAPTATION_INPUTS = (*SENSOR_INPUTS, *ROTATION_INPUTS, "rolac_enable", "identify", "contact_state")
SETPOINT_INPUTS = tuple(f"{b}.set_{a}" for b, a, _ in AXES)


def _inputs_of_sensor(sensor: int) -> tuple[str, ...]:
    """Inputs that reach a sensor: the displacements of its axis, which an axial offset mixes, and its faults."""
    axis = SENSOR_NAMES[sensor % 2 :: 2]
    return (*axis, *(f"{SENSOR_NAMES[sensor]}.{fault}" for fault in FAULT_INPUTS))


def _axis(b: str, a: str) -> list[Variable]:
    at = f"{b.upper()}, {a} axis"
    return [
        output(
            f"{b}.i_{a}",
            "A",
            f"Demanded control current, {at}",
            depends_on=(*ADAPTATION_INPUTS, f"{b}.set_{a}"),
            field="current",
        ),
        output(
            f"{b}.u_{a}",
            "N",
            f"Amplitude of the synchronous force, {at}",
            depends_on=(*ADAPTATION_INPUTS, *SELECTION_INPUTS),
            field="force_amplitude",
        ),
        output(
            f"{b}.u_phase_{a}",
            "rad",
            f"Phase of the synchronous force, {at}",
            depends_on=(*ADAPTATION_INPUTS, *SELECTION_INPUTS),
            field="force_phase",
        ),
    ]


def _sensor(k: int) -> list[Variable]:
    name, where = SENSORS[k]
    reached = (*_inputs_of_sensor(k), *ROTATION_INPUTS, *SELECTION_INPUTS)
    return [
        output(f"amplitude.{name}", "m", f"Synchronous amplitude, {where}", depends_on=reached, field="amplitude"),
        output(f"phase.{name}", "rad", f"Phase of the synchronous part, {where}", depends_on=reached, field="phase"),
    ]


def _harmonic(number: int) -> list[Variable]:
    return [
        output(
            f"harmonic{number}.displacement",
            "m",
            f"Root of the sum of squares of the eight amplitudes, harmonic number {number}",
            depends_on=(*SENSOR_INPUTS, *ROTATION_INPUTS),
        ),
        output(
            f"harmonic{number}.force",
            "N",
            f"Root of the sum of squares of the four forces, harmonic number {number}",
            depends_on=ADAPTATION_INPUTS,
        ),
    ]


def _receptance(sensor: str, b: str, a: str) -> list[Variable]:
    what = f"part of the identified receptance, {sensor} by a force at {b}.{a} (6.7)"
    return [
        output(
            f"r.{sensor}.{b}_{a}.{part}", "m/N", f"{word} {what}", depends_on=(*ADAPTATION_INPUTS, *SELECTION_INPUTS)
        )
        for part, word in (("re", "Real"), ("im", "Imaginary"))
    ]


def _contact_share(b: str) -> list[Variable]:
    return [
        output(
            f"{b}.contact_share",
            "1",
            f"Share of the last revolutions in contact at {b.upper()}, as contact.source tells",
            minimum=0.0,
            maximum=1.0,
            depends_on=(*SENSOR_INPUTS, "theta", "contact_state"),
            field=".",
        )
    ]


def _enumerated(sentences: tuple[str, ...]) -> str:
    return "; ".join(f"{k} {sentence}" for k, sentence in enumerate(sentences))


def _flag(name: str, description: str, depends_on: tuple[str, ...]) -> Variable:
    return output(name, "1", description, type="Boolean", depends_on=depends_on)


def _number(name: str, description: str, maximum: float, depends_on: tuple[str, ...]) -> Variable:
    return output(name, "1", description, type="Integer", minimum=0, maximum=maximum, depends_on=depends_on)


OUTPUT_VARIABLES = (
    *repeated("axes", [(b, a) for b, a, _ in AXES], _axis),
    *repeated("sensors", [(k,) for k in range(N_SENSORS)], _sensor),
    *repeated("harmonics", [(k + 1,) for k in range(N_HARMONICS)], _harmonic),
    _flag("rolac_active", "ROLAC is adapting its force", ADAPTATION_INPUTS),
    _flag("window_valid", "The synchronous signals span a full revolution", ROTATION_INPUTS),
    _number("rolac_status", f"What ROLAC does: {_enumerated(STATUSES)}", len(STATUSES) - 1, ADAPTATION_INPUTS),
    _flag("rolac_limited", "A synchronous force is at rolac.force_limit", ADAPTATION_INPUTS),
    _flag("h_extrapolated", "The speed is beyond the table, and H that of its nearest speed", ADAPTATION_INPUTS),
    _flag("current_limited", "A demanded current is at its limit", (*ADAPTATION_INPUTS, *SETPOINT_INPUTS)),
    _number(
        "suspect_sensor", "Number of a sensor that does not move while others do; 0: none", N_SENSORS, SENSOR_INPUTS
    ),
    *repeated("contact_shares", [(b,) for b in BEARINGS], _contact_share),
    _number("table_rows", "Speeds in the table of H, times harmonics", 1e6, ADAPTATION_INPUTS),
    _number("identification_state", _enumerated(STAGES), len(STAGES) - 1, ADAPTATION_INPUTS),
    _number(
        "identification_error",
        f"Why an identification failed: {_enumerated(ERRORS)}",
        len(ERRORS) - 1,
        ADAPTATION_INPUTS,
    ),
    output(
        "identification_progress",
        "1",
        "Share of the identification that is done",
        minimum=0.0,
        maximum=1.0,
        depends_on=ADAPTATION_INPUTS,
    ),
    output(
        "identification_speed",
        "rad/s",
        "Speed of the last identification that was completed",
        depends_on=ADAPTATION_INPUTS,
    ),
    output(
        "condition_number",
        "1",
        "Condition number of the last receptance identified, sensors weighted",
        minimum=0.0,
        maximum=LARGEST_CONDITION,
        depends_on=(*ADAPTATION_INPUTS, *SELECTION_INPUTS),
    ),
    *repeated(
        "receptance",
        [(sensor, b, a) for sensor in SENSOR_NAMES for b, a, _ in AXES],
        _receptance,
        shape=(N_SENSORS, N_AXES),
    ),
    output("fault_code", "1", "0 while all is well; the log says what else means", type="Integer"),
)
