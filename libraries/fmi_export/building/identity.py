"""Digests of the sources of an FMU; its guid changes only if the sources change."""

from __future__ import annotations

import hashlib
import importlib.util
import json
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from fmi_export import amb_cosim_bootstrap as bootstrap
from fmi_export.model import Array, Model

DOCUMENTATION = "documentation"  # folder of a package with the pictures of its model

DESCRIBING = (  # files here that determine an archive, in addition to code and data
    *("python_fmu.py", "description.py", "description3.py", "arrays.py"),
    *("units.py", "documentation.py", "interface_page.py", "experiment.py", "terminals.py"),
)


def guid_of(model: Model, constants: Array, flavour: str = "") -> str:
    """Return an identifier that changes only if the model, its code, the constants or `flavour` change."""
    sha = hashlib.sha256(model.interface.canonical() + flavour.encode())
    parts = [[part.name, part.model.name, part.every] for part in model.parts]
    facts = [model.name, model.description, [*model.faults.items()], model.step_size, model.variable_step]
    facts += [parts, repr(model.wiring)]
    sha.update(json.dumps(facts).encode())
    for name, digest in digests(model.packages).items():
        sha.update(f"{name} {digest}".encode())
    here, local = Path(__file__).parent, package_folder(model.packages[0])
    for name in DESCRIBING:
        sha.update((here / name).read_bytes())
    for file in (local / "README.md", *sorted((local / DOCUMENTATION).glob("*"))):
        if file.is_file():
            sha.update(file.read_bytes())
    sha.update(np.ascontiguousarray(constants, dtype=np.float64).tobytes())
    text = sha.hexdigest()
    return f"{{{text[:8]}-{text[8:12]}-{text[12:16]}-{text[16:20]}-{text[20:32]}}}"


def digests(packages: Iterable[str]) -> dict[str, str]:
    """Return a hash of the code of each package."""
    return {name: bootstrap.digest(package_folder(name)) for name in packages}


def package_folder(package: str) -> Path:
    """Return the folder of a package; raise ValueError if it is not installed."""
    spec = importlib.util.find_spec(package)
    if spec is None or spec.origin is None:
        raise ValueError(f"package {package} is not installed")
    return Path(spec.origin).parent
