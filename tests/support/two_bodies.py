"""A journal in its retainer, both bodies in the plane, and their spin: the smallest machine of `flexible_touchdown`.

Coordinates are q = (x, y, x_h, y_h, theta, phi): journal, housing, angle of the rotor, angle of the race.
"""

from dataclasses import dataclass, field

import numpy as np
from flexible_touchdown import FlexibleTouchdown, Retainer, fall

X, Y, X_H, Y_H, THETA, PHI = range(6)


@dataclass(frozen=True)
class TwoBodies:
    """Mass and support of journal and housing, their contact, and inertias of spin, all SI; None does not move."""

    mass: float
    clearance: float
    support_stiffness: float = 0.0
    support_damping: float = 0.0
    force: complex = 0.0  # on the journal (N), a weight for instance
    unbalance: float = 0.0  # kg m
    spin_inertia: float | None = None
    drive_torque: float = 0.0  # N m
    housing_mass: float | None = None
    mount_stiffness: tuple[float, float] = (0.0, 0.0)
    mount_damping: tuple[float, float] = (0.0, 0.0)
    race_inertia: float | None = None
    race_drag: float = 0.0  # N m
    race_viscous_drag: float = 0.0  # N m s
    mu: float = 0.0
    restitution: float = 0.0
    journal_radius: float = 0.025

    @property
    def order(self) -> list[int]:
        """The coordinates of `machine` among the six."""
        housing = [X_H, Y_H] if self.housing_mass is not None else []
        return [X, Y, *housing, *([PHI] if self.race_inertia is not None else []), THETA]

    @property
    def machine(self) -> FlexibleTouchdown:
        """The same as a rotor with one retainer."""
        retainer = Retainer(
            0,
            self.clearance,
            self.journal_radius,
            self.mu,
            self.housing_mass or 0.0,
            self.mount_stiffness,
            self.mount_damping,
            self.race_inertia or 0.0,
            self.race_drag,
            self.race_viscous_drag,
            self.restitution,
        )
        one, none = np.eye(2), np.zeros((2, 2))
        return FlexibleTouchdown(
            M=self.mass * one,
            C=self.support_damping * one,
            R=none,
            G=none,
            K=self.support_stiffness * one,
            unbalance=np.array([self.unbalance, 0.0]),
            force=np.array([self.force.real, self.force.imag]),
            sites=(retainer,),
            spin_inertia=self.spin_inertia,
            torque=self.drive_torque,
        )

    def slip(self, q: np.ndarray, v: np.ndarray) -> float:
        """Return the slip of the journal on its race (m/s)."""
        return self.machine.rows(0, q[self.order])[1] @ v[self.order]

    def energy(self, q: np.ndarray, v: np.ndarray) -> float:
        """Return the kinetic energy of all that moves, and strain energy (J)."""
        return self.machine.energy(q[self.order], v[self.order])


MOUNTED = TwoBodies(
    mass=10.0,
    clearance=0.25e-3,
    support_stiffness=2e4,
    force=98.1 * np.exp(-0.6j * np.pi),
    housing_mass=4.0,
    mount_stiffness=(4e6, 6e6),
    mount_damping=(400.0, 700.0),
)


@dataclass
class Motion:
    """Rows at the requested times, and every impact with its time (s) and site."""

    q: np.ndarray
    v: np.ndarray
    mode: np.ndarray
    N: np.ndarray
    T: np.ndarray
    impacts: list[tuple[float, int]] = field(default_factory=list)


def follow(model: TwoBodies, times: np.ndarray, q: np.ndarray, v: np.ndarray) -> Motion:
    """Integrate without the plant from (q, v) at time 0, without contact, to each of `times` (s)."""
    order = model.order
    found = fall(model.machine, times, q[order], v[order], tolerance=1e-11, longest=times[-1] / 100)
    motion = Motion(*np.zeros((2, len(times), 6)), found.mode[:, 0], found.N[:, 0], found.T[:, 0], found.impacts)
    motion.q[:, order], motion.v[:, order] = found.q, found.v
    return motion
