"""The thesis's tables and bearing constants, computed from the models, as data and as text."""

from __future__ import annotations

from typing import Any

from rich.table import Table

from amb_actuator.actuator import INTERFACE
from amb_actuator.force import current_stiffness, negative_stiffness
from rotor_contact.tables import frequency_tables

GEOMETRY = ("turns", "pole_area", "gap", "half_angle", "bias_current", "static_current")


def thesis_tables() -> dict[str, Any]:
    """Tables 3.1 and 3.4 (rad/s), and the actuator's constants K_s (N/m, 2.8) and K_i (N/A, 2.9) with Table 2.2."""
    geometry = [INTERFACE[f"mb1.{name}_x"].start for name in GEOMETRY]
    return {
        **frequency_tables(),
        "amb": {"k_s": negative_stiffness(*geometry), "k_i": current_stiffness(*geometry)},
    }


def as_text(data: dict[str, Any]) -> list[Table | str]:
    """What `thesis_tables` returns, to print."""
    rows = {
        "Table 3.1": [
            (f"{model.replace('_', ' ')}s, {mass} mass, {speed} rad/s", frequencies)
            for model, masses in data["table_3_1"].items()
            for mass, speeds in masses.items()
            for speed, frequencies in speeds.items()
        ],
        "Table 3.4": [
            (f"{model.replace('_', ' ')}, {speed} rad/s", frequencies)
            for speed, models in data["table_3_4"].items()
            for model, frequencies in models.items()
        ],
    }
    parts: list[Table | str] = []
    for title, lines in rows.items():
        table = Table("", *(f"{i + 1}" for i in range(8)), title=f"{title}: damped natural frequencies (rad/s)")
        for label, frequencies in lines:
            table.add_row(label, *(f"{f:.2f}" for f in frequencies))
        parts.append(table)
    parts.append(f"K_s = {data['amb']['k_s'] / 1e3:.2f} N/mm, K_i = {data['amb']['k_i']:.2f} N/A (2.8, 2.9)")
    return parts
