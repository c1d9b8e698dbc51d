"""Controller and actuator of the rig, and functions of the libraries with its names."""

from functools import partial

import numpy as np
import sampled_loop

from amb_actuator.actuator import constants_for as actuator_constants_for
from amb_actuator.actuator import model_for as actuator_for
from amb_analysis.linear.sampled_loop import parameters_of_loop
from amb_cosim.model_constants import controller_data
from amb_cosim.model_constants.rotor_models import control_loop
from array_types import Complex
from rolac_controller.controller import model_for as controller_for
from rolac_controller.enumerations import last_stages
from rolac_controller.sizes import sizes_of

LOOP = control_loop()
CONTROLLER, ACTUATOR = controller_for(LOOP), actuator_for(LOOP.bearings)
ACTUATOR_CONSTANTS = actuator_constants_for(LOOP.bearings)
AXES = tuple((axis.bearing, axis.direction) for axis in LOOP.axes)
SENSOR_NAMES = LOOP.sensor_names
SLOT_AFTER, DONE, FAILED = last_stages(len(AXES))

pack = partial(controller_data.pack, LOOP)
NO_TABLE = controller_data.no_table(LOOP)
SIZES = sizes_of(NO_TABLE)
given_parameters = partial(parameters_of_loop, LOOP)
identified_receptance = partial(sampled_loop.identified_receptance, LOOP)


def random_receptance(seed: int = 7) -> Complex:
    """Return a random, well-conditioned receptance of the size of the rig's (m/N), 8 sensors by 4 axes."""
    rng = np.random.default_rng(seed)
    return 1e-6 * (rng.normal(size=(8, 4)) + 1j * rng.normal(size=(8, 4)))
