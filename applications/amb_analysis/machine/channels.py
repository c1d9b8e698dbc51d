"""Measurement channels, and the places on a rotor that their names and units identify.

    fan.x       displacement (m), velocity (m/s), acceleration (m/s^2) or force (N) at the part `fan`, along x; for a
                body with an `offset`, at its centre of mass
    0.12 m.y    the same at a position on the shaft
    eye_up      the signal of a sensor, as its rotor file names it
    fan.f_x     force on a part
    left.i_x    current (A) of an axis of a magnetic bearing: injected into its demand, or demanded
    thrust.z    the same along the shaft of a rotor with a thrust disc: thrust.z, thrust.f_z, thrust.i_z

Names that begin with a component, as in a run, are also allowed: `rotor_contact.fan.f_x`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from amb_cosim.cosim.system.values import plain_number
from amb_cosim.results.component_names import ACTUATOR, CONTROLLER, PLANT
from amb_files.suggestions import suggest
from fmi_export.building.units import to_unit
from rotor_analysis.harmonic import harmonic_points
from rotor_analysis.parts import Point
from rotor_analysis.rotor import Rotor

ORDERS = {"m": 0, "m/s": 1, "m/s2": 2}  # derivatives of the displacement
KINDS = "", "f_", "i_"
DIRECTIONS = {f"{kind}{axis}": axis for kind in KINDS for axis in "xy"}


@dataclass(frozen=True)
class Place:
    """A quantity at a place on the rotor.

    name
        Name of the channel.
    place
        Name of a part, or the text of a position.
    direction
        `x` or `y`; `z` at the thrust disc.
    unit
        m, m/s, m/s2, N or A.
    position
        Axial position on the shaft (m); None for a part.
    """

    name: str
    place: str
    direction: str
    unit: str
    position: float | None = None

    @property
    def order(self) -> int:
        """Order of the derivative of the displacement, from 0 to 2."""
        return ORDERS[self.unit]

    @property
    def axis_name(self) -> str:
        """Name of the axis, such as `bearing.x`."""
        return f"{self.place}.{self.direction}"

    def point_on(self, rotor: Rotor) -> Point:
        """Return the point of a lateral channel on a rotor: a node, or the centre of mass of a body with an `offset`.

        Raises
        ------
        ValueError
            If the rotor has no such part, or no node at the position.
        """
        if self.position is not None:
            node = rotor.shaft.node_at(self.position)
            if node is None:
                raise ValueError(f"{self.name}: the rotor has no node at {self.position:g} m")
            return node
        try:
            return rotor.point_of(self.place)
        except ValueError as error:
            raise ValueError(f"{self.name}: {error}") from None


def place_of(name: str, unit: str, rotor: Rotor, *, is_input: bool) -> Place:
    """Return the place of a channel from its name and unit.

    Raises
    ------
    ValueError
        If the name does not denote a place on the rotor, or if the unit is not allowed for such a channel.
    """
    allowed = ("N", "A") if is_input else (*ORDERS, "A")
    if unit not in allowed:
        kind = "input" if is_input else "output"
        raise ValueError(f"{name}: an {kind} in {unit} is not allowed; it must be in {', '.join(allowed)}")
    component, _, rest = name.partition(".")
    variable = rest if component in (PLANT, ACTUATOR, CONTROLLER) else name
    for sensor in rotor.sensors:
        for direction in "xy":
            if variable == getattr(sensor, direction):
                return Place(name, sensor.name, direction, unit)
    if rotor.thrust and variable in [f"{rotor.thrust}.{kind}z" for kind in KINDS]:
        return Place(name, rotor.thrust, "z", unit)
    place, _, ending = variable.rpartition(".")
    if not place or ending not in DIRECTIONS:
        signals = [getattr(sensor, axis) for sensor in rotor.sensors for axis in "xy"]
        along = [f"{rotor.thrust}.z"] if rotor.thrust else []
        allowed_names = [*signals, *(f"{part}.{axis}" for part in rotor.nodes_by_name for axis in "xy"), *along]
        raise ValueError(f"channel {name!r} is not a place of rotor {rotor.name}; {suggest(variable, allowed_names)}")
    if place in rotor.nodes_by_name:
        return Place(name, place, DIRECTIONS[ending], unit)
    if plain_number(place) is not None:  # a node of an instrument has a number, too
        raise ValueError(
            f"channel {name!r}: {place} is not a place of rotor {rotor.name}; a position must have a unit, as in "
            f"'0.12 m.{ending}', and a measured channel needs a place: channels={{'{name}': '0.12 m.{ending}'}}"
        )
    try:
        position = to_unit(place, "m", name)
    except ValueError:
        hint = suggest(place, rotor.nodes_by_name)
        raise ValueError(f"channel {name!r}: rotor {rotor.name} has no part {place!r}; {hint}") from None
    return Place(name, place, DIRECTIONS[ending], unit, position)


def node_rows(rotor: Rotor, places: Sequence[Place]) -> list[int]:
    """Return the row of each place among the displacements: x and y of every point of `harmonic_points`, then z."""
    points = harmonic_points(rotor)

    def row(place: Place) -> int:
        is_axial = place.direction == "z"
        return 2 * len(points) if is_axial else 2 * points.index(place.point_on(rotor)) + "xy".index(place.direction)

    return [row(place) for place in places]
