"""The models of this project, as entry points find them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from amb_cosim.cosim.fmu.fmus import made_from
from amb_cosim.results.places import ACTUATOR, CONTROLLER, PLANT
from amb_files.pack_file import rotor_path

if TYPE_CHECKING:
    from fmi_export.model import Model

MODELS = (PLANT, ACTUATOR, CONTROLLER)

Made = tuple["Model", NDArray[np.float64]]


@made_from("rotor_contact", "rotor_analysis", "amb_cosim.design", rotor=rotor_path)
def rotor_contact(rotor: str | Path | None = None, **_: Any) -> Made:
    """Return the plant of a rotor: of one of a pack, of a rotor file, or of the packs' default."""
    from amb_cosim.design.plant_data import plant
    from rotor_analysis.rotor_file import load_rotor

    return plant(load_rotor(rotor))


@made_from("amb_actuator", "rotor_analysis", "amb_cosim.design", rotor=rotor_path)
def amb_actuator(rotor: str | Path | None = None, **_: Any) -> Made:
    """Return the actuator for the bearings of a rotor, the packs' default without."""
    from amb_cosim.design.rotor_models import actuator
    from rotor_analysis.rotor_file import load_rotor

    return actuator(load_rotor(rotor))


@made_from("rolac_controller", "signal_chain", "rotor_analysis", "amb_cosim.design", rotor=rotor_path)
def rolac_controller(rotor: str | Path | None = None, receptances: Path | None = None, **_: Any) -> Made:
    """Return the controller for a rotor, with H of the table in a file, or from the rotor model from 5 to 100 Hz.

    In the model the rotor is on bearings with K_b = 1e6 N/m and C_b = 5000 N s/m.
    """
    from amb_cosim.design.receptance_file import read_table
    from amb_cosim.design.rotor_models import control_loop, controller
    from rotor_analysis.rotor_file import load_rotor

    description = load_rotor(rotor)
    if receptances is None:
        return controller(description)
    return controller(description, read_table(receptances, description.name, control_loop(description)))


@made_from("linear_controller", "signal_chain", "amb_cosim.controllers")
def linear_controller(file: Path | None = None, **_: Any) -> Made:
    """Return the linear controller that is in a file: arrays (`.npz`, `.mat`) or blocks (TOML)."""
    from amb_cosim.controllers.linear_controller import linear_controller as made_of

    if file is None:
        raise ValueError(
            "linear_controller is made from a file; name that in its place, such as fmu.linear_controller = 'lead.mat'"
        )
    return made_of(file).model_and_constants
