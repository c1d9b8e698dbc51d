"""One kernel for each reason to refuse or not to refuse it."""

import math

import numpy as np

from fmi_export.jit import kernel


@kernel
def nothing(constants, parameters, inputs, state, work, outputs):
    outputs[0] = state[0]
    return 0


@kernel
def allocate(constants, parameters, inputs, state, work, outputs, time, step_size):
    outputs[0] = np.ones(int(inputs[0])).sum()
    return 0


@kernel
def raise_with_value(constants, parameters, inputs, state, work, outputs, time, step_size):
    if inputs[0] > 1.0:
        raise ValueError("the input is too large", inputs[0])
    return 0


@kernel
def assign_overlapping(constants, parameters, inputs, state, work, outputs, time, step_size):
    """Numba prepares this for views that overlap, by an allocation."""
    work[1:5] = work[:4]
    return 0


@kernel
def raise_plainly(constants, parameters, inputs, state, work, outputs, time, step_size):
    """Raises where the input is 2 or less."""
    if inputs[0] <= 2.0:
        raise ValueError("the input is too small")
    table = work[:6].reshape(2, 3)
    table[1, 2] = math.hypot(inputs[0], 12.0)
    outputs[0] = work[5]
    return 0


@kernel
def print_it(constants, parameters, inputs, state, work, outputs, time, step_size):
    print(inputs[0])
    return 0


def plain(constants, parameters, inputs, state, work, outputs, time, step_size):
    return 0
