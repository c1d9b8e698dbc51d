"""The part of a modelDescription that wiring, scenarios and results need."""

from __future__ import annotations

import fnmatch
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import fmpy

from amb_files.suggestions import suggest
from fmi_export.variables import TOOL

UnitDefinition = tuple[float, ...]  # exponents of kg, m, s, A, K, mol, cd, rad, then factor and offset

_BASE = ("kg", "m", "s", "A", "K", "mol", "cd", "rad", "factor", "offset")


@dataclass(frozen=True)
class Port:
    """One scalar variable of an FMU.

    `definition` is None where the FMU does not define its unit; `depends_on` of an output names the inputs
    that reach it without delay. `warning` is the sentence of an output that is a warning. `items` are the names of the
    values of an Enumeration, which is an Integer otherwise.
    """

    name: str
    type: str
    causality: str
    reference: int
    unit: str | None = None
    definition: UnitDefinition | None = None
    minimum: float = -math.inf
    maximum: float = math.inf
    start: float | None = None
    description: str = ""
    depends_on: tuple[str, ...] = ()
    warning: str = ""
    items: Mapping[str, int] = field(default_factory=dict)
    variability: str = "continuous"

    @property
    def shown_unit(self) -> str:
        """The unit with a leading space, empty where the variable has none."""
        return "" if self.unit in (None, "", "1") else f" {self.unit}"

    @property
    def kind(self) -> str:
        """The causality with its article: `an input`."""
        return f"{'an' if self.causality[0] in 'io' else 'a'} {self.causality}"

    def allowed(self) -> str:
        """Allowed values in words."""
        if self.type == "Boolean":
            return "true or false"
        if self.items:
            return f"one of {', '.join(f'{value} ({name})' for name, value in self.items.items())}"
        low = f">= {self.minimum:g}" if self.minimum > -math.inf else ""
        high = f"<= {self.maximum:g}" if self.maximum < math.inf else ""
        bounds = " and ".join(bound for bound in (low, high) if bound)
        if not bounds:
            return "a finite number"
        return bounds + self.shown_unit


@dataclass(frozen=True)
class FmuInterface:
    """An FMU's identity and its variables by name, in the order of the modelDescription.

    `takes_any_step` is whether it can handle a communication step other than its own, `saves_state` whether it can go
    back to an earlier state, `serialises_state` whether such a state can be written. `states` are the names of the
    continuous states and of their derivatives by time, of an FMU that gives directional derivatives and lists them.
    """

    identifier: str
    guid: str
    version: str
    ports: Mapping[str, Port]
    takes_any_step: bool = False
    saves_state: bool = False
    serialises_state: bool = False
    states: tuple[tuple[str, str], ...] = ()

    def of(self, causality: str) -> tuple[Port, ...]:
        """Return the variables of a causality."""
        return self._by_causality.get(causality, ())

    @cached_property
    def _by_causality(self) -> dict[str, tuple[Port, ...]]:
        kinds = dict.fromkeys(port.causality for port in self.ports.values())
        return {kind: tuple(port for port in self.ports.values() if port.causality == kind) for kind in kinds}

    def matching(self, pattern: str) -> tuple[Port, ...]:
        """Return the variables whose names match a pattern with `*` and `?`."""
        if pattern not in self._matching:
            self._matching[pattern] = tuple(self.ports[name] for name in fnmatch.filter(self.ports, pattern))
        return self._matching[pattern]

    @cached_property
    def _matching(self) -> dict[str, tuple[Port, ...]]:
        return {}

    def port(self, name: str, component: str) -> Port:
        """Return the variable called `name`.

        Raises
        ------
        ValueError
            If there is none; the message lists the names nearest to it.
        """
        if name not in self.ports:
            raise ValueError(f"{component} has no variable {name!r}; {suggest(name, self.ports)}")
        return self.ports[name]


