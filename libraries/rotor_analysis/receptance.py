"""Synchronous receptance of the levitated rotor, from which the matrix H of the controller is computed."""

from __future__ import annotations

import numpy as np

from array_types import Array, Complex
from rotor_analysis.response import dynamic_stiffness
from rotor_analysis.rotor import Rotor
from rotor_analysis.rotor_file import load_rotor
from rotor_analysis.supported_rotor import supported_plant


def receptance(speeds: Array, k_b: float = 1e6, c_b: float = 5000.0, rotor: Rotor | None = None) -> Complex:
    """Return the complex receptance R of the reduced rotor at synchronous frequency: Q = Q_0 + R U (5.6).

    R = S [-Omega^2 M + j Omega (C + Omega G) + K]^-1 B, with q = Re[Q exp(j theta)], u = Re[U exp(j theta)]

    Parameters
    ----------
    speeds
        Spin speeds Omega (rad/s), shape (n,).
    k_b, c_b
        Net stiffness (N/m) and damping (N s/m) of both bearings under PID control.
    rotor
        A rotor description; by default the packs' default rotor.

    Returns ------- array, shape (n, 8, 4), complex m/N; rows are sensors, columns are forces along x and y of each
    bearing.
    """
    rotor = (rotor or load_rotor()).on_equal_bearings(k_b, c_b)
    rotor_model = supported_plant(rotor)
    sensors = rotor_model.displacement_of(rotor.sensor_nodes)
    B = rotor_model.force_at(rotor.bearing_nodes)
    return np.array([sensors @ np.linalg.solve(dynamic_stiffness(rotor_model.model, Omega), B) for Omega in speeds])
