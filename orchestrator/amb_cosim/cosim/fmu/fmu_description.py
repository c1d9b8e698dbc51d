"""Reads the interface of an FMU from its modelDescription in FMI 2.0 or 3.0.

Each element of an FMI 3.0 array becomes a variable, in row-major order, with a name such as `gains[2,3]`; indices start
at 1. FMUs exported by this project state the FMI 2.0 names of the elements; these names are then used instead. If the
size of an array is a parameter, its start value applies.
"""

from __future__ import annotations

import itertools
import json
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any, Literal, NamedTuple, get_args
from xml.etree import ElementTree

from amb_cosim.cosim.fmu.fmu_interface import FmuInterface, Port, TextVariable, UnitDefinition
from amb_cosim.cosim.fmu.tolerant_reading import DESCRIPTION, read_tolerantly
from amb_files.checks import single_line
from fmi_export.building.units import SI
from fmi_export.variables import TOOL, OverStep

_BASE_UNIT_FIELDS = (*SI, "factor", "offset")

# Type of a variable for the master, by its type of FMI 2.0 or 3.0; clocks are not supported.
_TYPES = {
    **{name: "Real" for name in ("Real", "Float32", "Float64")},
    **{name: "Integer" for name in ("Integer", "Enumeration")},
    **{f"{sign}Int{bits}": "Integer" for sign in ("", "U") for bits in (8, 16, 32, 64)},
    "Boolean": "Boolean",
}
_TEXTS: tuple[Literal["String", "Binary"], ...] = ("String", "Binary")

NOTES = f"extra/{TOOL}/variables.json"  # as description3.py has it, whose import loads a compiler

# Limits of types that hold less than an Integer of FMI 2.0 does, or other numbers.
_LIMITS = {
    "Int8": (-128.0, 127.0),
    "UInt8": (0.0, 255.0),
    "Int16": (-32768.0, 32767.0),
    "UInt16": (0.0, 65535.0),
    "UInt32": (0.0, 4294967295.0),
    "UInt64": (0.0, math.inf),
}


class _Notes(NamedTuple):
    """Additional data of a variable in FMUs of this project: warning, rule over a step, names and texts of elements."""

    warning: str = ""
    over_step: OverStep = "end"
    elements: tuple[tuple[str, str], ...] = ()


def read_interface(folder: Path, name: str, archive: Path | None = None) -> FmuInterface:
    """Read the interface of an FMU.

    Parameters
    ----------
    folder
        Folder to which the FMU is extracted.
    name, archive
        Names of the component and the file in messages; the folder replaces a missing file name.

    Raises
    ------
    ValueError
        If it is not an FMI 2.0 or 3.0 FMU for co-simulation.
    """
    file = folder / DESCRIPTION
    return _read(folder, name, archive or folder, file.stat().st_mtime_ns if file.is_file() else 0)


@lru_cache(maxsize=64)  # a study runs the same FMUs many times
def _read(folder: Path, name: str, source: Path, _changed: int) -> FmuInterface:
    """Return the interface of an FMU whose description was last changed at this time (ns)."""
    try:
        description, deviations = read_tolerantly(folder)
        return replace(_interface(description, folder, f"{name}: {source}"), deviations=deviations)
    except Unsupported:
        raise
    except Exception as error:  # any that a damaged description causes
        raise ValueError(f"{name}: {source} is not a readable FMU ({single_line(error)})") from error


class Unsupported(ValueError):
    """The description is valid, but the FMU is not supported."""


