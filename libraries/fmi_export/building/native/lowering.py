"""Lowers the two kernels of a model to one LLVM module, which calls only mathematical functions of the C library.

Because numba compiles for the host's processor, a separate process compiles the kernels again for a generic processor.
Kernels are compiled without numba's run-time system, so they count no references and cannot allocate. The exceptions
that numba leaves in the code lose their text; they are reported by the status that a kernel returns.
"""

from __future__ import annotations

import importlib
import json
import os
import re
import subprocess
import sys
from collections.abc import Callable
from importlib import resources
from pathlib import Path
from typing import Any, Protocol

from amb_files.temporary_folders import temporary_folder
from fmi_export.compiling import collect_garbage_rarely, import_path
from fmi_export.jit import KERNELS_APART
from fmi_export.model import InitialiseKernel, StepKernel
from fmi_export.numba_internals import compile_nothing, linked, type_calls_once

ENTRIES = ("kernel_initialise", "kernel_step")

# Functions that a lowered kernel may call: C's mathematics and memory, and helpers of instance.c.
ALLOWED = re.compile(
    "acos|asin|atan2?|cbrt|ceil|copysign|cosh?|erfc?|exp2?|expm1|fabs|floor|fma|fmax|fmin|fmod|frexp|hypot|ldexp|lgamma|"
    "log|log10|log1p|log2|modf|nearbyint|nextafter|pow|rint|round|sinh?|sqrt|tanh?|tgamma|trunc|"
    "memcpy|memmove|memset"
)

EXCEPTION = "__excinfo"  # begins the name of a function that builds an exception from values

# Generic CPU; optimise after removing Python runtime calls; deterministic.
SETTINGS = {
    "NUMBA_CPU_NAME": "generic",
    "NUMBA_CPU_FEATURES": "",
    "NUMBA_OPT": "0",
    "NUMBA_LOOP_VECTORIZE": "0",
    "NUMBA_SLP_VECTORIZE": "0",
    "NUMBA_DISABLE_ERROR_MESSAGE_HIGHLIGHTING": "1",
    "PYTHONHASHSEED": "0",
}


class Kernels(Protocol):
    """The attributes of a model on which its machine code depends; see `Model`."""

    @property
    def name(self) -> str: ...
    @property
    def initialise(self) -> InitialiseKernel: ...
    @property
    def step(self) -> StepKernel: ...
    @property
    def packages(self) -> tuple[str, ...]: ...


def lower(model: Kernels) -> str:
    """Return the LLVM assembly of `kernel_initialise` and `kernel_step`, which is not specific to any target.

    `int32_t kernel_step(int64_t *fault, void **exception, double *constants, int64_t n_constants, ..., double time,
    double step_size)` takes each array as address and size and returns 0 unless the kernel raised an exception.

    Raises
    ------
    ValueError
        If the kernels are not compiled by numba, or need Python when they run.
    """
    places = [_place(model.name, kernel) for kernel in (model.initialise, model.step)]
    with temporary_folder() as folder:
        environment = {name: value for name, value in os.environ.items() if not name.startswith("NUMBA_")}
        environment |= SETTINGS | {"NUMBA_CACHE_DIR": str(folder)}
        environment["PYTHONPATH"] = import_path()
        target = folder / "kernels.ll"
        process = subprocess.run(
            [sys.executable, "-P", "-m", __name__, json.dumps(places), str(target)],
            cwd=folder,
            env=environment,
            capture_output=True,
            text=True,
            check=False,
        )
        if process.returncode != 0:
            reason = process.stderr.strip().splitlines() or [f"numba's process ended with {process.returncode}"]
            raise ValueError(f"{model.name} cannot be built as an FMU without Python: {reason[-1]}")
        return target.read_text(encoding="utf-8")


def _place(name: str, kernel: Any) -> tuple[str, str]:
    """Return the module and the name by which another process can find a kernel."""
    if not hasattr(kernel, "py_func"):
        raise ValueError(
            f"{name} cannot be built as an FMU without Python, because numba does not compile its kernels; "
            "install numba"
        )
    module, function = kernel.py_func.__module__, kernel.py_func.__qualname__
    if getattr(sys.modules.get(module), function, None) is not kernel:
        raise ValueError(
            f"{name} cannot be built as an FMU without Python: there is no kernel {function} in module {module}"
        )
    return module, function


# In the subprocess ------------------------------------------------------------------------------------------------


def main() -> None:
    """Compile the kernels named in the first argument to the file named in the second."""
    collect_garbage_rarely()
    compile_nothing()
    type_calls_once()
    kernels = [getattr(importlib.import_module(module), name) for module, name in json.loads(sys.argv[1])]
    try:
        assembly = without_python([_initialise_entry(kernels[0]), _step_entry(kernels[1])])
    except Exception as error:
        sys.exit(_single_line(error))
    Path(sys.argv[2]).write_text(assembly, encoding="utf-8")


def _single_line(error: Exception) -> str:
    """Return numba's message in one line, or the location of the code that requires numba's run-time system."""
    text = " ".join(str(error).split()) or repr(error)
    if "NRT required" not in text and "Only accept returning of array" not in text:
        return text
    place = next((p for p in re.findall(r" at (\S+ \(\d+\))", text) if "/numba/" not in p), "")
    return f"a kernel must not allocate, return an array or raise an exception that contains values: {place}"


def _initialise_entry(kernel: Callable[..., int]) -> Any:
    numba: Any = importlib.import_module("numba")
    carray, size, pointer = numba.carray, numba.int64, numba.types.CPointer(numba.float64)

    @numba.cfunc(size(*(pointer, size) * 6), error_model="numpy")
    def entry(c, n_c, p, n_p, u, n_u, x, n_x, w, n_w, y, n_y):  # type: ignore[no-untyped-def]
        return kernel(carray(c, n_c), carray(p, n_p), carray(u, n_u), carray(x, n_x), carray(w, n_w), carray(y, n_y))

    return entry


