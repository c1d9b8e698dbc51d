"""PID of one bearing axis (thesis 5.1 to 5.4), sampled.

    I_pid = -(1/K_i) [ (K_b + K_s) x + C_b x' + K_I integral(x) ]

K_s cancels the bearing's negative stiffness: the closed bearing has net stiffness K_b and damping C_b.
`k_s`, `k_i` are constants of the bearing (N/m, N/A); the gain of the integral is `k_integral`.
"""

from __future__ import annotations

from fmi_export.jit import kernel
from fmi_export.model import Array

# Layout of an axis's gains and of its memory.
K_B, C_B, K_INTEGRAL, K_S, K_I, I_MIN, I_MAX = range(7)
INTEGRAL, POSITION, DERIVATIVE = range(3)
N_GAINS, N_MEMORY = 7, 3


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
def pid_current(gains: Array, memory: Array) -> float:
    """Demanded current I_pid (A), without limits, for what `memory` holds (5.1 to 5.4).

    Parameters
    ----------
    gains
        Gains of the axis, shape (N_GAINS,): N/m, N.s/m, N/(m.s), N/m, N/A, A, A.
    memory
        Memory of the axis, shape (N_MEMORY,): integral (N), displacement (m), derivative (m/s).
    """
    force = (gains[K_B] + gains[K_S]) * memory[POSITION] + gains[C_B] * memory[DERIVATIVE] + memory[INTEGRAL]
    current: float = -force / gains[K_I]
    return current


@kernel
def limit_and_integrate(gains: Array, memory: Array, demand: float, sample_time: float) -> float:
    """Demand cut to [i_min, i_max] (A); the integral advances by a sample unless that would push further out.

    The integral is held as K_I integral(x) in newtons, so that a change of K_I while running makes no bump.
    """
    x = memory[POSITION]
    winds_up = (demand > gains[I_MAX] and x < 0.0) or (demand < gains[I_MIN] and x > 0.0)
    if not winds_up:
        memory[INTEGRAL] += sample_time * gains[K_INTEGRAL] * x
    current: float = min(max(demand, gains[I_MIN]), gains[I_MAX])
    return current
