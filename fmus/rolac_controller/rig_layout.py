"""Sensors, bearing axes and sensor planes of the rig: how many there are, and what they are called."""

from __future__ import annotations

N_SENSORS, N_AXES, N_PLANES, N_BEARINGS = 8, 4, 4, 2
N_HARMONICS = 4  # that can be controlled at the same time

# Each axis is controlled by the sensor at its bearing; the other four sensors serve the synchronous control only.
AXES = (("mb1", "x", "s5"), ("mb1", "y", "s6"), ("mb2", "x", "s3"), ("mb2", "y", "s4"))
BEARINGS = ("mb1", "mb2")
PLANES = ("motor end", "MB2", "MB1", "non-driven end")
SENSORS = tuple((f"s{k + 1}", f"{PLANES[k // 2]}, {'xy'[k % 2]} axis") for k in range(N_SENSORS))
SENSOR_NAMES = tuple(name for name, _ in SENSORS)
SENSOR_OF_AXIS = tuple(SENSOR_NAMES.index(sensor) for _, _, sensor in AXES)
