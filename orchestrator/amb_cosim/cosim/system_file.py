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

    [[signal]]                        # one value for several inputs
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

A file with a `base`, the name or path of another system, is laid over it: its components come after those of the base
or where `before` says, a connection or signal replaces what fed the same input, and parameters are merged.
"""

from __future__ import annotations

from collections.abc import Mapping
from importlib import resources
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import TypeVar

from pydantic import Field

from amb_cosim.cosim.choices import Coupling
from amb_cosim.cosim.experiment import EVERYTHING, Event, Experiment, Profile
from amb_cosim.cosim.fmus import models
from amb_cosim.cosim.stopping import StopCondition
from amb_cosim.cosim.system import Component, Connection, Signal, System
from amb_cosim.cosim.tables import Table, Value, Values, time_of
from amb_cosim.cosim.values import Raw
from amb_files.suggestions import suggest
from amb_files.toml import read_toml, validate


class ComponentTable(Table):
    """An instance of an FMU; `before` names the component of the base that it precedes."""

    name: str
    fmu: str
    every: int = Field(default=1, ge=1)
    mandatory: tuple[str, ...] = ()
    before: str | None = None


class ConnectTable(Table):
    """Outputs of one component to inputs of another; with `option` only where that option is on."""

    source: str = Field(alias="from")
    target: str = Field(alias="to")
    variables: tuple[str, ...] | dict[str, str]
    option: str | None = None

    def connections(self) -> list[Connection]:
        """The connections, variable by variable."""
        return [Connection(f"{self.source}.{output}", f"{self.target}.{input_}") for output, input_ in self.pairs()]

    def pairs(self) -> list[tuple[str, str]]:
        """Names of output and input, connection by connection."""
        if isinstance(self.variables, dict):
            return list(self.variables.items())
        return [(name, name) for name in self.variables]


class SignalTable(Table):
    """A shared signal and the inputs that it feeds."""

    name: str
    targets: tuple[str, ...] = Field(min_length=1)


class EventTable(Table):
    """From a time on, inputs have new values."""

    time: Value
    set: Values


class ProfileTable(Table):
    """An input that is linear between points (time, value)."""

    variable: str
    points: tuple[tuple[Value, Value], ...] = Field(min_length=1)
    slope: str | None = None


class StopTable(Table):
    """A condition that ends the run early."""

    variable: str
    above: Value | None = None
    below: Value | None = None
    hold_time: Value = 0.0
    from_time: Value = 0.0

    def condition(self) -> StopCondition:
        """The condition, times in s; raises ValueError unless one of `above` and `below` is given."""
        return stop_condition(
            self.variable,
            self.above,
            self.below,
            time_of(self.hold_time, "hold_time of stop", least=0.0),
            time_of(self.from_time, "from_time of stop", least=0.0),
        )


class Record(Table):
    """What is recorded: patterns of variable names, every how many steps, and whether settling is kept.

    `*` is all that the system records by itself; what it leaves out must be named.
    """

    variables: tuple[str, ...] = (EVERYTHING,)
    every: int = Field(default=1, ge=1)
    settling: bool = False


class ExperimentTable(Table):
    """A run: steps, times, inputs and what changes."""

    communication_step: Value
    stop_time: Value
    start_time: Value = 0.0
    inputs: Values = Field(default={})
    event: tuple[EventTable, ...] = ()
    profile: tuple[ProfileTable, ...] = ()
    stop: tuple[StopTable, ...] = ()
    record: Record = Record()

    def experiment(self) -> Experiment:
        """The run, times in s; raises ValueError where one is not allowed."""
        return Experiment(
            step_size=time_of(self.communication_step, "communication_step"),
            stop_time=time_of(self.stop_time, "stop_time"),
            start_time=time_of(self.start_time, "start_time", most=0.0),
            events=tuple(
                Event(time_of(e.time, "time of event", least=0.0), name, raw)
                for e in self.event
                for name, raw in e.set.items()
            ),
            profiles=tuple(
                Profile(p.variable, tuple((time_of(t, "time of a point", least=0.0), v) for t, v in p.points), p.slope)
                for p in self.profile
            ),
            stops=tuple(stop.condition() for stop in self.stop),
            recorded=self.record.variables,
            record_every=self.record.every,
            record_settling=self.record.settling,
        )


class SystemTable(Table):
    """A system file without its base."""

    description: str = ""
    coupling: Coupling = "gauss_seidel"
    unrecorded: tuple[str, ...] = ()
    parameters: dict[str, Values] = Field(default={})
    component: tuple[ComponentTable, ...] = Field(min_length=1)
    connect: tuple[ConnectTable, ...] = ()
    signal: tuple[SignalTable, ...] = ()
    experiment: ExperimentTable | None = None


class OverlayTable(SystemTable):
    """A system file with a base: what it adds to that, and what it says instead."""

    base: str
    component: tuple[ComponentTable, ...] = ()


def stop_condition(variable: str, above: Raw | None, below: Raw | None, hold: float, begin: float) -> StopCondition:
    """A stop condition; raises ValueError unless either `above` or `below` is given."""
    limit = above if below is None else below
    if (above is None) == (below is None) or limit is None:
        raise ValueError(f"stop on {variable} needs either above or below")
    return StopCondition(variable, above is not None, limit, hold, begin)


def packaged_systems() -> dict[str, Traversable]:
    """The systems that come with the package, by name."""
    folder = resources.files("amb_cosim").joinpath("systems")
    return {f.name.removesuffix(".toml"): f for f in folder.iterdir()}


def load_system(name: str | Path, options: Mapping[str, bool] | None = None) -> System:
    """Read a system, one that comes with the package or a TOML file.

    Parameters
    ----------
    options
        Options of connections that are switched off; all others are on.

    Raises
    ------
    ValueError
        If there is no such system, or its description is wrong.
    """
    table = _table(str(name))
    connections: dict[str, Connection] = {}
    signals: dict[str, Signal] = {}
    for connect in table.connect:
        if (options or {}).get(connect.option or "", True):
            for link in connect.connections():
                connections[link.target] = link
    for signal in table.signal:
        signals[signal.name] = Signal(signal.name, signal.targets)
    return System(
        name=Path(name).stem,
        description=table.description,
        components=tuple(Component(c.name, c.fmu, c.every, c.mandatory) for c in table.component),
        connections=tuple(connections.values()),
        signals=tuple(signals.values()),
        coupling=table.coupling,
        parameters=table.parameters,
        unrecorded=table.unrecorded,
    )


def load_experiment(name: str | Path) -> tuple[Experiment, Values]:
    """Read the experiment of a system file: the run, and the first values of inputs.

    Raises
    ------
    ValueError
        If the file has no table `experiment`, or it is wrong.
    """
    table = _table(str(name)).experiment
    if table is None:
        raise ValueError(f"system {name} has no table [experiment], which says what is run")
    try:
        return table.experiment(), table.inputs
    except ValueError as error:
        raise ValueError(f"system {name}: experiment: {error}") from error


def _table(name: str, derived: tuple[str, ...] = ()) -> SystemTable:
    """Content of a system file, laid over that of its base; paths in a file are relative to it."""
    packaged = packaged_systems()
    source: Traversable = packaged.get(name, Path(name))
    if not source.is_file():
        raise ValueError(f"no system {name!r}; {suggest(name, sorted(packaged))}")
    if name in derived:
        raise ValueError(f"system {name}: it is its own base ({' -> '.join((*derived, name))})")
    what = f"system {name}"
    data = read_toml(source, what)
    if "base" not in data:
        return _with_paths(validate(data, SystemTable, what), source)
    overlay = _with_paths(validate(data, OverlayTable, what), source)
    base = overlay.base
    if base not in packaged and isinstance(source, Path):
        base = str(source.parent / base)
    try:
        return _overlaid(_table(base, (*derived, name)), overlay)
    except ValueError as error:
        raise ValueError(str(error) if str(error).startswith("system ") else f"{what}: {error}") from error


T = TypeVar("T", bound=SystemTable)


def _with_paths(table: T, source: Traversable) -> T:
    """The table with the paths of its FMUs relative to the working directory."""
    if not isinstance(source, Path):
        return table
    components = tuple(
        c if c.fmu in models() else c.model_copy(update={"fmu": str(source.parent / c.fmu)}) for c in table.component
    )
    return table.model_copy(update={"component": components})


def _overlaid(below: SystemTable, above: OverlayTable) -> SystemTable:
    """A system with another laid over it."""
    components = list(below.component)
    for new in above.component:
        names = [component.name for component in components]
        if new.name in names:
            components[names.index(new.name)] = new
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
    given = above.model_dump(include=above.model_fields_set & {"description", "coupling"})
    merged = {
        "component": tuple(components),
        "connect": (*(_without(connect, fed) for connect in below.connect), *above.connect),
        "signal": (*(s for s in signals if s.targets), *above.signal),
        "unrecorded": (*below.unrecorded, *above.unrecorded),
        "parameters": parameters,
        "experiment": above.experiment or below.experiment,
    }
    return below.model_copy(update=given | merged)


def _without(connect: ConnectTable, fed: set[str]) -> ConnectTable:
    """A connect table of the base without the inputs that something else feeds."""
    left = {a: b for a, b in connect.pairs() if f"{connect.target}.{b}" not in fed}
    return connect.model_copy(update={"variables": left})
