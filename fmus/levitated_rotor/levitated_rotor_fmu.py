"""Entry point of the levitated_rotor FMU, loaded by pythonfmu."""

import amb_cosim_bootstrap

amb_cosim_bootstrap.choose_code(globals())

from typing import Any

from fmi_export.model import Model
from fmi_export.slave import ModelSlave
from levitated_rotor.model import model_from


class LevitatedRotor(ModelSlave):
    """The assembly as an FMI slave."""

    @classmethod
    def model_of(cls, layout: dict[str, Any]) -> Model:
        return model_from(layout)
