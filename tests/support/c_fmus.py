"""FMUs compiled from a file of C by ziglang, for Linux on this processor."""

from __future__ import annotations

import platform
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

DEFAULTS = Path(__file__).parent / "defaults.c"
PLATFORMS = {2: "linux64", 3: f"{platform.machine().lower()}-linux"}


def compile_fmu(folder: Path, source: Path, description: str, version: int = 2) -> None:
    """Write `Name.fmu` of `name.c`, and functions of `defaults.c` that it lacks; C has the version as FMI_VERSION."""
    pytest.importorskip("ziglang", reason="the FMU is compiled by ziglang: pip install 'amb-cosim[native]'")
    library = folder / f"{source.stem}.so"
    options = ["-shared", "-fPIC", "-O2", "-ffp-contract=off", "-fno-sanitize=all", f"-DFMI_VERSION={version}"]
    command = [sys.executable, "-m", "ziglang", "cc", *options, "-o", library, source, DEFAULTS]
    subprocess.run(command, check=True, capture_output=True)
    with zipfile.ZipFile(folder / f"{source.stem.capitalize()}.fmu", "w") as archive:
        archive.writestr("modelDescription.xml", description)
        archive.write(library, f"binaries/{PLATFORMS[version]}/{library.name}")
