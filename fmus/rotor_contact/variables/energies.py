"""Energies of the plant: their variables, and which of them are integrals over time.

An energy that is an integral requires a field in this module, a rate in `integration`, and an integral over a piece of
exact motion in `piece_energy`. Kinetic and strain energy follow from the state (`outputs`).
"""

from __future__ import annotations

import numpy as np

from fmi_export.jit import kernel
from fmi_export.records import record
from fmi_export.variables import Variable, output
from rotor_contact.variables import start_values
from rotor_contact.variables.planes import Planes
from rotor_contact.variables.start_values import ALWAYS_SAME

# Heat of all dampers, of friction, of impacts and compliant contacts, and work of all inputs (J).
ENERGY_INTEGRALS = record(
    ("damping_heat", np.float64), ("friction_heat", np.float64), ("impact_heat", np.float64), ("work", np.float64)
)
SINCE_START = {  # energies that are zero at the start
    "damping": "Heat so far from passive bearings, seals, the shaft and mounts, and from the drag on a free spin",
    "friction": "Heat so far from sliding friction at sites and faces, and from the drag on races",
    "impact": "Energy lost so far in impacts and their friction, in compliant contacts and in the dampers of faces, "
    "which can decrease under the nodal impact law",
    "dissipated": "Sum of energy.damping, energy.friction and energy.impact, which is heat except under the nodal "
    "impact law",
    "work": "Work done so far on the rotor by all inputs, gravity, the drive and the stiffness of the seals",
    "balance": "Change of kinetic and strain energy since the start, plus energy.dissipated, minus energy.work",
}


def energies(planes: Planes) -> list[Variable]:
    """Return the energies of a plant whose rotor has these planes."""
    return [
        output(
            "energy.kinetic",
            "J",
            "Kinetic energy of the lateral and axial motion, of housings, of races and of a free spin",
            initially_depends_on=(*start_values.motion(planes), "spin.free", "spin.inertia", "drive.ideal"),
        ),
        output(
            "energy.strain",
            "J",
            "Strain energy of the shaft, passive bearings, mounts, compliant contacts and faces, without seals",
            initially_depends_on=start_values.strain(planes),
        ),
        *(output(f"energy.{name}", "J", what, **ALWAYS_SAME) for name, what in SINCE_START.items()),
    ]


@kernel
def write_heat_and_work(integrals: np.record, gain: float, energy: np.record) -> None:
    """Write heat, work and the balance (J); `gain` is the gain of mechanical energy since the start."""
    dissipated: float = integrals.damping_heat + integrals.friction_heat + integrals.impact_heat
    energy.damping = integrals.damping_heat
    energy.friction = integrals.friction_heat
    energy.impact = integrals.impact_heat
    energy.dissipated = dissipated
    energy.work = integrals.work
    energy.balance = gain + dissipated - integrals.work
