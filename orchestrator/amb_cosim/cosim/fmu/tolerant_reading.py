"""Reads a modelDescription that breaks the rules of FMI, as other importers do, and reports the broken rules.

FMPy checks descriptions against the schema and against further rules. A description that FMPy refuses is read without
that check if it contains everything that a run needs: identifiers, and a name, a type and a value reference for each
variable. Errors that prevent FMPy from reading are corrected first. Parameters with continuous variability (the default
of FMI 2.0) become fixed. Undefined types, and unknowns that refer to no variable, are ignored. A version 2.0.x counts
as 2.0.
"""

from __future__ import annotations

import re
import zipfile
from collections import Counter
from io import BytesIO
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import fmpy

from amb_files.checks import single_line

DESCRIPTION = "modelDescription.xml"
PARAMETERS = ("parameter", "calculatedParameter")


def read_tolerantly(folder: Path) -> tuple[Any, tuple[str, ...]]:
    """Return the description of an extracted FMU, as FMPy returns it, and the rules that this description breaks.

    Raises
    ------
    ValueError
        If it cannot be read; the message gives the first reasons.
    """
    if not (folder / DESCRIPTION).is_file():
        inner = next((path.parent.relative_to(folder) for path in sorted(folder.rglob(DESCRIPTION))), None)
        hint = f"; the content of {inner.as_posix()} must be at the top of the archive" if inner is not None else ""
        raise ValueError(f"it has no {DESCRIPTION}{hint}")
    try:
        description = fmpy.read_model_description(str(folder))
        return description, _identifier_fault(description)
    except Exception as error:  # the check of an invalid description may fail itself
        problems = tuple(map(single_line, getattr(error, "problems", (error,))))
    try:
        description = fmpy.read_model_description(str(folder), validate=False)
    except Exception:
        try:
            description = _read_corrected(folder / DESCRIPTION)
        except Exception as error:
            raise ValueError("; ".join(problems[:3])) from error
    _check_usable(description)
    return description, problems + _identifier_fault(description)


def _identifier_fault(description: Any) -> tuple[str, ...]:
    """Return the rule that an identifier breaks if, like `tank-c`, it is not a valid name in C."""
    identifier = getattr(description.coSimulation, "modelIdentifier", None)
    if identifier is None or re.fullmatch(r"[A-Za-z_]\w*", identifier, re.ASCII):
        return ()
    return (f"modelIdentifier = {identifier!r} is not a valid name in C",)


def _read_corrected(file: Path) -> Any:
    """Return an FMI 2.0 description with a variability for each parameter, and without undefined types and unknowns."""
    root = ElementTree.parse(file).getroot()
    if root.get("fmiVersion", "").partition(".")[0] == "2":
        root.set("fmiVersion", "2.0")
    indices = {str(k + 1) for k in range(len(root.findall("ModelVariables/ScalarVariable")))}
    for group in root.iterfind("ModelStructure/*"):
        for unknown in [unknown for unknown in group if unknown.get("index") not in indices]:
            group.remove(unknown)
    types = {definition.get("name") for definition in root.iterfind("TypeDefinitions/*")}
    for variable in root.iterfind("ModelVariables/ScalarVariable"):
        if variable.get("causality") in PARAMETERS and variable.get("variability", "continuous") == "continuous":
            variable.set("variability", "fixed")
        for type_element in variable:
            if type_element.get("declaredType", "") not in {"", *types}:
                del type_element.attrib["declaredType"]
    with BytesIO() as memory:  # FMPy reads the description of an archive, or of a file
        with zipfile.ZipFile(memory, "w") as archive:
            archive.writestr(DESCRIPTION, ElementTree.tostring(root, encoding="utf-8"))
        return fmpy.read_model_description(memory, validate=False)


def _check_usable(description: Any) -> None:
    """Raise ValueError unless a description contains everything that a run needs."""
    major = description.fmiVersion.partition(".")[0]
    if not description.guid:
        raise ValueError(f"{DESCRIPTION} has no {'instantiationToken' if major == '3' else 'guid'!r}")
    if description.coSimulation is not None and not description.coSimulation.modelIdentifier:
        raise ValueError(f"{DESCRIPTION} has no 'modelIdentifier'")
    for variable in description.modelVariables:
        for attribute in ("name", "type", "valueReference"):
            if getattr(variable, attribute) is None:
                raise ValueError(f"{DESCRIPTION} has a variable {variable.name or ''} without {attribute!r}")
    counts = Counter(variable.name for variable in description.modelVariables)
    duplicates = [name for name, count in counts.items() if count > 1]
    if duplicates:
        raise ValueError(f"{DESCRIPTION} has {counts[duplicates[0]]} variables called {duplicates[0]!r}")
