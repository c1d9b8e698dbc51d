"""Reads a system, and an experiment with it, from a TOML file.

    [[component]]                     # in Gauss-Seidel order
    name = "plant"
    fmu = "plant.fmu"                 # a path relative to this file, or the name of a model
    [[component]]
    name = "sensor"
    fmu = "lag_sensor"

    [[connect]]
    from = "plant"
    to = "sensor"
    variables = { "x" = "u" }         # output = input; a list where both have the same name, with patterns: ["*.i_?"]

    [[signal]]                        # a value for several inputs
    name = "Omega"
    targets = ["plant.Omega"]

    [parameters.sensor]
    time_constant = "1 ms"

    [experiment]
    communication_step = "250 us"
    stop_time = "1 s"
    inputs = { "Omega" = "100 rad/s" }
    [[experiment.event]]
    time = "0.5 s"
    set = { "Omega" = "120 rad/s" }

A file with a `base`, the name or path of another system, extends it. Its components follow the components of the base,
unless `before` names a component that they precede. A component replaces the component of the same name in the base,
and a connection or signal replaces the source of the same input. Parameters are merged. `remove` deletes parts of the
base. The name of a component deletes it with all its connections. `component.variable`, with wildcards `*` and `?`,
deletes a parameter or the source of an input.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from amb_cosim.cosim.fmu.fmus import models
from amb_cosim.cosim.system.experiment import Experiment
from amb_cosim.cosim.system.system import Component, Connection, Signal, System
from amb_cosim.cosim.system.system_tables import ExperimentTable, OverlayTable, SystemTable
from amb_cosim.cosim.system.tables import check_bases
from amb_files.packs import PackFiles, files_of
from amb_files.suggestions import suggest
from amb_files.toml import read_toml, validate
from amb_files.wildcards import is_pattern, matches


def packaged_systems() -> PackFiles:
    """Return the files of the systems that come with amb-cosim and with packs, by name."""
    return files_of("systems", amb_cosim=Path(__file__).parents[2])


def load_system(name: str | Path, options: Mapping[str, bool] | None = None) -> System:
    """Read a system from amb-cosim, from a pack, or from a TOML file.

    Parameters
    ----------
    options
        For each option of connections, whether it is on; options that are not listed are on.

    Raises
    ------
    ValueError
        If no such system exists, or its description is wrong.

    Examples
    --------
    >>> [component.name for component in load_system("levitated").components]
    ['rolac_controller', 'amb_actuator', 'rotor_contact']
    """
    system, _ = _read(str(name))
    links = {link.target: link for link in system.connections if (options or {}).get(link.option or "", True)}
    signals = {signal.name: signal for signal in system.signals}
    stated = {c: names & {*system.parameters.get(c, {})} for c, names in system.stated.items()}
    return replace(system, connections=tuple(links.values()), signals=tuple(signals.values()), stated=stated)


def is_system(name: str | Path) -> bool:
    """Return whether a name belongs to an included system, or to a file with components or a run."""
    path = Path(name)
    keys = read_toml(path, f"file {name}").keys() if path.is_file() else ()
    return str(name) in packaged_systems() or not {"component", "connect", "experiment"}.isdisjoint(keys)


def load_experiment(name: str | Path, without: Experiment | None = None) -> Experiment:
    """Read the experiment of a system file.

    Parameters
    ----------
    without
        Experiment to return for a file without an experiment.

    Raises
    ------
    ValueError
        If the file has no table `experiment`, or the table is wrong.
    """
    _, table = _read(str(name))
    if table is None and without is not None:
        return without
    if table is None:
        raise ValueError(f"system {name} has no table [experiment], which defines the run")
    try:
        return replace(table.experiment(), source=f"system {name}")
    except ValueError as error:
        raise ValueError(f"system {name}: experiment: {error}") from error


def _read(name: str, derived: tuple[str, ...] = ()) -> tuple[System, ExperimentTable | None]:
    """Return a system and its run from a file and its bases; if several connections feed an input, the last applies.

    Parameters of a packaged file without a base are not `stated`.
    """
    packaged = packaged_systems()
    source = packaged.get(name, Path(name))
    if not source.exists():
        raise ValueError(f"no system {name!r}; {suggest(name, sorted(packaged))}")
    what = f"system {name}"
    check_bases(what, derived)
    data = read_toml(source, what)
    table = validate(data, OverlayTable if "base" in data else SystemTable, what)
    below, experiment, states = System(source.stem, "", (), ()), None, name not in packaged
    try:
        if isinstance(table, OverlayTable):
            beside = packaged.in_pack_of(source, table.base)
            base = str(beside or source.parent / table.base) if beside or table.base not in packaged else table.base
            below, experiment = _read(base, (*derived, name))
            below, states = _reduced(below, table.remove), True
        system = _overlaid(below, table, source.parent, states)
    except ValueError as error:
        raise ValueError(str(error) if str(error).startswith("system ") else f"{what}: {error}") from error
    return replace(system, name=Path(name).stem), table.experiment or experiment


def _overlaid(below: System, table: SystemTable, folder: Path, states: bool) -> System:
    """Return a system with the additions and replacements of a file; paths are relative to its folder.

    `states` says whether its parameters are added to `stated`.
    """
    system = _with_components(below, table, folder)
    connections = [
        Connection(f"{connect.source}.{output}", f"{connect.target}.{input_}", connect.option)
        for connect in table.connect
        for output, input_ in connect.pairs()
    ]
    fed = {link.target for link in connections} | {target for signal in table.signal for target in signal.targets}
    parameters, stated = dict(below.parameters), dict(below.stated)
    for component, values in table.parameters.items():
        parameters[component] = {**parameters.get(component, {}), **values}
        if states:
            stated[component] = stated.get(component, frozenset()) | values.keys()
    return replace(
        system,
        connections=(*(link for link in system.connections if link.target not in fed), *connections),
        signals=(*_unfed(system.signals, lambda t: t in fed), *(Signal(s.name, s.targets) for s in table.signal)),
        unrecorded=(*below.unrecorded, *table.unrecorded),
        parameters=parameters,
        stated=stated,
        **table.model_dump(include=table.model_fields_set & {"description", "coupling"}),
    )


def _with_components(below: System, table: SystemTable, folder: Path) -> System:
    """Return a system with the components of a file, which replace those of the same name.

    `before` is only used if the file has a base.
    """
    system, replaceable = below, {c.name for c in below.components}
    for new in table.component:
        fmu = new.fmu if new.fmu in models() else str(folder / new.fmu)
        names = [c.name for c in system.components]
        if new.name in replaceable:
            system = system.with_fmu(new.name, fmu)
            old, first = system.component(new.name), names.index(new.name)
            mandatory = new.mandatory if "mandatory" in new.model_fields_set else old.mandatory
            component, last = replace(old, every=new.every, mandatory=mandatory), first + 1
        elif new.before is None or new.before in names or not replaceable:
            component = Component(new.name, fmu, new.every, new.mandatory)
            first = last = names.index(new.before) if new.before is not None and replaceable else len(names)
        else:
            raise ValueError(f"no component {new.before!r}; {suggest(new.before, names)}")
        system = replace(system, components=(*system.components[:first], component, *system.components[last:]))
    return system


def _reduced(system: System, remove: Sequence[str]) -> System:
    """Return a system without the names in `remove`: components, parameters, and sources of inputs."""
    for entry in remove:
        name, dot, variable = entry.partition(".")
        names = [c.name for c in system.components]
        if name not in names:
            raise ValueError(f"remove: no component {name!r}; {suggest(name, names)}")
        values = system.parameters.get(name, {})
        remaining = {key: raw for key, raw in values.items() if key != variable and not matches(key, variable)}
        if not dot:
            system = _without_component(system, name)
        elif len(remaining) < len(values):
            system = replace(system, parameters={**system.parameters, name: remaining})
        else:
            system = _without_source(system, name, variable)
    return system


def _without_component(system: System, name: str) -> System:
    """Return a system without a component, its parameters and its connections."""
    return replace(
        system,
        components=tuple(c for c in system.components if c.name != name),
        connections=tuple(link for link in system.connections if not link.touches(name)),
        signals=_unfed(system.signals, lambda target: matches(target, f"{name}.*")),
        parameters={c: values for c, values in system.parameters.items() if c != name},
        unrecorded=tuple(p for p in system.unrecorded if not p.startswith(f"{name}.")),
    )


def _without_source(system: System, component: str, pattern: str) -> System:
    """Return a system in which the inputs that match a pattern have no source, and other patterns do not connect them.

    Raises
    ------
    ValueError
        If nothing feeds an input of this name; patterns are matched later, when the FMUs are known.
    """
    prefix, whole = f"{component}.", f"{component}.{pattern}"
    inputs = [target.removeprefix(prefix) for _, target in system.feeds() if target.startswith(prefix)]
    if not any(is_pattern(name) or matches(name, pattern) for name in inputs):
        options = [*system.parameters.get(component, {}), *inputs]
        raise ValueError(
            f"remove: the base neither sets nor feeds {pattern!r} of {component}; {suggest(pattern, options)}"
        )
    links = (
        replace(link, but=(*link.but, pattern)) if link.target.startswith(prefix) else link
        for link in system.connections
        if link.target != whole and not matches(link.target, whole)
    )
    return replace(
        system, connections=tuple(links), signals=_unfed(system.signals, lambda target: matches(target, whole))
    )


def _unfed(signals: Sequence[Signal], is_removed: Callable[[str], bool]) -> tuple[Signal, ...]:
    """Return the signals without some of their inputs, and without signals that then feed nothing."""
    reduced = (replace(s, targets=tuple(t for t in s.targets if not is_removed(t))) for s in signals)
    return tuple(signal for signal in reduced if signal.targets)
