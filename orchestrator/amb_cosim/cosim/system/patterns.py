"""Names with `*` and `?` in a system, expanded with the interfaces of its components."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from amb_cosim.cosim.fmu.fmu_interface import FmuInterface
from amb_cosim.cosim.system.system import Component, Connection, System
from amb_files.suggestions import suggest
from amb_files.wildcards import is_pattern, matches, matching_names


def expand(system: System, interfaces: Mapping[str, FmuInterface]) -> System:
    """Return the system with its patterns replaced by the names that they match in these interfaces.

    If both ends of a connection have the same pattern, it connects matching outputs of one component with the inputs of
    the same names of the other component. Inputs that something else feeds are excluded. The pattern of the inputs may
    have an additional ending, without `*` and `?`; the names of inputs must then have this ending. The name of a
    variable that contains such a character, for example `open?`, is not a pattern.

    Raises
    ------
    ValueError
        If the pattern of a connection or of a mandatory input matches nothing, an excluded input does not exist, or a
        component is unknown. Inherited and optional connections may match nothing.
    """
    literal: list[Connection] = []
    patterns: list[Connection] = []
    for link in system.connections:
        (patterns if _connects_patterns(link, system, interfaces) else literal).append(link)
    fed = {link.target for link in literal} | {t for signal in system.signals for t in signal.targets}
    matched: dict[str, Connection] = {}
    for link in patterns:
        for expanded in _matching(system, link, interfaces):
            if expanded.target not in fed:
                matched.setdefault(expanded.target, expanded)
    parameters = {
        component: {name: raw for name, raw in values.items() if _has(interfaces.get(component), name)}
        for component, values in system.parameters.items()
    }
    components = tuple(replace(c, mandatory=_mandatory(c, interfaces[c.name])) for c in system.components)
    return replace(
        system,
        components=components,
        connections=(*literal, *matched.values()),
        parameters=parameters,
    )


def _connects_patterns(link: Connection, system: System, interfaces: Mapping[str, FmuInterface]) -> bool:
    """Return whether the source of a connection is a pattern rather than the name of a variable."""
    component, name = system.divide(link.source)
    return is_pattern(link.source) and not (component in interfaces and name in interfaces[component].ports)


def _matching(system: System, link: Connection, interfaces: Mapping[str, FmuInterface]) -> list[Connection]:
    (source, pattern), (target, other) = system.split(link.source), system.split(link.target)
    ending = other.removeprefix(pattern)
    if not other.startswith(pattern) or is_pattern(ending):
        raise ValueError(
            f"{link.source} and {link.target} are patterns and must be equal; the pattern of the inputs may have an "
            f"additional ending"
        )
    inputs = {port.name for port in interfaces[target].of("input")}
    outputs = [port.name for port in interfaces[source].of("output")]
    names = [name for name in matching_names(outputs, pattern) if f"{name}{ending}" in inputs]
    if not names and not link.inherited and link.option is None:
        raise ValueError(f"no output of {source} that matches {pattern} is an input of {target}")
    for excluded in link.but:
        if not matching_names(inputs, excluded) and not link.inherited:
            raise ValueError(f"remove: {target} has no parameter or input {excluded!r}; {suggest(excluded, inputs)}")
    ends = {name: f"{name}{ending}" for name in names}
    connected = {a: b for a, b in ends.items() if not any(matches(b, excluded) for excluded in link.but)}
    return [replace(link, source=f"{source}.{a}", target=f"{target}.{b}", but=()) for a, b in connected.items()]


def _has(interface: FmuInterface | None, name: str) -> bool:
    """Return False if a name is a pattern that matches no variable, and True otherwise."""
    return interface is None or not is_pattern(name) or bool(matching_names(interface.ports, name))


def _mandatory(component: Component, interface: FmuInterface) -> tuple[str, ...]:
    """Return the mandatory inputs, with patterns expanded; a replacing component may lack them."""
    inputs = [port.name for port in interface.of("input")]
    expanded: list[str] = []
    for name in component.mandatory:
        matching = matching_names(inputs, name) if is_pattern(name) or component.replaces is not None else [name]
        if not matching and component.replaces is None:
            raise ValueError(f"{component.name} has no input {name}, which must be connected; {suggest(name, inputs)}")
        expanded += matching
    return tuple(expanded)
