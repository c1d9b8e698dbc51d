"""What passes between the parts: their inputs, which the state holds, and outputs over the pieces of a step."""

from __future__ import annotations

import numpy as np

from fmi_export.jit import inlined_kernel, kernel
from fmi_export.model import Array
from fmi_export.parts import clear, part
from levitated_rotor.records import REAL, Plan


@kernel
def first_outside(values: Array, lowest: Array, highest: Array) -> int:
    """Return the index of the first value that is outside its range or not a number, or -1."""
    outside = False
    for i in range(values.shape[0]):  # without a branch: several are compared at once
        outside |= not ((lowest[i] <= values[i]) & (values[i] <= highest[i]))
    if outside:
        for i in range(values.shape[0]):
            if not lowest[i] <= values[i] <= highest[i]:
                return i
    return -1


@inlined_kernel
def inputs_fault(plan: Plan, k: int, held: Array) -> int:
    """Return the fault code of the first input of part k that is outside its range, or 0."""
    own = plan.parts[k]
    for i in range(int(own.first_watched), int(own.first_watched + own.n_watched)):
        watched = plan.watched[i]
        if not watched.lowest <= held[int(watched.input)] <= watched.highest:
            return int(watched.code)
    return 0


@inlined_kernel
def outputs_outside(plan: Plan, first: int, stop: int, outputs: Array) -> bool:
    """Return whether an output from number `first` up to but not including `stop` is outside its range."""
    size = stop - first
    lowest, highest = part(plan.lowest, first, REAL, size), part(plan.highest, first, REAL, size)
    return first_outside(part(outputs, first, REAL, size), lowest, highest) >= 0


@inlined_kernel
def give(plan: Plan, inputs: Array, held: Array) -> None:
    """Carry the inputs of the assembly to the parts, all but the speed."""
    for k in range(plan.given.shape[0]):
        source, target = int(plan.given[k].source), int(plan.given[k].target)
        for i in range(int(plan.given[k].size)):
            held[target + i] = inputs[source + i]


@inlined_kernel
def give_speed(plan: Plan, inputs: Array, elapsed: float, held: Array) -> None:
    """Carry the speed to the parts, as it is after the time `elapsed` (s) of the step."""
    for k in range(plan.ramped.shape[0]):
        rise = inputs[int(plan.head[0].slope)] * elapsed
        held[int(plan.ramped[k].target)] = inputs[int(plan.ramped[k].source)] + rise


@inlined_kernel
def carry(plan: Plan, own: np.record, outputs: Array, held: Array) -> bool:
    """Carry the outputs of a part, `own` being its record, along its connections; return whether one has changed."""
    changed = False
    for k in range(int(own.first_link), int(own.first_link + own.n_links)):
        link = plan.connections[k]
        value = outputs[int(link.source)]
        changed |= held[int(link.target)] != value
        held[int(link.target)] = value
    return changed


@kernel
def show_held(plan: Plan, held: Array, outputs: Array) -> None:
    """Write what the parts were given as the outputs that it came from, for the sentence of a fault."""
    for k in range(plan.connections.shape[0]):
        link = plan.connections[k]
        outputs[int(link.source)] = held[int(link.target)]


@inlined_kernel
def gather(plan: Plan, outputs: Array, begins: bool, gathered: Array) -> None:
    """Gather outputs over the pieces of a step, anew where it begins: flags that were true, and sums."""
    if begins:
        clear(gathered)
    n_flags = plan.flags.shape[0]
    for k in range(n_flags):
        gathered[k] = max(gathered[k], outputs[int(plan.flags[k])])
    for k in range(plan.sums.shape[0]):
        gathered[n_flags + k] += outputs[int(plan.sums[k])]


@inlined_kernel
def show_gathered(plan: Plan, gathered: Array, outputs: Array) -> None:
    """Write what was gathered to the outputs."""
    n_flags = plan.flags.shape[0]
    for k in range(n_flags):
        outputs[int(plan.flags[k])] = gathered[k]
    for k in range(plan.sums.shape[0]):
        outputs[int(plan.sums[k])] = gathered[n_flags + k]
