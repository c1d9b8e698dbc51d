"""A linear model as control.StateSpace with names, units, and notes on its limits."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from numbers import Real
from pathlib import Path
from typing import Any

import control
import numpy as np

from amb_analysis.linear.components import LinearComponent
from amb_cosim.presentation.text_tables import TextBlock, html_of, text_table
from amb_files.checks import as_items
from amb_files.suggestions import suggest

CONTINUOUS = 0.0  # sample time of a continuous model
FACTS = ("input_names", "output_names", "input_units", "output_units", "operating_point", "notes", "warnings")


class LinearModel(control.StateSpace):  # type: ignore[misc]  # python-control has no types
    """A control.StateSpace of a machine or its loop; in `input_labels` and `output_labels`, _ replaces dots in names.

    Signals are selected by their names or labels: `model["rotor_contact.left.x", "rotor_contact.left.f_x"]`.
    Selections, multiples, sums of models with the same signals, and `sample` are linear models with these units and
    notes, too.

    input_names, output_names
        Names `component.variable` of the inputs and outputs, in the order of the matrices' columns and rows.
    input_units, output_units
        SI units of the inputs and outputs.
    operating_point
        Values at the operating point, by name: the speed `Omega` (rad/s), and any other values that were set.
    notes
        Sentences about effects that the model neglects, or about how the model of another project's FMU was obtained.
    warnings
        Warnings from the plan of the run; they also appear in the run's summary.
    """

    input_names: tuple[str, ...]
    output_names: tuple[str, ...]
    input_units: tuple[str, ...]
    output_units: tuple[str, ...]
    operating_point: Mapping[str, float]
    notes: tuple[str, ...]
    warnings: tuple[str, ...] = ()

    def __repr__(self) -> str:
        time = f"sampled every {self.dt:g} s" if self.dt else "continuous"
        return f"LinearModel({self.nstates} states, {self.ninputs} inputs, {self.noutputs} outputs, {time})"

    def __reduce__(self) -> tuple[Any, ...]:
        """Return what pickle stores: matrices and facts, without the functions that python-control makes of them."""
        matrices = (self.A, self.B, self.C, self.D, self.dt)
        return _with_facts, (matrices, *(getattr(self, fact) for fact in FACTS))

    def __getitem__(self, key: Any) -> LinearModel:
        """Return the model from some inputs to some outputs: `model[outputs, inputs]`, by names, labels or numbers.

        Raises
        ------
        ValueError
            If there are not two keys, or the model has no such signal.
        """
        if not isinstance(key, tuple) or len(key) != 2:
            raise ValueError(f"[{key!r}] is not allowed; a model needs an output and an input, such as model[0, 0]")
        rows = _places("output", key[0], self.output_names)
        columns = _places("input", key[1], self.input_names)
        return self._with_matrices(
            (self.A, self.B[:, columns], self.C[rows], self.D[np.ix_(rows, columns)], self.dt), rows, columns
        )

    def __neg__(self) -> LinearModel:
        return self._alike(super().__neg__())

    def __add__(self, other: Any) -> Any:
        return self._combined(super().__add__(other), other)

    def __radd__(self, other: Any) -> Any:
        return self._combined(super().__radd__(other), other)

    def __sub__(self, other: Any) -> Any:
        return self._combined(super().__sub__(other), other)

    def __rsub__(self, other: Any) -> Any:
        return self._combined(super().__rsub__(other), other)

    def __mul__(self, other: Any) -> Any:
        result = super().__mul__(other)
        return self._alike(result) if isinstance(other, Real) else result

    def __rmul__(self, other: Any) -> Any:
        result = super().__rmul__(other)
        return self._alike(result) if isinstance(other, Real) else result

    def __truediv__(self, other: Any) -> Any:
        result = super().__truediv__(other)
        return self._alike(result) if isinstance(other, Real) else result

    def sample(self, *arguments: Any, **options: Any) -> LinearModel:
        """Return the sampled model; the arguments are those of `control.StateSpace.sample`."""
        return self._alike(super().sample(*arguments, **options))

    def _combined(self, result: Any, other: Any) -> Any:
        """Return a sum as a linear model if the other part is a number or a model with the same signals and units."""
        signals = FACTS[:4]
        if isinstance(other, LinearModel) and any(getattr(self, fact) != getattr(other, fact) for fact in signals):
            return result
        return self._alike(result) if isinstance(other, Real | np.ndarray | LinearModel) else result

    def _alike(self, system: control.StateSpace) -> LinearModel:
        """Return a system with the same signals as a linear model with the facts of this one."""
        return self._with_matrices((system.A, system.B, system.C, system.D, system.dt))

    def _with_matrices(
        self, matrices: tuple[Any, ...], rows: Sequence[int] | None = None, columns: Sequence[int] | None = None
    ) -> LinearModel:
        """Return the model with other matrices, for some outputs and inputs; by default, for all."""
        rows = range(self.noutputs) if rows is None else rows
        columns = range(self.ninputs) if columns is None else columns
        ends = (
            tuple(getattr(self, fact)[k] for k in chosen)
            for fact, chosen in zip(FACTS, (columns, rows, columns, rows), strict=False)
        )
        return _with_facts(matrices, *ends, *(getattr(self, fact) for fact in FACTS[4:]))

    def text(self) -> list[TextBlock]:
        """Return a description: size, signals with their units, operating point, notes and warnings."""
        signals = text_table("", ("signal", "unit", "kind"), left=("signal", "unit", "kind"))
        for kind, names, units in (
            ("input", self.input_names, self.input_units),
            ("output", self.output_names, self.output_units),
        ):
            for name, unit in zip(names, units, strict=True):
                signals.add_row(name, unit, kind)
        point = ", ".join(f"{name} = {value:g}" for name, value in self.operating_point.items())
        warnings = (f"warning: {sentence}" for sentence in self.warnings)
        return [repr(self), f"at {point}" if point else "at rest", signals, *self.notes, *warnings]

    def _repr_html_(self) -> str:
        return html_of(self.text())

    def save(self, path: str | Path) -> Path:
        """Write A, B, C, D, the sample time Ts, names and units as arrays (`.mat`, `.npz`) and return the path.

        Raises
        ------
        ValueError
            If the suffix is not allowed.
        """
        from amb_cosim.controllers.array_file import write_arrays
        from amb_cosim.controllers.laws import Law

        metadata = {
            "Ts": self.dt,
            "inputs": self.input_names,
            "outputs": self.output_names,
            "input_units": self.input_units,
            "output_units": self.output_units,
        }
        return write_arrays(Path(path), {0.0: Law(self.A, self.B, self.C, self.D)}, metadata)


def _places(kind: str, key: Any, names: Sequence[str]) -> list[int]:
    """Return the places of signals that a key selects: a name, a label, a number, a slice, or a list of these."""
    if isinstance(key, slice):
        return list(range(len(names)))[key]
    labels = [_label(name) for name in names]
    places = []
    for item in as_items(key):
        if isinstance(item, str):
            known = names if item in names else labels
            if item not in known:
                raise ValueError(f"the model has no {kind} {item!r}; {suggest(item, names)}")
            places.append(list(known).index(item))
        else:
            try:
                places.append(range(len(names))[item])
            except (IndexError, TypeError):
                allowed = f"a name, or a number from 0 to {len(names) - 1}"
                raise ValueError(f"{kind} {item!r} is not allowed; it must be {allowed}") from None
    return places


def _label(name: str) -> str:
    """Return the label of a signal, which must not contain a dot in python-control."""
    return name.replace(".", "_")


def _with_facts(matrices: tuple[Any, ...], *facts: Any) -> LinearModel:
    """Return the model with these matrices A, B, C, D and sample time, and with the values of `FACTS`."""
    names = dict(zip(("inputs", "outputs"), ([_label(name) for name in ends] for ends in facts[:2]), strict=True))
    model = LinearModel(*matrices, **names, remove_useless_states=False)
    for name, value in zip(FACTS, facts, strict=True):
        setattr(model, name, value)
    return model


def linear_model(part: LinearComponent, units: Mapping[str, str], point: Mapping[str, float]) -> LinearModel:
    """Return a part as a `LinearModel`; `units` are given by signal name and default to 1."""
    law = part.law
    time = CONTINUOUS if law.sample_time is None else law.sample_time
    of_ends = (tuple(units.get(name, "1") for name in signals) for signals in (part.inputs, part.outputs))
    return _with_facts(
        (law.A, law.B, law.C, law.D, time), part.inputs, part.outputs, *of_ends, dict(point), part.notes, ()
    )
