"""One sample of the law, the limits of its demands, and the feedback of limited demands to the states.

    [x(n+1); u_law(n)] = M [x(n); e(n)],   u = gain u_law + offset + feedforward + jump                (1)
    u_lim = min(max(u, lower), upper),     x(n+1) += L (u_lim - u) / gain                              (2)

**Wind-up.** Modes of A that decay within `slow_time`, such as filters and derivatives, recover from a limited demand by
themselves. They continue to follow the measurement, because they provide damping, which matters most while a demand is
limited. Slow modes, such as integrators, do not recover. L acts only on the slow modes (back-calculation). While the
demand is limited, the slow modes have the matrix A_s - L_s C_s in their coordinates xi = W x, where A_s = W A V, C_s =
C V and L = V L_s. For each eigenvalue lambda of A_s, this matrix has the eigenvalue alpha^2 / conj(lambda) with alpha =
exp(-T / slow_time). L_s is then the gain of a Kalman filter for A_s / alpha without process noise, which is the gain
that requires the least excess.

**Switching on.** While the law is off, its demands are `offset + feedforward`; filters follow the measurement, and slow
modes are held at zero. At the sample that switches the law on, jump = u_last - u. The jump then fades as
exp(-t/transfer_time). The demands therefore do not jump, although the law acts in full from its first sample. A reset,
which sets the slow modes to zero while the law is on, is handled in the same way.
"""

from __future__ import annotations

import math

import numpy as np

from fmi_export.flat import copy
from fmi_export.jit import inlined_kernel
from fmi_export.parts import clear
from linear_controller.matrices import LawMatrices, TableRows, add_product
from linear_controller.records import Inputs, Parameters, State, Work
from signal_chain.demands import converted, dac_of, within_converter


@inlined_kernel
def start_states(parameters: Parameters, matrices: LawMatrices, bracket: TableRows, state: State, work: Work) -> None:
    """Set the first sample's states to zero, or to steady state under the errors (last part of `work.law_inputs`)."""
    clear(state.x)
    if parameters.common[0].start_at_rest != 0.0:
        errors = work.law_inputs[state.x.shape[0] :]
        add_product(matrices.rest, matrices.values, bracket, errors, state.x)


@inlined_kernel
def reset_slow(matrices: LawMatrices, bracket: TableRows, state: State, work: Work) -> None:
    """Subtract the contribution of the slow modes from the states."""
    slow = work.law_outputs[: state.x.shape[0]]
    clear(slow)
    add_product(matrices.slow, matrices.values, bracket, state.x, slow)
    for k in range(state.x.shape[0]):
        state.x[k] -= slow[k]


@inlined_kernel
def evaluate(matrices: LawMatrices, bracket: TableRows, state: State, work: Work) -> None:
    """Write M [x(n); e(n)] of (1) into `work.law_outputs`."""
    copy(state.x, work.law_inputs)
    clear(work.law_outputs)
    add_product(matrices.law, matrices.values, bracket, work.law_inputs, work.law_outputs)


@inlined_kernel
def fade_jump(common: np.record, state: State) -> None:
    """Let the jump fade for the duration of one sample."""
    any_left = False
    for i in range(state.jump.shape[0]):
        any_left = any_left or state.jump[i] != 0.0
    if any_left:
        factor = math.exp(-common.sample_time / common.transfer_time) if common.transfer_time > 0.0 else 0.0
        for i in range(state.jump.shape[0]):
            state.jump[i] *= factor


@inlined_kernel
def limit(parameters: Parameters, inputs: Inputs, state: State, work: Work, is_transfer: bool) -> bool:
    """Compute the demands of this sample and their excess (u_lim - u) / gain; return whether a demand is limited.

    Parameters
    ----------
    state
        `last` receives the demands. If `is_transfer` is true, `jump` is recomputed so that the demands continue from
        those of the last sample.
    work
        `law_outputs` contains the result of `evaluate`; `excess` receives the excess.
    """
    common, is_on, n = parameters.common[0], inputs.common[0].enable != 0.0, state.x.shape[0]
    is_limited, chain, dac = False, common.chain, dac_of(common.chain)
    for i in range(state.last.shape[0]):
        demand = parameters.demands[i]
        bias = demand.offset + inputs.feedforward[i]
        law = demand.gain * work.law_outputs[n + i] + bias
        if is_transfer:
            state.jump[i] = state.last[i] - law if common.transfer_time > 0.0 else 0.0
        demanded = law + state.jump[i] if is_on else bias
        limits = within_converter(demand.lower, demand.upper, chain, dac)
        limited = min(max(demanded, limits.low), limits.high)
        is_limited = is_limited or limited != demanded
        work.excess[i] = (limited - demanded) / demand.gain if is_on and demand.gain != 0.0 else 0.0
        state.last[i] = converted(limited, chain, dac)
    return is_limited


@inlined_kernel
def advance(matrices: LawMatrices, bracket: TableRows, state: State, work: Work) -> None:
    """Compute the states of the next sample, including the feedback of limited demands (2)."""
    copy(work.law_outputs[: state.x.shape[0]], state.x)
    for i in range(work.excess.shape[0]):
        if work.excess[i] != 0.0:
            add_product(matrices.tracking, matrices.values, bracket, work.excess, state.x)
            return
