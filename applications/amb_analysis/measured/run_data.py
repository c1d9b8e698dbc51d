"""Measured data from the result of a run of this project."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from amb_analysis.measured.records import TimeRecord
from amb_analysis.measured.units import even_step, si_channel
from amb_cosim.cosim.record.signals import AT_STEPS
from amb_cosim.cosim.run.dataset import load


def read_run(path: Path) -> TimeRecord:
    """Return the record of `result.nc` or its folder: each channel `component.variable` whose unit is in `units.SI`.

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
    signals = {}
    for name, variable in dataset.data_vars.items():
        if str(name).endswith(AT_STEPS) or variable.dims != ("time",):
            continue
        try:
            factor, channel = si_channel(str(name), str(variable.attrs.get("units", "1")))
        except ValueError:
            continue  # a unit of no channel: an angle, a torque, an energy
        signals[channel] = factor * np.asarray(variable.values, np.float64)
    return TimeRecord(even_step(np.asarray(dataset["time"].values, np.float64)), signals)
