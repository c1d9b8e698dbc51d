"""A process that ran an FMU ends without touching freed memory, in a Python host and in one without Python.

Nothing of this is visible in an ordinary run: one word of the heap's free lists is off by one, and the process
aborts only if that list is used again. The Python host is therefore made to die of it. A C host does so unaided.
"""

import os
import platform
import shutil
import subprocess
import sys
import sysconfig
import zipfile
from pathlib import Path
from xml.etree import ElementTree

import pytest

pytestmark = pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="exit order and heap are those of glibc")

LIBPYTHON = Path(sysconfig.get_config_var("LIBDIR") or "", sysconfig.get_config_var("INSTSONAME") or "")

# Loads an FMU, steps once, frees it and returns from main.
C_HOST = r"""
#include <dlfcn.h>
#include <stdlib.h>
static void logger(void *e, const char *n, int s, const char *c, const char *m, ...) {}
static struct { void (*log)(void *, const char *, int, const char *, const char *, ...);
                void *(*calloc)(size_t, size_t); void (*free)(void *); void *finished, *environment;
} callbacks = {logger, calloc, free, NULL, NULL};
int main(int n, char **argument) {
    if (!dlopen(argument[1], RTLD_NOW | RTLD_GLOBAL)) return 10;
    void *fmu = dlopen(argument[2], RTLD_NOW);
    if (!fmu) return 11;
    void *(*instantiate)() = (void *(*)())dlsym(fmu, "fmi2Instantiate");
    int (*enter)(void *) = (int (*)(void *))dlsym(fmu, "fmi2EnterInitializationMode");
    int (*leave)(void *) = (int (*)(void *))dlsym(fmu, "fmi2ExitInitializationMode");
    int (*step)(void *, double, double, int) = (int (*)(void *, double, double, int))dlsym(fmu, "fmi2DoStep");
    void (*release)(void *) = (void (*)(void *))dlsym(fmu, "fmi2FreeInstance");
    void *instance = instantiate("lag", 1, argument[3], argument[4], &callbacks, 0, 0);
    if (!instance) return 12;
    if (enter(instance) || leave(instance) || step(instance, 0.0, 250e-6, 1)) return 13;
    release(instance);
    dlclose(fmu);
    return 0;
}
"""


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
    from drive import Fmu

    instances = [Fmu(path, u=1.0) for _ in range(3)]
    statuses = [fmu.step(0) for fmu in instances]
    for fmu in instances if release else []:
        fmu.close()
    return statuses


@pytest.mark.parametrize("hidden", [[], ["probe_lag", "fmi_export", "numba"]], ids=["installed", "shipped"])
@pytest.mark.parametrize("release", [True, False], ids=["freed", "alive"])
def test_a_python_host_ends_without_releasing_freed_memory(build_fmu, lag, run_python, monkeypatch, hidden, release):
    monkeypatch.setenv("GLIBC_TUNABLES", "glibc.malloc.tcache_count=60000")  # what is freed last is used next
    statuses = run_python(run_between_deadly_handlers, path=build_fmu(lag), hidden=hidden, release=release)
    assert statuses == [0, 0, 0]


@pytest.mark.skipif(not shutil.which("cc"), reason="needs a C compiler")
@pytest.mark.skipif(not LIBPYTHON.is_file(), reason="needs Python as a shared library")
def test_a_host_without_python_ends_cleanly(build_fmu, lag, tmp_path):
    (tmp_path / "host.c").write_text(C_HOST)
    subprocess.run(["cc", "-std=gnu11", "-w", "-o", "host", "host.c", "-ldl"], cwd=tmp_path, check=True)
    with zipfile.ZipFile(build_fmu(lag)) as archive:
        archive.extractall(tmp_path / "fmu")
    fmu = tmp_path / "fmu"
    guid = ElementTree.parse(fmu / "modelDescription.xml").getroot().get("guid")
    paths = [sysconfig.get_path("purelib"), sysconfig.get_path("platlib")]
    for _ in range(3):
        process = subprocess.run(
            ["./host", LIBPYTHON, fmu / "binaries" / "linux64" / "probe_lag.so", guid, (fmu / "resources").as_uri()],
            cwd=tmp_path,
            env={**os.environ, "PYTHONHOME": sys.base_prefix, "PYTHONPATH": os.pathsep.join(dict.fromkeys(paths))},
            capture_output=True,
            text=True,
            timeout=60,
            check=False,
        )
        assert process.returncode == 0, process.stderr
