"""A host without Python: it runs the FMU on this machine, under sanitizers and valgrind, and on other platforms."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hosts import HEADERS, SUPPORT, binary_of, run

from fmi_export.building.native.compiler import PLATFORMS, host_platform
from fmi_export.model import Instance
from tests.support.messages import assert_names

H = 250e-6

pytestmark = [
    pytest.mark.usefixtures("compiler"),
    pytest.mark.skipif(sys.platform != "linux", reason="hosts are built and run on Linux"),
]


def build_host(cc, target, path):
    libraries = [] if "windows" in target else ["-ldl", "-lpthread"]
    options = ["-target", target, "-std=gnu11", "-O1", "-Wno-everything", f"-I{HEADERS}"]
    cc(*options, SUPPORT / "host.c", "-o", path, *libraries)
    return path


@pytest.fixture(scope="module")
def host(cc, tmp_path_factory):
    return build_host(cc, PLATFORMS[host_platform()][1][0], tmp_path_factory.mktemp("host") / "host")


class Program:
    """Lines for the host that run a model, and the results of the core for the same."""

    def __init__(self, model, constants, start, blocks, every, restart=False):
        self.table = model.interface
        self.reals = [i for i, v in enumerate(self.table.variables) if v.causality == "output" and v.type == "Real"]
        self.core = Instance(model, constants)
        self.expected = []
        self.lines = ["new 0", "new 1", "setup 0 0"]
        for name, value in start.items():
            self.core[name] = value
            self.lines.append(self.set(name, value))
        self.core.initialise()
        self.lines += ["enter 0", "exit 0"]
        for block in range(blocks):
            for n in range(block * every, (block + 1) * every):
                self.core.step(n * H, H)
            self.lines += [f"step 0 {block * every} {every} {H!r}", "save 0", "bytes 0", "restore 0", self.read()]
            self.expected.append(self.core.values[self.reals])
        self.lines += ["terminate 0", "reset 0", "free 0", "free 1"]

    def set(self, name, value):
        return f"{self.table[name].type.lower()} 0 {self.table.position[name]} {value!r}"

    def read(self):
        return "read 0 " + " ".join(map(str, self.reals))

    def check(self, answers, tolerance=0.0):
        assert all(answer[0] == "0" for answer in answers), answers
        rows = [[float.fromhex(x) for x in answer[1:]] for answer in answers if len(answer) > 1]
        scale = np.abs(self.expected).max(axis=0) + 1e-300
        if "energy.balance" in self.table.position:  # a small difference of what the energies add up to
            balance, work = (self.reals.index(self.table.position[f"energy.{name}"]) for name in ("balance", "work"))
            scale[balance] = scale[work]
        assert np.max(np.abs(np.array(rows) - self.expected) / scale) <= tolerance


@pytest.fixture(scope="module")
def lag_program(lag):
    return Program(lag, np.zeros(1), {"gain": 3.0, "offset": -2, "u": 1.25}, blocks=10, every=3)


@pytest.fixture(scope="module")
def plant_program(plant, plant_constants):
    start = {"Omega": 260.0, "d1.u": 0.3, "rb1.mu": 0.3, "rb2.mu": 0.3}
    return Program(plant, plant_constants, start, blocks=40, every=50)


@pytest.mark.slow
@pytest.mark.gate
def test_a_host_without_python_follows_the_plant_through_contact(host, unpacked, plant, plant_constants, plant_program):
    answers, _ = run([host], *binary_of(unpacked(plant, plant_constants)), program=plant_program.lines)
    plant_program.check(answers)
    heat = plant_program.reals.index(plant_program.table.position["energy.impact"])
    assert len({row[heat] for row in plant_program.expected}) > 5, "there must be contact"


# Sanitizers and valgrind -----------------------------------------------------------------------------------------


@pytest.mark.slow
def test_sanitizers_find_nothing_in_a_run_and_in_calls_in_any_order(sanitized, lag, lag_program):
    host, *fmu = sanitized(lag, np.zeros(1))
    answers, _ = run([host], *fmu, program=[*lag_program.lines, *(f"fuzz {seed} 100000" for seed in range(1, 6))])
    lag_program.check(answers)


@pytest.mark.slow
def test_sanitizers_find_nothing_in_calls_of_fmi_3_in_any_order(sanitized, matrix):
    host, library, guid, resources = sanitized(matrix, np.zeros(1))
    for seed in range(1, 6):
        command = [host.with_name("fuzz3"), library, guid, resources, str(seed), "100000"]
        process = subprocess.run(command, capture_output=True, text=True, timeout=600, check=False)
        assert process.returncode == 0, f"ended with {process.returncode}: {process.stderr[-3000:]}"


@pytest.mark.slow
def test_sanitizers_find_nothing_in_the_plant(sanitized, plant, plant_constants, plant_program):
    host, *fmu = sanitized(plant, plant_constants)
    answers, _ = run([host], *fmu, program=[*plant_program.lines, "fuzz 7 20000"])
    plant_program.check(answers)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["amb_actuator", "rolac_controller"])
def test_sanitizers_find_nothing_in_calls_of_actuator_and_controller(sanitized, name):
    from amb_cosim.cosim.fmu.fmus import model_source

    host, *fmu = sanitized(*model_source(name))
    run([host], *fmu, program=[f"fuzz {seed} 50000" for seed in range(1, 4)])


@pytest.mark.slow
def test_threads_with_separate_instances_share_nothing(sanitized, lag):
    host, *fmu = sanitized(lag, np.zeros(1), sanitizer="thread")
    run([host], *fmu, program=["threads 8 50000"], env=os.environ | {"TSAN_OPTIONS": "halt_on_error=1"})


@pytest.mark.slow
def test_guided_fuzzing_of_calls_finds_nothing(cc, sanitized, lag, tmp_path):
    """libFuzzer looks for calls that reach new code; what it found before is in `support/corpus`."""
    if not shutil.which("clang"):
        pytest.skip("needs clang with its sanitizers")
    fuzzer, library, guid, resources = sanitized(
        lag, np.zeros(1), compiler="clang", sanitizer="address,undefined,fuzzer"
    )
    shutil.copytree(SUPPORT / "corpus", tmp_path / "corpus")
    seconds = int(os.environ.get("FUZZ_SECONDS", "20"))
    command = [fuzzer, tmp_path / "corpus", f"-max_total_time={seconds}", "-timeout=10", "-max_len=2000"]
    environment = os.environ | {"LIBRARY": str(library), "GUID": guid, "RESOURCES": resources}
    done = subprocess.run(command, env=environment, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-3000:]
    assert int(re.findall(r"cov: (\d+)", done.stderr)[-1]) > 300, done.stderr[-3000:]


@pytest.mark.slow
def test_the_number_of_allocations_does_not_grow_with_the_number_of_steps(host, unpacked, lag):
    if not shutil.which("valgrind"):
        pytest.skip("needs valgrind")

    def allocations(steps):
        program = ["new 0", "enter 0", "exit 0", f"step 0 0 {steps} 1e-4", "real 0 3 1", "read 0 5", "free 0"]
        _, log = run(["valgrind", host], *binary_of(unpacked(lag)), program=program)
        return re.search(r"total heap usage: (\S+) allocs", log)[1]

    assert allocations(1) == allocations(1000)


@pytest.fixture(scope="module")
def failing_memory(tmp_path_factory):
    """Environment in which memory is refused to the lag, but for `FAILING`."""
    if not shutil.which("gcc"):
        pytest.skip("needs gcc")
    library = tmp_path_factory.mktemp("memory") / "failing_memory.so"
    subprocess.run(["gcc", "-shared", "-fPIC", "-O1", "-o", library, SUPPORT / "failing_memory.c", "-ldl"], check=True)
    return os.environ | {"LD_PRELOAD": str(library), "LIBRARY": "probe_lag"}


@pytest.mark.parametrize(
    ("failing", "answers", "facts"),
    [
        (1, "3 3 3 3 3", ("memory", "path")),
        (2, "3 3 3 3 3", ("memory", "path")),
        (3, "3 3 3 3 3", ("model.bin", "Cannot allocate memory")),
        (4, "3 3 3 3 3", ("memory", "instance")),
        (5, "0 0 0 3 3", ("fmi2GetFMUstate", "memory")),
        (6, "0 0 0 3 3", ("fmi2GetFMUstate", "memory")),
        (7, "0 0 0 0 3", ("fmi2DeSerializeFMUstate", "memory")),
    ],
)
def test_a_failed_allocation_is_an_error_with_the_reason(
    host, unpacked, lag, failing_memory, failing, answers, facts, tmp_path
):
    library, guid, resources = binary_of(unpacked(lag))
    shutil.copy(library, tmp_path)  # away from the resources
    program = ["new 0", "enter 0", "exit 0", "save 0", "bytes 0", "free 0"]
    values = tmp_path / library.name, guid, resources
    result, log = run([host], *values, program=program, env=failing_memory | {"FAILING": str(failing)})
    assert " ".join(answer[0] for answer in result) == f"{answers} 0"
    assert_names(log, *facts)


@pytest.mark.parametrize(("failing", "long"), [(4, True), (5, True), (1, False)], ids=["growth", "more", "in memory"])
def test_a_failed_allocation_for_the_data_is_an_error(host, unpacked, lag, failing_memory, tmp_path, failing, long):
    library, guid, _ = binary_of(unpacked(lag))
    library = shutil.copy(library, tmp_path)  # away from the resources
    (tmp_path / "model.bin").write_bytes(bytes(1 << 18))
    location = tmp_path.as_uri() if long else "data:;base64,AAAA"
    result, log = run(
        [host], library, guid, location, program=["new 0"], env=failing_memory | {"FAILING": str(failing)}
    )
    assert result == [["3"]]
    assert_names(log, *(("Cannot allocate memory",) if long else ("memory", "resources")))


# Other platforms -------------------------------------------------------------------------------------------------


def for_platform(unpacked, model, constants, platform):
    return binary_of(unpacked(model, constants, ["all"]), platform)


@pytest.fixture(scope="module")
def wine(tmp_path_factory):
    """The command that runs a program for Windows."""
    program = shutil.which("wine64") or shutil.which("wine")
    if not program:
        pytest.skip("needs wine")
    return ["env", f"WINEPREFIX={tmp_path_factory.mktemp('wine')}", "WINEDEBUG=-all", program]


@pytest.mark.slow
@pytest.mark.host("a host in C under wine", "wine", platform="Windows x86_64", fmus="rotor_contact", what="within 1e-9")
def test_the_windows_library_runs_under_wine(
    wine, cc, unpacked, plant, plant_constants, plant_program, lag, lag_program, tmp_path
):
    host = build_host(cc, PLATFORMS["win64"][1][0], tmp_path / "host.exe")
    for model, constants, program in ((lag, np.zeros(1), lag_program), (plant, plant_constants, plant_program)):
        library, guid, resources = for_platform(unpacked, model, constants, "win64")
        resources = resources.replace("file:///", "file:///Z:/")
        answers, _ = run([*wine, host], library, guid, resources, program=program.lines)
        program.check(answers, tolerance=1e-9)


@pytest.mark.slow
@pytest.mark.host(
    "a host in C under qemu", "qemu-aarch64", platform="Linux aarch64", fmus="rotor_contact", what="within 1e-9"
)
def test_the_arm_library_runs_under_qemu(
    cc, unpacked, plant, plant_constants, plant_program, lag, lag_program, tmp_path
):
    root = Path("/usr/aarch64-linux-gnu")
    if not (shutil.which("qemu-aarch64") and root.is_dir()):
        pytest.skip("needs qemu-aarch64 and the C library of aarch64 (Debian: qemu-user, libc6-arm64-cross)")
    host = build_host(cc, PLATFORMS["aarch64-linux"][1][0], tmp_path / "host")
    for model, constants, program in ((lag, np.zeros(1), lag_program), (plant, plant_constants, plant_program)):
        fmu = for_platform(unpacked, model, constants, "aarch64-linux")
        answers, _ = run(["qemu-aarch64", "-L", root, host], *fmu, program=program.lines)
        program.check(answers, tolerance=1e-9)


@pytest.mark.slow
@pytest.mark.host("a host in C under wine", "wine", platform="Windows x86_64", fmus="a probe", what="finds its data")
def test_the_windows_library_finds_its_data_in_every_form_of_location(wine, cc, unpacked, lag, tmp_path):
    library, guid, _ = for_platform(unpacked, lag, np.zeros(1), "win64")
    place = tmp_path / "a b" / "Größe" / "resources"
    shutil.copytree(unpacked(lag, np.zeros(1), ["all"]) / "resources", place)
    encoded = place.as_uri().removeprefix("file://")
    host = build_host(cc, PLATFORMS["win64"][1][0], tmp_path / "host.exe")
    forms = [f"file:///Z:{encoded}", f"file:/Z:{encoded}", f"file://localhost/Z:{encoded}/", f"file://Z:{encoded}"]
    # wine hands arguments to a program in its code page, so that letters beyond ASCII only come encoded
    plain = tmp_path / "plain folder"
    shutil.copytree(place, plain)
    forms += [f"Z:{plain}", "Z:" + str(plain).replace("/", "\\"), "z:" + str(plain).replace("/", "\\") + "\\"]
    for form in forms:
        answers, log = run([*wine, host], library, guid, form, program=["new 0", "enter 0", "exit 0", "free 0"])
        assert [answer[0] for answer in answers] == ["0"] * 4, (form, log)
    beside, _ = run([*wine, host], library, guid, "Z:\\nowhere", program=["new 0", "enter 0", "exit 0", "free 0"])
    assert [answer[0] for answer in beside] == ["0"] * 4, "those beside the library are used"
    _, log = run([*wine, host], shutil.copy(library, tmp_path), guid, "Z:\\nowhere", program=["new 0"])
    assert "cannot read Z:\\nowhere/model.bin: No such file or directory" in log
