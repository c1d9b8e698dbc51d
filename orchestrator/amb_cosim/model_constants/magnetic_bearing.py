"""Force of a bearing axis without a simulation: constants, static current and linearisation.

The functions take the parameters of one axis as a record, like the kernels of the actuator; `axis_parameters` returns
such a record.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from amb_actuator.force import (
    Coils,
    current_stiffness,
    force,
    least_and_most,
    limited_current,
    negative_stiffness,
    nonlinear_force,
    pull,
)
from amb_actuator.interface import LINEAR, MEASURED, NONLINEAR, axes_of, interface_of
from amb_actuator.records import AXIS
from array_types import Array, Bools
from fmi_export.variables import Variable


class Linearisation(NamedTuple):
    """Force in excess of the static load (N), K_s = dF/dx (N/m) and K_i = dF/dI_c (N/A), arrays of the same shape."""

    force: Array
    k_s: Array
    k_i: Array


def axis_parameters(bearing: str = "mb1", axis: str = "x", **changes: float) -> np.record:
    """Return the parameters of an axis as a record: the start values of the actuator's interface with `changes`.

    Parameters
    ----------
    bearing, axis
        Name of the bearing (`mb1` and `mb2` have measured constants), and `x`, `y` or, for a thrust magnet, `z`.
    changes
        Values that replace start values, by name without bearing and axis, for example `bias_current=4.3`.

    Raises
    ------
    ValueError
        If there is no such axis or parameter, a value is outside its range, or the coils cannot carry the bias.
    """
    axes = [a for _, a in axes_of([bearing], bearing)]
    if axis not in axes:
        raise ValueError(f"no axis {bearing}.{axis}; there are {', '.join(f'{bearing}.{a}' for a in axes)}")
    variables = _variables_of(bearing, axis)
    for name, value in changes.items():
        if name not in variables:
            raise ValueError(f"no parameter {name!r}; there are {', '.join(variables)}")
        if not variables[name].minimum <= value <= variables[name].maximum:
            raise ValueError(variables[name].describe_range(value))
    p: np.record = np.array([tuple(changes.get(name, v.start) for name, v in variables.items())], dtype=AXIS)[0]
    currents, (least, most) = (p.bias_current, p.static_current + p.bias_current), coil_range(p)
    if min(currents) < least or max(currents) > most:
        raise ValueError(
            f"bias_current = {p.bias_current:g} A plus static_current = {p.static_current:g} A is not allowed; "
            f"bias_current and the sum must both be >= {least:g} A and <= {most:g} A"
        )
    return p


@lru_cache(maxsize=64)
def _variables_of(bearing: str, axis: str) -> dict[str, Variable]:
    """Return the parameters of an axis by their names without bearing and axis; do not modify them."""
    table = interface_of([bearing], bearing)
    return {name: table[f"{bearing}.{name}_{axis}"] for name in AXIS.names or ()}


def linear_constants(p: np.record) -> tuple[float, float]:
    """Return K_s (N/m) and K_i (N/A) of the linear law from the geometry of an axis     (2.8, 2.9)."""
    return float(negative_stiffness(p)), float(current_stiffness(p))


def operating_constants(p: np.record, law: int) -> tuple[float, float]:
    """Return K_s (N/m) and K_i (N/A) at the operating point of an axis, for a force law of the actuator."""
    if law == MEASURED:
        return float(p.k_s_measured), float(p.k_i_measured)
    if law == LINEAR:
        return linear_constants(p)
    at_rest = linearisation(p)
    return float(at_rest.k_s), float(at_rest.k_i)


def static_current_for(load: float, p: np.record, law: int = NONLINEAR) -> float:
    """Return the static current I_s (A) of a centred axis that carries a static load under a force law.

    The current satisfies P(I_s + I_b) - P(I_b) = load; under the linear law, P has no saturation. Under the measured
    law, the current satisfies K_i/2 I_s = load.

    Parameters
    ----------
    load
        Force F_0 of the axis on the rotor (N), positive towards positive displacements.
    p
        Parameters of the axis; its static current is ignored.
    law
        `force_law` of the actuator.

    Raises
    ------
    ValueError
        If the coils cannot carry the load.
    """

    def excess(static: float) -> float:
        q = p.copy()
        q.static_current = static
        return force(law, q, 0.0, Coils(0.0, 0.0, 1.0, 1.0), True)[0] - load

    least, most = (float(current - p.bias_current) for current in coil_range(p))
    low, high = excess(least), excess(most)
    if not low <= 0.0 <= high:
        raise ValueError(f"load = {load:g} N is not allowed; it must be >= {low + load:g} N and <= {high + load:g} N")
    return float(brentq(excess, least, most, xtol=1e-13)) if load != 0.0 else 0.0


def coil_range(p: np.record) -> tuple[float, float]:
    """Return the smallest and the largest current (A) of a coil pair, including the effect of its permanent magnets."""
    least, most = least_and_most(p.current_limit, p.permanent_bias)
    return float(least), float(most)


def current_range(p: np.record) -> tuple[float, float]:
    """Return the smallest and the largest control current (A) that both coil pairs can carry."""
    low, high = (
        limited_current(sign * math.inf, p.bias_current, p.static_current, p.current_limit, p.permanent_bias)
        for sign in (-1.0, 1.0)
    )
    return float(low), float(high)


def linearisation(p: np.record, x: Array | float = 0.0, i_c: Array | float = 0.0) -> Linearisation:
    """Return the force of the nonlinear law (2.6) with saturation, and its slopes K_s and K_i, at operating points.

    Parameters
    ----------
    p
        Parameters of the axis.
    x, i_c
        Displacements (m) and control currents (A), whose shapes can be broadcast together.

    Raises
    ------
    ValueError
        If a displacement is outside the air gap or a current outside the limits of the coils.
    """
    x_all, i_all = np.broadcast_arrays(np.asarray(x, dtype=np.float64), np.asarray(i_c, dtype=np.float64))
    low, high = current_range(p)
    _check("x", x_all, ~(np.abs(x_all) < p.gap), "m", f"> {-p.gap:g} m and < {p.gap:g} m")
    slack = 1e-12 * p.current_limit  # both limits are sums and differences of currents
    outside = ~((low - slack <= i_all) & (i_all <= high + slack))
    _check("i_c", i_all, outside, "A", f">= {low:g} A and <= {high:g} A")
    rows = np.empty((x_all.size, 3))
    for row, x_k, i_k in zip(rows, x_all.flat, i_all.flat, strict=True):
        row[:2] = nonlinear_force(p, x_k, Coils(i_k, i_k, 1.0, 1.0))
        upper = pull(p, p.static_current + p.bias_current + i_k, p.gap - x_k)
        lower = pull(p, p.bias_current - i_k, p.gap + x_k)
        row[2] = upper.per_current + lower.per_current
    return Linearisation(*(column.reshape(x_all.shape) for column in rows.T))


def _check(name: str, values: Array, outside: Bools, unit: str, allowed: str) -> None:
    if outside.any():
        raise ValueError(f"{name} = {values[outside].flat[0]:g} {unit} is not allowed; it must be {allowed}")
