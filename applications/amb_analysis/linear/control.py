"""Linear models of the sampled controllers, from the constants and parameters of their FMUs.

    signals -> scale -> anti-aliasing filter -> law -> whole samples of delay -> demands (-> a share of a sample later)

The noise and the converters of the signal chain, the limits and the anti-windup are not included, because they are
nonlinear.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from amb_analysis.linear.components import LinearComponent, names_of
from amb_analysis.linear.sampled_loop import axis_matrix, parameters_of_loop
from amb_cosim.controllers.laws import Law, delayed, in_series, side_by_side, static
from array_types import Array
from linear_controller.matrices import find_bracket, matrices_of, sizes_of
from rolac_controller.control_loop import ControlLoop, SensorPlane
from rolac_controller.pid import damping, setpoint_stiffness, stiffness
from signal_chain.lowpass import coefficients
from signal_chain.presets import is_on

NOTE = "limits, noise, converters and faults are not included"


def pid_component(name: str, layout: Mapping[str, Any], parameters: Mapping[str, float]) -> LinearComponent:
    """Return the PID law (5.1 to 5.4) from displacements at all sensors and setpoints (m) to demanded currents (A).

    I = -[k x - k_set x_set + c (z - 1)/((tau + T) z - tau) x + K_I T/(z - 1) (x - x_set)] / K_i

    Parameters
    ----------
    name
        Name of the component.
    layout, parameters
        Layout and parameters of the model `rolac_controller`; its synchronous control is not included.
    """
    loop = _control_loop(layout)
    values = parameters_of_loop(loop, parameters)
    common = values.common[0]
    time, tau, direct = float(common.sample_time), float(common.derivative_time), common.pid.direct
    laws = []
    for gains in values.axes:
        k, c, k_set = (float(f(gains, direct)) for f in (stiffness, damping, setpoint_stiffness))
        integral, k_i, b = float(gains.k_integral), float(gains.k_i), 1.0 / (tau + time)
        A = np.array([[tau * b, -b, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 1.0]])  # derivative, x before, integral
        B = np.array([[b, 0.0], [1.0, 0.0], [time * integral, -time * integral]])
        C = -np.array([[c * tau * b, -c * b, 1.0]]) / k_i
        used = [j for j, is_used in enumerate((c != 0.0 and tau != 0.0, c != 0.0, integral != 0.0)) if is_used]
        laws.append(Law(A[np.ix_(used, used)], B[used], C[:, used], -np.array([[k + c * b, -k_set]]) / k_i))
    n, sensors = len(laws), len(loop.sensors)
    order = np.kron(np.eye(n), [[1.0], [0.0]]), np.kron(np.eye(n), [[0.0], [1.0]])  # of each law's two columns
    scaled = static(np.hstack([order[0] @ axis_matrix(values), order[1]]))
    chain = in_series(scaled, _filtered(common, 2 * n, range(0, 2 * n, 2)))
    law = in_series(
        in_series(chain, side_by_side(laws)), delayed(n, int(is_on(common.chain.preset, common.chain.delay)))
    )
    inputs = [*loop.sensor_names, *(f"{axis.bearing}.set_{axis.direction}" for axis in loop.axes)]
    outputs = [f"{axis.bearing}.i_{axis.direction}" for axis in loop.axes]
    assert law.D.shape == (n, sensors + n)
    excluded = "synchronous control, prediction_time" if common.prediction_time > 0.0 else "synchronous control"
    return _part(name, law, time, inputs, outputs, f"{excluded}, {NOTE}")


def law_component(
    name: str, layout: Mapping[str, Any], constants: Array, parameters: Mapping[str, float], Omega: float
) -> LinearComponent:
    """Return the model `linear_controller` at a speed, from signals, setpoints (m) and feedforward (A) to demands (A).

    u = gain (C x + D e) + feedforward, e = F scale y - setpoint

    Parameters
    ----------
    name
        Name of the component.
    layout, constants, parameters
        Layout, constants and parameters of the model.
    Omega
        Spin speed (rad/s), at which the matrices are interpolated.
    """
    matrices = law_at(constants, Omega)
    signals, demands = list(layout["signals"]), list(layout["demands"])
    p, m, time = len(demands), len(signals), parameters["sample_time"]
    gains = np.array([parameters[f"{demand}.gain"] for demand in demands])
    matrices = Law(matrices.A, matrices.B, gains[:, None] * matrices.C, gains[:, None] * matrices.D)
    scale = static(np.diag([parameters[f"{signal}.scale"] for signal in signals]))
    preset = parameters["chain.preset"]
    measured = scale
    if is_on(preset, parameters["chain.filter"]):
        measured = in_series(scale, side_by_side([_filter(parameters["chain.cutoff"], time)] * m))
    errors = side_by_side([measured, static(-np.eye(m)), static(np.eye(p))])
    to_law = static(np.block([[np.eye(m), np.eye(m), np.zeros((m, p))], [np.zeros((p, 2 * m)), np.eye(p)]]))
    summed = in_series(side_by_side([matrices, static(np.eye(p))]), static(np.hstack([np.eye(p), np.eye(p)])))
    late = parameters["delay"] + float(is_on(preset, parameters["chain.delay"]))
    law = in_series(in_series(in_series(errors, to_law), summed), delayed(p, math.floor(late)))
    inputs = [*signals, *(f"{s}.setpoint" for s in signals), *(f"{d}.feedforward" for d in demands)]
    return _part(name, law, time, inputs, demands, NOTE, late - math.floor(late))


def law_at(constants: Array, Omega: float) -> Law:
    """Return the matrices of a `linear_controller` at a speed (rad/s), in the controller's own coordinates."""
    sizes, matrices = sizes_of(constants), matrices_of(constants)
    n, m, p = sizes
    bracket = find_bracket(matrices.speeds, Omega)
    M = np.zeros((n + p, n + m))
    for row, weight in ((bracket.lower, 1.0 - bracket.weight), (bracket.upper, bracket.weight)):
        for block in matrices.law:
            start, rows, columns = int(block.start), int(block.n_rows), int(block.n_columns)
            values = matrices.values[row, start : start + rows * columns].reshape(columns, rows).T
            at = slice(int(block.row), int(block.row) + rows), slice(int(block.column), int(block.column) + columns)
            M[at] += weight * values
    return Law(M[:n, :n], M[:n, n:], M[n:, :n], M[n:, n:])


