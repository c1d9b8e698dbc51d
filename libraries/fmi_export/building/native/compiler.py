"""Compiles sources, with `ziglang`'s C compiler, to shared libraries for every platform and to WebAssembly."""

from __future__ import annotations

import importlib
import importlib.metadata
import os
import platform
import re
import subprocess
import sys
from collections.abc import Iterable, Mapping
from contextlib import suppress
from functools import cache
from pathlib import Path

import platformdirs

from amb_files.temporary_folders import temporary_folder
from amb_files.user_cache import is_private
from fmi_export.building.extras import require_extra
from fmi_export.building.native.universal import universal

# FMI 2.0.4 platform folder: suffix of its libraries, and the targets in a single library.
PLATFORMS: dict[str, tuple[str, tuple[str, ...]]] = {
    "linux64": (".so", ("x86_64-linux-gnu.2.17",)),
    "win64": (".dll", ("x86_64-windows-gnu",)),
    "darwin64": (".dylib", ("x86_64-macos.11.0", "aarch64-macos.11.0")),
    "aarch64-linux": (".so", ("aarch64-linux-gnu.2.17",)),
    "aarch64-darwin": (".dylib", ("aarch64-macos.11.0",)),
}

# WebAssembly is for no machine, and `all` omits it; its imports from WASI open files, and may fail.
WASM = "wasm32"
TARGETS = PLATFORMS | {WASM: (".wasm", ("wasm32-wasi",))}

# The same in FMI 3.0, where a universal macOS library has two folders.
FOLDERS3 = {
    "linux64": ("x86_64-linux",),
    "win64": ("x86_64-windows",),
    "darwin64": ("x86_64-darwin", "aarch64-darwin"),
    "aarch64-linux": ("aarch64-linux",),
    "aarch64-darwin": ("aarch64-darwin",),
    WASM: ("wasm32-wasi",),
}

ZIG_CACHE = "ZIG_GLOBAL_CACHE_DIR"  # environment variable

LIBRARY_OPTIONS = ("-shared",)
MODULE_OPTIONS = (
    "-msimd128",  # SIMD, as on 64-bit processors; in browsers since 2023
    "-mexec-model=reactor",  # a library: no main function
    "-Wl,--export-dynamic,--export=malloc,--export=free",
    "-Wl,--export-table,--growable-table",  # where a host adds its logger
    "-Wl,-z,stack-size=262144",
)
OPTIONS = (
    "-O2",
    "-std=c11",
    "-s",  # no names of functions, no paths
    "-fvisibility=hidden",
    "-ffp-contract=off",  # product and sum are rounded separately on every processor
    "-fno-sanitize=all",
    "-Wno-override-module",  # the module of the kernels has no target of its own
)


def host_platform() -> str:
    """Return the platform of this machine.

    Raises
    ------
    ValueError
        If native FMUs do not support this machine.
    """
    here = (sys.platform, platform.machine().lower())
    names = {
        ("linux", "x86_64"): "linux64",
        ("win32", "amd64"): "win64",
        ("darwin", "x86_64"): "darwin64",
        ("darwin", "arm64"): "darwin64",  # a library for both processors; importers look there first
        ("linux", "aarch64"): "aarch64-linux",
    }
    if here not in names:
        raise ValueError(f"there is no native FMU for {' '.join(here)}; native FMUs exist for {', '.join(PLATFORMS)}")
    return names[here]


def check_platforms(platforms: Iterable[str]) -> list[str]:
    """Return `platforms` without repetition and in the order of `TARGETS`; `all` stands for all `PLATFORMS`.

    Raises
    ------
    ValueError
        If no platform is given, or a platform is unknown.
    """
    wanted = set(platforms)
    unknown = sorted(wanted - {*TARGETS, "all"})
    if unknown or not wanted:
        what = f"no platform {', '.join(unknown)}" if unknown else "no platform was named"
        raise ValueError(f"{what}; choose from {', '.join(PLATFORMS)}, all (every one of these) and {WASM}")
    return [name for name in TARGETS if name in wanted or (name in PLATFORMS and "all" in wanted)]


def compile_library(name: str, sources: Mapping[str, str], target_platform: str) -> bytes:
    """Compile sources, given by file name, to the shared library `name` for one of `TARGETS`.

    Raises
    ------
    ValueError
        If the compiler is missing, if its LLVM version differs from numba's, or if it rejects the sources.
    """
    check_compiler()
    suffix, targets = TARGETS[target_platform]
    kind = MODULE_OPTIONS if target_platform == WASM else LIBRARY_OPTIONS
    with temporary_folder() as folder:
        for file, text in sources.items():
            (folder / file).write_text(text, encoding="utf-8", newline="\n")
        inputs = sorted(f"../{file}" for file in sources if not file.endswith(".h"))
        links = ["-lm", "-ldl"] if "linux" in target_platform else ["-lm"]
        slices = []
        for target in targets:
            (folder / target).mkdir()
            _zig(["-target", target, *kind, *OPTIONS, "-o", f"{name}{suffix}", *inputs, *links], folder / target)
            slices.append((folder / target / f"{name}{suffix}").read_bytes())
    return slices[0] if len(slices) == 1 else universal(slices)


@cache
def check_compiler() -> str:
    """Return the version of the installed `ziglang`.

    Raises
    ------
    ValueError
        If `ziglang` is missing, or its LLVM version differs from numba's.
    """
    require_extra("native", "compiling an engine", "ziglang")
    ours = int(importlib.import_module("llvmlite.binding").llvm_version_info[0])
    with temporary_folder() as folder:
        result = re.search(r"clang version (\d+)", _zig(["--version"], folder))
    theirs = int(result[1]) if result else 0
    if ours != theirs:
        raise ValueError(
            f"numba writes code for LLVM {ours}, but the installed ziglang reads LLVM {theirs}; "
            f"install a ziglang with LLVM {ours} or a numba with LLVM {theirs}"
        )
    return importlib.metadata.version("ziglang")


def _zig(arguments: list[str], folder: Path) -> str:
    process = subprocess.run(
        [sys.executable, "-P", "-m", "ziglang", "cc", *arguments],
        cwd=folder,
        env=os.environ | _cache(folder),
        capture_output=True,
        text=True,
        check=False,
    )
    if process.returncode != 0:
        raise ValueError(f"zig cc failed: {process.stderr.strip()[-2000:]}")
    return process.stdout


def _cache(folder: Path) -> dict[str, str]:
    """Return zig's cache variable with a path in `folder`; empty if the variable is set or the usual cache is safe."""
    usual = platformdirs.user_cache_path("zig", appauthor=False)
    with suppress(OSError):
        usual.mkdir(parents=True, exist_ok=True)
    if ZIG_CACHE in os.environ or (os.access(usual, os.W_OK) and is_private(usual)):
        return {}
    return {ZIG_CACHE: str(folder / "cache")}
