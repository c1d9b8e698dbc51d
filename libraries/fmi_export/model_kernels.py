"""Compiles the two kernels of a model in a separate process, each once with everything that it calls.

When Python calls a kernel, numba compiles each function below it for itself and once more into every function that
calls it. A plant has hundreds of kernels, so this takes several times as long as compiling the two that Python calls.
Numba then loads them from its cache on disk.
"""

from __future__ import annotations

import importlib
import json
import os
import subprocess
import sys
import warnings
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

from fmi_export.compiling import collect_garbage_rarely, compiling, import_path
from fmi_export.jit import COMPILED


def compile_model(initialise: Callable[..., int], step: Callable[..., int]) -> None:
    """Compile the kernels of a model into numba's cache on disk, unless it contains them.

    Without numba, without a cache, or in a host whose executable is not Python, nothing is done, and numba compiles the
    kernels when they are called.

    Parameters
    ----------
    initialise, step
        The two kernels, as in `fmi_export.model.Model`.
    """
    if not COMPILED or not Path(sys.executable or "").name.startswith("python"):
        return
    from fmi_export.numba_internals import folder_of_cache, is_in_cache

    kernels: list[Any] = [initialise, step]
    folders = [folder_of_cache(kernel) for kernel in kernels]

    def are_compiled() -> bool:
        return all(map(is_in_cache, kernels, _signatures()))

    if None in folders or are_compiled():
        return
    places = [(kernel.py_func.__module__, kernel.py_func.__qualname__) for kernel in kernels]
    (module, _) = places[-1]
    with suppress(OSError), compiling(Path(str(folders[-1]), f"{module}.model"), f"the machine code of {module}"):
        if not are_compiled():
            subprocess.run(
                [sys.executable, "-P", "-m", __name__, json.dumps(places)],
                env={**os.environ, "PYTHONPATH": import_path()},
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,  # numba shows an error again when Python calls the kernel
                check=False,
            )


@cache
def _signatures() -> list[tuple[Any, ...]]:
    """Return the types of the arguments of the two kernels: constants to outputs, and for a step also two times."""
    from numba import float64

    arrays = (float64[::1],) * 6
    return [arrays, (*arrays, float64, float64)]


# In the subprocess ------------------------------------------------------------------------------------------------


def main() -> None:
    """Compile the kernels whose modules and names the first argument states."""
    from fmi_export.numba_internals import compile_entries, type_calls_once

    collect_garbage_rarely()
    warnings.simplefilter("ignore")  # numba's checks of code that is inlined more than once
    places = [tuple(place) for place in json.loads(sys.argv[1])]
    compile_entries({".".join(place) for place in places})
    type_calls_once()
    kernels: list[Any] = [getattr(importlib.import_module(module), name) for module, name in places]
    for kernel, signature in zip(kernels, _signatures(), strict=True):
        kernel.compile(signature)


if __name__ == "__main__":
    main()
