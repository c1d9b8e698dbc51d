"""Source of a linear model: the components of a scenario or a system, and their start values."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from amb_analysis.linear.components import LinearComponent
from amb_analysis.linear.control import law_component, pid_component
from amb_analysis.linear.foreign import foreign_component, joint_response, responds_alike
from amb_analysis.linear.rotor_and_magnets import actuator_component, rotor_component
from amb_cosim.controllers.laws import Law
from amb_cosim.cosim.choices import Flavour
from amb_cosim.cosim.fmu.fmus import FmuSource, as_fmu, model_of, model_source, note_first_loading
from amb_cosim.cosim.run.options import RunOptions
from amb_cosim.cosim.system.assembly import Assembly, assemble
from amb_cosim.cosim.system.assignments import Assignments
from amb_cosim.cosim.system.experiment import Experiment, Plan
from amb_cosim.cosim.system.planning import experiment_plan
from amb_cosim.cosim.system.system import System
from amb_cosim.cosim.system.system_file import is_system, load_experiment, load_system
from amb_cosim.cosim.system.values import Raw, convert, plain_value, quantity
from amb_cosim.results.component_names import ACTUATOR, CONTROLLER, PLANT
from amb_cosim.scenario.plan import ScenarioPlan
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.rotors import RotorSource
from amb_cosim.scenario.scenario import SPEED, Scenario, as_scenario
from array_types import Array
from linear_controller.matrices import matrices_of
from rotor_contact.shaft.structure import structure_of

LINEAR = "linear_controller"


@dataclass(frozen=True)
class LinearSource:
    """Source of a linear model: the components of a run with all start values.

    plan
        Plan of the run.
    point
        Values at the operating point, by signal or `component.variable`; the signal `Omega` is in rad/s.
    changed
        Function that takes this source, the name of a component and its linear part, and returns the law that replaces
        the law of this part.
    rotor
        Constants of a plant with the same planes as the plant of the run; by default the constants of the run are used.
    """

    plan: Plan
    point: Mapping[str, float]
    changed: Callable[[LinearSource, str, LinearComponent], Law] | None = None
    rotor: Array | None = None
    _cache: dict[str, Any] = field(default_factory=dict)  # parts that do not depend on the speed
    _constants: dict[str, Array] = field(default_factory=dict)  # of components, which do not depend on the plan either

    def at(self, Omega: float) -> LinearSource:
        """Return the source at another spin speed (rad/s), which applies to every component that reads the speed."""
        return replace(self, point={**self.point, SPEED: Omega})

    def with_plan(self, plan: Plan) -> LinearSource:
        """Return the source with another plan of the same components; the constants of the components are kept."""
        return replace(self, plan=plan, _cache={})

    @property
    def names(self) -> list[str]:
        """Names of the components, in the order in which the master steps them."""
        return [component.name for component in self.plan.system.components]

    def parts(self, names: Sequence[str]) -> list[LinearComponent]:
        """Return the linear parts of the named components."""
        parts = [self._part(name) for name in names]
        if self.changed is None:
            return parts
        return [replace(part, law=self.changed(self, name, part)) for name, part in zip(names, parts, strict=True)]

    def _part(self, name: str) -> LinearComponent:
        kind, Omega = self.kind(name), self.speed_of(name)
        if kind == PLANT:
            return rotor_component(name, self.layout(name), self.constants(name), self.parameters(name), Omega)
        makers = {ACTUATOR: self._actuator, CONTROLLER: self._pid, LINEAR: self._law}
        if kind not in makers:
            start = self._start_of(name)
            foreign: LinearComponent = self.cached(
                f"{name} at {sorted(start.items())!r}", lambda: self._foreign(name, start)
            )
            return foreign
        depends_on_speed = kind == LINEAR and len(self._speeds(name)) > 1
        key = f"{name} at {Omega!r} rad/s" if depends_on_speed else name
        part: LinearComponent = self.cached(key, lambda: makers[kind](name))
        return part

    def units(self) -> dict[str, str]:
        """Return the units of all variables, by name."""
        ports = ((c, p) for c, interface in self.plan.interfaces.items() for p in interface.ports.values())
        return {f"{c}.{p.name}": p.unit or "1" for c, p in ports}

    def feeds(self, names: Sequence[str]) -> Mapping[str, str]:
        """Return the output that feeds each input, by the input's name, for connections among the named components."""
        feeds: Mapping[str, str] = self.cached(f"feeds among {sorted(names)}", lambda: self._feeds(names))
        return feeds

    def _feeds(self, names: Sequence[str]) -> dict[str, str]:
        system = self.plan.system
        links = {link.target: link.source for link in system.connections}
        return {t: s for t, s in links.items() if system.split(t)[0] in names and system.split(s)[0] in names}

    def samples_late(self, part: LinearComponent, target: str) -> float:
        """Return the delay of a part's outputs, in samples, at an input of another component, `component.variable`.

        Components are stepped in the order of `names`. Outputs that appear at the end of a step reach a component that
        is stepped later in the same step, and all others in the next step.
        """
        first, last = (self.names.index(end.partition(".")[0]) for end in (part.outputs[0], target))
        return part.late + (1.0 if part.at_end and first >= last else 0.0)

    def kind(self, name: str) -> str:
        """Return the name of a component's model, or the path of its FMU."""
        fmu = self.plan.system.component(name).fmu
        return model_of(fmu) or str(fmu)

    def layout(self, name: str) -> dict[str, Any]:
        """Return the layout that the FMU of a component declares; empty if it declares none."""
        return self.plan.fmus[name].layout or {}

    def parameters(self, name: str) -> dict[str, float]:
        """Return the values of a component's parameters (SI), by name."""
        values = self.cached("parameters", lambda: self.plan.all_parameters())[name]
        return {variable: value or 0.0 for variable, value in values.items()}

    def _actuator(self, name: str) -> LinearComponent:
        prefix = f"{name}."
        point = {end.removeprefix(prefix): value for end, value in self.point.items() if end.startswith(prefix)}
        return actuator_component(name, self.layout(name), self.parameters(name), point)

    def _pid(self, name: str) -> LinearComponent:
        return pid_component(name, self.layout(name), self.parameters(name))

    def _law(self, name: str) -> LinearComponent:
        return law_component(name, self.layout(name), self.constants(name), self.parameters(name), self.speed_of(name))

    def _start_of(self, name: str) -> dict[str, float]:
        """Return a component's parameters and inputs at the operating point, by name."""
        start = dict(self.plan.parameters[name])
        for port in self.plan.interfaces[name].of("input"):
            end = f"{name}.{port.name}"
            signal = self.plan.system.signal_of(end)
            value = self._value(signal.name if signal else end)
            if self._reads_speed(end):
                value = self.speed_of(name)
            if value is not None:
                start[port.name] = value
        return start

    def _reads_speed(self, end: str) -> bool:
        """Return whether an input receives the spin speed, either from the shared signal or from the rotor."""
        system = self.plan.system
        signal, source = system.signal_of(end), system.source_of(end)
        return (signal is not None and signal.name == SPEED) or source == f"{PLANT}.speed"

    def _foreign(self, name: str, start: Mapping[str, float]) -> LinearComponent:
        """Return the linear part of an FMU; it is that of another speed if the FMU responds in the same way there."""
        system, interface = self.plan.system, self.plan.interfaces[name]
        every = next(c.every for c in self.plan.system.components if c.name == name)
        fed = {link.target for link in system.connections}
        inputs = [p.name for p in interface.of("input") if p.type == "Real" and f"{name}.{p.name}" in fed]
        used = {link.source for link in system.connections}
        outputs = [p.name for p in interface.of("output") if p.type == "Real" and f"{name}.{p.name}" in used]
        folder, step = self.plan.fmus[name].folder, every * self.plan.step_size
        stated = interface.ports.get("sample_time")
        is_parameter = stated is not None and stated.causality == "parameter"
        note_first_loading(self.plan.fmus[name])
        time = max(step, self.parameters(name)["sample_time"] if is_parameter else 0.0)
        fmu = name, folder, interface, start, (inputs, outputs), time
        others = {port: value for port, value in start.items() if not self._reads_speed(f"{name}.{port}")}
        if len(others) == len(start):
            return foreign_component(*fmu)
        known: list[tuple[Array, LinearComponent]] = self.cached(f"{name} at all speeds and {others!r}", list)
        response = joint_response(*fmu)
        alike = next((part for other, part in known if responds_alike(response, other)), None)
        if alike is None:
            alike = foreign_component(*fmu)
            known.append((response, alike))
        return alike

    def constants(self, name: str) -> Array:
        """Return the constants of a component that is a model of this project."""
        if self.rotor is not None and self.kind(name) == PLANT:
            return self.rotor
        fmu = self.plan.system.component(name).fmu
        key = repr(fmu)
        if key not in self._constants:
            self._constants[key] = model_source(fmu, **self.plan.assembly.options)[1]
        return self._constants[key]

    def table_speeds(self) -> list[float]:
        """Return the speeds (rad/s) at which linear controllers have laws; laws at other speeds are interpolated."""
        return sorted({speed for name in self.names if self.kind(name) == LINEAR for speed in self._speeds(name)})

    def _speeds(self, name: str) -> list[float]:
        """Return the speeds (rad/s) at which a linear controller has laws."""

        def stated() -> list[float]:
            return [float(speed) for speed in matrices_of(self.constants(name)).speeds if math.isfinite(speed)]

        speeds: list[float] = self.cached(f"speeds of {name}", stated)
        return speeds

    def mass(self, name: str) -> Array:
        """Return the mass matrix of a component, which is empty for all models except this project's rotor."""
        if self.kind(name) != PLANT:
            return np.zeros((0, 0))
        structure = structure_of(self.constants(name))
        return structure.forms[: len(structure.K)]

    def cached(self, name: str, make: Callable[[], Any]) -> Any:
        """Return a value from the cache; if it is missing there, `make` computes it.

        The value may depend only on what its name states; for example, the name of a value that depends on the speed
        must contain the speed.
        """
        if name not in self._cache:
            self._cache[name] = make()
        return self._cache[name]

    def _value(self, name: str) -> float | None:
        return self.point.get(name, self.plan.inputs.get(name))

    def speed_of(self, name: str) -> float:
        """Return the spin speed (rad/s) of a component."""
        signal = self.plan.system.signal_of(f"{name}.{SPEED}")
        value = self._value(signal.name if signal else f"{name}.{SPEED}")
        return self._value(SPEED) or 0.0 if value is None else value


