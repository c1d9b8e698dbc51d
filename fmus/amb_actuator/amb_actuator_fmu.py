"""Entry point of the amb_actuator FMU, loaded by pythonfmu."""

import amb_cosim_bootstrap

amb_cosim_bootstrap.choose_code(globals())

from amb_actuator import actuator
from fmi_export.slave import ModelSlave


class AmbActuator(ModelSlave):
    """The actuator as an FMI slave."""

    model = actuator
