"""The system structure (.ssd) of a prepared run: components, connections, parameter bindings, default experiment.

Only connected connectors are listed, because FMPy sets every listed input in every step, to zero if nothing feeds it.
The system declares connectors only if requested, because libcosim refuses them. SSP defines neither step sizes nor an
order of components, so these are in annotations, one per tool:

    com.opensimulationplatform    libcosim: base step, and the step of each component that has a longer one
    org.openmodelica              OMSimulator: fixed-step master; it refuses components with annotations
    amb-cosim                     this package: base step, order, and signals that feed several inputs
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from lxml import etree

from amb_cosim.cosim.fmu.fmu_interface import FmuInterface, Port
from amb_cosim.cosim.ssp.parameter_values import add_enumerations, add_units, type_of
from amb_cosim.cosim.ssp.schema import NAMESPACES, STRUCTURE, VERSION, document, tag
from amb_cosim.cosim.system.experiment import Plan

TOOL = "amb-cosim"
TOOLS = {
    "osp": "http://opensimulationplatform.com/SSP/OSPAnnotations",
    "oms": "https://raw.githubusercontent.com/OpenModelica/OMSimulator/master/schema/oms.xsd",
    "amb": "urn:amb-cosim:ssp",
}
MASTER = f"{{{TOOLS['amb']}}}Master"


@dataclass(frozen=True)
class Described:
    """A prepared run to describe.

    name
        Name of the system.
    plan, interfaces
        The run, and the interface of each component.
    sources, bindings
        For each component, the paths of its FMU and of its parameter set in the archive.
    generator
        Name and version of this package.
    connectors
        Whether signals and inputs that change are connectors of the system.
    """

    name: str
    plan: Plan
    interfaces: Mapping[str, FmuInterface]
    sources: Mapping[str, str]
    bindings: Mapping[str, str]
    generator: str
    connectors: bool = False

    @property
    def changing(self) -> dict[str, tuple[str, ...]]:
        """Inputs that each connector feeds, by connector: a signal's inputs, or an input that changes in the run."""
        plan, system = self.plan, self.plan.system
        scheduled = {name for _, name, _ in plan.events} | {r.variable for r in plan.ramps}
        scheduled |= {ramp.slope for ramp in plan.ramps if ramp.slope is not None}
        signals = {signal.name: signal.targets for signal in system.signals}
        return signals | {name: (name,) for name in sorted(scheduled) if name not in signals}

    def port(self, name: str) -> Port:
        """Return the variable of a signal or input."""
        component, variable = self.plan.system.split(self.plan.system.first_end(name))
        return self.interfaces[component].ports[variable]

    def links(self) -> list[tuple[str | None, str, str, str]]:
        """Return each connection as start element and connector, end element and connector; None means the system."""
        system = self.plan.system
        links: list[tuple[str | None, str, str, str]] = [
            (*system.split(link.source), *system.split(link.target)) for link in system.connections
        ]
        if self.connectors:
            links += [(None, name, *system.split(end)) for name, ends in self.changing.items() for end in ends]
        return links


def system_structure(run: Described) -> bytes:
    """Return the document of a run."""
    namespaces = {prefix: NAMESPACES[prefix] for prefix in ("ssc", "ssd", "ssv")}
    root = etree.Element(tag("ssd:SystemStructureDescription"), nsmap=namespaces | TOOLS)
    root.attrib.update(dict(version=VERSION, name=run.name, generationTool=run.generator))
    system = etree.SubElement(root, tag("ssd:System"), name="root")
    if run.plan.system.description:
        system.set("description", run.plan.system.description)
    if run.connectors:
        inputs = etree.SubElement(system, tag("ssd:Connectors"))
        for name in run.changing:
            _connector(inputs, name, "input", run.port(name), run.plan.system.first_end(name))
    elements = etree.SubElement(system, tag("ssd:Elements"))
    for component in run.plan.system.components:
        _component(elements, run, component.name)
    connections = etree.SubElement(system, tag("ssd:Connections"))
    for start, source, end, target in run.links():
        link = etree.SubElement(connections, tag("ssd:Connection"))
        link.attrib.update({} if start is None else {"startElement": start})
        link.attrib.update(dict(startConnector=source, endElement=end, endConnector=target))
    if not len(connections):
        system.remove(connections)
    _annotate(system, _openmodelica(run.plan.step_size))
    connected = _connected(run)
    add_enumerations(root, "ssd", connected)
    units = {p.unit: p for p in connected.values() if p.unit and p.definition is not None and p.type == "Real"}
    if units:
        add_units(etree.SubElement(root, tag("ssd:Units")), units.values())
    _experiment(root, run)
    return document(root, STRUCTURE)


