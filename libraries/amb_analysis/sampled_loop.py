"""The synchronous receptance that the controller would identify, from a model of the plant: the sampled loop in z.

    U --(+)--> D --> hold, plant P --> rotor --> sensors F --+--> Q = R U        R = F (I + P D C S F)^-1 P D
         ^-                                                  |
         +------------------- C S <-------------------------+

P is the plant's response from held forces to the displacements of s1 to s8, F what scale, offset and filter make of
them, S picks the sensor of each axis, C is the PID (`pid.response`) and D = 1/z the delay; all at z = exp(j omega h).
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import expm

from rolac_controller.chain import is_on
from rolac_controller.interface import INTERFACE, PARAMETERS
from rolac_controller.lowpass import coefficients
from rolac_controller.pid import response
from rolac_controller.rig_layout import N_AXES, N_PLANES, N_SENSORS, SENSOR_OF_AXIS
from rolac_controller.sensors import plane_weight

Complex = NDArray[np.complex128]
Array = NDArray[np.float64]


def parameter_record(parameters: Mapping[str, float]) -> np.record:
    """Return the parameters as kernels see them, record PARAMETERS: start values, and what is given by name.

    Raises
    ------
    ValueError
        If there is no such parameter.
    """
    values: Array = INTERFACE.start[: INTERFACE.n_parameters].copy()
    for name, value in parameters.items():
        values[INTERFACE.parameter_index(name)] = value
    record: np.record = values.view(PARAMETERS)[0]
    return record


def held_response(a: ArrayLike, b: ArrayLike, c: ArrayLike, omega: float, sample_time: float) -> Complex:
    """Response P of x' = A x + B u, y = C x at omega, with u held over each sample: C (z I - Phi)^-1 Gamma.

    Parameters
    ----------
    a, b, c
        Shapes (n, n), (n, m), (p, n). For a rotor in magnetic bearings A holds their negative stiffness K_s, and u
        is the force K_i I.
    omega
        Frequency (rad/s).
    sample_time
        h (s).

    Returns
    -------
    array, shape (p, m), complex
    """
    A, B, C = (np.atleast_2d(np.asarray(matrix, dtype=np.float64)) for matrix in (a, b, c))
    n, m = B.shape
    block = np.zeros((n + m, n + m))
    block[:n, :n], block[:n, n:] = A, B
    sampled = expm(block * sample_time)
    z = np.exp(1j * omega * sample_time)
    return np.asarray(C @ np.linalg.solve(z * np.eye(n) - sampled[:n, :n], sampled[:n, n:]), dtype=np.complex128)


def filter_response(cutoff: float, omega: float, sample_time: float) -> complex:
    """Response of the anti-aliasing filter to samples of a vibration at omega (rad/s)."""
    decay, new = coefficients(cutoff, sample_time)
    z = np.exp(1j * omega * sample_time)
    return complex((1.0 - decay - new + new * z) / (z - decay))


def sensor_response(parameters: np.record, omega: float) -> Complex:
    """F: what the controller measures of a vibration at omega (rad/s), shape (8, 8)."""
    weights = np.array([[plane_weight(parameters, p, q) for q in range(N_PLANES)] for p in range(N_PLANES)])
    mixed = parameters.sensor_scales[:, np.newaxis] * np.kron(weights, np.eye(2))
    passed = 1.0 + 0j
    if is_on(parameters.chain.preset, parameters.chain.filter):
        passed = filter_response(parameters.chain.cutoff, omega, parameters.sample_time)
    return np.asarray(mixed * passed, dtype=np.complex128)


def controller_response(parameters: np.record, omega: float) -> Complex:
    """C S: force -C S q that the PID answers a measured vibration at omega (rad/s) with, shape (4, 8) (N/m)."""
    force = np.zeros((N_AXES, N_SENSORS), dtype=np.complex128)
    direct, tau, h = parameters.pid.direct, parameters.derivative_time, parameters.sample_time
    for axis in range(N_AXES):
        force[axis, SENSOR_OF_AXIS[axis]] = response(parameters.axes[axis], direct, tau, h, omega)
    return force


def identified_receptance(plant: ArrayLike, omega: float, parameters: Mapping[str, float] | None = None) -> Complex:
    """Receptance R that the controller identifies on a linear plant: R = F (I + P D C S F)^-1 P D.

    Parameters
    ----------
    plant
        P at omega, shape (8, 4), complex (m/N); see `held_response`.
    omega
        Frequency of the harmonic, n Omega (rad/s).
    parameters
        Parameters of the FMU that differ from their start values, by name.

    Returns
    -------
    array, shape (8, 4), complex
        m/N.

    Raises
    ------
    ValueError
        If the shape is wrong or a parameter does not exist.
    """
    p: Complex = np.asarray(plant, dtype=np.complex128)
    if p.shape != (N_SENSORS, N_AXES):
        raise ValueError(f"plant of shape {p.shape} is not allowed; it must be ({N_SENSORS}, {N_AXES})")
    values = parameter_record(parameters or {})
    if is_on(values.chain.preset, values.chain.delay):
        p = p * np.exp(-1j * omega * values.sample_time)
    F = sensor_response(values, omega)
    loop = np.eye(N_SENSORS) + p @ controller_response(values, omega) @ F
    return np.asarray(F @ np.linalg.solve(loop, p), dtype=np.complex128)
