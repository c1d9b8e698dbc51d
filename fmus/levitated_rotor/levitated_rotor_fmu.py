"""Entry point of FMUs of assemblies, loaded by pythonfmu."""

import amb_cosim_bootstrap

amb_cosim_bootstrap.choose_code(globals())

from fmi_export.slave import ModelSlave


class LevitatedRotor(ModelSlave):
    """A part of an assembly as an FMI slave."""
