"""Entry point of the probe_lag FMU."""

import amb_cosim_bootstrap

amb_cosim_bootstrap.choose_code(globals())

from fmi_export.slave import ModelSlave  # noqa: E402
from probe_lag.lag import MODEL  # noqa: E402


class ProbeLag(ModelSlave):
    """The lag as an FMI slave."""

    model = MODEL
