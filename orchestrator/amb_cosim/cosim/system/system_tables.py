"""The tables of a system file; `system_file` describes them."""

from __future__ import annotations

from pydantic import Field, model_validator

from amb_cosim.cosim.choices import Coupling
from amb_cosim.cosim.system.experiment import EVERYTHING, Experiment, InputChange, Profile
from amb_cosim.cosim.system.profile_file import profiles_of
from amb_cosim.cosim.system.stopping import StopCondition
from amb_cosim.cosim.system.tables import ByComponent, Count, Table, Value, Values, time_of
from amb_files.frozen_table import FrozenTable

LONGEST = 1e12  # s, of times in a file


class ComponentTable(Table):
    """An instance of an FMU."""

    name: str
    """Name used in connections and values."""
    fmu: str
    """Name of a model of this package, or path of an FMU."""
    every: Count = 1
    """Number of communication steps in one step of the component."""
    mandatory: tuple[str, ...] = ()
    """Inputs that must be connected or set."""
    before: str | None = None
    """Component of the base; this component steps before it."""


class ConnectTable(Table):
    """Connects outputs of a component to inputs of another. A replacing component may lack all of these inputs."""

    source: str = Field(alias="from")
    """Component with the outputs."""
    target: str = Field(alias="to")
    """Component with the inputs."""
    variables: tuple[str, ...] | dict[str, str]
    """Names of variables that both components have, or pairs of output and input."""
    option: str | None = None
    """Switch that enables the connection, such as `gradient`."""

    def pairs(self) -> list[tuple[str, str]]:
        """Return the names of the output and the input of each connection."""
        if isinstance(self.variables, dict):
            return list(self.variables.items())
        return [(name, name) for name in self.variables]


class SharedSignalTable(Table):
    """A value that feeds several inputs."""

    name: str
    """Name by which the signal is set and recorded."""
    targets: tuple[str, ...] = Field(min_length=1)
    """The inputs, as COMPONENT.INPUT."""


class EventTable(Table):
    """New values that inputs have from a certain time on."""

    time: Value
    """Time of the change."""
    set: Values
    """New values, by COMPONENT.INPUT or shared signal."""


class ProfileTable(Table):
    """An input that is linear between points (time, value), or inputs in a file.

    Only a Real is linear. An Integer, a Boolean or an Enumeration keeps the value of a point until the next point.
    """

    variable: str = ""
    """The input or shared signal."""
    points: tuple[tuple[Value, Value], ...] = ()
    """Times and values; the input is constant before the first time and after the last."""
    slope: str | None = None
    """Input for the slope (per s), if a component needs it."""
    file: str = ""
    """CSV file in place of `points`: a column `time (s)`, and one for each input with its unit, such as
    `rotor_contact.base.a_x (m/s2)`. A column named `time`, without a unit, is in seconds. Rows closer together than a
    communication step are averaged over each step. Booleans are `true`, `false`, 1 or 0, and Enumerations names or
    numbers. Times that are dates, in seconds since 1970, count from the first row.
    """
    begin: Value = 0.0
    """Time in the run that corresponds to time 0 of the file, or to its first row if its times are dates."""

    @model_validator(mode="after")
    def _has_one_source(self) -> ProfileTable:
        if bool(self.file) == bool(self.variable or self.points) or bool(self.variable) != bool(self.points):
            raise ValueError("a profile needs either variable and points, or file")
        return self

    def profiles(self, earliest: float, start: float = 0.0) -> tuple[Profile, ...]:
        """Return inputs, with times in s, for a run from `start` (s).

        Raises
        ------
        ValueError
            For times before `earliest` (s), and for a wrong file.
        """
        if self.file:
            return profiles_of(self.file, time_of(self.begin, "start of a profile", least=earliest), start)
        points = tuple((time_of(t, "time of a point", least=earliest), value) for t, value in self.points)
        return (Profile(self.variable, points, self.slope),)


