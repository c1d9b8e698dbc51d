"""Receptance that the controller would identify, from the linear model of the loop."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from amb_cosim.design.sampled_loop import identified_receptance, zoh_response
from amb_cosim.studies.linear_loop import LinearLoop, amplifier_system, rotor_system


def sampled_receptance(loop: LinearLoop, order: int = 1) -> NDArray[np.complex128]:
    """Return R of a harmonic, shape (n_sensors, n_axes), complex (m/N), of the loop with hold, PID, chain and sensors.

    The forces are those that the controller assumes, K_i I with its own K_i; the bearings have theirs.

    Raises
    ------
    ValueError
        If a bearing of the rotor has no sensor plane.
    """
    plant = rotor_system(loop) * amplifier_system(loop)
    k_i = np.array([loop.of_axis("rolac_controller", axis, "k_i") for axis in range(len(loop.axes))])
    omega = order * loop.Omega
    plant_response = zoh_response(plant.A, plant.B, plant.C, omega, loop.sample_time)
    return identified_receptance(loop.controlled, plant_response / k_i, omega, loop.parameters["rolac_controller"])
