"""Experiments with a system, in seconds, and their plans on the time grid of the master, as records."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from amb_cosim.cosim.choices import COUPLINGS, SETTLINGS, Coupling, Settling
from amb_cosim.cosim.fmu.fmu_interface import FmuInterface, Port
from amb_cosim.cosim.fmu.fmus import Fmu
from amb_cosim.cosim.grid.schedules import PiecewiseConstant, PiecewiseLinear, Schedule
from amb_cosim.cosim.grid.time_grid import TimeGrid, in_steps
from amb_cosim.cosim.system.assembly import Assembly
from amb_cosim.cosim.system.stopping import Condition, StopCondition
from amb_cosim.cosim.system.system import System
from amb_cosim.cosim.system.values import Raw
from amb_files.checks import require_choice
from fmi_export.variables import OverStep

EVERYTHING = "*"  # as a pattern of what is recorded

WARM_UP = 40  # steps before a settled motion is solved for; by then the plant's motion is exact, and all has moved


@dataclass(frozen=True)
class InputChange:
    """A value that an input or a tunable parameter has from `time` (s) on; `event` names the event that sets it."""

    time: float
    variable: str
    value: Raw
    event: str = "event"


@dataclass(frozen=True)
class Profile:
    """An input that is linear between points (time in s, value) and constant outside; `slope` receives its slope (1/s).

    If no point is at or before communication point 0, the input's initial value applies there. Values are in `unit`, if
    a unit is stated; they are then averaged over each step if they are closer together than steps. An input that is not
    a Real keeps the value of a point until the next point.

    Parameters
    ----------
    file, has_dates
        The file of the points, whose first row has the headings, and whether its times were dates; empty and false if
        they are not from a file.
    """

    variable: str
    points: tuple[tuple[float, Raw], ...]
    slope: str | None = None
    unit: str | None = None
    file: str = ""
    has_dates: bool = False


@dataclass(frozen=True)
class Experiment:
    """A run of a system, with times in s.

    Parameters
    ----------
    step_size
        Communication step.
    stop_time
        End of the run.
    start_time, settles
        Beginning of the run, and whether the system settles before time 0. If it does, the beginning is 0 or earlier,
        and the run proper begins at time 0.
    inputs
        Initial values of inputs, by name.
    events, profiles
        Inputs over time.
    stops
        Conditions that end the run early.
    recorded
        Patterns of the recorded variables; `*` means everything that the system does not exclude.
    essential
        Patterns of variables that are always recorded.
    record_every, record_settling
        Steps between records, and whether to record before time 0.
    each
        Patterns of variables that a decimated record contains at every step or, in long runs, for several steps
        together (`step_rows`), each with the rule that summarises these steps; None is the rule that the FMU declares.
        The record also contains all recorded variables for which an FMU declares another rule than the value at the
        end of a step, because samples would miss what happened between them.
    settling
        Whether the motion before time 0 is simulated, solved for (`settling`), or solved for if possible.
    period
        Duration of a cycle, in which times may be stated; 0 if there are no cycles. Even if the settled motion is
        solved for, the last cycle before time 0 is simulated, in order to fill windows over the past.
    marks
        Times by label.
    unsolvable
        Reason why the settled motion cannot be solved for, if known.
    notices, warnings
        Sentences for the plan: notices on roundings, and warnings on approximations and on parameters that are without
        effect or in conflict.
    coupling
        Order of the components' steps, which replaces the order of the system.
    source
        Name of its file for messages, such as `system pair`.

    Raises
    ------
    ValueError
        If there is no such settling or coupling.
    """

    step_size: float
    stop_time: float
    start_time: float = 0.0
    settles: bool = True
    inputs: Mapping[str, Raw] = field(default_factory=dict)
    events: tuple[InputChange, ...] = ()
    profiles: tuple[Profile, ...] = ()
    stops: tuple[StopCondition, ...] = ()
    recorded: tuple[str, ...] = (EVERYTHING,)
    essential: tuple[str, ...] = ()
    record_every: int = 1
    each: Mapping[str, OverStep | None] = field(default_factory=dict)
    record_settling: bool = False
    settling: Settling = "simulated"
    period: float = 0.0
    marks: Mapping[str, float] = field(default_factory=dict)
    unsolvable: str = ""
    notices: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()
    coupling: Coupling | None = None
    source: str = ""

    def __post_init__(self) -> None:
        require_choice("settling", self.settling, SETTLINGS)
        if self.coupling is not None:
            require_choice("coupling", self.coupling, COUPLINGS)


@dataclass(frozen=True)
class Ramp:
    """A profile on the grid: points (communication point, value) of the input `variable`."""

    variable: str
    points: tuple[tuple[int, float], ...]
    slope: str | None


@dataclass(frozen=True)
class Plan:
    """An experiment on the time grid: communication point n is at the time t_0 + n h, with t_0 = `start_time`.

    The last point is at `stop_time` unless that is None. `assembly` contains the FMUs; `system` is its system with the
    rates and the coupling of the run.

    `parameters` are the parameters of components, and `texts` are the values of their String and Binary variables.
    `inputs` are the initial values of signals and scheduled inputs by name, and `events` are changes of these inputs as
    (point, name, value). Quantities of `stops` are recorded. `notices` report the variables that replacing components
    lack, and `partial_events` report the events that are incomplete without them. `warnings` report approximations, and
    parameters that are without effect or in conflict. The motion before point 0 is simulated from point `first`, or it
    is solved for and then simulated for `turn` steps; the angle at point 0 is the same. `period` is the duration of a
    cycle (s), or 0 if there are no cycles; `marks` are points by label.
    """

    assembly: Assembly
    system: System
    step_size: float
    first: int
    last: int
    parameters: Mapping[str, Mapping[str, float]]
    inputs: Mapping[str, float]
    events: tuple[tuple[int, str, float], ...]
    ramps: tuple[Ramp, ...]
    recorded: tuple[str, ...]
    stops: tuple[Condition, ...] = ()
    record_every: int = 1
    recorded_each: Mapping[str, OverStep] = field(default_factory=dict)
    record_from: int = 0
    settling: Settling = "simulated"
    period: float = 0.0
    marks: Mapping[str, int] = field(default_factory=dict)
    notices: tuple[str, ...] = ()
    partial_events: tuple[tuple[float, str], ...] = ()
    warnings: tuple[str, ...] = ()
    texts: Mapping[str, Mapping[str, str | bytes]] = field(default_factory=dict)
    start_time: float = 0.0
    stop_time: float | None = None

    @property
    def fmus(self) -> Mapping[str, Fmu]:
        """FMU of each component."""
        return self.assembly.fmus

    @property
    def interfaces(self) -> Mapping[str, FmuInterface]:
        """Interface of each component."""
        return self.assembly.interfaces

    @property
    def grid(self) -> TimeGrid:
        """Times of the communication points."""
        if self.stop_time is None:
            return TimeGrid(self.step_size, self.start_time)
        return TimeGrid(self.step_size, self.start_time, self.last, self.stop_time)

    def time(self, n: int) -> float:
        """Return the time of communication point n (s)."""
        return self.grid.time(n)

    @property
    def first_recorded(self) -> int:
        """First communication point that is recorded."""
        return max(self.record_from, self.begin)

    @property
    def common_steps(self) -> int:
        """Number of steps between successive points at which every component has completed its step."""
        return math.lcm(*(component.every for component in self.system.components))

    @property
    def turn(self) -> int:
        """Number of steps that are simulated before point 0 after solving for the motion: the steps of a cycle."""
        return math.ceil(in_steps(self.period, self.step_size))

    @property
    def begin(self) -> int:
        """Communication point at which the run begins."""
        return self.first if self.settling == "simulated" else -(WARM_UP + self.turn + 4)

    def all_parameters(self) -> dict[str, dict[str, float | None]]:
        """Return every parameter of every component: the value that was set, or its start value."""
        return {c: interface.start_parameters | {**self.parameters[c]} for c, interface in self.interfaces.items()}

    def all_texts(self) -> dict[str, dict[str, str]]:
        """Return the String and Binary values that were set, by component; Binary values are in hexadecimal digits."""
        return {
            component: {name: value if isinstance(value, str) else value.hex() for name, value in values.items()}
            for component, values in self.texts.items()
        }

    def start_values(self) -> dict[str, dict[str, float]]:
        """Return parameters and initial inputs by component; inputs of a shared signal get their value from it."""
        values = {c.name: dict(self.parameters[c.name]) for c in self.system.components}
        for signal, value in self.inputs.items():
            shared = self.system.signal(signal)
            for end in shared.targets if shared is not None else (signal,):
                component, variable = self.system.split(end)
                values[component][variable] = value if shared is None else shared.value_at(end, value)
        return values

    def port(self, name: str) -> tuple[str, Port]:
        """Return the component and variable of a recorded name; for a shared signal, its port or an input it feeds."""
        component, variable = self.system.split(self.system.first_end(name))
        shared = self.system.signal(name)
        port = None if shared is None else shared.port
        return component, self.interfaces[component].ports[variable] if port is None else port

    def schedules(self, names: Sequence[str]) -> list[Schedule]:
        """Return the schedules of the inputs, for a master whose signals have these names."""
        at = list(names).index
        steps: list[Schedule] = [PiecewiseConstant((n, at(name), value) for n, name, value in self.events)]
        return steps + [
            PiecewiseLinear(r.points, self.grid, at(r.variable), None if r.slope is None else at(r.slope))
            for r in self.ramps
        ]
