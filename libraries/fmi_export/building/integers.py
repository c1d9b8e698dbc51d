"""Copies an FMU for hosts that ignore Enumerations: ecos ignores the values, and libcosim ignores the variables."""

from __future__ import annotations

import zipfile
from io import BytesIO
from xml.etree import ElementTree

DESCRIPTION = "modelDescription.xml"


def with_integers(fmu: bytes) -> bytes:
    """Return an FMI 2.0 FMU whose Enumerations are described as Integers.

    Nothing else changes, because the same functions set and read values of both types.
    """
    memory = BytesIO()
    with zipfile.ZipFile(BytesIO(fmu)) as values, zipfile.ZipFile(memory, "w", zipfile.ZIP_DEFLATED) as copy:
        for entry in values.infolist():
            content = values.read(entry)
            copy.writestr(entry, _described_as_integers(content) if entry.filename == DESCRIPTION else content)
    return memory.getvalue()


def _described_as_integers(description: bytes) -> bytes:
    root = ElementTree.fromstring(description)
    for types in root.findall("TypeDefinitions"):
        for unused in [kind for kind in types if kind.find("Enumeration") is not None]:
            types.remove(unused)
        if not len(types):
            root.remove(types)
    for variable in root.iterfind("ModelVariables/ScalarVariable/Enumeration"):
        variable.tag = "Integer"
        del variable.attrib["declaredType"]
    return bytes(ElementTree.tostring(root, encoding="utf-8", xml_declaration=True))
