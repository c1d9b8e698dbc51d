"""Linear models of the rotor and the magnetic bearings, from the constants and parameters of their FMUs."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from scipy.linalg import block_diag

from amb_actuator.eddy_currents import LAG
from amb_actuator.interface import DYNAMIC, NONLINEAR, axes_of
from amb_actuator.records import AXIS
from amb_analysis.linear.components import LinearComponent, names_of
from amb_cosim.controllers.laws import Law, in_series, side_by_side, static
from amb_cosim.model_constants.magnetic_bearing import axis_parameters, linearisation, operating_constants
from array_types import Array
from rotor_contact.shaft.seals import add_seals
from rotor_contact.shaft.structure import structure_of

Parameters = Mapping[str, float]
NEGLECTED = (
    "contact, unbalance, a free spin and the gap outputs c - |r| (without a derivative at the centre, r = 0) are not "
    "included"
)


def rotor_component(
    name: str, layout: Mapping[str, Any], constants: Array, parameters: Parameters, Omega: float
) -> LinearComponent:
    """Return the model of a rotor without contact, from forces (N) and base accelerations (m/s^2) to displacements (m).

    If the rotor has a thrust disc, its motion along the shaft obeys m z'' = f_z + f_process - m a_z.

    q'' = M^-1 (f + B_base a) - (M^-1 (K + K_b) - Omega M^-1 R J) q - (M^-1 (C + R + C_b) + Omega M^-1 G) q'

    Parameters
    ----------
    name
        Name of the component.
    layout, constants
        Layout and constants of the model `rotor_contact`. K_b and C_b contain the stiffness and damping of its passive
        bearings, and of its seals at this speed.
    parameters
        Values of the plant's parameters, by name.
    Omega
        Spin speed (rad/s).
    """
    s = structure_of(constants)
    n = len(s.K)
    K, C = s.MinvK - Omega * s.over_speed[n:], s.MinvC + Omega * s.over_speed[:n]
    bearings, at = list(layout["bearings"]), [int(row) + k for row in s.bearings for k in (0, 1)]
    for bearing, row in zip(bearings, s.bearings.astype(int), strict=True):
        for i in (row, row + 1):
            K[:, i] += s.Minv[:, i] * parameters[f"{bearing}.k_b"]
            C[:, i] += s.Minv[:, i] * parameters[f"{bearing}.c_b"]
    K_columns, C_columns = K.T.copy(), C.T.copy()
    add_seals(s.seals, Omega, K_columns, C_columns)
    K, C = K_columns.T, C_columns.T
    B = s.Minv @ np.hstack([np.eye(n)[:, at], s.B_disc.T, s.B_base.T])
    rows = [int(row) + k for row in s.sites for k in (0, 1)]
    C_q = np.vstack([np.eye(n)[at], s.sensors, np.eye(n)[rows]])
    inputs = [f"{place}.f_{a}" for place in (*bearings, *layout["discs"]) for a in "xy"] + ["base.a_x", "base.a_y"]
    outputs = [f"{bearing}.{a}" for bearing in bearings for a in "xy"]
    outputs += [plane[a] for plane in layout["sensors"] for a in "xy"]
    outputs += [f"{site['name']}.{a}" for site in layout["sites"] for a in "xy"]
    zero = np.zeros((n, n))
    law = Law(
        np.block([[zero, np.eye(n)], [-K, -C]]),
        np.vstack([np.zeros_like(B), B]),
        np.hstack([C_q, np.zeros_like(C_q)]),
        np.zeros((len(C_q), B.shape[1])),
    )
    if layout.get("thrust"):
        thrust = layout["thrust"]
        inputs += [f"{thrust}.f_z", f"{thrust}.f_process", "base.a_z"]
        outputs += [f"{thrust}.z", f"{thrust}.speed"]
        force = np.array([[1.0 / s.mass, 1.0 / s.mass, -1.0]])
        along = np.array([[0.0, 1.0], [0.0, 0.0]]), np.vstack([np.zeros((1, 3)), force]), np.eye(2), np.zeros((2, 3))
        across = law.A, law.B, law.C, law.D
        law = Law(*(block_diag(of_rotor, of_axis) for of_rotor, of_axis in zip(across, along, strict=True)))
    return _unique(law, name, inputs, outputs, NEGLECTED)


def bearing_slopes(
    bearing: str, axis: str, parameters: Parameters, x: float = 0.0, i: float = 0.0
) -> tuple[float, float]:
    """Return K_s (N/m) and K_i (N/A) of an axis at a displacement (m) and a current (A), by the actuator's force law.

    Raises
    ------
    ValueError
        If the displacement exceeds the air gap, or the current exceeds the limits of the coils.
    """
    values = {name: parameters[f"{bearing}.{name}_{axis}"] for name in AXIS.names or ()}
    p, law = axis_parameters(bearing, axis, **values), int(parameters["force_law"])
    if law == NONLINEAR and (x != 0.0 or i != 0.0):
        result = linearisation(p, x, i)
        return float(result.k_s), float(result.k_i)
    return operating_constants(p, law)


def actuator_component(
    name: str, layout: Mapping[str, Any], parameters: Parameters, point: Mapping[str, float] | None = None
) -> LinearComponent:
    """Return the model of the actuator, from displacements (m) and demands (A, V) to forces (N) and coil currents (A).

    f = K_s x + K_i i_c, i_c' = omega_b (i + g v - i_c)

    If the amplifiers are ideal, i_c = i + g v. Eddy currents, if there are any, delay the force along the shaft.

    Parameters
    ----------
    name
        Name of the component.
    layout, parameters
        Layout and parameters of the model `amb_actuator`.
    point
        Displacements and currents at the operating point, by the names of the inputs; 0 by default.
    """
    axes, at = axes_of(layout["bearings"], layout.get("thrust", "")), point or {}
    dynamic = parameters["amplifier"] == DYNAMIC
    n = len(axes)
    k_s, k_i, gain, omega = np.zeros((4, n))
    for k, (b, a) in enumerate(axes):
        k_s[k], k_i[k] = bearing_slopes(b, a, parameters, at.get(f"{b}.{a}", 0.0), at.get(f"{b}.i_{a}", 0.0))
        gain[k] = parameters[f"{b}.amplifier_gain_{a}"]
        omega[k] = 2.0 * math.pi * parameters[f"{b}.bandwidth_{a}"]
    eye, zero = np.eye(n), np.zeros((n, n))
    demanded = np.hstack([eye, zero, np.diag(gain)])  # i_c over i, x and v
    to_current = np.vstack([np.diag(k_i), eye, -eye])
    by_displacement = np.vstack([np.hstack([zero, np.diag(k_s), zero]), np.zeros((2 * n, 3 * n))])
    if dynamic:
        law = Law(-np.diag(omega), omega[:, None] * demanded, to_current, by_displacement)
    else:
        law = Law(np.zeros((0, 0)), np.zeros((0, 3 * n)), np.zeros((3 * n, 0)), by_displacement + to_current @ demanded)
    inputs = [f"{b}.{v}_{a}" if v else f"{b}.{a}" for v in ("i", "", "command_voltage") for b, a in axes]
    outputs = [f"{b}.{v}_{a}" for v in ("f", "i_upper", "i_lower") for b, a in axes]
    if corner := parameters.get(f"{layout.get('thrust', '')}.eddy_current_corner", 0.0):
        law = in_series(
            law, side_by_side([static(np.eye(n - 1)), lag_of(2.0 * math.pi * corner), static(np.eye(2 * n))])
        )
    return _unique(law, name, inputs, outputs, "faults and the limits of currents and voltages are not included")


def lag_of(omega_e: float) -> Law:
    """Return the lag of eddy currents for a corner frequency (rad/s): x_k' = p_k (u - x_k), y = sum c_k x_k."""
    poles, weights = omega_e * np.array(LAG.poles), np.array(LAG.weights)
    return Law(np.diag(-poles), poles[:, None], weights[None, :], np.zeros((1, 1)))


def _unique(law: Law, name: str, inputs: list[str], outputs: list[str], note: str) -> LinearComponent:
    """Return a part without the duplicate outputs of a sensor or retainer that has the same name as its bearing."""
    unique_outputs = list(dict.fromkeys(outputs))
    rows = [outputs.index(output) for output in unique_outputs]
    unique = Law(law.A, law.B, law.C[rows], law.D[rows], law.sample_time)
    return LinearComponent(unique, names_of(name, inputs), names_of(name, unique_outputs), notes=(f"{name}: {note}",))
