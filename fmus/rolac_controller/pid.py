"""PID of one bearing axis (thesis 5.1 to 5.4), sampled.

    I_pid = -(1/K_i) [ K_s x + K_b (x - x_set) + C_b x' + K_I integral(x - x_set) ]
    I_pid = -(1/K_i) [ k_p (x - x_set) + k_d x' + K_I integral(x - x_set) ]                  with pid.direct

K_s cancels the bearing's negative stiffness: the closed bearing has net stiffness K_b and damping C_b.
`k_s`, `k_i` are constants of the bearing (N/m, N/A); the gain of the integral is `k_integral`.
"""

from __future__ import annotations

import math

from fmi_export.jit import kernel
from fmi_export.model import Array
from rolac_controller.interface import C_B, K_B, K_D, K_I, K_INTEGRAL, K_P, K_S

N_MEMORY = 3
INTEGRAL, POSITION, DERIVATIVE = range(N_MEMORY)


@kernel
def stiffness(gains: Array, direct: bool) -> float:
    """Force against a displacement (N/m): k_p, or K_b + K_s."""
    k: float = gains[K_P] if direct else gains[K_B] + gains[K_S]
    return k


@kernel
def setpoint_stiffness(gains: Array, direct: bool) -> float:
    """Force towards a setpoint (N/m): k_p, or K_b."""
    k: float = gains[K_P] if direct else gains[K_B]
    return k


@kernel
def damping(gains: Array, direct: bool) -> float:
    """Force against a velocity (N s/m): k_d, or C_b."""
    c: float = gains[K_D] if direct else gains[C_B]
    return c


@kernel
def differentiate(memory: Array, x: float, filter_time: float, sample_time: float) -> None:
    """Derivative of the displacement, first-order filtered, by backward differences; stored in `memory`.

    d_n = (tau d_(n-1) + x_n - x_(n-1)) / (tau + h), the plain backward difference for tau = 0.

    Parameters
    ----------
    memory
        Memory of the axis, shape (N_MEMORY,).
    x
        Displacement (m).
    filter_time, sample_time
        tau and h (s).
    """
    change = x - memory[POSITION]
    memory[DERIVATIVE] = (filter_time * memory[DERIVATIVE] + change) / (filter_time + sample_time)
    memory[POSITION] = x


@kernel
def pid_current(gains: Array, direct: bool, memory: Array, setpoint: float) -> float:
    """Demanded current I_pid (A), without limits, for what `memory` holds (5.1 to 5.4).

    Parameters
    ----------
    gains
        Gains of the axis, shape (N_GAINS,): N/m, N.s/m, N/(m.s), N/m, N/A, A, A, N/m, N.s/m.
    direct
        Whether k_p and k_d count in place of K_b + K_s and C_b.
    memory
        Memory of the axis, shape (N_MEMORY,): integral (N), displacement (m), derivative (m/s).
    setpoint
        x_set (m).
    """
    proportional = stiffness(gains, direct) * memory[POSITION] - setpoint_stiffness(gains, direct) * setpoint
    force = proportional + damping(gains, direct) * memory[DERIVATIVE] + memory[INTEGRAL]
    current: float = -force / gains[K_I]
    return current


@kernel
def limit_and_integrate(
    gains: Array, memory: Array, setpoint: float, demand: float, low: float, high: float, sample_time: float
) -> float:
    """Demand cut to [low, high] (A); the integral advances by a sample unless that would push further out.

    The integral is held as K_I integral(x - x_set) in newtons, so that a change of K_I while running makes no bump.
    """
    error = memory[POSITION] - setpoint
    winds_up = (demand > high and error < 0.0) or (demand < low and error > 0.0)
    if not winds_up:
        memory[INTEGRAL] += sample_time * gains[K_INTEGRAL] * error
    current: float = min(max(demand, low), high)
    return current


@kernel
def response(gains: Array, direct: bool, filter_time: float, sample_time: float, omega: float) -> tuple[float, float]:
    """Real and imaginary part of C in K_i I_pid = -C x for a vibration at omega (rad/s), as it is sampled (N/m).

    C = k + c D + K_I J with z = exp(j omega h), D = (1 - 1/z) / (tau + h - tau/z), J = h / (z - 1).
    """
    cos, sin = math.cos(omega * sample_time), math.sin(omega * sample_time)
    above_re, above_im = 1.0 - cos, sin
    below_re, below_im = sample_time + filter_time * above_re, filter_time * above_im
    size = below_re * below_re + below_im * below_im
    c = damping(gains, direct) / size
    re = stiffness(gains, direct) + c * (above_re * below_re + above_im * below_im)
    im = c * (above_im * below_re - above_re * below_im)
    if gains[K_INTEGRAL] != 0.0:
        scale = gains[K_INTEGRAL] * sample_time / (above_re * above_re + sin * sin)
        re -= scale * above_re
        im -= scale * sin
    return re, im
