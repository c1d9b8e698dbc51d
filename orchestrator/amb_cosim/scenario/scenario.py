"""Scenarios of a levitated rotor (machine, speed and events), read from TOML and checked."""

from __future__ import annotations

import math
from collections.abc import Mapping
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import tomli_w
from pydantic import AfterValidator, Field, ValidationError

from amb_cosim.cosim.choices import Coupling, Role, Settling
from amb_cosim.cosim.fmu.fmus import FmuSource, as_fmu
from amb_cosim.cosim.system.system_file import load_system
from amb_cosim.cosim.system.system_tables import Record
from amb_cosim.cosim.system.tables import ByComponent, Table, Value, time_of
from amb_cosim.cosim.system.values import Raw, quantity, stated
from amb_cosim.presentation.units import speed_unit
from amb_cosim.scenario.coupling import DEFAULT_STEPS
from amb_cosim.scenario.file import (
    SPEEDS,
    check_exists,
    overlaid,
    packaged_scenarios,
    read_scenario,
    relative_to,
    with_paths,
)
from amb_cosim.scenario.rotors import (
    FmuField,
    RotorField,
    RotorSource,
    TableField,
    TableSource,
    is_controller,
    is_rotor,
    is_table,
    named,
)
from amb_cosim.scenario.scenario_tables import Event, InputProfile, Plot, SpeedPoint, Stop
from amb_files.atomic import write_file
from amb_files.checks import errors_in, require, require_kind
from amb_files.frozen_table import FrozenTable
from amb_files.pack_file import default
from amb_files.speed_units import require_speed_unit, with_speed_units
from amb_files.validation_errors import sentences

_MACHINE = (  # fields that define the machine and its parameters
    *("system", "rotor", "gradient", "fmu", "parameters", "Omega", "gravity", "gravity_angle", "tilt"),
    "communication_step",
)

SPEED = "Omega"  # the shared signal whose initial value defines the cycles
UNBALANCE = "kg.m"  # unit of inputs that are unbalances
AT_STANDSTILL = 0.01  # s, a cycle of a rotor that does not turn at first
FORMER_LABELS = {"step": "disturbance", "removal": "relief"}  # labels that implied a role before roles existed


