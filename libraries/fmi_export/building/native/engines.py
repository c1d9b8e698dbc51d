"""Engines: the machine code of models for a platform, independent of the models' interfaces and constants.

An engine consists of the slave in C and the two lowered kernels of a model or, for an assembly, of each model in it. It
is taken from the installed package or from the user's cache; if neither contains it, it is compiled.
"""

from __future__ import annotations

import importlib.metadata
import logging
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from platform import machine

from amb_files.stored_folder import is_undamaged, keep
from amb_files.user_cache import user_cache
from fmi_export.building.extras import require_extra
from fmi_export.building.identity import digests
from fmi_export.building.native.compiler import check_compiler, compile_library
from fmi_export.building.native.lowering import Kernels, lower
from fmi_export.building.native.sources import FOLDER, digest_of, texts_of
from fmi_export.compiling import compiling

log = logging.getLogger(__name__)

SHIPPED = FOLDER / "engines"  # in an installed package
HEADERS = "fmi_headers"  # folder of the headers of the FMI standard, unchanged
SLAVE = (  # an instance as hosts of FMI 2.0 run it, without the kernels
    *(f"{HEADERS}/fmi2{part}.h" for part in ("Functions", "FunctionTypes", "TypesPlatform")),
    *("assembly.h", "data.h", "derivative.h", "host.h", "instance.h", "kernels.h", "loop.h", "resources.h", "saved.h"),
    *("slave.h", "values.h"),
    *("assembly.c", "data.c", "derivative.c", "fmi2.c", "host.c", "instance.c", "loop.c", "resources.c", "saved.c"),
    *("slave.c", "values.c"),
)
SLAVE3 = (
    *(f"{HEADERS}/fmi3{part}.h" for part in ("Functions", "FunctionTypes", "PlatformTypes")),
    "fmi3.c",
    "fmi3_absent.c",
)
C_SOURCES = (*SLAVE, *SLAVE3, "compiled.c")
LOWERING = ("lowering.py", "runtime.ll")
COMPILING = ("compiler.py", "universal.py")
LIBRARY, MADE_BY, KERNELS = "library", "made_by.txt", "kernels.ll"  # file names
ENTRY = "@kernel_"  # begins the names of lowered functions


@dataclass(frozen=True)
class Engine:
    """A shared library, and the names and versions of the compilers that made it."""

    library: bytes
    made_by: str

    @classmethod
    def read(cls, folder: Path) -> Engine:
        """Return the engine from a folder that `write` made."""
        return cls((folder / LIBRARY).read_bytes(), (folder / MADE_BY).read_text(encoding="utf-8"))

    def write(self, folder: Path) -> None:
        """Write the engine into a new folder atomically; a damaged engine there is replaced."""

        def fill(stage: Path) -> None:
            (stage / LIBRARY).write_bytes(self.library)
            (stage / MADE_BY).write_text(self.made_by, encoding="utf-8")

        keep(folder, fill)


def engine_key(models: Sequence[Kernels]) -> str:
    """Return an identifier of 32 hexadecimal digits that changes only if the code of the kernels or the slave changes.

    Computing it requires neither numba nor the C compiler.
    """
    return digest_of([_kernels(model) for model in models], *C_SOURCES, *LOWERING, *COMPILING)


def engine(models: Sequence[Kernels], platform: str) -> Engine:
    """Return the engine of these models for one of `TARGETS`.

    Raises
    ------
    ValueError
        If the engine must be compiled but a compiler is missing, or if a kernel needs Python when it runs.
    """
    return find_or_compile(engine_place(models, platform), lambda: _compile(models, platform))


def find_or_compile(place: Path, compile_anew: Callable[[], Engine]) -> Engine:
    """Return the shipped or cached engine at a relative path; if there is none, compile it and cache it.

    Damaged engines are ignored. Each compilation is logged when it is done.
    """
    result = _existing(place)
    if result is not None:
        return result
    with compiling(_cached(place), f"engine {place.name}"):
        result = _existing(place)
        if result is None:
            began = time.monotonic()
            result = compile_anew()
            name, platform = place.name.rpartition("-")[0] or place.name, place.parent.name
            log.info("compiled %s for %s in %.0f s", name, platform, time.monotonic() - began)
            with suppress(OSError):  # without a cache the next build takes as long
                result.write(_cached(place))
    return result


def engine_at_hand(models: Sequence[Kernels], platform: str) -> Engine | None:
    """Return the engine of these models if it is shipped or cached, otherwise None; nothing is compiled."""
    return _existing(engine_place(models, platform))


def _existing(place: Path) -> Engine | None:
    undamaged = (folder for folder in (SHIPPED / place, _cached(place)) if is_undamaged(folder))
    return next(map(Engine.read, undamaged), None)


def _cached(place: Path) -> Path:
    return _cache() / "engines" / place


def engine_place(models: Sequence[Kernels], platform: str) -> Path:
    """Return the path of the engine of these models, relative to the folder of all engines."""
    return Path(platform, f"{_name(models)}-{engine_key(models)}")


def engine_sources(models: Sequence[Kernels]) -> dict[str, str]:
    """Return the sources of an engine by file name: the slave, the key, and the lowered kernels of each model."""
    return texts_of(C_SOURCES) | key_header(models) | {f"{m.name}.ll": lowered_kernels(m) for m in models}


def key_header(models: Sequence[Kernels]) -> dict[str, str]:
    """Return the header that contains an engine's key and the names of its models, by file name."""
    named = "".join(f" M({model.name})" for model in models)
    return {"engine_key.h": f'#define ENGINE_KEY "{engine_key(models)}"\n#define MODELS(M){named}\n'}


def lowered_kernels(model: Kernels) -> str:
    """Return the LLVM assembly of a model's kernels, `<name>_initialise` and `<name>_step`."""
    return _lowered(model).replace(ENTRY, f"@{model.name}_")


def _name(models: Sequence[Kernels]) -> str:
    return "-".join(model.name for model in models)


def _compile(models: Sequence[Kernels], platform: str) -> Engine:
    purpose = (
        f"the engine of {_name(models)} for {platform} is not compiled yet (flavour python needs no engine); "
        "compiling it"
    )
    require_extra("native", purpose, "numba", "ziglang")
    check_compiler()
    library = compile_library(models[0].name, engine_sources(models), platform)
    return Engine(library, "numba {numba}, ziglang {ziglang}".format(**_versions("numba", "ziglang")))


def _lowered(model: Kernels) -> str:
    """Return the lowered kernels, from the user's cache if possible; they are the same for all platforms."""
    facts = [_kernels(model), _versions("numba", "llvmlite"), machine()]
    folder = _cache() / f"kernels-{model.name}-{digest_of(facts, *LOWERING)}"
    with compiling(folder, f"the kernels of {model.name}"):
        if is_undamaged(folder):
            return (folder / KERNELS).read_bytes().decode()
        assembly = lower(model)
        with suppress(OSError):
            keep(folder, lambda stage: (stage / KERNELS).write_bytes(assembly.encode()))
    return assembly


def _kernels(model: Kernels) -> list[object]:
    """Return the facts on which the machine code of the kernels depends."""
    functions = [getattr(kernel, "py_func", kernel) for kernel in (model.initialise, model.step)]
    return [model.name, [f"{f.__module__}.{f.__qualname__}" for f in functions], digests(model.packages)]


def _versions(*names: str) -> dict[str, str]:
    return {name: importlib.metadata.version(name) for name in names}


def _cache() -> Path:
    return user_cache()
