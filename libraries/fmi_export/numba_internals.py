"""The seven undocumented features of numba that this project uses, each with its purpose.

`pyproject.toml` does not allow versions of numba later than the tested one. If a later version changes one of these
features, change this file.

**Functions without numba's run-time system, and without an entry for C** (`KERNEL_OPTIONS`, the options `_nrt` and
`no_cfunc_wrapper` of `njit`). Allocating becomes a compilation error, and no time is spent on counting references to
arrays. Without the first option, kernels are correct but several times slower, and `building.native` refuses them,
because they call the run-time system. Without the second option, compiling takes an eighth longer.

**The cache on disk** (`cache_soundly`, `compile_once`, `is_in_cache`, `folder_of_cache`, `user_cache`; `compile` and
`_cache` of a dispatcher, `numba.core.caching`, `numba.misc.appdirs`). numba finds code in its cache by the path and the
date of the source, so that it compiles the same code again in another place. A truncated file in the cache, such as one
left by a full disk, causes a traceback at every start. Processes that start together all compile the same code, which
takes each of them minutes. In addition, numba compiles a function anew for each literal argument. These functions
prevent all four problems. Without them, kernels are still correct.

**Code for arrays at positions known only in a kernel** (`lower_array_functions`, of `numba.core` and
`numba.np.arrayobj`). Slices, `view` and `reshape` do the same, but with divisions and branches. Without this feature, a
step takes longer, but the results have the same bits.

**Machine code of a model's two kernels only** (`compile_entries`, `linked`; methods of `numba.core.codegen`,
`numba.core.cpu` and `numba.core.caching`). By default, numba optimises and compiles each function together with
everything that it calls. Without this feature, the first step of the flavour `python` takes several times as long.

**No machine code** (`compile_nothing`, methods of `numba.core.codegen`, and the names that numba gives to its functions
in the assembly; see `building.native.lowering`). By default, numba links, optimises and compiles each function together
with everything that it calls, so a function at the bottom of a deep call tree is compiled once for every level above
it. `compile_nothing` prevents this, and omits the entries of functions for Python and C. Without it, lowering takes
twice as long, but the results have the same bits.

**Types of calls** (`type_calls_once`, `get_call_type` of `numba.core.types.functions`). By default, numba infers the
type of an operator at every call. Without `type_calls_once`, lowering takes a third longer, but the machine code is the
same.

**Preserved stores** (`keep_stores`, `find_potential_aliases` of `numba.core.ir_utils`). After inlining, numba removes
writes to arrays that it considers local. These include every array in a tuple that an inlined function made; for
example, `state_of(work).z[i] = 1.0` had no effect (numba issue 10041). Without `keep_stores`, kernels can be wrong,
which `tests/fmi_export` detects. Remove `keep_stores` when numba has fixed the issue.
"""

from __future__ import annotations

import ctypes
import importlib
from collections.abc import Collection
from contextlib import suppress
from pathlib import Path
from typing import Any

from fmi_export.compiling import compiling

KERNEL_OPTIONS = {"_nrt": False, "no_cfunc_wrapper": True}  # options of `njit`


def cache_soundly(dispatcher: Any, folder: Path) -> Any:
    """Let numba cache the machine code of a function in a folder, whatever the path and the date of its source.

    If the code in the cache is damaged, numba compiles again; if the disk is full, it continues. Returns the function.
    """
    cache_on_disk = dispatcher._cache
    caching: Any = importlib.import_module("numba.core.caching")
    name = f"{dispatcher.py_func.__module__}.{cache_on_disk._impl.filename_base}"
    cache_on_disk._cache_path = str(folder)
    cache_on_disk._cache_file = caching.IndexDataCacheFile(str(folder), name, source_stamp=None)
    cache_on_disk._impl.locator.ensure_cache_path = lambda: folder.mkdir(parents=True, exist_ok=True)
    load, save = cache_on_disk.load_overload, cache_on_disk.save_overload

    def load_overload(*arguments: Any) -> Any:
        try:
            return load(*arguments)
        except Exception:  # any error from reading a damaged file
            with suppress(OSError):
                cache_on_disk.flush()
            return None

    def save_overload(*arguments: Any) -> None:
        with suppress(Exception):  # the disk, or a damaged index
            save(*arguments)

    cache_on_disk.load_overload, cache_on_disk.save_overload = load_overload, save_overload
    return dispatcher


