"""Lets PythonFMU's binary end in the right order when the process exits.

The binary keeps a static shared pointer to its interpreter state. At exit the C library runs static destructors
first and a library's finaliser last; the finaliser then releases the pointer that was destroyed already, and
takes one from what is by now a link of the heap's free list. On a `dlclose` the order is the other way round and
right, but the binary holds unique symbols, so glibc never unloads it.
"""

from __future__ import annotations

import ctypes
import os
import sys
from functools import cache
from pathlib import Path


@cache
def release_before_static_destructors(binary: Path) -> bool:
    """Register the finaliser of a loaded PythonFMU binary as an exit handler; whether that was possible.

    Exit handlers run last in, first out, so it runs ahead of the static destructors, which were registered when
    the binary was loaded. It clears the pointer; its later run and the destructor then find nothing to release.

    Parameters
    ----------
    binary
        The shared library of an FMU, as the host loaded it.
    """
    if sys.platform != "linux":
        return False
    try:
        # A handle of ctypes is never closed, so the handler cannot outlive the code it calls.
        finaliser = ctypes.CDLL(str(binary), mode=os.RTLD_NOLOAD).finalizePythonInterpreter
        register = ctypes.CDLL(None)["__cxa_atexit"]
    except (OSError, AttributeError):  # loaded from elsewhere, or another version of PythonFMU
        return False
    register.argtypes = [ctypes.c_void_p] * 3
    return bool(register(ctypes.cast(finaliser, ctypes.c_void_p), None, None) == 0)
