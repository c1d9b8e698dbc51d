"""Native FMUs and hosts, built once; what needs the C compiler is skipped where it is not installed."""

from __future__ import annotations

import importlib
import shutil
import subprocess
import sys
import zipfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fmi_export.building.native.package import build_native_fmu
from fmi_export.model import Model


@pytest.fixture(scope="session")
def lag() -> Model:
    """A first-order lag with state, all variable types, ranges and faults (`fmi_export/support/probe_lag`)."""
    return importlib.import_module("probe_lag.lag").MODEL


@pytest.fixture(scope="session")
def plant() -> Model:
    from rotor_contact.plant import MODEL

    return MODEL


@pytest.fixture(scope="session")
def plant_constants() -> Any:
    from rotor_analysis.plant_data import plant_constants

    return plant_constants()


@pytest.fixture(scope="session")
def compiler() -> None:
    """Skips what needs `ziglang`."""
    pytest.importorskip("numba")
    pytest.importorskip("ziglang", reason="a native FMU is compiled by ziglang: pip install 'amb-cosim[native]'")


@pytest.fixture(scope="session")
def native(compiler: None, tmp_path_factory: pytest.TempPathFactory) -> Callable[..., Path]:
    """`native(model, constants=None, platforms=None)`: path of the FMU, built once per session and xdist worker."""
    built: dict[Any, Path] = {}

    def build(model: Model, constants: Any = None, platforms: Sequence[str] | None = None) -> Path:
        numbers = np.zeros(1) if constants is None else constants
        key = (model.name, numbers.tobytes(), tuple(platforms or ()))
        if key not in built:
            built[key] = build_native_fmu(model, numbers, tmp_path_factory.mktemp(model.name), platforms)
        return built[key]

    return build


@pytest.fixture(scope="session")
def unpacked(native: Callable[..., Path], tmp_path_factory: pytest.TempPathFactory) -> Callable[..., Path]:
    """The same arguments as `native`; folder of the extracted FMU."""
    folders: dict[Path, Path] = {}

    def extract(*arguments: Any) -> Path:
        fmu = native(*arguments)
        if fmu not in folders:
            folders[fmu] = tmp_path_factory.mktemp("extracted")
            with zipfile.ZipFile(fmu) as archive:
                archive.extractall(folders[fmu])
        return folders[fmu]

    return extract


@pytest.fixture(scope="session")
def cc(compiler: None) -> Callable[..., None]:
    """`cc(*arguments)`: zig's C compiler."""

    def run(*arguments: Any) -> None:
        command = [sys.executable, "-m", "ziglang", "cc", *map(str, arguments)]
        process = subprocess.run(command, capture_output=True, text=True, check=False)
        assert process.returncode == 0, process.stderr

    return run


def needs(*programs: str) -> pytest.MarkDecorator:
    """Skips a test where a program is missing."""
    missing = [program for program in programs if not shutil.which(program)]
    return pytest.mark.skipif(bool(missing), reason=f"needs {', '.join(missing)}")
