"""Variable table of the controller, derived from the bearings and sensor planes of its loop."""

from __future__ import annotations

from fmi_export.interface import Interface, interface
from rolac_controller.control_loop import ControlLoop, SensorPlane
from rolac_controller.parameters import parameter_variables
from rolac_controller.signals import input_variables, output_variables


def interface_of(loop: ControlLoop) -> Interface:
    """Return the variables of a controller of this loop."""
    return interface(parameter_variables(loop), input_variables(loop), output_variables(loop))


# A single element of each, for the record types of the parts.
SMALLEST = interface_of(ControlLoop(("b",), (SensorPlane("p", "p.x", "p.y", 0.0),), ("p",))).with_all_parts()
