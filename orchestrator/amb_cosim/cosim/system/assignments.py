"""Values that a user gives to parameters and inputs of a system, as numbers in the units of the FMUs."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from amb_cosim.cosim.fmu.fmu_interface import FmuInterface, Port
from amb_cosim.cosim.system.system import System
from amb_cosim.cosim.system.values import Raw, convert, is_zero
from amb_files.suggestions import suggest
from amb_files.wildcards import is_pattern, matching_names


class Assignments:
    """Values of parameters, and first values of inputs, of a system.

    A variable is called `component.variable`, a shared signal by its name or by one of the inputs that it feeds. `*`
    and `?` in the name of a variable match any characters and any one character.

    Attributes
    ----------
    parameters
        Values of parameters by component and name.
    inputs
        Values of signals and of other inputs, by name.
    dropped
        Names whose values `set_or_drop` dropped.
    """

    def __init__(self, system: System, interfaces: Mapping[str, FmuInterface]) -> None:
        self.system, self.interfaces = system, interfaces
        self.parameters: dict[str, dict[str, float]] = {c.name: {} for c in system.components}
        self.inputs: dict[str, float] = {}
        self.dropped: list[str] = []

    def copy(self) -> Assignments:
        """Return the same values, to add others to."""
        other = Assignments(self.system, self.interfaces)
        other.parameters = {component: dict(values) for component, values in self.parameters.items()}
        other.inputs, other.dropped = dict(self.inputs), list(self.dropped)
        return other

    def set(self, name: str, raw: Raw, only: str | None = None) -> list[str]:
        """Give a value to every variable that `name` matches, and return their names.

        Parameters
        ----------
        only
            The causality it must have, `parameter` or `input`; either by default.

        Raises
        ------
        ValueError
            If nothing is called so or may be set here, or the value is not allowed.
        """
        names = self.matching(name)
        for matching in names:
            target, value = self.read(matching, raw, only)
            component, _, variable = target.partition(".")
            if variable and self.interfaces[component].ports[variable].causality == "parameter":
                self.parameters[component][variable] = value
            else:
                self.inputs[target] = value
        return names

    def set_or_drop(self, name: str, raw: Raw, only: str | None = None) -> list[str]:
        """Give a value as `set` does, but drop it if the component replaces one that has such a variable."""
        return [] if self.drops(name, only) else self.set(name, raw, only)

    def set_first(self, name: str, raw: Raw) -> None:
        """Give an input, or all that `name` matches, a first value; drop 0 and false if the component lacks it.

        Raises
        ------
        ValueError
            As `set`; and if a component that replaces another lacks what is not 0: a load or a fault that nothing feels
            would pass as one that does no harm.
        """
        if self.lacks(name, "input") and not is_zero(raw):
            value = str(raw).lower() if isinstance(raw, bool) else raw
            raise ValueError(
                f"the first value {value} of {name} would do nothing: {self.missing(name)}; "
                f'a scenario or system based on this one may say remove = ["{name}"]'
            )
        self.set_or_drop(name, raw, only="input")

    def drops(self, name: str, only: str | None = None) -> bool:
        """Return whether the FMU `lacks` what a name matches; the name then stands in `dropped`."""
        dropped = self.lacks(name, only)
        if dropped and name not in self.dropped:
            self.dropped.append(name)
        return dropped

    def lacks(self, name: str, only: str | None = None) -> bool:
        """Return whether a component that replaces another has nothing that `name` matches; see `set` for `only`."""
        component, _, pattern = name.partition(".")
        return component in self.system.replaced and not matching_names(self._settable_names(component, only), pattern)

    def missing(self, name: str) -> str:
        """Return what the FMU of a component does not have, and what it has that is called alike."""
        component, _, pattern = name.partition(".")
        file = Path(self.system.component(component).fmu).name
        return f"{component} ({file}) has no {pattern}, {suggest(pattern, self._settable_names(component))}"

    def _settable_names(self, component: str, only: str | None = None) -> list[str]:
        causalities = ("parameter", "input") if only is None else (only,)
        return [port.name for port in self.interfaces[component].ports.values() if port.causality in causalities]

    def set_defaults_of_signals(self) -> None:
        """Give signals without a value the start value of the first input that they feed."""
        for signal in self.system.signals:
            self.inputs.setdefault(signal.name, self.start_value(signal.name))

    def matching(self, name: str) -> list[str]:
        """Return the settable variables that a name with `*` or `?` matches; any other name as it is."""
        if not is_pattern(name):
            return [name]
        component, pattern = self._split(name)
        settable = self._settable_names(component)
        matching = matching_names(settable, pattern)
        if not matching:
            raise ValueError(f"{component} has no parameter or input {pattern!r}; {suggest(pattern, settable)}")
        return [f"{component}.{variable}" for variable in matching]

    def read(self, name: str, raw: Raw, only: str | None = None) -> tuple[str, float]:
        """Return the name under which a value is kept (the signal's, where one feeds the input) and the number."""
        signal = self.system.signal(name) or self.system.signal_of(name)
        value = 0.0
        for end in signal.targets if signal is not None else (name,):
            port = self._settable(end, ("parameter", "input") if only is None else (only,))
            value = convert(raw, port, end if signal is None else signal.name)
        return (signal.name if signal is not None else name), value

    def read_change(self, name: str, raw: Raw) -> tuple[str, float]:
        """Read a value that comes during the run, of an input or a tunable parameter; see `read`."""
        component, _, variable = name.partition(".")
        port = self.interfaces[component].ports.get(variable) if component in self.interfaces else None
        is_tunable = port is not None and port.causality == "parameter" and port.variability == "tunable"
        return self.read(name, raw, "parameter" if is_tunable else "input")

    def port(self, name: str) -> Port:
        """Return the variable of a name; of a shared signal, the first input that it feeds."""
        component, variable = self._split(self.system.first_end(name))
        return self.interfaces[component].port(variable, component)

    def start_value(self, name: str) -> float:
        """Return the start value of an input or a signal; of a parameter the value that was set."""
        port = self.port(name)
        return self.parameter(name) if port.causality == "parameter" else port.start or 0.0

    def parameter(self, name: str) -> float:
        """Return the value of a parameter, `component.variable`: the one that was set, or its start value."""
        component, variable = self._split(name)
        start = self.interfaces[component].port(variable, component).start or 0.0
        return self.parameters[component].get(variable, start)

    def _settable(self, end: str, causalities: tuple[str, ...]) -> Port:
        component, variable = self._split(end)
        port = self.interfaces[component].port(variable, component)
        if port.causality not in causalities:
            options = [p.name for kind in causalities for p in self.interfaces[component].of(kind)]
            raise ValueError(
                f"{end} is {port.kind} and cannot be set here as {' or '.join(causalities)}; "
                f"{suggest(variable, options)}"
            )
        source = self.system.source_of(end)
        if source is not None:
            raise ValueError(f"{end} cannot be set; it is connected to {source}")
        return port

    def _split(self, end: str) -> tuple[str, str]:
        if "." not in end:
            names = [c.name for c in self.system.components] + [s.name for s in self.system.signals]
            raise ValueError(f"{end!r} is no component.variable and no signal; {suggest(end, names)}")
        return self.system.split(end)
