"""Description of a rotor: shaft, parts, mass, modes, and the plant's model."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Annotated, ClassVar

from amb_analysis.studies.coefficient_limits import EXTRAPOLATED, Limits, is_extrapolated, limit_notes, limits_of
from amb_analysis.studies.result import DrawnResult
from amb_cosim.presentation.json_data import Layout
from amb_cosim.presentation.text_tables import TextBlock, number, text_table
from array_types import Array
from rotor_analysis.assembly import assemble
from rotor_analysis.reduced_rotor import reduced_rotor, reduction_error, valid_to
from rotor_analysis.rigid_body import rigid_body
from rotor_analysis.rotor import Rotor
from rotor_analysis.rotor_file import RotorSource, load_rotor, numbered_positions

COUNT = 6  # modes


@dataclass(frozen=True)
class LayoutEntry:
    """A part of the rotor: kind, name, node number in its file, position (m) and function; None for other nodes."""

    kind: str
    name: str
    node: int | None
    z: Annotated[float, "m"]
    what: str


@dataclass(frozen=True)
class PlantModel:
    """A reduced model of the rotor: mesh nodes of its planes, number of coordinates, highest valid frequency."""

    masters: tuple[int, ...]
    coordinates: int
    valid_to: Annotated[float, "rad/s"]

    def text(self, z: Sequence[float], numbers: Mapping[int, int]) -> str:
        """Return it in words, for positions (m) of nodes, and their numbers in the rotor file if it has them."""
        planes = f"z = {', '.join(f'{z[node - 1]:.4g}' for node in self.masters)} m"
        if set(self.masters) <= numbers.keys():
            planes = f"nodes {', '.join(str(numbers[node]) for node in self.masters)}"
        return f"{self.coordinates} coordinates, planes at {planes}; holds up to {number(self.valid_to)} rad/s"


@dataclass(frozen=True, eq=False, repr=False)
class RotorLayout(DrawnResult):
    """A rotor, its modes at rest on its bearings, and the reduced model of a plant.

    rotor
        Its name.
    mass, centre, polar_inertia, diametral_inertia
        Rigid-body properties: kg, m, kg m^2 about the axis, and kg m^2 about the centre of mass.
    length, nodes
        Length of the shaft (m), and number of nodes of the mesh.
    numbers
        Numbers of nodes in the rotor file, by those of the mesh, which also has nodes for `z` and `[mesh]`.
    parts
        Bodies, bearings, contact sites and sensors.
    method, masters, coordinates, valid_to
        The plant's model: reduction method, mesh nodes of its planes, number of coordinates, and the frequency up to
        which it is valid (rad/s), see `rotor_analysis.reduced_rotor.valid_to`.
    leaner
        The model with planes only at bearings and contact sites, which require one; None if it does not have fewer
        coordinates. Unbalance, external forces and sensors require no plane.
    frequencies, error
        Undamped natural frequencies of the full model (rad/s), negative where motion diverges, and relative errors of
        those of the plant's model (%).
    description
        The rotor, for the figure.
    limits
        Limits of the coefficients of bearings and seals.
    """

    name: ClassVar[str] = "layout"

    rotor: str
    mass: Annotated[float, "kg"]
    centre: Annotated[float, "m"]
    polar_inertia: Annotated[float, "kg.m2"]
    diametral_inertia: Annotated[float, "kg.m2"]
    length: Annotated[float, "m"]
    nodes: int
    numbers: Annotated[dict[int, int], Layout.OMITTED]
    parts: tuple[LayoutEntry, ...]
    method: str
    masters: tuple[int, ...]
    coordinates: int
    valid_to: Annotated[float, "rad/s"]
    leaner: PlantModel | None
    frequencies: Annotated[Array, "rad/s"]
    error: Annotated[Array, "%"]
    description: Annotated[Rotor, Layout.OMITTED]
    limits: Limits = ()

    def text(self) -> list[TextBlock]:
        """Return lines about the rotor, and tables of its parts and its modes."""
        inertia = f"inertia {self.polar_inertia:.4g} kg m2 about the axis, {self.diametral_inertia:.4g} across"
        parts = text_table("Parts", ("kind", "name", "node", "z (m)", "what"), left=("kind", "name", "what"))
        for part in self.parts:
            parts.add_row(
                part.kind, part.name, "-" if part.node is None else str(part.node), f"{part.z:.4f}", part.what
            )
        where = "at rest on its bearings" if self.description.bearings else "free, without bearings"
        where += f" ({EXTRAPOLATED})" if is_extrapolated(self.limits, 0.0) else ""
        modes = text_table(f"Undamped, {where}", ("mode", "frequency (rad/s)", "(Hz)", "plant (%)"))
        for k, (frequency, error) in enumerate(zip(self.frequencies, self.error, strict=True), start=1):
            displayed = "-" if math.isnan(error) else f"{error:+.4f}"
            hertz = f"{frequency / (2.0 * math.pi):.3f}" if frequency > 0.0 else "diverges"
            modes.add_row(str(k), f"{frequency:.3f}", hertz, displayed)
        z = self.description.shaft.nodes
        plant = PlantModel(self.masters, self.coordinates, self.valid_to).text(z, self.numbers)
        fewer = "" if self.leaner is None else self.leaner.text(z, self.numbers)
        leaner = [f"with reduction.masters at bearings and sites: {fewer}"] if fewer else []
        return [
            f"{self.rotor}: {self.mass:.4g} kg, {self.length:.4g} m, {self.nodes} nodes",
            f"centre of mass at {self.centre:.4g} m; {inertia}",
            parts,
            modes,
            *limit_notes(self.limits, [0.0]),
            f"plant by {self.method}: {plant}",
            *leaner,
            f"damping: {_damping(self.description)}",
        ]


def layout(rotor: RotorSource = None) -> RotorLayout:
    """Return the parts, mass and modes of a rotor, and the plant's model of it.

    Parameters
    ----------
    rotor
        A rotor or a rotor file; by default the packs' default rotor.

    Raises
    ------
    ValueError
        If the rotor file cannot be read, or the plant's model is less accurate than the file requires.

    Examples
    --------
    >>> result = layout("compressor")
    >>> f"{result.mass:.1f} kg, {result.length:.3f} m, {result.nodes} nodes"
    '246.9 kg, 1.653 m, 56 nodes'
    """
    result = load_rotor(rotor)
    body, plant, error = rigid_body(result), _plant(result), reduction_error(result, COUNT)
    z = result.shaft.nodes
    nodes = ((result.shaft.node_at(place), k) for k, place in enumerate(numbered_positions(rotor), start=1))
    numbers = {node: k for node, k in nodes if node is not None}
    return RotorLayout(
        rotor=result.name,
        mass=body.mass,
        centre=body.centre,
        polar_inertia=body.polar_inertia,
        diametral_inertia=body.diametral_inertia,
        length=z[-1] - z[0],
        nodes=len(z),
        numbers=numbers,
        parts=tuple(replace(part, node=numbers.get(part.node or 0)) for part in _parts(result)),
        method=str(result.reduction.method),
        masters=plant.masters,
        coordinates=plant.coordinates,
        valid_to=plant.valid_to,
        leaner=_leaner(result, plant),
        frequencies=error.frequencies,
        error=error.percent,
        description=result,
        limits=limits_of((*result.bearings, *result.seals)),
    )


def _plant(rotor: Rotor) -> PlantModel:
    model = reduced_rotor(rotor).model
    return PlantModel(tuple(model.translations), model.size, valid_to(assemble(rotor), model))


def _leaner(rotor: Rotor, plant: PlantModel) -> PlantModel | None:
    """The plant's model with planes only at bearings, seals and sites and as many modes, if that is smaller."""
    needed = tuple(sorted({*rotor.bearing_nodes, *rotor.seal_nodes, *rotor.site_nodes}))
    if rotor.reduction.method != "craig_bampton" or len(needed) < 2:
        return None
    try:
        result = _plant(replace(rotor, reduction=replace(rotor.reduction, masters=needed)))
    except ValueError:  # the shaft does not reach the accuracy on these planes
        return None
    return result if result.coordinates < plant.coordinates else None


