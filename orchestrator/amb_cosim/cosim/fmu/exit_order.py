"""Runs the finaliser of PythonFMU's binary in the right order when the process exits.

This module is for FMUs of other tools; FMUs of this project contain a guard that does the same.

The binary keeps a static shared pointer to its interpreter state. At exit, the C library runs static destructors first
and a library's finaliser last. The finaliser then releases a pointer that has already been destroyed. It decrements a
counter in freed memory, which now holds a link of the heap's free list. With `dlclose`, the order would be correct, but
the binary has unique symbols, so glibc never unloads it.
"""

from __future__ import annotations

import ctypes
import os
import sys
from functools import cache
from pathlib import Path


@cache
def release_before_static_destructors(binary: Path) -> bool:
    """Register the finaliser of a loaded PythonFMU binary as an exit handler; return whether that was possible.

    Exit handlers run last in, first out, so this one runs before the static destructors, which were registered when the
    binary was loaded. It clears the pointer, so that the regular finaliser and the destructor find nothing to release.

    Parameters
    ----------
    binary
        Path of the FMU's shared library, as the host loaded it.
    """
    if sys.platform != "linux":
        return False
    try:
        # A handle of ctypes is never closed, so the handler cannot outlive the code it calls.
        finaliser = ctypes.CDLL(str(binary), mode=os.RTLD_NOLOAD).finalizePythonInterpreter
        register = ctypes.CDLL(None)["__cxa_atexit"]
    except (OSError, AttributeError):  # loaded from another path, or by another version of PythonFMU
        return False
    register.argtypes = [ctypes.c_void_p] * 3
    return bool(register(ctypes.cast(finaliser, ctypes.c_void_p), None, None) == 0)
