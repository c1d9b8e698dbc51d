"""Parts on the shaft: bodies, bearings, contact sites, sensors and faces, each at a node or at a position z."""

from __future__ import annotations

import math
from collections.abc import Iterable
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, Any, Literal, NamedTuple

import numpy as np
from annotated_types import Ge
from pydantic import AfterValidator, BeforeValidator, Discriminator, Field, StrictBool, Tag

from amb_files.checks import require
from amb_files.toml import table
from amb_files.validation_errors import Unit
from array_types import Array
from rotor_analysis.checks import Inertia, Length, Mass, Name, Node, Offset, Position, Size, Speed, Variable

if TYPE_CHECKING:
    from scipy.interpolate import PchipInterpolator

Tensor = tuple[tuple[float, float], tuple[float, float]]  # ((xx, xy), (yx, yy))


def _as_tensor(value: object) -> object:
    """Return a 2 x 2 tensor unchanged, and a single number as the tensor of an isotropic bearing."""
    rows: Any = value if isinstance(value, list | tuple) else ((value, 0.0), (0.0, value))
    is_matrix = len(rows) == 2 and all(isinstance(row, list | tuple) and len(row) == 2 for row in rows)
    if not is_matrix or not all(_is_finite(number) for row in rows for number in row):
        raise ValueError("it must be a finite number or [[xx, xy], [yx, yy]] of finite numbers")
    return tuple(tuple(float(number) for number in row) for row in rows)


