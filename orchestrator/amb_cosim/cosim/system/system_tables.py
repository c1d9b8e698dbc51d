"""The form of a system file: its tables, as `system_file` describes them."""

from __future__ import annotations

from pydantic import Field, PrivateAttr

from amb_cosim.cosim.basics.choices import Coupling
from amb_cosim.cosim.fmu.fmus import is_placeholder
from amb_cosim.cosim.system.experiment import EVERYTHING, Experiment, InputChange, Profile
from amb_cosim.cosim.system.stopping import StopCondition
from amb_cosim.cosim.system.system import Component, Connection
from amb_cosim.cosim.system.tables import Count, Table, Value, Values, time_of
from amb_cosim.cosim.system.values import Raw
from amb_files.wildcards import matches


class ComponentTable(Table):
    """An instance of an FMU."""

    name: str
    """Name, by which connections and values know it."""
    fmu: str
    """Name of an own FMU, or path of any."""
    every: Count = 1
    """It steps once in that many communication steps."""
    mandatory: tuple[str, ...] = ()
    """Inputs that a connection or a value must feed."""
    before: str | None = None
    """Component of the base that it precedes."""
    _replaces: str | None = PrivateAttr(None)

    def component(self) -> Component:
        """Return the component as a record."""
        return Component(self.name, self.fmu, self.every, self.mandatory, self._replaces)

    def in_place_of(self, old: ComponentTable) -> ComponentTable:
        """Return the component in the place of another: what feeds that must feed this, as far as it has the inputs."""
        mandatory = self.mandatory if "mandatory" in self.model_fields_set else old.mandatory
        new = self.model_copy(update={"mandatory": mandatory})
        new._replaces = (old._replaces or old.fmu) if new.replaces(old) else old._replaces
        return new

    def replaces(self, old: ComponentTable) -> bool:
        """Return whether this is another FMU than that of a component, and not the file that it was left open for."""
        return self.fmu != old.fmu and not is_placeholder(old.fmu)


class ConnectTable(Table):
    """Outputs of one component to inputs of another. A component that replaces another may lack all its ports."""

    source: str = Field(alias="from")
    """Component whose outputs they are."""
    target: str = Field(alias="to")
    """Component whose inputs they are."""
    variables: tuple[str, ...] | dict[str, str]
    """Names that both have, or pairs of output and input."""
    option: str | None = None
    """The connection is made only where that is on, such as `gradient`."""
    _inherited: bool = PrivateAttr(False)
    _but: tuple[str, ...] = PrivateAttr(())

    def connections(self) -> list[Connection]:
        """Return the connections, variable by variable."""
        return [
            Connection(f"{self.source}.{output}", f"{self.target}.{input_}", self.option, self._inherited, self._but)
            for output, input_ in self.pairs()
        ]

    def inherited(self) -> ConnectTable:
        """Return the table as it was made for an FMU that another has replaced."""
        table = self.model_copy()
        table._inherited = True
        return table

    def leaving(self, pattern: str) -> ConnectTable:
        """Return the table without the inputs that a pattern names, by whichever own patterns it reaches them."""
        left = {a: b for a, b in self.pairs() if b != pattern and not matches(b, pattern)}
        table = self.model_copy(update={"variables": left})
        table._but = (*self._but, pattern)
        return table

    def pairs(self) -> list[tuple[str, str]]:
        """Return names of output and input, connection by connection."""
        if isinstance(self.variables, dict):
            return list(self.variables.items())
        return [(name, name) for name in self.variables]


class SharedSignalTable(Table):
    """A value that feeds several inputs."""

    name: str
    """Its name, under which it is set and recorded."""
    targets: tuple[str, ...] = Field(min_length=1)
    """The inputs, as COMPONENT.INPUT."""


class EventTable(Table):
    """From a time on, inputs have new values."""

    time: Value
    """From when on."""
    set: Values
    """New values, by COMPONENT.INPUT or shared signal."""


class ProfileTable(Table):
    """An input that is linear between points (time, value)."""

    variable: str
    """The input or shared signal."""
    points: tuple[tuple[Value, Value], ...] = Field(min_length=1)
    """Times and values; constant before the first and after the last."""
    slope: str | None = None
    """Input that gets the slope (per s), where a component asks for it."""


