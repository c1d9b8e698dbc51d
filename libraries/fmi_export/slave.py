"""Lets PythonFMU call the kernels of any model for the guard, which is the slave that hosts see.

The guard owns the arrays of the instance and checks them before and after each call. Kernels work on these arrays in
place.

No method may raise an exception, because PythonFMU would then corrupt reference counts, and the guard would no longer
call it. Instead, errors are logged, and the guard reports the logged text as the reason for the failure.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable
from ctypes import c_double
from pathlib import Path
from typing import Any

import numpy as np
from pythonfmu import Fmi2Slave
from pythonfmu.enums import Fmi2Status

from fmi_export.log_categories import LOG_CATEGORIES
from fmi_export.model import Array
from fmi_export.model_kernels import compile_model


class ModelSlave(Fmi2Slave):  # type: ignore[misc]
    """Base class of the FMUs' entry points; a subclass sets `model` to a `Model` or to the module with the kernels.

    In an assembly, the guard creates one slave for each part; the name of the instance is the name of the part.
    """

    model: Any
    log_categories = LOG_CATEGORIES

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        import amb_cosim_bootstrap  # beside the script that runs this

        resources = Path(self.resources)
        build = amb_cosim_bootstrap.build_facts(resources)
        amb_cosim_bootstrap.refuse_other_code(build)
        self.modelName = build["model"]
        self.arrays: list[Array] = [np.load(resources / "constants.npy")]
        if self.instance_name in build["parts"]:
            module, first, stop = build["parts"][self.instance_name]
            self.model, self.arrays = importlib.import_module(module), [self.arrays[0][first:stop]]

    def set_string(self, vrs: list[int], values: list[str]) -> None:
        """Receive from the guard the addresses and sizes of the arrays that follow the constants, in order."""
        numbers = [int(number) for number in values[0].split()]
        places = zip(numbers[::2], numbers[1::2], strict=True)
        self.arrays += [np.ctypeslib.as_array((c_double * size).from_address(address)) for address, size in places]

    def enter_initialization_mode(self) -> None:
        compile_model(self.model.initialise, self.model.step)
        self._call(self.model.initialise)

    def do_step(self, current_time: float, step_size: float) -> bool:
        self._call(self.model.step, current_time, step_size)
        return True

    def _call(self, kernel: Callable[..., int], *times: float) -> None:
        """Call a kernel, and store its fault in the last output."""
        try:
            self.arrays[-1][-1] = kernel(*self.arrays, *times)
        except Exception as error:
            self.log(str(error) or repr(error), Fmi2Status.error)