class StopTable(Table):
    """A condition that ends the run early."""

    variable: str
    """Output or input to check."""
    above: Value | None = None
    """Value that the signal must exceed; set either this or `below`."""
    below: Value | None = None
    """Value below which the signal must fall."""
    hold_time: Value = 0.0
    """Duration for which the condition must hold; with 0, a single point suffices."""
    from_time: Value | None = None
    """Time from which the signal is checked; by default the start."""

    def condition(self, beginning: float) -> StopCondition:
        """Return the condition, with times in s; raises ValueError unless one of `above` and `below` is set."""
        begin = None if self.from_time is None else time_of(self.from_time, "from_time of stop", least=beginning)
        hold = time_of(self.hold_time, "hold_time of stop", least=0.0)
        return StopCondition(self.variable, self.above, self.below, hold, begin)


class Record(Table):
    """Recorded variables."""

    variables: tuple[str, ...] = (EVERYTHING,)
    """Patterns of names; `*` stands for the variables that the system records by default."""
    every: Count = 1
    """Number of communication steps between recorded samples."""
    settling: bool | None = None
    """Whether times before 0 are recorded; by default true for a system file and false for a scenario."""


class ExperimentTable(Table):
    """A run: steps, times, inputs and changes."""

    communication_step: Value
    """Communication step."""
    stop_time: Value
    """End of the run; the last step is shortened if necessary."""
    start_time: Value = 0.0
    """Start of the run, and of the record."""
    inputs: Values = Field(default=FrozenTable())
    """Initial values of inputs and shared signals."""
    event: tuple[EventTable, ...] = ()
    """Changes during the run."""
    profile: tuple[ProfileTable, ...] = ()
    """Inputs that change linearly."""
    stop: tuple[StopTable, ...] = ()
    """Conditions that end the run early."""
    record: Record = Record()
    """Recorded variables."""

    def experiment(self) -> Experiment:
        """Return the run, with times in s; raises ValueError if a time is not allowed."""
        start = time_of(self.start_time, "start_time", least=-LONGEST)
        settles = start < 0.0 and self.record.settling is False
        beginning = 0.0 if settles else start
        earliest = min(0.0, beginning)
        return Experiment(
            step_size=time_of(self.communication_step, "communication_step"),
            stop_time=time_of(self.stop_time, "stop_time", least=-LONGEST),
            start_time=start,
            settles=settles,
            inputs=self.inputs,
            events=tuple(
                InputChange(time_of(e.time, "time of event", least=beginning), name, raw, f"event {number}")
                for number, e in enumerate(self.event, 1)
                for name, raw in e.set.items()
            ),
            profiles=tuple(profile for table in self.profile for profile in table.profiles(earliest, start)),
            stops=tuple(stop.condition(beginning) for stop in self.stop),
            recorded=self.record.variables,
            record_every=self.record.every,
            record_settling=not settles,
        )


class SystemTable(Table):
    """A system file without its base."""

    description: str = ""
    """One-line description."""
    coupling: Coupling = "gauss_seidel"
    """Coupling: each component uses the newest values, all use values of the previous step, or steps are repeated."""
    unrecorded: tuple[str, ...] = ()
    """Patterns of variables that are recorded only if named."""
    parameters: ByComponent = Field(default=FrozenTable())
    """Parameters, by component."""
    component: tuple[ComponentTable, ...] = Field(min_length=1)
    """The components, in the order in which they step."""
    connect: tuple[ConnectTable, ...] = ()
    """Connections."""
    signal: tuple[SharedSignalTable, ...] = ()
    """Values that feed several inputs."""
    experiment: ExperimentTable | None = None
    """Run of the system by `amb-cosim simulate`."""


class OverlayTable(SystemTable):
    """A system file with a base: additions, replacements and removals."""

    base: str
    remove: tuple[str, ...] = ()
    component: tuple[ComponentTable, ...] = ()
