"""Builds the python flavour of a model: an archive with script, code and constants for PythonFMU, and a guard.

The archive is like that of `pythonfmu.builder`. That builder is not used, because it imports the script under a name
that an FMU of the same model may already use in this process. It also takes libraries from the copy of PythonFMU that
was imported first; this may be a copy in an FMU, which has no libraries.
"""

from __future__ import annotations

import importlib.metadata
import json
import sys
import sysconfig
from collections.abc import Iterable
from dataclasses import replace
from io import BytesIO
from pathlib import Path

import numpy as np

from amb_files.archive import archive_of, write_archive
from fmi_export import amb_cosim_bootstrap as bootstrap
from fmi_export.building.description import model_description, xml_file
from fmi_export.building.documentation import documentation
from fmi_export.building.experiment import experiment_files
from fmi_export.building.guard.libraries import check_guarded, guard, guard_key, library_names
from fmi_export.building.identity import DOCUMENTATION, digests, guid_of, package_folder
from fmi_export.building.native.compiler import PLATFORMS, host_platform
from fmi_export.building.native.data import linear_state_file, model_data, sizes
from fmi_export.model import Array, Model


def build_python_fmu(model: Model, constants: Array, folder: Path, platforms: Iterable[str] | None = None) -> Path:
    """Write `python_fmu(model, constants, platforms)` to `<model.name>.fmu` in `folder` atomically; return its path.

    The folder is created if it is missing.
    """
    fmu = python_fmu(model, constants, platforms)
    folder.mkdir(parents=True, exist_ok=True)
    return write_archive(folder / f"{model.name}.fmu", fmu)


def python_fmu(model: Model, constants: Array, platforms: Iterable[str] | None = None) -> bytes:
    """Return an FMU that PythonFMU runs.

    Parameters
    ----------
    model
        The model to export.
    constants
        Constants of the model, a flat float64 array.
    platforms
        FMI names of the platforms on which the FMU runs, or `all`; by default, the platform of this machine. See
        `guard.libraries`.

    Raises
    ------
    ValueError
        If PythonFMU has no library for a platform, or if the guard must be compiled but cannot be.
    """
    chosen = check_guarded([host_platform()] if platforms is None else platforms)
    guid = python_guid(model, constants)
    guards = {platform: guard(platform) for platform in chosen}
    content = {f"resources/{name}": file for name, file in _resources(model, constants, guid).items()}
    for platform, engine in guards.items():
        guard_path, pythonfmu_path = library_names(model.name, platform)
        content |= {guard_path: engine.library, pythonfmu_path: _library_of_pythonfmu(platform)}
    content |= documentation(model, ["pythonfmu"])
    content["modelDescription.xml"] = xml_file(model_description(model, guid, *_tool()))
    content["resources/model.bin"] = _data(model, constants, guid)
    content |= linear_state_file(model, constants) | experiment_files(model, constants)
    content["resources/python.txt"] = "\n".join(_this_python()).encode()
    return archive_of(content)


def python_guid(model: Model, constants: Array) -> str:
    """Return an identifier that changes if the interface, the code (including the guard) or the constants change."""
    return guid_of(model, constants, "python " + guard_key())


def what_it_needs() -> str:
    """Return sentences that say what an FMU built here requires from the importing process."""
    library, _ = _this_python()
    effect = (
        f"starts this machine's Python, {library}" if library else "cannot run it: this Python has no shared library"
    )
    return (
        "An FMU of flavour python runs in a process that has Python with NumPy; a process without Python "
        f"{effect}. FMUs of flavour native need no Python."
    )


