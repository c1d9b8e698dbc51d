"""User values of parameters and inputs of a system, as numbers in the units of the FMUs."""

from __future__ import annotations

from collections.abc import Mapping
from copy import copy

from amb_cosim.cosim.fmu.fmu_interface import FmuInterface, Port, TextVariable
from amb_cosim.cosim.fmu.fmus import fmu_name
from amb_cosim.cosim.system.system import UNCHANGED, Signal, System
from amb_cosim.cosim.system.values import Plain, Raw, convert, is_zero, plain_value
from amb_files.suggestions import suggest
from amb_files.wildcards import is_pattern, matching_names


class Assignments:
    """Values that a user sets in a system: parameters, other start values, and initial values of inputs.

    A variable is identified by `component.variable`, and a shared signal by its name or by one of the inputs that it
    feeds. In the name of a variable, `*` matches any characters and `?` matches one character.

    Attributes
    ----------
    parameters
        Values, by component and name, of parameters and of other variables whose start value a user may set according
        to FMI.
    inputs
        Values of signals and of other inputs, by name.
    written
        Values of signals and of other inputs in the form in which they were set, by name.
    texts
        Values of String and Binary variables by component and name.
    dropped
        Names whose values `set_or_drop` dropped.
    outputs
        Names of all outputs.
    """

    def __init__(self, system: System, interfaces: Mapping[str, FmuInterface]) -> None:
        self.system, self.interfaces = system, interfaces
        self.parameters: dict[str, dict[str, float]] = {c.name: {} for c in system.components}
        self.inputs: dict[str, float] = {}
        self.written: dict[str, Raw] = {}
        self.texts: dict[str, dict[str, str | bytes]] = {}
        self.dropped: list[str] = []
        outputs = [(c.name, port.name) for c in system.components for port in interfaces[c.name].of("output")]
        self.outputs = tuple(f"{component}.{name}" for component, name in outputs)

    def copy(self) -> Assignments:
        """Return a copy of the values, to which further values can be added."""
        other = copy(self)
        other.parameters = {component: dict(values) for component, values in self.parameters.items()}
        other.texts = {component: dict(values) for component, values in self.texts.items()}
        other.inputs, other.written, other.dropped = dict(self.inputs), dict(self.written), list(self.dropped)
        return other

    def set(self, name: str, raw: Raw, only: str | None = None) -> list[str]:
        """Set every variable that `name` matches, and return their names.

        If nothing has the name `a=b`, setting `a=b` to the text `c` sets `a` to the text `b=c`.

        Parameters
        ----------
        only
            The causality that the variable must have, `parameter` or `input`; by default, both are allowed.

        Raises
        ------
        ValueError
            If nothing has this name, if the variable cannot be set here, or if the value is not allowed.
        """
        name, raw = self._divided(name, plain_value(raw, name))
        names = self.matching(name)
        component, variable = self.system.divide(name)
        text = self._text(component, variable)
        if text is not None:
            if only not in (None, text.causality):
                raise ValueError(f"{name} is {text.kind} and cannot be set here as {only}")
            self.texts.setdefault(component, {})[variable] = text.value(raw, name)
            return names
        for matched in names:
            target, value = self.read(matched, raw, only)
            component, variable = self.system.divide(target)
            is_signal = self.system.signal(target) is not None
            if not is_signal and self.interfaces[component].ports[variable].set_as == "parameter":
                self.parameters[component][variable] = value
            else:
                self.inputs[target], self.written[target] = value, raw
        return names

    def set_or_drop(self, name: str, raw: Raw, only: str | None = None) -> list[str]:
        """Set a value, or drop it if the variable is one that only the replaced component had."""
        return [] if self.drops(name, only) else self.set(name, raw, only)

    def set_parameters(self, tables: Mapping[str, Mapping[str, Raw]]) -> list[str]:
        """Set parameters by component and name like `set_or_drop`, and return the names of those that were set."""
        values = [(f"{component}.{name}", raw) for component, table in tables.items() for name, raw in table.items()]
        return [each for name, raw in values for each in self.set_or_drop(name, raw, only="parameter")]

    def set_first(self, name: str, raw: Raw) -> None:
        """Set the initial value of all inputs that `name` matches; drop 0 and false if the component lacks the input.

        Raises
        ------
        ValueError
            As for `set`, and also if the value is not zero and a replacing component lacks the input, because a run
            would otherwise silently ignore a load or fault.
        """
        if self.lacks(name, "input") and not is_zero(raw):
            value = str(raw).lower() if isinstance(raw, bool) else raw
            raise ValueError(
                f"the initial value {value} of {name} has no effect: {self.missing(name)}; "
                f'to remove it, a scenario or system based on this one can set remove = ["{name}"]'
            )
        self.set_or_drop(name, raw, only="input")

    def drops(self, name: str, only: str | None = None) -> bool:
        """Return whether the FMU lacks the variables that a name stands for; if so, add the name to `dropped`."""
        dropped = self.lacks(name, only)
        if dropped and name not in self.dropped:
            self.dropped.append(name)
        return dropped

    def lacks(self, name: str, only: str | None = None) -> bool:
        """Return whether a replacing component has no variable that `name` matches.

        `only` is the causality of the variables that may match, as in `set`, or `output`.
        """
        component, pattern = self.system.divide(name)
        if component not in self.system.replaced or self._text(component, pattern) is not None:
            return False
        names = self._outputs(component) if only == "output" else self._settable_names(component, only)
        return not matching_names(names, pattern)

    def missing(self, name: str) -> str:
        """Return a phrase that names the variables a component's FMU lacks, and existing ones with similar names."""
        component, pattern = self.system.divide(name)
        file = fmu_name(self.system.component(component).fmu)
        return f"{component} ({file}) has no {pattern}, {suggest(pattern, self._settable_names(component))}"

    def _settable_names(self, component: str, only: str | None = None) -> list[str]:
        causalities = ("parameter", "input") if only is None else (only,)
        interface = self.interfaces[component]
        ports = [port.name for port in interface.ports.values() if port.set_as in causalities]
        return ports + [text.name for text in interface.texts.values() if text.causality in causalities]

    def _outputs(self, component: str) -> list[str]:
        interface = self.interfaces[component]
        texts = [text.name for text in interface.texts.values() if text.causality == "output"]
        return [port.name for port in interface.of("output")] + texts

    def set_defaults_of_signals(self) -> None:
        """Set each signal without a value to the start value of an input that it feeds."""
        for signal in self.system.signals:
            self.inputs.setdefault(signal.name, self.start_value(signal.name))

    def matching(self, name: str) -> list[str]:
        """Return the settable variables that match a name with `*` or `?`; return any other name unchanged."""
        if not is_pattern(name) or self._is_name(name):
            return [name]
        component, pattern = self._split(name)
        settable = self._settable_names(component)
        matching = matching_names(settable, pattern)
        if not matching:
            raise ValueError(f"{component} has no parameter or input {pattern!r}; {suggest(pattern, settable)}")
        return [f"{component}.{variable}" for variable in matching]

    def read(self, name: str, raw: Raw, only: str | None = None) -> tuple[str, float]:
        """Return the name under which a value is stored (a signal's name if it feeds the input), and the number."""
        signal = self.system.signal(name) or self.system.signal_of(name)
        value = 0.0
        if signal is not None and signal.port is not None:
            return signal.name, self._read_converted(name, raw, signal, signal.port)
        for end in signal.targets if signal is not None else (name,):
            port = self._settable(end, ("parameter", "input") if only is None else (only,))
            value = convert(raw, port, end if signal is None else signal.name)
        return (signal.name if signal is not None else name), value

    def read_change(self, name: str, raw: Raw) -> tuple[str, float]:
        """Read, as `read` does, a value to which an input or a tunable parameter changes during the run."""
        component, variable = self.system.divide(name)
        port = self.interfaces[component].ports.get(variable) if component in self.interfaces else None
        is_tunable = port is not None and port.causality == "parameter" and port.variability == "tunable"
        return self.read(name, raw, "parameter" if is_tunable else "input")

    def port(self, name: str) -> Port:
        """Return the variable with a name; for a shared signal, its port or an input that it feeds."""
        signal = self.system.signal(name)
        if signal is not None and signal.port is not None:
            return signal.port
        component, variable = self._split(self.system.first_end(name))
        return self.interfaces[component].port(variable, component)

    def start_value(self, name: str) -> float:
        """Return the start value of an input or a signal, or the present value of a parameter."""
        port = self.port(name)
        return self.parameter(name) if port.set_as == "parameter" else port.start or 0.0

    def parameter(self, name: str) -> float:
        """Return the value of a parameter, `component.variable`: the value that was set, or its start value."""
        component, variable = self._split(name)
        start = self.interfaces[component].port(variable, component).start or 0.0
        return self.parameters[component].get(variable, start)

    def _divided(self, name: str, raw: Plain) -> tuple[str, Plain]:
        """Split `name=raw` at the `=` after the longest existing name; return this name, and the rest as its value."""
        if "=" not in name or not isinstance(raw, str) or self._is_name(name):
            return name, raw
        parts = f"{name}={raw}".split("=")
        for k in range(name.count("=") + 1, 0, -1):
            shorter = "=".join(parts[:k]).strip()
            if self._exists(shorter):
                return shorter, "=".join(parts[k:]).strip()
        return name.strip(), raw.strip()

    def _exists(self, name: str) -> bool:
        """Return whether a signal or a variable has this name, or a settable variable matches this pattern."""
        component, pattern = self.system.divide(name)
        is_matched = component in self.interfaces and bool(matching_names(self._settable_names(component), pattern))
        return self._is_name(name) or (is_pattern(name) and is_matched)

    def _is_name(self, name: str) -> bool:
        """Return whether a signal or a variable has this name, which may contain brackets, as in `x[State.on]`."""
        component, variable = self.system.divide(name)
        interface = self.interfaces.get(component)
        is_variable = interface is not None and (variable in interface.ports or variable in interface.texts)
        return is_variable or self.system.signal(name) is not None

    def _text(self, component: str, variable: str) -> TextVariable | None:
        """Return the String or Binary variable that can be set, if there is one with this name."""
        text = self.interfaces[component].texts.get(variable) if component in self.interfaces else None
        return text if text is not None and text.causality in ("parameter", "input") else None

    def _settable(self, end: str, causalities: tuple[str, ...]) -> Port:
        component, variable = self._split(end)
        port = self.interfaces[component].port(variable, component)
        if port.set_as not in causalities:
            options = [p.name for p in self.interfaces[component].ports.values() if p.set_as in causalities]
            raise ValueError(
                f"{end} is {port.kind} and cannot be set here as {' or '.join(causalities)}; "
                f"{suggest(variable, options)}"
            )
        source = self.system.source_of(end)
        if source is not None:
            raise ValueError(f"{end} cannot be set; it is connected to {source}")
        return port

    def _read_converted(self, name: str, raw: Raw, signal: Signal, port: Port) -> float:
        """Return the value of a signal that has a port, from a value of the signal or of an input that it feeds."""
        value = convert(raw, port if name == signal.name else self.port(name), name)
        if name != signal.name:
            factor, offset = signal.laws.get(name, UNCHANGED)
            if factor == 0.0:
                raise ValueError(f"{name} cannot be set; its value is {offset:g} for any value of {signal.name}")
            value = (value - offset) / factor
        for end in signal.targets:
            convert(signal.value_at(end, value), self._settable(end, ("input",)), end)
        return value

    def _split(self, end: str) -> tuple[str, str]:
        if "." not in end:
            names = [c.name for c in self.system.components] + [s.name for s in self.system.signals]
            raise ValueError(f"{end!r} is not a component.variable or a signal; {suggest(end, names)}")
        return self.system.split(end)
