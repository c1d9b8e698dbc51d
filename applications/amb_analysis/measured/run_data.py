"""Measured data from the result of a run of this project."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np

from amb_analysis.measured.records import TimeRecord
from amb_analysis.measured.units import even_step, si_channel
from amb_cosim.cosim.record.signals import AT_STEPS, Signals, variables_of
from amb_cosim.cosim.run.dataset import load
from amb_cosim.results.signal_arrays import at_every_step
from amb_cosim.results.thinned import even_samples, folding


def read_run(path: Path, needed: Iterable[str] = ()) -> TimeRecord:
    """Return the record of `result.nc` or its folder: each channel `component.variable` whose unit is in `units.SI`.

    A thinned record has displacements, and inputs that vary, at every step. Its record is that of every step if this
    contains the `needed` channels; otherwise, it is that of the samples, with a warning.

    Raises
    ------
    ValueError
        If the result cannot be read, or its samples are not evenly spaced.
    """
    file = path / "result.nc" if path.is_dir() else path
    try:
        dataset = load(file)
    except Exception as error:  # HDF5 and its readers each raise other types
        raise ValueError(f"it cannot be read as the result of a run: {error or type(error).__name__}") from error
    recorded: Signals = at_every_step(dataset)
    if any(name in dataset and name not in recorded for name in needed):
        recorded = dataset
    time, signals = np.asarray(recorded["time"].values, np.float64), {}
    even = slice(even_samples(time))
    for name in variables_of(recorded):
        if name.endswith(AT_STEPS):
            continue
        try:
            factor, channel = si_channel(name, str(recorded[name].attrs.get("units", "1")))
        except ValueError:
            continue  # a unit of no channel: an angle, a torque, an energy
        signals[channel] = factor * np.asarray(recorded[name].values[even], np.float64)
    return TimeRecord(even_step(time[even]), signals, warning=folding(recorded))
