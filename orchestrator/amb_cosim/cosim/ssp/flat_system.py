"""The systems of an archive as a single system: components, connections and signals, and values by component.

A connector of the outermost system that feeds inputs is a signal. Its value takes precedence over the values of the
connected inputs. If a variable has several values, the value of the outer system applies; if several sets of a system
contain it, the last set applies.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from amb_cosim.cosim.fmu.fmu_description import read_interface
from amb_cosim.cosim.fmu.fmu_interface import Port, TextVariable
from amb_cosim.cosim.fmu.fmus import provide
from amb_cosim.cosim.grid.time_grid import in_steps
from amb_cosim.cosim.ssp.bindings import Setting, read_bindings
from amb_cosim.cosim.ssp.hierarchy import NAMES, Hierarchy, Node, number_of
from amb_cosim.cosim.ssp.nets import Nets, Route
from amb_cosim.cosim.ssp.parameter_values import general_type
from amb_cosim.cosim.ssp.structure import MASTER
from amb_cosim.cosim.ssp.unit_conversion import Unit, conversion, unit_of
from amb_cosim.cosim.system.system import UNCHANGED, Component, Connection, Output, Signal
from amb_cosim.cosim.system.values import Raw

TIME = "time"  # name of the times of a record


class FlatSystem:
    """The content of an archive, extracted to `folder`, in the form that a `System` requires."""

    def __init__(self, root: Any, folder: Path, what: str) -> None:
        self.root, self.what = root, what
        self.hierarchy = Hierarchy(root, folder, what)
        components = self.hierarchy.components
        if not components:
            raise ValueError(f"{what} has no component with an FMU; there is nothing to simulate")
        self.files = {name: file for name, (file, _, _) in components.items()}
        self.folders = {name: provide(str(file)).folder for name, file in self.files.items()}
        self.interfaces = {name: read_interface(place, name, self.files[name]) for name, place in self.folders.items()}
        self.nets = Nets(self.hierarchy, self.interfaces, what)
        self._parameters: dict[str, dict[str, Raw]] = {name: {} for name in self.interfaces}
        self._inputs: dict[str, Raw] = {}
        self._unconnected: dict[str, None] = {}  # connectors with a value that reaches nothing
        self.connections = tuple(self._connections())
        outer, inner = (self.hierarchy.of_systems(outermost) for outermost in (True, False))
        self.exposed = {node: self.nets.claim(node) for node in outer if self._is_free(node)}
        for node in inner:
            if self._is_free(node):
                self.nets.claim(node)

    @property
    def fmu_steps(self) -> list[float | None]:
        """The step sizes (s) of the default experiments of the FMUs."""
        return [interface.internal_step for interface in self.interfaces.values()]

    def components(self) -> tuple[Component, ...]:
        """Return the components in the order of the document, with the individual step sizes that annotations state.

        Components that an annotation of this package names are in the order of this annotation, because tools may write
        elements in any order.
        """
        base = number_of(self.root, ".//osp:FixedStepAlgorithm", "baseStepSize")
        every: dict[str, int] = {}
        for name, (_, element, _) in self.hierarchy.components.items():
            hint = number_of(element, ".//osp:StepSizeHint", "value")
            every[name] = max(1, round(in_steps(hint, base))) if hint and base else 1
        order = [step.get("component") for step in self.root.iterfind(f".//{MASTER}/amb:Step", NAMES)]
        named = iter(sorted(set(order) & set(self.files), key=order.index))
        names = [next(named) if name in order else name for name in self.files]
        return tuple(Component(name, str(self.files[name]), every[name]) for name in names)

    def remarks(self) -> tuple[str, ...]:
        """Return notices on everything that does not run as the document states; `values` must be called first."""
        elements = self.hierarchy.components.items()
        exchanged = [name for name, (_, element, _) in elements if element.get("implementation") == "ModelExchange"]
        notices = [f"{name}: the archive requests model exchange; co-simulation is used" for name in exchanged]
        units = ((node, connector.unit, self.nets.unit(node)) for node, connector in self.hierarchy.connectors.items())
        other = [
            f"{node.text} ({declared.name}, in the FMU {unit.name})"
            for node, declared, unit in units
            if declared is not None and unit is not None and conversion(declared, unit) != UNCHANGED
        ]
        for what, differing in (("kinds and types", self._contradictions()), ("units", other)):
            if differing:
                notices.append(f"{what} of connectors are ignored where the FMUs differ: {', '.join(differing)}")
        if self._unconnected:
            notices.append(f"values of connectors that are not connected are ignored: {', '.join(self._unconnected)}")
        if any(node.name == TIME for node in self.nets.delivered):
            notices.append(
                f"the output {TIME} of the archive is not recorded, because the record uses this name for its times"
            )
        return tuple(notices)

    def _contradictions(self) -> list[str]:
        """Return the connectors of components that differ in kind or type from the FMU's variables."""
        found = []
        for node, connector in self.hierarchy.connectors.items():
            port = self._port(node) if node.kind == "component" else None
            if port is None:
                continue
            variability = port.variability if isinstance(port, Port) else ""
            if connector.kind not in ("inout", "unspecified", port.causality, variability):
                found.append(f"{node.text} ({connector.kind}, in the FMU {port.causality})")
            if connector.type is not None and general_type(connector.type) != port.type:
                of_fmu = port.declared if isinstance(port, Port) else port.type
                found.append(f"{node.text} ({connector.type}, in the FMU {of_fmu})")
        return found

    def _port(self, node: Node) -> Port | TextVariable | None:
        """Return the variable of a component's connector, or the first element if the variable is an array."""
        interface = self.interfaces[node.place]
        return interface.texts.get(node.name) or next(iter(interface.elements(node.name)), None)

    def _connections(self) -> Iterator[Connection]:
        """Yield the connections between variables of components."""
        for source in self.nets.outputs:
            for route in self.nets.claim(source):
                if self.nets.causality(route.node) == "output":
                    both = f"{source.text} and {route.node.text}"
                    raise ValueError(f"{self.what}: the outputs {both} are connected to each other")
                outputs = self._ends(source, route.start_indices)
                inputs = self._ends(route.node, route.end_indices)
                if len(outputs) != len(inputs):
                    pair = f"{next(iter(outputs))} ({len(outputs)} values) and {next(iter(inputs))} ({len(inputs)})"
                    raise ValueError(f"{self.what}: a connection joins {pair}; the numbers must be equal")
                self._check_law(route, {**outputs, **inputs})
                factor, offset = route.law
                for output, target in zip(outputs, inputs, strict=True):
                    yield Connection(output, target, factor=factor, offset=offset, converts_units=True)
        for link in self.hierarchy.links:
            ends = (link.start, link.end)
            if all(end.kind == "component" for end in ends) and not set(ends) & set(self.nets.outputs):
                yield Connection(link.start.text, link.end.text)  # of no output; the check of the system refuses it

    def _is_free(self, node: Node) -> bool:
        """Return whether a connector of a system can be set, which requires that no output feeds it."""
        kinds = ("input", "parameter", "structuralParameter", "inout")
        return self.hierarchy.connectors[node].kind in kinds and not self.nets.has_source(node)

    def signals(self, inputs: Mapping[str, Raw]) -> tuple[Signal, ...]:
        """Return signals: the system's connectors that feed inputs, and the signals in this package's annotation.

        A connector without a value does not become a signal if its inputs have different values.
        """
        annotated = {
            signal.get("name"): tuple(end.get("name") for end in signal.iterfind("amb:Target", NAMES))
            for signal in self.root.iterfind(f".//{MASTER}/amb:Signal", NAMES)
        }
        signals = [Signal(name, targets) for name, targets in annotated.items()]
        for node, reached in self.exposed.items():
            for name, fed in self._elements_fed(node, reached).items() if node.name not in annotated else ():
                values = {inputs[target] for target in fed if target in inputs}
                if name in inputs or len(values) < 2:
                    signals.append(self._signal(node, name, fed))
        return tuple(signals)

    def outputs(self) -> tuple[Output, ...]:
        """Return the outputs of the archive: connectors of the outermost system to which outputs of components lead."""
        return tuple(
            output
            for node, value in self.nets.delivered.items()
            if node.name != TIME and self.hierarchy.connectors[node].kind in ("output", "inout")
            for output in self._delivered(node.name, value)
        )

    def _delivered(self, name: str, route: Route) -> Iterator[Output]:
        """Yield an output for a connector, or for each element of an array; the source of an output may be a signal."""
        node = route.source
        sources = self._ends(node, route.start_indices) if node.kind == "component" else {node.text: None}
        self._check_law(route, sources)
        for source in sources:
            place = "" if len(sources) == 1 else source.removeprefix(node.text)
            yield Output(f"{name}{place}", source, None if route.unit is None else route.unit.name, *route.law)

    def _elements_fed(self, node: Node, reached: Iterable[Route]) -> dict[str, dict[str, tuple[Route, Port | None]]]:
        """Return the inputs of components that a connector, or each element of an array, feeds."""
        fed: dict[str, dict[str, tuple[Route, Port | None]]] = {}
        for route in reached:
            if self.nets.causality(route.node) == "input":
                targets = self._ends(route.node, route.end_indices)
                for k, (target, port) in enumerate(targets.items(), 1):
                    place = route.start_indices or ((k,) if len(targets) > 1 else ())
                    name = f"{node.name}[{','.join(map(str, place))}]" if place else node.name
                    fed.setdefault(name, {})[target] = route, port
        return fed

    def _signal(self, node: Node, name: str, fed: Mapping[str, tuple[Route, Port | None]]) -> Signal:
        """Return the signal of a connector, with a separate port unless every input is equal to the signal."""
        laws = {target: route.law for target, (route, _) in fed.items() if route.law != UNCHANGED}
        unit = self._start_unit(node)
        if not laws and len({port.unit for _, port in fed.values() if port is not None and port.unit}) <= 1:
            return Signal(name, tuple(fed))
        for target, (route, port) in fed.items():
            self._check_law(route, {target: port})
        route, first = next(iter(fed.values()))
        factor, offset = route.law
        port = Port(
            name=name,
            type="Real" if first is None else first.type,
            causality="input",
            reference=0,
            unit=None if unit is None else unit.name,
            definition=None if unit is None else unit.definition,
            relative=unit is not None and unit.relative,
            start=0.0 if first is None or not factor else ((first.start or 0.0) - offset) / factor,
            items={} if first is None else first.items,
        )
        return Signal(name, tuple(fed), port, laws)

    def _start_unit(self, node: Node) -> Unit | None:
        """Return the unit of a connector of the system: its own unit, or else the unit of variables that it feeds."""
        declared = self.nets.unit(node)
        if declared is not None or node not in self.exposed:
            return declared
        units = dict.fromkeys(route.presumed for route in self.exposed[node] if route.presumed is not None)
        first = next(iter(units), None)
        for unit in units:
            if first is not None and conversion(first, unit) != UNCHANGED:
                raise ValueError(
                    f"{self.what}: connector {node.name} feeds variables in {first.name} and variables in "
                    f"{unit.name}, so the connector must declare a unit"
                )
        return first

    def values(self) -> tuple[dict[str, dict[str, Raw]], dict[str, Raw], tuple[str, ...]]:
        """Return parameters by component and name, values of inputs and signals by name, and nonexistent names."""
        unknown: dict[str, None] = {}
        settings: list[tuple[Node, Setting]] = []
        for path, element, document in self.hierarchy.bindings:  # values of outer systems take precedence
            resources = self.folders[path] / "resources" if path in self.folders else self.hierarchy.bases.get(path)
            for setting in read_bindings(element, document, resources):
                node = self.hierarchy.resolve(path, setting.name)
                if node is None or not self._exists(node):
                    unknown[f"{path}.{setting.name}" if path else setting.name] = None
                elif node.kind == "system" and self._reaches_nothing(node):
                    self._unconnected[node.text] = None
                else:
                    settings.append((node, setting))
        for node, setting in sorted(settings, key=lambda item: -_depth(item[0])):  # connections take precedence
            if node.kind == "component":
                self._set(node, self._read(node, setting)[0])
            else:
                self._spread(node, setting)
        fed = {link.target for link in self.connections}
        for node, reached in self.exposed.items():
            for name, targets in self._elements_fed(node, reached).items():
                fed |= targets.keys() if name in self._inputs else set()
        inputs = {name: value for name, value in self._inputs.items() if name not in fed}
        return self._parameters, inputs, tuple(unknown)

    def _exists(self, node: Node) -> bool:
        if node.kind == "component":
            interface = self.interfaces[node.place]
            return bool(interface.elements(node.name)) or node.name in interface.texts
        return node in self.hierarchy.connectors

    def _reaches_nothing(self, node: Node) -> bool:
        """Return whether a connector of a system leads to no component, and to no output of the outermost system."""
        return not self.nets.below(node, None) and all(route.source != node for route in self.nets.delivered.values())

    def _spread(self, node: Node, setting: Setting) -> None:
        """Set the values of everything that a connector of a system reaches, and of its signal."""
        values, unit = self._read(node, setting)
        for route in self.nets.below(node, unit):
            (factor, offset), passed = route.law, values
            if route.law != UNCHANGED:
                self._check_law(route, self._ends(route.node, route.end_indices))
                passed = [factor * _checked_number(value, setting.name, self.what) + offset for value in values]
            self._set(route.node, self._selected(passed, route.start_indices, route.node.text), route.end_indices)
        if node in self.exposed:
            for name in self._elements_fed(node, self.exposed[node]):
                place = [int(index) for index in name.removeprefix(node.name).strip("[]").split(",") if index]
                self._inputs[name] = self._selected(values, place, setting.name)[0]

    def _read(self, node: Node, setting: Setting) -> tuple[list[Raw], Unit | None]:
        """Return values, converted to the unit of a connector if it has one, and the unit of the returned values."""
        target, numbers, unit_after = self._start_unit(node), [], None
        ports = self.interfaces[node.place].elements(node.name) if node.kind == "component" else ()
        declared = ports[0].units if ports else {}
        for value in setting.values:
            number: Raw = float(value[0]) if isinstance(value, tuple) else value
            unit = unit_of(value[1], setting.units, declared) if isinstance(value, tuple) else None
            unit_after = target or (unit if setting.law is None and not setting.suppresses_units else None)
            if unit is not None and target is not None and not setting.suppresses_units:
                law = conversion(unit, target)
                if law is None and setting.law is None:
                    raise ValueError(
                        f"{self.what}: {setting.name} = {number} {unit.name}, which cannot be converted to the unit "
                        f"{target.name} of {node.text}"
                    )
                if law not in (None, UNCHANGED):
                    number = law[0] * _checked_number(number, setting.name, self.what) + law[1]
            if setting.law is not None:
                number = setting.law[0] * _checked_number(number, setting.name, self.what) + setting.law[1]
            numbers.append(number)
        return numbers, unit_after

    def _set(self, node: Node, values: Sequence[Raw], indices: tuple[int, ...] = ()) -> None:
        """Set a variable of a component, or the elements of an array."""
        interface = self.interfaces[node.place]
        text = interface.texts.get(node.name)
        if text is not None and len(values) != 1:
            excess = f"{len(values)} values for {node.text}, which is a {text.type}"
            raise ValueError(f"{self.what}: a parameter set has {excess}")
        ports: Sequence[Port | TextVariable] = interface.elements(node.name, indices)
        ports = (text,) if text is not None else ports or (interface.port(node.name, node.place),)
        if len(ports) != len(values):
            raise ValueError(
                f"{self.what}: a parameter set has {len(values)} values for {node.text}, which takes {len(ports)}"
            )
        for port, value in zip(ports, values, strict=True):
            if port.causality == "input":
                self._inputs[f"{node.place}.{port.name}"] = value
            else:
                self._parameters[node.place][port.name] = value

    def _selected(self, values: Sequence[Raw], place: Sequence[int], name: str) -> Sequence[Raw]:
        """Return the value of one element of a one-dimensional array or, if there are no indices, all values."""
        if not place:
            return values
        if len(place) > 1 or not 1 <= place[0] <= len(values):
            raise ValueError(f"{self.what}: {name} has {len(values)} values, but no element {list(place)}")
        return [values[place[0] - 1]]

    def _ends(self, node: Node, indices: tuple[int, ...]) -> dict[str, Port | None]:
        """Return the variables of a component's connector, or of the elements of an array, by their names.

        A connector without a variable is mapped to None, which the check of the system reports.
        """
        ports = self.interfaces[node.place].elements(node.name, indices)
        if indices and not ports:
            raise ValueError(f"{self.what}: {node.text} has no element [{','.join(map(str, indices))}]")
        return {f"{node.place}.{port.name}": port for port in ports} or {node.text: None}

    def _check_law(self, route: Route, ends: Mapping[str, Port | None]) -> None:
        """Raise a ValueError if a route transforms values but not all variables are Reals."""
        for end, port in ends.items() if route.law != UNCHANGED else ():
            if port is not None and port.type != "Real":
                raise ValueError(
                    f"{self.what}: {end} is {port.declared}; only Reals and Floats can be transformed or converted to "
                    f"another unit"
                )


def _depth(node: Node) -> float:
    """Return the depth of a connector; values pass from outer systems to inner systems and to components."""
    if node.kind == "component":
        return math.inf
    return node.place.count(".") + 1 if node.place else 0


def _checked_number(value: Raw, name: str, what: str) -> float:
    if isinstance(value, bool | str):
        raise ValueError(f"{what}: {name} = {value} is not a number and cannot be transformed")
    return float(value)