def linear_source(
    source: str | Path | Scenario | System | None = None,
    at: Raw | Mapping[str, Raw] | None = None,
    *,
    rotor: RotorSource = None,
    fmu: Mapping[str, FmuSource | PathLike[str]] | None = None,
    set: Mapping[str, Raw] | None = None,
    flavour: Flavour = "native",
) -> LinearSource:
    """Return the components of a scenario or system with their start values; the arguments are those of `linearise`."""
    values = at if isinstance(at, Mapping) else {} if at is None else {SPEED: plain_value(at, "at")}
    options = RunOptions(flavour=flavour)
    if isinstance(source, System) or (isinstance(source, str | Path) and is_system(source)):
        plan = _planned_system(source, fmu or {}, rotor, set or {}, options)
        return LinearSource(plan, _point(plan.assembly, values))
    return source_of_run(prepare_run(as_scenario(source, rotor, fmu=fmu), set, options=options), values)


def source_of_run(prepared: ScenarioPlan, at: Mapping[str, Raw] | None = None) -> LinearSource:
    """Return the source of a prepared run's linear model, with the run's reduced rotor; `at` replaces start values."""
    return LinearSource(prepared, _point(prepared.assembly, at or {}))


def _planned_system(
    source: str | Path | System,
    fmu: Mapping[str, FmuSource | PathLike[str]],
    rotor: RotorSource,
    set: Mapping[str, Raw],
    options: RunOptions,
) -> Plan:
    system = source if isinstance(source, System) else load_system(source)
    for component, file in fmu.items():
        system = system.with_fmu(component, as_fmu(file))
    assembly = assemble(system, options.flavour, **({} if rotor is None else {"rotor": rotor}))
    values = assembly.assignments()
    for name, raw in set.items():
        values.set(name, raw)
    default = Experiment(_sample_time(values), 1.0)
    experiment = default if isinstance(source, System) else load_experiment(source, default)
    return experiment_plan(experiment, assembly, set, values)


def _sample_time(values: Assignments) -> float:
    """Return the shortest `sample_time` (s) of the components, or 1 ms if no component has one."""
    times = [
        values.parameter(f"{c}.sample_time")
        for c, interface in values.interfaces.items()
        if "sample_time" in interface.ports
    ]
    return min(times, default=1e-3)


def _point(assembly: Assembly, operating: Mapping[str, Raw]) -> dict[str, float]:
    """Return the operating values (SI) by the name of the shared signal, or of the input itself if nothing feeds it."""
    result, system = {}, assembly.system
    for name, raw in operating.items():
        end = system.first_end(name)
        if "." not in end:
            if name != SPEED:
                raise ValueError(f"at: {name!r} is not a component.variable or a signal")
            result[name] = quantity(raw, "rad/s", name)
            continue
        port = system.port(end, assembly.interfaces)
        if port.causality != "input":
            raise ValueError(f"at: {name} is {port.kind}; it must be an input")
        signal = system.signal_of(end)
        result[signal.name if signal else name] = convert(raw, port, name)
    return result
