"""Hosts without Python that load an FMU of flavour python: it starts Python, or logs why it cannot."""

import os
import platform
import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path
from urllib.parse import quote_from_bytes

import numpy as np
import pytest
from hosts import HEADERS, SUPPORT, binary_of, run
from instances import initialised

from fmi_export.building.native.compiler import host_platform
from tests.support.messages import assert_names

LIBPYTHON = Path(sysconfig.get_config_var("LIBDIR") or "", sysconfig.get_config_var("INSTSONAME") or "")
H = 250e-6

pytestmark = [
    pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="hosts are built and run on Linux"),
    pytest.mark.skipif(not shutil.which("cc"), reason="needs a C compiler"),
    pytest.mark.skipif(
        not (LIBPYTHON.is_file() and ".so" in LIBPYTHON.name), reason="needs Python as a shared library"
    ),
]

# Loads the FMU several times, makes two instances each time, and leaves one alive; a library that is named first is
# loaded for this program alone.
ROUNDS = r"""
#include <dlfcn.h>
#include <stdlib.h>
static void logger(void *e, const char *n, int s, const char *c, const char *m, ...) {}
static struct { void (*log)(void *, const char *, int, const char *, const char *, ...);
                void *(*calloc)(size_t, size_t); void (*free)(void *); void *finished, *environment;
} callbacks = {logger, calloc, free, NULL, NULL};
int main(int n, char **argument) {
    if (n > 4 && !dlopen(argument[4], RTLD_NOW | RTLD_LOCAL)) return 10;
    for (int round = 0; round < 3; round++) {
        void *fmu = dlopen(argument[1], RTLD_NOW), *instances[2];
        if (!fmu) return 11;
        void *(*instantiate)() = (void *(*)())dlsym(fmu, "fmi2Instantiate");
        int (*enter)(void *) = (int (*)(void *))dlsym(fmu, "fmi2EnterInitializationMode");
        int (*leave)(void *) = (int (*)(void *))dlsym(fmu, "fmi2ExitInitializationMode");
        int (*step)(void *, double, double, int) = (int (*)(void *, double, double, int))dlsym(fmu, "fmi2DoStep");
        void (*release)(void *) = (void (*)(void *))dlsym(fmu, "fmi2FreeInstance");
        for (int i = 0; i < 2; i++) {
            void *instance = instances[i] = instantiate("lag", 1, argument[2], argument[3], &callbacks, 0, 0);
            if (!instance) return 12;
            if (enter(instance) || leave(instance) || step(instance, 0.0, 250e-6, 1)) return 13;
        }
        release(instances[1]);
        if (round != 1) release(instances[0]);
        dlclose(fmu);
    }
    return 0;
}
"""


@pytest.fixture(scope="module")
def compiled(tmp_path_factory):
    """`compiled(source, *options)`: path of what the C compiler makes of a file."""
    folder = tmp_path_factory.mktemp("hosts")

    def compile_file(source: Path, *options: str) -> Path:
        command = ["cc", "-std=gnu11", "-w", f"-I{HEADERS}", *options, source, "-o", folder / source.stem, "-ldl"]
        subprocess.run(command, check=True)
        return folder / source.stem

    return compile_file


@pytest.fixture(scope="module")
def host(compiled):
    return compiled(SUPPORT / "host.c")


@pytest.fixture
def fmu_copy(fmu, tmp_path):
    """A copy of the FMU for changes."""
    return shutil.copytree(fmu, tmp_path / "fmu")


def without_python(command: list, *arguments: object, program: list, **environment: str) -> tuple[list, str]:
    """Run a host with nothing in its environment that names a Python; return its answers and its log."""
    return run(command, *arguments, program=program, env={"PATH": os.defpath, "HOME": "/nonexistent", **environment})


@pytest.mark.parametrize("loaded", [[], [LIBPYTHON]], ids=["no Python", "a Python of its own"])
def test_a_host_without_python_runs_instances_and_ends_cleanly(fmu, compiled, tmp_path, loaded):
    (tmp_path / "rounds.c").write_text(ROUNDS)
    environment = {"PYTHONPATH": sysconfig.get_path("purelib"), "PYTHONHOME": sys.base_prefix} if loaded else {}
    without_python([compiled(tmp_path / "rounds.c")], *binary_of(fmu), *loaded, program=[], **environment)


def test_a_host_without_python_gets_the_numbers_of_the_core(fmu, host, lag):
    core = initialised(lag, np.zeros(1), {"u": 1.0})
    for n in range(8):
        core.step(n * H, H)
    begin = ["new 0", "real 0 3 1.0", "setup 0 0", "enter 0", "exit 0", "step 0 0 5 0.00025", "save 0"]
    rest = ["step 0 5 3 0.00025", "read 0 5", "restore 0", "step 0 5 3 0.00025", "read 0 5", "terminate 0", "free 0"]
    answers, log = without_python([host], *binary_of(fmu), program=begin + rest)
    assert {answer[0] for answer in answers} == {"0"}, log
    assert [float.fromhex(answer[1]) for answer in answers if "x" in answer[-1]] == [core["y"]] * 2


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2])
def test_any_calls_with_any_arguments_are_survived(fmu, host, seed):
    without_python([host], *binary_of(fmu), program=[f"fuzz {seed} 3000"])