def read_interface(folder: Path, name: str, archive: Path | None = None) -> FmuInterface:
    """Read the interface of an FMU.

    Parameters
    ----------
    folder
        Where it is extracted.
    name, archive
        Component and file in messages; the folder by default.

    Raises
    ------
    ValueError
        If it is no FMI 2.0 co-simulation FMU.
    """
    source = archive or folder
    try:
        description = fmpy.read_model_description(str(folder))
        return _interface(description, folder, f"{name}: {source}")
    except NotTaken:
        raise
    except Exception as error:  # whatever a damaged description leads to
        raise ValueError(f"{name}: {source} is no FMU that can be read ({_first_line(error)})") from error


class NotTaken(ValueError):
    """A description that is in order, of an FMU that is not taken."""


def _interface(description: Any, folder: Path, what: str) -> FmuInterface:
    if description.fmiVersion.startswith("3."):
        raise NotTaken(f"{what} is an FMU of FMI {description.fmiVersion}; this master runs those of FMI 2.0")
    if not description.fmiVersion.startswith("2.") or description.coSimulation is None:
        raise NotTaken(f"{what} is no FMI 2.0 co-simulation FMU")
    definitions = {
        unit.name: tuple(float(getattr(unit.baseUnit, field)) for field in _BASE)
        for unit in description.unitDefinitions
        if unit.baseUnit is not None
    }
    inputs = tuple(v.name for v in description.modelVariables if v.causality == "input")
    depends_on = {
        unknown.variable.name: inputs
        if unknown.dependencies is None
        else tuple(v.name for v in unknown.dependencies if v.causality == "input")
        for unknown in description.outputs
    }
    warnings = _warnings(folder)
    ports = {
        v.name: _port(v, definitions, depends_on.get(v.name, ()), warnings.get(v.name, ""))
        for v in description.modelVariables
        if v.type != "String"
    }
    ability = description.coSimulation
    return FmuInterface(
        identifier=ability.modelIdentifier,
        guid=description.guid,
        version=description.version or "",
        ports=ports,
        takes_any_step=bool(ability.canHandleVariableCommunicationStepSize),
        saves_state=bool(ability.canGetAndSetFMUstate),
        serialises_state=bool(ability.canGetAndSetFMUstate and ability.canSerializeFMUstate),
        states=_states(description) if ability.providesDirectionalDerivative else (),
    )


def _states(description: Any) -> tuple[tuple[str, str], ...]:
    """Return names of states and of their derivatives; none if a derivative does not say of what."""
    listed = [unknown.variable for unknown in description.derivatives]
    pairs = tuple((v.derivative.name, v.name) for v in listed if v is not None and v.derivative is not None)
    return pairs if len(pairs) == len(listed) else ()


def _warnings(folder: Path) -> dict[str, str]:
    """Return the sentences of the outputs that are warnings, which fmpy leaves out."""
    content = (folder / "modelDescription.xml").read_bytes()
    variables = ElementTree.fromstring(content).iterfind("ModelVariables/ScalarVariable[Annotations]")
    declared = ((v.get("name", ""), v.find(f"Annotations/Tool[@name='{TOOL}']/Warning")) for v in variables)
    return {variable: warning.get("sentence", "") for variable, warning in declared if warning is not None}


def _port(variable: Any, definitions: Mapping[str, UnitDefinition], depends_on: tuple[str, ...], warning: str) -> Port:
    declared = variable.declaredType
    unit = variable.unit or (declared.unit if declared is not None else None)
    items = declared.items if declared is not None and variable.type == "Enumeration" else ()
    return Port(
        name=variable.name,
        type="Integer" if variable.type == "Enumeration" else variable.type,
        causality=variable.causality or "local",
        reference=int(variable.valueReference),
        unit=unit,
        definition=definitions.get(unit) if unit is not None else None,
        minimum=-math.inf if variable.min is None else float(variable.min),
        maximum=math.inf if variable.max is None else float(variable.max),
        start=_number(variable.start),
        description=variable.description or "",
        depends_on=depends_on,
        warning=warning,
        items={item.name: int(item.value) for item in items},
        variability=variable.variability or "continuous",
    )


def _number(start: str | None) -> float | None:
    if start is None:
        return None
    return {"true": 1.0, "false": 0.0}[start] if start in ("true", "false") else float(start)


def _first_line(error: Exception) -> str:
    return (str(error) or type(error).__name__).strip().splitlines()[0]