def _resources(model: Model, constants: Array, guid: str) -> dict[str, bytes]:
    """Return the files that PythonFMU's library and the script need, by their paths in the resources."""
    script, memory = _script(model), BytesIO()
    np.save(memory, np.ascontiguousarray(constants, dtype=np.float64))
    result = {
        "slavemodule.txt": script.stem.encode(),
        script.name: script.read_bytes(),
        Path(bootstrap.__file__).name: Path(bootstrap.__file__).read_bytes(),
        "constants.npy": memory.getvalue(),
        "layout.json": json.dumps(dict(model.layout), indent=1).encode(),
        "build.json": json.dumps(_build_facts(model, guid), indent=1).encode(),
    }
    for file in _installed_pythonfmu().glob("*.py"):
        result[f"pythonfmu/{file.name}"] = file.read_bytes()
    for package in model.packages:
        folder = package_folder(package)
        for file in folder.rglob("*"):
            place = file.relative_to(folder)
            if file.is_file() and not _is_unneeded(place):
                result[f"code/{package}/{place.as_posix()}"] = file.read_bytes()
    return result


def _is_unneeded(place: Path) -> bool:
    """Return whether a file of a package is omitted from FMUs."""
    return place.suffix == ".md" or not {"__pycache__", DOCUMENTATION, bootstrap.BUILD_ONLY}.isdisjoint(place.parts)


def _installed_pythonfmu() -> Path:
    """Return the folder of the installed PythonFMU; this process may have imported another copy."""
    return Path(str(importlib.metadata.distribution("pythonfmu").locate_file("pythonfmu")))


def _library_of_pythonfmu(platform: str) -> bytes:
    folder = _installed_pythonfmu() / "resources" / "binaries" / platform
    return next(folder.glob(f"*{PLATFORMS[platform][0]}")).read_bytes()


def _data(model: Model, constants: Array, guid: str) -> bytes:
    """Return the data for the guard, without the constants, which Python kernels read from a file."""
    return model_data(_without_constants(model, constants), np.zeros(0), guid, guard_key())


def _without_constants(model: Model, constants: Array) -> Model:
    """Return the model with its sizes, and those of its parts, as numbers instead of functions of the constants."""
    n_state, n_work = sizes(model, constants)
    parts = (replace(p, model=_without_constants(p.model, p.constants), constants=np.zeros(0)) for p in model.parts)
    return replace(model, n_state=n_state, n_work=n_work, parts=tuple(parts))


def _this_python() -> tuple[str, str]:
    """Return this Python's library (empty if there is none) and interpreter, for hosts that do not run Python."""
    name = "python3.dll" if sys.platform == "win32" else str(sysconfig.get_config_var("INSTSONAME"))
    folder = sys.base_prefix if sys.platform == "win32" else sysconfig.get_config_var("LIBDIR")
    library = Path(folder or "", name)
    return str(library) if library.is_file() and library.suffix != ".a" else "", sys.executable


def _script(model: Model) -> Path:
    """Return the script that PythonFMU loads; raise ValueError if the model's package has none."""
    name = model.packages[0] if model.parts else model.name  # all assemblies have the same script
    script = package_folder(model.packages[0]) / f"{name}_fmu.py"
    if not script.is_file():
        raise ValueError(
            f"model {model.name} has no script {script}; the first of its packages must contain one that defines the "
            "model for PythonFMU, such as examples/lag_sensor/lag_sensor/lag_sensor_fmu.py"
        )
    return script


def _build_facts(model: Model, guid: str) -> dict[str, object]:
    packages = digests(model.packages)
    return {"model": model.name, "guid": guid, "version": _tool()[1], "parts": _parts(model), "packages": packages}


def _parts(model: Model) -> dict[str, tuple[str, int, int]]:
    """Return, for each part of an assembly, its kernels' module and the indices where its constants begin and end."""
    places, end = {}, 0
    for part in model.parts:
        kernel = getattr(part.model.step, "py_func", part.model.step)
        places[part.name] = (kernel.__module__, end, end + len(part.constants))
        end += len(part.constants)
    return places


def _tool() -> tuple[str, str]:
    """Return the names and versions of the tools that generate an FMU, and the version of this project."""
    version, of_pythonfmu = (importlib.metadata.version(name) for name in ("amb-cosim", "pythonfmu"))
    return f"amb-cosim {version} with PythonFMU {of_pythonfmu}", version
