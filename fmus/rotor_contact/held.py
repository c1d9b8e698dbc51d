"""What a step has in common with the last: the records of sites and bodies, and the forces that no magnet makes.

It is kept in the scratch array beside the parameters and inputs that it follows from, and found anew where one of these
differs in a bit. So scratch memory needs no promise: what is in it counts only with its reasons.
"""

from __future__ import annotations

from typing import NamedTuple

from fmi_export.flat import copy, same_bits
from fmi_export.jit import kernel, views
from fmi_export.model import Array
from fmi_export.parts import part
from rotor_contact.signals import N_INPUTS, first_disc_input, n_inputs, n_parameters
from rotor_contact.structure import REAL, Structure


class Held(NamedTuple):
    """Number of all degrees of freedom, in an array of two; parameters and inputs that all this follows from."""

    n: Array
    parameters: Array
    inputs: Array


@views
def held_size(structure: Structure) -> int:
    """Return how many float64 a `Held` takes, an even number."""
    size = 2 + n_parameters(structure) + n_inputs(structure)
    return size + size % 2


@views
def held_of(work: Array, at: int, structure: Structure) -> Held:
    """Return a `Held` in an array from `at` on."""
    inputs = at + 2 + n_parameters(structure)
    return Held(
        part(work, at, REAL, 2),
        part(work, at + 2, REAL, n_parameters(structure)),
        part(work, inputs, REAL, n_inputs(structure)),
    )


@kernel
def is_held(held: Held, structure: Structure, parameters: Array, inputs: Array) -> bool:
    """Return whether all but the magnets' forces is as when `hold` was called last."""
    discs = first_disc_input(structure)
    return (
        same_bits(parameters, held.parameters)
        and same_bits(inputs[:N_INPUTS], held.inputs[:N_INPUTS])
        and same_bits(inputs[discs:], held.inputs[discs:])
    )


@kernel
def hold(held: Held, parameters: Array, inputs: Array, n: int) -> None:
    """Keep parameters, inputs and the number of all degrees of freedom that follows from them."""
    copy(parameters, held.parameters)
    copy(inputs, held.inputs)
    held.n[0] = n
