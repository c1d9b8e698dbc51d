"""The rotor's planes that have variables in the plant: discs, bearings, contact sites and sensors."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any


@dataclass(frozen=True)
class ContactSite:
    """A contact site: start values of its clearance and journal radius (m).

    `bearing` names the bearing if the site is its retainer, and `stator` names it if the site is its stator bore.
    `sensor` names the sensor plane at the same position, if any. `z` is the position of the site (m).
    """

    name: str
    clearance: float
    journal_radius: float
    bearing: str = ""
    sensor: str = ""
    stator: str = ""
    z: float | None = None


@dataclass(frozen=True)
class MeasuredPlane:
    """A plane where displacements are measured; `x` and `y` are the names of the two variables."""

    name: str
    x: str
    y: str


@dataclass(frozen=True)
class Face:
    """A face that limits the rotor's axial motion: start values of its clearance and mean radius (m).

    `retainer` is the contact site on whose retainer the face lands, if any.
    """

    name: str
    clearance: float
    radius: float
    retainer: str = ""


@dataclass(frozen=True)
class Planes:
    """Names of all planes by kind, in the order of their variables.

    discs
        Planes of unbalance and external forces.
    bearings
        Magnetic bearings: names.
    sites, sensors
        Contact sites and sensor planes.
    max_substep
        Start value of solver.max_substep (s), shorter for a rotor with faster modes.
    polar_inertia
        Start value of spin.inertia (kg m^2).
    valid_to
        Frequency (rad/s) up to which the reduced rotor is accurate, used to judge a run.
    moved_by
        For each bearing, sensor plane or site, by name: the sites whose journals move it while the rest of the rotor is
        fixed.
    mixes_axes
        Whether a steady load in x deflects the rotor in y, due to damping that rotates with the shaft or due to seals.
    seals
        Names of the seals and passive bearings whose coefficients depend on the speed.
    thrust
        Name of the disc of an axial bearing; without one the rotor does not move along its shaft.
    faces
        Faces that limit the rotor's axial motion.
    loss_factor
        Loss factor of the shaft, whose damping the constants contain as viscous damping; 0 if there is none.
    implausible
        Sentences about implausible dimensions of the rotor.
    """

    discs: tuple[str, ...]
    bearings: tuple[str, ...]
    sites: tuple[ContactSite, ...]
    sensors: tuple[MeasuredPlane, ...]
    max_substep: float = 250e-6
    polar_inertia: float = 1.0
    valid_to: float = 0.0
    moved_by: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    mixes_axes: bool = False
    seals: tuple[str, ...] = ()
    thrust: str = ""
    faces: tuple[Face, ...] = ()
    loss_factor: float = 0.0
    implausible: tuple[str, ...] = ()

    def layout(self) -> dict[str, Any]:
        """Return the fields as JSON types, for storage in an FMU."""
        return asdict(self)
