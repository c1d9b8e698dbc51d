"""A component replaced by another FMU: remaining connections, missing ports, and notices.

Another FMU can replace the original one if it provides, under the same names, every output that feeds an input of a
component that remains. It may lack inputs. Connections of an `option` may be omitted, but only together.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace

from amb_cosim.cosim.fmu.fmu_interface import FmuInterface, Port
from amb_cosim.cosim.fmu.fmus import fmu_name, is_model
from amb_cosim.cosim.system.patterns import expand
from amb_cosim.cosim.system.system import Component, Connection, System
from amb_files.wildcards import is_pattern

Interfaces = Mapping[str, FmuInterface]


def fitted(
    system: System, interfaces: Interfaces, interface_of: Callable[[Component], FmuInterface]
) -> tuple[System, Interfaces]:
    """Return a system with expanded patterns, and its interfaces; replacing FMUs inherit connections of their ports.

    Parameters
    ----------
    system, interfaces
        The system and the interface of each component, as read.
    interface_of
        Function that returns the interface of a component that was replaced.

    Raises
    ------
    ValueError
        If a replacing FMU lacks variables that others need, or the system is inconsistent (`System.check`).
    """
    if system.replaced:
        before = original(system)
        first = {c.name: interface_of(c) for c in before.components}
        interfaces = {name: with_units(interface, first[name]) for name, interface in interfaces.items()}
        system = expand(without_lacking(system, interfaces), interfaces)
        missing = missing_ports(system, interfaces, expand(before, first))
        if missing:
            raise ValueError("\n".join(missing))
    else:
        system = expand(system, interfaces)
    system.check(interfaces)
    return system, interfaces


def original(system: System) -> System:
    """Return the system with its original FMUs in place of the replacing ones."""
    components = tuple(replace(c, fmu=c.replaces or c.fmu, replaces=None) for c in system.components)
    return replace(system, components=components)


def with_units(interface: FmuInterface, before: FmuInterface) -> FmuInterface:
    """Return an interface whose variables without a unit have the unit of the replaced variable of the same name."""

    def with_unit(port: Port) -> Port:
        old = before.ports.get(port.name)
        if port.unit is not None or old is None or old.type != port.type:
            return port
        return replace(port, unit=old.unit, definition=old.definition, relative=old.relative)

    return replace(interface, ports={name: with_unit(port) for name, port in interface.ports.items()})


def without_lacking(system: System, interfaces: Interfaces) -> System:
    """Return the system without inherited connections of ports that the new FMUs lack.

    Parameters
    ----------
    system
        A system with replaced components; connections may be patterns.
    interfaces
        The interface of each component.
    """

    def stays(link: Connection) -> bool:
        if is_pattern(link.source) or not link.inherited:
            return True
        return _has(interfaces, link.source, "output") and _has(interfaces, link.target, "input")

    def reaches(target: str) -> bool:
        component, _ = system.divide(target)
        return component not in system.replaced or _has(interfaces, target, "input")

    signals = (replace(signal, targets=tuple(filter(reaches, signal.targets))) for signal in system.signals)
    return replace(
        system,
        connections=tuple(filter(stays, system.connections)),
        signals=tuple(signal for signal in signals if signal.targets),
    )


def missing_ports(system: System, interfaces: Interfaces, before: System) -> list[str]:
    """Return a line for each replaced component that lacks ports that other components need.

    Parameters
    ----------
    system, interfaces
        The system with the new FMUs and its patterns expanded.
    before
        The expanded system with the original FMUs.
    """
    fed = system.fed()
    required = [
        link
        for link in before.connections
        if link.option is None and link.target not in fed and _has(interfaces, link.target, "input")
    ]
    required += _incomplete_options(system, before)
    lines = []
    for component in system.components:
        links = [link for link in required if component.replaces is not None and link.touches(component.name)]
        outputs = _lacking(component, (link.source for link in links), interfaces, "output")
        inputs = _lacking(component, (link.target for link in links), interfaces, "input")
        lacking = {"outputs": outputs, "inputs": inputs}
        ports = [f"the {kind} {', '.join(names)}" for kind, names in lacking.items() if names]
        if ports:
            file = fmu_name(component.fmu)
            lines.append(f"{component.name}: {file} must have {' and '.join(ports)}, which other components need")
    lines += _silent_signals(system, before)
    return lines


def notices(system: System, interfaces: Interfaces, assigned: Iterable[str], dropped: Iterable[str]) -> list[str]:
    """Return sentences on dropped values, and on inputs of replaced components that nothing feeds.

    Inputs of models are excluded: they are designed to keep their start values.

    Parameters
    ----------
    assigned
        Inputs and signals with a value, by name.
    dropped
        Variables, `component.variable`, whose values are dropped.
    """
    fed, names = system.fed() | set(assigned), {c.name for c in system.components}
    dropped = (*dropped, *system.unknown)
    orphaned = [end for end in dropped if system.divide(end)[0] not in names]
    broken = {c.name: interfaces[c.name].deviations for c in system.components}
    sentences = [f"{name}: {_breach(rules)}" for name, rules in broken.items() if rules]
    sentences += [*system.remarks, *(f"there is no {end}; its settings are ignored" for end in orphaned)]
    for component in system.components:
        name = component.name
        lacks = [end.removeprefix(f"{name}.") for end in dropped if system.divide(end)[0] == name]
        if lacks:
            sentences.append(f"{name}: {fmu_name(component.fmu)} has no {', '.join(lacks)}; such settings are ignored")
        if component.replaces is None:
            continue
        unfed = [p.name for p in interfaces[name].of("input") if f"{name}.{p.name}" not in fed]
        if unfed and not is_model(component.fmu):
            sentences.append(f"{name}: nothing feeds {', '.join(unfed)}, so start values apply")
    return sentences


def _breach(rules: Sequence[str]) -> str:
    """Return a phrase on the rules that a description breaks, or on the first few of them."""
    more = f"; and {len(rules) - 3} more" if len(rules) > 3 else ""
    return f"its modelDescription.xml is not valid FMI: {'; '.join(rules[:3])}{more}"


def _silent_signals(system: System, before: System) -> list[str]:
    """Return a line for each signal that feeds nothing although one of its inputs is mandatory."""
    mandatory = {f"{c.name}.{variable}" for c in before.components for variable in c.mandatory}
    feeding = {signal.name for signal in system.signals}
    return [
        f"signal {signal.name} feeds nothing: {' or '.join(signal.targets)} must be an input"
        for signal in before.signals
        if signal.name not in feeding and mandatory.intersection(signal.targets)
    ]


def _incomplete_options(system: System, before: System) -> list[Connection]:
    """Return the optional connections that are missing although other connections of their group exist."""
    made = {link.target: link for link in system.connections}
    groups: dict[tuple[str, str, str], list[Connection]] = {}
    for link in before.connections:
        if link.option is not None and any(link.touches(name) for name in system.replaced):
            ends = before.divide(link.source)[0], before.divide(link.target)[0]
            groups.setdefault((link.option, *ends), []).append(link)
    incomplete = []
    for links in groups.values():
        absent = [link for link in links if link.target not in made]
        if len(absent) < len(links):
            incomplete += absent
    return incomplete


def _lacking(component: Component, ends: Iterable[str], interfaces: Interfaces, causality: str) -> list[str]:
    of_component = dict.fromkeys(end for end in ends if end.startswith(f"{component.name}."))
    return [end.removeprefix(f"{component.name}.") for end in of_component if not _has(interfaces, end, causality)]


def _has(interfaces: Interfaces, end: str, causality: str) -> bool:
    ports = (
        interface.ports.get(end.removeprefix(f"{component}."))
        for component, interface in interfaces.items()
        if end.startswith(f"{component}.")
    )
    return any(port is not None and port.causality == causality for port in ports)
