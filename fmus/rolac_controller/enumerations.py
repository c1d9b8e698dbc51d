"""Values of parameters and outputs that are one of a list, and the sentences that describe them."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from fmi_export.jit import kernel

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

# Values of identification_state. The slots begin with SLOT_BEFORE; one for each axis and `LastStages` follow.
NOT_STARTED, WAITING, SLOT_BEFORE = range(3)


class LastStages(NamedTuple):
    """The values of identification_state after the slots of the axes."""

    slot_after: int
    done: int
    failed: int


@kernel
def last_stages(n_axes: int) -> LastStages:
    """Return the last values of identification_state of a controller with so many axes."""
    slot_after = SLOT_BEFORE + 1 + n_axes
    return LastStages(slot_after, slot_after + 1, slot_after + 2)


def stage_sentences(axes: Iterable[str]) -> tuple[str, ...]:
    """Return what the values of identification_state mean, for axes of these names."""
    return (
        "none yet",
        "waiting for a valid window",
        "idle slot before",
        *(f"force at {axis}" for axis in axes),
        "idle slot after",
        "done",
        "failed",
    )


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
