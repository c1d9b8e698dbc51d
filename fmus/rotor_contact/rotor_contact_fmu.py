"""Entry point of the rotor_contact FMU, loaded by pythonfmu."""

import amb_cosim_bootstrap

amb_cosim_bootstrap.choose_code(globals())

from fmi_export.slave import ModelSlave
from rotor_contact import plant


class RotorContact(ModelSlave):
    """The plant as an FMI slave."""

    model = plant
