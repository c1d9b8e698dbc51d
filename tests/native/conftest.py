"""Native FMUs and hosts, built once; tests that need the C compiler are skipped where it is not installed."""

from __future__ import annotations

import hashlib
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

from fmi_export.building.native.package import Fmi, build_native_fmu, native_guid
from fmi_export.model import Model


@pytest.fixture(scope="session")
def lag() -> Model:
    """A first-order lag with state, all variable types, ranges and faults (`fmi_export/support/probe_lag`)."""
    return importlib.import_module("probe_lag.lag").MODEL


@pytest.fixture(scope="session")
def plant() -> Model:
    from rotor_analysis.plant_data import plant

    return plant()[0]


@pytest.fixture(scope="session")
def plant_constants() -> Any:
    from rotor_analysis.plant_data import plant

    return plant()[1]


@pytest.fixture(scope="session")
def compiler() -> None:
    """Skip tests that need `ziglang`."""
    pytest.importorskip("numba")
    pytest.importorskip("ziglang", reason="a native FMU is compiled by ziglang: pip install 'amb-cosim[native]'")


@pytest.fixture(scope="session")
def native(compiler: None, create_once: Callable[..., Path]) -> Callable[..., Path]:
    """`native(model, constants=None, platforms=None, fmi=2)`: path of the FMU, built once per test run."""

    def build(model: Model, constants: Any = None, platforms: Sequence[str] | None = None, fmi: Fmi = 2) -> Path:
        numbers = np.zeros(1) if constants is None else constants
        facts = [native_guid(model, numbers, fmi), model.step.__qualname__, model.initialise.__qualname__, platforms]
        name = f"{model.name}-{hashlib.sha256(repr(facts).encode()).hexdigest()[:32]}"
        home = create_once(name, lambda folder: build_native_fmu(model, numbers, folder, platforms, fmi))
        return home / f"{model.name}.fmu"

    return build


@pytest.fixture(scope="session")
def unpacked(native: Callable[..., Path], create_once: Callable[..., Path]) -> Callable[..., Path]:
    """The same arguments as `native`; folder of the extracted FMU."""

    def extract(*arguments: Any) -> Path:
        fmu = native(*arguments)

        def fill(folder: Path) -> None:
            with zipfile.ZipFile(fmu) as archive:
                archive.extractall(folder)

        return create_once(f"{fmu.parent.name}-extracted", fill)

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
    """Skip a test where a program is missing."""
    missing = [program for program in programs if not shutil.which(program)]
    return pytest.mark.skipif(bool(missing), reason=f"needs {', '.join(missing)}")
