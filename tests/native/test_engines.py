"""Engines: their dependencies, where a build looks for them, and the wheel that ships them."""

import dataclasses
import importlib
import sys
import zipfile
from pathlib import Path

import pytest

from fmi_export.building.guard.libraries import SYSTEMS, guard_place
from fmi_export.building.native import engines
from fmi_export.building.native.compiler import PLATFORMS, WASM, host_platform
from fmi_export.building.native.engines import Engine, engine, engine_key, engine_place
from fmi_export.interface import Interface
from tests.support.messages import assert_names, raises_naming

ROOT = Path(__file__).parents[2]


@pytest.fixture
def empty(monkeypatch, tmp_path):
    """Nothing was compiled before; an engine that is compiled now consists of one byte."""
    compiled = []
    monkeypatch.setattr(engines, "_cache", lambda: tmp_path / "cache")
    monkeypatch.setattr(engines, "SHIPPED", tmp_path / "shipped")
    monkeypatch.setattr(engines, "_compile", lambda *given: compiled.append(given) or Engine(b"c", "a compiler"))
    return compiled


def test_an_engine_depends_on_code_alone(lag, tmp_path, monkeypatch):
    key = engine_key([lag])
    table = Interface((dataclasses.replace(lag.interface.variables[0], name="tau"), *lag.interface.variables[1:]))
    assert engine_key([dataclasses.replace(lag, interface=table, faults={}, n_state=9)]) == key
    assert engine_key([dataclasses.replace(lag, step=lag.initialise)]) != key
    assert engine_key([dataclasses.replace(lag, packages=("fmi_export",))]) != key
    monkeypatch.setattr(engines, "C_SOURCES", engines.C_SOURCES[1:])
    assert engine_key([lag]) != key


def test_an_engine_is_compiled_once(lag, empty):
    assert [engine([lag], "win64") for _ in range(3)] == [Engine(b"c", "a compiler")] * 3
    assert empty == [([lag], "win64")]


def test_damaged_lowered_kernels_are_lowered_again(lag, monkeypatch, tmp_path):
    lowered = []
    monkeypatch.setattr(engines, "_cache", lambda: tmp_path)
    monkeypatch.setattr(engines, "lower", lambda model: lowered.append(model) or "; the code\n")
    for _ in range(2):
        assert engines.engine_sources([lag])["probe_lag.ll"] == "; the code\n"
    (file,) = tmp_path.rglob("*.ll")
    file.write_text("; other code\n")
    assert engines.engine_sources([lag])["probe_lag.ll"] == "; the code\n"
    assert len(lowered) == 2


def test_an_engine_is_compiled_without_a_writable_cache(lag, empty, tmp_path):
    (tmp_path / "cache").touch()
    assert engine([lag], "linux64").library == b"c"


def test_a_shipped_engine_is_used_if_its_code_is_current(lag, empty):
    Engine(b"shipped", "").write(engines.SHIPPED / engine_place([lag], "linux64"))
    assert engine([lag], "linux64").library == b"shipped"
    other = dataclasses.replace(lag, step=lag.initialise)
    assert engine([other], "linux64").library == b"c"


def without_compilers(folder: str, shipped: str) -> str:
    import os
    import pathlib
    import sys

    os.environ["XDG_CACHE_HOME"] = os.environ["LOCALAPPDATA"] = folder
    from hide import hide

    hide("numba", "llvmlite", "ziglang")
    import numpy as np
    from probe_lag.lag import MODEL

    import fmi_export.building.native.package as package

    sys.modules["fmi_export.building.native.engines"].SHIPPED = pathlib.Path(shipped)
    try:
        return str(package.build_native_fmu(MODEL, np.zeros(1), pathlib.Path(folder)))
    except ValueError as error:
        return str(error)


@pytest.mark.usefixtures("compiler")
def test_a_build_with_a_shipped_engine_needs_no_compiler(lag, native, run_python, tmp_path):
    engine([lag], host_platform()).write(tmp_path / "shipped" / engine_place([lag], host_platform()))
    built = run_python(without_compilers, folder=tmp_path, shipped=tmp_path / "shipped")
    assert Path(built).read_bytes() == native(lag).read_bytes()


def test_build_without_engine_and_compiler_names_what_to_install(run_python, tmp_path):
    message = run_python(without_compilers, folder=tmp_path, shipped=tmp_path / "nothing")
    assert_names(message, "probe_lag", host_platform(), "flavour python", "numba, ziglang", "pip install")
    assert message.endswith("[native]'")


# The wheel ---------------------------------------------------------------------------------------------------------


