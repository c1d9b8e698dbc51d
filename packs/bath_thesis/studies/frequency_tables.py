"""Studies of natural frequencies by mesh, mass matrix and condensation (thesis Tables 3.1 to 3.4)."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

import numpy as np
from rich.table import Table

from amb_analysis.studies.inputs import Number, node_numbers, speed_range
from amb_analysis.studies.result import DrawnResult, WarnedResult
from amb_cosim.presentation.json_data import JsonKey, Layout
from amb_cosim.presentation.text_tables import TextBlock, text_table
from amb_cosim.presentation.units import speed_unit
from array_types import Array
from bath_thesis.condensation_error import CondensationError, condensation_error
from bath_thesis.meshes import mesh_family
from bath_thesis.printed import table_of
from rotor_analysis.implausible_sizes import implausible_sizes
from rotor_analysis.modes import damped_frequencies
from rotor_analysis.rotor import Rotor
from rotor_analysis.rotor_file import RotorSource, load_rotor
from rotor_analysis.shaft import MassModel
from rotor_analysis.supported_rotor import SupportedRotor, supported_rotor

SPEEDS = (90.0, 120.0, 145.0)  # rad/s
MASSES: tuple[MassModel, ...] = ("consistent", "diagonal")
COUNT = 8
POINTS = 161  # speeds of the error of condensation

ByMassAndSpeed = dict[str, dict[str, list[float]]]
"""Rows of numbers by mass matrix and spin speed (rad/s)."""


@dataclass(frozen=True, eq=False)
class FrequencyTables:
    """Damped natural frequencies of a rotor, ascending.

    by_mesh
        Frequencies (rad/s) by mesh, mass matrix and spin speed (rad/s), with the finest mesh first (Table 3.1).
    condensed
        Frequencies (rad/s) of the full and the condensed model with diagonal mass, by spin speed (rad/s) (Table 3.4).
        It is empty for a rotor without master planes.
    condensation_error
        Relative errors of the condensed frequencies (%), by spin speed (rad/s); None for a rotor without
        master planes.
    deviation_from_thesis
        Deviations of the rig's frequencies from the thesis (%), by model, mass matrix and speed; None for any other
        rotor.
    """

    by_mesh: Annotated[dict[str, ByMassAndSpeed], JsonKey("table_3_1")]
    condensed: Annotated[dict[str, dict[str, list[float]]], JsonKey("table_3_4")]
    condensation_error: Annotated[dict[float, Array] | None, "%", Layout.OMITTED_IF_NONE]
    deviation_from_thesis: Annotated[dict[str, ByMassAndSpeed] | None, "%", Layout.OMITTED_IF_NONE]

    def text(self) -> list[TextBlock]:
        """Return a table for each field; frequencies are in rad/s, as in the thesis, unless a unit has been chosen."""
        unit = speed_unit("rad/s")
        title = f"Table 3.1: damped natural frequencies ({unit.label})"
        parts: list[TextBlock] = [_table(title, ("mesh", "mass"), _rows(self.by_mesh), ".2f", unit.size)]
        if self.condensed:
            rows = [(model, speed, row) for speed, models in self.condensed.items() for model, row in models.items()]
            title = f"Table 3.4: full and condensed, diagonal mass ({unit.label})"
            parts.append(_table(title, ("model",), rows, ".2f", unit.size))
        if self.condensation_error is not None:
            parts.append(_table("Error of the condensed model (%)", (), self.condensation_error.items(), "z.4f"))
        if self.deviation_from_thesis is not None:
            rows = [*_rows(self.deviation_from_thesis)]
            parts.append(_table("Deviation from the thesis (%)", ("model", "mass"), rows, "z.2f"))
        return parts


@dataclass(frozen=True, eq=False, repr=False)
class MeshAndCondensation(WarnedResult, DrawnResult):
    """Frequencies of a rotor with different meshes and mass matrices, and after condensation.

    rotor
        Name of the rotor.
    frequencies
        The tables.
    condensation
        Errors of the condensation as a function of spin speed; None if the rotor has no planes to condense to.
    """

    name: ClassVar[str] = "tables"

    rotor: str
    frequencies: Annotated[FrequencyTables, Layout.MERGED]
    condensation: Annotated[CondensationError | None, Layout.OMITTED_IF_NONE]

    def text(self) -> list[TextBlock]:
        """Return the tables of frequencies."""
        return [*self.frequencies.text(), *self.warning_lines()]


def tables(
    rotor: RotorSource = None, *, up_to: Number = "6000 rpm", planes: str | Sequence[int] | None = None
) -> MeshAndCondensation:
    """Return the frequencies of a rotor by mesh, mass matrix and condensation, and the errors of the condensation.

    Parameters
    ----------
    rotor
        A rotor or a rotor file; the rig of the thesis by default.
    up_to
        Highest spin speed (rad/s) at which errors are computed, or a string with its unit.
    planes
        Nodes to condense to, as a sequence or a comma-separated string; by default the master planes of the rotor.

    Raises
    ------
    ValueError
        If the rotor file cannot be read, or an argument is out of range.
    """
    description = load_rotor(rotor)
    chosen = node_numbers(planes, "planes", description, rotor) if planes else description.masters
    condensation = condensation_error(description, speed_range(up_to, POINTS), chosen) if chosen else None
    frequencies, warnings = frequency_tables(description), implausible_sizes(description)
    return MeshAndCondensation(description.name, frequencies, condensation, warnings=warnings)


def frequency_tables(rotor: Rotor) -> FrequencyTables:
    """Return the first eight damped natural frequencies of a rotor at three speeds, by mesh and after condensation.

    For the thesis's rig, the frequencies are compared with the printed ones (`printed_frequencies.toml`).
    """
    meshes = sorted(mesh_family(rotor).items(), reverse=True)
    by_mesh: dict[str, ByMassAndSpeed] = {
        f"{count}_node": {mass: _by_speed(supported_rotor(mesh, mass)) for mass in MASSES} for count, mesh in meshes
    }
    models, errors = {}, None
    if rotor.masters:
        models[f"fem_{len(rotor.shaft.nodes)}"] = _by_speed(supported_rotor(rotor))
        models["condensed"] = _by_speed(supported_rotor(rotor, planes=rotor.masters))
        errors = dict(zip(SPEEDS, condensation_error(rotor, np.array(SPEEDS)).frequency_error.T, strict=True))
    condensed = {
        f"{speed:g}": {name: by_speed[f"{speed:g}"] for name, by_speed in models.items()} for speed in SPEEDS if models
    }
    is_rig = rotor == load_rotor("bath_rig_thesis")
    deviations = _deviations(by_mesh | {"condensed": {"diagonal": models["condensed"]}}) if is_rig else None
    return FrequencyTables(by_mesh, condensed, errors, deviations)


def _by_speed(rotor_model: SupportedRotor) -> dict[str, list[float]]:
    return {f"{speed:g}": damped_frequencies(rotor_model.model, speed, COUNT).tolist() for speed in SPEEDS}


def _deviations(computed: dict[str, ByMassAndSpeed]) -> dict[str, ByMassAndSpeed]:
    """Return the deviations (%) of the frequencies from the thesis, for each printed row."""
    return {
        model: {
            mass: {
                speed: [100.0 * (ours / printed - 1.0) for ours, printed in zip(by_speed[speed], row, strict=True)]
                for speed, row in rows.items()
            }
            for mass, rows in masses.items()
            for by_speed in (computed[model][mass],)
        }
        for model, masses in table_of("frequencies").items()
    }


def _rows(models: Mapping[str, ByMassAndSpeed]) -> Iterator[tuple[Any, ...]]:
    """Yield the labels and the numbers of each row."""
    for model, masses in models.items():
        for mass, speeds in masses.items():
            for speed, row in speeds.items():
                yield model.replace("_node", " nodes"), mass, speed, row


def _table(title: str, labels: tuple[str, ...], rows: Iterable[tuple[Any, ...]], form: str, size: float = 1.0) -> Table:
    """Return a table with a line for each row: its labels, its spin speed, and its numbers divided by their unit.

    The numbers of a line begin with the lowest frequency.
    """
    filled, speed = list(rows), speed_unit()
    numbers = [str(k + 1) for k in range(max((len(row[-1]) for row in filled), default=0))]
    table = text_table(title, (*labels, f"speed ({speed.label})", *numbers), left=labels, gap=1)
    for *texts, Omega, values in filled:
        cells = ("-" if np.isnan(value) else f"{value / size:{form}}" for value in values)
        table.add_row(*texts, speed.number(float(Omega)), *cells)
    return table
