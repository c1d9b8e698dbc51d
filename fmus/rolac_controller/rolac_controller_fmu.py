"""Entry point of the rolac_controller FMU, loaded by pythonfmu."""

import amb_cosim_bootstrap

amb_cosim_bootstrap.choose_code(globals())

from typing import Any

from fmi_export.model import Model
from fmi_export.slave import ModelSlave
from rolac_controller.control_loop import control_loop_from
from rolac_controller.controller import model_for


class RolacController(ModelSlave):
    """The controller as an FMI slave."""

    @classmethod
    def model_of(cls, layout: dict[str, Any]) -> Model:
        return model_for(control_loop_from(layout))
