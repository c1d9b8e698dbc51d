"""Scenarios of a levitated rotor: what is run, at which speed, and what happens when; read from TOML and checked."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

import tomli_w
from pydantic import Field, StringConstraints

from amb_cosim.cosim.basics.choices import Coupling, Role, Settling
from amb_cosim.cosim.system.stopping import StopCondition
from amb_cosim.cosim.system.system_tables import Record, stop_condition
from amb_cosim.cosim.system.tables import Cycles, Table, Value, Values, time_of
from amb_cosim.cosim.system.values import quantity
from amb_cosim.scenario.coupling import DEFAULT_STEPS
from amb_cosim.scenario.file import overlaid, packaged_scenarios, read_scenario, relative_to, with_paths
from amb_files.atomic import write_atomically
from amb_files.pack_file import default
from amb_files.toml import parse_toml, validate

_MACHINE = (  # fields that say what runs, and how it is set
    *("system", "rotor", "gradient", "fmu", "parameters", "Omega", "gravity", "gravity_angle", "communication_step"),
)

Label = Annotated[str, StringConstraints(pattern=r"^[a-z][a-z0-9_]*$", max_length=40)]
FORMER_LABELS = {"step": "disturbance", "removal": "relief"}  # that stood for a role before there were roles

FigureName = Literal["orbits", "displacement", "contact", "whirl", "magnets", "energy", "touchdown"]


class _Moment(Table):
    """Something that happens at a cycle or at a time."""

    noun: ClassVar[str]

    cycle: Cycles | None = None
    """When, in turns at the initial speed from the end of settling."""
    time: Value | None = None
    """When, in seconds from the end of settling."""

    def moment(self, period: float) -> float:
        """When it happens in s, for cycles of `period` s."""
        if (self.cycle is None) == (self.time is None):
            raise ValueError(f"{self.noun} needs either cycle or time")
        if self.cycle is not None:
            return self.cycle * period
        return quantity(self.time or 0.0, "s", f"time of {self.noun}")


class Event(_Moment):
    """From a moment on, inputs and tunable parameters have new values."""

    noun = "an event"

    label: Label | None = None
    """Names the event in figures and sweeps, such as `power_loss`; by default its role. No two have the same."""
    role: Role | None = None
    """What it is to the run: the `disturbance` that the rotor is judged after, or the `relief` that takes it back."""
    set: dict[str, Values]
    """New values, by component and variable."""

    @property
    def name(self) -> str:
        """Its label or, without one, its role; empty without both."""
        return self.label or self.role or ""


class SpeedPoint(_Moment):
    """A speed that is reached at a moment; it changes linearly from the point before."""

    noun = "a speed point"

    Omega: Value
    """The speed that is reached."""


class Stop(Table):
    """The run ends at the first point at which a signal has been above, or below, a value for long enough."""

    variable: str
    """An output, or an input that the scenario sets, by its name in the data set."""
    above: Value | None = None
    """The signal counts while it is above; either this or `below`."""
    below: Value | None = None
    """The signal counts while it is below."""
    hold_cycles: Cycles | None = None
    """How long without a break, in turns; a single point is enough without."""
    hold_time: Value | None = None
    """The same in seconds."""
    from_cycle: Cycles | None = None
    """From when on it is judged; from cycle 0 without."""
    from_time: Value | None = None
    """The same in seconds."""

    def condition(self, period: float) -> StopCondition:
        """The condition with its times in s, for cycles of `period` s."""
        hold = self._duration("hold", self.hold_cycles, self.hold_time, period)
        begin = self._duration("from", self.from_cycle, self.from_time, period)
        return stop_condition(self.variable, self.above, self.below, hold, begin)

    def _duration(self, what: str, cycles: float | None, time: Value | None, period: float) -> float:
        if cycles is not None and time is not None:
            names = [name for name in type(self).model_fields if name.startswith(what)]
            raise ValueError(f"stop on {self.variable} has both {' and '.join(names)}; it may have one")
        value = cycles * period if cycles is not None else quantity(time or 0.0, "s", f"{what}_time of stop")
        if not 0.0 <= value < math.inf:
            raise ValueError(f"{what}_time of stop = {value:g} s is not allowed; it must be >= 0 s")
        return value


class Plot(Table):
    """What is drawn."""

    cycles: tuple[Cycles, Cycles] | None = None
    """First and last cycle of the figures; what suits the run without."""
    figures: tuple[FigureName, ...] | None = None
    """Which figures; what suits the run without."""


class Scenario(Table):
    """A run of the levitated rotor. Cycles are periods of the initial speed, counted from the end of settling.

    Keys of `inputs`, `parameters` and `fmu` are component names; `*` and `?` in the names of parameters and inputs
    match any characters and any one character.
    """

    name: str = "scenario"
    """Name, that of the file."""
    description: str = ""
    """What happens, in one line."""
    source: str = ""
    """Where it is from."""
    theme: str = ""
    """Under which heading lists have it."""
    system: str = "levitated"
    """Components and their connections: the name of a packaged system, or of a system file."""
    rotor: str | None = None
    """Name of a rotor of a pack, or a rotor file, for which the models are built; by default the one that a pack says.
    """
    receptances: str | None = None
    """Table whose receptances the controller has in place of the rotor model's."""
    gradient: bool = True
    """Whether the actuator feels the rotor within a communication step, by the gradient of its force."""
    coupling: Coupling | None = None
    """Order in which the components step; that of the system by default."""
    communication_step: Value | None = None
    """Step after which values are exchanged: 250 us by default, in Jacobi order 25 us, where a controller with the
    parameter `prediction_time` predicts by two steps unless told otherwise."""
    Omega: Value
    """Speed before and at cycle 0, and for good without points of `speed`."""
    gravity: Value | None = None
    """Acceleration that pulls on the rotor. The static currents of magnetic bearings carry the weight, and the rotor
    levitates at its setpoint; parameters that the scenario gives keep their values."""
    gravity_angle: Value = "225 deg"
    """Where gravity pulls to, from x towards y."""
    settle_cycles: float = Field(default=40.0, ge=0.0, le=1e9)
    """Turns before cycle 0, in which the motion settles."""
    settling: Settling = "simulated"
    """Whether these turns are `simulated`, or the motion that they lead to is `solved` for, and one turn of it
    simulated, with the angle that the rotor has after them; `automatic` solves where it can. It cannot where noise,
    converters, adaptive control, identification or contact are on before cycle 0, where the loop is not stable,
    forces are not linear, or housings, races or the speed move."""
    end_cycle: float | None = Field(default=None, gt=0.0, le=1e9)
    """Where the run ends, in turns; either this or `end_time`. A `stop` may end it before."""
    end_time: Value | None = None
    """Where the run ends, in seconds."""
    unbalance_factor: float = Field(default=1.0, gt=0.0, le=1e9)
    """Multiplies every unbalance (input in kg.m) that the scenario sets."""
    inputs: dict[str, Values] = Field(default={})
    """Inputs at the start, by component."""
    parameters: dict[str, Values] = Field(default={})
    """Parameters, by component."""
    event: tuple[Event, ...] = ()
    """What changes, and when."""
    speed: tuple[SpeedPoint, ...] = ()
    """Points through which the speed passes after cycle 0, linear between them and constant after the last."""
    stop: tuple[Stop, ...] = ()
    """Conditions that end the run before its end."""
    record: Record = Record()
    """What is recorded."""
    plot: Plot = Plot()
    """What is drawn."""
    fmu: dict[str, str] = Field(default={})
    """FMUs or controller files in the place of components."""

    @classmethod
    def load(cls, name: str | Path) -> Scenario:
        """Read a scenario by its name, or from a TOML file; see `load_scenario`."""
        return load_scenario(str(name))

    def changed(self, **fields: Any) -> Scenario:
        """Return the scenario with other fields; tables (`inputs`, `parameters`, ...) are merged, the rest is replaced.

        Raises
        ------
        ValueError
            If a field does not exist or a value is not allowed.
        """
        return make_scenario(overlaid(self._data(), fields), self.name)

    def machine(self, **fields: Any) -> Scenario:
        """Return a scenario of the same machine and parameters, with `fields` in place of what happens in this one.

        It is a second without settling unless they say otherwise.
        """
        retained = {key: value for key, value in self._data().items() if key in _MACHINE}
        return make_scenario(overlaid(retained, {"settle_cycles": 0, "end_time": 1.0} | fields), self.name)

    def save(self, path: str | Path) -> Path:
        """Write the scenario as a TOML file that `load` reads, paths in it relative to the file; return its path."""
        text = tomli_w.dumps(with_paths(self._data(), relative_to(Path(path).parent)))
        write_atomically(Path(path), lambda file: file.write_text(text, encoding="utf-8"))
        return Path(path)

    def _data(self) -> dict[str, Any]:
        return self.model_dump(mode="json", exclude_unset=True, exclude_none=True, exclude={"name"})

    @property
    def initial_speed(self) -> float:
        """Speed before and at the beginning of cycle 0 in rad/s."""
        return positive_speed(quantity(self.Omega, "rad/s", "Omega"))

    @property
    def period(self) -> float:
        """Duration of a cycle in s."""
        return 2.0 * math.pi / self.initial_speed

    def step_size(self, coupling: Coupling) -> float:
        """Communication step in s, in this coupling."""
        if self.communication_step is None:
            return DEFAULT_STEPS[coupling]
        return time_of(self.communication_step, "communication_step")

    def end(self, period: float) -> float:
        """End of the run in s, for cycles of `period` s."""
        if (self.end_cycle is None) == (self.end_time is None):
            raise ValueError("a scenario needs either end_cycle or end_time")
        return time_of(self.end_cycle * period if self.end_cycle is not None else self.end_time or 0.0, "end_time")

    @property
    def labels(self) -> tuple[str, ...]:
        """Labels of events, in the order in which they happen."""
        events = sorted(self.event, key=lambda event: event.moment(self.period))
        return tuple(event.name for event in events if event.name)

    def by_role(self, role: Role) -> Event | None:
        """Return the event with that role, if there is one."""
        return next((event for event in self.event if event.role == role), None)


