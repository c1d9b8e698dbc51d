"""Motion of the rotor along its shaft, as a rigid body, under forces that are constant or proportional to z in a step.

With the mass m, the force f of the bearing at z_ref and its gradient k, another force p, and gravity g at the tilt b,

    m z'' = f + k (z - z_ref) + p - m g sin(b)                                     (1)

With w = k/m and the acceleration a at the beginning, the motion after a time t is

    z(t) = z + v S + a C,    v(t) = v + (w v) C + a S                                 (2)
    S = sinh(sqrt(w) t)/sqrt(w),    C = (cosh(sqrt(w) t) - 1)/w

with sine and cosine for w < 0: a gradient k > 0 pushes the rotor away, as a magnet does. The work of all forces is that
of the force at the beginning, and half the gradient times the square of the way. z couples to the lateral motion by
neither bearings nor mass, so it is no row of that motion.
"""

from __future__ import annotations

import math

import numpy as np

from fmi_export.jit import kernel
from fmi_export.records import record

AXIAL = record(("z", np.float64), ("speed", np.float64))  # m, m/s
SHORT = 1e-2  # of |w| t^2, below which S and C are series


@kernel
def move_along(
    mass: float, gravity: float, parameters: np.record, inputs: np.record, motion: np.record, t: float
) -> float:
    """Move a rotor (kg) along its shaft over a time t (s); return the work of all forces (J).

    `gravity` is in m/s^2; records of types `AXIAL_PARAMETERS`, `AXIAL_INPUTS` and `AXIAL`.
    """
    gradient: float = inputs.gradient
    weight = mass * gravity * math.sin(parameters.tilt)
    force = inputs.force + gradient * (motion.z - inputs.reference) + inputs.f_process - weight
    z, speed = moved_along(motion.z, motion.speed, force / mass, gradient / mass, t)
    way = z - motion.z
    motion.z, motion.speed = z, speed
    work: float = (force + 0.5 * gradient * way) * way
    return work


@kernel
def moved_along(z: float, speed: float, acceleration: float, w: float, t: float) -> tuple[float, float]:
    """Return z (m) and its velocity (m/s) after a time t (s), by (2); `w` (1/s^2) is the gradient over the mass."""
    S, C = _responses(w, t)
    return z + speed * S + acceleration * C, speed + w * speed * C + acceleration * S


@kernel
def _responses(w: float, t: float) -> tuple[float, float]:
    """Return S (s) and C (s^2)."""
    x = w * t * t
    if abs(x) < SHORT:
        S = t * (1.0 + x / 6.0 * (1.0 + x / 20.0 * (1.0 + x / 42.0 * (1.0 + x / 72.0))))
        C = 0.5 * t * t * (1.0 + x / 12.0 * (1.0 + x / 30.0 * (1.0 + x / 56.0 * (1.0 + x / 90.0))))
        return S, C
    rate = math.sqrt(abs(w))
    half = 0.5 * rate * t
    s, c = (math.sinh(half), math.cosh(half)) if w > 0.0 else (math.sin(half), math.cos(half))
    return 2.0 * s * c / rate, 2.0 * s * s / abs(w)
