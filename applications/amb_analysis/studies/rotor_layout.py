"""Description of a rotor: shaft, parts, mass, modes, and the plant's model."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Annotated, ClassVar

import numpy as np

from amb_analysis.studies.coefficient_limits import EXTRAPOLATED, Limits, is_extrapolated, limit_notes, limits_of
from amb_analysis.studies.result import DrawnResult, WarnedResult
from amb_cosim.cosim.system.values import RPM
from amb_cosim.presentation.digits import significant
from amb_cosim.presentation.json_data import Layout
from amb_cosim.presentation.text_tables import TextBlock, number, text_table
from amb_cosim.presentation.units import frequency_unit, speed_unit
from array_types import Array
from rotor_analysis.damping import free_modes
from rotor_analysis.implausible_sizes import implausible_sizes
from rotor_analysis.receptance_error import ReceptanceError, receptance_error
from rotor_analysis.reduced_rotor import WhirlError, reduced_rotor, reduction_error, whirl_error
from rotor_analysis.rigid_body import rigid_body
from rotor_analysis.rotor import Rotor
from rotor_analysis.rotor_file import RotorSource, load_rotor, numbered_positions
from rotor_analysis.undamped import planes_are_alike

COUNT = 6  # modes
ALLOWED_SPINNING = 0.01  # error of the receptance of the spinning rotor, above which advice is given


@dataclass(frozen=True)
class LayoutEntry:
    """A part of the rotor: kind, name, node number (None if the file does not number it), position (m) and function."""

    kind: str
    name: str
    node: int | None
    z: Annotated[float, "m"]
    what: str


@dataclass(frozen=True, eq=False, repr=False)
class RotorLayout(WarnedResult, DrawnResult):
    """A rotor, its modes at rest on its bearings, and its reduced model in a plant.

    rotor
        Name of the rotor.
    mass, centre, polar_inertia, diametral_inertia
        Rigid-body properties: kg, m, kg m^2 about the axis, and kg m^2 about the centre of mass.
    length, nodes
        Length of the shaft (m), and number of nodes of the mesh.
    numbers
        Node numbers in the rotor file, by node number of the mesh. The mesh also has nodes that `z` and `[mesh]` add.
    parts
        Bodies, bearings, seals, contact sites, thrust disc, faces and sensors.
    method, planes, coordinates, fastest
        The plant's model: reduction method, mesh nodes whose displacements are coordinates, number of coordinates, and
        frequency (rad/s) of the fastest mode without bearings. The frequency is 0 if the model has no elastic mode.
    receptance
        Error of the plant's receptance between bearings and contact sites; None for a rotor with massless nodes.
    frequencies, error
        Undamped natural frequencies of the full model (rad/s), and their relative errors (%) in the plant's model. A
        negative frequency means that the motion diverges. Each frequency belongs to both planes of motion if the
        bearings are alike in x and y.
    whirl
        Error of the plant's model in the whirl of the free rotor at the highest speed; None if the rotor file states no
        speed.
    description
        The rotor, which the figure shows.
    limits
        Validity limits of the coefficients of bearings and seals.
    warnings
        Warnings about implausible sizes.
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
    planes: tuple[int, ...]
    coordinates: int
    fastest: Annotated[float, "rad/s"]
    receptance: ReceptanceError | None
    frequencies: Annotated[Array, "rad/s"]
    error: Annotated[Array, "%"]
    whirl: WhirlError | None
    description: Annotated[Rotor, Layout.OMITTED]
    limits: Limits = ()

    def text(self) -> list[TextBlock]:
        """Return lines about the rotor, and tables of its parts and its modes."""
        inertia = f"inertia {self.polar_inertia:.4g} kg m2 about the axis, {self.diametral_inertia:.4g} across"
        parts = text_table("Parts", ("kind", "name", "node", "z (m)", "what"), left=("kind", "name", "what"))
        for part in self.parts:
            parts.add_row(part.kind, part.name, "-" if part.node is None else str(part.node), number(part.z), part.what)
        where = "at rest on its bearings" if self.description.bearings else "free, without bearings"
        where += "" if planes_are_alike(self.description) else ", which differ in x and y"
        where += f" ({EXTRAPOLATED})" if is_extrapolated(self.limits, 0.0) else ""
        modes = text_table(f"Undamped, {where}", ("mode", f"frequency ({frequency_unit().label})", "plant (%)"))
        for k, (frequency, error) in enumerate(zip(self.frequencies, self.error, strict=True), start=1):
            percent = "-" if math.isnan(error) else f"{error:+z.4f}"
            modes.add_row(str(k), frequency_unit().number(frequency, 6) if frequency > 0.0 else "diverges", percent)
        return [
            f"{self.rotor}: {self.mass:.4g} kg, {self.length:.4g} m, {self.nodes} nodes",
            f"centre of mass at {self.centre:.4g} m; {inertia}",
            parts,
            modes,
            *limit_notes(self.limits, [0.0]),
            self._plant(),
            *self._receptance_table(),
            *self._whirl_table(),
            f"damping: {_damping(self.description)}",
            *self.warning_lines(),
        ]

    def _plant(self) -> str:
        """Return a description of the plant's model in words."""
        z = self.description.shaft.nodes
        where = f"z = {', '.join(f'{z[node - 1]:.4g}' for node in self.planes)} m"
        if set(self.planes) <= self.numbers.keys():
            where = f"nodes {', '.join(str(self.numbers[node]) for node in self.planes)}"
        fastest = f"fastest mode {_hertz(self.fastest)}" if self.fastest > 0.0 else "no elastic mode"
        size = f"{self.coordinates} coordinates, planes at {where}; {fastest}"
        if self.receptance is None:
            return f"plant by {self.method}: {size}"
        limit = _hertz(self.receptance.limit) if math.isfinite(self.receptance.limit) else "its fastest mode"
        accuracy = f"{100.0 * self.receptance.accuracy:g} % up to {limit}"
        within = f"error of the receptance at rest between bearings and sites: at most {accuracy}"
        return f"plant by {self.method}: {size}; {within}"

    def _receptance_table(self) -> list[TextBlock]:
        """Return the table of the receptance's error; empty if it was not computed."""
        error = self.receptance
        if error is None or not len(error.frequencies):
            return []
        unit = speed_unit()
        columns = ("frequency", "at rest (%)", f"turning at ({unit.label})", "for unbalance (%)")
        table = text_table("Error of the plant's receptance", columns)
        for frequency, at_rest, spinning in zip(error.frequencies, error.error, error.spinning, strict=True):
            numbers = (significant(100.0 * at_rest, 2), unit.number(frequency), significant(100.0 * spinning, 2))
            table.add_row(_hertz(frequency), *numbers)
        meaning = (
            "for unbalance: error of the response to a force that turns with the rotor at the speed in the column to "
            "the left"
        )
        return [table, meaning, *self._advice_on_spin(error)]

    def _advice_on_spin(self, error: ReceptanceError) -> Iterator[str]:
        """Yield advice if the model is accurate at rest but not under unbalance, and a line about the highest speed."""
        unit, highest = speed_unit(), None if self.whirl is None else self.whirl.speed
        accurate = error.error <= error.accuracy  # at rest
        reached = accurate if highest is None else accurate & (error.frequencies <= highest)
        wrong = np.flatnonzero(reached & (error.spinning > ALLOWED_SPINNING))
        if len(wrong):
            first = int(wrong[0])
            if highest is not None:
                cure = "state a wider band in [reduction] of the rotor file"
            else:
                cure = "if your rotor turns that fast, set speed in [reduction] of the rotor file to its highest speed"
                cure += " and remove masters" if self.method == "msdc" else ""
            at = unit.text(float(error.frequencies[first]))
            yield f"at {at} the error for unbalance is {significant(100.0 * error.spinning[first], 2)} %; {cure}"
        if highest is not None:
            yield f"the rotor file states a highest speed of {unit.text(highest)}"

    def _whirl_table(self) -> list[TextBlock]:
        """Return the table of whirl at the highest speed; empty if the rotor file states no speed."""
        whirl = self.whirl
        if whirl is None:
            return []
        header = ("mode", "forward (Hz)", "plant (%)", "backward (Hz)", "plant (%)")
        table = text_table(f"Whirl of the free rotor at {whirl.speed * RPM:.0f} rpm", header)
        forward = _whirl_cells(whirl.forward, whirl.forward_error)
        backward = [("-", "-"), *_whirl_cells(whirl.backward, whirl.backward_error)]
        for mode, (ahead, back) in enumerate(zip(forward, backward, strict=True)):
            table.add_row(str(mode), *ahead, *back)
        return [table]


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
    description = load_rotor(rotor)
    body, plant, error = rigid_body(description), reduced_rotor(description).model, reduction_error(description, COUNT)
    z = description.shaft.nodes
    nodes = ((description.shaft.node_at(place), k) for k, place in enumerate(numbered_positions(rotor), start=1))
    numbers = {node: k for node, k in nodes if node is not None}
    return RotorLayout(
        rotor=description.name,
        mass=body.mass,
        centre=body.centre,
        polar_inertia=body.polar_inertia,
        diametral_inertia=body.diametral_inertia,
        length=z[-1] - z[0],
        nodes=len(z),
        numbers=numbers,
        parts=tuple(replace(part, node=numbers.get(part.node or 0)) for part in _parts(description)),
        method=str(description.reduction.method),
        planes=tuple(plant.translations),
        coordinates=plant.size,
        fastest=float(free_modes(plant.M[::2, ::2], plant.K[::2, ::2])[0].max(initial=0.0)),
        receptance=receptance_error(description),
        frequencies=error.frequencies,
        error=error.percent,
        whirl=whirl_error(description, COUNT),
        description=description,
        limits=limits_of((*description.bearings, *description.seals)),
        warnings=implausible_sizes(description),
    )