def refusal(*command: object, **environment: str) -> str:
    """Return why a host gets no instance."""
    answers, log = without_python(list(command), program=["new 0"], **environment)
    assert answers == [["3"]], "no instance"
    assert log.startswith("fmu0 3 logStatusError ")
    return log


def test_without_python_no_instance_is_made_and_the_reason_is_logged(fmu_copy, host, compiled, tmp_path):
    (tmp_path / "fake.c").write_text("int nothing;\n")
    (tmp_path / "fake").mkdir()
    shutil.move(compiled(tmp_path / "fake.c", "-shared", "-fPIC"), tmp_path / "fake" / "libpython3.40.so.1.0")
    (fmu_copy / "resources" / "python.txt").write_text("/nowhere/libpython.so\n/nowhere/python")
    text = refusal(host, *binary_of(fmu_copy), LD_LIBRARY_PATH=str(tmp_path / "fake"))
    assert_names(text, "Python", "/nowhere/libpython.so")
    assert "LD_LIBRARY_PATH" in text
    assert "flavour native" in text


def test_a_python_without_numpy_is_named_as_the_reason(fmu_copy, host, tmp_path):
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", tmp_path / "bare"], check=True)
    program = tmp_path / "bare" / "bin" / "python"
    (fmu_copy / "resources" / "python.txt").write_text(f"{LIBPYTHON}\n{program}")
    assert "No module named 'numpy'" in refusal(host, *binary_of(fmu_copy))


def test_a_missing_library_of_pythonfmu_is_named_as_the_reason(fmu_copy, host):
    library = fmu_copy / "binaries" / host_platform() / "probe_lag_pythonfmu.so"
    library.unlink()
    text = refusal(host, *binary_of(fmu_copy))
    assert_names(text, "PythonFMU's library")
    assert str(library) in text


def test_a_wrong_library_in_place_of_pythonfmu_is_named_as_the_reason(fmu_copy, host, compiled, tmp_path):
    (tmp_path / "other.c").write_text("int fmi2Instantiate;\n")
    library = fmu_copy / "binaries" / host_platform() / "probe_lag_pythonfmu.so"
    shutil.copy(compiled(tmp_path / "other.c", "-shared", "-fPIC"), library)
    text = refusal(host, *binary_of(fmu_copy))
    assert_names(text, str(library), "PythonFMU")


@pytest.mark.parametrize("name", [b"Gr\xf6\xdfe", b"\xc3", b"\xe2\x82", b"\xf0\x9f\x98a", b"\x80", b"\xff"])
def test_a_folder_whose_name_is_not_utf_8_is_named_as_the_reason(fmu, host, tmp_path, name):
    shutil.copytree(os.fsencode(fmu / "resources"), os.fsencode(tmp_path) + b"/" + name)
    library, guid, _ = binary_of(fmu)
    text = refusal(host, library, guid, f"{tmp_path.as_uri()}/{quote_from_bytes(name)}")
    assert_names(text, "PythonFMU", "UTF-8")


def test_without_a_recorded_python_an_fmu_uses_another(fmu_copy, host):
    (fmu_copy / "resources" / "python.txt").unlink()
    where = {"LD_LIBRARY_PATH": str(Path(LIBPYTHON).parent), "PYTHONPATH": sysconfig.get_path("purelib")}
    program = ["new 0", "setup 0 0", "enter 0", "exit 0", "free 0"]
    answers, log = without_python([host], *binary_of(fmu_copy), program=program, PYTHONHOME=sys.base_prefix, **where)
    assert answers == [["0"]] * 5, log


@pytest.mark.slow
@pytest.mark.parametrize(
    ("failing", "answers", "sentence"),
    [
        (4, "3 3 3 3 3", "there is no memory for another instance"),
        (6, "3 3 3 3 3", "there is no memory for the path of the resources"),
        (7, "3 3 3 3 3", "there is no memory for another instance"),
        (11, "3 3 3 3 3", "slavemodule.txt: Cannot allocate memory"),
        (14, "0 0 0 3 3", "fmi2GetFMUstate: there is no memory for a state"),
        (16, "0 0 0 0 3", "fmi2DeSerializeFMUstate: there is no memory for a state"),
    ],
)
def test_a_failed_allocation_is_an_error_with_the_reason(fmu, host, compiled, failing, answers, sentence):
    memory = compiled(SUPPORT / "failing_memory.c", "-shared", "-fPIC", "-O1")
    environment = {"LD_PRELOAD": str(memory), "LIBRARY": "/probe_lag.so", "FAILING": str(failing)}
    program = [f"{line} 0" for line in ("new", "enter", "exit", "save", "bytes", "free")]
    found, log = without_python([host], *binary_of(fmu), program=program, **environment)
    assert " ".join(answer[0] for answer in found) == f"{answers} 0"
    assert sentence in log
