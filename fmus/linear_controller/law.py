"""One sample of the law, its demands within their limits, and what the states learn of that.

    [x(n+1); u_law(n)] = M [x(n); e(n)],   u = gain u_law + offset + feedforward + jump                (1)
    u_lim = min(max(u, lower), upper),     x(n+1) += L (u_lim - u) / gain                              (2)

**Wind-up.** A mode of A that decays in less than `slow_time` forgets by itself what a limited demand has not done;
filters and derivatives, which are such modes, go on seeing what is measured: with a limited demand damping counts
most. Slow modes, integrators first of all, do not forget. L acts on them alone (back-calculation): in their coordinates
xi = W x, A_s = W A V, C_s = C V, L = V L_s, and A_s - L_s C_s, which they obey while the demand is limited, has for
each mode lambda of A_s the mode alpha^2 / conj(lambda), alpha = exp(-T / slow_time). It is what needs the least excess:
the gain of a Kalman filter for A_s / alpha without process noise.

**Switching on.** While the law is off its demands are `offset + feedforward`; filters see what is measured, and slow
modes are held at zero. At the sample that switches on, jump = u_last - u, which then fades as exp(-t / transfer_time):
no demand jumps, and the law acts in full from its first sample on. So it is at a reset, which takes the slow modes to
zero while the law is on.
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
    """Set the states of the first sample: at rest under its errors, or zero; `work.given` ends with the errors."""
    clear(state.x)
    if parameters.own[0].start_at_rest != 0.0:
        errors = work.given[state.x.shape[0] :]
        add_product(matrices.rest, matrices.values, bracket, errors, state.x)


@inlined_kernel
def reset_slow(matrices: LawMatrices, bracket: TableRows, state: State, work: Work) -> None:
    """Take the slow part out of the states."""
    slow = work.found[: state.x.shape[0]]
    clear(slow)
    add_product(matrices.slow, matrices.values, bracket, state.x, slow)
    for k in range(state.x.shape[0]):
        state.x[k] -= slow[k]


@inlined_kernel
def evaluate(matrices: LawMatrices, bracket: TableRows, state: State, work: Work) -> None:
    """Compute (1), without gain and sums, into `work.found`."""
    copy(state.x, work.given)
    clear(work.found)
    add_product(matrices.law, matrices.values, bracket, work.given, work.found)


@inlined_kernel
def fade_jump(own: np.record, state: State) -> None:
    """Let the jump fade by a sample."""
    any_left = False
    for i in range(state.jump.shape[0]):
        any_left = any_left or state.jump[i] != 0.0
    if any_left:
        factor = math.exp(-own.sample_time / own.transfer_time) if own.transfer_time > 0.0 else 0.0
        for i in range(state.jump.shape[0]):
            state.jump[i] *= factor


@inlined_kernel
def limit(parameters: Parameters, inputs: Inputs, state: State, work: Work, is_transfer: bool) -> bool:
    """Compute the demands of this sample into `state.last`, and (u_lim - u) / gain; return whether one is limited.

    Parameters
    ----------
    state
        Its jump is set anew where `is_transfer`, so that the demands go on from those of the last sample.
    work
        `found` as from `evaluate`; `excess` is written.
    """
    own, is_on, n = parameters.own[0], inputs.own[0].enable != 0.0, state.x.shape[0]
    is_limited, chain, dac = False, own.chain, dac_of(own.chain)
    for i in range(state.last.shape[0]):
        demand = parameters.demands[i]
        given = demand.offset + inputs.feedforward[i]
        law = demand.gain * work.found[n + i] + given
        if is_transfer:
            state.jump[i] = state.last[i] - law if own.transfer_time > 0.0 else 0.0
        asked = law + state.jump[i] if is_on else given
        limits = within_converter(demand.lower, demand.upper, chain, dac)
        limited = min(max(asked, limits.low), limits.high)
        is_limited = is_limited or limited != asked
        work.excess[i] = (limited - asked) / demand.gain if is_on and demand.gain != 0.0 else 0.0
        state.last[i] = converted(limited, chain, dac)
    return is_limited


@inlined_kernel
def advance(matrices: LawMatrices, bracket: TableRows, state: State, work: Work) -> None:
    """Take the states of the next sample, with what they learn of limited demands (2)."""
    copy(work.found[: state.x.shape[0]], state.x)
    for i in range(work.excess.shape[0]):
        if work.excess[i] != 0.0:
            add_product(matrices.tracking, matrices.values, bracket, work.excess, state.x)
            return
