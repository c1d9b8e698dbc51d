"""Values of parameters and outputs that are one of a list, and the sentences that describe them."""

from __future__ import annotations

from rolac_controller.rig_layout import N_AXES

# Values of rolac.mode.
MODES = ("rolac", "olac", "notch", "force_free")
ROLAC, OLAC, NOTCH, FORCE_FREE = range(len(MODES))

# Values of chain.preset.
PRESETS = ("ideal", "rig", "custom")
IDEAL, RIG, CUSTOM = range(len(PRESETS))

# Values of contact.source.
NO_SOURCE, OWN_SENSORS, GIVEN = range(3)

# Values of rolac_status. From TOO_SLOW on the PID works alone.
STATUSES = (
    "off",
    "adapting",
    "forces held while an identification runs",
    "PID alone: Omega is below rolac.min_speed",
    "PID alone: no full revolution in the window, or theta does not turn as Omega says",
    "PID alone: the table has no H for the speed (several harmonics: for one of them)",
    "PID alone: suspect_sensor does not move",
)
OFF, ADAPTING, IDENTIFYING, TOO_SLOW, NO_WINDOW, NO_H, SENSOR_SUSPECT = range(len(STATUSES))

# Values of identification_state. From SLOT_BEFORE to SLOT_AFTER they are the six slots.
STAGES = (
    "none yet",
    "waiting for a valid window",
    "idle slot before",
    "force at mb1.x",
    "force at mb1.y",
    "force at mb2.x",
    "force at mb2.y",
    "idle slot after",
    "done",
    "failed",
)
NOT_STARTED, WAITING, SLOT_BEFORE = range(3)
SLOT_AFTER, DONE, FAILED = range(SLOT_BEFORE + 1 + N_AXES, len(STAGES))
N_SLOTS = SLOT_AFTER - SLOT_BEFORE + 1

# Values of identification_error.
ERRORS = (
    "none",
    "identify was switched off",
    "the window became invalid",
    "the speed changed",
    "a current reached its limit",
    "contact",
    "the vibration without force changed",
    "the receptance is ill-conditioned",
    "the table is full",
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
) = range(len(ERRORS))