def _filter(cutoff: float, sample_time: float) -> Law:
    """Return the anti-aliasing filter (`signal_chain.lowpass`), whose states are the previous output and input."""
    E, P = coefficients(cutoff, sample_time)
    row = np.array([[E, 1.0 - E - P]])
    return Law(np.vstack([row, np.zeros((1, 2))]), np.array([[P], [1.0]]), row, np.array([[P]]))


def _filtered(p: np.record, count: int, filtered: Sequence[int]) -> Law:
    """Return the law that passes `count` signals, and filters those in `filtered` if the controller's filter is on."""
    if not is_on(p.chain.preset, p.chain.filter):
        return static(np.eye(count))
    lowpass = _filter(float(p.chain.cutoff), float(p.sample_time))
    return side_by_side([lowpass if k in filtered else static(np.eye(1)) for k in range(count)])


def _control_loop(layout: Mapping[str, Any]) -> ControlLoop:
    planes = tuple(SensorPlane(**plane) for plane in layout["planes"])
    return ControlLoop(tuple(layout["bearings"]), planes, tuple(layout["feedback"]))


def _part(
    name: str, law: Law, time: float, inputs: Sequence[str], outputs: Sequence[str], note: str, late: float = 0.0
) -> LinearComponent:
    whole = Law(law.A, law.B, law.C, law.D, time)
    notes = [f"{name}: {note}"]
    if late > 0.0:
        notes.append(f"{name}: a delay of {late:g} samples applies only to demands that reach the amplifiers")
    return LinearComponent(whole, names_of(name, inputs), names_of(name, outputs), late, tuple(notes))
