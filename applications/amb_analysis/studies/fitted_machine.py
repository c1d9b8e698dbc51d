"""A rotor, or a rotor in its machine, as a function of the numbers in its files that are fitted."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any

import tomli_w

from amb_analysis.machine.channels import Place
from amb_analysis.machine.frequency_response import Loop, Structure, refined
from amb_analysis.machine.machine import machine_of
from amb_analysis.measured.least_squares import FreeParameter
from amb_analysis.studies.inputs import Number, controlled, spin_speed
from amb_analysis.studies.loop_parameters import LoopParameters, differences, is_of_component
from amb_analysis.studies.rotor_parameters import RotorParameters, number_of_file
from amb_cosim.cosim.choices import Flavour
from amb_cosim.cosim.run.options import RunOptions
from amb_cosim.cosim.system.values import Raw
from amb_cosim.results.component_names import CONTROLLER
from amb_cosim.scenario.plan import ScenarioPlan
from amb_cosim.scenario.prepare_run import prepare_run
from array_types import Array
from rotor_analysis.implausible_sizes import implausible_sizes
from rotor_analysis.rotor import Rotor

ROTOR_FILE, SCENARIO_FILE = "rotor.toml", "scenario.toml"
KEPT = 16  # reduced rotors of the last values


@dataclass(frozen=True)
class FittedMachine:
    """A rotor and its support, as a function of fitted numbers.

    loop, Omega
        Support of the rotor, and spin speed (rad/s).
    free
        Fitted parameters: first those of the rotor file, then those of components.
    rotor_parameters
        Parameters of the rotor file.
    loop_parameters
        Parameters of the machine's components; None if there is no machine.
    source, stated
        The rotor file, and the content of a scenario file for the machine. This content names the base of the scenario
        and any replacements of its rotor or FMUs.
    settings, flavour
        Values that replace values of the scenario, and flavour of the FMUs.
    places
        Places at which the rotor must have a node.
    """

    loop: Loop
    Omega: float
    free: tuple[FreeParameter, ...]
    rotor_parameters: RotorParameters
    loop_parameters: LoopParameters | None
    source: str | Path | None
    stated: Mapping[str, Any]
    settings: Mapping[str, Raw]
    flavour: Flavour
    places: tuple[Place, ...] = ()

    @cached_property
    def _rotors(self) -> Callable[[tuple[float, ...]], Structure]:
        return lru_cache(KEPT)(self._structure)

    @classmethod
    def load(
        cls,
        files: tuple[str | Path | None, str | Path | None, str | Path | None],
        loop: Loop,
        speed: Number | None,
        bounds: Mapping[str, tuple[Number, Number]],
        settings: Mapping[str, Raw],
        flavour: Flavour,
    ) -> FittedMachine:
        """Read the files of a scenario, a rotor and a controller; the keys of `bounds` are the parameters to fit.

        Raises
        ------
        ValueError
            If a file cannot be read, a name does not denote a number, or bounds are not allowed.
        """
        scenario, rotor, controller = files
        machine = controlled(*files) if scenario is not None or loop in ("open", "closed") else None
        source: Any = rotor if machine is None else machine.rotor
        if loop in ("free", "linear"):
            machine = None
        names = [name for name in bounds if machine is not None and is_of_component(machine, name)]
        others = [name for name in bounds if name not in names]
        of_rotor, of_loop = RotorParameters.load(source, others), None
        if machine is not None:
            prepared = prepare_run(machine.machine(), settings, options=RunOptions(flavour=flavour))
            of_loop = LoopParameters.of(machine_of(prepared), names)
        free = [FreeParameter(name, *(number_of_file(name, raw) for raw in bounds[name])) for name in others]
        if of_loop is not None:
            free += [FreeParameter(name, *(of_loop.number(name, raw) for raw in bounds[name])) for name in names]
        default = 0.0 if of_loop is None else of_loop.machine.Omega
        Omega = default if speed is None else spin_speed(speed)
        name = "" if machine is None else machine.name if scenario is None else str(scenario)
        stated: dict[str, Any] = {"base": _path(name)} | ({"rotor": _path(rotor)} if rotor else {})
        stated |= {"fmu": {CONTROLLER: _path(controller)}} if controller else {}
        return cls(loop, Omega, tuple(free), of_rotor, of_loop, source, stated, settings, flavour)

    def with_places(self, places: Sequence[Place]) -> FittedMachine:
        """Return the rotor and its support with nodes at these places; these nodes do not move if parameters change."""
        positions = [place.position for place in places if place.position is not None]
        rotor_parameters = RotorParameters.load(self.source, self.rotor_parameters.names, positions)
        return replace(self, places=tuple(places), rotor_parameters=rotor_parameters)

    @property
    def start(self) -> tuple[float, ...]:
        """Values that the parameters have in the files."""
        return (*self.rotor_parameters.start, *(self.loop_parameters.start if self.loop_parameters else ()))

    def rotor_with(self, values: Array | Sequence[float]) -> Rotor:
        """Return the rotor with other values of its parameters."""
        return self.rotor_parameters.rotor_with(self._split(values)[0])

    def structure_with(self, values: Array | Sequence[float]) -> Structure:
        """Return the rotor and its support with other values of the parameters; recent reduced rotors are reused."""
        of_rotor, of_loop = self._split(values)
        structure = self._rotors(of_rotor)
        if self.loop_parameters is None:
            return structure
        return structure.with_machine(self.loop_parameters.machine_with(of_loop, structure.rotor))

    def _structure(self, of_rotor: tuple[float, ...]) -> Structure:
        rotor = refined(self.rotor_parameters.rotor_with(of_rotor), self.places)
        return Structure(rotor, self.loop, self.Omega)

    def _split(self, values: Array | Sequence[float]) -> tuple[tuple[float, ...], tuple[float, ...]]:
        numbers, count = tuple(float(value) for value in values), len(self.rotor_parameters.names)
        return numbers[:count], numbers[count:]

    def warnings(self, values: Array | Sequence[float]) -> tuple[str, ...]:
        """Return warnings about the unfitted machine or rotor, and a note if the values make the loop unstable."""
        if self.loop_parameters is None:
            return tuple(implausible_sizes(self.rotor_with(self.start)))
        result = self.loop_parameters.machine.prepared.warnings
        try:
            if self.loop == "closed":
                machine_of(self._prepared(values, self._pinned(values))).loop.check_stable([self.Omega])
        except ValueError as error:
            return (*result, f"the measured loop must have been stable, but with the fitted values {error}")
        return result

    def files_with(self, values: Array | Sequence[float]) -> dict[str, str]:
        """Return the text of each file with the fitted values, by name: the rotor file, and a scenario file."""
        files, (of_rotor, _) = {}, self._split(values)
        if of_rotor or self.loop_parameters is None:
            files[ROTOR_FILE] = tomli_w.dumps(self.rotor_parameters.data_with(of_rotor))  # type: ignore[arg-type]
        if self.loop_parameters is not None:
            files[SCENARIO_FILE] = tomli_w.dumps(self._scenario_data(values, ROTOR_FILE in files))
        return files

    def _scenario_data(self, values: Array | Sequence[float], has_rotor: bool) -> dict[str, Any]:
        """Return the content of a scenario with the fitted values; all other values are those that the fit used."""
        assert self.loop_parameters is not None
        prepared = self.loop_parameters.machine.prepared
        system, data = prepared.assembly.system, {**self.stated, **({"rotor": ROTOR_FILE} if has_rotor else {})}
        parameters: dict[str, dict[str, Raw]] = {}
        for name, raw in self.settings.items():
            component, variable = system.divide(name)
            ports = prepared.interfaces[component].matching(variable) if variable else ()
            if not variable:
                data[name] = raw
            elif ports and ports[0].causality == "input":
                data.setdefault("inputs", {}).setdefault(component, {})[variable] = raw
            else:
                parameters.setdefault(component, {})[variable] = raw
        for table in (self.loop_parameters.values(self._split(values)[1]), self._pinned(values)):
            for component, found in table.items():
                parameters.setdefault(component, {}).update(found)
        return {**data, "parameters": parameters}

    def _pinned(self, values: Array | Sequence[float]) -> dict[str, dict[str, float]]:
        """Return the parameters whose values in the fit differ from the values that a plan would derive."""
        assert self.loop_parameters is not None
        machine = self.loop_parameters.machine_with(self._split(values)[1], self.rotor_with(values))
        prepared = machine_of(self._prepared(values, {}))
        return differences(machine.parameters, prepared.parameters)

    def _prepared(self, values: Array | Sequence[float], pinned: Mapping[str, Mapping[str, float]]) -> ScenarioPlan:
        assert self.loop_parameters is not None
        scenario = self.loop_parameters.machine.prepared.scenario
        tables = (self.loop_parameters.values(self._split(values)[1]), pinned)
        settings = {f"{c}.{n}": value for table in tables for c, found in table.items() for n, value in found.items()}
        if self.rotor_parameters.names:
            scenario = scenario.machine(rotor=self.rotor_with(values))
        return prepare_run(scenario, {**self.settings, **settings}, options=RunOptions(flavour=self.flavour))


def _path(source: str | Path) -> str:
    """Return a path that does not depend on the working folder; names of packaged files remain unchanged."""
    return str(Path(source).resolve()) if Path(source).is_file() else str(source)
