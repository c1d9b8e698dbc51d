"""The one decorator of every model kernel: compiled where numba is installed, plain Python elsewhere."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from hashlib import sha256
from io import BytesIO
from pathlib import Path
from typing import Any, TypeVar, cast

from fmi_export.amb_cosim_bootstrap import digest, find

F = TypeVar("F", bound=Callable[..., Any])

DIGEST_SIZE = sha256().digest_size

try:
    import numba
    import numba.extending

    COMPILED = not cast(Any, numba.config).DISABLE_JIT
except ImportError:  # the kernels are ordinary Python too, only slower
    COMPILED = False


def kernel(function: F) -> F:
    """Compile `function` in numba's nopython mode, with IEEE division and an on-disk cache where one can be written.

    A kernel takes flat float64 arrays and scalars, allocates nothing and raises nothing: the same source is
    later compiled into FMUs that need no Python. It is compiled without numba's run-time system (`_nrt`): allocating
    is then an error of compilation, and no time goes into counting references to arrays, which is most of it otherwise.
    """
    return _compiled(function)


def inlined_kernel(function: F) -> F:
    """Compile `function` as `kernel` does, into each place that calls it.

    A call copies all the arrays of its arguments, seven or nine numbers each: more work than a short kernel has.
    """
    return _compiled(function, forceinline=True)


def kernel_apart(function: F) -> F:
    """Compile `function` as `kernel` does, and keep it out of the code of its callers in native FMUs.

    For what few steps do: beside it, what every step does would have fewer registers and longer ways.
    """
    KERNELS_APART.add((*function.__module__.split("."), *function.__qualname__.split(".")))
    return _compiled(function)


KERNELS_APART: set[tuple[str, ...]] = set()


def _compiled(function: F, **options: bool) -> F:
    if not COMPILED:
        return function
    with _cache_of(function.__module__.split(".")[0]):
        settings: dict[str, Any] = {"error_model": "numpy", "_nrt": False} | options
        try:
            return cast(F, _tolerant(numba.njit(cache=True, **settings)(function)))
        except RuntimeError:  # no folder can be written, neither the package's nor the user's
            return cast(F, numba.njit(**settings)(function))


def _tolerant(dispatcher: Any) -> Any:
    """Let numba compile anew what is damaged in the cache, and go on where the cache is full."""
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


def views(function: F) -> F:
    """Let kernels call `function`, which hands out views into its arguments; called from Python it stays Python.

    So does a formula that Python needs too. It becomes part of its callers. A kernel cannot give a view to Python: it
    does not own the memory.
    """
    return numba.extending.register_jitable(inline="always")(function) if COMPILED else function


@contextmanager
def _cache_of(package: str) -> Iterator[None]:
    """Let numba cache in a folder named after all the code a kernel may call.

    By itself numba notices a change of the file a function is in, but not of what it calls in other files,
    and would go on running old machine code after an upgrade. A package whose kernels call those of others names these
    packages in `KERNELS_FROM`.
    """
    config: Any = numba.config
    before = config.CACHE_DIR
    folder = _cache_folder(package, before)
    if folder:
        config.CACHE_DIR = folder
    try:
        yield
    finally:
        config.CACHE_DIR = before


@cache
def _cache_folder(package: str, base: str) -> str:
    """Folder below `base`, or below the package's own `__pycache__`; empty where nothing can be written."""
    here = Path(__file__).parent
    loaded = sys.modules.get(package)
    own = Path(loaded.__file__).parent if loaded is not None and loaded.__file__ else here
    parent = Path(base) if base else own / "__pycache__"
    others = (find(name) for name in getattr(loaded, "KERNELS_FROM", ()))
    called = "".join(f"{digest(other)[:16]}-" for other in others if other is not None)
    folder = parent / f"kernels-{digest(own)[:16]}-{called}{digest(here)[:16]}"
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return ""
    return str(folder)
