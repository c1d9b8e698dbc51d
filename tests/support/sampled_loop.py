"""The synchronous receptance that the controller identifies on a given plant: the sampled closed loop in z.

    U --(+)--> D --> hold, plant P --> rotor --> sensors F --+--> Q = R U        R = F (I + P D C S F)^-1 P D
         ^-                                                  |
         +------------------- C S <-------------------------+

P is the plant's response from held forces to the displacements of the sensors, F the response of sensors (scale,
offset) and filter, S picks the sensor of each axis, C is the PID (`pid.response`) and D = 1/z the delay; all at
z = exp(j omega h).
"""

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import expm

from amb_analysis.linear.sampled_loop import parameters_of_loop, sensor_response
from array_types import Complex
from rolac_controller.control_loop import ControlLoop
from rolac_controller.pid import response
from rolac_controller.records import Parameters
from signal_chain.presets import is_on


def zoh_response(a: ArrayLike, b: ArrayLike, c: ArrayLike, omega: float, sample_time: float) -> Complex:
    """Return the response P of x' = A x + B u, y = C x at omega (rad/s), with u held over each sample (s).

    P = C (z I - Phi)^-1 Gamma, shape (p, m). For a rotor in magnetic bearings A holds their negative stiffness K_s, and
    u is the force K_i I.
    """
    A, B, C = (np.atleast_2d(np.asarray(matrix, dtype=np.float64)) for matrix in (a, b, c))
    n, m = B.shape
    block = np.zeros((n + m, n + m))
    block[:n, :n], block[:n, n:] = A, B
    sampled = expm(block * sample_time)
    z = np.exp(1j * omega * sample_time)
    return np.asarray(C @ np.linalg.solve(z * np.eye(n) - sampled[:n, :n], sampled[:n, n:]), dtype=np.complex128)


def controller_response(parameters: Parameters, omega: float) -> Complex:
    """Return C S of the PID at omega (rad/s), shape (n_axes, n_sensors) (N/m): its force is -C S q for a measured q."""
    local = parameters.common[0]
    force = np.zeros((len(parameters.axes), len(parameters.sensor_scales)), dtype=np.complex128)
    for axis, sensor in enumerate(parameters.sensor_of_axis):
        gains = parameters.axes[axis]
        force[axis, int(sensor)] = response(gains, local.pid.direct, local.derivative_time, local.sample_time, omega)
    return force


def identified_receptance(
    loop: ControlLoop, plant: ArrayLike, omega: float, parameters: Mapping[str, float] | None = None
) -> Complex:
    """Return the receptance R (m/N) that the controller identifies on a plant P (m/N), both of (n_sensors, n_axes).

    `omega` (rad/s) is that of the harmonic, and `parameters` are those of the FMU that differ from their start values.
    """
    p: Complex = np.asarray(plant, dtype=np.complex128)
    values = parameters_of_loop(loop, parameters or {})
    local = values.common[0]
    if is_on(local.chain.preset, local.chain.delay):
        p = p * np.exp(-1j * omega * local.sample_time)
    F = sensor_response(values, omega)
    closed = np.eye(len(p)) + p @ controller_response(values, omega) @ F
    return np.asarray(F @ np.linalg.solve(closed, p), dtype=np.complex128)
