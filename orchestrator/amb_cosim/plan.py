"""A scenario turned into numbers: what components start with, what happens when, what is recorded."""

from __future__ import annotations

import fnmatch
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

from amb_cosim.cosim.interface import Interface, Port, suggest
from amb_cosim.cosim.stopping import Condition
from amb_cosim.cosim.system import Component, System
from amb_cosim.cosim.values import Raw, convert
from amb_cosim.scenario import Scenario, Stop, positive_speed

SPEED = "Omega"  # the shared signal whose first value counts the cycles
ACCELERATION = "Omega_dot"  # the shared signal that tells how the speed changes over the coming step

EVERYTHING = "*"  # as a pattern of what is recorded
# Figures and plots need these, whatever else is recorded.
ESSENTIAL = tuple(f"rotor_contact.{name}" for name in ("mb?.[xy]", "rb?.*", "eb?.*", "contact_state", "energy.*"))


@dataclass(frozen=True)
class Plan:
    """What a run does, in numbers. Communication point 0 begins cycle 0; settling comes before it.

    `start` holds parameters by component, `exogenous` the first values of signals and scheduled inputs by
    name, `events` their changes as (point, name, value). `profile` holds the points (point, speed in rad/s)
    that a changing speed is linear between; it is empty where the speed stays. What `stops` judge is recorded.
    """

    system: System
    step_size: float
    period: float
    first: int
    last: int
    start: Mapping[str, Mapping[str, float]]
    exogenous: Mapping[str, float]
    events: tuple[tuple[int, str, float], ...]
    profile: tuple[tuple[int, float], ...]
    marks: Mapping[str, int]
    recorded: tuple[str, ...]
    stops: tuple[Condition, ...] = ()

    @property
    def speed(self) -> float:
        """Initial speed in rad/s."""
        return self.exogenous[SPEED]

    def parameters(self, interfaces: Mapping[str, Interface]) -> dict[str, dict[str, float | None]]:
        """Every parameter of every component: what was set, or what it starts with."""
        return {
            c: {p.name: self.start[c].get(p.name, p.start) for p in interface.of("parameter")}
            for c, interface in interfaces.items()
        }


def parse_settings(settings: Iterable[str]) -> dict[str, str]:
    """`component.variable=value` texts by variable; the last one counts."""
    parsed = {}
    for text in settings:
        name, equals, value = (part.strip() for part in text.partition("="))
        if not (name and equals and value):
            raise ValueError(f"{text!r} is no setting; write component.variable=value")
        parsed[name] = value
    return parsed


def make_plan(
    scenario: Scenario,
    system: System,
    interfaces: Mapping[str, Interface],
    settings: Mapping[str, Raw] | None = None,
    until: float | None = None,
) -> Plan:
    """Numbers for a scenario.

    Parameters
    ----------
    scenario, system, interfaces
        What is run, of what, and the interfaces of its components.
    settings
        Values by `component.variable`, or by a signal's name, that replace the scenario's first values.
    until
        End of the run in s from the beginning of cycle 0, in place of the scenario's.

    Raises
    ------
    ValueError
        For names that do not exist, values that are not allowed, and times that do not fit the steps.
    """
    values = _Values(system, interfaces, scenario.unbalance_factor)
    values.set(SPEED, scenario.Omega)
    for shared in system.signals:
        values.exogenous.setdefault(shared.name, values.default(shared.targets[0]))
    for parameters in (system.parameters, scenario.parameters):
        for component, variables in parameters.items():
            for variable, raw in variables.items():
                values.set(f"{component}.{variable}", raw, only="parameter")
    for component, variables in scenario.inputs.items():
        for variable, raw in variables.items():
            values.set(f"{component}.{variable}", raw, only="input", scaled=True)
    for name, raw in (settings or {}).items():
        values.set(name, raw)
    period = 2.0 * math.pi / positive_speed(values.exogenous[SPEED])

    h = scenario.step_size
    profile = _profile(scenario, values, period, h)
    system = replace(system, components=tuple(_rated(c, interfaces, values.start, h) for c in system.components))
    events: list[tuple[int, str, float]] = []
    marks: dict[str, int] = {}
    for event in scenario.event:
        n = round(event.moment(period) / h)
        if event.label:
            marks[event.label] = n
        for component, variables in event.set.items():
            for variable, raw in variables.items():
                name, value = values.read(f"{component}.{variable}", raw, "input", scaled=True)
                if profile and name in (SPEED, ACCELERATION):
                    raise ValueError(f"an event cannot set {name}; the speed points of the scenario do")
                values.exogenous.setdefault(name, values.default(f"{component}.{variable}"))
                events.append((n, name, value))

    common = math.lcm(*(c.every for c in system.components))
    settle = common * math.ceil(scenario.settle_cycles * period / h / common)
    last = _whole_steps("--until", until, h) if until is not None else max(1, round(scenario.end(period) / h))
    available = [
        *values.exogenous,
        *(f"{c.name}.{p.name}" for c in system.components for p in interfaces[c.name].of("output")),
    ]
    stops = tuple(_condition(stop, available, system, interfaces, period, h) for stop in scenario.stop)
    return Plan(
        system,
        h,
        period,
        -settle,
        last,
        values.start,
        values.exogenous,
        tuple(events),
        profile,
        marks,
        _recorded(scenario.record.variables, system.unrecorded, available, [stop.signal for stop in stops]),
        stops,
    )


