"""The part of the plant's state that moves linearly while the rotor touches nothing."""

from __future__ import annotations

from fmi_export.linear_state import LinearState
from fmi_export.model import Array
from rotor_contact.layout import HEAD, place_of_axial_motion, place_of_motion
from rotor_contact.shaft.structure import structure_of


def linear_state(constants: Array) -> LinearState:
    """Return the positions of the linear motion, the angle and the energies in the state (see `LinearState`)."""
    structure, names = structure_of(constants), HEAD.names or ()
    z = place_of_motion(structure)
    energy = names.index("initial_energy"), names.index("largest_energy")
    unless = "spin.free", "*.housing_mass", "*.race_inertia", "*.mode"
    axial = place_of_axial_motion(structure)
    along = ((axial, z),) if structure.n_thrust else ()
    return LinearState((*along, (z, z + 2 * len(structure.K))), names.index("theta"), energy, unless)
