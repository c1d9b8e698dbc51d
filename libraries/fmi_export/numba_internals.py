"""What is used of numba that its documentation does not promise: six things, each with what it is for.

`pyproject.toml` allows no numba later than the one that was tested. Where that has changed one of these, this file is
what has to change.

**Functions without numba's run-time system, and without an entry for C** (`KERNEL_OPTIONS`, the options `_nrt` and
`no_cfunc_wrapper` of `njit`). Allocating becomes an error of compilation, and no time goes into counting references to
arrays. Without it kernels are right, and several times slower; `building.native` refuses them, since they call that
system. Without the second, compiling takes an eighth longer.

**The cache on disk** (`keep_cache_sound`, `compile_once`; `compile` and `_cache` of a dispatcher, its `_cache_file`).
numba reads machine code from its cache as it is: a wrong bit would crash the process, a file cut short is a traceback,
and so is a full disk. Processes that begin together all compile the same. Without it kernels are right while the disk
is.

**Code for arrays at places that are known only in a kernel** (`lower_array_functions`, of `numba.core` and
`numba.np.arrayobj`). Slices, `view` and `reshape` do the same with divisions and branches. Without it a step takes
longer, and is the same to the last bit.

**Machine code of nothing, or of what Python calls alone** (`compile_nothing`, `compile_entries`, methods of
`numba.core.codegen`, and the names that numba gives to its own functions in the assembly, see
`building.native.lowering`). By itself numba links a function with all that it calls, optimises that and compiles it,
for each function anew: one at the bottom of a deep tree of calls is compiled once for every level above it. What is
left out has no code that Python or C calls it by, either. Without it lowering, and compiling for the tests, takes
twice as long; the bits of results are the same.

**Types of calls** (`type_calls_once`, `get_call_type` of `numba.core.types.functions`). numba infers the type of an
operator anew at every call. Without it lowering takes longer; the machine code is the same.

**Stores that stay** (`keep_stores`, `find_potential_aliases` of `numba.core.ir_utils`). After inlining, numba removes
what writes to an array that it takes for a local one, and it takes every array for that which came out of a tuple made
by an inlined function: `state_of(work).z[i] = 1.0` did nothing (numba issue 10041). Without it kernels can be wrong,
and `tests/fmi_export` says so; where numba mends that, this can go.
"""

from __future__ import annotations

import ctypes
import importlib
from collections.abc import Collection, Iterator
from contextlib import contextmanager, suppress
from hashlib import sha256
from io import BytesIO
from pathlib import Path
from typing import Any

from fmi_export.compiling import compiling

KERNEL_OPTIONS = {"_nrt": False, "no_cfunc_wrapper": True}  # options of `njit`

DIGEST_SIZE = sha256().digest_size


def keep_cache_sound(dispatcher: Any) -> Any:
    """Let numba compile anew what is damaged in the cache of a function, and go on where the cache is full.

    Returns the function.
    """
    cache_on_disk = dispatcher._cache
    _sign_files(cache_on_disk._cache_file)
    load, save = cache_on_disk.load_overload, cache_on_disk.save_overload

    def load_overload(*arguments: Any) -> Any:
        try:
            return load(*arguments)
        except Exception:  # whatever reading a damaged file leads to
            with suppress(OSError):
                cache_on_disk.flush()
            return None

    def save_overload(*arguments: Any) -> None:
        with suppress(Exception):  # the disk, or an index that is still damaged
            save(*arguments)

    cache_on_disk.load_overload, cache_on_disk.save_overload = load_overload, save_overload
    return dispatcher


def compile_once(dispatcher: Any) -> Any:
    """Let one process compile a function with all that it calls, while others wait for what that keeps on disk.

    A process has one such lock at a time, that of the function which Python calls. Returns the function.
    """
    held: Any = importlib.import_module("numba.core.compiler_lock").global_compiler_lock
    on_disk, compile_it = dispatcher._cache, dispatcher.compile
    place, name = Path(on_disk._cache_file._index_path), f"{dispatcher.py_func.__module__}.{dispatcher.__name__}"

    def is_kept(signature: Any) -> bool:
        with suppress(Exception):  # whatever reading a damaged file leads to
            return on_disk._index_key(signature, dispatcher.targetctx.codegen()) in on_disk._cache_file._load_index()
        return False

    def compile_alone(signature: Any) -> Any:
        global _compiles
        with held:
            if _compiles or is_kept(signature):
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


def _sign_files(files: Any) -> None:
    """Let the files of numba's cache end with a digest, and refuse to read what does not fit its own.

    A single wrong bit of machine code would crash the process. What follows a pickle, pickle does not read.
    """
    open_for_write, load_index, load_data = files._open_for_write, files._load_index, files._load_data

    @contextmanager
    def open_signed(path: str) -> Iterator[BytesIO]:
        content = BytesIO()
        yield content
        with open_for_write(path) as file:
            file.write(content.getvalue() + sha256(content.getvalue()).digest())

    def check(path: str) -> None:
        content = Path(path).read_bytes()
        if sha256(content[:-DIGEST_SIZE]).digest() != content[-DIGEST_SIZE:]:
            raise ValueError(f"{path} is damaged")

    def load_checked_index() -> Any:
        with suppress(FileNotFoundError):  # nothing was kept yet
            check(files._index_path)
        return load_index()

    def load_checked_data(name: str) -> Any:
        check(files._data_path(name))
        return load_data(name)

    files._open_for_write, files._load_index, files._load_data = open_signed, load_checked_index, load_checked_data


