"""Has numba write the assembly of kernels without compiling it, each function once.

By itself numba links a function with all that it calls, optimises that and compiles it to machine code, for each
function anew: one at the bottom of a deep tree of calls is compiled once for every level above it. Where only the
assembly of the whole is wanted, that is half of the time.

numba has no option for it; what is replaced here are methods of `numba.core.codegen`, in a process that lowers kernels
and runs none.
"""

from __future__ import annotations

import ctypes
import importlib
from typing import Any

_NOWHERE = ctypes.create_string_buffer(8)  # the address of machine code that does not exist


def compile_nothing() -> None:
    """Let numba's libraries keep their own function alone; their text is that with all that it calls."""
    codegen: Any = importlib.import_module("numba.core.codegen")
    caching: Any = importlib.import_module("numba.core.caching")

    codegen.CPUCodeLibrary.finalize = _finalize
    codegen.CPUCodeLibrary.get_llvm_str = lambda library: str(_linked(library))
    codegen.CPUCodeLibrary._optimize_functions = lambda library, module: None
    codegen.JITCodeLibrary.get_pointer_to_function = _address
    codegen.JITCPUCodegen.set_env = lambda generator, name, environment: None
    caching.Cache.save_overload = lambda cache, signature, result: None


def _finalize(library: Any) -> None:
    library._final_module.verify()
    library._finalized = True


def _address(library: Any, name: str) -> int:
    library._ensure_finalized()
    return ctypes.addressof(_NOWHERE)


def _linked(library: Any) -> Any:
    """Return the module of a library, linked with those of all libraries that it needs."""
    llvm: Any = importlib.import_module("llvmlite.binding")
    module = library._final_module.clone()
    for other in _needed(library):
        part = other._final_module.clone()
        for function in part.functions:
            if not function.is_declaration and function.linkage == llvm.Linkage.external:
                function.linkage = "linkonce_odr"  # more than one may bring it along
        module.link_in(part)
    return module


def _needed(library: Any) -> list[Any]:
    """Return the libraries that a library calls, directly or not, each once."""
    found, open_ones = [library], [library]
    while open_ones:
        for other in open_ones.pop()._linking_libraries:
            if not any(other is known for known in found):
                found.append(other)
                open_ones.append(other)
    return found[1:]
