"""A system as data: its components and connections, and a check against the components' interfaces."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

from amb_cosim.cosim.choices import COUPLINGS, Coupling
from amb_cosim.cosim.fmu.fmu_interface import FmuInterface, Port
from amb_cosim.cosim.fmu.fmus import FmuSource, is_placeholder
from amb_cosim.cosim.system.values import Raw
from amb_files.checks import repeated, require_choice
from amb_files.suggestions import suggest

UNCHANGED = (1.0, 0.0)  # factor and offset of a value that is passed on as it is


@dataclass(frozen=True)
class Component:
    """An instance of an FMU: its name, its model or FMU file, its rate, and its mandatory inputs.

    `every` is the number of communication steps that one step of the component spans; a component with a parameter
    `sample_time` steps at that rate instead, unless its FMU takes any step. `replaces` is the replaced FMU; see
    `replacement`.
    """

    name: str
    fmu: FmuSource
    every: int = 1
    mandatory: tuple[str, ...] = ()
    replaces: FmuSource | None = None


@dataclass(frozen=True)
class Connection:
    """A connection of an output to an input of another component; both ends are `component.variable`.

    `option` names a group of connections that may be omitted together. An `inherited` connection was made for a
    replaced FMU. If a connection is a pattern, it excludes the inputs in `but`, which may be patterns as well. The
    input is `factor` times the output plus `offset`. If `converts_units` is set, these numbers also convert the unit,
    so the units of the ends may differ.
    """

    source: str
    target: str
    option: str | None = None
    inherited: bool = False
    but: tuple[str, ...] = ()
    factor: float = 1.0
    offset: float = 0.0
    converts_units: bool = False

    @property
    def text(self) -> str:
        """Expression for the value of the input."""
        is_same = (self.factor, self.offset) == UNCHANGED
        return self.source if is_same else f"{self.factor!r} {self.source} + {self.offset!r}"

    def touches(self, component: str) -> bool:
        """Return whether an end belongs to a component."""
        return any(end.startswith(f"{component}.") for end in (self.source, self.target))


@dataclass(frozen=True)
class Signal:
    """An exogenous signal that feeds several inputs at once.

    If it has a separate `port`, its value has the unit and type of the port, and `laws` are the factor and offset of
    each input that is not equal to this value. Without a port, all its inputs have the value of the signal.
    """

    name: str
    targets: tuple[str, ...]
    port: Port | None = None
    laws: Mapping[str, tuple[float, float]] = field(default_factory=dict)

    def value_at(self, target: str, value: float) -> float:
        """Return the value of an input for a value of the signal."""
        factor, offset = self.laws.get(target, UNCHANGED)
        return factor * value + offset


@dataclass(frozen=True)
class Output:
    """An output of the system as a whole: factor times `source`, an output of a component, plus offset, in `unit`.

    It is recorded under its name if its source is recorded.
    """

    name: str
    source: str
    unit: str | None = None
    factor: float = 1.0
    offset: float = 0.0


@dataclass(frozen=True)
class System:
    """Components in Gauss-Seidel order, their connections, shared signals, parameters, and outputs of the system.

    `*` and `?` in names of connected variables, mandatory inputs and parameters match variables of the components (see
    `patterns.expand`); a pattern of a parameter may match nothing. `unrecorded` are patterns of outputs that a run
    records only if it names them. `stated` are the parameters, by component, that the system's file itself or a base
    outside the packs sets. `unknown` are names to which the file assigns values but which no component has; `remarks`
    are other notices about the file. `check` compares the system with the components' interfaces.

    Raises
    ------
    ValueError
        If two components have one name, or there is no such coupling.

    Examples
    --------
    >>> system = System("rotor alone", "A rotor.", (Component("plant", "rotor_contact"),), ())
    >>> system.with_fmu("plant", "own.fmu").component("plant").fmu
    'own.fmu'
    """

    name: str
    description: str
    components: tuple[Component, ...]
    connections: tuple[Connection, ...]
    signals: tuple[Signal, ...] = ()
    coupling: Coupling = "gauss_seidel"
    parameters: Mapping[str, Mapping[str, Raw]] = field(default_factory=dict)
    unrecorded: tuple[str, ...] = ()
    stated: Mapping[str, frozenset[str]] = field(default_factory=dict)
    unknown: tuple[str, ...] = ()
    remarks: tuple[str, ...] = ()
    outputs: tuple[Output, ...] = ()

    def __post_init__(self) -> None:
        require_choice("coupling", self.coupling, COUPLINGS)
        if duplicates := sorted(repeated(component.name for component in self.components)):
            raise ValueError(f"system {self.name}: components named twice: {', '.join(duplicates)}")

    def component(self, name: str) -> Component:
        """Return the component called `name`; the ValueError for an unknown name lists all names."""
        if name not in self._by_name:
            raise ValueError(f"no component {name!r}; {suggest(name, [*self._by_name])}")
        return self._by_name[name]

    @cached_property
    def _by_name(self) -> Mapping[str, Component]:
        return {component.name: component for component in self.components}

    def with_fmu(self, name: str, fmu: FmuSource) -> System:
        """Return the system with another FMU for a component: a model, an FMU file, or an object in place of a file."""
        old = self.component(name)
        if fmu == old.fmu:
            return self
        if is_placeholder(old.fmu):
            return replace(self, components=tuple(replace(c, fmu=fmu) if c is old else c for c in self.components))
        changed = replace(old, fmu=fmu, replaces=old.replaces or old.fmu)
        links = tuple(replace(link, inherited=True) if link.touches(name) else link for link in self.connections)
        components = tuple(changed if c.name == name else c for c in self.components)
        return replace(self, components=components, connections=links)

    @property
    def replaced(self) -> tuple[str, ...]:
        """Names of the components that replace original ones."""
        return tuple(c.name for c in self.components if c.replaces is not None)

    def split(self, end: str) -> tuple[str, str]:
        """Split `component.variable` into its two names."""
        component, variable = self.divide(end)
        if not variable:
            raise ValueError(f"{end!r} is not a component.variable")
        return self.component(component).name, variable

    def divide(self, end: str) -> tuple[str, str]:
        """Split a name into component and variable, without a check.

        A component of a nested system has a name with dots, such as `axle.motor`. A name that begins with no
        component's name is divided at its first dot.
        """
        component, _, variable = end.partition(".")
        if component in self._by_name:
            return component, variable
        nested = [name for name in self._nested if end.startswith(f"{name}.")]
        if not nested:
            return component, variable
        component = max(nested, key=len)
        return component, end[len(component) + 1 :]

    @cached_property
    def _nested(self) -> list[str]:
        return [name for name in self._by_name if "." in name]

    def signal(self, name: str) -> Signal | None:
        """Return the shared signal with this name, if any."""
        return next((signal for signal in self.signals if signal.name == name), None)

    def first_end(self, name: str) -> str:
        """Return the input that the shared signal of this name feeds first; return any other name unchanged."""
        signal = self.signal(name)
        return name if signal is None else signal.targets[0]

    def signal_of(self, target: str) -> Signal | None:
        """Return the shared signal that feeds an input, if any."""
        return next((signal for signal in self.signals if target in signal.targets), None)

    def source_of(self, target: str) -> str | None:
        """Return the output that feeds an input, if any."""
        return next((link.source for link in self.connections if link.target == target), None)

    @property
    def transformed(self) -> dict[str, tuple[float, float]]:
        """Factor and offset of each input whose connection transforms the value."""
        laws = {link.target: (link.factor, link.offset) for link in self.connections}
        for signal in self.signals:
            laws |= signal.laws
        return {target: law for target, law in laws.items() if law != UNCHANGED}

    def check(self, interfaces: Mapping[str, FmuInterface]) -> None:
        """Check the system against the interfaces of its components.

        Raises
        ------
        ValueError
            For an unknown component or variable, a wrong causality, different types or units, an input fed twice, or a
            mandatory input without a source, one line each; the message names both ends and valid alternatives.
        """
        fed: dict[str, str] = {}
        for source, target in self.feeds():
            self._check_end(target, "input", interfaces)
            if target in fed:
                raise ValueError(f"{target} is connected twice: to {fed[target]} and to {source}")
            fed[target] = source
        for link in self.connections:
            self._check_end(link.source, "output", interfaces)
            _check_match(
                link.source,
                self.port(link.source, interfaces),
                link.target,
                self.port(link.target, interfaces),
                converts_units=link.converts_units,
            )
        for signal in self.signals:
            first, *others = signal.targets
            for other in others:
                ports = self.port(first, interfaces), self.port(other, interfaces)
                _check_match(first, ports[0], other, ports[1], converts_units=signal.port is not None)
        mandatory = [
            f"{component.name}.{variable}" for component in self.components for variable in component.mandatory
        ]
        for target in mandatory:
            self._check_end(target, "input", interfaces)
        unfed = [target for target in mandatory if target not in fed]
        if unfed:
            possible = [(target, self._possible(target, interfaces)) for target in unfed]
            raise ValueError(
                "\n".join(f"{target} must be connected but is not; {options}" for target, options in possible)
            )

    @cached_property
    def links(self) -> frozenset[tuple[str, str]]:
        """The sending and the receiving component of each connection."""
        return frozenset((self.split(link.source)[0], self.split(link.target)[0]) for link in self.connections)

    def fed(self) -> set[str]:
        """Return the inputs that a connection or a signal feeds."""
        return {target for _, target in self.feeds()}

    def port(self, end: str, interfaces: Mapping[str, FmuInterface]) -> Port:
        """Return the variable `component.variable`; raises ValueError if there is none."""
        component, variable = self.split(end)
        return interfaces[component].port(variable, component)

    def feeds(self) -> Iterator[tuple[str, str]]:
        """Yield the source and the name of every input that is fed; a shared signal is the source `signal NAME`."""
        for link in self.connections:
            yield link.source, link.target
        for signal in self.signals:
            for target in signal.targets:
                yield f"signal {signal.name}", target

    def _check_end(self, end: str, causality: str, interfaces: Mapping[str, FmuInterface]) -> None:
        try:
            port = self.port(end, interfaces)
        except ValueError as error:
            others = [s if t == end else t for s, t in self.feeds() if end in (s, t)]
            where = f" (connected with {others[0]})" if others else ""
            raise ValueError(f"{error}{where}") from error
        if port.causality != causality:
            component, variable = self.split(end)
            options = [p.name for p in interfaces[component].of(causality)]
            raise ValueError(
                f"{end} is {port.kind}, but a connection needs an {causality} there; {suggest(variable, options)}"
            )

    def _possible(self, target: str, interfaces: Mapping[str, FmuInterface]) -> str:
        port = self.port(target, interfaces)
        options = [
            f"{component.name}.{output.name}"
            for component in self.components
            for output in interfaces[component.name].of("output")
            if output.type == port.type and _same_unit(output, port)
        ]
        variable = self.split(target)[1]
        same = [option for option in options if self.split(option)[1] == variable]
        return suggest(target, same or options)


def _same_unit(a: Port, b: Port) -> bool:
    """Return whether two units are equal; a port without a unit matches any."""
    if not a.unit or not b.unit:
        return True
    if a.definition is not None and b.definition is not None:
        return a.definition == b.definition
    return a.unit == b.unit


def _check_match(source: str, a: Port, target: str, b: Port, converts_units: bool = False) -> None:
    is_number = converts_units and (a.type, b.type) == ("Integer", "Real") and not a.items
    if a.type != b.type and not is_number:
        raise ValueError(
            f"{source} is {a.declared} and {target} is {b.declared}; connected variables must have the same type"
        )
    if not converts_units and not _same_unit(a, b):
        raise ValueError(
            f"{source} is in {a.unit} and {target} is in {b.unit}; connected variables must have the same unit"
        )
