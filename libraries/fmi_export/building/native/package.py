"""A native FMU: description, engines and data in a single archive; the same sources give the same bytes."""

from __future__ import annotations

import importlib.metadata
import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any, Literal

from amb_files.archive import archive_of, write_archive
from fmi_export.building.arrays import without_arrays
from fmi_export.building.description import model_description, xml_file
from fmi_export.building.description3 import NOTES, model_description3, variable_notes
from fmi_export.building.documentation import documentation
from fmi_export.building.experiment import experiment_files
from fmi_export.building.identity import guid_of
from fmi_export.building.native.compiler import FOLDERS3, TARGETS, check_platforms, host_platform
from fmi_export.building.native.data import linear_state_file, model_data
from fmi_export.building.native.engines import engine, engine_key
from fmi_export.building.native.portable import build_description, compiled_files, portable_sources
from fmi_export.building.terminals import FILE as TERMINALS
from fmi_export.building.terminals import terminals
from fmi_export.model import Array, Model

Fmi = Literal[2, 3]  # version
ICON, ICON3 = "model.png", "terminalsAndIcons/icon.png"  # where importers look for it, in FMI 3.0 the latter


def build_native_fmu(model: Model, constants: Array, folder: Path, *options: Any, **named: Any) -> Path:
    """Write `native_fmu(model, constants, ...)` to `<model.name>.fmu` in `folder` atomically, and return its path.

    The folder is created if it is missing; for the options see `native_fmu`.
    """
    fmu = native_fmu(model, constants, *options, **named)
    folder.mkdir(parents=True, exist_ok=True)
    return write_archive(folder / f"{model.name}.fmu", fmu)


def native_fmu(
    model: Model,
    constants: Array,
    platforms: Iterable[str] | None = None,
    fmi: Fmi = 2,
    arrays: bool = True,
    sources: bool = False,
) -> bytes:
    """Return a native FMU.

    Parameters
    ----------
    model
        The model to export.
    constants
        Constants of the model, a flat float64 array.
    platforms
        FMI names of the platforms, or `all`; by default, the platform of this machine. See `compiler.TARGETS`.
    fmi
        Version of FMI, 2.0 or 3.0. Both have the same engine, the same results, and the same data except the guid.
    arrays
        Whether an FMU of FMI 3.0 has array variables; otherwise each element is a variable, as in FMI 2.0.
    sources
        Whether the FMU contains its C code, for platforms without a library; see `portable`.

    Raises
    ------
    ValueError
        If a platform is unknown, if a message of the model is invalid, or if an engine cannot be compiled.
    """
    if fmi == 3 and not arrays:
        model = without_arrays(model)
    chosen = check_platforms([host_platform()] if platforms is None else platforms)
    guid = native_guid(model, constants, fmi)
    data = model_data(model, constants, guid, engine_key(model.compiled))
    engines = {platform: engine(model.compiled, platform) for platform in chosen}
    made_by = sorted({item.made_by for item in engines.values()})
    code = portable_sources(model, fmi) if sources else {}
    content = {"modelDescription.xml": _description(model, guid, made_by, fmi, code), "resources/model.bin": data}
    content |= {f"sources/{name}": text.encode() for name, text in code.items()}
    if code and fmi == 3:
        content["sources/buildDescription.xml"] = build_description(model, code)
    for platform, item in engines.items():
        for place in FOLDERS3[platform] if fmi == 3 else (platform,):
            content[f"binaries/{place}/{model.name}{TARGETS[platform][0]}"] = item.library
    content |= {ICON3 if fmi == 3 and name == ICON else name: file for name, file in documentation(model).items()}
    content["resources/layout.json"] = json.dumps(dict(model.layout), indent=1).encode()
    if fmi == 3:
        content |= {NOTES: variable_notes(model.interface), TERMINALS: terminals(model.interface)}
    content |= linear_state_file(model, constants)
    content |= experiment_files(model, constants, by_slot=fmi == 3)
    return archive_of(content)


def native_guid(model: Model, constants: Array, fmi: Fmi = 2) -> str:
    """Return an identifier that depends on interface, code (including the slave), constants and FMI version."""
    return guid_of(model, constants, f"native {'FMI 3.0 ' if fmi == 3 else ''}{engine_key(model.compiled)}")


def _description(model: Model, guid: str, made_by: list[str], fmi: Fmi, code: Iterable[str]) -> bytes:
    version = importlib.metadata.version("amb-cosim")
    tool = f"amb-cosim {version} with {'; '.join(made_by)}"
    if fmi == 3:
        return xml_file(model_description3(model, guid, tool, version))
    return xml_file(model_description(model, guid, tool, version, needs_tool=False, sources=compiled_files(code)))