def _step_entry(kernel: Callable[..., int]) -> Any:
    numba: Any = importlib.import_module("numba")
    carray, size, pointer = numba.carray, numba.int64, numba.types.CPointer(numba.float64)

    @numba.cfunc(size(*(pointer, size) * 6, numba.float64, numba.float64), error_model="numpy")
    def entry(c, n_c, p, n_p, u, n_u, x, n_x, w, n_w, y, n_y, t, h):  # type: ignore[no-untyped-def]
        return kernel(
            carray(c, n_c), carray(p, n_p), carray(u, n_u), carray(x, n_x), carray(w, n_w), carray(y, n_y), t, h
        )

    return entry


def without_python(entries: list[Any]) -> str:
    """Return the LLVM assembly of compiled entries (`numba.cfunc`), renamed to `ENTRIES` and free of calls to Python.

    Raises
    ------
    ValueError
        If a call that needs Python remains.
    """
    llvm: Any = importlib.import_module("llvmlite.binding")
    llvm.initialize_native_target()
    assembly = str(linked(*(entry._library for entry in entries)))
    module = llvm.parse_assembly(_remove_runtime(assembly))
    # numba's C callback sets Python's error indicator; the function that it calls does not.
    for entry, name in zip(entries, ENTRIES, strict=True):
        module.get_function(entry.native_name.removeprefix("cfunc.")).name = name
    _keep_entries_only(module, llvm)
    _refuse_what_needs_python(module)
    return _shorten_names(re.sub(r"^(target |source_filename|; ModuleID).*\n", "", str(module), flags=re.MULTILINE))


def _shorten_names(assembly: str) -> str:
    """Replace long names of blocks and values; names in inlined code are long, as they contain the function's name."""
    names: dict[str, str] = {}
    return re.sub(
        r'(?<=%)[-\w$.]{100,}|^[-\w$.]{100,}(?=:)|(?<=%)"[^"\n]{100,}"|^"[^"\n]{100,}"(?=:)',
        lambda match: names.setdefault(match[0], f"name_{len(names)}"),
        assembly,
        flags=re.MULTILINE,
    )


RUNTIME = resources.files(__package__).joinpath("runtime.ll")


def _remove_runtime(assembly: str) -> str:
    """Remove Python's runtime, the contents of exceptions, and addresses within this process from the assembly."""
    flags = re.MULTILINE | re.DOTALL
    runtime = RUNTIME.read_text(encoding="utf-8")
    names = "|".join(re.findall(r"@(\w+)\(", runtime))
    named = rf"[^@\n]*@(?:{names})\("
    assembly = re.sub(rf"^define {named}.*?^\}}|^declare {named}.*?$", "", assembly, flags=flags)
    # If it is not optimised away, such a variable is now undefined, and the build is refused.
    assembly = re.sub(r"^(@numba\.dynamic\.globals\.\w+ =) .*?$", r"\1 external global ptr", assembly, flags=flags)
    lines = (
        line if line.startswith("@") else re.sub(r"@\.const\.picklebuf\.[\w.]+", "@no_exception", line)
        for line in assembly.splitlines()
    )
    return "\n".join((*lines, runtime))


def _keep_entries_only(module: Any, llvm: Any) -> None:
    """Make everything except the entries private, and remove unreachable code."""
    for function in module.functions:
        if not function.is_declaration:
            retained = function.name in ENTRIES
            function.linkage = "external" if retained else "internal"
            function.visibility = "hidden" if retained else "default"
    for variable in module.global_variables:
        if not variable.is_declaration:
            variable.linkage = "internal"
    _keep_apart(module)
    machine = llvm.Target.from_default_triple().create_target_machine(cpu="generic", features="", opt=2)
    tuning = llvm.create_pipeline_tuning_options(speed_level=2)
    tuning.loop_vectorization = tuning.slp_vectorization = False  # the compiler of each platform does it
    builder = llvm.create_pass_builder(machine, tuning)
    builder.getModulePassManager().run(module, builder)
    module.verify()
    for k, function in enumerate(f for f in module.functions if not f.is_declaration and f.name not in ENTRIES):
        if not function.name.startswith(EXCEPTION):
            function.name = f"kernel_{k}"  # numba's names are long, and macOS libraries keep them


def _keep_apart(module: Any) -> None:
    """Prevent the kernels in `KERNELS_APART` from being inlined into their callers."""
    mangled = ["".join(f"{len(part)}{part}" for part in parts) + "B" for parts in KERNELS_APART]
    for function in module.functions:
        if not function.is_declaration and any(name in function.name for name in mangled):
            function.add_function_attribute("noinline")


def _refuse_what_needs_python(module: Any) -> None:
    functions, variables = list(module.functions), list(module.global_variables)
    names = {v.name for v in (*functions, *variables) if v.is_declaration and not v.name.startswith("llvm.")}
    names = {name for name in names if not ALLOWED.fullmatch(name)}
    names |= {function.name for function in functions if function.name.startswith(EXCEPTION)}
    if names:
        raise ValueError(f"the kernels call {', '.join(sorted(names))}, which are not available in an FMU")
    processors = sorted({f.name for f in functions if re.match(r"llvm\.(x86|aarch64)\.", f.name)})
    if processors:
        raise ValueError(f"the kernels are compiled for one processor only: {', '.join(processors)}")


if __name__ == "__main__":
    main()
