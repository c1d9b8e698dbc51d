"""Sizes, names and enumerations that tables and kernels share."""

from __future__ import annotations

N_SENSORS, N_AXES, N_PLANES, N_BEARINGS = 8, 4, 4, 2
N_HARMONICS = 4  # that can be controlled side by side

# Each axis is controlled by the sensor at its bearing; the other four only serve the synchronous control.
AXES = (("mb1", "x", "s5"), ("mb1", "y", "s6"), ("mb2", "x", "s3"), ("mb2", "y", "s4"))
PLANES = ("motor end", "MB2", "MB1", "non-driven end")
SENSORS = tuple((f"s{k + 1}", f"{PLANES[k // 2]}, {'xy'[k % 2]} axis") for k in range(N_SENSORS))
SENSOR_NAMES = tuple(name for name, _ in SENSORS)
SENSOR_OF_AXIS = tuple(SENSOR_NAMES.index(sensor) for _, _, sensor in AXES)

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
OFF, ADAPTING, HELD, TOO_SLOW, NO_WINDOW, NO_H, SUSPECT = range(len(STATUSES))

# Values of identification_state. From BEFORE to AFTER they are the six slots.
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
NONE, WAITING, BEFORE = range(3)
AFTER, DONE, FAILED = range(BEFORE + 1 + N_AXES, len(STAGES))
N_SLOTS = AFTER - BEFORE + 1

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
NO_ERROR, ABORTED, WINDOW_LOST, SPEED_CHANGED, LIMITED, CONTACT, DRIFTED, ILL_CONDITIONED, TABLE_FULL = range(
    len(ERRORS)
)
