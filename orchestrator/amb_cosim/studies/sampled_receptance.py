"""The receptance that the controller would identify, from the linear model of the loop that a run has."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from amb_actuator.interface import N_AXES
from amb_analysis.sampled_loop import held_response, identified_receptance
from amb_cosim.studies.loop import Loop, amplifiers, rotor


def sampled_receptance(loop: Loop, order: int = 1) -> NDArray[np.complex128]:
    """R of a harmonic, shape (8, 4), complex (m/N): the sampled loop with hold, PID, filter, delay and sensors as set.

    The forces are those that the controller means, K_i I with its own K_i; the bearings answer with theirs.

    Raises
    ------
    ValueError
        If the rotor has not the four sensor planes and two bearings of the loop.
    """
    plant = rotor(loop, loop.rotor.planes.sensors) * amplifiers(loop)
    k_i = np.array([loop.of_axis("rolac_controller", axis, "k_i") for axis in range(N_AXES)])
    omega = order * loop.Omega
    held = held_response(plant.A, plant.B, plant.C, omega, loop.sample_time)
    return identified_receptance(held / k_i, omega, loop.parameters["rolac_controller"])
