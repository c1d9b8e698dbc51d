"""Guards: native slaves that run kernels through PythonFMU's library; one guard per platform serves all models."""

from __future__ import annotations

import importlib.metadata
from collections.abc import Iterable
from pathlib import Path

from fmi_export.building.extras import require_extra
from fmi_export.building.native.compiler import PLATFORMS, compile_library
from fmi_export.building.native.engines import COMPILING, SLAVE, Engine, find_or_compile
from fmi_export.building.native.sources import digest_of, texts_of

SOURCES = ("pythonfmu.h", "system.h", "interpreted.c", "pythonfmu.c")
# Platforms of PythonFMU: the code for their operating system.
SYSTEMS = {"linux64": "linux.c", "win64": "windows.c"}


def guard_key() -> str:
    """Return an identifier of 32 hexadecimal digits that changes only if the code of the guard changes."""
    return digest_of(SYSTEMS, *SLAVE, *_beside(*SOURCES, *SYSTEMS.values()), *COMPILING)


def guard(platform: str) -> Engine:
    """Return the guard for one of `SYSTEMS`.

    Raises
    ------
    ValueError
        If the guard must be compiled, but no compiler is installed.
    """
    return find_or_compile(guard_place(platform), lambda: _compile(platform))


def guard_place(platform: str) -> Path:
    """Return the path of the guard, relative to the folder of all engines."""
    return Path(platform, f"guard-{guard_key()}")


def check_guarded(platforms: Iterable[str]) -> list[str]:
    """Return `platforms` without repetition, in the order of `SYSTEMS`; `all` means every platform.

    Raises
    ------
    ValueError
        If no platform is given, or if PythonFMU has no library for a given platform.
    """
    wanted = set(platforms)
    unknown = sorted(wanted - {*SYSTEMS, "all"})
    if unknown or not wanted:
        what = f"PythonFMU has no library for {', '.join(unknown)}" if unknown else "no platform was named"
        raise ValueError(f"{what}; for flavour python, choose from {', '.join(SYSTEMS)} and all (every one of these)")
    return [name for name in SYSTEMS if wanted & {name, "all"}]


def _compile(platform: str) -> Engine:
    require_extra(
        "native", f"the guard for FMUs of flavour python is not compiled for {platform} yet; compiling it", "ziglang"
    )
    sources = texts_of(SLAVE + _beside(*SOURCES, SYSTEMS[platform]))
    sources["engine_key.h"] = f'#define ENGINE_KEY "{guard_key()}"\n'
    library = compile_library("guard", sources, platform)
    return Engine(library, f"ziglang {importlib.metadata.version('ziglang')}")


def _beside(*names: str) -> tuple[str, ...]:
    return tuple(f"../{Path(__file__).parent.name}/{name}" for name in names)


def library_names(model: str, platform: str) -> tuple[str, str]:
    """Return the paths of the guard and of PythonFMU's library in an FMU."""
    suffix = PLATFORMS[platform][0]
    return f"binaries/{platform}/{model}{suffix}", f"binaries/{platform}/{model}_pythonfmu{suffix}"
