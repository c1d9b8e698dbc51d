"""The variable table of the controller, and the records through which kernels see its arrays."""

from __future__ import annotations

from fmi_export.variables import interface
from rolac_controller.parameters import PARAMETER_VARIABLES
from rolac_controller.signals import INPUT_VARIABLES, OUTPUT_VARIABLES

INTERFACE = interface(PARAMETER_VARIABLES, INPUT_VARIABLES, OUTPUT_VARIABLES)
PARAMETERS, INPUTS, OUTPUTS = INTERFACE.records

HARMONIC = PARAMETERS["harmonics"].base  # order and power of one harmonic
GAINS = PARAMETERS["axes"].base  # of the PID of one axis
