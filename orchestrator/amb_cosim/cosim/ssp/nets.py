"""Nets of connected connectors: the inputs that an output, or a connector of the outermost system, reaches.

Values pass from a component's output through connectors of systems and entries of signal dictionaries to inputs of
components. At each connection, a value is converted to the unit of the next connector, unless the conversion is
suppressed. It is then transformed by the law of the connection. At a connector without a unit, the value keeps its
unit.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

from amb_cosim.cosim.fmu.fmu_interface import FmuInterface
from amb_cosim.cosim.ssp.hierarchy import OUTERMOST, Hierarchy, Link, Node
from amb_cosim.cosim.ssp.unit_conversion import Law, Unit, composed, conversion, unit_of
from amb_cosim.cosim.system.system import UNCHANGED

SUPPLIES = {"output": True, "calculatedParameter": True} | dict.fromkeys(
    ("input", "parameter", "structuralParameter"), False
)  # whether a connector of a kind supplies the value of a connection around its component or system


class Route(NamedTuple):
    """The route of a value from a source to a connector, with the law that is applied to the value on this route.

    `presumed` is the unit that the law assumes at the source, and `unit` is the unit of the value at the connector.
    Each is None if there is no unit. Indices refer to an element of an array.
    """

    source: Node
    node: Node
    law: Law
    presumed: Unit | None
    unit: Unit | None
    start_indices: tuple[int, ...]
    end_indices: tuple[int, ...]


class Nets:
    """The connections of an archive as nets.

    Parameters
    ----------
    hierarchy
        The structure.
    interfaces
        The interfaces of its components.
    what
        The archive, for messages.
    """

    def __init__(self, hierarchy: Hierarchy, interfaces: Mapping[str, FmuInterface], what: str) -> None:
        self._connectors, self._interfaces, self.what = hierarchy.connectors, interfaces, what
        self._links_at: dict[Node, list[tuple[Link, bool]]] = {}
        for link in hierarchy.links:
            self._links_at.setdefault(link.start, []).append((link, True))
            self._links_at.setdefault(link.end, []).append((link, False))
            self._check_direction(link)
        self._arrival: dict[Node, Link] = {}  # by which the value of a net reaches each connector
        self.delivered: dict[Node, Route] = {}  # to each connector of the outermost system that an output reaches

    def _check_direction(self, link: Link) -> None:
        """Raise a ValueError unless one end of a connection can supply a value and the other end can receive it.

        Connections between two components are checked later, together with the whole system, against the variables of
        their FMUs.
        """
        for end in (link.start, link.end):
            kinds = self._connectors[end].kind if end in self._connectors else "", self.causality(end)
            if {SUPPLIES.get(kind) for kind in kinds} == {True, False}:
                raise ValueError(
                    f"{self.what}: the connected {end.text} has the kind {kinds[0]}, but the causality {kinds[1]} in "
                    f"its FMU"
                )
        supplies = [self._supplies(end, link.place) for end in (link.start, link.end)]
        if supplies[0] is supplies[1] is not None and not link.start.kind == link.end.kind == "component":
            ends = " and ".join(f"{end.text} ({self.causality(end)})" for end in (link.start, link.end))
            problem = "both supply a value" if supplies[0] else "neither supplies a value"
            system = f" of system {link.place}" if link.place else ""
            raise ValueError(f"{self.what}: a connection{system} joins {ends}; {problem}")

    def _supplies(self, node: Node, place: str) -> bool | None:
        """Return whether a connector is the source of a connection in system `place`; None if it may be either end."""
        supplies = SUPPLIES.get(self.causality(node))
        is_inside = (node.kind, node.place) == ("system", place)
        return not supplies if is_inside and supplies is not None else supplies

    def causality(self, node: Node) -> str:
        """Return the causality of a connector: for a component, from its FMU; otherwise, from the document."""
        if node.kind == "component":
            ports = self._interfaces[node.place].elements(node.name)
            if ports:
                return ports[0].causality
        declared = self._connectors.get(node)
        return "" if declared is None else declared.kind

    def unit(self, node: Node) -> Unit | None:
        """Return the unit of a connector, if any; the unit that an FMU states for its variable takes precedence."""
        declared = self._connectors.get(node)
        unit = None if declared is None else declared.unit
        if node.kind != "component":
            return unit
        port = next(iter(self._interfaces[node.place].elements(node.name)), None)
        if port is None or not port.unit:
            return unit
        unit = unit_of(port.unit) if port.definition is None else Unit(port.unit, port.definition)
        return None if unit is None else unit._replace(relative=port.relative)

    @property
    def outputs(self) -> list[Node]:
        """The connected outputs of components."""
        return [node for node in self._links_at if node.kind == "component" and self.causality(node) == "output"]

    def has_source(self, node: Node) -> bool:
        """Return whether `claim` has been called for a source that feeds a connector."""
        return node in self._arrival

    def claim(self, start: Node) -> list[Route]:
        """Return the routes to everything that a source reaches, and record how its value arrives at each connector."""
        return list(self._spread(start, self.unit(start), claims=True))

    def below(self, node: Node, unit: Unit | None) -> list[Route]:
        """Return the routes onward from a connector; `unit` is the unit of its value."""
        return list(self._spread(node, self.unit(node) or unit, claims=False))

    def _spread(self, start: Node, unit: Unit | None, claims: bool) -> Iterator[Route]:
        queue = [(Route(start, start, UNCHANGED, unit, unit, (), ()), self._arrival.get(start))]
        seen = {start}
        while queue:
            here, arrival = queue.pop(0)
            for link, forward in self._links_at.get(here.node, ()):
                node = link.end if forward else link.start
                if link is arrival or node in seen:
                    continue
                from_indices, to_indices = (link.start_indices, link.end_indices)[:: 1 if forward else -1]
                if (here.node != start and from_indices) or (node.kind != "component" and to_indices):
                    raise ValueError(
                        f"{self.what}: the connection of {here.node.text} and {node.text} has indices at a connector "
                        f"of a system, which is not supported"
                    )
                law, after = self._passed(link, here.node, here.unit, node)
                total = composed(here.law, law)
                is_same = total == UNCHANGED and not link.suppresses_units
                presumed = here.presumed or (self.unit(node) if is_same else None)
                route = Route(start, node, total, presumed, after, here.start_indices or from_indices, to_indices)
                if node.kind == "component":
                    yield route
                    continue
                seen.add(node)
                if claims:
                    self._arrival.setdefault(node, link)
                    if node[:2] == OUTERMOST:
                        self.delivered.setdefault(node, route)
                queue.append((route, link))

    def _passed(self, link: Link, source: Node, unit: Unit | None, target: Node) -> tuple[Law, Unit | None]:
        """Return the law of a connection in this direction, and the unit of the value after it."""
        expected, law = self.unit(target), link.law or UNCHANGED
        if expected is None:
            return law, unit if link.law is None and not link.suppresses_units else None
        if unit is None or link.suppresses_units:
            return law, expected
        converted = conversion(unit, expected)
        if converted is not None:
            return composed(converted, law), expected
        if link.law is not None:  # which states how one becomes the other
            return law, expected
        raise ValueError(
            f"{self.what}: {source.text} is in {unit.name} and {target.text} is in {expected.name}, which cannot be "
            f"converted; a LinearTransformation or suppressUnitConversion is needed"
        )