def compile_once(dispatcher: Any) -> Any:
    """Let one process compile a function and everything that it calls, while others wait for its cache on disk.

    A process holds only one lock at a time: that of the function that Python calls. By default, numba also compiles a
    function anew for each literal argument. Returns the function.
    """
    compiler_lock: Any = importlib.import_module("numba.core.compiler_lock").global_compiler_lock
    type_of: Any = importlib.import_module("numba.core.types").unliteral
    on_disk, compile_it = dispatcher._cache, dispatcher.compile
    place, name = Path(on_disk._cache_file._index_path), f"{dispatcher.py_func.__module__}.{dispatcher.__name__}"

    def compile_alone(signature: Any) -> Any:
        global _compiles
        signature = tuple(type_of(argument) for argument in signature)
        with compiler_lock:
            if _compiles or is_in_cache(dispatcher, signature):
                return compile_it(signature)
            _compiles = True
            try:
                with compiling(place, name):
                    return compile_it(signature)
            finally:
                _compiles = False

    dispatcher.compile = compile_alone
    return dispatcher


_compiles = False  # whether this process has a lock


def is_in_cache(kernel: Any, signature: tuple[Any, ...]) -> bool:
    """Return whether a kernel is compiled for these types of its arguments, in this process or in the cache on disk."""
    if signature in kernel.overloads:
        return True
    with suppress(Exception):  # any error from a kernel without a cache, or from reading a damaged file
        on_disk, file = kernel._cache, kernel._cache._cache_file
        name = file._load_index()[on_disk._index_key(signature, kernel.targetctx.codegen())]
        return Path(file._data_path(name)).exists()  # numba writes the index before the code
    return False


def user_cache() -> Path:
    """Return the folder in which numba caches the code of packages whose own folders are read-only."""
    return Path(importlib.import_module("numba.misc.appdirs").AppDirs("numba", appauthor=False).user_cache_dir)


def folder_of_cache(kernel: Any) -> Path | None:
    """Return the folder in which numba caches the machine code of a kernel, or None if it does not."""
    folder = getattr(getattr(kernel, "_cache", None), "cache_path", None)
    return None if folder is None else Path(folder)


