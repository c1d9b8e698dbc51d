"""Controller and actuator of the rig, and functions of the libraries with its names."""

from __future__ import annotations

from functools import partial

import numpy as np

import amb_analysis.controller_data
import amb_analysis.sampled_loop
from amb_actuator.actuator import model_for as actuator_for
from amb_analysis.rotor_models import control_loop
from rolac_controller.controller import model_for as controller_for
from rolac_controller.enumerations import last_stages
from rolac_controller.sizes import sizes_of

LOOP = control_loop()
CONTROLLER, ACTUATOR = controller_for(LOOP), actuator_for(LOOP.bearings)
ACTUATOR_CONSTANTS = np.array([2.0])
AXES = tuple((axis.bearing, axis.direction) for axis in LOOP.axes)
SENSOR_NAMES = LOOP.sensor_names
SLOT_AFTER, DONE, FAILED = last_stages(len(AXES))

pack = partial(amb_analysis.controller_data.pack, LOOP)
NO_TABLE = amb_analysis.controller_data.no_table(LOOP)
SIZES = sizes_of(NO_TABLE)
given_parameters = partial(amb_analysis.sampled_loop.given_parameters, LOOP)
identified_receptance = partial(amb_analysis.sampled_loop.identified_receptance, LOOP)
