"""The models of this project, which are found through entry points."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from amb_cosim.cosim.fmu.fmus import made_from
from amb_cosim.results.component_names import ACTUATOR, CONTROLLER, PLANT
from amb_cosim.scenario.rotors import RotorSource
from amb_files.pack_file import rotor_path
from array_types import Array

if TYPE_CHECKING:
    from amb_cosim.controllers.linear_controller import LinearController
    from amb_cosim.model_constants.receptance_file import ReceptanceTable
    from fmi_export.model import Model

MODELS = (PLANT, ACTUATOR, CONTROLLER)

Made = tuple["Model", Array]


@made_from("rotor_contact", "rotor_analysis", "amb_cosim.model_constants", rotor=rotor_path)
def rotor_contact(rotor: RotorSource = None, stators: Sequence[str] = (), **_: Any) -> Made:
    """Return the plant of a packaged rotor, of a rotor file, or of the packs' default rotor.

    The rotor can touch the stator bores of the bearings `stators`.
    """
    from amb_cosim.model_constants.plant_data import plant
    from rotor_analysis.rotor_file import load_rotor

    return plant(load_rotor(rotor), stators)


@made_from("amb_actuator", "rotor_analysis", "amb_cosim.model_constants", rotor=rotor_path)
def amb_actuator(rotor: RotorSource = None, **_: Any) -> Made:
    """Return the actuator for the bearings of a rotor, by default the packs' default rotor."""
    from amb_cosim.model_constants.rotor_models import actuator
    from rotor_analysis.rotor_file import load_rotor

    return actuator(load_rotor(rotor))


@made_from("rolac_controller", "signal_chain", "rotor_analysis", "amb_cosim.model_constants", rotor=rotor_path)
def rolac_controller(rotor: RotorSource = None, receptances: Path | ReceptanceTable | None = None, **_: Any) -> Made:
    """Return the controller for a rotor, with H from a table file, or from the rotor model between 5 and 100 Hz.

    In this model, the rotor is on bearings with K_b = 1e6 N/m and C_b = 5000 N s/m.
    """
    from amb_cosim.model_constants.receptance_file import read_table
    from amb_cosim.model_constants.rotor_models import control_loop, controller
    from rotor_analysis.rotor_file import load_rotor

    description = load_rotor(rotor)
    if receptances is None:
        return controller(description)
    return controller(description, read_table(receptances, description.name, control_loop(description)))


@made_from("linear_controller", "signal_chain", "amb_cosim.controllers")
def linear_controller(file: Path | LinearController | None = None, **_: Any) -> Made:
    """Return the linear controller in a file with arrays (`.npz`, `.mat`) or blocks (TOML), or in a Python object."""
    from amb_cosim.controllers.linear_controller import linear_controller as made_of

    if file is None:
        raise ValueError(
            "linear_controller is made from a file; name the file instead, such as fmu.linear_controller = 'lead.mat'"
        )
    return (made_of(file) if isinstance(file, Path) else file).model_and_constants
