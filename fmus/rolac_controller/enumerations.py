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
        ("rolac", "recursive open-loop adaptive control (5.22)"),
        ("olac", "updates whenever the vibration is steady"),
        ("notch", "generalised notch: no synchronous current"),
        ("force_free", "no synchronous bearing force"),
    ),
)
ROLAC, OLAC, NOTCH, FORCE_FREE = range(4)

# Of contact.source.
SOURCES = Enumeration(
    "ContactSource",
    (
        ("none", "not at all"),
        ("sensors", "from the sensors at the bearings and contact.clearance"),
        ("given", "from the input contact_state"),
    ),
)
NO_SOURCE, OWN_SENSORS, GIVEN = range(3)

# Of rolac_status. From TOO_SLOW on only the PID acts.
STATUSES = Enumeration(
    "RolacStatus",
    (
        ("off", ""),
        ("adapting", ""),
        ("identifying", "forces held while an identification runs"),
        ("too_slow", "PID alone: Omega is below rolac.min_speed"),
        ("no_window", "PID alone: no full revolution in the window, or theta does not rotate at Omega"),
        ("no_h", "PID alone: the table has no H for the speed, or for one of several harmonics"),
        ("sensor_suspect", "PID alone: the reading of suspect_sensor is constant"),
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
            ("not_started", "none yet"),
            ("waiting", "waiting for a valid window"),
            ("before", "idle slot before"),
            *((axis.replace(".", "_"), f"force at {axis}") for axis in axes),
            ("after", "idle slot after"),
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
        ("contact", ""),
        ("vibration_changed", "the vibration without force changed"),
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
