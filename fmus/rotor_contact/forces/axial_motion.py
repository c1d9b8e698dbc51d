"""Motion of the rotor along its shaft, as a rigid body, under forces that are constant or proportional to z in a step.

With the mass m, the force f of the bearing at z_ref and the gradient k of this force, another force p, gravity g at the
tilt b, and the acceleration a of the base, relative to which z is measured,

    m z'' = f + k (z - z_ref) + p - m (g sin(b) + a)                              (1)

With w = k/m, the acceleration a at the beginning, and the ratio c of the faces' damping to the mass, the motion after a
time t is

    z(t) = z + v S + a C_2,    v(t) = v S' + a S,    S'' + c S' - w S = 0,  S(0) = 0,  S'(0) = 1         (2)

where C_2 is the integral of S. A force with a gradient k > 0, such as a magnet's, drives the rotor away from
equilibrium. The work of all forces is the work of the initial force, plus half the gradient times the square of the
distance. Neither bearings nor mass couple z to the lateral motion, so z is not among the degrees of freedom of that
motion.
"""

from __future__ import annotations

import math

import numpy as np

from fmi_export.jit import kernel
from fmi_export.records import record

AXIAL = record(("z", np.float64), ("speed", np.float64))  # m, m/s
SHORT = 0.5  # of |w| t^2 + c t, below which S is a series
N_TERMS = 19


@kernel
def force_along(mass: float, gravity: float, parameters: np.record, inputs: np.record, z: float) -> float:
    """Return the force (N) of (1) on a rotor of this mass (kg) at z (m).

    `gravity` is in m/s^2; `parameters` and `inputs` are records of the types `AXIAL_PARAMETERS` and `AXIAL_INPUTS`.
    """
    weight = mass * (gravity * math.sin(parameters.tilt) + inputs.base_acceleration)
    force: float = inputs.force + inputs.gradient * (z - inputs.reference) + inputs.f_process - weight
    return force


@kernel
def move_along(
    mass: float, gravity: float, parameters: np.record, inputs: np.record, motion: np.record, t: float
) -> float:
    """Move a rotor with an `AXIAL` motion along its shaft for a time t (s); return the work (J) of all forces."""
    gradient: float = inputs.gradient
    force = force_along(mass, gravity, parameters, inputs, motion.z)
    z, speed = moved_along(motion.z, motion.speed, force / mass, gradient / mass, t)
    way = z - motion.z
    motion.z, motion.speed = z, speed
    work: float = (force + 0.5 * gradient * way) * way
    return work


@kernel
def moved_along(z: float, speed: float, acceleration: float, w: float, t: float) -> tuple[float, float]:
    """Return z (m) and its velocity (m/s) after a time t (s), by (2); `w` (1/s^2) is gradient/mass."""
    rate, S, C_2, _ = responses(w, 0.0, t)
    return z + speed * S + acceleration * C_2, speed * rate + acceleration * S


@kernel
def responses(w: float, c: float, t: float) -> tuple[float, float, float, float]:
    """Return the functions of (2) after a time t (s): S', S (s), C_2 (s^2) and the integral of C_2 (s^3)."""
    if abs(w) * t * t + c * t < SHORT:
        before, term = 0.0, 1.0  # coefficients of t^(k - 1) in S, times t^(k - 2)
        rate, S, C_2, C_3 = 1.0, 1.0, 0.5, 1.0 / 6.0
        for k in range(2, N_TERMS):
            before, term = term, (w * t * t * before - c * t * (k - 1.0) * term) / (k * (k - 1.0))
            rate += k * term
            S += term
            C_2 += term / (k + 1.0)
            C_3 += term / ((k + 1.0) * (k + 2.0))
        return rate, S * t, C_2 * t * t, C_3 * t * t * t
    half, square = 0.5 * c, 0.25 * c * c + w
    root = math.sqrt(abs(square))
    if root * t < 1e-6:
        S = t * math.exp(-half * t)
        mean = math.exp(-half * t)
    elif square > 0.0:
        slow, fast = math.exp((root - half) * t), math.exp((-root - half) * t)
        S, mean = 0.5 * (slow - fast) / root, 0.5 * (slow + fast)
    else:
        S, mean = math.exp(-half * t) * math.sin(root * t) / root, math.exp(-half * t) * math.cos(root * t)
    rate = mean - half * S
    C_2 = (rate + c * S - 1.0) / w
    return rate, S, C_2, (S + c * C_2 - t) / w
