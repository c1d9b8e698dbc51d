"""The thesis's tables and bearing constants, computed from the models, as data and as text."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np
from rich.table import Table

from amb_analysis.design import axis_parameters, linear_constants
from rotor_analysis.condensation import condensation_error
from rotor_analysis.rotor import Rotor
from rotor_analysis.rotor_file import load_rotor
from rotor_analysis.tables import SPEEDS, deviations, frequency_tables


def thesis_tables() -> dict[str, Any]:
    """Tables 3.1 to 3.4 (rad/s), and the actuator's constants K_s (N/m, 2.8) and K_i (N/A, 2.9) with Table 2.2."""
    k_s, k_i = linear_constants(axis_parameters())
    return {
        **rotor_tables(load_rotor()),
        "amb": {"k_s": k_s, "k_i": k_i},
    }


def rotor_tables(rotor: Rotor) -> dict[str, Any]:
    """Frequencies of a rotor by mesh and mass, full and condensed (rad/s), and the errors (percent)."""
    tables = frequency_tables(rotor)
    if rotor.planes.master:
        error = condensation_error(rotor, np.array(SPEEDS))
        tables["condensation_error_percent"] = {
            f"{speed:g}": [None if np.isnan(value) else float(value) for value in row]
            for speed, row in zip(SPEEDS, error.frequency, strict=True)
        }
    if rotor == load_rotor():
        tables["deviation_from_thesis_percent"] = deviations(tables)
    return tables


def as_text(data: dict[str, Any]) -> list[Table | str]:
    """What `thesis_tables` or `rotor_tables` returned, to print."""
    parts: list[Table | str] = [
        _table(
            "Table 3.1: damped natural frequencies (rad/s)", ("mesh", "mass", "speed"), _rows(data["table_3_1"]), ".2f"
        )
    ]
    if data["table_3_4"]:
        both = [(model, speed, row) for speed, models in data["table_3_4"].items() for model, row in models.items()]
        parts.append(_table("Table 3.4: full and condensed, diagonal mass (rad/s)", ("model", "speed"), both, ".2f"))
        errors = data["condensation_error_percent"].items()
        parts.append(_table("Error of the condensed model (%)", ("speed",), errors, ".4f"))
    if "deviation_from_thesis_percent" in data:
        rows = _rows(data["deviation_from_thesis_percent"])
        parts.append(_table("Deviation from the thesis (%)", ("model", "mass", "speed"), rows, ".2f"))
    if "amb" in data:
        amb = data["amb"]
        parts.append(f"K_s = {amb['k_s'] / 1e3:.2f} N/mm, K_i = {amb['k_i']:.2f} N/A (2.8, 2.9)")
    return parts


def _rows(models: dict[str, Any]) -> Iterator[tuple[Any, ...]]:
    for model, masses in models.items():
        for mass, speeds in masses.items():
            for speed, row in speeds.items():
                yield model.replace("_node", " nodes"), mass, speed, row


def _table(title: str, keys: tuple[str, ...], rows: Iterable[tuple[Any, ...]], form: str) -> Table:
    """A row for each of `rows`: its labels, then its list of numbers; the lowest frequency comes first."""
    table = Table(title=title, title_justify="left", box=None, padding=(0, 1, 0, 0))
    for key in keys:
        table.add_column(key, no_wrap=True, justify="right" if key == "speed" else "left")
    filled = list(rows)
    for k in range(max((len(row[-1]) for row in filled), default=0)):
        table.add_column(str(k + 1), no_wrap=True, justify="right")
    for *labels, numbers in filled:
        table.add_row(*labels, *("-" if number is None else f"{number:{form}}" for number in numbers))
    return table
