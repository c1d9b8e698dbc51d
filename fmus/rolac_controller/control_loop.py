"""Connections of a controller: magnetic bearings, sensor planes, and the plane that closes each bearing's loop."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any, NamedTuple

N_HARMONICS = 4  # controlled at the same time
MAX_BEARINGS = 30  # `contact_state` has a bit for each, and FMI's integers have 32


@dataclass(frozen=True)
class SensorPlane:
    """A plane with two displacement sensors; `x` and `y` name their signals, and `position` (m) is axial."""

    name: str
    x: str
    y: str
    position: float


class LoopAxis(NamedTuple):
    """An axis of a bearing, x or y, and the signal that closes its loop."""

    bearing: str
    direction: str
    sensor: str

    @property
    def name(self) -> str:
        """Name of the axis, such as `mb1.x`."""
        return f"{self.bearing}.{self.direction}"


class SensorSignal(NamedTuple):
    """The name of a sensor's signal, and a description of the sensor's position."""

    name: str
    where: str


@dataclass(frozen=True)
class ControlLoop:
    """Bearings and sensor planes of a controller, both in the order of the variables.

    bearings
        Names of the magnetic bearings.
    planes
        Sensor planes; the synchronous control uses all of their sensors.
    feedback
        For each bearing, the name of the sensor plane that its PID reads.

    Raises
    ------
    ValueError
        If there is no bearing or there are more than `MAX_BEARINGS`, or if the plane that the PID of a bearing reads is
        not among the sensor planes.
    """

    bearings: tuple[str, ...]
    planes: tuple[SensorPlane, ...]
    feedback: tuple[str, ...]

    def __post_init__(self) -> None:
        if not 1 <= len(self.bearings) <= MAX_BEARINGS:
            raise ValueError(f"{len(self.bearings)} bearings is not allowed; there must be 1 to {MAX_BEARINGS}")
        _check_feedback(self.bearings, self.feedback, [plane.name for plane in self.planes])

    @property
    def axes(self) -> tuple[LoopAxis, ...]:
        """Axes of all bearings, in order: x and y of each bearing."""
        plane_of = {plane.name: plane for plane in self.planes}
        closed = [(b, plane_of[name]) for b, name in zip(self.bearings, self.feedback, strict=True)]
        return tuple(LoopAxis(b, a, sensor) for b, plane in closed for a, sensor in (("x", plane.x), ("y", plane.y)))

    @property
    def sensors(self) -> tuple[SensorSignal, ...]:
        """Sensors of all planes, in order: x and y of each plane."""
        return tuple(
            SensorSignal(s, f"at plane {p.name} in {a}") for p in self.planes for s, a in ((p.x, "x"), (p.y, "y"))
        )

    @property
    def sensor_names(self) -> tuple[str, ...]:
        """Names of the sensors' signals."""
        return tuple(sensor.name for sensor in self.sensors)

    @property
    def axis_names(self) -> tuple[str, ...]:
        """Names of the axes, such as `mb1.x`."""
        return tuple(axis.name for axis in self.axes)

    @property
    def shape(self) -> tuple[int, int]:
        """Shape of a receptance: number of sensors, number of axes."""
        return 2 * len(self.planes), 2 * len(self.bearings)

    def layout(self) -> dict[str, Any]:
        """Return the fields as JSON types, for storage in an FMU."""
        return asdict(self)


def _check_feedback(bearings: Sequence[str], feedback: Sequence[str], planes: Sequence[str]) -> None:
    for k, bearing in enumerate(bearings):
        if k >= len(feedback) or feedback[k] not in planes:
            named = f"there is no plane {feedback[k]!r}; " if k < len(feedback) else ""
            there = f"the rotor has {'the' if planes else 'no'} sensor planes {', '.join(planes)}".rstrip()
            raise ValueError(
                f"bearing {bearing!r} has no sensors: {named}{there}; its control needs its own sensor plane"
            )
        if feedback[k] in feedback[:k]:
            other = bearings[feedback.index(feedback[k])]
            raise ValueError(
                f"bearing {bearing!r} has no sensors of its own: the sensors of plane {feedback[k]!r} close the loop "
                f"of {other!r}; each bearing needs its own sensor plane"
            )
