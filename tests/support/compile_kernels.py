"""Compiles kernels into numba's cache on disk: `compile_kernels.py FOLDER MODEL ...`.

A file in the folder, named after the model, says that its kernels are compiled, or that they cannot be: the tests of
the model show what is wrong with it.
"""

import sys
from contextlib import suppress
from pathlib import Path

from amb_cosim.cosim.fmus import model_source
from fmi_export.model import Instance


def compile_kernels(name: str) -> None:
    """Step a model once; numba keeps what it compiles for that."""
    instance = Instance(*model_source(name))
    instance.initialise()
    instance.step(0.0, 250e-6)


folder, *names = sys.argv[1:]
for name in names:
    with suppress(Exception):
        compile_kernels(name)
    Path(folder, name).touch()
