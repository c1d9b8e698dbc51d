"""The plant of two equal bodies at the ends of a rotor that stays straight, each as in `two_bodies`."""

from __future__ import annotations

import numpy as np
from rotor_cases import both, head, masters, place, plant, rigid_rotor
from two_bodies import PHI, THETA, X_H, Y_H, TwoBodies

from fmi_export.model import Instance

EXACT = {"solver.max_substep": 2e-6}


def plant_of(model: TwoBodies, spin: float = 0.0, velocity: complex = 0.0, **solver: float) -> Instance:
    """The plant of which either end is `model`; the journals start in the middle at `velocity` (m/s)."""
    site = {
        "clearance": model.clearance,
        "mu": model.mu,
        "restitution": model.restitution,
        "journal_radius": model.journal_radius,
        "housing_mass": model.housing_mass or 0.0,
        "mount_stiffness_x": model.mount_stiffness[0],
        "mount_stiffness_y": model.mount_stiffness[1],
        "mount_damping_x": model.mount_damping[0],
        "mount_damping_y": model.mount_damping[1],
        "race_inertia": model.race_inertia or 0.0,
        "race_drag": model.race_drag,
        "race_viscous_drag": model.race_viscous_drag,
    }
    bearing = {
        "k_b": model.support_stiffness,
        "c_b": model.support_damping,
        "f_x": model.force.real,
        "f_y": model.force.imag,
    }
    values = {f"{kind}{k}.{name}": value for kind, part in (("rb", site), ("mb", bearing)) for k in (1, 2)
              for name, value in part.items()}  # fmt: skip
    values |= {"Omega": spin, "d1.u": model.unbalance, "d3.u": model.unbalance} | EXACT | solver
    if model.spin_inertia is not None:
        values |= {"spin.free": 1.0, "spin.inertia": 2.0 * model.spin_inertia}
        values |= {"drive.torque": 2.0 * model.drive_torque, "drive.torque_limit": 2.0 * abs(model.drive_torque)}
    rotor = plant(values, rigid_rotor(2.0 * model.mass))
    return place(rotor, np.zeros(2, dtype=complex), np.full(2, velocity)) if velocity else rotor
