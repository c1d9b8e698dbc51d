"""The compiled loop as a shared library: shipped in the installed package, or compiled once into the user's cache.

It contains the loop (`loop.c`), its FMI 3.0 calls (`binding3.c`), and the code that steps from a saved state
(`answers.c`).
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import nullcontext
from ctypes import CDLL, c_double, c_ssize_t, c_void_p
from functools import cache
from pathlib import Path

from amb_files.stored_folder import is_undamaged, keep
from amb_files.user_cache import user_cache
from fmi_export.building.native.compiler import PLATFORMS, compile_library, host_platform
from fmi_export.building.native.sources import digest_of, texts_of
from fmi_export.compiling import compiling

SOURCES = ("loop.c", "loop.h")  # of every engine too
LOCAL_SOURCES = ("answers.c", "binding3.c")  # beside this file
SHIPPED = Path(__file__).parent / "loops"  # in an installed package


def load_loop() -> Callable[..., None] | None:
    """Return the library's function `advance`, or None if there is neither a library nor a compiler."""
    library = load_library()
    return None if library is None else library.advance


@cache
def load_library() -> CDLL | None:
    """Return the library, or None if there is neither a library nor a compiler."""
    try:
        place = loop_place(host_platform())
        path = SHIPPED / place
        if not path.is_file():
            folder = user_cache() / "loops" / place.with_suffix("")
            with nullcontext() if is_undamaged(folder) else compiling(folder, "the loop"):
                keep(folder, lambda stage: (stage / place.name).write_bytes(compile_loop(host_platform())))
            path = folder / place.name
        library = CDLL(str(path))
    except (OSError, ValueError):
        return None
    address, number = c_void_p, c_ssize_t
    library.advance.argtypes = (*[address] * 4, *[number] * 4, address, address)
    library.advance.restype = None
    library.answers.argtypes = (*[address] * 7, c_double, c_double, number, *(number, address, address) * 2)
    library.answers.restype = number
    return library


def loop_place(platform: str) -> Path:
    """Return the path of the library for a platform, relative to the common folder."""
    return Path(platform, f"loop-{digest_of(_local_sources(), *SOURCES)}{PLATFORMS[platform][0]}")


def compile_loop(platform: str) -> bytes:
    """Compile the loop for a platform.

    Raises
    ------
    ValueError
        If no such platform exists, or the compiler is missing.
    """
    return compile_library("loop", texts_of(SOURCES) | _local_sources() | {"loop_library.h": ""}, platform)


def _local_sources() -> dict[str, str]:
    return {name: Path(__file__).with_name(name).read_text(encoding="utf-8") for name in LOCAL_SOURCES}