def _interface(description: Any, folder: Path, what: str) -> FmuInterface:
    major = description.fmiVersion.partition(".")[0]
    if major not in ("2", "3") or description.coSimulation is None:
        kinds = {"modelExchange": "model exchange", "coSimulation": "co-simulation", "scheduledExecution": "schedules"}
        provided = [kind for name, kind in kinds.items() if getattr(description, name, None) is not None]
        kind = f"{' and '.join(provided) or 'no purpose'} of FMI {description.fmiVersion}"
        raise Unsupported(f"{what} is an FMU for {kind}; it must support co-simulation of FMI 2.0 or 3.0")
    definitions = {
        unit.name: tuple(float(getattr(unit.baseUnit, field)) for field in _BASE_UNIT_FIELDS)
        for unit in description.unitDefinitions
        if unit.baseUnit is not None
    }
    units = {unit.name: _with_display_units(unit, definitions) for unit in description.unitDefinitions}
    notes = _notes(folder)
    _add_omitted(description, folder)
    supported = [v for v in description.modelVariables if v.type in _TYPES and not v.clocks and not _is_time(v, major)]
    names = {v.name: _names(v, notes.get(v.name, _Notes())) for v in supported}

    def inputs_among(variables: Iterable[Any]) -> tuple[str, ...]:
        return tuple(name for v in variables if v.causality == "input" for name, _ in names.get(v.name, ()))

    every_input = inputs_among(description.modelVariables)
    depends_on = {
        unknown.variable.name: every_input if unknown.dependencies is None else inputs_among(unknown.dependencies)
        for unknown in description.outputs
    }
    ports = {
        port.name: port
        for v in supported
        for port in _ports(
            v, names[v.name], definitions, units, depends_on.get(v.name, ()), notes.get(v.name, _Notes())
        )
    }
    capabilities = description.coSimulation
    return FmuInterface(
        identifier=capabilities.modelIdentifier,
        guid=description.guid,
        version=description.version or "",
        ports=ports,
        takes_any_step=bool(capabilities.canHandleVariableCommunicationStepSize),
        saves_state=bool(capabilities.canGetAndSetFMUstate),
        serialises_state=bool(capabilities.canGetAndSetFMUstate and capabilities.canSerializeFMUstate),
        states=_states(description) if capabilities.providesDirectionalDerivative and major == "2" else (),
        fmi=3 if major == "3" else 2,
        once_per_process=bool(capabilities.canBeInstantiatedOnlyOncePerProcess),
        texts={text.name: text for text in _texts(description)},
        internal_step=_of_experiment(description, "stepSize"),
        tolerance=_of_experiment(description, "tolerance"),
        reports_faults=(description.generationTool or "").startswith(f"{TOOL} "),
    )


def _with_display_units(unit: Any, definitions: Mapping[str, UnitDefinition]) -> Mapping[str, UnitDefinition]:
    """Return the definitions of all units, b = F v + O, and of the display units of one unit, d = f v + o."""
    displays = {display.name: display for display in unit.displayUnits if display.name not in definitions}
    if unit.name not in definitions or not displays:
        return definitions
    *powers, factor, offset = definitions[unit.name]
    result = dict(definitions)
    for name, display in displays.items():
        f, o = float(display.factor or 1.0), float(display.offset or 0.0)
        if f and getattr(display, "inverse", None) not in ("true", "1"):
            result[name] = (*powers, factor / f, offset - factor * o / f)
    return result


def _texts(description: Any) -> Iterator[TextVariable]:
    """Return the String and Binary variables, except the variables of clocks."""
    for v in description.modelVariables:
        kind = next((kind for kind in _TEXTS if kind == v.type), None)
        if kind is not None and not v.clocks:
            yield TextVariable(v.name, kind, v.causality or "local", int(v.valueReference), math.prod(v.shape or ()))


def _of_experiment(description: Any, attribute: str) -> float | None:
    """Return an attribute of the default experiment if it is a positive number, otherwise None."""
    with suppress(TypeError, ValueError):  # None, or a text that is not a number
        value = float(getattr(description.defaultExperiment, attribute, None))  # type: ignore[arg-type]
        return value if 0.0 < value < math.inf else None
    return None


def _states(description: Any) -> tuple[tuple[str, str], ...]:
    """Return the names of the states and of their derivatives; empty if a derivative does not name its state."""
    listed = [unknown.variable for unknown in description.derivatives]
    pairs = tuple((v.derivative.name, v.name) for v in listed if v is not None and v.derivative is not None)
    return pairs if len(pairs) == len(listed) else ()


def _notes(folder: Path) -> dict[str, _Notes]:
    """Return the additional data of variables, from annotations (FMI 2.0) or a file (FMI 3.0)."""
    if (file := folder / NOTES).is_file():
        entries = json.loads(file.read_bytes())
        return {
            v: _Notes(e.get("warning", ""), _rule(e.get("over_step")), tuple(map(tuple, e.get("elements", ()))))
            for v, e in entries.items()
        }
    content = (folder / DESCRIPTION).read_bytes()
    result = {}
    for variable in ElementTree.fromstring(content).iterfind("ModelVariables/ScalarVariable[Annotations]"):
        tool = variable.find(f"Annotations/Tool[@name='{TOOL}']")
        if tool is not None:
            stated = {item.tag: item.attrib for item in tool}
            sentence, rule = stated.get("Warning", {}).get("sentence", ""), stated.get("OverStep", {}).get("rule")
            result[variable.get("name", "")] = _Notes(sentence, _rule(rule))
    return result


