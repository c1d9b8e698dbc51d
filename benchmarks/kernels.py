"""Compile the step kernels of the native FMUs into libraries that return their addresses."""

from __future__ import annotations

import ctypes
import tempfile
from functools import cache
from pathlib import Path

from amb_cosim.cosim.fmu.fmus import FmuSource, model_source
from fmi_export.building.native.compiler import PLATFORMS, compile_library, host_platform
from fmi_export.building.native.engines import engine_sources

EXPORT_SOURCE = """
#ifdef _WIN32
#define EXPORTED __declspec(dllexport)
#else
#define EXPORTED __attribute__((visibility("default")))
#endif
int %s_step(void);
EXPORTED void *step_address(void) { return (void *)%s_step; }
"""


@cache
def step_kernel(source: FmuSource) -> int:
    """Return the address of the machine code that the native FMU of a model runs in a step.

    The library is compiled like the FMU's, with one more function that returns this address. It stays loaded.

    Raises
    ------
    ValueError
        If the C compiler is missing.
    """
    model = model_source(source)[0]
    name = model.name
    sources = engine_sources([model]) | {"export.c": EXPORT_SOURCE % (name, name)}
    platform = host_platform()
    library = compile_library(name, sources, platform)
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        path = Path(folder) / f"{name}{PLATFORMS[platform][0]}"
        path.write_bytes(library)
        address = ctypes.CDLL(str(path)).step_address
    address.restype = ctypes.c_void_p
    return int(address())