def port_of(signal: str, system: System, interfaces: Mapping[str, Interface]) -> tuple[str, Port]:
    """Component and variable behind a name of the data set; of a shared signal, the first input that it feeds."""
    shared = next((s for s in system.signals if s.name == signal), None)
    component, variable = system.split(shared.targets[0] if shared is not None else signal)
    return component, interfaces[component].ports[variable]


class _Values:
    """Collects numbers for parameters and exogenous inputs, and refuses everything else."""

    def __init__(self, system: System, interfaces: Mapping[str, Interface], unbalance_factor: float) -> None:
        self.system, self.interfaces, self.factor = system, interfaces, unbalance_factor
        self.start: dict[str, dict[str, float]] = {c.name: {} for c in system.components}
        self.exogenous: dict[str, float] = {}

    def set(self, name: str, raw: Raw, only: str | None = None, scaled: bool = False) -> None:
        """Set what `name` names; `*` and `?` in it stand for any characters and any one."""
        for end in self._matching(name):
            target, value = self.read(end, raw, only, scaled)
            component, _, variable = target.partition(".")
            if variable and self.interfaces[component].ports[variable].causality == "parameter":
                self.start[component][variable] = value
            else:
                self.exogenous[target] = value

    def _matching(self, name: str) -> list[str]:
        if not set("*?") & set(name):
            return [name]
        component, pattern = self._split(name)
        ports = self.interfaces[component].ports.values()
        settable = [p.name for p in ports if p.causality in ("parameter", "input")]
        matching = fnmatch.filter(settable, pattern)
        if not matching:
            raise ValueError(f"{component} has no parameter or input {pattern!r}; {suggest(pattern, settable)}")
        return [f"{component}.{variable}" for variable in matching]

    def read(self, name: str, raw: Raw, only: str | None, scaled: bool = False) -> tuple[str, float]:
        """Name under which a value is kept, a shared signal's in place of its targets', and the value."""
        signal = next((s for s in self.system.signals if s.name == name), self.system.signal_of(name))
        ends = signal.targets if signal is not None else (name,)
        value = 0.0
        for end in ends:
            component, variable = self._split(end)
            port = self.interfaces[component].port(variable, component)
            settable = ("parameter", "input") if only is None else (only,)
            if port.causality not in settable:
                options = [p.name for kind in settable for p in self.interfaces[component].of(kind)]
                raise ValueError(
                    f"{end} is {port.kind} and cannot be set here as {' or '.join(settable)}; "
                    f"{suggest(variable, options)}"
                )
            source = self.system.source_of(end)
            if source is not None:
                raise ValueError(f"{end} cannot be set; it is connected to {source}")
            value = convert(raw, port, end if signal is None else signal.name)
            if scaled and port.unit == "kg.m":
                value = convert(self.factor * value, port, f"unbalance_factor times {end}")
        return (signal.name if signal is not None else name), value

    def default(self, end: str) -> float:
        component, variable = self._split(end)
        return self.interfaces[component].ports[variable].start or 0.0

    def _split(self, end: str) -> tuple[str, str]:
        if "." not in end:
            names = [c.name for c in self.system.components] + [s.name for s in self.system.signals]
            raise ValueError(f"{end!r} is no component.variable and no signal; {suggest(end, names)}")
        return self.system.split(end)


