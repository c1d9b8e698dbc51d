"""Data shared with the last step: records of sites and bodies, and non-magnetic forces.

The cache is in the scratch array with the parameters and inputs that it depends on, and is recomputed if any of these
differs in a single bit.
"""

from __future__ import annotations

from typing import NamedTuple

from fmi_export.flat import copy, same_bits
from fmi_export.jit import kernel, views
from fmi_export.model import Array
from fmi_export.parts import part
from rotor_contact.shaft.structure import REAL, Structure
from rotor_contact.variables.signals import N_INPUTS, first_disc_input, n_inputs, n_parameters


class StepCache(NamedTuple):
    """Total number of degrees of freedom, in an array of length 2; parameters and inputs on which the cache depends."""

    n: Array
    parameters: Array
    inputs: Array


@views
def step_cache_size(structure: Structure) -> int:
    """Return how many float64 values a `StepCache` occupies; the number is even."""
    size = 2 + n_parameters(structure) + n_inputs(structure)
    return size + size % 2


@views
def step_cache_of(work: Array, at: int, structure: Structure) -> StepCache:
    """Return a `StepCache` as views into an array, from position `at`."""
    inputs = at + 2 + n_parameters(structure)
    return StepCache(
        part(work, at, REAL, 2),
        part(work, at + 2, REAL, n_parameters(structure)),
        part(work, inputs, REAL, n_inputs(structure)),
    )


@kernel
def is_valid(step_cache: StepCache, structure: Structure, parameters: Array, inputs: Array) -> bool:
    """Return whether everything except the magnets' forces is unchanged since the last call of `store`."""
    discs = first_disc_input(structure)
    return (
        same_bits(parameters, step_cache.parameters)
        and same_bits(inputs[:N_INPUTS], step_cache.inputs[:N_INPUTS])
        and same_bits(inputs[discs:], step_cache.inputs[discs:])
    )


@kernel
def store(step_cache: StepCache, parameters: Array, inputs: Array, n: int) -> None:
    """Store the parameters, the inputs and the resulting total number of degrees of freedom."""
    copy(parameters, step_cache.parameters)
    copy(inputs, step_cache.inputs)
    step_cache.n[0] = n
