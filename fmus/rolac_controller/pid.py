"""Sampled PID of a bearing axis (thesis 5.1 to 5.4); docs/theory/controller.md gives its equations.

K_s cancels the bearing's negative stiffness, so that the controlled bearing has the net stiffness K_b and the damping
C_b. `k_s` and `k_i` are constants of the bearing (N/m, N/A); `k_integral` is the gain of the integral.
"""

from __future__ import annotations

import numpy as np

from fmi_export.jit import kernel
from fmi_export.records import record
from rolac_controller.complex_numbers import phasor, quotient, scaled, squared_magnitude
from signal_chain.demands import Limits

PID_MEMORY = record(
    ("integral", "f8"),  # K_I integral(x - x_set) (N), so that a change of K_I causes no bump
    ("displacement", "f8"),  # m
    ("derivative", "f8"),  # m/s
)


@kernel
def stiffness(gains: np.record, direct: float) -> float:
    """Return the restoring force per displacement (N/m): k_p if `direct`, otherwise K_b + K_s."""
    k: float = gains.k_p if direct else gains.k_b + gains.k_s
    return k


@kernel
def setpoint_stiffness(gains: np.record, direct: float) -> float:
    """Return the force per setpoint, towards the setpoint (N/m): k_p if `direct`, otherwise K_b."""
    k: float = gains.k_p if direct else gains.k_b
    return k


@kernel
def damping(gains: np.record, direct: float) -> float:
    """Return the opposing force per velocity (N s/m): k_d if `direct`, otherwise C_b."""
    c: float = gains.k_d if direct else gains.c_b
    return c


@kernel
def differentiate(memory: np.record, x: float, filter_time: float, sample_time: float) -> None:
    """Update the displacement's derivative, a backward difference with a first-order filter.

    The derivative is d_n = (tau d_(n-1) + x_n - x_(n-1)) / (tau + h), which is the plain backward difference if tau =
    0.

    Parameters
    ----------
    memory
        Record PID_MEMORY of the axis; changed.
    x
        Displacement (m).
    filter_time, sample_time
        Filter time tau and sample time h (s).
    """
    change = x - memory.displacement
    memory.derivative = (filter_time * memory.derivative + change) / (filter_time + sample_time)
    memory.displacement = x


@kernel
def pid_current(gains: np.record, direct: float, memory: np.record, setpoint: float) -> float:
    """Return the demanded current I_pid (A), without limits (5.1 to 5.4).

    Parameters
    ----------
    gains
        Record GAINS of the axis.
    direct
        The parameter `pid.direct`: whether k_p and k_d are used instead of K_b + K_s and C_b.
    memory
        Record PID_MEMORY of the axis.
    setpoint
        Setpoint x_set of the displacement (m).
    """
    proportional = stiffness(gains, direct) * memory.displacement - setpoint_stiffness(gains, direct) * setpoint
    force = proportional + damping(gains, direct) * memory.derivative + memory.integral
    current: float = -force / gains.k_i
    return current


@kernel
def limit_and_integrate(
    gains: np.record, memory: np.record, setpoint: float, demand: float, limits: Limits, sample_time: float
) -> float:
    """Return the limited demand (A); integrate the error unless this moves the demand further beyond its limit."""
    error = memory.displacement - setpoint
    winds_up = (demand > limits.high and error < 0.0) or (demand < limits.low and error > 0.0)
    if not winds_up:
        memory.integral += sample_time * gains.k_integral * error
    current: float = min(max(demand, limits.low), limits.high)
    return current


@kernel
def response(gains: np.record, direct: float, filter_time: float, sample_time: float, omega: float) -> complex:
    """Return C (N/m) in K_i I_pid = -C x for a sampled vibration at omega (rad/s).

    C = k + c D + K_I J with z = exp(j omega h), D = (1 - 1/z) / (tau + h - tau/z), J = h / (z - 1).
    """
    z = phasor(omega * sample_time)
    one_minus_inverse = complex(1.0 - z.real, z.imag)  # 1 - 1/z, and |z| = 1
    below = sample_time + scaled(one_minus_inverse, filter_time)
    C = stiffness(gains, direct) + scaled(
        one_minus_inverse * below.conjugate(), damping(gains, direct) / squared_magnitude(below)
    )
    if gains.k_integral != 0.0:
        C += quotient(complex(gains.k_integral * sample_time, 0.0), z - 1.0)
    return C