class Scenario(Table):
    """A run of the levitated rotor.

    Cycles are periods of rotation at the initial speed, counted from the end of settling. A cycle of a rotor that is
    initially at rest lasts 10 ms.

    Keys of `inputs`, `parameters` and `fmu` are component names. In the names of parameters and inputs, `*` matches any
    characters and `?` matches any single character.

    Examples
    --------
    >>> scenario = Scenario.load("compressor_levitated").changed(Omega="6000 rpm", end_cycle=4)
    >>> scenario.Omega, scenario.end_cycle
    ('6000 rpm', 4.0)
    """

    name: str = "scenario"
    """Name, from the file name."""
    description: str = ""
    """One-line description."""
    source: str = ""
    """Source."""
    theme: str = ""
    """Heading in lists."""
    system: str = "levitated"
    """Components and their connections: the name of a packaged system, or of a system file."""
    rotor: RotorField | None = None
    """Rotor of the models: the name of a packaged rotor, a rotor file, or in Python a `Rotor`; if omitted, the
    default rotor of the packs.
    """
    receptances: TableField | None = None
    """Table of receptances for the controller, instead of those of the rotor model: a file, or in Python a
    `ReceptanceTable`.
    """
    gradient: bool = True
    """Whether the force gradient makes the magnetic force follow the rotor within a communication step."""
    coupling: Coupling | None = None
    """Order in which the components step; default: the system's order."""
    communication_step: Value | None = None
    """Time step after which the components exchange values. The default is 250 us, or 25 us in Jacobi order. In
    Jacobi order, a controller with the parameter `prediction_time` predicts two steps ahead unless
    `prediction_time` is set.
    """
    Omega: Value
    """Speed until cycle 0, and after it unless `speed` has points. In a file, the value has a unit; in Python, a number
    is in rad/s.
    """
    gravity: Value | None = None
    """Gravitational acceleration. The static currents of magnetic bearings carry the weight, and the rotor
    levitates at its setpoint; parameters set in the scenario keep their values. Without the key, static currents keep
    their values.
    """
    gravity_angle: Value = "225 deg"
    """Direction of gravity, from x towards y."""
    tilt: Value = 0.0
    """Angle of the shaft above the horizontal, positive if the end with the largest z is up; 90 deg is a vertical
    machine. Gravity acts across the shaft with the cosine of this angle, and along the shaft with its sine. A rotor
    with `[thrust_disc]` in its file moves along the shaft.
    """
    settle_cycles: float = Field(default=40.0, ge=0.0, le=1e9)
    """Revolutions before cycle 0 in which the motion settles. Regardless of the communication step, the rotor angle
    at cycle 0 is `initial.angle` of the rotor plus these revolutions."""
    settling: Settling = "simulated"
    """How the motion before cycle 0 is found: `simulated` over `settle_cycles`; `solved` as a steady motion, followed
    by a simulated revolution that ends at the same rotor angle; or `automatic`, which solves if possible. Solving is
    not possible with noise, converters, adaptive control, identification or contact before cycle 0, with an unstable
    loop or nonlinear forces, or if housings or races move or the speed changes.
    """
    end_cycle: float | None = Field(default=None, gt=0.0, le=1e9)
    """End of the run in cycles; set this or `end_time`. Either one replaces the end that the base states. A `stop` may
    end the run earlier."""
    end_time: Value | None = None
    """End of the run in seconds."""
    unbalance_factor: float = Field(default=1.0, gt=0.0, le=1e9)
    """Factor for every unbalance (input in kg.m) that the scenario sets."""
    inputs: ByComponent = Field(default=FrozenTable())
    """Initial values of inputs, by component."""
    parameters: ByComponent = Field(default=FrozenTable())
    """Parameters, by component."""
    event: tuple[Event, ...] = ()
    """Changes during the run."""
    speed: tuple[SpeedPoint, ...] = ()
    """Points of the speed after cycle 0; the speed is linear between them and constant after the last."""
    profile: tuple[InputProfile, ...] = ()
    """Inputs that change linearly between points or come from a file; times count from cycle 0."""
    stop: tuple[Stop, ...] = ()
    """Conditions that end the run early."""
    record: Record = Record()
    """Recorded variables."""
    plot: Plot = Plot()
    """Figures."""
    fmu: Annotated[dict[str, FmuField], AfterValidator(FrozenTable)] = Field(default=FrozenTable())
    """FMUs or controller files that replace components; in Python also a `LinearController`."""

    if not TYPE_CHECKING:  # type checkers derive the arguments from the fields

        def __init__(self, **fields: Any) -> None:
            try:
                super().__init__(**fields)
            except ValidationError as error:
                raise ValueError("\n".join(sentences(error, Scenario, fields))) from error
            _check(self)

    @classmethod
    def load(cls, name: str | Path) -> Scenario:
        """Read a scenario by its name, or from a TOML file; see `load_scenario`."""
        return load_scenario(str(name))

    def changed(self, **fields: Any) -> Scenario:
        """Return the scenario with other values of fields; tables (`inputs`, ...) are merged, and all else is replaced.

        Raises
        ------
        ValueError
            If a field does not exist or a value is not allowed.
        """
        return make_scenario(overlaid(self._data(), fields), self.name)

    def machine(self, **fields: Any) -> Scenario:
        """Return a scenario with the same machine and parameters, but with other events and `fields`.

        The scenario lasts one second without settling, unless `fields` set something else.

        Raises
        ------
        ValueError
            If the scenario's inputs or events, which are left out, name a component that does not exist.
        """
        system = load_system(self.system, {"gradient": self.gradient})
        with errors_in(f"scenario {self.name}"):
            for inputs in (self.inputs, *(event.set for event in self.event)):
                for component, values in inputs.items():
                    for variable in values:
                        system.component(system.divide(f"{component}.{variable}")[0])
        fields_of_machine = {key: value for key, value in self._data().items() if key in _MACHINE}
        return make_scenario(overlaid(fields_of_machine | {"settle_cycles": 0, "end_time": 1.0}, fields), self.name)

    def save(self, path: str | Path) -> Path:
        """Write the scenario as a TOML file that `load` reads, with paths relative to the file; return its path.

        Raises
        ------
        ValueError
            If its rotor, table of receptances or a controller was made in Python, because a scenario file can only name
            them.
        """
        controllers = {f"fmu.{name}": fmu for name, fmu in self.fmu.items() if is_controller(fmu)}
        if made := self._made() | controllers:
            what = " and ".join(f"{kind} {named(value)!r}" for kind, value in made.items())
            raise ValueError(f"scenario {self.name} contains {what} made in Python; a scenario file must name files")
        data = with_paths(self._data(), relative_to(Path(path).parent))
        data |= with_speed_units({key: data[key] for key in SPEEDS if key in data}, ("Omega",))
        write_file(Path(path), tomli_w.dumps(data))
        return Path(path)

    def _repr_html_(self) -> str:
        from amb_cosim.presentation.text_tables import html_of

        data = self._data() | {kind: repr(named(value)) for kind, value in self._made().items()}
        if "fmu" in data:
            data["fmu"] = {name: str(fmu) for name, fmu in self.fmu.items()}
        return html_of([self.name, tomli_w.dumps(data)])

    def _data(self) -> dict[str, Any]:
        data = self.model_dump(mode="json", exclude_unset=True, exclude_none=True, exclude={"name"})
        return data | self._made() | ({"fmu": dict(self.fmu)} if "fmu" in data else {})

    def _made(self) -> dict[str, Any]:
        """Return the fields that hold an object made in Python."""
        fields = {"rotor": self.rotor, "receptances": self.receptances}
        return {name: value for name, value in fields.items() if is_rotor(value) or is_table(value)}

    @property
    def initial_speed(self) -> float:
        """Speed before and at the beginning of cycle 0 in rad/s."""
        return checked_speed(quantity(self.Omega, "rad/s", "Omega"), self.Omega)

    @property
    def period(self) -> float:
        """Duration of a cycle in s."""
        return cycle_period(self.initial_speed)

    def step_size(self, coupling: Coupling) -> float:
        """Return the communication step (s) for a coupling."""
        if self.communication_step is None:
            return DEFAULT_STEPS[coupling]
        return time_of(self.communication_step, "communication_step")

    def end(self, period: float) -> float:
        """Return the end of the run (s) for cycles of `period` (s)."""
        if self.end_cycle is not None and self.end_time is not None:
            raise ValueError(f"end_cycle = {self.end_cycle:g} and end_time = {self.end_time!r} exclude each other")
        if self.end_cycle is None and self.end_time is None:
            raise ValueError("a scenario needs an end: end_cycle or end_time")
        return time_of(self.end_time or 0.0, "end_time") if self.end_cycle is None else self.end_cycle * period

    @property
    def labels(self) -> tuple[str, ...]:
        """Labels of events, in the order in which they happen."""
        period = self.period
        events = sorted(self.event, key=lambda event: event.moment(period))
        return tuple(event.name for event in events if event.name)

    @property
    def named_changes(self) -> tuple[Event | InputProfile, ...]:
        """Events and profiles with a label or a role."""
        events: tuple[Event | InputProfile, ...] = tuple(event for event in self.event if event.name)
        return (*events, *(profile for profile in self.profile if profile.name))

    def by_role(self, role: Role) -> Event | InputProfile | None:
        """Return the event or profile with this role, if there is one."""
        return next((change for change in self.named_changes if change.role == role), None)


