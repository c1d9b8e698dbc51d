"""A linear model as engineers have it: control.StateSpace with names, units, and what is not in it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import control

from amb_cosim.linear.parts import LinearPart

CONTINUOUS = 0.0  # sample time of a continuous model


class LinearModel(control.StateSpace):  # type: ignore[misc]  # python-control has no types
    """control.StateSpace of a machine or of its loop; `input_labels` and `output_labels` have _ for the dots of names.

    input_names, output_names
        `component.variable`, in the order of the matrices' columns and rows.
    input_units, output_units
        Units of these, SI.
    operating_point
        Values about which the model is linear, by name: the speed `Omega` (rad/s), and others that were given.
    notes
        What is not in the model, or how a part is known that is no model of ours, in sentences.
    """

    input_names: tuple[str, ...]
    output_names: tuple[str, ...]
    input_units: tuple[str, ...]
    output_units: tuple[str, ...]
    operating_point: Mapping[str, float]
    notes: tuple[str, ...]

    def save(self, path: str | Path) -> Path:
        """Write the matrices A, B, C, D, Ts, names and units as arrays (`.mat`, `.npz`) and return the path.

        Raises
        ------
        ValueError
            If the name ends in another way.
        """
        from amb_cosim.controllers.array_file import write_arrays
        from amb_cosim.controllers.laws import Law

        facts = {
            "Ts": self.dt,
            "inputs": self.input_names,
            "outputs": self.output_names,
            "input_units": self.input_units,
            "output_units": self.output_units,
        }
        return write_arrays(Path(path), {0.0: Law(self.A, self.B, self.C, self.D)}, facts)


def linear_model(part: LinearPart, units: Mapping[str, str], point: Mapping[str, float]) -> LinearModel:
    """Return a part as a `LinearModel`; units are by name, and 1 of those that lack."""
    law = part.law
    names: dict[str, Any] = {
        "inputs": [name.replace(".", "_") for name in part.inputs],
        "outputs": [name.replace(".", "_") for name in part.outputs],
    }
    time = CONTINUOUS if law.sample_time is None else law.sample_time
    model = LinearModel(law.A, law.B, law.C, law.D, time, **names, remove_useless_states=False)
    model.input_names, model.output_names = part.inputs, part.outputs
    model.input_units, model.output_units = (
        tuple(units.get(name, "1") for name in of_kind) for of_kind in (part.inputs, part.outputs)
    )
    model.operating_point, model.notes = dict(point), part.notes
    return model