@pytest.fixture
def hook(empty, monkeypatch):
    """`hook(platforms)`: build data of a wheel for hatchling, and the added files, for a value of the variable."""
    pytest.importorskip("hatchling")
    monkeypatch.syspath_prepend(str(ROOT))
    monkeypatch.setattr(sys, "path", list(sys.path))
    monkeypatch.setattr("amb_cosim.cosim.building.loop_library.compile_loop", lambda _: b"loop")
    monkeypatch.setattr("fmi_export.building.guard.libraries._compile", lambda _: Engine(b"guard", "a compiler"))

    def run(platforms: str | None, version: str = "standard") -> tuple[dict, set[str]]:
        if platforms is None:
            monkeypatch.delenv("AMB_COSIM_PLATFORMS", raising=False)
        else:
            monkeypatch.setenv("AMB_COSIM_PLATFORMS", platforms)
        build = importlib.import_module("hatch_build").EngineBuildHook(
            str(ROOT), {"kernels": {"probe_lag": "probe_lag.lag"}, "assembled": ["probe_lag"]}, None, None, "", "wheel"
        )
        data: dict = {"force_include": {}, "pure_python": True}
        build.initialize(version, data)
        paths = {path.relative_to(folder) for folder in data["force_include"] for path in Path(folder).glob("*/*")}
        build.finalize(version, data, "")
        guards = {platform for platform in SYSTEMS if guard_place(platform) in paths}
        files = {path.parts[0] for path in paths}
        assert guards == files & {*SYSTEMS}, "a guard for each platform that PythonFMU has a library for"
        return data, files

    return run


@pytest.mark.slow  # needs hatchling
def test_a_wheel_contains_the_engines_of_its_platforms_and_is_tagged_by_them(hook, lag, empty):
    data, files = hook(None)
    assert {platform for _, platform in empty} == files == {host_platform()}
    assert {engine_place(kernels, "win64") for kernels, _ in empty} == {engine_place([lag], "win64")}
    assert not data["pure_python"]
    assert data["tag"].startswith("py3-none-")
    assert not data["tag"].endswith("-any")
    data, files = hook("win64,linux64,wasm32")
    assert (files, data["tag"]) == ({"linux64", "win64", WASM}, "py3-none-manylinux_2_17_x86_64.win_amd64")
    data, files = hook("all")
    assert (files, data["pure_python"], "tag" in data) == ({*PLATFORMS, WASM}, True, False)
    assert hook("all", "editable") == ({"force_include": {}, "pure_python": True}, set())
    with raises_naming(SystemExit, "AMB_COSIM_PLATFORMS", "amiga", "linux64"):
        hook("amiga")


def from_the_wheel(wheel: str, folder: str) -> dict:
    import os
    import sys

    os.environ["XDG_CACHE_HOME"] = os.environ["LOCALAPPDATA"] = folder
    sys.path.insert(0, wheel)
    from hide import hide

    sys.path_importer_cache.clear()
    hide("numba", "llvmlite", "ziglang")
    from fmpy.validation import validate_fmu

    import amb_cosim

    paths = amb_cosim.build(folder, "native", platforms=["all"])
    problems = {path.stem: validate_fmu(str(path)) for path in paths}
    return {"from": amb_cosim.__file__, "problems": problems}


@pytest.mark.slow
@pytest.mark.usefixtures("compiler")
def test_the_wheel_builds_for_every_platform_without_a_compiler(run_python, tmp_path):
    pytest.importorskip("hatch_vcs")

    def build(root: str, folder: str) -> str:
        import os
        import subprocess
        import sys

        os.environ["AMB_COSIM_PLATFORMS"] = "all"
        command = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", folder]
        return subprocess.run(command, cwd=root, capture_output=True, text=True, check=True).stdout.strip()

    run_python(build, root=ROOT, folder=tmp_path, timeout=900)
    (wheel,) = tmp_path.glob("*.whl")
    assert wheel.name.endswith("-py3-none-any.whl")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(tmp_path / "wheel")
    result = run_python(from_the_wheel, wheel=tmp_path / "wheel", folder=tmp_path / "fmus")
    assert result["from"].startswith(str(tmp_path))
    assert result["problems"] == {"rotor_contact": [], "amb_actuator": [], "rolac_controller": []}
    for fmu in (tmp_path / "fmus").glob("*.fmu"):
        with zipfile.ZipFile(fmu) as archive:
            binaries = {name.split("/")[1] for name in archive.namelist() if name.startswith("binaries/")}
        assert binaries == set(PLATFORMS)