def _profile(scenario: Scenario, values: _Values, period: float, h: float) -> tuple[tuple[int, float], ...]:
    """Communication points and speeds that the speed is linear between, from point 0 on."""
    if not scenario.speed:
        return ()
    signals = [signal.name for signal in values.system.signals]
    if ACCELERATION not in signals:
        raise ValueError(
            f"system {values.system.name} has no signal {ACCELERATION}, and so its speed cannot change; "
            f"there are {', '.join(signals)}"
        )
    profile = [(0, values.exogenous[SPEED])]
    for point in scenario.speed:
        n = round(point.moment(period) / h)
        if n <= profile[-1][0]:
            raise ValueError(
                f"speed point at {point.moment(period):g} s is not allowed; it must be at least one communication "
                f"step, {h:g} s, after the one before it"
            )
        profile.append((n, positive_speed(values.read(SPEED, point.Omega, "input")[1])))
    return tuple(profile)


def _rated(
    component: Component,
    interfaces: Mapping[str, Interface],
    start: Mapping[str, Mapping[str, float]],
    h: float,
) -> Component:
    """The component at the rate of its parameter `sample_time`, if it has one."""
    port = interfaces[component.name].ports.get("sample_time")
    if port is None or port.causality != "parameter":
        return component
    sample_time = start[component.name].get("sample_time", port.start or h)
    return replace(component, every=_whole_steps(f"{component.name}.sample_time", sample_time, h))


def _whole_steps(name: str, time: float, h: float) -> int:
    if not 0.0 < time < math.inf:
        raise ValueError(f"{name} = {time:g} s is not allowed; it must be > 0 s")
    n = round(time / h)
    if n < 1 or not math.isclose(n * h, time, rel_tol=1e-9):
        raise ValueError(
            f"{name} = {time:.12g} s is not allowed; it must be a whole multiple of the communication step {h:g} s"
        )
    return n


def _condition(
    stop: Stop, available: Sequence[str], system: System, interfaces: Mapping[str, Interface], period: float, h: float
) -> Condition:
    signal = stop.variable
    if signal not in available:
        raise ValueError(f"stop: there is no signal {signal!r}; {suggest(signal, available)}")
    _, port = port_of(signal, system, interfaces)
    side, raw = stop.limit
    limit = convert(raw, port, f"stop: {signal} {side}")
    first, hold = round(stop.begin(period) / h), round(stop.hold(period) / h)
    text = f"{signal} {side} {limit:.9g}{port.shown_unit}" + (f" for {hold * h:.9g} s" if hold else "")
    return Condition(signal, side == "above", limit, first, hold, text)


def _recorded(
    patterns: Sequence[str], unrecorded: Sequence[str], available: Sequence[str], watched: Sequence[str]
) -> tuple[str, ...]:
    """Names that match a pattern, or that figures need; `*` leaves out what the system does not record by itself."""
    for pattern in patterns:
        if not fnmatch.filter(available, pattern):
            raise ValueError(f"record.variables: nothing matches {pattern!r}; {suggest(pattern, available)}")
    every = EVERYTHING in patterns
    matching = (*(pattern for pattern in patterns if pattern != EVERYTHING), *ESSENTIAL)

    def is_recorded(name: str) -> bool:
        return name in watched or _matches(name, matching) or (every and not _matches(name, unrecorded))

    return tuple(name for name in available if is_recorded(name))


def _matches(name: str, patterns: Sequence[str]) -> bool:
    return any(fnmatch.fnmatchcase(name, pattern) for pattern in patterns)
