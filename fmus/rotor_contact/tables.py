"""Tables 3.1 and 3.4 of the thesis, computed from the model."""

from __future__ import annotations

from typing import Any

import numpy as np

from rotor_contact.assembly import MassModel, Matrices, assemble
from rotor_contact.modes import damped_frequencies
from rotor_contact.reduction import msdc
from rotor_contact.rotor import Rotor, load_rotor

# Chapter 3: net stiffness K_b = 2.7e6 N/m less the measured negative stiffness (Fig. 2.5), and identified damping.
CHAPTER_3_STIFFNESS = (2.7e6 - 1.944e6, 2.7e6 - 2.156e6)  # N/m
CHAPTER_3_DAMPING = (4665.0, 4665.0)  # N s/m
SPEEDS = (90.0, 120.0, 145.0)  # rad/s


def on_bearings(
    model: Matrices,
    rotor: Rotor,
    stiffness: tuple[float, float] = CHAPTER_3_STIFFNESS,
    damping: tuple[float, float] = CHAPTER_3_DAMPING,
) -> Matrices:
    """`model` on two isotropic bearings of the given net stiffness (N/m) and damping (N s/m)."""
    for node, k, c in zip(rotor.planes.bearings, stiffness, damping, strict=True):
        model = model.with_bearing(node, k * np.eye(2), c * np.eye(2))
    return model


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
