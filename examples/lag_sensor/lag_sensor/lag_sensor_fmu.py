"""Entry point of the lag_sensor FMU, loaded by pythonfmu."""

import amb_cosim_bootstrap

amb_cosim_bootstrap.choose_code(globals())

from fmi_export.slave import ModelSlave  # noqa: E402
from lag_sensor.model import MODEL  # noqa: E402


class LagSensor(ModelSlave):
    """The sensors as an FMI slave."""

    model = MODEL
