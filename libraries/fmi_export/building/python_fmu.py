"""Builds the pythonfmu flavour of a model: script, code, constants and description in one archive."""

from __future__ import annotations

import hashlib
import importlib.metadata
import importlib.util
import json
import shutil
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path

import numpy as np
from pythonfmu.builder import FmuBuilder

from amb_files.atomic import write_atomically
from fmi_export import amb_cosim_bootstrap as bootstrap
from fmi_export.model import Array, Model


def guid_of(model: Model, constants: Array, flavour: str = "") -> str:
    """Return an identifier that changes with the interface, the code, the constants or `flavour`, with nothing else."""
    sha = hashlib.sha256(model.interface.canonical() + flavour.encode())
    for name, digest in digests(model).items():
        sha.update(f"{name} {digest}".encode())
    for name in ("python_fmu.py", "description.py", "units.py"):  # they decide what an archive and its description hold
        sha.update((Path(__file__).parent / name).read_bytes())
    sha.update(np.ascontiguousarray(constants, dtype=np.float64).tobytes())
    text = sha.hexdigest()
    return f"{{{text[:8]}-{text[8:12]}-{text[12:16]}-{text[16:20]}-{text[20:32]}}}"


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
        unneeded = shutil.ignore_patterns("__pycache__", bootstrap.BUILD_ONLY)
        for name in model.packages:
            shutil.copytree(_folder(name), stage / "code" / name, ignore=unneeded)
        script = shutil.copy2(_script(model), stage)
        shutil.copy2(bootstrap.__file__, stage)
        np.save(stage / "constants.npy", np.ascontiguousarray(constants, dtype=np.float64))
        (stage / "layout.json").write_text(json.dumps(dict(model.layout), indent=1), encoding="utf-8")
        (stage / "build.json").write_text(json.dumps(_build_facts(model, constants), indent=1), encoding="utf-8")
        script_helper = bootstrap.__name__.split(".")[-1] + ".py"
        files = [stage / name for name in ("code", script_helper, "constants.npy", "layout.json", "build.json")]
        with _restoring_interpreter():
            built = FmuBuilder.build_FMU(script, dest=Path(temporary), project_files=files)
        target = folder / f"{model.name}.fmu"
        write_atomically(target, partial(shutil.copyfile, built))
    return target


def _script(model: Model) -> Path:
    """Return the script that PythonFMU loads; raises ValueError if the model's package has none."""
    script = _folder(model.packages[0]) / f"{model.name}_fmu.py"
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
        "packages": digests(model),
    }


def digests(model: Model) -> dict[str, str]:
    """Return a hash of each package that the model's kernels need."""
    return {name: bootstrap.digest(_folder(name)) for name in model.packages}


def _folder(package: str) -> Path:
    spec = importlib.util.find_spec(package)
    if spec is None or spec.origin is None:
        raise ValueError(f"package {package} is not installed")
    return Path(spec.origin).parent


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
