"""Entry point of the linear_controller FMU, loaded by pythonfmu."""

import amb_cosim_bootstrap

amb_cosim_bootstrap.choose_code(globals())

from fmi_export.slave import ModelSlave
from linear_controller import controller


class LinearControllerSlave(ModelSlave):
    """The controller as an FMI slave."""

    model = controller
