"""Reads an SSP archive as a system and an experiment.

It supports: co-simulation FMUs in a single system; connections, with linear transformations of Reals (which require the
loop in Python); connectors of the system, each a signal; parameter bindings of components and of the system, in the
document or in files; the default experiment. The communication step and the order come from annotations (see
`structure`), otherwise the step comes from the FMUs. Parameters that no FMU has are ignored, as SSP allows. Arrays of
SSP 2.0 are supported: a connection of two arrays connects each element, row by row, and indices count from 1, as in FMI
3.0.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, get_args
from urllib.parse import unquote, urlsplit

import fmpy

from amb_cosim.cosim.basics.cache import unpacked
from amb_cosim.cosim.basics.choices import Coupling
from amb_cosim.cosim.basics.time_grid import in_steps
from amb_cosim.cosim.fmu.fmu_description import read_interface
from amb_cosim.cosim.fmu.fmu_interface import FmuInterface, Port
from amb_cosim.cosim.fmu.fmus import provide
from amb_cosim.cosim.ssp.experiment_file import EXPERIMENT
from amb_cosim.cosim.ssp.parameter_values import ParameterValue, read_parameters
from amb_cosim.cosim.ssp.schema import NAMESPACES, PARAMETERS, STRUCTURE, check, parse, tag
from amb_cosim.cosim.ssp.structure import MASTER, TOOLS
from amb_cosim.cosim.system.experiment import Experiment
from amb_cosim.cosim.system.system import Component, Connection, Signal, System
from amb_cosim.cosim.system.system_tables import ExperimentTable
from amb_cosim.cosim.system.values import Raw
from amb_files.toml import read_toml, validate

FMU_TYPES = (None, "application/x-fmu-sharedlibrary")
NAMES = {**NAMESPACES, **TOOLS}
UNCHANGED = (1.0, 0.0)  # factor and offset


def load_ssp(
    path: str | Path, step_size: float | None = None, stop_time: float | None = None
) -> tuple[System, Experiment, dict[str, Raw]]:
    """Return the system of an archive, its experiment, and the initial values of inputs.

    Parameters
    ----------
    path
        The archive.
    step_size, stop_time
        Values (s) in place of the archive's.

    Raises
    ------
    ValueError
        If it is not an archive of SSP 1.0 or 2.0, contains unsupported elements, or lacks a step or a stop time.
    """
    what = f"archive {path}"
    if not Path(path).is_file():
        raise ValueError(f"no {what}")
    folder, _ = unpacked(Path(path), what)
    root = parse(_file(folder, "SystemStructure.ssd", what).read_bytes(), STRUCTURE, f"{what}: SystemStructure.ssd")
    reader = _Reader(root, folder, what)
    parameters, inputs, unknown = reader.values()
    system = System(
        name=Path(path).stem,
        description=reader.system.get("description") or "",
        components=reader.components(),
        connections=tuple(reader.connections()),
        signals=reader.signals(),
        coupling=_coupling(root, what),
        parameters=parameters,
        unknown=unknown,
    )
    local = folder / EXPERIMENT
    if local.is_file():
        table = validate(read_toml(local, f"{what}: {EXPERIMENT}"), ExperimentTable, what)
        experiment = table.experiment()
        end = experiment.stop_time if stop_time is None else stop_time
        experiment = replace(experiment, step_size=step_size or experiment.step_size, stop_time=end)
        return system, experiment, {**inputs, **table.inputs}
    return system, reader.experiment(step_size, stop_time), inputs


def _file(folder: Path, source: str, what: str) -> Path:
    """Return the file of a relative URI within the archive."""
    uri = urlsplit(source)
    file = (folder / unquote(uri.path)).resolve()
    if uri.scheme or uri.netloc or uri.fragment or not file.is_relative_to(folder.resolve()) or not file.is_file():
        raise ValueError(f"{what} has no file {source!r}; sources must be relative paths of files in it")
    return file


class _Reader:
    """The structure of an archive extracted to `folder`."""

    def __init__(self, root: Any, folder: Path, what: str) -> None:
        self.root, self.folder, self.what = root, folder, what
        self.system = root.find("ssd:System", NAMES)
        self.elements: dict[str, Any] = {}
        for element in self.system.iterfind("ssd:Elements/*", NAMES):
            name = element.get("name")
            if element.tag != tag("ssd:Component") or element.get("type") not in FMU_TYPES:
                raise ValueError(
                    f"{what}: element {name} is not an FMU; nested systems and dictionaries are not supported"
                )
            if "." in name or element.get("implementation") == "ModelExchange":
                said = "has a dot in its name" if "." in name else "requires model exchange"
                raise ValueError(f"{what}: component {name} {said}, which is not supported")
            self.elements[name] = element
        self.files = {name: _file(folder, element.get("source"), what) for name, element in self.elements.items()}
        self.folders = {name: provide(str(file)).folder for name, file in self.files.items()}
        self.interfaces = {name: read_interface(place, name, self.files[name]) for name, place in self.folders.items()}

    def components(self) -> tuple[Component, ...]:
        """Return components in the order of the document; their own step sizes come from annotations."""
        base = _number(self.root, ".//osp:FixedStepAlgorithm", "baseStepSize")
        every: dict[str, int] = {}
        for name, element in self.elements.items():
            hint = _number(element, ".//osp:StepSizeHint", "value")
            every[name] = max(1, round(in_steps(hint, base))) if hint and base else 1
        return tuple(Component(name, str(file), every[name]) for name, file in self.files.items())

    def connections(self) -> Iterator[Connection]:
        """Return connections between components."""
        for link in self._links():
            if link.get("startElement") and link.get("endElement"):
                sources, targets = self._ends(link, "start"), self._ends(link, "end")
                if len(sources) != len(targets):
                    said = f"{sources[0]} ({len(sources)} values) and {targets[0]} ({len(targets)})"
                    raise ValueError(f"{self.what}: a connection joins {said}, which must be equal in number")
                factor, offset = law = _law(link)
                for source, target in zip(sources, targets, strict=True):
                    output, input_ = self._directed(source, target)
                    if law != UNCHANGED and not (output == source and self._is_real(source) and self._is_real(target)):
                        raise ValueError(
                            f"{self.what}: the connection from {source} transforms its value, which is supported only "
                            f"from a Real output to a Real input"
                        )
                    yield Connection(output, input_, factor=factor, offset=offset)

    def signals(self) -> tuple[Signal, ...]:
        """Connectors of the system that feed inputs, and signals that this package's annotation names."""
        targets: dict[str, list[str]] = {
            signal.get("name"): [end.get("name") for end in signal.iterfind("amb:Target", NAMES)]
            for signal in self.root.iterfind(f".//{MASTER}/amb:Signal", NAMES)
        }
        annotated = frozenset(targets)
        for link in self._links():
            local = [self._ends(link, side)[0] for side in ("start", "end") if not link.get(f"{side}Element")]
            inner = [self._ends(link, side) for side in ("start", "end") if link.get(f"{side}Element")]
            if local and inner and local[0] not in annotated and self._causality(inner[0][0]) != "output":
                for k, end in enumerate(inner[0], 1):
                    name = local[0] if len(inner[0]) == 1 else f"{local[0]}[{k}]"
                    targets.setdefault(name, []).append(end)
        return tuple(Signal(name, tuple(ends)) for name, ends in targets.items())

    def values(self) -> tuple[dict[str, dict[str, Raw]], dict[str, Raw], tuple[str, ...]]:
        """Return values of parameters by component and name, of inputs by `component.variable`, and unknown names."""
        parameters: dict[str, dict[str, Raw]] = {name: {} for name in self.elements}
        inputs: dict[str, Raw] = {}
        unknown: dict[str, None] = {}
        fed = {link.target for link in self.connections()}
        settings = [(f"{name}.", element) for name, element in self.elements.items()] + [("", self.system)]
        for prefix, element in settings:  # what the system says of a component counts more
            for name, values in self._bound(element):
                component, _, variable = f"{prefix}{name}".partition(".")
                ports = self.interfaces[component].elements(variable) if component in self.interfaces else ()
                if not ports:
                    unknown[f"{prefix}{name}"] = None
                elif len(ports) != len(values):
                    said = f"{len(values)} values for {prefix}{name}, which has {len(ports)}"
                    raise ValueError(f"{self.what}: a parameter set has {said}")
                for port, value in zip(ports, values, strict=False):
                    if f"{component}.{port.name}" in fed:
                        continue
                    if port.causality == "input":
                        inputs[f"{component}.{port.name}"] = _number_of(port, value)
                    else:
                        parameters[component][port.name] = _number_of(port, value)
        return parameters, inputs, tuple(unknown)

    def experiment(self, step_size: float | None, stop_time: float | None) -> Experiment:
        """Return the default experiment."""
        table = self.root.find("ssd:DefaultExperiment", NAMES)
        start, stop = (
            None if table is None or table.get(name) is None else float(table.get(name))
            for name in ("startTime", "stopTime")
        )
        step = step_size or self._step()
        end = stop if stop_time is None else stop_time
        if step is None or end is None:
            missing = "communication step; set --step" if step is None else "stop time; set --until"
            raise ValueError(f"{self.what} defines no {missing}")
        return Experiment(step_size=step, stop_time=end, start_time=start or 0.0)

    def _step(self) -> float | None:
        """Return the communication step: that of an annotation, or the shortest step of an FMU."""
        for path, name in (
            (f".//{MASTER}", "stepSize"),
            (".//osp:FixedStepAlgorithm", "baseStepSize"),
            (".//oms:FixedStepMaster", "stepSize"),
        ):
            step = _number(self.root, path, name)
            if step:
                return step
        experiments = [fmpy.read_model_description(str(place)).defaultExperiment for place in self.folders.values()]
        steps = [float(e.stepSize) for e in experiments if e is not None and e.stepSize is not None]
        return min(steps, default=None)

    def _links(self) -> Iterator[Any]:
        harmless = [tag(name) for name in ("ssd:ConnectionGeometry", "ssd:Annotations", "ssc:LinearTransformation")]
        for link in self.system.iterfind("ssd:Connections/ssd:Connection", NAMES):
            is_inner = link.get("startElement") and link.get("endElement")
            if any(element.tag not in harmless for element in link) or (_law(link) != UNCHANGED and not is_inner):
                ends = f"{link.get('startElement')}.{link.get('startConnector')}"
                raise ValueError(
                    f"{self.what}: the connection from {ends} transforms its value, which is not supported"
                )
            yield link

    def _ends(self, link: Any, side: str) -> list[str]:
        """Return the variables at an end of a connection: one, or the elements of an array."""
        element, name = link.get(f"{side}Element"), link.get(f"{side}Connector")
        if not element:
            return [name]
        place = tuple(map(int, link.get(f"{side}Indices", "").split()))
        ports = self.interfaces[element].elements(name, place) if element in self.interfaces else ()
        if place and not ports:
            raise ValueError(f"{self.what}: {element}.{name} has no element [{','.join(map(str, place))}]")
        return [f"{element}.{port.name}" for port in ports] or [f"{element}.{name}"]

    def _directed(self, source: str, target: str) -> tuple[str, str]:
        """Return output and input of a connection; SSP does not define their order."""
        turned = self._causality(source) == "input" and self._causality(target) == "output"
        return (target, source) if turned else (source, target)

    def _causality(self, end: str) -> str | None:
        port = self._port(end)
        return None if port is None else port.causality

    def _is_real(self, end: str) -> bool:
        port = self._port(end)
        return port is not None and port.type == "Real"

    def _port(self, end: str) -> Port | None:
        component, _, variable = end.partition(".")
        interface: FmuInterface | None = self.interfaces.get(component)
        return None if interface is None else interface.ports.get(variable)

    def _bound(self, element: Any) -> Iterator[tuple[str, list[ParameterValue]]]:
        """Return names and values of the parameter sets that an element is bound to."""
        for binding in element.iterfind("ssd:ParameterBindings/ssd:ParameterBinding", NAMES):
            if binding.find("ssd:ParameterMapping", NAMES) is not None:
                raise ValueError(
                    f"{self.what}: a binding of {element.get('name')} has a mapping, which is not supported"
                )
            source = binding.get("source")
            if source is None:
                result = binding.find("ssd:ParameterValues/ssv:ParameterSet", NAMES)
                if result is not None:  # of which the schema of structures knows nothing
                    check(result, PARAMETERS, f"{self.what}: the parameter set of {element.get('name')}")
            else:
                base = self.folder
                if binding.get("sourceBase") == "component":
                    raise ValueError(f"{self.what}: {source} is inside an FMU, which is not supported")
                result = parse(_file(base, source, self.what).read_bytes(), PARAMETERS, f"{self.what}: {source}")
            prefix = binding.get("prefix") or ""
            for name, value in read_parameters(result, self.what).items() if result is not None else ():
                yield f"{prefix}{name}", value


