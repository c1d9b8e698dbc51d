"""FMUs built from their own C code: the same bits as the shipped library, in other tools, and on other processors."""

import shutil
import sys
import zipfile
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from command_line import run_program
from host_marks import in_host
from raw import Library, Library3

from amb_cosim.cosim.fmu.fmus import model_source
from fmi_export.building.native.compiler import host_platform
from fmi_export.building.native.package import build_native_fmu
from fmi_export.building.native.portable import OPTIONS, compiled_files

needs_gcc = pytest.mark.skipif(not shutil.which("gcc") or sys.platform != "linux", reason="needs gcc on Linux")
STRICT = ("-pedantic", "-Wall", "-Wextra", "-Werror")
SUPPORT = Path(__file__).parent / "support"
H = 250e-6  # s
LIBRARIES = {2: Library, 3: Library3}


@pytest.fixture(scope="module")
def with_sources(compiler, create_once):
    """`with_sources(model, constants, fmi)`: the folder of an FMU that holds its C code."""

    def build(model, constants, fmi):
        def fill(folder):
            fmu = build_native_fmu(model, constants, folder, None, fmi, sources=True)
            zipfile.ZipFile(fmu).extractall(folder / "extracted")

        return create_once(f"{model.name}-sources-{fmi}", fill) / "extracted"

    return build


def compile_sources(folder, target, *options):
    files = [folder / "sources" / name for name in compiled_files(path.name for path in (folder / "sources").iterdir())]
    run_program("gcc", *OPTIONS.split(), *STRICT, "-O2", "-fPIC", *options, *files, "-o", target, "-lm")


def rebuilt(folder, fmi, place):
    """A copy of an FMU whose library is compiled from its C code."""
    shutil.copytree(folder, place)
    (library,) = place.glob("binaries/*/*.so")
    library.unlink()
    compile_sources(place, library, "-shared", f"-DFMI{fmi}_OVERRIDE_FUNCTION_PREFIX")
    return place


def outputs_of(library, start, change, steps):
    """All outputs of an FMU at every step; `change(n)` returns the inputs of step n."""
    with library.instantiate().begin(**start) as slave:
        rows = []
        for n in range(steps):
            assert slave.set(**change(n)) == 0
            assert slave.step(n) == 0, slave.log
            rows.append(slave.get(*library.outputs))
    return np.array(rows)


PLANT = {"Omega": 260.0, "d1__u": 0.3, "rb1__mu": 0.3, "rb2__mu": 0.3}
CASES = {  # what each model starts with, and inputs that move, with their size
    "probe_lag": ({"gain": 3.0, "offset": -2}, {"u": 1.2}),
    "rotor_contact": (PLANT, {"d2__f_x": 80.0, "d2__f_y": 80.0}),
    "amb_actuator": ({"mb1__x": 1e-4}, {"mb1__x": 1e-4, "mb1__i_x": 2.0, "mb2__i_y": 1.0}),
    "rolac_controller": ({"Omega": 400.0, "rolac_enable": 1.0}, {f"s{k}": 1e-5 for k in range(1, 9)}),
}


@needs_gcc
@pytest.mark.parametrize(
    ("name", "fmi", "steps"),
    [
        ("probe_lag", 2, 200),
        ("probe_lag", 3, 200),
        *(pytest.param(name, 2, 4000, marks=pytest.mark.slow) for name in CASES if name != "probe_lag"),
    ],
)
def test_a_library_from_the_c_code_gives_the_bits_of_the_shipped_one(with_sources, lag, name, fmi, steps, tmp_path):
    start, moving = CASES[name]
    shipped = with_sources(*((lag, np.zeros(1)) if name == "probe_lag" else model_source(name)), fmi)
    places = (shipped, rebuilt(shipped, fmi, tmp_path / "rebuilt"))
    values = np.random.default_rng(7).standard_normal((steps, len(moving)))

    def change(n):
        return {key: float(size * x) for (key, size), x in zip(moving.items(), values[n], strict=True)}

    theirs, ours = (outputs_of(LIBRARIES[fmi](place), start, change, steps) for place in places)
    assert ours.tobytes() == theirs.tobytes()
    assert np.ptp(ours, axis=0).max() > (1e4 if name == "rotor_contact" else 0.1), "there must be contact"


@needs_gcc
@pytest.mark.parametrize("fmi", [2, 3])
def test_every_symbol_begins_with_the_name_of_the_model(with_sources, lag, fmi, tmp_path):
    compile_sources(with_sources(lag, np.zeros(1), fmi), tmp_path / "all.so", "-shared")
    listed = run_program("nm", "-g", "--defined-only", tmp_path / "all.so")
    names = [line.split()[2] for line in listed.stdout.splitlines()]
    assert len(names) > 30
    assert {name for name in names if not name.startswith("probe_lag_")} == set()