def _damping(rotor: Rotor) -> str:
    """The damping of a rotor without its bearings, in words."""
    damping = rotor.damping
    ratios = ", ".join(f"{100.0 * ratio:g} %" for ratio in damping.modal)
    values = {
        f"{damping.mass:g} 1/s times mass": damping.mass,
        f"{damping.stiffness:g} s times stiffness": damping.stiffness,
        f"{ratios} of the elastic modes": any(damping.modal),
        f"loss factor {damping.loss_factor:g}": damping.loss_factor,
    }
    said = [words for words, value in values.items() if value]
    return ", ".join([*said, f"{100.0 * damping.rotating:g} % turns with the shaft"]) if said else "none"


def _parts(rotor: Rotor) -> Iterator[LayoutEntry]:
    z = rotor.shaft.nodes
    for body in rotor.bodies:
        inertia = f"{number(body.mass)} kg, {number(body.polar_inertia)} kg m2 about the axis"
        yield LayoutEntry(
            "disc" if body.unbalance else "body",
            body.name,
            body.node,
            z[body.node - 1],
            inertia + (", unbalance" if body.unbalance else ""),
        )
    for kind, bearing in (*(("bearing", b) for b in rotor.bearings), *(("seal", s) for s in rotor.seals)):
        K, C, _ = bearing.at(0.0)
        stated = f"{number(K[0, 0])} N/m, {number(C[0, 0])} N s/m along x"
        if K[0, 1] or K[1, 0]:
            stated += f", cross-coupled {number(K[0, 1])} and {number(K[1, 0])} N/m"
        what = stated + (" at rest" if bearing.at_speed else "")
        yield LayoutEntry(kind, bearing.name, bearing.node, z[bearing.node - 1], what)
    for site in rotor.sites:
        stator = f"stator of {site.stator}" if site.stator else "bush"
        what = f"retainer of {site.bearing}" if site.bearing else stator
        yield LayoutEntry("contact site", site.name, site.node, z[site.node - 1], what)
    for sensor in rotor.sensors:
        yield LayoutEntry("sensor", sensor.name, sensor.node, z[sensor.node - 1], f"{sensor.x}, {sensor.y}")