def _law(link: Any) -> tuple[float, float]:
    """Return factor and offset of a connection."""
    element = link.find("ssc:LinearTransformation", NAMES)
    return UNCHANGED if element is None else (float(element.get("factor", 1.0)), float(element.get("offset", 0.0)))


def _number_of(port: Port, value: ParameterValue) -> Raw:
    """Return a value for the system: with its unit if the FMU's variable has another one."""
    if isinstance(value, tuple):
        text, unit = value
        return float(text) if port.unit in (None, unit) else f"{text} {unit}"
    return value


def _coupling(root: Any, what: str) -> Coupling:
    """Return the order from an annotation of this package or of libcosim, whose algorithm is parallel."""
    local = root.find(f".//{MASTER}")
    if local is not None:
        available: tuple[Coupling, ...] = get_args(Coupling)
        for coupling in available:
            if local.get("coupling") == coupling:
                return coupling
        raise ValueError(f"{what}: coupling = {local.get('coupling')} is not allowed; there are {', '.join(available)}")
    return "jacobi" if root.find(".//osp:FixedStepAlgorithm", NAMES) is not None else "gauss_seidel"


def _number(root: Any, path: str, name: str) -> float | None:
    element = root.find(path, NAMES)
    return None if element is None or element.get(name) is None else float(element.get(name))
