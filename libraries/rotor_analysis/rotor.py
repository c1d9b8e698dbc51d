"""Description of a rotor: its shaft, its parts, and the reduction of the plant's model. SI units.

The classes define the format of a rotor file, with limits and units; `rotor_file.load_rotor` reads such a file. Objects
created in Python check their values in the same way.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import field, replace
from typing import Annotated, Any, Literal

from annotated_types import Ge, Gt, Lt
from pydantic import StrictFloat, StrictInt, StrictStr

from amb_files.checks import require
from amb_files.suggestions import suggest
from amb_files.toml import table
from amb_files.validation_errors import Unit
from rotor_analysis.checks import Moderate, Name, Node, Speed
from rotor_analysis.damping import Damping
from rotor_analysis.element import Element, Material
from rotor_analysis.parts import (
    COEFFICIENTS,
    NO_TENSOR,
    Bearing,
    BodyOrDisc,
    CentreOfMass,
    Face,
    Part,
    Point,
    Sensor,
    Site,
    ThrustDisc,
)
from rotor_analysis.shaft import Shaft, ShaftOrSections

Method = Literal["free_modes", "msdc", "none"]

KINDS = ("bodies", "bearings", "seals", "sites", "sensors", "faces")


@table
class ReductionOptions:
    """Reduction of the plant's model. Modes and masters that are not set are chosen to meet `accuracy`."""

    method: Method | None = None
    """`free_modes` retains modes of the free rotor and residual shapes of bearings and sites; `msdc` condenses the
    rotor to the translations at the nodes `masters`; `none` keeps the full model. Default: `msdc` if masters are set,
    otherwise `free_modes`.
    """
    masters: tuple[Node, ...] = ()
    """With `msdc`, the nodes at which translations are retained, including bearings and sites."""
    modes: Annotated[StrictInt, Ge(0)] | None = None
    """With `free_modes`, the number of elastic modes of the free rotor."""
    band: Annotated[StrictFloat, Gt(0.0), Moderate, Unit("Hz")] | None = None
    """With `free_modes`, the frequency up to which the receptance between bearings and sites is accurate; by default
    2 kHz, the highest frequency at which ISO 14839-3 judges the sensitivity of magnetic bearings."""
    speed: Annotated[Speed, Ge(0.0)] = 0.0
    """With `free_modes`, the highest spin speed; in a file, a text with its unit, such as `"9900 rpm"`. At this speed,
    the forward and backward whirl frequencies are accurate for modes whose backward whirl is within `band`, or for the
    first `modes`. By default only the rotor at rest is considered, so the reduced rotor may whirl too fast when it
    spins; `rotor show` reports the error.
    """
    accuracy: Annotated[StrictFloat, Gt(0.0), Lt(1.0)] = 1e-3
    """Allowed relative error of the receptance at rest and of the whirl frequencies; with `msdc`, of the first natural
    frequencies.
    """

    def __post_init__(self) -> None:
        if self.method is None:
            object.__setattr__(self, "method", "msdc" if self.masters else "free_modes")
        if self.modes is not None and self.band is not None:
            raise ValueError("modes and band are both set; set one of them")
        for name, is_set, method in (
            ("masters", len(self.masters) > 0, "msdc"),
            ("modes", self.modes is not None, "free_modes"),
            ("band", self.band is not None, "free_modes"),
            ("speed", self.speed > 0.0, "free_modes"),
        ):
            if is_set and self.method != method:
                raise ValueError(f"{name} is set, but it applies only to {method}, not to {self.method!r}")


@table
class Mesh:
    """Fineness of the elements: halving an element changes no natural frequency by more than the allowed value."""

    modes: Annotated[StrictInt, Ge(1)] = 6
    """Number of modes, from the lowest."""
    accuracy: Annotated[StrictFloat, Gt(0.0), Lt(1.0)] = 1e-4
    """Allowed relative change of a natural frequency when an element is halved."""


