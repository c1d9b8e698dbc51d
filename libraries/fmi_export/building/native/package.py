"""A native FMU: description and libraries in one archive, the same bytes for the same sources."""

from __future__ import annotations

import hashlib
import importlib.metadata
import json
import zipfile
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path
from platform import machine
from xml.etree import ElementTree

import numpy as np
import platformdirs

from amb_files.atomic import write_atomically
from fmi_export.building.description import model_description
from fmi_export.building.native.compiler import (
    PLATFORMS,
    check_compiler,
    check_platforms,
    compile_library,
    host_platform,
)
from fmi_export.building.native.lowering import lower
from fmi_export.building.native.tables import model_source, sizes_header
from fmi_export.building.python_fmu import digests, guid_of
from fmi_export.model import Array, Model

HERE = Path(__file__).parent
C_SOURCES = ("fmi2.h", "model.h", "instance.h", "instance.c", "slave.c")
NO_TIME = (1980, 1, 1, 0, 0, 0)  # the earliest time that a zip archive can store


def build_native_fmu(model: Model, constants: Array, folder: Path, platforms: Iterable[str] | None = None) -> Path:
    """Write `<model.name>.fmu` into `folder` and return its path; the file appears complete or not at all.

    Parameters
    ----------
    model
        The model to export.
    constants
        Its constants, flat float64.
    folder
        Where the FMU goes; made if it is missing.
    platforms
        FMI names of the platforms that it runs on, or `all`; this machine's by default. See `compiler.PLATFORMS`.

    Raises
    ------
    ValueError
        If a platform is not known, the compiler is missing, or a kernel needs Python when it runs.
    """
    chosen = check_platforms([host_platform()] if platforms is None else platforms)
    check_compiler()
    sources = native_sources(model, constants)
    content = {"modelDescription.xml": _description(model, native_guid(model, constants))}
    content["resources/layout.json"] = json.dumps(dict(model.layout), indent=1).encode()
    for platform in chosen:
        library = f"binaries/{platform}/{model.name}{PLATFORMS[platform][0]}"
        content[library] = compile_library(model.name, sources, platform)
    return _write(folder / f"{model.name}.fmu", content)


def native_sources(model: Model, constants: Array) -> dict[str, str]:
    """Return the sources of a library by file name: the slave, the model's tables, its lowered kernels."""
    constants = np.ascontiguousarray(constants, dtype=np.float64)
    sources = {name: (HERE / name).read_text(encoding="utf-8") for name in C_SOURCES}
    return sources | {
        "sizes.h": sizes_header(model, constants),
        "model.c": model_source(model, constants, native_guid(model, constants)),
        "kernels.ll": lowered(model),
    }


def native_guid(model: Model, constants: Array) -> str:
    """Return an identifier that changes with the interface, the code (of the native slave too) or the constants."""
    return guid_of(model, constants, "native " + _own_digest())


def lowered(model: Model) -> str:
    """Return the lowered kernels, from the user's cache where they are there: they depend on code alone."""
    code = [(HERE / name).read_text(encoding="utf-8") for name in ("lowering.py", "runtime.ll")]
    facts = json.dumps([digests(model), code, _versions("numba", "llvmlite"), machine()])
    key = hashlib.sha256(facts.encode()).hexdigest()[:32]
    kept = platformdirs.user_cache_path("amb-cosim", appauthor=False) / f"kernels-{model.name}-{key}.ll"
    if kept.is_file():
        return kept.read_text(encoding="utf-8")
    assembly = lower(model)
    with suppress(OSError):  # without a cache the next build takes as long
        kept.parent.mkdir(parents=True, exist_ok=True)
        write_atomically(kept, lambda path: path.write_bytes(assembly.encode()))
    return assembly


def _description(model: Model, guid: str) -> bytes:
    versions = _versions("amb-cosim", "numba", "ziglang")
    tool = "amb-cosim {amb-cosim} with numba {numba}, ziglang {ziglang}".format(**versions)
    root = model_description(model, guid, tool, versions["amb-cosim"], needs_tool=False)
    ElementTree.indent(root)
    return bytes(ElementTree.tostring(root, encoding="utf-8", xml_declaration=True))


def _versions(*names: str) -> dict[str, str]:
    return {name: importlib.metadata.version(name) for name in names}


def _own_digest() -> str:
    """Return a hash of the sources of a library besides the model."""
    sha = hashlib.sha256()
    for file in sorted(HERE.glob("*.[chlp]*")):
        sha.update(file.name.encode() + b"\0" + file.read_bytes() + b"\0")
    return sha.hexdigest()


def _write(target: Path, content: dict[str, bytes]) -> Path:
    def archive(path: Path) -> None:
        with zipfile.ZipFile(path, "w") as fmu:
            for name in sorted(content):
                entry = zipfile.ZipInfo(name, NO_TIME)
                entry.compress_type = zipfile.ZIP_DEFLATED
                entry.create_system, entry.external_attr = 3, 0o100644 << 16
                fmu.writestr(entry, content[name], compresslevel=9)

    target.parent.mkdir(parents=True, exist_ok=True)
    write_atomically(target, archive)
    return target
