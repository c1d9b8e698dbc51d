"""FMUs that are not this project's, built once by PythonFMU."""

from __future__ import annotations

import subprocess
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest

SUPPORT = Path(__file__).parent / "support"


@pytest.fixture(scope="session")
def foreign_fmus(create_once: Callable[..., Path]) -> Path:
    """Folder with `Mass.fmu`, `Spring.fmu` and `Unruly.fmu`."""
    from pythonfmu.builder import FmuBuilder

    def fill(folder: Path) -> None:
        for script in SUPPORT.glob("*.py"):
            FmuBuilder.build_FMU(script, dest=folder)

    return create_once("foreign-fmus", fill)


ODD = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="Odd" guid="{odd}">
<CoSimulation modelIdentifier="odd" canHandleVariableCommunicationStepSize="true"/>
<ModelVariables>
<ScalarVariable name="what" valueReference="0" causality="input"><Real start="0"/></ScalarVariable>
<ScalarVariable name="y" valueReference="1" causality="output"><Real/></ScalarVariable>
</ModelVariables>
<ModelStructure><Outputs><Unknown index="2"/></Outputs></ModelStructure>
</fmiModelDescription>
"""


@pytest.fixture(scope="session")
def odd_fmu(create_once: Callable[..., Path]) -> Path:
    """`Odd.fmu`, which is compiled from C for Linux on this processor."""

    def fill(folder: Path) -> None:
        compile_it = [sys.executable, "-m", "ziglang", "cc", "-shared", "-fPIC", "-O2", "-o", folder / "odd.so"]
        subprocess.run([*compile_it, SUPPORT / "odd.c"], check=True, capture_output=True)
        with zipfile.ZipFile(folder / "Odd.fmu", "w") as archive:
            archive.writestr("modelDescription.xml", ODD)
            archive.write(folder / "odd.so", "binaries/linux64/odd.so")

    return create_once("odd-fmu-2", fill) / "Odd.fmu"
