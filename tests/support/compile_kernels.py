"""Compiles the kernels of a model into numba's cache on disk: `compile_kernels.py MODEL [MODULE.KERNEL ...]`.

Machine code is made of the two kernels of a model, and of those named, which Python calls too: of what only kernels
call it would cost as much again. It stays in the cache of the tests too, by the code that it was made from: a fresh
installation, whose files have other places and dates, does not compile it again.
"""

import ctypes
import importlib
import os
import shutil
import sys
import warnings
from collections.abc import Collection
from pathlib import Path
from typing import Any

from fmi_export.numba_internals import finalize, linked, type_calls_once

VERSIONS = 40  # of the code of models, whose kernels stay in the cache of the tests
STEPPED = {"rotor_contact": "plant", "amb_actuator": "actuator"}  # modules of others are named `controller`


def compile_entries(entries: Collection[str]) -> None:
    """Let numba compile and cache only `entries` (`module.function`), each once with everything that it calls.

    To be called before any kernel is loaded. Calling other functions from Python is then a MemoryError: instead of
    machine code they have the function of Python that raises one.
    """
    caching: Any = importlib.import_module("numba.core.caching")
    codegen: Any = importlib.import_module("numba.core.codegen")
    make_function: Any = importlib.import_module("numba._dynfunc").make_function
    context: Any = importlib.import_module("numba.core.cpu").CPUContext
    wrap, load = context.create_cpython_wrapper, context.get_executable
    kernels = Path(os.environ["XDG_CACHE_HOME"], "kernels")
    read, save = caching.Cache._load_overload, caching.Cache._save_overload
    refuse = ctypes.cast(ctypes.pythonapi.PyErr_NoMemory, ctypes.c_void_p).value

    def is_entry(described: Any) -> bool:
        return f"{described.modname}.{described.qualname}" in entries

    def wrap_entry(context: Any, library: Any, described: Any, *arguments: Any, **options: Any) -> None:
        if is_entry(described):
            wrap(context, library, described, *arguments, **options)

    def load_entry(context: Any, library: Any, described: Any, environment: Any) -> Any:
        if not is_entry(described):
            return make_function(described.lookup_module(), described.qualname, "", refuse, environment, (library,))
        if not library.codegen._engine.is_symbol_defined(described.llvm_cpython_wrapper_name):  # nor from the cache
            library._final_module = linked(library)
            library._optimize_final_module()
            library._finalize_final_module()
        return load(context, library, described, environment)

    def stored(cache_on_disk: Any) -> Any:
        place = Path(cache_on_disk._cache_path)  # numba's name of a file's folder, in that of all its code
        folder = kernels / place.parent.name
        folder.mkdir(parents=True, exist_ok=True)
        name = f"{cache_on_disk._py_func.__module__}.{cache_on_disk._impl.filename_base}"
        return caching.IndexDataCacheFile(str(folder), name, source_stamp=None)

    def load_stored(cache_on_disk: Any, signature: Any, target: Any) -> Any:
        key, file = cache_on_disk._index_key(signature, target.codegen()), cache_on_disk._cache_file
        if file.load(key) is None and (data := stored(cache_on_disk).load(key)) is not None:
            cache_on_disk._impl.locator.ensure_cache_path()
            file.save(key, data)
        return read(cache_on_disk, signature, target)

    def save_entry(cache_on_disk: Any, signature: Any, result: Any) -> None:
        if is_entry(result.fndesc):
            save(cache_on_disk, signature, result)
            key = cache_on_disk._index_key(signature, result.codegen)
            if (data := cache_on_disk._cache_file.load(key)) is not None:
                stored(cache_on_disk).save(key, data)
                for outdated in sorted(kernels.iterdir(), key=os.path.getmtime)[:-VERSIONS]:
                    shutil.rmtree(outdated, ignore_errors=True)

    codegen.CPUCodeLibrary.finalize = finalize
    context.create_cpython_wrapper, context.get_executable = wrap_entry, load_entry
    caching.Cache._load_overload, caching.Cache._save_overload = load_stored, save_entry


name, *called = sys.argv[1:]
own = [f"{name}.{STEPPED.get(name, 'controller')}.{kernel}" for kernel in ("initialise", "step")]
compile_entries({"fmi_export.model.first_outside", "rolac_controller.enumerations.last_stages", *own, *called})
type_calls_once()  # as for native FMUs: a quarter less to do, for the same machine code
warnings.simplefilter("ignore")  # numba's own checks of what is inlined more than once

from amb_cosim import linear_controller  # noqa: E402
from amb_cosim.cosim.fmu.fmus import model_source  # noqa: E402
from fmi_export.model import Instance  # noqa: E402

law = linear_controller(1.0, ["y"], ["u"], 1e-3) if name == "linear_controller" else None  # made from a file
instance = Instance(*(law.model_and_constants if law else model_source(name)))
instance.initialise()
instance.step(0.0, 250e-6)  # numba keeps what it compiles for these
