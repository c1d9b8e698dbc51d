"""What a step has in common with the last: the records of sites and bodies, and the forces that no magnet makes.

It is kept in the scratch array beside the parameters and inputs that it follows from, and found anew where one of these
differs in a bit: cached values are revalidated against their inputs.
"""

from __future__ import annotations

from typing import NamedTuple

from fmi_export.flat import copy, same_bits
from fmi_export.jit import kernel, views
from fmi_export.model import Array
from fmi_export.parts import part
from rotor_contact.signals import N_INPUTS, first_disc_input, n_inputs, n_parameters
from rotor_contact.structure import REAL, Structure


class StepCache(NamedTuple):
    """Number of all degrees of freedom, in an array of two; parameters and inputs that all this follows from."""

    n: Array
    parameters: Array
    inputs: Array


@views
def step_cache_size(structure: Structure) -> int:
    """Return how many float64 a `StepCache` takes, an even number."""
    size = 2 + n_parameters(structure) + n_inputs(structure)
    return size + size % 2


@views
def step_cache_of(work: Array, at: int, structure: Structure) -> StepCache:
    """Return a `StepCache` in an array from `at` on."""
    inputs = at + 2 + n_parameters(structure)
    return StepCache(
        part(work, at, REAL, 2),
        part(work, at + 2, REAL, n_parameters(structure)),
        part(work, inputs, REAL, n_inputs(structure)),
    )


@kernel
def is_valid(step_cache: StepCache, structure: Structure, parameters: Array, inputs: Array) -> bool:
    """Return whether all but the magnets' forces is as when `store` was called last."""
    discs = first_disc_input(structure)
    return (
        same_bits(parameters, step_cache.parameters)
        and same_bits(inputs[:N_INPUTS], step_cache.inputs[:N_INPUTS])
        and same_bits(inputs[discs:], step_cache.inputs[discs:])
    )


@kernel
def store(step_cache: StepCache, parameters: Array, inputs: Array, n: int) -> None:
    """Keep parameters, inputs and the number of all degrees of freedom that follows from them."""
    copy(parameters, step_cache.parameters)
    copy(inputs, step_cache.inputs)
    step_cache.n[0] = n
