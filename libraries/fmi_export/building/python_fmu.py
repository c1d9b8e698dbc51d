"""Builds the pythonfmu flavour of a model: script, code, constants and description in one archive."""

from __future__ import annotations

import importlib.metadata
import json
import shutil
import sys
import tempfile
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path

import numpy as np
from pythonfmu.builder import FmuBuilder

from amb_files.atomic import write_atomically
from fmi_export import amb_cosim_bootstrap as bootstrap
from fmi_export.building.documentation import documentation
from fmi_export.building.identity import DOCUMENTATION, digests, guid_of, package_folder
from fmi_export.model import Array, Model


def build_python_fmu(model: Model, constants: Array, folder: Path) -> Path:
    """Write `<model.name>.fmu` into `folder` and return its path; the file appears complete or not at all.

    Parameters
    ----------
    model
        The model to export.
    constants
        Its constants, flat float64.
    folder
        Where the FMU goes; made if it is missing.
    """
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix="fmu-") as temporary:
        stage = Path(temporary) / "stage"
        (stage / "code").mkdir(parents=True)
        unneeded = shutil.ignore_patterns("__pycache__", "*.md", DOCUMENTATION, bootstrap.BUILD_ONLY)
        for name in model.packages:
            shutil.copytree(package_folder(name), stage / "code" / name, ignore=unneeded)
        script = shutil.copy2(_script(model), stage)
        shutil.copy2(bootstrap.__file__, stage)
        np.save(stage / "constants.npy", np.ascontiguousarray(constants, dtype=np.float64))
        (stage / "layout.json").write_text(json.dumps(dict(model.layout), indent=1), encoding="utf-8")
        (stage / "build.json").write_text(json.dumps(_build_facts(model, constants), indent=1), encoding="utf-8")
        script_helper = bootstrap.__name__.split(".")[-1] + ".py"
        files = [stage / name for name in ("code", script_helper, "constants.npy", "layout.json", "build.json")]
        with _restoring_interpreter():
            built = FmuBuilder.build_FMU(script, dest=Path(temporary), project_files=files)
        with zipfile.ZipFile(built, "a", zipfile.ZIP_DEFLATED) as archive:
            for name, content in documentation(model, ["pythonfmu"]).items():
                archive.writestr(name, content)
        target = folder / f"{model.name}.fmu"
        write_atomically(target, partial(shutil.copyfile, built))
    return target


def _script(model: Model) -> Path:
    """Return the script that PythonFMU loads; raises ValueError if the model's package has none."""
    script = package_folder(model.packages[0]) / f"{model.name}_fmu.py"
    if not script.is_file():
        raise ValueError(
            f"model {model.name} has no script {script}; the first of its packages must contain one that names the "
            "model to PythonFMU, such as examples/lag_sensor/lag_sensor/lag_sensor_fmu.py"
        )
    return script


def _build_facts(model: Model, constants: Array) -> dict[str, object]:
    versions = {name: importlib.metadata.version(name) for name in ("amb-cosim", "pythonfmu")}
    return {
        "model": model.name,
        "guid": guid_of(model, constants),
        "version": versions["amb-cosim"],
        "tool": f"amb-cosim {versions['amb-cosim']} with PythonFMU {versions['pythonfmu']}",
        "packages": digests(model.packages),
    }


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
