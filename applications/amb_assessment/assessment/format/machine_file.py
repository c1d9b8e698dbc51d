"""Format and reader of machine files, which describe the parts, speeds and loads of a machine.

A machine file refers to a rotor file, which contains bearings, retainers, sensors and seals, and to a controller file.
It sets parameters of components as a scenario does. Alternatively, it names a scenario that defines the machine.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from amb_analysis.studies.inputs import positive
from amb_assessment.assessment.format.retainer_bearings import RetainerBearing
from amb_assessment.assessment.format.thrust_bearing import ThrustBearing
from amb_cosim.cosim.system.tables import Table, Value, Values
from amb_cosim.cosim.system.values import RPM, quantity, stated
from amb_cosim.presentation.units import frequency_unit, speed_unit
from amb_cosim.results.component_names import ACTUATOR, CONTROLLER
from amb_cosim.scenario.file import overlaid, read_scenario, with_paths
from amb_cosim.scenario.scenario import Scenario, make_scenario, tilt_of
from amb_files.checks import errors_in, require
from amb_files.packs import files_of
from amb_files.speed_units import require_speed_unit, require_speed_units
from amb_files.suggestions import suggest
from amb_files.toml import read_toml, validate
from rolac_controller.signals import LARGEST_SPEED
from rotor_analysis.parts import AtSpeed, Bearing
from rotor_analysis.rotor_file import load_rotor

GRADE = re.compile(r"G ?(\d+(?:\.\d+)?)")  # form of ISO 21940-11, in mm/s

OF_MACHINE = ("system", "rotor", "gravity", "gravity_angle", "tilt", "communication_step", "fmu", "parameters")
OF_SCENARIO = (*OF_MACHINE, "gradient", "inputs")  # fields of a scenario that define its machine


WITH_SPEEDS = ("speed", "up_to", "stages", "thrust_bearing")  # keys of a machine with speeds and frequencies
SPEED_KEYS = ("minimum", "maximum", "trip", "up_to", "speed", "corner", "bandwidth")


class Speeds(Table):
    """Speeds of the machine: smallest and largest operating speed, and trip speed (default: 1.05 times the largest).

    `run_up` and `run_down` are the times between standstill and the largest speed, at constant acceleration.
    """

    minimum: Value
    maximum: Value
    trip: Value | None = None
    run_up: Value | None = None
    run_down: Value | None = None

    @model_validator(mode="after")
    def _ascend(self) -> Speeds:
        for name, raw in {"minimum": self.minimum, "maximum": self.maximum, "trip": self.trip}.items():
            require_speed_unit(raw, f"speed.{name}")
        trip = f"1.05 x {self.maximum}" if self.trip is None else self.trip
        written = {"minimum": self.minimum, "maximum": self.maximum, "trip": trip}
        before, reason = 0.0, ""
        for (name, raw), value in zip(written.items(), (self.lowest, self.highest, self.tripping), strict=True):
            shown = stated(speed_unit().text(value), raw)
            allowed = f">= {speed_unit().text(before)}, the {reason}" if reason else f"> {speed_unit().text(0.0)}"
            require(value >= before if reason else value > 0.0, f"speed.{name}", shown, allowed)
            most = f"<= {speed_unit().text(LARGEST_SPEED)}, the limit of the models"
            require(value <= LARGEST_SPEED, f"speed.{name}", shown, most)
            before, reason = value, name
        _ = self.run_up_time, self.run_down_time
        return self

    @property
    def lowest(self) -> float:
        """Lowest operating speed (rad/s)."""
        return quantity(self.minimum, "rad/s", "speed.minimum")

    @property
    def highest(self) -> float:
        """Highest operating speed (rad/s)."""
        return quantity(self.maximum, "rad/s", "speed.maximum")

    @property
    def tripping(self) -> float:
        """Trip speed (rad/s)."""
        return 1.05 * self.highest if self.trip is None else quantity(self.trip, "rad/s", "speed.trip")

    @property
    def run_up_time(self) -> float | None:
        """Time from standstill to the largest speed (s), if stated."""
        return None if self.run_up is None else positive(self.run_up, "s", "speed.run_up")

    @property
    def run_down_time(self) -> float | None:
        """Time from the largest speed to standstill (s), if stated."""
        return None if self.run_down is None else positive(self.run_down, "s", "speed.run_down")


class Balancing(Table):
    """Balancing grade, which is e Omega at the largest speed (ISO 21940-11); the default is 2.5 mm/s, or "G 2.5"."""

    grade: Value = "2.5 mm/s"

    @property
    def speed(self) -> float:
        """Product of eccentricity and speed (m/s)."""
        letter = isinstance(self.grade, str) and GRADE.fullmatch(self.grade.strip())
        if not letter and str(self.grade).strip().upper().startswith("G"):
            raise ValueError(f"balancing.grade = {self.grade!r} is not allowed; it must be a grade such as 'G 2.5'")
        value = quantity(f"{letter[1]} mm/s" if letter else self.grade, "m/s", "balancing.grade")
        if not 0.0 < value < 1.0:
            raise ValueError(
                f"balancing.grade = {value:g} m/s is not allowed; it must be > 0 m/s and < 1 m/s, such as 'G 2.5'"
            )
        return value


class CompressorStage(Table):
    """A stage that drives whirl; it acts at the rotor part `at`, and is described by its data or by its coupling.

    kind, power, diameter, width, density_ratio
        Kind (centrifugal or axial); power; diameter of the impeller, or pitch diameter of the blades; smallest width of
        the diffuser or impeller, or height of the blades; discharge density over suction density (only for a
        centrifugal stage).
    cross_coupling
        Anticipated cross-coupled stiffness, which replaces the data above.
    real
        Result of a more accurate calculation, which is used for level II. It is either a cross-coupled stiffness, or a
        table of stiffness, damping and mass over speed, as for a seal in a rotor file. By default, the anticipated
        coupling is used.
    """

    at: str
    kind: Literal["centrifugal", "axial"] = "centrifugal"
    power: Value | None = None
    diameter: Value | None = None
    width: Value | None = None
    density_ratio: Annotated[float, Field(gt=0.0)] = 1.0
    cross_coupling: Value | None = None
    real: Value | tuple[AtSpeed, ...] | None = None

    @model_validator(mode="after")
    def _is_complete(self) -> CompressorStage:
        values = [name for name in ("power", "diameter", "width") if getattr(self, name) is not None]
        if (self.cross_coupling is None) != (len(values) == 3):
            raise ValueError(f"stage at {self.at} needs either cross_coupling, or power, diameter and width")
        _ = self.anticipated(1.0), self.coefficients() or self.level_two(1.0)
        return self

    def anticipated(self, Omega: float) -> float:
        """Return the anticipated cross-coupled stiffness (N/m) at a speed (rad/s).

        For a centrifugal stage, Q_a = P B C (rho_d/rho_s)/(D H N) with B = 3 and C = 9.55, for P in W, D and H in m,
        and N in 1/min. For an axial stage, B is 1.5 and the densities are omitted. The formula is from API 617, as
        cited in ROSS's report of 2020.
        """
        if self.cross_coupling is not None:
            name = f"cross_coupling of stage at {self.at}"
            Q = quantity(self.cross_coupling, "N/m", name)
            require(
                Q >= 0.0,
                name,
                stated(f"{Q:g} N/m", self.cross_coupling),
                ">= 0 N/m (positive values drive forward whirl)",
            )
            return Q
        P, D, H = (
            positive(getattr(self, name) or 0.0, unit, f"{name} of stage at {self.at}")
            for name, unit in (("power", "W"), ("diameter", "m"), ("width", "m"))
        )
        B = 3.0 * self.density_ratio if self.kind == "centrifugal" else 1.5
        return P * B * 9.55 / (D * H * Omega * RPM)

    def level_two(self, Omega: float) -> float:
        """Return the cross-coupled stiffness (N/m) for level II, which is (K_xy - K_yx)/2 for given `coefficients`."""
        result = self.coefficients()
        if result is not None:
            K = result.at(Omega)[0]
            return float(0.5 * (K[0, 1] - K[1, 0]))
        if self.real is None or isinstance(self.real, tuple):
            return self.anticipated(Omega)
        return quantity(self.real, "N/m", f"real of stage at {self.at}")

    def coefficients(self) -> Bearing | None:
        """Return the level II coefficients as functions of speed, or None if the file does not state them."""
        if not isinstance(self.real, tuple) or not self.real:
            return None
        if len(self.real) == 1:
            (only,) = self.real
            return Bearing("stage", 1, only.stiffness, only.damping, mass=only.mass)
        return Bearing("stage", 1, at_speed=self.real)


class Tolerances(Table):
    """Tolerances of constants, as fractions of their nominal values."""

    k_i: Annotated[float, Field(ge=0.0, lt=1.0)] = 0.1
    k_s: Annotated[float, Field(ge=0.0, lt=1.0)] = 0.15
    gap: Annotated[float, Field(ge=0.0, lt=1.0)] = 0.05
    modes: Annotated[float, Field(ge=0.0, lt=1.0)] = 0.02


class MachineFile(Table):
    """A machine: parts, speeds and loads.

    name, description, source
        Name, one-line description, and source of the data.
    scenario
        Name or file of a scenario that defines the machine. Fields of the machine file replace those of the scenario.
    rotor, controller
        Rotor file, and controller: a file with blocks or arrays, or an FMU. The default controller is the PID of
        `rolac_controller`.
    system, gravity, gravity_angle, tilt, communication_step, fmu, parameters
        As in a scenario. `parameters.amb_actuator` describes magnets and amplifiers, and `parameters.rotor_contact`
        describes retainers.
    speed, balancing, stages
        Operating speeds, balancing grade, and stages that drive whirl.
    retainer_bearings
        Ball bearings of the retainers, which are needed to compute the loads on their balls during a landing.
    thrust_bearing
        Axial magnetic bearing.
    up_to
        Frequency up to which the damping of modes is judged; by default twice the trip speed.
    tolerances
        Tolerances of constants, within which the worst margins are found.
    criteria
        Files of criteria; by default those of the package.
    """

    name: str = "machine"
    description: str = ""
    source: str = ""
    scenario: str = ""
    rotor: str | None = None
    controller: str | None = None
    system: str | None = None
    gravity: Value | None = None
    gravity_angle: Value | None = None
    communication_step: Value | None = None
    fmu: dict[str, str] = Field(default={})
    parameters: dict[str, Values] = Field(default={})
    speed: Speeds
    balancing: Balancing = Balancing()
    stages: tuple[CompressorStage, ...] = ()
    retainer_bearings: tuple[RetainerBearing, ...] = ()
    tilt: Value | None = None
    thrust_bearing: ThrustBearing | None = None
    up_to: Value | None = None
    tolerances: Tolerances = Tolerances()
    criteria: tuple[str, ...] = ()

    @model_validator(mode="after")
    def _has_a_rotor(self) -> MachineFile:
        if not self.scenario and self.rotor is None:
            raise ValueError("a machine needs either rotor or scenario")
        _ = self.highest_frequency, self.balancing.speed, self.shaft_tilt
        for name, value, unit in (("gravity", self.gravity, "m/s2"), ("gravity_angle", self.gravity_angle, "rad")):
            if value is not None:
                quantity(value, unit, name)
        return self

    @property
    def highest_frequency(self) -> float:
        """Frequency up to which modes are judged (rad/s)."""
        if self.up_to is None:
            return 2.0 * self.speed.tripping
        value, least = positive(self.up_to, "rad/s", "up_to"), self.speed.tripping
        unit = frequency_unit()
        require(value >= least, "up_to", stated(unit.text(value), self.up_to), f">= {unit.text(least)}, the trip speed")
        return value

    @property
    def shaft_tilt(self) -> float:
        """Angle of the shaft above the horizontal (rad)."""
        return tilt_of(self._scenario_data().get("tilt", 0.0))

    @property
    def axial_gravity(self) -> float:
        """Component of gravity along z (m/s^2), which is -g sin(tilt)."""
        raw = self._scenario_data().get("gravity")
        return 0.0 if raw is None else 0.0 - quantity(raw, "m/s2", "gravity") * math.sin(self.shaft_tilt)

    @property
    def has_synchronous_control(self) -> bool:
        """Whether the machine's scenario starts with synchronous control (ROLAC), which an assessment switches off."""
        return bool(self._scenario_data().get("inputs", {}).get(CONTROLLER, {}).get("rolac_enable"))

    def as_scenario(self, Omega: float, **fields: Any) -> Scenario:
        """Return a scenario at a speed (rad/s); by default, it lasts one second and has no settling time."""
        data = self._scenario_data()
        if self.controller is not None:
            data = overlaid(data, {"fmu": {CONTROLLER: self.controller}})
        data = overlaid(data, {"inputs": {CONTROLLER: {"rolac_enable": False}}})
        data = overlaid(data, {"Omega": Omega, "settle_cycles": 0} | fields)
        data = overlaid({"parameters": {ACTUATOR: self._iron}}, data)
        return make_scenario(data if {"end_time", "end_cycle"} & {*data} else data | {"end_time": 1.0}, self.name)

    @cached_property
    def _iron(self) -> dict[str, Value]:
        """Parameter of the actuator for eddy currents in the thrust bearing; empty unless the rotor moves along z."""
        bearing, rotor = self.thrust_bearing, self._scenario_data().get("rotor")
        corner = None if bearing is None else bearing.corner
        thrust = "" if corner is None or rotor is None else load_rotor(rotor).thrust
        return {f"{thrust}.eddy_current_corner": f"{corner!r} rad/s"} if thrust and corner else {}

    def _scenario_data(self) -> dict[str, Any]:
        """Return the data of the scenario, in which values of the machine file replace those of the scenario."""
        base = read_scenario(self.scenario) if self.scenario else {}
        data = {key: base[key] for key in OF_SCENARIO if key in base}
        of_file = self.model_dump(mode="json", exclude_unset=True, exclude_none=True, include={*OF_MACHINE})
        return overlaid(_without_plant_inputs(data), of_file)


