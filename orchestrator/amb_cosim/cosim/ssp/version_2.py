"""Additions of SSP 2.0 to SSP 1.0: arrays, the number types of FMI 3.0, metadata and signatures.

No schema of 2.0 is available. However, both versions use the same namespaces, and a document of 2.0 without these
additions follows the schema of 1.0, which FMPy contains.

Modelica Association, System Structure and Parameterization, version 2.0, 2024, sections 4.5.6, 5.3 and 6.2.
"""

from __future__ import annotations

from copy import deepcopy
from typing import Any

from lxml import etree

VERSION = "2.0"
FLOATS = ("Float64", "Float32")
INTEGERS = tuple(f"{sign}Int{bits}" for bits in (8, 16, 32, 64) for sign in ("", "U"))
ADDED_ELEMENTS = ("Clock", "Dimension", "MetaData", "Signature")
ADDED_ATTRIBUTES = ("startIndices", "endIndices", "systemInnerX", "systemInnerY")
ADDED_KINDS = ("structuralParameter", "constant", "local", "unspecified")


def as_version_1(root: Any) -> Any:
    """Return a copy without additions of 2.0: arrays are replaced by their first elements, numbers by Reals."""
    copied = deepcopy(root)
    copied.set("version", "1.0")
    for element in [element for element in copied.iter("{*}*") if element.tag.startswith("{http://ssp-standard.org/")]:
        name, parent = etree.QName(element), element.getparent()
        if name.localname in ADDED_ELEMENTS:
            parent.remove(element)
            continue
        if name.localname in (*FLOATS, *INTEGERS):
            element.tag = f"{{{name.namespace}}}Real"
        if element.get("kind") in ADDED_KINDS:
            element.set("kind", "parameter")
        for attribute in ADDED_ATTRIBUTES:
            element.attrib.pop(attribute, None)
        if parent is not None and etree.QName(parent).localname == "Parameter" and element is parent[0]:
            element.set("value", next(iter(texts_of(element)), ""))
            del element[:]
    return copied


def texts_of(element: Any) -> list[str]:
    """Return the values of a parameter as text, row by row, from its element `value` or its children `Value`."""
    children = [child.get("value", "") for child in element]
    if children or etree.QName(element).localname in ("Enumeration", "String", "Binary"):
        return children or [element.get("value", "")]
    return str(element.get("value", "")).split()
