"""Controller, actuator and plant stepped together, in the order that leaves one sample between sensor and force.

A communication step is cut into pieces at the controller's samples. In each piece the parts step one after the other,
and each sees what those before it have found, as in a Gauss-Seidel master:

    samples      |                         |                         |
    step              [--------------------------------------]
    pieces            [--------------------][----------------]
                      controller, actuator, plant   the same
"""

from __future__ import annotations

from amb_actuator.actuator import initialise as initialise_actuator
from amb_actuator.actuator import step as step_actuator
from fmi_export.jit import inlined_kernel, kernel
from fmi_export.model import Array
from fmi_export.parts import clear, part
from levitated_rotor.exchange import carry, first_outside, gather, give, show_gathered, show_held
from levitated_rotor.faults import FAULT_LOOP, OF_PART
from levitated_rotor.records import N_PARTS, REAL, Arrays, Plan, arrays_of, plan_of, shared_of
from rolac_controller.controller import initialise as initialise_controller
from rolac_controller.controller import step as step_controller
from rotor_contact.plant import initialise as initialise_plant
from rotor_contact.plant import step as step_plant

CONTROLLER, ACTUATOR, PLANT = range(N_PARTS)

OUTSIDE = -1  # in place of a fault: an output is outside its range, which the caller of the entry kernel finds and names


@inlined_kernel
def inputs_fault(plan: Plan, k: int, held: Array) -> int:
    """Return the fault code of the first input of part k that is outside its range, or 0."""
    first, size = int(plan.parts[k].first_held), int(plan.parts[k].n_held)
    lowest, highest = part(plan.lowest_held, first, REAL, size), part(plan.highest_held, first, REAL, size)
    at = first_outside(part(held, first, REAL, size), lowest, highest)
    return 0 if at < 0 else int(plan.codes[first + at])


@inlined_kernel
def outputs_outside(plan: Plan, first: int, stop: int, outputs: Array) -> bool:
    """Return whether an output from number `first` up to but not including `stop` is outside its range."""
    size = stop - first
    lowest, highest = part(plan.lowest_outputs, first, REAL, size), part(plan.highest_outputs, first, REAL, size)
    return first_outside(part(outputs, first, REAL, size), lowest, highest) >= 0


@kernel
def fault_of_step(plan: Plan, k: int, fault: int, outputs: Array) -> int:
    """Return the fault that ends a step in part k: `OUTSIDE` where a part before it has left a range in this piece."""
    return OUTSIDE if outputs_outside(plan, 0, int(plan.parts[k].first_outputs), outputs) else fault


@inlined_kernel
def started(plan: Plan, k: int, fault: int, whole: Arrays) -> tuple[int, bool]:
    """Carry the outputs of part k at the start if it has no fault; return that, and whether a carried value changed."""
    own = plan.parts[k]
    if fault != 0:
        return OF_PART * (k + 1) + fault, False
    if outputs_outside(plan, int(own.first_outputs), int(own.first_outputs + own.n_outputs), whole.outputs):
        return OUTSIDE, False
    return 0, carry(plan, own, whole.outputs, whole.held)


@kernel
def settle(plan: Plan, whole: Arrays) -> tuple[int, bool]:
    """Initialise each part with what the others show; return the first fault, and whether a carried value changed.

    A part with a fault shows what it did before.
    """
    fault, changes = inputs_fault(plan, CONTROLLER, whole.held), False
    if fault == 0:
        own = arrays_of(plan.parts[CONTROLLER], whole)
        clear(own.state)
        fault, changes = started(plan, CONTROLLER, initialise_controller(*own), whole)
    first, any_changes = fault, changes
    fault, changes = inputs_fault(plan, ACTUATOR, whole.held), False
    if fault == 0:
        own = arrays_of(plan.parts[ACTUATOR], whole)
        clear(own.state)
        fault, changes = started(plan, ACTUATOR, initialise_actuator(*own), whole)
    first, any_changes = first if first != 0 else fault, any_changes or changes
    fault, changes = inputs_fault(plan, PLANT, whole.held), False
    if fault == 0:
        own = arrays_of(plan.parts[PLANT], whole)
        clear(own.state)
        fault, changes = started(plan, PLANT, initialise_plant(*own), whole)
    return first if first != 0 else fault, any_changes or changes


