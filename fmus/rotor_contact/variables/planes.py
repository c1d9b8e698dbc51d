"""The rotor's planes that have variables in the plant: discs, bearings, contact sites and sensors."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any


@dataclass(frozen=True)
class ContactSite:
    """A contact site."""

    name: str
    clearance: float  # start values of clearance and journal radius (m)
    journal_radius: float
    bearing: str = ""  # whose retainer the site is, if any
    sensor: str = ""  # plane at the same position, if any
    stator: str = ""  # bearing whose stator bore the site is, if any
    z: float | None = None  # position (m)


@dataclass(frozen=True)
class MeasuredPlane:
    """A plane where displacements are measured; `x` and `y` are the names of the two variables."""

    name: str
    x: str
    y: str


@dataclass(frozen=True)
class Face:
    """A face that limits the rotor's axial motion."""

    name: str
    clearance: float  # start values of clearance and mean radius (m)
    radius: float
    retainer: str = ""  # the contact site on whose retainer the face lands, if any


@dataclass(frozen=True)
class Planes:
    """Names of all planes by kind, in the order of their variables."""

    discs: tuple[str, ...]  # planes of unbalance and external forces
    bearings: tuple[str, ...]  # magnetic bearings
    sites: tuple[ContactSite, ...]
    sensors: tuple[MeasuredPlane, ...]
    max_substep: float = 250e-6  # start value of solver.max_substep (s), shorter for a rotor with faster modes
    polar_inertia: float = 1.0  # start value of spin.inertia (kg m^2)
    valid_to: float = math.inf  # frequency (rad/s) up to which the reduced rotor is accurate; infinite without a limit
    # For each bearing, sensor plane or site, by name: the sites whose journals move it while the rest of the rotor is
    # fixed.
    moved_by: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    # Whether a steady load in x deflects the rotor in y, due to damping that rotates with the shaft or due to seals.
    mixes_axes: bool = False
    seals: tuple[str, ...] = ()  # seals and passive bearings whose coefficients depend on the speed
    thrust: str = ""  # disc of an axial bearing; without one the rotor does not move along its shaft
    faces: tuple[Face, ...] = ()
    loss_factor: float = 0.0  # of the shaft, whose damping the constants contain as viscous damping; 0 if there is none
    implausible: tuple[str, ...] = ()  # sentences about implausible dimensions of the rotor

    def layout(self) -> dict[str, Any]:
        """Return the fields as JSON types, for storage in an FMU; a frequency without a limit is None."""
        return asdict(self) | {"valid_to": self.valid_to if math.isfinite(self.valid_to) else None}
