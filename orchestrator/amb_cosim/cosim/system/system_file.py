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

A file with a `base`, the name or path of another system, extends it: its components follow those of the base, or
precede the one in `before`; a component of the same name replaces the base's, a connection or signal replaces the
source of the same input, and parameters are merged. `remove` deletes parts of the base: a component with all its
connections, by name; a parameter, or the source of an input, as `component.variable`, with wildcards `*` and `?`.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TypeVar

from amb_cosim.cosim.fmu.fmus import models
from amb_cosim.cosim.system.experiment import Experiment
from amb_cosim.cosim.system.system import Connection, Signal, System
from amb_cosim.cosim.system.system_overlay import overlaid
from amb_cosim.cosim.system.system_tables import OverlayTable, SystemTable
from amb_cosim.cosim.system.tables import check_bases
from amb_files.packs import files_of
from amb_files.suggestions import suggest
from amb_files.toml import read_toml, validate


def packaged_systems() -> dict[str, Path]:
    """Return the files of the systems that come with amb-cosim and with packs, by name."""
    return files_of("systems", amb_cosim=Path(__file__).parents[2])


def load_system(name: str | Path, options: Mapping[str, bool] | None = None) -> System:
    """Read a system of amb-cosim or of a pack, or a TOML file.

    Parameters
    ----------
    options
        Options of connections that are switched off; all others are on.

    Raises
    ------
    ValueError
        If no such system exists, or its description is wrong.

    Examples
    --------
    >>> [component.name for component in load_system("levitated").components]
    ['rolac_controller', 'amb_actuator', 'rotor_contact']
    """
    table, stated = _table(str(name)), _stated(str(name))
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
        components=tuple(c.component() for c in table.component),
        connections=tuple(connections.values()),
        signals=tuple(signals.values()),
        coupling=table.coupling,
        parameters=table.parameters,
        unrecorded=table.unrecorded,
        stated={component: names & {*table.parameters.get(component, {})} for component, names in stated.items()},
    )


def _stated(name: str) -> dict[str, frozenset[str]]:
    """Return the names of parameters by component that a system file sets, or a base of it that has a base itself."""
    packaged = packaged_systems()
    source = packaged.get(name, Path(name))
    data = read_toml(source, f"system {name}")
    stated = {component: frozenset(values) for component, values in data.get("parameters", {}).items()}
    if "base" not in data:
        return {} if name in packaged else stated
    base = data["base"] if data["base"] in packaged else str(source.parent / data["base"])
    below = _stated(base)
    return {
        component: stated.get(component, frozenset()) | below.get(component, frozenset())
        for component in stated | below
    }


def is_system(name: str | Path) -> bool:
    """Return whether a name is that of an included system, or of a file with components or a run."""
    path = Path(name)
    keys = read_toml(path, f"file {name}").keys() if path.is_file() else ()
    return str(name) in packaged_systems() or not {"component", "connect", "experiment"}.isdisjoint(keys)


def load_experiment(name: str | Path, without: Experiment | None = None) -> Experiment:
    """Read the experiment of a system file.

    Parameters
    ----------
    without
        Returned for a file without an experiment.

    Raises
    ------
    ValueError
        If the file has no table `experiment`, or it is wrong.
    """
    table = _table(str(name)).experiment
    if table is None and without is not None:
        return without
    if table is None:
        raise ValueError(f"system {name} has no table [experiment], which defines the run")
    try:
        return table.experiment()
    except ValueError as error:
        raise ValueError(f"system {name}: experiment: {error}") from error


def _table(name: str, derived: tuple[str, ...] = ()) -> SystemTable:
    """Return the content of a system file merged with its base; paths in a file are relative to it."""
    packaged = packaged_systems()
    source = packaged.get(name, Path(name))
    if not source.is_file():
        raise ValueError(f"no system {name!r}; {suggest(name, sorted(packaged))}")
    what = f"system {name}"
    check_bases(what, derived)
    data = read_toml(source, what)
    if "base" not in data:
        return _with_paths(validate(data, SystemTable, what), source)
    overlay = _with_paths(validate(data, OverlayTable, what), source)
    base = overlay.base
    if base not in packaged:
        base = str(source.parent / base)
    try:
        return overlaid(_table(base, (*derived, name)), overlay)
    except ValueError as error:
        raise ValueError(str(error) if str(error).startswith("system ") else f"{what}: {error}") from error


T = TypeVar("T", bound=SystemTable)


def _with_paths(table: T, source: Path) -> T:
    """Return the table with the paths of its FMUs relative to the working directory."""
    components = tuple(
        c if c.fmu in models() else c.model_copy(update={"fmu": str(source.parent / c.fmu)}) for c in table.component
    )
    return table.model_copy(update={"component": components})
