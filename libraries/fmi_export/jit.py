"""Decorators for model kernels, which are compiled if numba is installed, and run as plain Python otherwise."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any, TypeVar, cast

from fmi_export.amb_cosim_bootstrap import digest, find

F = TypeVar("F", bound=Callable[..., Any])

try:
    import numba
    import numba.extending

    from fmi_export.numba_internals import KERNEL_OPTIONS, cache_soundly, compile_once, keep_stores, user_cache

    keep_stores()
    COMPILED = not cast(Any, numba.config).DISABLE_JIT
except ImportError:  # the kernels are also ordinary Python, but slower
    COMPILED = False


def kernel(function: F) -> F:
    """Compile `function` in numba's nopython mode, with IEEE division and, if the disk is writable, an on-disk cache.

    A kernel takes flat float64 arrays and scalars, allocates nothing and raises nothing, because the same source is
    later compiled into FMUs without Python. It is compiled without numba's run-time system (`_nrt`). Allocating is
    therefore a compilation error, and no time is spent on counting references to arrays, which would otherwise take
    most of the time.
    """
    return _compiled(function)


def inlined_kernel(function: F) -> F:
    """Compile `function` as `kernel` does, and inline it into each caller.

    A call copies the descriptors of its array arguments, seven or nine numbers each, which takes longer than a short
    kernel.
    """
    return _compiled(function, forceinline=True)


def noinline_kernel(function: F) -> F:
    """Compile `function` as `kernel` does, but do not inline it into its callers in native FMUs.

    Use this for code that runs in few steps. If such code were inlined, the other code would have fewer registers and
    worse locality.
    """
    KERNELS_APART.add((*function.__module__.split("."), *function.__qualname__.split(".")))
    return _compiled(function)


KERNELS_APART: set[tuple[str, ...]] = set()
PACKAGES = "PACKAGES"  # of a package: the names of all packages whose code its kernels need


def _compiled(function: F, **options: bool) -> F:
    if not COMPILED:
        return function
    # By default, numba compiles a function that an inlined one calls a second time, and inlines that copy everywhere.
    settings: dict[str, Any] = {"error_model": "numpy", "forceinline": False, **KERNEL_OPTIONS, **options}
    folder = _cache_folder(function.__module__.split(".")[0], cast(Any, numba.config).CACHE_DIR)
    if folder is not None:
        with suppress(RuntimeError):  # numba finds no place for a cache of its own
            return cast(F, compile_once(cache_soundly(numba.njit(cache=True, **settings)(function), folder)))
    return cast(F, numba.njit(**settings)(function))


def views(function: F) -> F:
    """Let kernels call `function`, which returns views into its arguments; calls from Python run it as plain Python.

    The decorator also suits formulas that both kernels and Python code evaluate. The function is inlined into the
    machine code of its callers. Numba's own inlining is not used, because it infers the types at every call; for the
    plant, this takes two fifths of the compile time. In contrast, a kernel cannot return a view to Python, because the
    kernel does not own the memory of the view.
    """
    return numba.extending.register_jitable(forceinline=True, **KERNEL_OPTIONS)(function) if COMPILED else function


@cache
def _cache_folder(package: str, base: str) -> Path | None:
    """Return a folder for machine code whose name depends on all the code that a kernel may call, or None.

    numba detects changes in the file of a function, but not in other files whose functions it calls. Without such a
    folder, numba would continue to run old machine code after an upgrade. A package whose kernels call packages other
    than `fmi_export` lists them in `PACKAGES`.

    A script has none, because the code that its kernels may call is in no package.

    The folder is in `base`, or else in the package's `__pycache__`, or else in the user's cache. Hosts delete an FMU
    that they have extracted, so the code of a package in an FMU is in the user's cache, or every run would compile it.
    """
    here = Path(__file__).parent
    loaded = sys.modules.get(package)
    if loaded is not None and not hasattr(loaded, "__path__"):
        return None
    home = Path(loaded.__file__).parent if loaded is not None and loaded.__file__ else here
    others = [find(name) for name in getattr(loaded, PACKAGES, ()) if name not in (package, "fmi_export")]
    code = [home, *(folder for folder in others if folder is not None), here]
    name = "-".join(["kernels", *(digest(folder)[:16] for folder in code)])
    in_fmu = home.parent.name == "code" and (home.parents[1] / "build.json").is_file()
    for parent in [Path(base)] if base else [user_cache()] if in_fmu else [home / "__pycache__", user_cache()]:
        with suppress(OSError):
            (parent / name).mkdir(parents=True, exist_ok=True)
            if os.access(parent / name, os.W_OK):
                return parent / name
    return None
