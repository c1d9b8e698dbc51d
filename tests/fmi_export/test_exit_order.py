"""A process that ran an FMU ends without touching freed memory.

Nothing of this is visible in an ordinary run: one word of the heap's free lists is off by one, and the process
aborts only if that list is used again. The Python host is therefore made to die of it. A C host does so unaided; see
`test_guard_hosts`.
"""

import platform

import pytest

pytestmark = pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="exit order and heap are those of glibc")


def run_between_deadly_handlers(path: str, hidden: list, release: bool) -> list:
    import ctypes

    from hide import hide

    hide(*hidden)
    libc = ctypes.CDLL(None)
    libc.wcsdup.argtypes, libc.wcsdup.restype = [ctypes.c_wchar_p], ctypes.c_void_p
    # Copies of this text take the place of what the FMU freed at exit: whoever releases that again finds a
    # reference count of 1 and calls a destructor through a pointer to nowhere.
    ones = libc.wcsdup("\x01" * 33)
    for _ in range(64):
        libc.__cxa_atexit(ctypes.cast(libc.wcsdup, ctypes.c_void_p), ctypes.c_void_p(ones), None)
    from raw import Library

    library = Library(path)
    instances = [library.instantiate().begin(u=1.0) for _ in range(3)]
    statuses = [fmu.step(0) for fmu in instances]
    for fmu in instances if release else []:
        fmu.free()
    return statuses


@pytest.mark.parametrize("hidden", [[], ["probe_lag", "fmi_export", "numba"]], ids=["installed", "shipped"])
@pytest.mark.parametrize("release", [True, False], ids=["freed", "alive"])
def test_a_python_host_ends_without_releasing_freed_memory(build_fmu, lag, run_python, monkeypatch, hidden, release):
    monkeypatch.setenv("GLIBC_TUNABLES", "glibc.malloc.tcache_count=60000")  # what is freed last is used next
    statuses = run_python(run_between_deadly_handlers, path=build_fmu(lag), hidden=hidden, release=release)
    assert statuses == [0, 0, 0]
