"""Names of SSP in XML, and the check of a document against the schema of SSP 1.0, which FMPy contains."""

from __future__ import annotations

from copy import deepcopy
from functools import cache
from pathlib import Path
from typing import Any

import fmpy
from lxml import etree

from amb_cosim.cosim.ssp import version_2

VERSION = "1.0"
STRUCTURE, PARAMETERS, MAPPING, DICTIONARY = (
    f"SystemStructure{name}.xsd" for name in ("Description", "ParameterValues", "ParameterMapping", "SignalDictionary")
)
NAMESPACES = {
    "ssc": "http://ssp-standard.org/SSP1/SystemStructureCommon",
    "ssd": "http://ssp-standard.org/SSP1/SystemStructureDescription",
    "ssv": "http://ssp-standard.org/SSP1/SystemStructureParameterValues",
    "ssm": "http://ssp-standard.org/SSP1/SystemStructureParameterMapping",
    "ssb": "http://ssp-standard.org/SSP1/SystemStructureSignalDictionary",
}
GROUPS = (
    *(f"ssd:{name}" for name in ("ParameterBindings", "Connectors", "Elements", "Connections", "SignalDictionaries")),
    *(f"{prefix}:{name}" for prefix in ("ssd", "ssv", "ssb") for name in ("Units", "Enumerations", "Annotations")),
)
OWNERS = ("ssd:SystemStructureDescription", "ssd:System", "ssd:Component", "ssv:ParameterSet", "ssb:SignalDictionary")
ORDER = {
    name: k
    for k, name in enumerate(
        (
            *("System", "Connectors", "ElementGeometry", "ParameterBindings", "Elements", "Connections"),
            *("SignalDictionaries", "SystemGeometry", "GraphicalElements", "Parameters", "DictionaryEntry"),
            *("Enumerations", "Units", "DefaultExperiment", "Annotations"),
        )
    )
}


def tag(name: str, namespaces: dict[str, str] | None = None) -> str:
    """Return a qualified name, such as `ssd:System`, as the XML library writes it."""
    prefix, _, local = name.partition(":")
    return f"{{{(namespaces or NAMESPACES)[prefix]}}}{local}"


def document(root: Any, schema: str) -> bytes:
    """Return a document as text, checked against its schema.

    Raises
    ------
    ValueError
        If it does not follow the schema.
    """
    etree.indent(root)
    check(root, schema, "the document")
    return bytes(etree.tostring(root, encoding="UTF-8", xml_declaration=True))


def parse(content: bytes, schema: str, what: str) -> Any:
    """Return the root of a document that follows a schema.

    Raises
    ------
    ValueError
        If it is not XML, or does not follow the schema; the message begins with `what` and contains the line number.
    """
    parser = etree.XMLParser(resolve_entities="internal", no_network=True, remove_comments=True, remove_pis=True)
    try:
        root = etree.fromstring(content, parser)
    except etree.XMLSyntaxError as error:
        raise ValueError(f"{what} is not XML: {error}") from error
    check(root, schema, what)
    return root


def check(root: Any, schema: str, what: str) -> None:
    """Raise a ValueError unless a document follows the schema of its SSP version; the message begins with `what`."""
    loaded, version = _schema(schema), root.get("version")
    checked = version_2.as_version_1(root) if version == version_2.VERSION else root
    if not loaded.validate(checked) and not loaded.validate(_tidied(checked)):
        required_version = version if version == version_2.VERSION else VERSION
        first = loaded.error_log[0]
        raise ValueError(f"{what} is not valid SSP {required_version}; line {first.line}: {first.message}")


def _tidied(root: Any) -> Any:
    """Return a copy without empty groups, in which the other groups are in the order of the schema.

    Some tools write empty groups or use another order; neither changes the meaning of the document.
    """
    copied = deepcopy(root)
    for group in [group for group in copied.iter(*map(tag, GROUPS)) if not len(group)]:
        group.getparent().remove(group)
    for owner in copied.iter(*map(tag, OWNERS)):
        owner[:] = sorted(owner, key=lambda child: ORDER.get(etree.QName(child).localname, len(ORDER)))
    return copied


@cache
def _schema(name: str) -> Any:
    return etree.XMLSchema(file=str(Path(fmpy.__file__).parent / "ssp" / "schema" / name))
