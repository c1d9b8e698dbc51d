"""Views of constants, parameters, inputs, outputs and state, with which kernels read the axes as arrays of records."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from amb_actuator.eddy_currents import N_POLES
from amb_actuator.interface import SMALLEST
from fmi_export.jit import views
from fmi_export.model import Array
from fmi_export.parts import part
from fmi_export.records import record, size_of

Records = np.ndarray[tuple[int], np.dtype[np.record]]

SIZES = record(("n_axes", "f8"))  # the only constant
PARAMETERS = SMALLEST.common_record("parameter")
AXIS, AXIS_INPUTS, AXIS_OUTPUTS = (SMALLEST.element_record(kind, "axes") for kind in ("parameter", "input", "output"))
IRON = SMALLEST.element_record("parameter", "iron")
# Deviations of the coil currents of an axis from the operating point (A), see `Coils`.
DEVIATIONS = record(("upper", "f8"), ("lower", "f8"))

# Displacement of an axis with eddy currents at the previous step (m).
MOTION = record(("previous", "f8"))
LAGGED = np.dtype(np.float64)

N_PARAMETERS, N_DEVIATIONS, N_AXIS = size_of(PARAMETERS), size_of(DEVIATIONS), size_of(AXIS)
N_MOTION = size_of(MOTION)
N_IRON_STATE = N_MOTION + 2 * N_POLES


class Axes(NamedTuple):
    """The arrays of an actuator: `common` holds one record `PARAMETERS`; most others hold one record per axis.

    parameters, inputs, outputs, deviations
        Records `AXIS`, `AXIS_INPUTS`, `AXIS_OUTPUTS` and `DEVIATIONS`.
    iron, motion, lags
        Data of the last axis if it belongs to a thrust magnet, otherwise empty: records `IRON` and `MOTION`, and the
        lags of its coil pairs (A), shape (1 or 0, 2, N_POLES).
    """

    common: Records
    parameters: Records
    inputs: Records
    deviations: Records
    outputs: Records
    iron: Records
    motion: Records
    lags: Array


@views
def n_axes_of(constants: Array) -> int:
    """Return the number of axes: two for each bearing, and one for a thrust magnet."""
    return int(part(constants, 0, SIZES, 1)[0].n_axes)


@views
def views_of(constants: Array, parameters: Array, inputs: Array, state: Array, outputs: Array) -> Axes:
    """Return views into the arrays of an actuator with these constants."""
    n = n_axes_of(constants)
    n_thrust, after_deviations = n % 2, n * N_DEVIATIONS
    return Axes(
        part(parameters, 0, PARAMETERS, 1),
        part(parameters, N_PARAMETERS, AXIS, n),
        part(inputs, 0, AXIS_INPUTS, n),
        part(state, 0, DEVIATIONS, n),
        part(outputs, 0, AXIS_OUTPUTS, n),
        part(parameters, N_PARAMETERS + n * N_AXIS, IRON, n_thrust),
        part(state, after_deviations, MOTION, n_thrust),
        part(state, after_deviations + n_thrust * N_MOTION, LAGGED, (n_thrust, 2, N_POLES)),
    )
