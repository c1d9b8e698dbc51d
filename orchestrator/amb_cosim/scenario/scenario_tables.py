"""Tables of a scenario file: events, speed points, conditions that end the run, and figures."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Annotated, Literal

from pydantic import StringConstraints

from amb_cosim.cosim.choices import Role
from amb_cosim.cosim.system.experiment import Profile
from amb_cosim.cosim.system.stopping import StopCondition
from amb_cosim.cosim.system.system_tables import ProfileTable
from amb_cosim.cosim.system.tables import ByComponent, Cycles, Table, Value
from amb_cosim.cosim.system.values import is_zero, quantity
from amb_files.validation_errors import Allowed

Label = Annotated[
    str,
    StringConstraints(pattern=r"^[a-z][a-z0-9_]*$", max_length=40),
    Allowed("a name of at most 40 lower-case letters, digits and underscores, beginning with a letter"),
]
FigureName = Literal["orbits", "displacement", "contact", "whirl", "magnets", "energy", "touchdown", "turns"]


class _Moment(Table):
    """An event at a cycle or at a time."""

    cycle: Cycles | None = None
    """Cycle of the event: revolutions at the initial speed since the end of settling."""
    time: Value | None = None
    """Time of the event in seconds since the end of settling."""

    @property
    def described(self) -> str:
        """The name of the event in messages, without its position in the file."""
        raise NotImplementedError

    def moment(self, period: float) -> float:
        """Return the time (s) of the event for cycles of `period` (s)."""
        if (self.cycle is None) == (self.time is None):
            raise ValueError(f"{self.described} needs either cycle or time")
        if self.cycle is not None:
            return self.cycle * period
        return quantity(self.time or 0.0, "s", f"time of {self.described}")


class _Named(Table):
    """A change that figures and the summary name."""

    label: Label | None = None
    """Unique name of the event, such as `power_loss`, in figures and sweeps; default: its role."""
    role: Role | None = None
    """Role of the event in the run: the `disturbance` after which the rotor is judged, or the `relief` that removes
    it.
    """

    @property
    def name(self) -> str:
        """The label of the change or, without a label, its role; empty if it has neither."""
        return self.label or self.role or ""


class Event(_Named, _Moment):
    """New values that inputs and tunable parameters have from a point in time on."""

    set: ByComponent
    """New values, by component and variable."""

    @property
    def described(self) -> str:
        """The event in messages: `event step` or, without a name, `the event that sets rotor_contact`."""
        return f"event {self.name}" if self.name else f"the event that sets {', '.join(self.set)}"


class InputProfile(_Named, ProfileTable):
    """An input that is linear between points (time, value), or inputs in a file.

    With a label or a role it is also an event, which happens at the last point before a value changes.
    """

    @property
    def described(self) -> str:
        """The profile in messages, such as `profile air_inrush`."""
        return f"profile {self.name or self.variable or self.file}"

    def moment(self, period: float) -> float:
        """Return the time (s) at which the input begins to change; `period` is not used."""
        return min(_beginning(profile) for profile in self.profiles(0.0))


def _beginning(profile: Profile) -> float:
    """Return the time (s) of the last point before the value changes; the time of the first point if it never does."""
    for (time, value), (_, later) in pairwise(profile.points):
        if value != later and not (is_zero(value) and is_zero(later)):
            return time
    return profile.points[0][0]


class SpeedPoint(_Moment):
    """A speed at a point in time; from the previous point, the speed changes linearly to this value."""

    Omega: Value
    """Speed at that time."""

    @property
    def described(self) -> str:
        """The speed point in messages: `the speed point with Omega = 960 rpm`."""
        return f"the speed point with Omega = {self.Omega}"


class Stop(Table):
    """A condition that ends the run: a signal has been above, or below, a value for a certain time."""

    variable: str
    """An output, or an input that the scenario sets, by its name in the data set."""
    above: Value | None = None
    """Value that the signal must exceed; set either this or `below`."""
    below: Value | None = None
    """Value below which the signal must fall."""
    hold_cycles: Cycles | None = None
    """Duration of the condition in cycles; by default a single point suffices."""
    hold_time: Value | None = None
    """Duration of the condition in seconds."""
    from_cycle: Cycles | None = None
    """Cycle from which the signal is checked; by default 0."""
    from_time: Value | None = None
    """Time in seconds from which the signal is checked."""

    def condition(self, period: float) -> StopCondition:
        """Return the condition with its times in s, for cycles of `period` (s)."""
        hold = self._duration("hold", self.hold_cycles, self.hold_time, period)
        begin = self._duration("from", self.from_cycle, self.from_time, period)
        return StopCondition(self.variable, self.above, self.below, hold, begin)

    def _duration(self, what: str, cycles: float | None, time: Value | None, period: float) -> float:
        if cycles is not None and time is not None:
            names = [name for name in type(self).model_fields if name.startswith(what)]
            raise ValueError(f"stop on {self.variable} has both {' and '.join(names)}; set only one")
        value = cycles * period if cycles is not None else quantity(time or 0.0, "s", f"{what}_time of stop")
        if not 0.0 <= value < math.inf:
            raise ValueError(f"{what}_time of stop = {value:g} s is not allowed; it must be >= 0 s")
        return value


class Plot(Table):
    """Figures."""

    cycles: tuple[Cycles, Cycles] | None = None
    """First and last cycle of the figures; by default chosen to suit the run."""
    figures: tuple[FigureName, ...] | None = None
    """Figures to draw; by default chosen to suit the run."""