def _rule(stated: str | None) -> OverStep:
    """Return the rule by which a variable summarises a step; it is `end` unless the FMU states a known one."""
    return next((rule for rule in get_args(OverStep) if rule == stated), "end")


def _add_omitted(description: Any, folder: Path) -> None:
    """Set attributes of variables that FMPy 0.3 does not read: relativeQuantity, and limits of unsigned integers."""
    content = (folder / DESCRIPTION).read_bytes()
    if b"relativeQuantity" not in content and b"<UInt" not in content:
        return
    variables = {v.name: v for v in description.modelVariables}
    for element in ElementTree.fromstring(content).iterfind("ModelVariables/*"):
        v = variables[element.get("name", "")]
        for typed in (element, *element):
            if (relative := typed.get("relativeQuantity")) is not None:
                v.relativeQuantity = relative in ("true", "1")
        if v.type.startswith("UInt"):
            v.min, v.max = element.get("min"), element.get("max")


def _has_start(variable: Any) -> bool:
    """Return whether a user may set the start value of an output or local variable (`exact` or `approx` in FMI)."""
    is_computed = variable.causality in (None, "local", "output") and variable.variability != "constant"
    return is_computed and variable.initial in ("exact", "approx")


def _is_time(variable: Any, major: str) -> bool:
    """Return whether a variable is the time, which every FMI 3.0 FMU declares."""
    return major == "3" and variable.causality == "independent"


def _names(variable: Any, notes: _Notes) -> tuple[tuple[str, str], ...]:
    """Return the name and description of a variable, or of each element of an array."""
    shape, text = tuple(variable.shape or ()), variable.description or ""
    if not shape:
        return ((variable.name, text),)
    if len(notes.elements) == math.prod(shape):
        return notes.elements
    return tuple((f"{variable.name}[{','.join(map(str, place))}]", text) for place in _places(shape))


def _places(shape: Sequence[int]) -> Iterator[tuple[int, ...]]:
    """Return the indices of the elements of an array, row by row."""
    return itertools.product(*(range(1, n + 1) for n in shape))


def _ports(
    variable: Any,
    names: Sequence[tuple[str, str]],
    definitions: Mapping[str, UnitDefinition],
    units: Mapping[str, Mapping[str, UnitDefinition]],
    depends_on: tuple[str, ...],
    notes: _Notes,
) -> Iterator[Port]:
    """Yield a port for a variable, or for each element of an array."""
    declared = variable.declaredType
    unit = variable.unit or inherited(variable, "unit")
    items = declared.items if declared is not None and variable.type == "Enumeration" else ()
    lowest, highest = _LIMITS.get(variable.type, (-math.inf, math.inf))
    minimum, maximum = (inherited(variable, name) for name in ("min", "max"))
    first = Port(
        name=variable.name,
        type=_TYPES[variable.type],
        causality=variable.causality or "local",
        reference=int(variable.valueReference),
        unit=unit,
        definition=definitions.get(unit) if unit is not None else None,
        units=units.get(unit or "", definitions),
        minimum=lowest if minimum is None else float(minimum),
        maximum=highest if maximum is None else float(maximum),
        start=None if variable.shape else _number(variable.start),
        description=variable.description or "",
        depends_on=depends_on,
        warning=notes.warning,
        over_step=notes.over_step,
        items={item.name: int(item.value) for item in items},
        variability=variable.variability or "continuous",
        stored=variable.type,
        relative=bool(inherited(variable, "relativeQuantity")),
        has_start=_has_start(variable),
    )
    if not variable.shape:
        yield first
        return
    starts = [None] if variable.start is None else variable.start.split()
    starts = starts * len(names) if len(starts) == 1 else starts
    places = _places(variable.shape)
    for k, ((name, text), start, place) in enumerate(zip(names, starts, places, strict=True)):
        number, array = _number(start), (variable.name, *place)
        yield replace(first, name=name, description=text, start=number, element=k, size=len(names), array=array)


def inherited(variable: Any, attribute: str) -> Any:
    """Return an attribute of a variable or, if the variable lacks it, of its declared type; None if both lack it."""
    own = getattr(variable, attribute, None)
    return getattr(variable.declaredType, attribute, None) if own is None else own


def _number(start: str | None) -> float | None:
    if start is None:
        return None
    return {"true": 1.0, "false": 0.0}[start] if start in ("true", "false") else float(start)
