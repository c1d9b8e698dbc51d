"""The planes of a rotor that the plant has variables for: discs, bearings, contact sites and sensors."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any


@dataclass(frozen=True)
class ContactSite:
    """A place where the rotor can touch: start values of its clearance and journal radius (m).

    `bearing` is the bearing whose retainer it is, `sensor` the sensor plane in the same place, if there are.
    """

    name: str
    clearance: float
    journal_radius: float
    bearing: str = ""
    sensor: str = ""


@dataclass(frozen=True)
class MeasuredPlane:
    """A plane where displacements are measured; `x` and `y` are the names of the two variables."""

    name: str
    x: str
    y: str


@dataclass(frozen=True)
class Planes:
    """Names of all planes, each kind in the order of its variables.

    discs
        Where unbalance sits and external forces act.
    bearings
        Magnetic bearings: names.
    sites, sensors
        Where the rotor can touch, and where it is measured.
    max_substep
        Start value of solver.max_substep (s), shorter for a rotor with faster modes.
    polar_inertia
        Start value of spin.inertia (kg m^2).
    valid_to
        Frequency up to which the reduction of the rotor holds (rad/s), for those who judge a run.
    moved_by
        For a bearing, sensor plane or site, by name: sites whose journal moves it while the rest of the rotor stays.
    mixes_axes
        Whether a steady load in x deflects the rotor in y, by damping that rotates with the shaft or by seals.
    seals
        Names of seals and passive bearings with coefficients over the speed.
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

    def layout(self) -> dict[str, Any]:
        """Return the same in types of JSON, which an FMU keeps."""
        return asdict(self)