@kernel
def step_parts(plan: Plan, whole: Arrays, time: float, step_size: float) -> int:
    """Step controller, actuator and plant from `time` by `step_size` (s); return the fault code or `OUTSIDE`."""
    held, outputs = whole.held, whole.outputs
    fault = inputs_fault(plan, CONTROLLER, held)
    if fault != 0:
        return fault
    a = arrays_of(plan.parts[CONTROLLER], whole)
    fault = step_controller(a.constants, a.parameters, a.held, a.state, a.work, a.outputs, time, step_size)
    if fault != 0:
        return OF_PART + fault
    carry(plan, plan.parts[CONTROLLER], outputs, held)
    fault = inputs_fault(plan, ACTUATOR, held)
    if fault != 0:
        return fault_of_step(plan, ACTUATOR, fault, outputs)
    a = arrays_of(plan.parts[ACTUATOR], whole)
    fault = step_actuator(a.constants, a.parameters, a.held, a.state, a.work, a.outputs, time, step_size)
    if fault != 0:
        return fault_of_step(plan, ACTUATOR, 2 * OF_PART + fault, outputs)
    carry(plan, plan.parts[ACTUATOR], outputs, held)
    fault = inputs_fault(plan, PLANT, held)
    if fault != 0:
        return fault_of_step(plan, PLANT, fault, outputs)
    a = arrays_of(plan.parts[PLANT], whole)
    fault = step_plant(a.constants, a.parameters, a.held, a.state, a.work, a.outputs, time, step_size)
    if fault != 0:
        return fault_of_step(plan, PLANT, 3 * OF_PART + fault, outputs)
    carry(plan, plan.parts[PLANT], outputs, held)
    return 0


@kernel
def initialise(constants: Array, parameters: Array, inputs: Array, state: Array, work: Array, outputs: Array) -> int:
    """Initialise the parts until what passes between them no longer changes; return the first fault of the last pass."""
    plan = plan_of(constants)
    held = shared_of(state, work, plan).held
    whole = Arrays(constants, parameters, held, state, work, outputs)
    clear(held)
    give(plan, inputs, 0.0, held)
    fault, changes, passes = 0, True, 0
    while changes:
        if passes > plan.connections.shape[0] + 1:
            return FAULT_LOOP
        fault, changes = settle(plan, whole)
        passes += 1
    if fault > 0:
        show_held(plan, held, outputs)
    return max(fault, 0)


@kernel
def step(
    constants: Array,
    parameters: Array,
    inputs: Array,
    state: Array,
    work: Array,
    outputs: Array,
    time: float,
    step_size: float,
) -> int:
    """Advance all parts by `step_size` (s) under constant inputs, piece by piece; return the fault code.

    Where an output leaves its range the step ends there with 0, and the caller finds that output. Outputs that say what
    happened during a step do so of all pieces.
    """
    plan = plan_of(constants)
    held, gathered = shared_of(state, work, plan)
    whole = Arrays(constants, parameters, held, state, work, outputs)
    sample_time = parameters[0]
    pieces = max(1, round(step_size / sample_time))
    if pieces > 1:
        clear(gathered)
    for k in range(pieces):
        elapsed = k * sample_time
        give(plan, inputs, elapsed, held)
        fault = step_parts(plan, whole, time + elapsed, sample_time if pieces > 1 else step_size)
        if fault > 0:
            show_held(plan, held, outputs)
            return fault
        if fault == OUTSIDE or (k < pieces - 1 and outputs_outside(plan, 0, int(plan.head[0].n_outputs), outputs)):
            return 0
        if pieces > 1:
            gather(plan, outputs, gathered)
    if pieces > 1:
        show_gathered(plan, gathered, outputs)
    return 0