def positive_speed(speed: float) -> float:
    """The speed (rad/s), if it is one that cycles can count; raises ValueError otherwise."""
    if not 0.0 < speed < math.inf:
        raise ValueError(f"Omega = {speed:g} rad/s is not allowed; it must be > 0 rad/s, since cycles count its turns")
    return speed


def scenarios() -> dict[str, str]:
    """Return the names of the packs' scenarios, and what happens in each."""
    return {name: scenario.description for name, scenario in load_scenarios().items()}


def load_scenarios() -> dict[str, Scenario]:
    """Return the packs' scenarios, by name."""
    return {name: load_scenario(name) for name in packaged_scenarios()}


def load_scenario(name: str | None = None) -> Scenario:
    """Read the scenario called `name`, or the TOML file at that path; the default of the packs without a name.

    A file with a `base`, the name or path of another one, only says what differs from it; see `file`.

    Raises
    ------
    ValueError
        If there is none, or it is wrong; the message is one line for each mistake.
    """
    name = default("scenario") if name is None else name
    return make_scenario(read_scenario(name), name)


def given_scenario(
    given: str | Path | Scenario | None, rotor: str | Path | None = None, receptances: str | Path | None = None
) -> Scenario:
    """Return a scenario, which may be given as for `load_scenario`, with these files in place of its own.

    Raises
    ------
    ValueError
        As `load_scenario` does.
    """
    scenario = given if isinstance(given, Scenario) else load_scenario(None if given is None else str(given))
    files = {"rotor": rotor, "receptances": receptances}
    return scenario.model_copy(update={key: str(file) for key, file in files.items() if file is not None})