def checked_speed(speed: float, written: Raw = 0.0) -> float:
    """Return the speed (rad/s) after checking that a rotor can turn at this speed.

    Raises
    ------
    ValueError
        If the speed is negative or not finite, or is `written` as a text without a unit; the message quotes it as
        `written`.
    """
    require_speed_unit(written)
    shown = stated(speed_unit().text(speed), written)
    require(0.0 <= speed < math.inf, "Omega", shown, f">= {speed_unit().text(0.0)}, because cycles count revolutions")
    return speed


def tilt_of(written: Raw) -> float:
    """Return the angle of a shaft above the horizontal (rad).

    Raises
    ------
    ValueError
        If the shaft is tilted beyond the vertical.
    """
    value = quantity(written, "rad", "tilt")
    if not abs(value) <= 0.5 * math.pi * (1.0 + 1e-9):
        raise ValueError(f"tilt = {math.degrees(value):g} deg is not allowed; it must be >= -90 deg and <= 90 deg")
    return value


def share_across(tilt: float) -> float:
    """Return the share of gravity across a shaft of this tilt (rad): its cosine, or exactly 0 for an upright shaft."""
    return 0.0 if math.isclose(abs(tilt), 0.5 * math.pi, rel_tol=1e-9) else math.cos(tilt)


