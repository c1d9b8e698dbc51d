"""The step kernels of the native FMUs, callable by their addresses."""

from __future__ import annotations

import ctypes
import tempfile
from functools import cache
from pathlib import Path

from amb_cosim.cosim.fmus import model_source
from fmi_export.building.native.compiler import PLATFORMS, compile_library, host_platform
from fmi_export.building.native.package import native_sources

SHOWN = """
#ifdef _WIN32
#define SHOWN __declspec(dllexport)
#else
#define SHOWN __attribute__((visibility("default")))
#endif
int kernel_step(void);
SHOWN void *address_of_the_step(void) { return (void *)kernel_step; }
"""


@cache
def step_kernel(name: str) -> int:
    """Address of the machine code that the native FMU of a model runs in a step, `kernel_step` in `lowering`.

    The library is compiled as the FMU's is, but tells where this function is. It stays loaded.

    Raises
    ------
    ValueError
        If there is no compiler.
    """
    sources = native_sources(*model_source(name)) | {"shown.c": SHOWN}
    platform = host_platform()
    library = compile_library(name, sources, platform)
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        path = Path(folder) / f"{name}{PLATFORMS[platform][0]}"
        path.write_bytes(library)
        address = ctypes.CDLL(str(path)).address_of_the_step
    address.restype = ctypes.c_void_p
    return int(address())
