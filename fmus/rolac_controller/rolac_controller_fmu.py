"""Entry point of the rolac_controller FMU, loaded by pythonfmu."""

import amb_cosim_bootstrap

amb_cosim_bootstrap.choose_code(globals())

from fmi_export.slave import ModelSlave
from rolac_controller import controller


class RolacController(ModelSlave):
    """The controller as an FMI slave."""

    model = controller