class StopTable(Table):
    """A condition that ends the run early."""

    variable: str
    """Output or input that is judged."""
    above: Value | None = None
    """It counts while it is above; either this or `below`."""
    below: Value | None = None
    """It counts while it is below."""
    hold_time: Value = 0.0
    """How long without a break; a single point is enough at 0."""
    from_time: Value = 0.0
    """From when on it is judged."""

    def condition(self) -> StopCondition:
        """Return the condition, times in s; raises ValueError unless one of `above` and `below` is given."""
        return stop_condition(
            self.variable,
            self.above,
            self.below,
            time_of(self.hold_time, "hold_time of stop", least=0.0),
            time_of(self.from_time, "from_time of stop", least=0.0),
        )


class Record(Table):
    """What is recorded."""

    variables: tuple[str, ...] = (EVERYTHING,)
    """Patterns of names; `*` is all that the system records by itself, what it leaves out must be named."""
    every: Count = 1
    """Every how many steps."""
    settling: bool = False
    """Whether what is before time 0 is kept."""


class ExperimentTable(Table):
    """A run: steps, times, inputs and what changes."""

    communication_step: Value
    """Step after which values are exchanged."""
    stop_time: Value
    """Where the run ends."""
    start_time: Value = 0.0
    """Where it begins, 0 or before: what is before 0 is settling."""
    inputs: Values = Field(default={})
    """Inputs and shared signals at the start."""
    event: tuple[EventTable, ...] = ()
    """What changes, and when."""
    profile: tuple[ProfileTable, ...] = ()
    """Inputs that change linearly."""
    stop: tuple[StopTable, ...] = ()
    """Conditions that end the run before its end."""
    record: Record = Record()
    """What is recorded."""

    def experiment(self) -> Experiment:
        """Return the run, times in s; raises ValueError where one is not allowed."""
        return Experiment(
            step_size=time_of(self.communication_step, "communication_step"),
            stop_time=time_of(self.stop_time, "stop_time"),
            start_time=time_of(self.start_time, "start_time", most=0.0),
            events=tuple(
                InputChange(time_of(e.time, "time of event", least=0.0), name, raw, f"event {number}")
                for number, e in enumerate(self.event, 1)
                for name, raw in e.set.items()
            ),
            profiles=tuple(
                Profile(p.variable, tuple((time_of(t, "time of a point", least=0.0), v) for t, v in p.points), p.slope)
                for p in self.profile
            ),
            stops=tuple(stop.condition() for stop in self.stop),
            recorded=self.record.variables,
            record_every=self.record.every,
            record_settling=self.record.settling,
        )


class SystemTable(Table):
    """A system file without its base."""

    description: str = ""
    """What it is, in one line."""
    coupling: Coupling = "gauss_seidel"
    """Order in which the components step: each with the newest values, or all with those of the step before."""
    unrecorded: tuple[str, ...] = ()
    """Patterns of variables that are recorded only where they are named."""
    parameters: dict[str, Values] = Field(default={})
    """Parameters, by component."""
    component: tuple[ComponentTable, ...] = Field(min_length=1)
    """The components, in the order in which they step."""
    connect: tuple[ConnectTable, ...] = ()
    """What feeds what."""
    signal: tuple[SharedSignalTable, ...] = ()
    """Values that feed several inputs."""
    experiment: ExperimentTable | None = None
    """A run of it, for `amb-cosim simulate`."""


class OverlayTable(SystemTable):
    """A system file with a base: what it adds to that, what it says instead, and what it takes away."""

    base: str
    remove: tuple[str, ...] = ()
    component: tuple[ComponentTable, ...] = ()


def stop_condition(variable: str, above: Raw | None, below: Raw | None, hold: float, begin: float) -> StopCondition:
    """Return a stop condition; raises ValueError unless either `above` or `below` is given."""
    limit = above if below is None else below
    if (above is None) == (below is None) or limit is None:
        raise ValueError(f"stop on {variable} needs either above or below")
    return StopCondition(variable, above is not None, limit, hold, begin)
