"""A linear model as control.StateSpace with names, units, and notes on its limits."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import control

from amb_analysis.linear.components import LinearComponent
from amb_cosim.presentation.text_tables import TextBlock, html_of, text_table

CONTINUOUS = 0.0  # sample time of a continuous model


class LinearModel(control.StateSpace):  # type: ignore[misc]  # python-control has no types
    """A control.StateSpace of a machine or its loop; in `input_labels` and `output_labels`, _ replaces dots in names.

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


def linear_model(part: LinearComponent, units: Mapping[str, str], point: Mapping[str, float]) -> LinearModel:
    """Return a part as a `LinearModel`; `units` are given by signal name and default to 1."""
    law = part.law
    names: dict[str, Any] = {
        "inputs": [name.replace(".", "_") for name in part.inputs],
        "outputs": [name.replace(".", "_") for name in part.outputs],
    }
    time = CONTINUOUS if law.sample_time is None else law.sample_time
    model = LinearModel(law.A, law.B, law.C, law.D, time, **names, remove_useless_states=False)
    model.input_names, model.output_names = part.inputs, part.outputs
    model.input_units, model.output_units = (
        tuple(units.get(name, "1") for name in signals) for signals in (part.inputs, part.outputs)
    )
    model.operating_point, model.notes = dict(point), part.notes
    return model