def _hertz(omega: float) -> str:
    return f"{omega / (2.0 * math.pi):.{0 if omega > 1e3 else 1}f} Hz"


def _whirl_cells(frequencies: Array, percent: Array) -> list[tuple[str, str]]:
    """Return frequencies (Hz) and errors (%) as texts for the table."""
    errors = ("-" if math.isnan(error) else f"{error:+z.4f}" for error in percent)
    return [(f"{omega / (2.0 * math.pi):.1f}", error) for omega, error in zip(frequencies, errors, strict=True)]


def _damping(rotor: Rotor) -> str:
    """Return a description of the damping of a rotor without its bearings."""
    damping = rotor.damping
    ratios = ", ".join(f"{100.0 * ratio:g} %" for ratio in damping.modal)
    values = {
        f"{damping.mass:g} 1/s times mass": damping.mass,
        f"{damping.stiffness:g} s times stiffness": damping.stiffness,
        f"damping ratio {ratios} of the elastic modes": any(damping.modal),
        f"loss factor {damping.loss_factor:g}": damping.loss_factor,
    }
    terms = [words for words, value in values.items() if value]
    return ", ".join([*terms, f"{100.0 * damping.rotating:g} % turns with the shaft"]) if terms else "none"


def _parts(rotor: Rotor) -> Iterator[LayoutEntry]:
    z = rotor.shaft.nodes
    for body in rotor.bodies:
        inertia = f"{number(body.mass)} kg, {number(body.polar_inertia)} kg m2 about the axis"
        inertia += f", centre of mass at {number(z[body.node - 1] + body.offset)} m" if body.offset else ""
        yield LayoutEntry(
            "disc" if body.unbalance else "body",
            body.name,
            body.node,
            z[body.node - 1],
            inertia + (", unbalance" if body.unbalance else ""),
        )
    for kind, bearing in (*(("bearing", b) for b in rotor.bearings), *(("seal", s) for s in rotor.seals)):
        K, C, M = bearing.at(0.0)
        mass = [f", {number(M[k, k])} kg" if M.any() else "" for k in (0, 1)]
        along_x, along_y = (f"{number(K[k, k])} N/m, {number(C[k, k])} N s/m{mass[k]}" for k in (0, 1))
        coefficients = f"{along_x} along x, {along_y} along y" if along_y != along_x else f"{along_x} along x and y"
        if K[0, 1] or K[1, 0]:
            coefficients += f", cross-coupled {number(K[0, 1])} and {number(K[1, 0])} N/m"
        if bearing.tilting is not None:
            K, C, _ = bearing.tilting.at(0.0)
            of_tilt = [f"{number(K[k, k])} N m/rad, {number(C[k, k])} N m s/rad" for k in (0, 1)]
            coefficients += f", tilt {' and '.join(dict.fromkeys(of_tilt))}"
            if K[0, 1] or K[1, 0]:
                coefficients += f", cross-coupled {number(K[0, 1])} and {number(K[1, 0])} N m/rad"
        what = coefficients + (" at rest" if bearing.at_speed else "")
        yield LayoutEntry(kind, bearing.name, bearing.node, z[bearing.node - 1], what)
    for site in rotor.sites:
        stator = f"stator of {site.stator}" if site.stator else "bush"
        what = f"retainer of {site.bearing}" if site.bearing else stator
        yield LayoutEntry("contact site", site.name, site.node, z[site.node - 1], what)
    if rotor.thrust_disc is not None:
        disc = rotor.thrust_disc
        yield LayoutEntry(
            "thrust disc", disc.name, None, disc.z, "axial magnetic bearing; the rotor moves along its shaft"
        )
    for face in rotor.faces:
        what = f"stops motion along {face.stops} after {1e6 * face.clearance:g} um, mean radius {number(face.radius)} m"
        what += f", on {face.retainer}" if face.retainer else ""
        yield LayoutEntry("face", face.name, face.node, z[face.node - 1], what)
    for sensor in rotor.sensors:
        yield LayoutEntry("sensor", sensor.name, sensor.node, z[sensor.node - 1], f"{sensor.x}, {sensor.y}")