def lower_array_functions(part: Any, clear: Any, copy_all: Any) -> None:
    """Register the code of the three functions of `parts` for use in kernels."""
    from numba import types
    from numba.core import cgutils
    from numba.core.imputils import impl_ret_borrowed
    from numba.extending import lower_builtin, type_callable
    from numba.np.arrayobj import make_array, populate_array

    @type_callable(part)
    def _type_of_part(context: Any) -> Any:
        def typer(array: Any, start: Any, dtype: Any, shape: Any) -> Any:
            n_dimensions = 1 if isinstance(shape, types.Integer) else shape.count
            return types.Array(dtype.dtype, n_dimensions, "C")

        return typer

    @lower_builtin(part, types.Array, types.Integer, types.Any, types.Any)
    def _lowered_part(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        result_type, (array_type, start_type, _, shape_type) = signature.return_type, signature.args
        source = make_array(array_type)(context, builder, arguments[0])
        start = context.cast(builder, arguments[1], start_type, types.intp)
        if isinstance(shape_type, types.Integer):
            sizes = [(arguments[3], shape_type)]
        else:
            sizes = list(zip(cgutils.unpack_tuple(builder, arguments[3]), shape_type, strict=True))
        shape = [context.cast(builder, size, kind, types.intp) for size, kind in sizes]
        itemsize = context.get_abi_sizeof(context.get_data_type(result_type.dtype))
        strides = [context.get_constant(types.intp, itemsize)]
        for size in reversed(shape[1:]):
            strides.insert(0, builder.mul(strides[0], size))
        address = builder.gep(source.data, [start], source_etype=context.get_value_type(types.float64))
        result = make_array(result_type)(context, builder)
        populate_array(
            result,
            data=builder.bitcast(address, result.data.type),
            shape=shape,
            strides=strides,
            itemsize=context.get_constant(types.intp, itemsize),
            meminfo=source.meminfo,
            parent=source.parent,
        )
        return impl_ret_borrowed(context, builder, result_type, result._getvalue())

    def _bytes(context: Any, builder: Any, array_type: Any, value: Any) -> tuple[Any, Any]:
        """Return the address of an array and its size (bytes)."""
        array = make_array(array_type)(context, builder, value)
        itemsize = context.get_constant(types.intp, context.get_abi_sizeof(context.get_data_type(array_type.dtype)))
        return array.data, builder.mul(array.nitems, itemsize)

    @type_callable(clear)
    def _type_of_clear(context: Any) -> Any:
        return lambda array: types.none

    @lower_builtin(clear, types.Array)
    def _lowered_clear(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        address, size = _bytes(context, builder, signature.args[0], arguments[0])
        cgutils.memset(builder, address, size, 0)
        return context.get_dummy_value()

    @type_callable(copy_all)
    def _type_of_copy_all(context: Any) -> Any:
        return lambda source, target: types.none

    @lower_builtin(copy_all, types.Array, types.Array)
    def _lowered_copy_all(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        source, size = _bytes(context, builder, signature.args[0], arguments[0])
        target, _ = _bytes(context, builder, signature.args[1], arguments[1])
        cgutils.raw_memcpy(builder, target, source, size, 1)
        return context.get_dummy_value()


def keep_stores() -> None:
    """Make numba treat every array as visible to other code when it looks for stores without effect."""
    ir_utils: Any = importlib.import_module("numba.core.ir_utils")
    find = ir_utils.find_potential_aliases

    def find_potential_aliases(blocks: Any, *arguments: Any, **options: Any) -> tuple[Any, Any]:
        aliases, visible = find(blocks, *arguments, **options)
        stores = (statement for block in blocks.values() for statement in block.find_insts(ir_utils.ir.SetItem))
        return aliases, visible | {store.target.name for store in stores}

    ir_utils.find_potential_aliases = find_potential_aliases


_NOWHERE = ctypes.create_string_buffer(8)  # the address of machine code that does not exist


def compile_nothing() -> None:
    """Make each of numba's libraries contain only its own function, without machine code; see `linked`.

    Use this only in a process that lowers kernels but does not run any.
    """
    codegen: Any = importlib.import_module("numba.core.codegen")
    caching: Any = importlib.import_module("numba.core.caching")
    cpu: Any = importlib.import_module("numba.core.cpu")

    codegen.CPUCodeLibrary.finalize = finalize
    codegen.CPUCodeLibrary._optimize_functions = lambda library, module: None
    codegen.JITCodeLibrary.get_pointer_to_function = _address
    codegen.JITCPUCodegen.set_env = lambda generator, name, environment: None
    caching.Cache.save_overload = lambda cache, signature, result: None
    cpu.CPUContext.create_cpython_wrapper = lambda context, *arguments, **options: None
    cpu.CPUContext.create_cfunc_wrapper = lambda context, *arguments: None


def compile_entries(entries: Collection[str]) -> None:
    """Make numba compile and cache only `entries` (`module.function`), each once with everything that it calls.

    Call this before any kernel is loaded, in a process that compiles kernels for others. There, only entries can call
    the other functions: if Python calls one, it raises a MemoryError, because it has no machine code of its own.
    """
    caching: Any = importlib.import_module("numba.core.caching")
    codegen: Any = importlib.import_module("numba.core.codegen")
    make_function: Any = importlib.import_module("numba._dynfunc").make_function
    context: Any = importlib.import_module("numba.core.cpu").CPUContext
    wrap, load, save = context.create_cpython_wrapper, context.get_executable, caching.Cache._save_overload
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

    def save_entry(cache_on_disk: Any, signature: Any, result: Any) -> None:
        if is_entry(result.fndesc):
            save(cache_on_disk, signature, result)

    codegen.CPUCodeLibrary.finalize = finalize
    context.create_cpython_wrapper, context.get_executable = wrap_entry, load_entry
    caching.Cache._save_overload = save_entry


def type_calls_once() -> None:
    """Make numba infer the type of a function's calls once per set of argument types instead of at every call."""
    functions: Any = importlib.import_module("numba.core.types.functions")
    infer = functions.BaseFunction.get_call_type
    results: dict[Any, Any] = {}

    def get_call_type(function: Any, context: Any, args: Any, kws: Any) -> Any:
        key = function, tuple(args), tuple(kws.items())
        if key not in results:
            results[key] = infer(function, context, args, kws)
        return results[key]

    functions.BaseFunction.get_call_type = get_call_type


def finalize(library: Any) -> None:
    """Finalise a library without making machine code."""
    library._final_module.verify()
    library._finalized = True


def _address(library: Any, name: str) -> int:
    library._ensure_finalized()
    return ctypes.addressof(_NOWHERE)


def linked(*libraries: Any) -> Any:
    """Return the module of some libraries, linked with the modules of all libraries that they need.

    A function that is inlined in one module may be called in another. Therefore everything is linked, and unused code
    is removed afterwards.
    """
    llvm: Any = importlib.import_module("llvmlite.binding")
    modules = [library._final_module.clone() for library in libraries]
    modules += [other._get_module_for_linking().clone() for other in _needed(libraries)]
    for module in modules:
        _replace_linkage(module, llvm.Linkage.linkonce_odr, llvm.Linkage.weak_odr)
    while len(modules) > 1:  # in pairs, because linking reads all that the first module contains
        modules, others = modules[::2], modules[1::2]
        for module, other in zip(modules, others, strict=False):
            module.link_in(other)
    module = modules[0]
    _replace_linkage(module, llvm.Linkage.weak_odr, llvm.Linkage.linkonce_odr)
    return module


def _replace_linkage(module: Any, old: Any, new: Any) -> None:
    for function in module.functions:
        if not function.is_declaration and function.linkage == old:
            function.linkage = new


def _needed(libraries: Collection[Any]) -> list[Any]:
    """Return what libraries call directly or indirectly, without repetition and without themselves."""
    needed, pending = [*libraries], [*libraries]
    while pending:
        for other in pending.pop()._linking_libraries:
            if not any(other is present for present in needed):
                needed.append(other)
                pending.append(other)
    return needed[len(libraries) :]