def _connected(run: Described) -> dict[str, Port]:
    """Return the variables that are connectors of components, by `component.variable`."""
    ends = [end for start, source, *target in run.links() for end in ((start, source), tuple(target))]
    return {f"{c}.{variable}": run.interfaces[c].ports[variable] for c, variable in ends if c is not None}


def _component(elements: Any, run: Described, name: str) -> None:
    element = etree.SubElement(elements, tag("ssd:Component"), name=name, source=run.sources[name])
    element.set("type", "application/x-fmu-sharedlibrary")
    element.set("implementation", "CoSimulation")
    ends = [(start, source) for start, source, _, _ in run.links()] + [(end, target) for *_, end, target in run.links()]
    used = dict.fromkeys(variable for component, variable in ends if component == name)
    ports = run.interfaces[name].ports
    if used:
        connectors = etree.SubElement(element, tag("ssd:Connectors"))
        for variable in used:
            _connector(connectors, variable, ports[variable].causality, ports[variable], f"{name}.{variable}")
    if name in run.bindings:
        bindings = etree.SubElement(element, tag("ssd:ParameterBindings"))
        etree.SubElement(bindings, tag("ssd:ParameterBinding"), source=run.bindings[name])
    every = next(c.every for c in run.plan.system.components if c.name == name)
    if every > 1:
        hint = etree.Element(tag("osp:StepSizeHint", TOOLS), value=repr(every * run.plan.step_size))
        _annotate(element, ("com.opensimulationplatform", hint))


def _connector(parent: Any, name: str, kind: str, port: Port, enumeration: str) -> None:
    connector = etree.SubElement(parent, tag("ssd:Connector"), name=name, kind=kind)
    typed = etree.SubElement(connector, tag(f"ssc:{type_of(port)}"))
    if port.items:
        typed.set("name", enumeration)
    if port.type == "Real" and port.unit and port.definition is not None:
        typed.set("unit", port.unit)


def _experiment(root: Any, run: Described) -> None:
    plan = run.plan
    experiment = etree.SubElement(root, tag("ssd:DefaultExperiment"))
    experiment.set("startTime", repr(plan.time(plan.first)))
    experiment.set("stopTime", repr(plan.time(plan.last)))
    algorithm = etree.Element(tag("osp:Algorithm", TOOLS))
    etree.SubElement(algorithm, tag("osp:FixedStepAlgorithm", TOOLS), baseStepSize=repr(plan.step_size))
    master = etree.Element(MASTER, stepSize=repr(plan.step_size), coupling=run.plan.system.coupling)
    for component in plan.system.components:
        etree.SubElement(master, tag("amb:Step", TOOLS), component=component.name, every=str(component.every))
    for signal in plan.system.signals:
        element = etree.SubElement(master, tag("amb:Signal", TOOLS), name=signal.name)
        for end in signal.targets:
            etree.SubElement(element, tag("amb:Target", TOOLS), name=end)
    _annotate(experiment, ("com.opensimulationplatform", algorithm), (TOOL, master))


def _openmodelica(step_size: float) -> tuple[str, Any]:
    annotations = etree.Element(tag("oms:Annotations", TOOLS))
    information = etree.SubElement(annotations, tag("oms:SimulationInformation", TOOLS))
    master = etree.SubElement(information, tag("oms:FixedStepMaster", TOOLS), description="oms-ma")
    master.attrib.update(dict(stepSize=f"{step_size:.9f}", absoluteTolerance="0.0001", relativeTolerance="0.0001"))
    return "org.openmodelica", annotations


def _annotate(parent: Any, *annotations: tuple[str, Any]) -> None:
    group = etree.SubElement(parent, tag("ssd:Annotations"))
    for kind, content in annotations:
        etree.SubElement(group, tag("ssc:Annotation"), type=kind).append(content)