def lower_array_functions(part: Any, clear: Any, copy_all: Any) -> None:
    """Give kernels their own code of the three functions of `parts`."""
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
            given = [(arguments[3], shape_type)]
        else:
            given = list(zip(cgutils.unpack_tuple(builder, arguments[3]), shape_type, strict=True))
        shape = [context.cast(builder, size, kind, types.intp) for size, kind in given]
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
        """Address and size of an array in bytes."""
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
    """Let numba take every array for one that others can see, when it looks for stores that have no effect."""
    ir_utils: Any = importlib.import_module("numba.core.ir_utils")
    find = ir_utils.find_potential_aliases

    def find_potential_aliases(blocks: Any, *arguments: Any, **options: Any) -> tuple[Any, Any]:
        aliases, visible = find(blocks, *arguments, **options)
        stores = (statement for block in blocks.values() for statement in block.find_insts(ir_utils.ir.SetItem))
        return aliases, visible | {store.target.name for store in stores}

    ir_utils.find_potential_aliases = find_potential_aliases


_NOWHERE = ctypes.create_string_buffer(8)  # the address of machine code that does not exist


def compile_nothing() -> None:
    """Let numba's libraries keep their own function alone; their text is that with all that it calls.

    For a process that lowers kernels and runs none.
    """
    codegen: Any = importlib.import_module("numba.core.codegen")
    caching: Any = importlib.import_module("numba.core.caching")
    cpu: Any = importlib.import_module("numba.core.cpu")

    codegen.CPUCodeLibrary.finalize = _finalize
    codegen.CPUCodeLibrary.get_llvm_str = lambda library: str(_linked(library))
    codegen.CPUCodeLibrary._optimize_functions = lambda library, module: None
    codegen.JITCodeLibrary.get_pointer_to_function = _address
    codegen.JITCPUCodegen.set_env = lambda generator, name, environment: None
    caching.Cache.save_overload = lambda cache, signature, result: None
    cpu.CPUContext.create_cpython_wrapper = lambda context, *arguments, **options: None
    cpu.CPUContext.create_cfunc_wrapper = lambda context, *arguments: None


def compile_entries(entries: Collection[str]) -> None:
    """Let numba make and keep machine code of `entries` alone (`module.function`), of each once with all that it calls.

    For a process that compiles kernels for others, before it loads any. A call of others from Python is a MemoryError
    there: what they have in place of machine code is the function of Python that raises one.
    """
    caching: Any = importlib.import_module("numba.core.caching")
    codegen: Any = importlib.import_module("numba.core.codegen")
    make_function: Any = importlib.import_module("numba._dynfunc").make_function
    context: Any = importlib.import_module("numba.core.cpu").CPUContext
    wrap, load, save = context.create_cpython_wrapper, context.get_executable, caching.Cache.save_overload
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
            library._final_module = _linked(library)
            library._optimize_final_module()
            library._finalize_final_module()
        return load(context, library, described, environment)

    def save_entry(cache_on_disk: Any, signature: Any, result: Any) -> None:
        if is_entry(result.fndesc):
            save(cache_on_disk, signature, result)

    codegen.CPUCodeLibrary.finalize = _finalize
    context.create_cpython_wrapper, context.get_executable = wrap_entry, load_entry
    caching.Cache.save_overload = save_entry


def type_calls_once() -> None:
    """Let numba infer the type of a call of its own functions once for each types of arguments, not at every call."""
    functions: Any = importlib.import_module("numba.core.types.functions")
    infer = functions.BaseFunction.get_call_type
    known: dict[Any, Any] = {}

    def get_call_type(function: Any, context: Any, args: Any, kws: Any) -> Any:
        key = function, tuple(args), tuple(kws.items())
        if key not in known:
            known[key] = infer(function, context, args, kws)
        return known[key]

    functions.BaseFunction.get_call_type = get_call_type


def _finalize(library: Any) -> None:
    library._final_module.verify()
    library._finalized = True


def _address(library: Any, name: str) -> int:
    library._ensure_finalized()
    return ctypes.addressof(_NOWHERE)


def _linked(library: Any) -> Any:
    """Return the module of a library, linked with those of all libraries that it needs, optimised already or not.

    What one of those has inlined, another may call later: all of it is linked, and what nothing calls may then go.
    """
    llvm: Any = importlib.import_module("llvmlite.binding")
    module = library._final_module.clone()
    for other in _needed(library):
        part = other._get_module_for_linking().clone()
        _replace_linkage(part, llvm.Linkage.linkonce_odr, llvm.Linkage.weak_odr)
        module.link_in(part)
    _replace_linkage(module, llvm.Linkage.weak_odr, llvm.Linkage.linkonce_odr)
    return module


def _replace_linkage(module: Any, given: Any, wanted: Any) -> None:
    for function in module.functions:
        if not function.is_declaration and function.linkage == given:
            function.linkage = wanted


def _needed(library: Any) -> list[Any]:
    """Return the libraries that a library calls, directly or not, each once."""
    found, open_ones = [library], [library]
    while open_ones:
        for other in open_ones.pop()._linking_libraries:
            if not any(other is known for known in found):
                found.append(other)
                open_ones.append(other)
    return found[1:]
