"""The thesis's tables and bearing constants, computed from the models, as data and as text."""

from __future__ import annotations

from typing import Any

from rich.table import Table

from amb_actuator.actuator import INTERFACE
from amb_actuator.force import current_stiffness, negative_stiffness
from rotor_analysis.tables import frequency_tables

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
    (nodes, masses), *_ = data["table_3_1"].items()
    full = [(mass, speed, row) for mass, rows in masses.items() for speed, row in rows.items()]
    condensed = [(model, speed, row) for speed, models in data["table_3_4"].items() for model, row in models.items()]
    amb = data["amb"]
    return [
        _table(f"Table 3.1, {nodes.replace('_node', ' nodes')}", "mass", full),
        _table("Table 3.4, diagonal mass", "model", condensed),
        f"K_s = {amb['k_s'] / 1e3:.2f} N/mm, K_i = {amb['k_i']:.2f} N/A (2.8, 2.9)",
    ]


def _table(title: str, kind: str, rows: list[tuple[str, str, list[float]]]) -> Table:
    table = Table(
        title=f"{title}: damped natural frequencies (rad/s)", title_justify="left", box=None, padding=(0, 1, 0, 0)
    )
    table.add_column(kind, no_wrap=True)
    table.add_column("speed", no_wrap=True, justify="right")
    for pair in range(4):
        table.add_column(f"{pair + 1}b", no_wrap=True, justify="right")
        table.add_column(f"{pair + 1}f", no_wrap=True, justify="right")
    for label, speed, frequencies in rows:
        table.add_row(label, speed, *(f"{frequency:.2f}" for frequency in frequencies))
    return table
