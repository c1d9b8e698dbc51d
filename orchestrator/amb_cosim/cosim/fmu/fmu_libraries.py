"""Checks the libraries of an FMU before one is loaded: a damaged one would end the process with a signal."""

from __future__ import annotations

import re
from pathlib import Path

import fmpy

from amb_cosim.cosim.fmu.elf import is_whole
from amb_cosim.cosim.fmu.fmu_interface import FmuInterface

PYTHONFMU = b"slavemodule.txt"  # a name that its library holds: the file that names the script


def check_libraries(folder: Path, interface: FmuInterface, what: str) -> None:
    """Check that an FMU has a library for this machine, whole, and what that needs when it is loaded.

    Parameters
    ----------
    folder
        Where the FMU is extracted.
    interface
        Its interface.
    what
        What messages call it.

    Raises
    ------
    ValueError
        If it has none, or one that cannot be loaded.
    """
    identifier = interface.identifier
    if not re.fullmatch(r"[A-Za-z_]\w*", identifier):
        raise ValueError(f"{what}: modelIdentifier = {identifier!r} is not allowed; it must be a name in C")
    platform = fmpy.platform_tuple if interface.fmi == 3 else fmpy.platform
    place = folder / "binaries" / platform
    if not (place / f"{identifier}{fmpy.sharedLibraryExtension}").is_file():
        present = sorted(path.name for path in folder.glob("binaries/*"))
        raise ValueError(f"{what} has no library {identifier} for {platform}; it has {', '.join(present) or 'none'}")
    for library in place.glob(f"*{fmpy.sharedLibraryExtension}"):
        content = library.read_bytes()
        if not is_whole(content):
            raise ValueError(f"{what}: {library.relative_to(folder).as_posix()} is damaged: its end is missing")
        if PYTHONFMU in content:
            _check_script(folder / "resources", what)


def _check_script(resources: Path, what: str) -> None:
    """Raise ValueError if the script is missing that PythonFMU's library loads."""
    named = resources / PYTHONFMU.decode()
    if not named.is_file():
        raise ValueError(f"{what} is damaged: resources/{named.name} is missing, which names its script")
    script = resources / f"{named.read_text(encoding='utf-8', errors='replace').strip()}.py"
    if not script.is_file():
        raise ValueError(f"{what} is damaged: its script resources/{script.name} is missing")