def _without_plant_inputs(data: dict[str, Any]) -> dict[str, Any]:
    """Return a scenario's data without the inputs of its rotor."""
    from amb_cosim.results.component_names import PLANT

    inputs = {component: values for component, values in data.get("inputs", {}).items() if component != PLANT}
    return {key: value for key, value in data.items() if key != "inputs"} | ({"inputs": inputs} if inputs else {})


def packaged_machines() -> Mapping[str, Path]:
    """Return the machine files of the packs, by name."""
    return files_of("machines")


def load_machine(source: str | Path) -> MachineFile:
    """Read a machine from a file or by the name of a packaged machine. Paths in a file are relative to that file.

    Raises
    ------
    ValueError
        If the machine does not exist or is invalid; the message has a line for each mistake.
    """
    packaged = packaged_machines()
    path = packaged.get(str(source), Path(source))
    if not path.exists():
        kind = "file" if str(source).endswith(".toml") else "machine"
        raise ValueError(f"no {kind} {str(source)!r}; {suggest(str(source), packaged)}")
    name = f"machine file {path}"
    read = read_toml(path, name)
    with errors_in(name):
        require_speed_units({key: read.get(key) for key in WITH_SPEEDS}, SPEED_KEYS)
    data, scenarios = with_paths(read, lambda file: str(path.parent / file), path), files_of("scenarios")
    if isinstance(scenario := data.get("scenario"), str):
        beside = scenarios.in_pack_of(path, scenario)
        data["scenario"] = str(beside or path.parent / scenario) if beside or scenario not in scenarios else scenario
    if isinstance(data.get("controller"), str):
        data["controller"] = str(path.parent / data["controller"])
    axial = data.get("thrust_bearing")
    if isinstance(axial, dict) and isinstance(axial.get("controller"), str):
        data["thrust_bearing"] = axial | {"controller": str(path.parent / axial["controller"])}
    if isinstance(data.get("criteria"), list):
        from amb_assessment.assessment.format.criteria import packaged_criteria

        with_names = packaged_criteria()
        data["criteria"] = [item if item in with_names else str(path.parent / str(item)) for item in data["criteria"]]
    return validate({"name": path.stem} | data, MachineFile, name)
