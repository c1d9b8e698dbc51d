"""The passive parts of the bearings; `interface` declares their coefficients.

    f = -(k_b q + c_b q'),   q = (x, y) of the shaft there, f the force on the shaft    (1)

The bearings store k_b |q|^2/2 and dissipate c_b |q'|^2.
"""

from __future__ import annotations

import math

import numpy as np

from fmi_export.flat import is_near
from fmi_export.jit import kernel, views
from fmi_export.model import Array
from fmi_export.records import record, size_of

# A magnetic bearing during a step: row of its x, passive stiffness (N/m) and damping (N s/m), and the gradients (N/m)
# of its force in x and y.
BEARING = record(("row", np.int64), ("k_b", np.float64), ("c_b", np.float64), ("gradient", np.float64, (2,)))
N_BEARING = size_of(BEARING)
RESOLUTION = 1.0  # of the fastest time constant of the bearings; a substep is no longer
Bearings = np.ndarray[tuple[int], np.dtype[np.record]]


@views
def bearings_size(count: int) -> int:
    """Return how many float64 values `count` bearings occupy in an array; the number is even."""
    return (count * N_BEARING + 1) // 2 * 2


@kernel
def set_passive(bearing: np.record, source: np.record) -> None:
    """Copy a bearing's coefficients from another bearing or from parameters, and set its magnet's gradients to zero."""
    bearing.k_b = source.k_b
    bearing.c_b = source.c_b
    bearing.gradient[0] = bearing.gradient[1] = 0.0


@kernel
def same_passive(bearing: np.record, reference: np.record, tolerance: float) -> bool:
    """Return whether coefficients equal those of a reference bearing within the relative `tolerance`."""
    return is_near(bearing.k_b, reference.k_b, tolerance) and is_near(bearing.c_b, reference.c_b, tolerance)


@kernel
def is_damping(bearing: np.record) -> bool:
    """Return whether a bearing dissipates energy."""
    return bool(bearing.c_b != 0.0)


@kernel
def add_bearings(Minv: Array, bearings: Bearings, magnets: float, K: Array, C: Array) -> None:
    """Add bearings (1), and `magnets` times the gradients of their magnets, to the columns of M^-1 K and M^-1 C."""
    for bearing in bearings:
        for axis in range(2):
            row = bearing.row + axis
            stiffness = bearing.k_b - magnets * bearing.gradient[axis]
            for i in range(Minv.shape[0]):
                K[row, i] += Minv[i, row] * stiffness
                C[row, i] += Minv[i, row] * bearing.c_b


@kernel
def passive_limit(Minv: Array, bearings: Bearings, longest: float) -> float:
    """Return a substep length (s), at most `longest`, that resolves the motion of the adjacent mass on each bearing."""
    fastest = 0.0
    for bearing in bearings:
        mobility = Minv[bearing.row, bearing.row]
        fastest += math.sqrt(mobility * abs(bearing.k_b)) + mobility * abs(bearing.c_b)
    return RESOLUTION / fastest if fastest * longest > RESOLUTION else longest


@kernel
def heat_per_second(bearing: np.record, v_x: float, v_y: float) -> float:
    """Return the dissipation of a bearing at a velocity (m/s): c_b |v|^2 (W)."""
    heat: float = bearing.c_b * (v_x * v_x + v_y * v_y)
    return heat


@kernel
def stored_in_bearing(parameters: np.record, x: float, y: float) -> float:
    """Return the strain energy (J) of a bearing from its parameters when the shaft is at x and y (m) there."""
    energy: float = 0.5 * parameters.k_b * (x * x + y * y)
    return energy
