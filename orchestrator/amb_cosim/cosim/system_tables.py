"""The form of a system file: its tables, as `system_file` describes them."""

from __future__ import annotations

from fnmatch import fnmatchcase

from pydantic import Field, PrivateAttr

from amb_cosim.cosim.choices import Coupling
from amb_cosim.cosim.experiment import EVERYTHING, Experiment, InputChange, Profile
from amb_cosim.cosim.stopping import StopCondition
from amb_cosim.cosim.system import Component, Connection
from amb_cosim.cosim.tables import Count, Table, Value, Values, time_of
from amb_cosim.cosim.values import Raw


class ComponentTable(Table):
    """An instance of an FMU; `before` names the component of the base that it precedes."""

    name: str
    fmu: str
    every: Count = 1
    mandatory: tuple[str, ...] = ()
    before: str | None = None
    _replaces: str | None = PrivateAttr(None)

    def component(self) -> Component:
        """Return the component as a record."""
        return Component(self.name, self.fmu, self.every, self.mandatory, self._replaces)

    def in_place_of(self, old: ComponentTable) -> ComponentTable:
        """Return the component in the place of another: what feeds that must feed this, as far as it has the inputs."""
        mandatory = self.mandatory if "mandatory" in self.model_fields_set else old.mandatory
        new = self.model_copy(update={"mandatory": mandatory})
        new._replaces = (old._replaces or old.fmu) if new.fmu != old.fmu else old._replaces
        return new


class ConnectTable(Table):
    """Outputs of one component to inputs of another.

    One with an `option` is made only where that is on; a component that replaces another may lack all its ports.
    """

    source: str = Field(alias="from")
    target: str = Field(alias="to")
    variables: tuple[str, ...] | dict[str, str]
    option: str | None = None
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
        left = {a: b for a, b in self.pairs() if b != pattern and not fnmatchcase(b, pattern)}
        table = self.model_copy(update={"variables": left})
        table._but = (*self._but, pattern)
        return table

    def pairs(self) -> list[tuple[str, str]]:
        """Return names of output and input, connection by connection."""
        if isinstance(self.variables, dict):
            return list(self.variables.items())
        return [(name, name) for name in self.variables]


class SharedSignalTable(Table):
    """A shared signal and the inputs that it feeds."""

    name: str
    targets: tuple[str, ...] = Field(min_length=1)


class EventTable(Table):
    """From a time on, inputs have new values."""

    time: Value
    set: Values


class ProfileTable(Table):
    """An input that is linear between points (time, value)."""

    variable: str
    points: tuple[tuple[Value, Value], ...] = Field(min_length=1)
    slope: str | None = None


class StopTable(Table):
    """A condition that ends the run early."""

    variable: str
    above: Value | None = None
    below: Value | None = None
    hold_time: Value = 0.0
    from_time: Value = 0.0

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
    """What is recorded: patterns of variable names, every how many steps, and whether settling is kept.

    `*` is all that the system records by itself; what it leaves out must be named.
    """

    variables: tuple[str, ...] = (EVERYTHING,)
    every: Count = 1
    settling: bool = False


class ExperimentTable(Table):
    """A run: steps, times, inputs and what changes."""

    communication_step: Value
    stop_time: Value
    start_time: Value = 0.0
    inputs: Values = Field(default={})
    event: tuple[EventTable, ...] = ()
    profile: tuple[ProfileTable, ...] = ()
    stop: tuple[StopTable, ...] = ()
    record: Record = Record()

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
    coupling: Coupling = "gauss_seidel"
    unrecorded: tuple[str, ...] = ()
    parameters: dict[str, Values] = Field(default={})
    component: tuple[ComponentTable, ...] = Field(min_length=1)
    connect: tuple[ConnectTable, ...] = ()
    signal: tuple[SharedSignalTable, ...] = ()
    experiment: ExperimentTable | None = None


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
