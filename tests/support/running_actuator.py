"""A running actuator with values given by name, `mb1__i_x` for `mb1.i_x`."""

import math
from collections.abc import Mapping

from instances import initialised
from rig import ACTUATOR, ACTUATOR_CONSTANTS

from fmi_export.model import Instance

K = 4e-7 * math.pi * 158**2 * 1399e-6 * math.cos(math.radians(22.5)) / 1.2e-3**2  # N/A^2, pull at the centre
F_0 = K * (5.57**2 - 4.43**2)  # N, static load


def running_actuator(values: Mapping[str, float] | None = None, **more: float) -> Instance:
    """Return an initialised actuator with these parameters and inputs."""
    named = {name.replace("__", "."): value for name, value in more.items()}
    return initialised(ACTUATOR, ACTUATOR_CONSTANTS, {**(values or {}), **named})
