"""Compiles the kernels of a model into numba's cache on disk: `compile_kernels.py MODEL [MODULE.KERNEL ...]`.

It compiles the two kernels of the model and the named ones, which Python calls as well. To compile the kernels that
only other kernels call would take as long again.
"""

import os
import shutil
import sys
import warnings
from pathlib import Path

from fmi_export.numba_internals import compile_entries, type_calls_once

VERSIONS = 40  # of the code of models, whose kernels stay in the cache of the tests
STEPPED = {"rotor_contact": "plant", "amb_actuator": "actuator"}  # modules of others are named `controller`


name, *called = sys.argv[1:]
own = [f"{name}.{STEPPED.get(name, 'controller')}.{kernel}" for kernel in ("initialise", "step")]
compile_entries({"fmi_export.model.first_outside", "rolac_controller.enumerations.last_stages", *own, *called})
if folder := os.environ.get("NUMBA_CACHE_DIR"):
    for outdated in sorted(Path(folder).glob("kernels-*"), key=os.path.getmtime)[:-VERSIONS]:
        shutil.rmtree(outdated, ignore_errors=True)
type_calls_once()  # as for native FMUs: a quarter less to do, for the same machine code
warnings.simplefilter("ignore")  # numba's own checks of what is inlined more than once

import fmi_export.model  # noqa: E402
from amb_cosim import linear_controller  # noqa: E402
from amb_cosim.cosim.fmu.fmus import model_source  # noqa: E402

fmi_export.model.compile_model = lambda *_: None  # this process compiles more than the two kernels of a model
law = linear_controller(1.0, ["y"], ["u"], 1e-3) if name == "linear_controller" else None  # made from a file
instance = fmi_export.model.Instance(*(law.model_and_constants if law else model_source(name)))
instance.initialise()
instance.step(0.0, 250e-6)  # numba keeps what it compiles for these
