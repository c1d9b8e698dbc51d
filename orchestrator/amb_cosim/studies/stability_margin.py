"""Sensitivity of the levitated rotor (ISO 14839-3): computed, and measured in a co-simulation of the three FMUs."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
from rich.table import Table

from amb_cosim.cosim.values import quantity
from amb_cosim.studies import loop_figures
from amb_cosim.studies.injection import HIGHEST, LOWEST, measure, prepared_loop
from amb_cosim.studies.loop import AXIS_NAMES, loop_of, pole_frequency, response
from amb_cosim.studies.loop import sensitivity as sensitivity_of
from amb_cosim.studies.modal import speed as spin_speed
from amb_cosim.studies.outcome import Outcome
from amb_cosim.text_tables import labelled_table
from fmi_export.model import Array
from rotor_analysis.rotor import require

ZONES = {"A": 3.0, "B": 4.0, "C": 5.0, "D": np.inf}  # each with its upper limit
POINTS = 2000  # of the computed curve
COMPARED = 500.0  # Hz, up to which computed and measured are held against each other


def zone(peak: float) -> str:
    """Zone of a peak of |S|: A below 3, B below 4, C below 5, D from there."""
    return next(name for name, limit in ZONES.items() if peak < limit)


def sensitivity(speed: str, amplifier: bool, delay: bool, sample_time: str, settings: tuple[str, ...]) -> Outcome:
    """|S| of each axis over frequency, its peak and zone, computed and measured."""
    time = quantity(sample_time, "s", "sample-time")
    require(0.0 < time < 0.5 / LOWEST, "sample-time", f"{time:g} s", f"> 0 s and < {0.5 / LOWEST:g} s")
    prepared = prepared_loop(spin_speed(speed), time, amplifier, delay, list(settings))
    loop = loop_of(prepared)
    system = sensitivity_of(loop)
    poles = system.poles()
    measured = measure(prepared, float(np.abs(poles).max()))
    frequencies = curve_frequencies(poles, time)
    curves = np.abs(response(system, frequencies))
    expected = np.array([response(system, row)[k] for k, row in enumerate(measured.frequencies)])
    difference = np.abs(measured.sensitivity / expected - 1.0)
    data: dict[str, Any] = {
        "speed_rad_s": loop.Omega,
        "sample_time_s": loop.sample_time,
        "delay_samples": loop.delay,
        "amplifier": "dynamic" if loop.parameters["amb_actuator"]["amplifier"] else "ideal",
        "settings": list(settings),
        "zone_limits": {name: limit for name, limit in ZONES.items() if np.isfinite(limit)},
        "frequencies_hz": frequencies.tolist(),
        "axes": {
            name: {
                "peak": float(curve.max()),
                "peak_frequency_hz": float(frequencies[curve.argmax()]),
                "zone": zone(float(curve.max())),
                "computed": curve.tolist(),
                "measured_frequencies_hz": measured.frequencies[k].tolist(),
                "measured": np.abs(measured.sensitivity[k]).tolist(),
                "largest_difference_below_500_hz": float(difference[k][measured.frequencies[k] < COMPARED].max()),
                "largest_difference": float(difference[k].max()),
            }
            for k, (name, curve) in enumerate(zip(AXIS_NAMES, curves, strict=True))
        },
    }
    return Outcome(data, {"sensitivity": partial(loop_figures.sensitivity, data)}, as_text(data))


def curve_frequencies(poles: Array, sample_time: float) -> Array:
    """Frequencies (Hz) of the computed curve: evenly on a logarithmic axis, and those of the poles, where peaks are."""
    highest = min(HIGHEST, 0.5 / sample_time)
    rings = np.asarray(pole_frequency(poles, sample_time))
    own = rings[(rings >= LOWEST) & (rings <= highest)]
    return np.unique(np.concatenate([np.geomspace(LOWEST, highest, POINTS), own]))


def as_text(data: dict[str, Any]) -> list[Table | str]:
    """What `sensitivity` found, to print."""
    headings = ("peak of |S|", "at (Hz)", "zone", "measured differs below 500 Hz (%)", "anywhere (%)")
    table = labelled_table(f"Sensitivity at {data['speed_rad_s']:g} rad/s", "axis", *headings)
    for name, axis in data["axes"].items():
        differences = (100.0 * axis[key] for key in ("largest_difference_below_500_hz", "largest_difference"))
        table.add_row(
            name,
            f"{axis['peak']:.3f}",
            f"{axis['peak_frequency_hz']:.1f}",
            axis["zone"],
            *(f"{difference:.3f}" for difference in differences),
        )
    worst = max(axis["peak"] for axis in data["axes"].values())
    return [table, f"zone {zone(worst)} (ISO 14839-3: A below 3, B below 4, C below 5)"]
