"""A running actuator with values given by name, `mb1__i_x` for `mb1.i_x`."""

from __future__ import annotations

from collections.abc import Mapping

from rig import ACTUATOR, ACTUATOR_CONSTANTS

from fmi_export.model import Instance


def running_actuator(values: Mapping[str, float] | None = None, **more: float) -> Instance:
    """Return an initialised actuator with these parameters and inputs."""
    made = Instance(ACTUATOR, ACTUATOR_CONSTANTS)
    for name, value in {**(values or {}), **{n.replace("__", "."): v for n, v in more.items()}}.items():
        made[name] = value
    made.initialise()
    return made
