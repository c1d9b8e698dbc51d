"""Finds FMUs that cannot run in one process with those before them.

* Of an FMU with `canBeInstantiatedOnlyOncePerProcess`, a process can have one instance: others would share its state.
* FMUs of PythonFMU share one interpreter, in which a name is one module: the first FMU's.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path

from amb_cosim.cosim.fmu.fmu_interface import FmuInterface
from amb_cosim.cosim.fmu.fmu_libraries import PYTHONFMU
from amb_cosim.cosim.fmu.fmus import Fmu

CODE = (".py", ".so", ".pyd")  # files of Python modules


def separate_components(fmus: Mapping[str, Fmu], interfaces: Mapping[str, FmuInterface]) -> frozenset[str]:
    """Return the components that need a process of their own, given those before them."""
    separate: set[str] = set()
    identifiers: set[str] = set()
    modules: dict[str, str] = {}
    for name, fmu in fmus.items():
        interface, of_fmu = interfaces[name], modules_of(fmu.folder) if fmu.layout is None else {}
        is_taken = interface.once_per_process and interface.identifier in identifiers
        if is_taken or any(modules.get(module, digest) != digest for module, digest in of_fmu.items()):
            separate.add(name)
        else:
            identifiers.add(interface.identifier)
            modules.update(of_fmu)
    return frozenset(separate)


@lru_cache(maxsize=256)
def modules_of(folder: Path) -> Mapping[str, str]:
    """Return the Python modules that an extracted FMU of PythonFMU brings, by name, each with a digest of its code."""
    resources = folder / "resources"
    result: dict[str, str] = {}
    if not (resources / PYTHONFMU.decode()).is_file():
        return {}
    for item in sorted(resources.iterdir()):
        files = sorted(item.rglob("*")) if item.is_dir() else [item]
        code = [file for file in files if file.suffix in CODE]
        if code:
            sha = hashlib.sha256()
            for file in code:
                sha.update(file.relative_to(resources).as_posix().encode() + b"\0" + file.read_bytes())
            name = item.name.partition(".")[0]
            result[name] = result.get(name, "") + sha.hexdigest()
    return result