def parse_scenario(text: str, name: str) -> Scenario:
    """A scenario from TOML; `name` is used in messages. Raises ValueError as `load_scenario` does."""
    return make_scenario(parse_toml(text, f"scenario {name}"), name)


def make_scenario(data: dict[str, Any], name: str) -> Scenario:
    """A scenario from what its TOML holds. Raises ValueError as `load_scenario` does."""
    what = f"scenario {name}"
    scenario = validate({"name": Path(name).stem} | data, Scenario, what)
    try:
        _check_events(scenario)
        _check_speeds(scenario)
        for stop in scenario.stop:
            stop.condition(scenario.period)
        _ = scenario.step_size("gauss_seidel"), scenario.end(scenario.period)  # both raise when they are wrong
    except ValueError as error:
        raise ValueError(f"{what}: {error}") from error
    return scenario


def _check_events(scenario: Scenario) -> None:
    for event in scenario.event:
        if not 0.0 <= event.moment(scenario.period) < math.inf:
            raise ValueError(f"event at {event.moment(scenario.period):g} s is not allowed; it must be at >= 0 s")
        if event.label in FORMER_LABELS and event.role is None:
            raise ValueError(f"the event labelled {event.label} needs role = '{FORMER_LABELS[event.label]}'")
    for what, values in (("label", scenario.labels), ("role", [event.role for event in scenario.event if event.role])):
        if len(set(values)) < len(values):
            raise ValueError(f"two events have the same {what}")
    disturbance, relief = scenario.by_role("disturbance"), scenario.by_role("relief")
    if disturbance and relief and relief.moment(scenario.period) <= disturbance.moment(scenario.period):
        raise ValueError("the event with the role relief must come after the disturbance")


def _check_speeds(scenario: Scenario) -> None:
    before = 0.0
    for point in scenario.speed:
        moment = point.moment(scenario.period)
        if not before < moment < math.inf:
            what = f"at > {before:g} s, after the point before it" if before else "at > 0 s, where Omega holds"
            raise ValueError(f"speed point at {moment:g} s is not allowed; it must be {what}")
        positive_speed(quantity(point.Omega, "rad/s", "Omega"))
        before = moment