@pytest.mark.parametrize("fmi", [2, 3])
def test_the_descriptions_list_the_compiled_sources(with_sources, lag, fmi):
    fmpy = pytest.importorskip("fmpy")
    folder = with_sources(lag, np.zeros(1), fmi)
    (configuration,) = fmpy.read_model_description(str(folder), validate=True).buildConfigurations
    (files,) = configuration.sourceFileSets
    assert configuration.modelIdentifier == "probe_lag"
    assert files.sourceFiles == sorted(path.name for path in (folder / "sources").glob("*.c"))
    assert "probe_lag.c" in files.sourceFiles
    included = "".join((folder / "sources" / name).read_text() for name in files.sourceFiles)
    assert f"fmi{5 - fmi}" not in included
    if fmi == 3:
        build = ElementTree.parse(folder / "sources" / "buildDescription.xml").getroot()
        (files,) = build.iterfind("BuildConfiguration/SourceFileSet")
        assert (files.get("compiler"), files.get("compilerOptions")) == ("gcc", OPTIONS), "options are of a compiler"


@pytest.mark.slow
@in_host("FMPy", "a lag, from its C code", "builds the library and runs it")
@pytest.mark.skipif(not shutil.which("cmake"), reason="needs cmake")
@needs_gcc
@pytest.mark.parametrize("fmi", [2, 3])
def test_fmpy_builds_the_library_from_the_c_code_and_runs_it(with_sources, lag, fmi, tmp_path):
    build = pytest.importorskip("fmpy.build")
    import fmpy

    place = tmp_path / "rebuilt"
    shutil.copytree(with_sources(lag, np.zeros(1), fmi), place)
    shutil.rmtree(place / "binaries")
    options = {"CMAKE_C_FLAGS:STRING": "-DFMI2_OVERRIDE_FUNCTION_PREFIX"} if fmi == 2 else {}
    build.build_platform_binary(place, cmake_options=options)
    result = fmpy.simulate_fmu(str(place), stop_time=0.01, output_interval=H, start_values={"u": 1.0}, output=["y"])
    assert np.ptp(result["y"]) > 0.0


def linked_statically(command, folder, target):
    """Compile an FMU's C code and a host to one program; return its name."""
    sources = sorted((folder / "sources").glob("*.c"))
    values = [*command, *OPTIONS.split(), "-O2", f"-I{folder / 'sources'}", *sources, SUPPORT / "static_host.c"]
    run_program(*values, "-static", "-o", target, "-lm")
    return target


def on_processor(emulator, target, platform):
    """The emulator and the target of a processor, skipped where it cannot be emulated."""
    missing = not shutil.which(emulator) or host_platform() != "linux64"
    values = {"platform": platform, "what": "within 1e-14"}
    marks = [
        pytest.mark.host("a host in C under qemu", emulator, fmus="a lag, from its C code", **values),
        pytest.mark.skipif(missing, reason=f"needs {emulator}"),
    ]
    return pytest.param(emulator, target, marks=marks, id=platform)


@pytest.mark.slow
@needs_gcc
@pytest.mark.parametrize(
    ("emulator", "target"),
    [
        on_processor("qemu-riscv64", "riscv64-linux-musl", "Linux riscv64"),
        on_processor("qemu-arm", "arm-linux-musleabihf", "Linux armv7"),
        on_processor("qemu-i386", "x86-linux-musl", "Linux i686"),
    ],
)
def test_on_other_processors_the_c_code_gives_the_numbers_of_this_one(with_sources, lag, tmp_path, emulator, target):
    """RISC-V has a fused multiply-add; disabled by a flag, it rounds as this machine does. Two targets have 32 bits."""
    folder = with_sources(lag, np.zeros(1), 2)
    zig = (sys.executable, "-m", "ziglang", "cc", "-target", target)
    emulated = linked_statically(zig, folder, tmp_path / "there")
    native = linked_statically(("gcc",), folder, tmp_path / "here")
    root = ElementTree.parse(folder / "modelDescription.xml").getroot()
    names = [v.get("name") for v in root.iterfind("ModelVariables/*")]
    values = [root.get("guid"), (folder / "resources").as_uri(), names.index("u"), names.index("y"), 200]
    rows = []
    for program in ([emulator, emulated], [native]):
        rows.append(np.array([float.fromhex(line) for line in run_program(*program, *values).stdout.splitlines()]))
    np.testing.assert_allclose(rows[0], rows[1], rtol=1e-14)
    assert np.ptp(rows[0]) > 0.01
