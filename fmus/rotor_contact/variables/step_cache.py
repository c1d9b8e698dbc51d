"""Data shared with the last step: records of sites and bodies, and non-magnetic forces.

The cache is in the scratch array with the parameters and inputs that it depends on, and is recomputed if any of these
differs by a bit.
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
    """Number of all degrees of freedom, in an array of two; the parameters and inputs that the cache depends on."""

    n: Array
    parameters: Array
    inputs: Array


@views
def step_cache_size(structure: Structure) -> int:
    """Return the number of float64 in a `StepCache`, an even number."""
    size = 2 + n_parameters(structure) + n_inputs(structure)
    return size + size % 2


@views
def step_cache_of(work: Array, at: int, structure: Structure) -> StepCache:
    """Return a `StepCache` in an array, from `at`."""
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
    """Store parameters, inputs and the resulting number of all degrees of freedom."""
    copy(parameters, step_cache.parameters)
    copy(inputs, step_cache.inputs)
    step_cache.n[0] = n
