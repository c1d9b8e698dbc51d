"""The systems of an archive as a flat structure: components, connectors, links and parameter bindings.

An element is identified by its path from the outermost system, such as `axle.motor`. Systems can be nested in the
document, be separate documents or archives within the archive, or refer to a system of a document by its id:

    axle.ssd    axle.ssd#id    axle.ssp    axle.ssp#other.ssd    #id

A source is relative to the document that names it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, NamedTuple
from urllib.parse import unquote, urlsplit

from lxml import etree

from amb_cosim.cosim.building.cache import unpacked
from amb_cosim.cosim.fmu.fmu_interface import UnitDefinition
from amb_cosim.cosim.ssp.parameter_values import READERS
from amb_cosim.cosim.ssp.schema import DICTIONARY, NAMESPACES, STRUCTURE, check, parse, tag
from amb_cosim.cosim.ssp.structure import TOOLS
from amb_cosim.cosim.ssp.unit_conversion import Law, Unit, law_of, suppresses_units, unit_definitions, unit_of
from amb_files.suggestions import suggest

NAMES = {**NAMESPACES, **TOOLS}
FMU, DEFINITION, PACKAGE = (f"application/x-{kind}" for kind in ("fmu-sharedlibrary", "ssp-definition", "ssp-package"))
TYPES = (FMU, DEFINITION, PACKAGE)
HARMLESS = [tag(name) for name in ("ssd:ConnectionGeometry", "ssd:Annotations", "ssc:LinearTransformation")]
MOST_NESTED = 20  # depth of nested systems
Kind = Literal["component", "system", "dictionary"]
OUTERMOST = ("system", "")  # kind and place of the connectors of the outermost system


class Node(NamedTuple):
    """A connector of a component or a system, or an entry of a signal dictionary; `place` is the path of its owner."""

    kind: Kind
    place: str
    name: str

    @property
    def text(self) -> str:
        """Name for messages."""
        return ".".join(part for part in (self.place, self.name) if part)


class Connector(NamedTuple):
    """The kind, the unit and the type of a connector in a document."""

    kind: str
    unit: Unit | None
    type: str | None = None


class Link(NamedTuple):
    """A connection of two connectors, in either direction; indices refer to an element of an array.

    `place` is the path of the system that contains the connection.
    """

    place: str
    start: Node
    end: Node
    start_indices: tuple[int, ...]
    end_indices: tuple[int, ...]
    law: Law | None
    suppresses_units: bool


@dataclass(frozen=True)
class Document:
    """A structure document, the folder to which its sources are relative, and the folder of its archive."""

    root: Any
    folder: Path
    what: str
    archive: Path

    @property
    def units(self) -> Mapping[str, UnitDefinition]:
        """Definitions of the units in the document."""
        return unit_definitions(self.root, "ssd")

    def file(self, source: str, folder: Path | None = None) -> Path:
        """Return the file of a relative URI, in the archive or in `folder`; tools on Windows may write backslashes."""
        base, limit = (self.folder, self.archive) if folder is None else (folder, folder)
        for text in (source, source.replace("\\", "/")):
            uri = urlsplit(text)
            file = (base / unquote(uri.path)).resolve()
            is_local = not (uri.scheme or uri.netloc or uri.fragment) and file.is_relative_to(limit.resolve())
            if is_local and file.is_file():
                return file
        raise ValueError(f"{self.what} has no file {source!r}; sources must be relative paths of files in it")

    def system(self, name: str = "") -> Any:
        """Return the system with an id, by default the outermost one."""
        if not name:
            return self.root.find("ssd:System", NAMES)
        systems = {system.get("id"): system for system in self.root.iter(tag("ssd:System")) if system.get("id")}
        if name not in systems:
            raise ValueError(f"{self.what} has no system with the id {name!r}; {suggest(name, systems)}")
        return systems[name]


class Hierarchy:
    """The elements of all systems of an archive, whose files are in `folder`.

    Attributes
    ----------
    components
        File, element and document of each FMU, in the order of the documents.
    connectors
        All declared connectors; those of an outer system come first.
    links
        All connections.
    bindings
        Path, element and document of everything that can have parameter bindings. Inner elements come first, because
        outer ones take precedence.
    bases
        For each system in a separate document, by the system's path: the folder of this document.

    Raises
    ------
    ValueError
        If the archive has an element that is not supported; the message begins with `what` and names the element.
    """

    def __init__(self, root: Any, folder: Path, what: str) -> None:
        self.components: dict[str, tuple[Path, Any, Document]] = {}
        self.connectors: dict[Node, Connector] = {}
        self.links: list[Link] = []
        self.bindings: list[tuple[str, Any, Document]] = []
        self.bases: dict[str, Path] = {}
        self._elements: dict[str, dict[str, tuple[Kind, str]]] = {}  # kind and path, by the path of their system
        document = Document(root, folder, what, folder)
        self._add_system(document.system(), "", document, {}, 0)
        for node in (end for link in self.links for end in (link.start, link.end)):
            if node.kind != "component" and node not in self.connectors:
                others = [other.name for other in self.connectors if other[:2] == node[:2]]
                inside = f"{node.kind} {node.place}" if node.place else "the system"
                raise ValueError(f"{what}: {inside} has no connector {node.name!r}; {suggest(node.name, others)}")

    def of_systems(self, outermost: bool) -> list[Node]:
        """Return the connectors of the outermost system, or those of all other systems and of signal dictionaries."""
        nodes = (node for node in self.connectors if node.kind != "component")
        return [node for node in nodes if (node[:2] == OUTERMOST) == outermost]

    def resolve(self, path: str, name: str) -> Node | None:
        """Return the connector with a hierarchical name in a system or a component; None if there is no such element.

        A name belongs to a connector of the system itself, or begins with the name of an element and a dot.
        """
        if path in self.components:
            return Node("component", path, name)
        system = Node("system", path, name)
        if system in self.connectors:
            return system
        for element, (kind, place) in self._elements[path].items():
            if name.startswith(f"{element}."):
                rest = name[len(element) + 1 :]
                return self.resolve(place, rest) if kind == "system" else Node(kind, place, rest)
        return None

    def _add_system(
        self, system: Any, path: str, document: Document, dictionaries: dict[str, str], depth: int
    ) -> tuple[Kind, str]:
        if depth > MOST_NESTED:
            raise ValueError(
                f"{document.what}: {path} is nested too deeply; at most {MOST_NESTED} levels are supported"
            )
        self._add_connectors("system", path, system, document)
        dictionaries = dictionaries | {
            dictionary.get("name"): self._add_dictionary(dictionary, path, document)
            for dictionary in system.iterfind("ssd:SignalDictionaries/ssd:SignalDictionary", NAMES)
        }
        elements = self._elements[path] = {}
        for element in system.iterfind("ssd:Elements/*", NAMES):
            name = element.get("name")
            place = f"{path}.{name}" if path else name
            if name in elements:
                raise ValueError(f"{document.what}: two elements are called {place}")
            if "." in name:
                raise ValueError(f"{document.what}: element {place} has a dot in its name, which is not supported")
            if element.tag == tag("ssd:System"):
                elements[name] = self._add_system(element, place, document, dictionaries, depth + 1)
            elif element.tag == tag("ssd:SignalDictionaryReference"):
                dictionary = element.get("dictionary")
                if dictionary not in dictionaries:
                    hint = suggest(dictionary, dictionaries)
                    raise ValueError(f"{document.what}: {place} refers to no signal dictionary {dictionary!r}; {hint}")
                elements[name] = "dictionary", dictionaries[dictionary]
            else:
                elements[name] = self._add_component(element, place, document, depth)
        for link in system.iterfind("ssd:Connections/ssd:Connection", NAMES):
            self.links.append(self._link(link, path, document))
        self.bindings.append((path, system, document))
        return "system", path

    def _add_connectors(self, kind: Kind, place: str, element: Any, document: Document) -> None:
        units = document.units
        for connector in element.iterfind("ssd:Connectors/ssd:Connector", NAMES):
            node = Node(kind, place, connector.get("name"))
            declared = Connector(connector.get("kind"), _unit(connector, units), _type(connector))
            self.connectors.setdefault(node, declared)

    def _add_component(self, element: Any, place: str, document: Document, depth: int) -> tuple[Kind, str]:
        kind = element.get("type") or FMU
        if kind not in TYPES:
            raise ValueError(f"{document.what}: component {place} is of type {kind}, which is not supported")
        kind_and_path: tuple[Kind, str] = "component", place
        if kind == FMU:
            self.components[place] = document.file(element.get("source")), element, document
            self._add_connectors("component", place, element, document)
        else:
            inner, system = _referenced(document, element.get("source"), kind == PACKAGE)
            kind_and_path = self._add_system(system, place, inner, {}, depth + 1)
            self.bases[place] = inner.folder
        self.bindings.append((place, element, document))
        return kind_and_path

    def _add_dictionary(self, dictionary: Any, path: str, document: Document) -> str:
        """Add the entries of a signal dictionary, and return its path."""
        name, source = dictionary.get("name"), dictionary.get("source")
        place = f"{path}.{name}" if path else name
        if source is None:
            content = dictionary.find("ssb:SignalDictionary", NAMES)
            if content is None:
                raise ValueError(f"{document.what}: signal dictionary {place} contains no SSP entries")
            check(content, DICTIONARY, f"{document.what}: signal dictionary {place}")
        else:
            content = parse(document.file(source).read_bytes(), DICTIONARY, f"{document.what}: {source}")
        units = {**document.units, **unit_definitions(content, "ssb")}
        for entry in content.iterfind("ssb:DictionaryEntry", NAMES):
            self.connectors[Node("dictionary", place, entry.get("name"))] = Connector("inout", _unit(entry, units))
        return place

    def _link(self, link: Any, path: str, document: Document) -> Link:
        start, end = (self._end(link, side, path, document) for side in ("start", "end"))
        for element in link:
            if element.tag not in HARMLESS:
                kind = etree.QName(element).localname
                raise ValueError(
                    f"{document.what}: the connection from {start.text} transforms its value by {kind}, which is not "
                    f"supported in connections"
                )
        first, last = (tuple(map(int, link.get(f"{side}Indices", "").split())) for side in ("start", "end"))
        return Link(path, start, end, first, last, law_of(link), suppresses_units(link))

    def _end(self, link: Any, side: str, path: str, document: Document) -> Node:
        """Return the connector at one side of a connection in a system."""
        elements, element, name = self._elements[path], link.get(f"{side}Element"), link.get(f"{side}Connector")
        if not element:
            return Node("system", path, name)
        if element not in elements:
            inside = f" of {path}" if path else ""
            raise ValueError(
                f"{document.what}: a connection{inside} names no element {element!r}; {suggest(element, elements)}"
            )
        return Node(*elements[element], name)


def _referenced(document: Document, source: str, is_package: bool) -> tuple[Document, Any]:
    """Return the document and the system of a component that is itself a system."""
    path, _, part = source.partition("#")
    if not path:
        return document, document.system(part)
    file, what, archive = document.file(path), f"{document.what}: {path}", document.archive
    if is_package:
        archive = unpacked(file, what)
        file, part = Document(None, archive, what, archive).file(part or "SystemStructure.ssd"), ""
    inner = Document(parse(file.read_bytes(), STRUCTURE, what), file.parent, what, archive)
    return inner, inner.system(part)


def _unit(connector: Any, units: Mapping[str, UnitDefinition]) -> Unit | None:
    """Return the unit that the type of a connector states, if it states one."""
    return next((unit_of(kind.get("unit"), units) for kind in connector if kind.get("unit")), None)


def _type(connector: Any) -> str | None:
    """Return the type of a connector, such as Real, if it has one."""
    return next((name for kind in connector if (name := etree.QName(kind).localname) in READERS), None)


def number_of(root: Any, path: str, name: str) -> float | None:
    """Return an attribute of an element as a number, if there is one."""
    element = root.find(path, NAMES)
    return None if element is None or element.get(name) is None else float(element.get(name))
