"""Merges a system file with its base: adds, replaces and removes components, connections, signals and parameters."""

from __future__ import annotations

from collections.abc import Sequence

from amb_cosim.cosim.system.system_tables import ConnectTable, OverlayTable, SharedSignalTable, SystemTable
from amb_files.suggestions import suggest
from amb_files.wildcards import is_pattern, matches


def overlaid(below: SystemTable, above: OverlayTable) -> SystemTable:
    """Return a system merged with an overlay.

    Raises
    ------
    ValueError
        If it names a component that the base does not have.
    """
    below = _reduced(below, above.remove)
    components, replaced = list(below.component), set()
    for new in above.component:
        names = [component.name for component in components]
        if new.name in names:
            place = names.index(new.name)
            replaced |= {new.name} if new.replaces(components[place]) else set()
            components[place] = new.in_place_of(components[place])
        elif new.before is None:
            components.append(new)
        elif new.before in names:
            components.insert(names.index(new.before), new)
        else:
            raise ValueError(f"no component {new.before!r}; {suggest(new.before, names)}")
    fed = {link.target for connect in above.connect for link in connect.connections()}
    fed |= {target for signal in above.signal for target in signal.targets}
    signals = [s.model_copy(update={"targets": tuple(t for t in s.targets if t not in fed)}) for s in below.signal]
    parameters = dict(below.parameters)
    for component, values in above.parameters.items():
        parameters[component] = {**parameters.get(component, {}), **values}
    settings = above.model_dump(include=above.model_fields_set & {"description", "coupling"})
    retained = (_without(connect, fed) for connect in below.connect)
    merged = {
        "component": tuple(components),
        "connect": (*(c.inherited() if replaced & {c.source, c.target} else c for c in retained), *above.connect),
        "signal": (*(s for s in signals if s.targets), *above.signal),
        "unrecorded": (*below.unrecorded, *above.unrecorded),
        "parameters": parameters,
        "experiment": above.experiment or below.experiment,
    }
    return below.model_copy(update=settings | merged)


def _reduced(table: SystemTable, remove: Sequence[str]) -> SystemTable:
    """Return a system without the names in `remove`: components, parameters, and sources of inputs."""
    for entry in remove:
        component, dot, variable = entry.partition(".")
        names = [c.name for c in table.component]
        if component not in names:
            raise ValueError(f"remove: no component {component!r}; {suggest(component, names)}")
        values = table.parameters.get(component, {})
        left = {name: raw for name, raw in values.items() if name != variable and not matches(name, variable)}
        if not dot:
            table = _without_component(table, component)
        elif len(left) < len(values):
            table = table.model_copy(update={"parameters": {**table.parameters, component: left}})
        else:
            _check_feeds(table, component, variable)
            connect = tuple(c.leaving(variable) if c.target == component else c for c in table.connect)
            table = table.model_copy(update={"connect": connect, "signal": _signals(table.signal, entry)})
    return table


def _check_feeds(table: SystemTable, component: str, pattern: str) -> None:
    """Raise ValueError if nothing feeds an input of this name; patterns are matched later, with the FMUs."""
    targets = [link.target for connect in table.connect for link in connect.connections()]
    targets += [target for signal in table.signal for target in signal.targets]
    local = [target.removeprefix(f"{component}.") for target in targets if target.startswith(f"{component}.")]
    if not any(is_pattern(name) or matches(name, pattern) for name in local):
        options = [*table.parameters.get(component, {}), *local]
        raise ValueError(f"remove: the base gives {component} no {pattern!r}; {suggest(pattern, options)}")


def _without_component(table: SystemTable, name: str) -> SystemTable:
    """Return a system without a component, its parameters and its connections."""
    return table.model_copy(
        update={
            "component": tuple(c for c in table.component if c.name != name),
            "connect": tuple(c for c in table.connect if name not in (c.source, c.target)),
            "signal": _signals(table.signal, f"{name}.*"),
            "parameters": {c: values for c, values in table.parameters.items() if c != name},
            "unrecorded": tuple(p for p in table.unrecorded if not p.startswith(f"{name}.")),
        }
    )


def _signals(signals: Sequence[SharedSignalTable], pattern: str) -> tuple[SharedSignalTable, ...]:
    """Return signals without the inputs that a pattern matches, and without signals that then feed nothing."""
    left = [s.model_copy(update={"targets": tuple(t for t in s.targets if not matches(t, pattern))}) for s in signals]
    return tuple(signal for signal in left if signal.targets)


def _without(connect: ConnectTable, fed: set[str]) -> ConnectTable:
    """Return a connect table of the base without the inputs that something else feeds."""
    left = {a: b for a, b in connect.pairs() if f"{connect.target}.{b}" not in fed}
    return connect.model_copy(update={"variables": left})
