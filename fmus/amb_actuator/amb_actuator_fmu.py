"""Entry point of the amb_actuator FMU, loaded by pythonfmu."""

import amb_cosim_bootstrap

amb_cosim_bootstrap.choose_code(globals())

from typing import Any

from amb_actuator.actuator import model_for
from fmi_export.model import Model
from fmi_export.slave import ModelSlave


class AmbActuator(ModelSlave):
    """The actuator as an FMI slave."""

    @classmethod
    def model_of(cls, layout: dict[str, Any]) -> Model:
        return model_for(layout["bearings"])
