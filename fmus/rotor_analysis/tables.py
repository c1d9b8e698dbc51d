"""Tables 3.1 and 3.4 of the thesis, computed from the model."""

from __future__ import annotations

from typing import Any

from rotor_analysis.modes import damped_frequencies
from rotor_contact.assembly import MassModel, Matrices, assemble, on_bearings
from rotor_contact.reduction import msdc
from rotor_contact.rotor import Rotor
from rotor_contact.rotor_file import load_rotor

SPEEDS = (90.0, 120.0, 145.0)  # rad/s


def frequency_tables(rotor: Rotor | None = None) -> dict[str, Any]:
    """First eight damped natural frequencies (rad/s), ascending pairs (backward, forward), at three speeds.

    Returns
    -------
    dict
        `table_3_1` of the full model with both mass matrices, `table_3_4` full against condensed (diagonal mass).
    """
    rotor = rotor or load_rotor()
    masses: tuple[MassModel, ...] = ("consistent", "diagonal")
    full = {mass: on_bearings(assemble(rotor, mass), rotor) for mass in masses}
    condensed = msdc(full["diagonal"], rotor.planes.master).model

    def row(model: Matrices, speed: float) -> list[float]:
        return [float(f) for f in damped_frequencies(model, speed, 8)]

    return {
        "table_3_1": {
            f"{len(rotor.shaft.nodes)}_node": {
                mass: {f"{speed:g}": row(full[mass], speed) for speed in SPEEDS} for mass in masses
            }
        },
        "table_3_4": {
            f"{speed:g}": {
                f"fem_{len(rotor.shaft.nodes)}": row(full["diagonal"], speed),
                "condensed": row(condensed, speed),
            }
            for speed in SPEEDS
        },
    }
