"""Checks that an FMU has a library for this machine, and the script that PythonFMU would load."""

from __future__ import annotations

import re
from pathlib import Path

import fmpy

from amb_cosim.cosim.fmu.fmu_interface import FmuInterface

PYTHONFMU = b"slavemodule.txt"  # the file that names the script; PythonFMU's library contains this name


def check_libraries(folder: Path, interface: FmuInterface, what: str) -> None:
    """Check that an FMU has a library for this machine, and the files that the library loads.

    Parameters
    ----------
    folder
        Folder to which the FMU is extracted.
    interface
        Its interface.
    what
        Name of the FMU in messages.

    Raises
    ------
    ValueError
        If the FMU has no library, or has PythonFMU's library without a script, because loading such an FMU would end
        the process.
    """
    identifier = interface.identifier
    if not re.fullmatch(r"\w[\w .+-]*", identifier):
        raise ValueError(
            f"{what}: modelIdentifier = {identifier!r} is not allowed; it must be a valid name in C, not a path"
        )
    platform = fmpy.platform_tuple if interface.fmi == 3 else fmpy.platform
    place = folder / "binaries" / platform
    if not (place / f"{identifier}{fmpy.sharedLibraryExtension}").is_file():
        present = sorted(path.name for path in folder.glob("binaries/*"))
        raise ValueError(
            f"{what} has no library {identifier} for {platform}; "
            f"it has libraries for {', '.join(present) or 'no platform'}"
        )
    for library in place.glob(f"*{fmpy.sharedLibraryExtension}"):
        if PYTHONFMU in library.read_bytes():
            _check_script(folder / "resources", what)


def _check_script(resources: Path, what: str) -> None:
    """Raise ValueError if the script that PythonFMU's library loads is missing."""
    name_file = resources / PYTHONFMU.decode()
    if not name_file.is_file():
        raise ValueError(f"{what} is damaged: resources/{name_file.name}, which names its script, is missing")
    script = resources / f"{name_file.read_text(encoding='utf-8', errors='replace').strip()}.py"
    if not script.is_file():
        raise ValueError(f"{what} is damaged: its script resources/{script.name} is missing")
