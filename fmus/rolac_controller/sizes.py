"""Sizes of a controller, stored in its constants: bearings, sensors, and the sensor that closes each axis's loop."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from fmi_export.jit import views
from fmi_export.model import Array
from fmi_export.parts import part
from fmi_export.records import record, size_of

Records = np.ndarray[tuple[int], np.dtype[np.record]]

# The constants begin with this record and the numbers of the sensors that close the loops of the axes. Tables of the
# inner loop and of the receptances that the FMU was built with follow, whose rows have keys.
SIZES = record(("n_bearings", "f8"), ("n_planes", "f8"))
KEY = record(("order", "f8"), ("speed", "f8"))  # of the harmonic, and of the rotor (rad/s)
N_SIZES, N_KEY = size_of(SIZES), size_of(KEY)


class Sizes(NamedTuple):
    """Numbers of axes (two per bearing) and of sensors (two per plane)."""

    n_axes: int
    n_sensors: int


@views
def sizes_of(constants: Array) -> Sizes:
    """Return the numbers of axes and sensors of a controller with these constants."""
    head = part(constants, 0, SIZES, 1)[0]
    return Sizes(2 * int(head.n_bearings), 2 * int(head.n_planes))
