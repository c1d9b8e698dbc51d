"""Finds FMUs that cannot run in one process with the FMUs before them.

* A process can have only one instance of an FMU with `canBeInstantiatedOnlyOncePerProcess`, because further instances
  would share its state.
* FMUs of PythonFMU share one interpreter, in which a module name always refers to the module of the first FMU.
* Additional libraries of an FMU are loaded by name. If several FMUs have a library of the same name, all of them get
  the library of the first FMU.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path

import fmpy

from amb_cosim.cosim.fmu.fmu_interface import FmuInterface
from amb_cosim.cosim.fmu.fmu_libraries import PYTHONFMU
from amb_cosim.cosim.fmu.fmus import Fmu

CODE = (".py", ".so", ".pyd")  # files of Python modules


def separate_components(fmus: Mapping[str, Fmu], interfaces: Mapping[str, FmuInterface]) -> frozenset[str]:
    """Return the components that need a separate process because they conflict with components before them."""
    separate: set[str] = set()
    identifiers: set[str] = set()
    code: dict[str, str] = {}
    for name, fmu in fmus.items():
        interface = interfaces[name]
        fmu_code = _named_code(fmu.folder, interface.identifier) if fmu.layout is None else {}
        is_second = interface.once_per_process and interface.identifier in identifiers
        if is_second or any(code.get(loaded, digest) != digest for loaded, digest in fmu_code.items()):
            separate.add(name)
        else:
            identifiers.add(interface.identifier)
            code.update(fmu_code)
    return frozenset(separate)


@lru_cache(maxsize=256)
def _named_code(folder: Path, identifier: str) -> Mapping[str, str]:
    """Return digests of the modules and libraries of an extracted FMU that are loaded by name."""
    places = (folder / "binaries" / platform for platform in (fmpy.platform, fmpy.platform_tuple))
    files = [file for place in places if place.is_dir() for file in sorted(place.iterdir())]
    libraries = {
        f"library {file.name}": hashlib.sha256(file.read_bytes()).hexdigest()
        for file in files
        if file.is_file() and file.name.partition(".")[0] != identifier
    }
    return {**modules_of(folder), **libraries}


@lru_cache(maxsize=256)
def modules_of(folder: Path) -> Mapping[str, str]:
    """Return the Python modules in an extracted FMU of PythonFMU, by name, each with a digest of its code."""
    resources = folder / "resources"
    digests: dict[str, str] = {}
    if not (resources / PYTHONFMU.decode()).is_file():
        return {}
    for entry in sorted(resources.iterdir()):
        files = sorted(entry.rglob("*")) if entry.is_dir() else [entry]
        code = [file for file in files if file.suffix in CODE]
        if code:
            sha = hashlib.sha256()
            for file in code:
                sha.update(file.relative_to(resources).as_posix().encode() + b"\0" + file.read_bytes())
            name = entry.name.partition(".")[0]
            digests[name] = digests.get(name, "") + sha.hexdigest()
    return digests
