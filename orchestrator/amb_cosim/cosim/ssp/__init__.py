"""System Structure and Parameterization: a prepared run as an archive (1.0), and archives (1.0, 2.0) as systems.

    export_ssp   write a prepared run: FMUs, wiring, parameters, default experiment
    load_ssp     read an archive, of this package or of another tool, as a system and an experiment

Modelica Association, System Structure and Parameterization, version 1.0, 2019.
"""

from amb_cosim.cosim.ssp.archive import export_ssp
from amb_cosim.cosim.ssp.reader import load_ssp

__all__ = ["export_ssp", "load_ssp"]
