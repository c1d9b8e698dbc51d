"""Receptance that the controller would identify, from the linear model of the loop."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from amb_cosim.design.sampled_loop import identified_receptance, zoh_response
from amb_cosim.linear.linearisable import of_prepared
from amb_cosim.linear.linearise import model_of
from amb_cosim.results.places import ACTUATOR, CONTROLLER, PLANT
from amb_cosim.scenario.simulation import Prepared
from amb_cosim.studies.machine import machine_of


def sampled_receptance(prepared: Prepared, order: int = 1) -> NDArray[np.complex128]:
    """Return R of a harmonic, shape (n_sensors, n_axes), complex (m/N), of the loop with hold, PID, chain and sensors.

    The forces are those that the controller assumes, K_i I with its own K_i; the bearings have theirs.

    Raises
    ------
    ValueError
        If a bearing of the rotor has no sensor plane.
    """
    machine = machine_of(prepared, CONTROLLER)
    axes, sensors = machine.controlled.axes, machine.controlled.sensor_names
    currents = [f"{ACTUATOR}.{axis.bearing}.i_{axis.direction}" for axis in axes]
    shown = [f"{PLANT}.{sensor}" for sensor in sensors]
    plant = model_of(of_prepared(prepared), currents, shown, components=(PLANT, ACTUATOR))
    parameters = machine.parameters[CONTROLLER]
    k_i = np.array([parameters[f"{axis.bearing}.k_i_{axis.direction}"] for axis in axes])
    omega = order * machine.Omega
    response = zoh_response(plant.A, plant.B, plant.C, omega, parameters["sample_time"])
    return identified_receptance(machine.controlled, response / k_i, omega, parameters)
