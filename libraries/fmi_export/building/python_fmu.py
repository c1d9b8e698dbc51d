"""Builds the python flavour of a model: PythonFMU's archive of script, code and constants, behind a guard."""

from __future__ import annotations

import importlib.metadata
import json
import shutil
import sys
import sysconfig
import zipfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
from pythonfmu.builder import FmuBuilder

from amb_files.archive import archive_of, write_archive
from amb_files.temporary_folders import temporary_folder
from fmi_export import amb_cosim_bootstrap as bootstrap
from fmi_export.building.description import model_description, xml_file
from fmi_export.building.documentation import documentation
from fmi_export.building.experiment import experiment_files
from fmi_export.building.guard.libraries import check_guarded, guard, guard_key, library_names
from fmi_export.building.identity import DOCUMENTATION, digests, guid_of, package_folder
from fmi_export.building.native.compiler import host_platform
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
        Its constants, flat float64.
    platforms
        FMI names of the platforms that it runs on, or `all`; this machine's by default; see `guard.libraries`.

    Raises
    ------
    ValueError
        If PythonFMU has no library for a platform, or the guard before it must be compiled and cannot be.
    """
    chosen = check_guarded([host_platform()] if platforms is None else platforms)
    guid = python_guid(model, constants)
    guards = {platform: guard(platform) for platform in chosen}
    with temporary_folder() as temporary:
        content = _content(_built_by_pythonfmu(model, constants, guid, temporary))
    libraries = {name: content.pop(name) for name in list(content) if name.startswith("binaries/")}
    for platform, item in guards.items():
        guarding, pythonfmu = library_names(model.name, platform)
        content |= {guarding: item.library, pythonfmu: libraries[guarding]}
    content |= documentation(model, ["pythonfmu"])
    content["modelDescription.xml"] = xml_file(model_description(model, guid, *_tool()))
    content["resources/model.bin"] = _data(model, constants, guid)
    content |= linear_state_file(model, constants) | experiment_files(model, constants)
    content["resources/python.txt"] = "\n".join(_this_python()).encode()
    return archive_of(content)


def python_guid(model: Model, constants: Array) -> str:
    """Return an identifier that changes with the interface, the code (including the guard) or the constants."""
    return guid_of(model, constants, "python " + guard_key())


def what_it_needs() -> str:
    """Return a sentence on the requirements of an FMU built here on the importing process."""
    library, _ = _this_python()
    local = f"starts that of this machine, {library}" if library else "cannot run it: this Python is no shared library"
    return (
        "An FMU of flavour python runs in a process that has Python with NumPy; a process without Python "
        f"{local}. FMUs of flavour native need no Python."
    )


def _built_by_pythonfmu(model: Model, constants: Array, guid: str, folder: Path) -> Path:
    """Return the FMU as PythonFMU builds it, in `folder`."""
    stage = folder / "stage"
    (stage / "code").mkdir(parents=True)
    unneeded = shutil.ignore_patterns("__pycache__", "*.md", DOCUMENTATION, bootstrap.BUILD_ONLY)
    for name in model.packages:
        shutil.copytree(package_folder(name), stage / "code" / name, ignore=unneeded)
    script = shutil.copy2(_script(model), stage)
    shutil.copy2(bootstrap.__file__, stage)
    np.save(stage / "constants.npy", np.ascontiguousarray(constants, dtype=np.float64))
    (stage / "layout.json").write_text(json.dumps(dict(model.layout), indent=1), encoding="utf-8")
    (stage / "build.json").write_text(json.dumps(_build_facts(model, guid), indent=1), encoding="utf-8")
    script_helper = bootstrap.__name__.split(".")[-1] + ".py"
    files = [stage / name for name in ("code", script_helper, "constants.npy", "layout.json", "build.json")]
    with _restoring_interpreter():
        return Path(FmuBuilder.build_FMU(script, dest=folder, project_files=files))


def _content(archive: Path) -> dict[str, bytes]:
    with zipfile.ZipFile(archive) as fmu:
        return {name: fmu.read(name) for name in fmu.namelist()}


def _data(model: Model, constants: Array, guid: str) -> bytes:
    """Return the data of the guard: everything except the constants, which kernels in Python read from a file."""
    return model_data(_without_constants(model, constants), np.zeros(0), guid, guard_key())


def _without_constants(model: Model, constants: Array) -> Model:
    """Return a model whose sizes do not depend on its constants, nor those of its parts."""
    n_state, n_work = sizes(model, constants)
    parts = (replace(p, model=_without_constants(p.model, p.constants), constants=np.zeros(0)) for p in model.parts)
    return replace(model, n_state=n_state, n_work=n_work, parts=tuple(parts))


def _this_python() -> tuple[str, str]:
    """Return library (empty if there is none) and interpreter of this Python, which a host without one starts."""
    name = "python3.dll" if sys.platform == "win32" else str(sysconfig.get_config_var("INSTSONAME"))
    folder = sys.base_prefix if sys.platform == "win32" else sysconfig.get_config_var("LIBDIR")
    library = Path(folder or "", name)
    return str(library) if library.is_file() and library.suffix != ".a" else "", sys.executable


def _script(model: Model) -> Path:
    """Return the script that PythonFMU loads; raises ValueError if the model's package has none."""
    name = model.packages[0] if model.parts else model.name  # a script is that of all assemblies
    script = package_folder(model.packages[0]) / f"{name}_fmu.py"
    if not script.is_file():
        raise ValueError(
            f"model {model.name} has no script {script}; the first of its packages must contain one that names the "
            "model to PythonFMU, such as examples/lag_sensor/lag_sensor/lag_sensor_fmu.py"
        )
    return script


def _build_facts(model: Model, guid: str) -> dict[str, object]:
    packages = digests(model.packages)
    return {"model": model.name, "guid": guid, "version": _tool()[1], "parts": _parts(model), "packages": packages}


def _parts(model: Model) -> dict[str, tuple[str, int, int]]:
    """Return the module with the kernels of each part of an assembly, and where its constants begin and end."""
    places, end = {}, 0
    for part in model.parts:
        kernel = getattr(part.model.step, "py_func", part.model.step)
        places[part.name] = (kernel.__module__, end, end + len(part.constants))
        end += len(part.constants)
    return places


def _tool() -> tuple[str, str]:
    """Return what generates an FMU, and the version of it."""
    local, other = (importlib.metadata.version(name) for name in ("amb-cosim", "pythonfmu"))
    return f"amb-cosim {local} with PythonFMU {other}", local


@contextmanager
def _restoring_interpreter() -> Iterator[None]:
    """Undo the changes that pythonfmu makes to `sys.path` and `sys.modules`."""
    path, modules = list(sys.path), set(sys.modules)
    try:
        yield
    finally:
        sys.path[:] = path
        for name in [n for n in sys.modules if n not in modules and n.endswith(("_fmu", "amb_cosim_bootstrap"))]:
            del sys.modules[name]