def _is_finite(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


def _as_moderate(tensor: Tensor) -> Tensor:
    if max(abs(number) for row in tensor for number in row) > 1e20:
        raise ValueError("it must be at most 1e20 in magnitude")
    return tensor


COEFFICIENTS = ("stiffness", "damping", "mass", "tilt_stiffness", "tilt_damping")  # of a bearing or seal
NO_TENSOR: Tensor = ((0.0, 0.0), (0.0, 0.0))
TensorOrNumber = Annotated[Tensor, BeforeValidator(_as_tensor), AfterValidator(_as_moderate)]
DEFAULT_CLEARANCE = 0.5e-3  # m
AT_Z = 0  # in place of the node of a part that is placed by z
NodeUnlessZ = Annotated[Node, Field(default=AT_Z)]  # `= AT_Z` in a class would require defaults of all fields after it


class CentreOfMass(NamedTuple):
    """A centre of mass that lies off its node and is rigidly connected to it, so that it moves by x + offset x'.

    node, offset
        Node number, and distance (m) from it, positive along +z.
    """

    node: int
    offset: float


Point = int | CentreOfMass
"""A node number, or a centre of mass that lies off its node."""


def seat(point: Point) -> int:
    """Return the node with which a point moves."""
    return point if isinstance(point, int) else point.node


class _Placed:
    """A part on the shaft, at `node`; a part that is placed by `z` gets the node at `z` from its rotor."""

    node: int
    z: float | None

    def __post_init__(self) -> None:
        if (self.node == AT_Z) == (self.z is None):
            raise ValueError(f"{'node and z are both set' if self.node else 'node and z are missing'}; set one of them")


@table
class Body(_Placed):
    """A rigid body on the shaft. A body that only marks a plane of unbalance has mass 0."""

    name: Name
    """Name of the part; the names of its variables in the plant begin with it."""
    node: NodeUnlessZ
    """Node number, counted from 1; omit it if `z` is set."""
    mass: Mass
    """Mass."""
    diametral_inertia: Inertia
    """Moment of inertia about a diameter through the centre of mass."""
    polar_inertia: Inertia
    """Moment of inertia about the axis."""
    unbalance: StrictBool = False
    """Whether an unbalance and an external force act here; they are the plant's inputs NAME.u, NAME.phi, NAME.f_x and
    NAME.f_y."""
    z: Position | None = None
    """Position along the shaft, instead of `node`; the shaft gets a node there."""
    offset: Offset = 0.0
    """Distance of the centre of mass from the position of the part, positive along +z. The body is rigid and tilts with
    the shaft there; its inertias are about the centre of mass, where unbalance and external force act."""


@table
class Disc(_Placed):
    """A homogeneous rigid disc or core on the shaft."""

    name: Name
    """Name of the part; the names of its variables in the plant begin with it."""
    node: NodeUnlessZ
    """Node number, counted from 1; omit it if `z` is set."""
    mass: Mass
    """Mass."""
    radius: Size
    """Outer radius."""
    width: Size
    """Length along the shaft."""
    unbalance: StrictBool = False
    """Whether an unbalance and an external force act here; they are the plant's inputs NAME.u, NAME.phi, NAME.f_x and
    NAME.f_y."""
    z: Position | None = None
    """Position along the shaft, instead of `node`; the shaft gets a node there."""
    offset: Offset = 0.0
    """Distance of the centre of mass from the position of the part, positive along +z. The disc is rigid and tilts with
    the shaft there; its inertias are about the centre of mass, where unbalance and external force act."""

    @property
    def diametral_inertia(self) -> float:
        """I_d = m r^2/4 + m w^2/12 (kg m^2)."""
        return self.mass * (self.radius**2 / 4.0 + self.width**2 / 12.0)

    @property
    def polar_inertia(self) -> float:
        """I_p = m r^2/2 (kg m^2)."""
        return self.mass * self.radius**2 / 2.0


def _kind_of_body(value: object) -> str:
    """Return the tag of a body: `disc` if it has a radius or a width, otherwise `body`."""
    if isinstance(value, dict):
        return "disc" if {"radius", "width"} & set(value) else "body"
    return "disc" if isinstance(value, Disc) else "body"


BodyOrDisc = Annotated[
    Annotated[Body, Tag("body")] | Annotated[Disc, Tag("disc")],
    Discriminator(_kind_of_body),
]


@table
class AtSpeed:
    """Coefficients of a bearing at a spin speed."""

    speed: Speed
    """Spin speed; in a file, a text with its unit, such as `"9900 rpm"`."""
    stiffness: Annotated[TensorOrNumber, Unit("N/m")] = NO_TENSOR
    """2 x 2 stiffness (N/m) or a number."""
    damping: Annotated[TensorOrNumber, Unit("N s/m")] = NO_TENSOR
    """2 x 2 damping (N s/m) or a number."""
    mass: Annotated[TensorOrNumber, Unit("kg")] = NO_TENSOR
    """2 x 2 mass (kg) or a number."""
    tilt_stiffness: Annotated[TensorOrNumber, Unit("N m/rad")] = NO_TENSOR
    """2 x 2 stiffness against tilt (N m/rad) or a number."""
    tilt_damping: Annotated[TensorOrNumber, Unit("N m s/rad")] = NO_TENSOR
    """2 x 2 damping of tilt (N m s/rad) or a number."""


@table
class Bearing(_Placed):
    """A linear bearing or seal. A tensor that is not diagonal couples the axes; a single number applies to both axes.

    f = -(K q + C q' + M q''),   q = (x, y) of the shaft there, f the force on it                  (1)

    K = [[k, Q], [-Q, k]] with Q > 0 drives forward whirl. On a forward circle q = (cos, sin), the cross-coupled part of
    the force is f = Q (-sin, cos), which has the direction of the velocity.

    In the same way, moments resist the slopes (x', y') of the shaft at the bearing, which are positive if x or y
    increases along z:

        m = -(K_t s + C_t s'),   s = (dx/dz, dy/dz), m the moments on the shaft that turn x and y towards z    (2)

    Their power is m . s'. A thrust disc between magnets has a negative K_t, which tilts the shaft further.
    """

    name: Name
    """Name of the part; the names of its variables in the plant begin with it."""
    node: NodeUnlessZ
    """Node number, counted from 1; omit it if `z` is set."""
    stiffness: Annotated[TensorOrNumber, Unit("N/m")] = NO_TENSOR
    """2 x 2 stiffness [[xx, xy], [yx, yy]] or a number (N/m)."""
    damping: Annotated[TensorOrNumber, Unit("N s/m")] = NO_TENSOR
    """2 x 2 damping or a number (N s/m)."""
    z: Position | None = None
    """Position along the shaft, instead of `node`; the shaft gets a node there."""
    at_speed: tuple[AtSpeed, ...] = ()
    """Coefficients at ascending spin speeds, instead of constant ones. They are interpolated monotonically and
    are constant outside the range of speeds."""
    mass: Annotated[TensorOrNumber, Unit("kg")] = NO_TENSOR
    """2 x 2 mass of a fluid that moves with the shaft, or a number (kg)."""
    whirl_frequency: Annotated[Speed, Ge(0.0)] | None = None
    """Whirl frequency at which frequency-dependent coefficients have these values; results report it. In a file, a text
    with its unit, such as `"75 Hz"`."""
    tilt_stiffness: Annotated[TensorOrNumber, Unit("N m/rad")] = NO_TENSOR
    """2 x 2 stiffness against tilt [[xx, xy], [yx, yy]] or a number (N m/rad). A negative stiffness increases
    the tilt."""
    tilt_damping: Annotated[TensorOrNumber, Unit("N m s/rad")] = NO_TENSOR
    """2 x 2 damping of tilt or a number (N m s/rad)."""

    def __post_init__(self) -> None:
        super().__post_init__()
        speeds = [row.speed for row in self.at_speed]
        ascending = all(b > a for a, b in pairwise(speeds))
        require(not speeds or (ascending and len(speeds) > 1), "at_speed", f"{speeds} rad/s", "ascending, two or more")
        for name in COEFFICIENTS:
            if speeds and getattr(self, name) != NO_TENSOR:
                raise ValueError(f"{name} and at_speed are both set; set one of them")

    def at(self, Omega: float) -> tuple[Array, Array, Array]:
        """Return K (N/m), C (N s/m) and M (kg) of (1) at spin speed Omega (rad/s), shape (2, 2) each.

        Between two speeds of the table, each coefficient stays between its values at these speeds (`interpolant`);
        outside the table, it has its value at the nearest speed.
        """
        if not self.at_speed:
            return np.array(self.stiffness), np.array(self.damping), np.array(self.mass)
        speeds = [row.speed for row in self.at_speed]
        stiffness, damping, mass = self.interpolant()(np.clip(Omega, speeds[0], speeds[-1]))
        return stiffness, damping, mass

    @property
    def tilting(self) -> Bearing | None:
        """The moments (2), as a bearing whose law (1) relates moments to slopes; None for a bearing without moments."""
        tensors = [self.tilt_stiffness, self.tilt_damping]
        tensors += [tensor for row in self.at_speed for tensor in (row.tilt_stiffness, row.tilt_damping)]
        if all(tensor == NO_TENSOR for tensor in tensors):
            return None
        rows = tuple(AtSpeed(row.speed, row.tilt_stiffness, row.tilt_damping) for row in self.at_speed)
        return Bearing(self.name, self.node, self.tilt_stiffness, self.tilt_damping, self.z, rows)

    def interpolant(self) -> PchipInterpolator:
        """Return the interpolant of the table: K, C and M, shape (3, 2, 2), as a function of the spin speed (rad/s).

        It is piecewise cubic and monotone between neighbouring speeds, so that positive damping stays positive (F. N.
        Fritsch, J. Butland, SIAM J. Sci. Stat. Comput. 5, 1984).
        """
        from scipy.interpolate import PchipInterpolator  # slow to import, and most rotors need none

        speeds = [row.speed for row in self.at_speed]
        return PchipInterpolator(speeds, np.array([(row.stiffness, row.damping, row.mass) for row in self.at_speed]))


def table_speeds(parts: Iterable[Bearing]) -> list[float]:
    """Return the spin speeds (rad/s) of all entries in the tables of bearings and seals, ascending."""
    return sorted({row.speed for part in parts for row in part.at_speed})


@table
class Site(_Placed):
    """A contact site."""

    name: Name
    """Name of the part; the names of its variables in the plant begin with it."""
    node: NodeUnlessZ
    """Node number, counted from 1; omit it if `z` is set."""
    clearance: Length = DEFAULT_CLEARANCE
    """Radial clearance."""
    journal_radius: Size | None = None
    """Radius of the rotor at the contact; by default the shaft's radius."""
    bearing: Name | None = None
    """Bearing to which this retainer belongs."""
    stator: Name | None = None
    """Bearing whose stator bore this site represents; the rotor touches the iron of the bearing's magnets there."""
    z: Position | None = None
    """Position along the shaft, instead of `node`; the shaft gets a node there."""


@table
class Sensor(_Placed):
    """A plane of displacement sensors."""

    name: Name
    """Name of the part; the names of its variables in the plant begin with it."""
    node: NodeUnlessZ
    """Node number, counted from 1; omit it if `z` is set."""
    x: Variable = ""
    """Name of the plant's variable along x; NAME.x by default."""
    y: Variable = ""
    """Name of the plant's variable along y; NAME.y by default."""
    z: Position | None = None
    """Position along the shaft, instead of `node`; the shaft gets a node there."""

    def __post_init__(self) -> None:
        super().__post_init__()
        for axis in ("x", "y"):
            object.__setattr__(self, axis, getattr(self, axis) or f"{self.name}.{axis}")


@table
class ThrustDisc:
    """The disc of an axial magnetic bearing; a rotor with such a disc can move along its shaft in co-simulation."""

    z: Position
    """Position along the shaft."""
    name: Name = "thrust"
    """Name of the part; the names of its variables in the plant begin with it."""


@table
class Face(_Placed):
    """A face that stops the rotor along its shaft, such as a shoulder against the ring of a retainer bearing."""

    name: Name
    """Name of the part; the names of its variables in the plant begin with it."""
    node: NodeUnlessZ
    """Node number, counted from 1; omit it if `z` is set."""
    stops: Literal["-z", "+z"]
    """Direction of motion that the face stops: towards smaller or larger z."""
    clearance: Length
    """Axial distance of the face from its seat when the rotor is in the middle."""
    radius: Size
    """Mean radius of the ring on which the face lands."""
    retainer: Name | None = None
    """Contact site of the retainer on which the face lands. The face turns the race of this retainer, moves the
    retainer's housing and heats both."""
    z: Position | None = None
    """Position along the shaft, instead of `node`; the shaft gets a node there."""


Part = Body | Disc | Bearing | Site | Sensor | Face
