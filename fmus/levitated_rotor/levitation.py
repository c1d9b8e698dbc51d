"""Controller, actuator and plant stepped together, in the order that leaves one sample between sensor and force.

A communication step is cut into pieces at the controller's samples. In each piece the parts step one after the other,
and each sees what those before it have found, as in a Gauss-Seidel master; docs/theory/levitated_rotor.md has a sketch.
"""

from __future__ import annotations

from amb_actuator.actuator import initialise as initialise_actuator
from amb_actuator.actuator import step as step_actuator
from fmi_export.jit import inlined_kernel, kernel
from fmi_export.model import UNCHANGED, Array
from fmi_export.parts import clear, copy_all, part
from levitated_rotor.exchange import (
    carry,
    gather,
    give,
    give_speed,
    inputs_fault,
    outputs_outside,
    show_gathered,
    show_held,
)
from levitated_rotor.faults import FAULT_LOOP, OF_PART
from levitated_rotor.pieces import CLOCK, next_sample, piece, whole_sample
from levitated_rotor.records import N_PARTS, Arrays, Plan, arrays_of, plan_of, shared_of
from rolac_controller.controller import initialise as initialise_controller
from rolac_controller.controller import step as step_controller
from rotor_contact.plant import initialise as initialise_plant
from rotor_contact.plant import step as step_plant

CONTROLLER, ACTUATOR, PLANT = range(N_PARTS)

OUTSIDE = -1  # in place of a fault: an output is outside its range, and who called the entry kernel finds and names it


@inlined_kernel
def of_part(k: int, fault: int) -> int:
    """Return the assembly's code for a fault of part k."""
    return OF_PART * (k + 1) + fault if fault != 0 else 0


@inlined_kernel
def started(plan: Plan, k: int, fault: int, whole: Arrays) -> tuple[int, bool]:
    """Carry the outputs of part k at the start if it has no fault; return that, and whether a carried value changed."""
    own = plan.parts[k]
    if fault != 0:
        return of_part(k, fault), False
    if outputs_outside(plan, int(own.first_outputs), int(own.first_outputs + own.n_outputs), whole.outputs):
        return OUTSIDE, False
    return 0, carry(plan, own, whole.outputs, whole.held)


@kernel
def ended(plan: Plan, k: int, fault: int, held: Array, outputs: Array) -> int:
    """Return what a step returns that a fault of part k ends: 0 where a part before it has just left a range."""
    if outputs_outside(plan, 0, int(plan.parts[k].first_outputs), outputs):
        return 0
    show_held(plan, held, outputs)
    return fault


@kernel
def initialise(constants: Array, parameters: Array, inputs: Array, state: Array, work: Array, outputs: Array) -> int:
    """Initialise the parts, with what the others show, until nothing between them changes; return the first fault.

    A part with a fault shows what it did before, which may put right what another part shows.
    """
    plan = plan_of(constants)
    shared = shared_of(state, work, plan)
    held = shared.held
    whole = Arrays(constants, parameters, held, state, work, outputs)
    clear(held)
    give(plan, inputs, held)
    give_speed(plan, inputs, 0.0, held)
    first, changed, passes = 0, True, 0
    while changed:
        if passes > plan.connections.shape[0] + 1:
            return FAULT_LOOP
        passes += 1
        first, changed = inputs_fault(plan, CONTROLLER, held), False
        if first == 0:
            a = arrays_of(plan.parts[CONTROLLER], whole)
            clear(a.state)
            fault = initialise_controller(a.constants, a.parameters, a.held, a.state, a.work, a.outputs)
            first, changed = started(plan, CONTROLLER, fault, whole)
        code, changes = inputs_fault(plan, ACTUATOR, held), False
        if code == 0:
            a = arrays_of(plan.parts[ACTUATOR], whole)
            clear(a.state)
            fault = initialise_actuator(a.constants, a.parameters, a.held, a.state, a.work, a.outputs)
            code, changes = started(plan, ACTUATOR, fault, whole)
        first, changed = first if first != 0 else code, changed or changes
        code, changes = inputs_fault(plan, PLANT, held), False
        if code == 0:
            a = arrays_of(plan.parts[PLANT], whole)
            clear(a.state)
            fault = initialise_plant(a.constants, a.parameters, a.held, a.state, a.work, a.outputs)
            code, changes = started(plan, PLANT, fault, whole)
        first, changed = first if first != 0 else code, changed or changes
    if first == OUTSIDE:
        return 0
    if first != 0:
        show_held(plan, held, outputs)
    return first


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
    shared = shared_of(state, work, plan)
    held = shared.held
    whole = Arrays(constants, parameters, held, state, work, outputs)
    c, a, p = (
        arrays_of(plan.parts[CONTROLLER], whole),
        arrays_of(plan.parts[ACTUATOR], whole),
        arrays_of(plan.parts[PLANT], whole),
    )
    clock, sample_time = part(c.state, 0, CLOCK, 1), c.parameters[int(plan.head[0].sample_time)]
    at, left, pieces = time, step_size, 0
    give(plan, inputs, held)
    while left > 0.0:
        size = piece(next_sample(clock[0], at, sample_time), at, left, sample_time)
        h = whole_sample(size, at, sample_time)
        give_speed(plan, inputs, at - time, held)
        k, fault = CONTROLLER, inputs_fault(plan, CONTROLLER, held)
        if fault == 0:
            fault = step_controller(c.constants, c.parameters, c.held, c.state, c.work, c.outputs, at, h)
            if fault == UNCHANGED:
                copy_all(shared.shown, c.outputs)
            elif fault == 0:
                copy_all(c.outputs, shared.shown)
                carry(plan, plan.parts[CONTROLLER], outputs, held)
            fault = of_part(CONTROLLER, max(fault, 0))
        if fault == 0:
            k, fault = ACTUATOR, inputs_fault(plan, ACTUATOR, held)
        if fault == 0:
            fault = step_actuator(a.constants, a.parameters, a.held, a.state, a.work, a.outputs, at, h)
            fault = of_part(ACTUATOR, fault)
        if fault == 0:
            carry(plan, plan.parts[ACTUATOR], outputs, held)
            k, fault = PLANT, inputs_fault(plan, PLANT, held)
        if fault == 0:
            fault = of_part(PLANT, step_plant(p.constants, p.parameters, p.held, p.state, p.work, p.outputs, at, h))
        if fault != 0:
            return ended(plan, k, fault, held, outputs)
        carry(plan, plan.parts[PLANT], outputs, held)
        left = left - size
        at = time + step_size - left
        if left > 0.0 or pieces > 0:
            if outputs_outside(plan, 0, int(plan.head[0].n_outputs), outputs):
                return 0
            gather(plan, outputs, pieces == 0, shared.gathered)
        pieces += 1
    if pieces > 1:
        show_gathered(plan, shared.gathered, outputs)
    return 0
