"""The linear model of a scenario or system, from constants of this project's models and responses of other FMUs."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from os import PathLike
from pathlib import Path

from amb_analysis.linear.components import LinearComponent, in_order, loop_of
from amb_analysis.linear.linear_source import LinearSource, linear_source
from amb_analysis.linear.model import LinearModel, linear_model
from amb_cosim.cosim.choices import Flavour
from amb_cosim.cosim.errors import give_warnings
from amb_cosim.cosim.fmu.fmus import FmuSource
from amb_cosim.cosim.processes.blas import one_blas_thread
from amb_cosim.cosim.system.system import System
from amb_cosim.cosim.system.values import Raw
from amb_cosim.scenario.rotors import RotorSource
from amb_cosim.scenario.scenario import SPEED, Scenario
from amb_files.checks import as_names
from amb_files.suggestions import suggest
from amb_files.wildcards import matching_names


@one_blas_thread()
def linearise(
    source: str | Path | Scenario | System | None = None,
    at: Raw | Mapping[str, Raw] | None = None,
    inputs: str | Sequence[str] | None = None,
    outputs: str | Sequence[str] | None = None,
    *,
    components: str | Sequence[str] | None = None,
    opened: str | Sequence[str] = (),
    rotor: RotorSource = None,
    fmu: Mapping[str, FmuSource | PathLike[str]] | None = None,
    set: Mapping[str, Raw] | None = None,
    flavour: Flavour = "native",
) -> LinearModel:
    """Return the linear model of a machine, a part of it, or its sampled loop, as control.StateSpace.

    The rotor, which is modelled without contact, and the magnetic bearings are continuous. If the components include a
    controller, the model has the sample time of the controller, and is exact for currents held over each sample. A
    value injected at an input is added to the signal that feeds the input, and is delayed by the same fraction of a
    sample as this signal (`components.loop_of`).

        rotor = linearise("drop", components=["rotor_contact"])
        plant = linearise("drop", components=["rotor_contact", "amb_actuator"])
        S = linearise("drop", inputs=["amb_actuator.*.i_?"], outputs=["amb_actuator.*.i_?"])

    Parameters
    ----------
    source
        A scenario (a `Scenario`, the name of a packaged scenario, or a TOML file), or a system (a `System`, or its name
        or file). The default is the packs' default scenario.
    at
        Spin speed (in rad/s, or as text with its unit), or values by name. A name is `Omega`, or `component.variable`
        of an input such as a displacement or current of a magnetic bearing. Values default to the start values of the
        scenario, or to 0.
    inputs, outputs
        Names or patterns `component.variable`. An input may be named as an output; its value is the sum of all signals
        at this input. By default, the model has all outputs, and the inputs to which nothing is connected.
    components
        Component or components of the model; all by default.
    opened
        Names or patterns of inputs whose connection is cut.
    rotor, fmu, set, flavour
        As for `amb_cosim.run`.

    Raises
    ------
    ValueError
        If a name or value is not allowed, if components have different sample times, or if an FMU has no linear model.
    FmuError
        If an FMU of another project fails to run.

    Examples
    --------
    >>> rotor = linearise("compressor_levitated", components=["rotor_contact"])
    >>> rotor.nstates, rotor.ninputs, rotor.noutputs
    (28, 20, 16)
    """
    resolved = linear_source(source, at, rotor=rotor, fmu=fmu, set=set, flavour=flavour)
    model = model_of(resolved, inputs, outputs, components, opened)
    give_warnings(model.warnings)
    return model


def model_of(
    source: LinearSource,
    inputs: str | Sequence[str] | None = None,
    outputs: str | Sequence[str] | None = None,
    components: str | Sequence[str] | None = None,
    opened: str | Sequence[str] = (),
) -> LinearModel:
    """Return the linear model of some components of a source; other arguments and errors as for `linearise`."""
    present = source.names
    components = None if components is None else as_names("components", components)
    for name in components or ():
        if name not in present:
            raise ValueError(f"no component {name!r}; {suggest(name, present)}")
    chosen, units = [name for name in present if components is None or name in components], source.units()
    parts, feeds = source.parts(chosen), source.feeds(chosen)
    parts, feeds = in_order(parts, feeds, chosen)
    reason = partial(_reason, source, parts)
    cut = _matching("opened", opened, [end for part in parts for end in part.inputs], reason)
    cut_feeds = {name: feeds.pop(name) for name in cut if name in feeds}
    whole = loop_of(parts, feeds, cut_feeds)
    part_inputs = {end for part in parts for end in part.inputs}
    free = [name for name in whole.inputs if name in part_inputs and (inputs is not None or name not in feeds)]
    variables = [name for name in whole.outputs if name in units]
    part_outputs = [name for name in variables if name not in part_inputs]
    chosen_inputs = free if inputs is None else _matching("inputs", inputs, free, reason)
    chosen_outputs = part_outputs if outputs is None else _matching("outputs", outputs, variables, reason)
    point = {SPEED: source.plan.inputs[SPEED]} if SPEED in source.plan.inputs else {}
    model = linear_model(whole.selected(chosen_inputs, chosen_outputs), units, {**point, **source.point})
    model.warnings = source.plan.warnings
    return model


def _matching(
    what: str, patterns: Sequence[str], names: Sequence[str], reason: Callable[[str, Sequence[str]], str]
) -> list[str]:
    """Return the names that match patterns, each once, in the patterns' order; `reason` completes the error message."""
    result: dict[str, None] = {}
    for pattern in as_names(what, patterns):
        matching = [pattern] if pattern in names else matching_names(names, pattern)
        if not matching:
            raise ValueError(f"{what}: nothing in the linear model matches {pattern!r}; {reason(pattern, names)}")
        result |= dict.fromkeys(matching)
    return list(result)


def _reason(source: LinearSource, parts: Sequence[LinearComponent], pattern: str, names: Sequence[str]) -> str:
    """Return why the linear model lacks the variables that match a pattern, or similar names if no variable matches.

    Such a variable is a parameter, an output that cannot be an input, a variable that the model neglects, or a variable
    of a component outside the model.
    """
    ports = {
        f"{c}.{p.name}": (c, p) for c, interface in source.plan.interfaces.items() for p in interface.ports.values()
    }
    matching = [pattern] if pattern in ports else matching_names(list(ports), pattern)
    if not matching:
        return suggest(pattern, names)
    name, rest = matching[0], f" and {len(matching) - 1} more" if len(matching) > 1 else ""
    component, port = ports[name]
    if port.causality == "parameter" or name in {end for part in parts for end in part.outputs}:
        return f"{name}{rest}: it is {port.kind}"
    notes = [note for part in parts for note in part.notes if note.startswith(f"{component}: ")]
    return f"{name}{rest}: {'; '.join(notes) or f'{component} is not among its components'}"
