"""Enumerations of parameters and outputs: numbers, names and meanings."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from fmi_export.jit import kernel
from fmi_export.variables import Enumeration

# Of rolac.mode.
MODES = Enumeration(
    "SynchronousControl",
    (
        ("rolac", "recursive open-loop adaptive control"),
        ("olac", "open-loop adaptive control, which updates the force whenever the vibration is steady"),
        ("notch", "generalised notch, which removes the synchronous current"),
        ("force_free", "removal of the synchronous bearing force"),
    ),
)
ROLAC, OLAC, NOTCH, FORCE_FREE = range(4)

# Of contact.source.
SOURCES = Enumeration(
    "ContactSource",
    (
        ("none", "no detection of contact"),
        ("sensors", "the sensors at the bearings and contact.clearance"),
        ("given", "the input contact_state"),
    ),
)
NO_SOURCE, OWN_SENSORS, GIVEN = range(3)

# Of rolac_status. From TOO_SLOW on only the PID acts.
STATUSES = Enumeration(
    "RolacStatus",
    (
        ("off", ""),
        ("adapting", ""),
        ("identifying", "the forces are held while an identification runs"),
        ("too_slow", "PID alone, because Omega is below rolac.min_speed"),
        ("no_window", "PID alone, because the window holds no full revolution or theta does not rotate at Omega"),
        ("no_h", "PID alone, because the table has no H for the speed or for one of the harmonics"),
        ("sensor_suspect", "PID alone, because the reading of suspect_sensor is constant"),
    ),
)
OFF, ADAPTING, IDENTIFYING, TOO_SLOW, NO_WINDOW, NO_H, SENSOR_SUSPECT = range(7)

# Of identification_state. The slots begin with SLOT_BEFORE; a slot for each axis and `LastStages` follow.
NOT_STARTED, WAITING, SLOT_BEFORE = range(3)


class LastStages(NamedTuple):
    """The values of identification_state that follow the slots of the axes."""

    slot_after: int
    done: int
    failed: int


@kernel
def last_stages(n_axes: int) -> LastStages:
    """Return the values of identification_state that follow the slots of this number of axes."""
    slot_after = SLOT_BEFORE + 1 + n_axes
    return LastStages(slot_after, slot_after + 1, slot_after + 2)


def stages(axes: Iterable[str]) -> Enumeration:
    """Return the values of identification_state for axes with these names."""
    return Enumeration(
        "IdentificationStage",
        (
            ("not_started", "no identification has begun"),
            ("waiting", "waiting for a valid window"),
            ("before", "slot without test force, before the axes"),
            *((axis.replace(".", "_"), f"test force at {axis}") for axis in axes),
            ("after", "slot without test force, after the axes"),
            ("done", ""),
            ("failed", ""),
        ),
    )


# Of identification_error.
ERRORS = Enumeration(
    "IdentificationError",
    (
        ("none", ""),
        ("switched_off", "identify was switched off"),
        ("window_lost", "the window became invalid"),
        ("speed_changed", "the speed changed"),
        ("current_limited", "a current reached its limit"),
        ("contact", "a journal came into contact"),
        ("vibration_changed", "the vibration without test force changed"),
        ("ill_conditioned", "the receptance is ill-conditioned"),
        ("table_full", "the table is full"),
    ),
)
(
    NO_ERROR,
    SWITCHED_OFF,
    WINDOW_LOST,
    SPEED_CHANGED,
    CURRENT_LIMITED,
    CONTACT_OCCURRED,
    VIBRATION_CHANGED,
    ILL_CONDITIONED,
    TABLE_FULL,
) = range(9)
