"""Entry point of the rotor_contact FMU, loaded by pythonfmu."""

import amb_cosim_bootstrap

amb_cosim_bootstrap.choose_code(globals())

from typing import Any

from fmi_export.model import Model
from fmi_export.slave import ModelSlave
from rotor_contact.planes import planes_from
from rotor_contact.plant import model_for


class RotorContact(ModelSlave):
    """The plant as an FMI slave."""

    @classmethod
    def model_of(cls, layout: dict[str, Any]) -> Model:
        return model_for(planes_from(layout))
