"""The actuator and the controller of a rotor, with the names of its bearings and sensors."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from amb_actuator import actuator as amb_actuator
from amb_cosim.model_constants.controller_data import MAX_CONDITION, condition_number, no_table, pack
from amb_cosim.model_constants.receptance_file import ReceptanceTable, loop_parameters, read_table
from array_types import Array
from fmi_export.model import Model
from rolac_controller import controller as rolac_controller
from rolac_controller.control_loop import ControlLoop, SensorPlane
from rotor_analysis.receptance import receptance
from rotor_analysis.rotor import Rotor
from rotor_analysis.rotor_file import RotorSource, load_rotor

# Speeds (rad/s) of the table of a controller without identified receptances, and its bearing coefficients.
SPEEDS = 2.0 * np.pi * np.arange(5.0, 101.0)
K_B, C_B = 1e6, 5000.0  # N/m, N s/m


def control_loop(rotor: Rotor | None = None) -> ControlLoop:
    """Return the bearings and sensor planes of a rotor or the default rotor; a bearing uses the plane nearest to it.

    Raises
    ------
    ValueError
        If the rotor has no bearing, or a bearing lacks a sensor plane of its own.
    """
    rotor = rotor or load_rotor()
    z = rotor.shaft.nodes
    planes = tuple(SensorPlane(s.name, s.x, s.y, z[s.node - 1]) for s in rotor.sensors)
    nearest = (
        min(planes, key=lambda plane, at=z[bearing.node - 1]: abs(plane.position - at), default=None)  # type: ignore[misc]
        for bearing in rotor.bearings
    )
    feedback = tuple(plane.name for plane in nearest if plane is not None)
    return ControlLoop(tuple(bearing.name for bearing in rotor.bearings), planes, feedback)


def actuator(rotor: Rotor | None = None) -> tuple[Model, Array]:
    """Return the actuator of a rotor, by default the packs' default rotor, and the constants of the actuator.

    The errors are those of `actuator.model_for`.
    """
    rotor = rotor or load_rotor()
    names = tuple(bearing.name for bearing in rotor.bearings)
    return amb_actuator.model_for(names, rotor.thrust), amb_actuator.constants_for(names, rotor.thrust)


def controller(rotor: Rotor | None = None, table: ReceptanceTable | None = None) -> tuple[Model, Array]:
    """Return the controller of a rotor, by default the packs' default rotor, and the constants of the controller.

    Parameters
    ----------
    rotor
        A rotor description.
    table
        Identified receptances. By default, receptances are computed from the rotor model on bearings with `K_B` and
        `C_B`, from 5 to 100 Hz, and receptances that cannot be inverted are left out.

    Raises
    ------
    ValueError
        As for `control_loop`, or if the table has no entry, or has other sensors or axes than the rotor.
    """
    rotor = rotor or load_rotor()
    loop = control_loop(rotor)
    model = rolac_controller.model_for(loop)
    if table is not None:
        return model, table.constants(loop)
    R = receptance(SPEEDS, K_B, C_B, rotor)
    invertible = np.array([condition_number(r) <= MAX_CONDITION for r in R])
    return model, pack(loop, SPEEDS[invertible], R[invertible]) if invertible.any() else no_table(loop)


def check_loop(
    receptances: Path | ReceptanceTable,
    parameters: Mapping[str, float | None],
    rotor: RotorSource = None,
    inner: Mapping[str, float] | None = None,
) -> None:
    """Raise a ValueError if a table was identified with other controller parameters than those of the present loop.

    `parameters` belong to the controller of the `rotor`, by default the packs' default rotor; `inner` contains
    parameters of an inner linear controller, by `component.name`.
    """
    stated = {name: value for name, value in parameters.items() if value is not None}
    loop = control_loop(load_rotor(rotor))
    read_table(receptances, loop=loop, parameters={**loop_parameters(loop, stated), **(inner or {})})
