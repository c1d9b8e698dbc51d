"""The plant of two equal bodies at the ends of a rotor that stays straight, each as in `two_bodies`."""

import numpy as np
from flexible_touchdown import FREE
from rotor_cases import both, head, memory, plant, rigid_rotor, run, state
from two_bodies import PHI, THETA, X_H, Y_H, Motion, TwoBodies, X, Y

from fmi_export.model import Instance

READ = ("mb1.x", "mb1.y", "rb1.housing_x", "rb1.housing_y", "speed", "rb1.race_speed", "rb1.mode", "rb1.f_n", "rb1.f_t")


def plant_of(
    model: TwoBodies, q: np.ndarray, v: np.ndarray, mode: int = FREE, max_substep: float = 2e-6, **more: float
) -> Instance:
    """The plant of which either end is `model`, from the state (q, v) with its contact in `mode`, and `more` values."""
    values = both("mb.k_b", model.support_stiffness) | both("mb.c_b", model.support_damping)
    values |= both("mb.f_x", model.force.real) | both("mb.f_y", model.force.imag)
    values |= both("rb.housing_mass", model.housing_mass or 0.0) | both("rb.race_inertia", model.race_inertia or 0.0)
    for name in ("clearance", "mu", "restitution", "journal_radius", "race_drag", "race_viscous_drag"):
        values |= both(f"rb.{name}", getattr(model, name))
    for axis, stiffness, damping in zip("xy", model.mount_stiffness, model.mount_damping, strict=True):
        values |= both(f"rb.mount_stiffness_{axis}", stiffness) | both(f"rb.mount_damping_{axis}", damping)
    values |= {"d1.u": model.unbalance, "d3.u": model.unbalance, "Omega": v[THETA], "solver.max_substep": max_substep}
    if model.spin_inertia is not None:
        values |= {"spin.free": 1.0, "spin.inertia": 2.0 * model.spin_inertia}
        values |= {"drive.torque": 2.0 * model.drive_torque, "drive.torque_limit": 2.0 * abs(model.drive_torque)}
    rotor = plant(values | more, rigid_rotor(2.0 * model.mass))
    _place(rotor, model, q, v, mode)
    return rotor


def coordinates(model: TwoBodies) -> list[int]:
    """Return the plant's coordinates in those of `two_bodies`: journals, housings and races of both ends, the spin."""
    housings = [X_H, Y_H, X_H, Y_H] if model.housing_mass is not None else []
    races = [PHI, PHI] if model.race_inertia is not None else []
    return [X, Y, X, Y, *housings, *races, *([THETA] if model.spin_inertia is not None else [])]


def _place(rotor: Instance, model: TwoBodies, q: np.ndarray, v: np.ndarray, mode: int) -> None:
    """Displacements, then velocities, and the contact of both ends."""
    order = coordinates(model)
    z, sites, start = state(rotor), memory(rotor).sites, head(rotor)
    z[: 2 * len(order)] = np.concatenate([q[order], v[order]])
    sites["mode"][:2] = mode
    sites["slip_sign"][:2] = np.sign(model.slip(q, v)) if mode != FREE else 1.0
    start.theta = q[THETA]
    start.initial_energy = 2.0 * model.energy(q, v)


def follow_plant(rotor: Instance, times: np.ndarray) -> Motion:
    """What the plant's first end does at equidistant `times` (s) from the first step on."""
    h = times[0]
    record = run(rotor, len(times), READ, h)
    motion = Motion(*np.zeros((2, len(times), 6)), *record[:, 6:].T)
    motion.q[:, : Y_H + 1] = record[:, :4]
    motion.v[:, [THETA, PHI]] = record[:, 4:6]
    return motion
