"""Compiles the kernels of a model into numba's cache on disk: `compile_kernels.py FOLDER MODEL`.

A file in the folder, named after the model, says that they are compiled, or that they cannot be: the tests of the model
show what is wrong with it.
"""

import sys
import warnings
from contextlib import suppress
from pathlib import Path

from amb_cosim import linear_controller
from amb_cosim.cosim.fmus import model_source
from fmi_export.model import Instance
from fmi_export.numba_internals import type_calls_once

folder, name = sys.argv[1:]
type_calls_once()  # as for native FMUs: a quarter less to do, for the same machine code
warnings.simplefilter("ignore")  # numba's own checks of what is inlined more than once
with suppress(Exception):
    law = linear_controller(1.0, ["y"], ["u"], 1e-3) if name == "linear_controller" else None  # made from a file
    instance = Instance(*(law.model_and_constants if law else model_source(name)))
    instance.initialise()
    instance.step(0.0, 250e-6)  # numba keeps what it compiles for these
Path(folder, name).touch()