def cycle_period(speed: float) -> float:
    """Return the duration of a cycle (s) at an initial speed (rad/s): a turn or, at rest, `AT_STANDSTILL`."""
    return 2.0 * math.pi / speed if checked_speed(speed) else AT_STANDSTILL


def scenarios() -> dict[str, str]:
    """Return the names and descriptions of the packs' scenarios.

    Examples
    --------
    >>> scenarios()["compressor_levitated"]
    'A compressor in magnetic bearings under PID withstands a step of unbalance without contact'
    """
    return {name: load_scenario(name).description for name in packaged_scenarios()}


def load_scenario(name: str | None = None) -> Scenario:
    """Read the scenario called `name`, or the TOML file at that path; without a name, the default of the packs.

    A file with a `base` (the name or path of another file) contains only the differences from it; see `file`.

    Raises
    ------
    ValueError
        If it does not exist or is invalid; the message has one line for each mistake.
    """
    name = default("scenario") if name is None else name
    return make_scenario(read_scenario(name), name)


def as_scenario(
    source: str | Path | Scenario | None,
    rotor: RotorSource = None,
    receptances: TableSource = None,
    fmu: Mapping[str, FmuSource | PathLike[str]] | None = None,
) -> Scenario:
    """Return a scenario (see `load_scenario`) with another rotor, table and FMUs.

    Raises
    ------
    ValueError
        As `load_scenario` does.
    """
    scenario = source if isinstance(source, Scenario) else load_scenario(None if source is None else str(source))
    if fmu is not None:
        require_kind("fmu", fmu, Mapping, "a table of FMUs by the name of a component")
    others = {"rotor": rotor, "receptances": receptances}
    changes = {key: str(new) if isinstance(new, Path) else new for key, new in others.items() if new is not None}
    scenario = scenario.model_copy(update=changes)
    return scenario.changed(fmu={component: as_fmu(new) for component, new in fmu.items()}) if fmu else scenario


def make_scenario(data: dict[str, Any], name: str) -> Scenario:
    """Return a scenario from the content of its TOML file. Raises ValueError as `load_scenario` does."""
    try:
        return Scenario(**{"name": Path(name).stem} | data)
    except ValueError as error:
        raise ValueError("\n".join(f"scenario {name}: {line}" for line in str(error).splitlines())) from error


def _check(scenario: Scenario) -> None:
    """Raise ValueError if a scenario names a file that does not exist, or if its fields contradict each other.

    FMUs may be built later; a run looks for them.
    """
    files = {"system": scenario.system, "rotor": scenario.rotor, "receptances": scenario.receptances}
    for key, value in files.items():
        check_exists(key, value)
    period = scenario.period
    _check_events(scenario, period)
    _check_speeds(scenario, period)
    for stop in scenario.stop:
        stop.condition(period)
    if tilt_of(scenario.tilt) and scenario.gravity is None:
        raise ValueError(f"tilt = {scenario.tilt} requires gravity, because tilt only sets its direction")
    _ = scenario.step_size("gauss_seidel"), scenario.end(period)  # both raise for wrong values


def _check_events(scenario: Scenario, period: float) -> None:
    for event in scenario.event:
        if not 0.0 <= event.moment(period) < math.inf:
            raise ValueError(f"event at {event.moment(period):g} s is not allowed; it must be at >= 0 s")
        if event.label in FORMER_LABELS and event.role is None:
            raise ValueError(f"the event labelled {event.label} needs role = '{FORMER_LABELS[event.label]}'")
    names = [change.name for change in scenario.named_changes]
    roles = [change.role for change in scenario.named_changes if change.role]
    for what, values in (("label", names), ("role", roles)):
        if len(set(values)) < len(values):
            raise ValueError(f"two events have the same {what}")
    disturbance, relief = scenario.by_role("disturbance"), scenario.by_role("relief")
    if disturbance and relief and relief.moment(period) <= disturbance.moment(period):
        raise ValueError("the event with the role relief must come after the disturbance")


def _check_speeds(scenario: Scenario, period: float) -> None:
    before = 0.0
    for point in scenario.speed:
        moment = point.moment(period)
        if not before < moment < math.inf:
            what = (
                f"at > {before:g} s, after the previous point"
                if before
                else "at > 0 s, because Omega is the speed at 0 s"
            )
            raise ValueError(f"speed point at {moment:g} s is not allowed; it must be {what}")
        checked_speed(quantity(point.Omega, "rad/s", "Omega"), point.Omega)
        before = moment
