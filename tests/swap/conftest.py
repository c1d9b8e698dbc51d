"""FMUs that replace the components of the rig, built once."""

from __future__ import annotations

import shutil
import subprocess
import sys
import zipfile
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path

import fmpy
import pytest

SUPPORT = Path(__file__).parent / "support"


@pytest.fixture(scope="session")
def python_fmus(create_once: Callable[..., Path]) -> Path:
    """Folder of the FMUs of PythonFMU."""
    from pythonfmu.builder import FmuBuilder

    def fill(folder: Path) -> None:
        for name in ("pd_controller", "linear_actuator", "full_rotor"):
            FmuBuilder.build_FMU(SUPPORT / f"{name}.py", dest=folder)

    return create_once("python_fmus", fill)


@pytest.fixture(scope="session")
def c_controller(create_once: Callable[..., Path]) -> Path:
    """The controller in C, by the C compiler of this machine; its tests are skipped where there is none."""
    zig = [sys.executable, "-m", "ziglang", "cc"] if find_spec("ziglang") is not None else None
    result = next((path for path in map(shutil.which, ("cc", "gcc", "clang")) if path is not None), None)
    compiler = zig or ([result] if result is not None else None)
    if compiler is None:
        pytest.skip("there is no C compiler: pip install ziglang")
    platform = fmpy.platform
    headers = Path(fmpy.__file__).parent / "c-code"

    def fill(folder: Path) -> None:
        library = folder / f"pd_controller{fmpy.sharedLibraryExtension}"
        options = ["-shared", "-fPIC", "-O2", "-ffp-contract=off", f"-I{headers}", "-o", str(library)]
        subprocess.run([*compiler, *options, str(SUPPORT / "pd_controller.c")], check=True, timeout=120)
        with zipfile.ZipFile(folder / "pd_controller.fmu", "w") as archive:
            archive.write(SUPPORT / "pd_controller.xml", "modelDescription.xml")
            archive.write(library, f"binaries/{platform}/{library.name}")

    return create_once("c_controller", fill) / "pd_controller.fmu"