@table
class Rotor:
    """A rotor: shaft, bodies, bearings, seals, contact sites, sensors, faces, damping, and materials.

    Parts can be placed by `z`. The shaft then gets a node at this position, and the node numbers of parts and masters
    refer to the mesh with these nodes.

    Raises
    ------
    ValueError
        If a value is out of range, if a part is at a position that the shaft does not have, or if two parts have the
        same name; the message has one line for each mistake.

    Examples
    --------
    >>> from rotor_analysis.parts import Bearing, Disc
    >>> from rotor_analysis.shaft import Shaft
    >>> shaft = Shaft((0.0, 0.5, 1.0), (0.05,), youngs_modulus=210e9, density=7850.0, poissons_ratio=0.3)
    >>> supports = (Bearing("left", 1, stiffness=1e7), Bearing("right", 3, stiffness=1e7))
    >>> fan = Rotor("fan", shaft, (Disc("wheel", 2, 10.0, 0.1, 0.06),), supports)
    >>> round(fan.mass, 2)  # of shaft and wheel (kg)
    25.41
    """

    name: StrictStr
    """Name in figures and reports."""
    shaft: ShaftOrSections
    """Nodes or sections, material and theory."""
    bodies: tuple[BodyOrDisc, ...] = ()
    """Rigid bodies and discs on the shaft."""
    bearings: tuple[Bearing, ...] = ()
    """Linear bearings for analyses. In co-simulation only their positions matter, because another component applies the
    forces."""
    sites: tuple[Site, ...] = ()
    """Contact sites."""
    sensors: tuple[Sensor, ...] = ()
    """Planes of displacement sensors."""
    reduction: ReductionOptions = ReductionOptions()
    """Reduction of the plant's model."""
    materials: dict[Name, Material] = field(default_factory=dict, hash=False)
    """Materials of elements and sleeves, by name."""
    mesh: Mesh | None = None
    """Fineness of the elements; by default the nodes are used unchanged."""
    damping: Damping = Damping()
    """Damping of the rotor without its bearings."""
    seals: tuple[Bearing, ...] = ()
    """Seals and passive bearings, which act both in analyses and in co-simulation."""
    thrust_disc: ThrustDisc | None = None
    """Disc of an axial magnetic bearing; without it the rotor does not move along its shaft."""
    faces: tuple[Face, ...] = ()
    """Faces that stop the rotor along its shaft."""

    def __post_init__(self) -> None:
        errors = [*self._misplaced(), *self._misnamed()]
        if errors:
            raise ValueError("\n".join(errors))
        shaft = self.shaft.with_nodes_at(part.z for _, part in self._parts() if part.z is not None)
        masters = list(self.masters)  # as numbered in the file, without the nodes at `z`
        for name, value in self._fields_on(shaft).items():
            object.__setattr__(self, name, value)
        require(len(set(masters)) == len(masters), "reduction.masters", masters, "a list without repetition")
        retained: tuple[Part, ...] = (*self.bearings, *self.sites)
        missing = [part.name for part in retained if part.node not in self.masters]
        allowed = f"a list that contains the nodes of bearings and sites: {', '.join(missing)}"
        require(not masters or not missing, "reduction.masters", masters, allowed)
        require(len(masters) != 1, "reduction.masters", masters, "two nodes or more")
        require(bool(self.bodies) or self.mass > 0.0, "mass of shaft and bodies", "0 kg", "> 0 kg")

    def _parts(self) -> Iterator[tuple[str, Part]]:
        """Yield every part with its key."""
        for kind in KINDS:
            for k, part in enumerate(getattr(self, kind)):
                yield f"{kind}[{k}]", part

    def _misplaced(self) -> Iterator[str]:
        """Yield a sentence for each part or master at a position that the shaft does not have."""
        nodes = self.shaft.nodes
        allowed = f"from {nodes[0]:g} m to {nodes[-1]:g} m, on the shaft"
        for key, part in self._parts():
            if part.z is not None and self.shaft.node_at(part.z) is None and not nodes[0] < part.z < nodes[-1]:
                yield f"{key}.z ({part.name}) = {part.z} m is not allowed; it must be {allowed}"
        disc = self.thrust_disc
        if disc is not None and not nodes[0] <= disc.z <= nodes[-1]:
            yield f"thrust_disc.z = {disc.z} m is not allowed; it must be {allowed}"
        numbers = [(f"{key}.node ({part.name})", part.node) for key, part in self._parts()]
        numbers += [(f"reduction.masters[{k}]", node) for k, node in enumerate(self.masters)]
        for what, node in numbers:
            if node > len(nodes):
                yield f"{what} = {node} is not allowed; it must be a node number from 1 to {len(nodes)}"

    def _misnamed(self) -> Iterator[str]:
        """Yield a sentence for each duplicate name of a part or signal, and for each unknown name."""
        names = [(f"{key}.name", part.name) for key, part in self._parts()]
        if self.thrust:
            names.append(("thrust_disc.name", self.thrust))
        signals = [(f"sensors[{k}].{axis}", getattr(s, axis)) for k, s in enumerate(self.sensors) for axis in "xy"]
        taken: set[str] = set()
        for key, name in (*names, *signals):
            if name in taken:
                yield f"{key} = {name!r} is not allowed; it must be unique on the rotor"
            taken.add(name)
        for material in dict.fromkeys((*self.shaft.material, *(sleeve.material for sleeve in self.shaft.sleeves))):
            if material is not None and material not in self.materials:
                yield f"shaft.material = {material!r} is not one of the materials; {suggest(material, self.materials)}"
        bearings = [bearing.name for bearing in self.bearings]
        for k, site in enumerate(self.sites):
            for key, bearing in (("bearing", site.bearing), ("stator", site.stator)):
                if bearing is not None and bearing not in bearings:
                    hint = suggest(bearing, bearings)
                    yield f"sites[{k}].{key} ({site.name}) = {bearing!r} is not the name of a bearing; {hint}"
            if site.bearing is not None and site.stator is not None:
                yield f"sites[{k}] ({site.name}) sets both bearing and stator; it may set only one of them"
        sites = [site.name for site in self.sites]
        for k, face in enumerate(self.faces):
            if face.retainer is not None and face.retainer not in sites:
                hint = suggest(face.retainer, sites)
                yield f"faces[{k}].retainer ({face.name}) = {face.retainer!r} is not the name of a site; {hint}"
        if self.faces and self.thrust_disc is None:
            yield "faces require a [thrust_disc]; without one the rotor does not move along its shaft"

    def _fields_on(self, shaft: Shaft) -> dict[str, Any]:
        """Return the fields of this rotor on another mesh of its shaft; this mesh must contain the required nodes."""

        def number(node: int, z: float | None = None) -> int:
            position = self.shaft.nodes[node - 1] if z is None else z
            result = shaft.node_at(position)
            if result is None:
                raise ValueError(
                    f"nodes = {list(shaft.nodes)} m is not allowed; it must be a list that contains {position:g} m"
                )
            return result

        parts = {
            kind: tuple(replace(part, node=number(part.node, part.z), z=None) for part in getattr(self, kind))
            for kind in KINDS
        }
        masters = tuple(number(node) for node in self.masters)
        return {"shaft": shaft, **parts, "reduction": replace(self.reduction, masters=masters)}

    def on_mesh(self, shaft: Shaft) -> Rotor:
        """Return the same rotor on another mesh of its shaft, with parts and masters at the same positions.

        Raises
        ------
        ValueError
            If `shaft` has no node at one of these positions.
        """
        return replace(self, **self._fields_on(shaft))

    @property
    def elements(self) -> tuple[tuple[Element, ...], ...]:
        """The elements between the nodes, each followed by the sleeves on it."""
        return self.shaft.elements(self.materials)

    @property
    def masters(self) -> tuple[int, ...]:
        """Nodes whose translations the reduction retains, as set in the description of the rotor."""
        return self.reduction.masters

    @property
    def discs(self) -> tuple[BodyOrDisc, ...]:
        """The bodies that are planes of unbalance and external force."""
        return tuple(body for body in self.bodies if body.unbalance)

    @property
    def thrust(self) -> str:
        """Name of the thrust disc; empty if there is none."""
        return "" if self.thrust_disc is None else self.thrust_disc.name

    @property
    def nodes_by_name(self) -> dict[str, int]:
        """Node numbers of all parts, by their names."""
        return {part.name: part.node for _, part in self._parts()}

    def node_of(self, part: str) -> int:
        """Return the node of a part.

        Raises
        ------
        ValueError
            If the rotor has no part of this name.
        """
        parts = self.nodes_by_name
        if part not in parts:
            raise ValueError(f"rotor {self.name} has no part {part!r}; {suggest(part, parts)}")
        return parts[part]

    def point_of(self, part: str) -> Point:
        """Return the point where forces act on a part: its node, or a body's centre of mass that lies off its node.

        Raises
        ------
        ValueError
            As `node_of`.
        """
        body = next((body for body in self.bodies if body.name == part), None)
        return self.node_of(part) if body is None else _point(body)

    def position_of(self, point: Point) -> float:
        """Return the position (m) of a node or of a centre of mass."""
        return self.shaft.nodes[point - 1] if isinstance(point, int) else self.position_of(point.node) + point.offset

    @property
    def disc_points(self) -> tuple[Point, ...]:
        """The points at which unbalance and external forces act on the discs."""
        return tuple(_point(disc) for disc in self.discs)

    @property
    def part_nodes(self) -> tuple[int, ...]:
        """Node numbers of all parts: bodies, bearings, seals, sites, sensors and faces."""
        return _nodes(part for _, part in self._parts())

    @property
    def disc_nodes(self) -> tuple[int, ...]:
        """Node numbers of the planes of unbalance and external force."""
        return _nodes(self.discs)

    @property
    def bearing_nodes(self) -> tuple[int, ...]:
        """Node numbers of the bearings."""
        return _nodes(self.bearings)

    @property
    def seal_nodes(self) -> tuple[int, ...]:
        """Node numbers of the seals."""
        return _nodes(self.seals)

    @property
    def site_nodes(self) -> tuple[int, ...]:
        """Node numbers of the contact sites."""
        return _nodes(self.sites)

    @property
    def sensor_nodes(self) -> tuple[int, ...]:
        """Node numbers of the sensor planes."""
        return _nodes(self.sensors)

    def on_equal_bearings(self, stiffness: float, damping: float) -> Rotor:
        """Return the same rotor, with its seals, on isotropic bearings of this stiffness (N/m) and damping (N s/m)."""
        k, c = ((stiffness, 0.0), (0.0, stiffness)), ((damping, 0.0), (0.0, damping))
        coefficients: dict[str, Any] = dict.fromkeys(COEFFICIENTS, NO_TENSOR) | {"stiffness": k, "damping": c}
        bearings = (replace(b, **coefficients, at_speed=(), whirl_frequency=None) for b in self.bearings)
        return replace(self, bearings=tuple(bearings))

    @property
    def mass(self) -> float:
        """Total mass (kg)."""
        return sum(layer.mass for layers in self.elements for layer in layers) + sum(body.mass for body in self.bodies)


def _point(body: BodyOrDisc) -> Point:
    return CentreOfMass(body.node, body.offset) if body.offset else body.node


def _nodes(parts: Iterable[Part]) -> tuple[int, ...]:
    return tuple(part.node for part in parts)
