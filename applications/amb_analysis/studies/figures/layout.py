"""Side view of a rotor: shaft, sleeves and bodies to scale, and below them the positions of parts and masters."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch, Rectangle

from amb_analysis.studies.coefficient_limits import EXTRAPOLATED, is_extrapolated
from amb_analysis.studies.rotor_layout import LayoutEntry, RotorLayout
from amb_cosim.presentation.style import BLUE, BROWN, GREEN, ORANGE, PURPLE, SKY_BLUE, YELLOW, StyledFigure, write_title
from amb_cosim.presentation.units import frequency_unit
from rotor_analysis.element import Element
from rotor_analysis.parts import BodyOrDisc, Face
from rotor_analysis.rotor import Rotor

LANES = {
    "disc": (ORANGE, "o"),
    "bearing": (BLUE, "^"),
    "seal": (BROWN, "D"),
    "contact site": (PURPLE, "v"),
    "thrust disc": (SKY_BLUE, "P"),
    "face": (YELLOW, ">"),
    "sensor": (GREEN, "s"),
}
SHAFT, SLEEVE, BODY = "0.82", SKY_BLUE, "0.6"
LANE, TALL_LANE = 0.42, 0.62  # inches; tall where names are turned
WIDTH, LEFT, RIGHT = 8.2, 0.13, 0.98  # width of the figure (inches), and ends of the axes over it


def draw(result: RotorLayout) -> Figure:
    """Draw the rotor, and lanes with its discs, bearings, seals, contact sites, faces, sensors and master planes."""
    rotor = result.description
    radius = 1.15 * _largest_radius(rotor)
    lanes = [kind for kind in LANES if any(part.kind == kind for part in result.parts)]
    margin = 0.03 * result.length
    to_scale = (RIGHT - LEFT) * WIDTH * 2.0 * radius / (result.length + 2.0 * margin)
    lane = TALL_LANE if any(_is_crowded(result, kind) for kind in lanes) else LANE
    side, lower = float(np.clip(to_scale, 1.0, 4.0)), lane * (len(lanes) + 1)
    height = side + lower + 1.2
    figure = StyledFigure(figsize=(WIDTH, height))
    above, beneath = figure.subplots(2, 1, sharex=True, height_ratios=(side, lower))
    figure.subplots_adjust(LEFT, 0.5 / height, RIGHT, 1.0 - 0.6 / height, hspace=0.05)
    _draw_shaft(above, rotor)
    first, last = _ends(rotor)
    above.set(xlim=(first - margin, last + margin), ylim=(-radius, radius), ylabel="$r$ (m)")
    above.tick_params(bottom=False, labelbottom=False)
    above.spines["bottom"].set_visible(False)
    kinds = (("shaft", SHAFT, True), ("sleeve", SLEEVE, bool(rotor.shaft.sleeves)), ("body", BODY, bool(rotor.bodies)))
    handles = [Patch(facecolor=fill, edgecolor="black", lw=0.4, label=kind) for kind, fill, exists in kinds if exists]
    above.legend(handles=handles, loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=3, borderaxespad=0.0)
    _draw_lanes(beneath, result, lanes)
    _mark_parts(above, result, lanes)
    positive = result.frequencies[result.frequencies > 0.0]
    unit = frequency_unit()
    first_modes = ", ".join(unit.number(frequency) for frequency in positive[:3])
    mark = f" ({EXTRAPOLATED})" if is_extrapolated(result.limits, 0.0) else ""
    frozen = any(item.whirl_frequency is not None for item in result.limits)
    mark += " (coefficients at one whirl frequency)" if frozen else ""
    support = "on the bearings of its file" if rotor.bearings else "free"
    title = f"{rotor.name}: {result.mass:.4g} kg; {first_modes} {unit.label} at rest, {support}{mark}"
    write_title(figure, title, x=LEFT, y=1.0 - 0.1 / height, ha="left", va="top")
    return figure


def _ends(rotor: Rotor) -> tuple[float, float]:
    """Return the ends (m) of the shaft, or of bodies that extend beyond it."""
    z = rotor.shaft.nodes
    spans = [(z[0], z[-1])]
    for body in rotor.bodies:
        centre, half = z[body.node - 1] + body.offset, 0.5 * _equivalent_disc(body)[1] if body.offset else 0.0
        spans.append((centre - half, centre + half))
    return min(low for low, _ in spans), max(high for _, high in spans)


def _draw_shaft(axes: Axes, rotor: Rotor) -> None:
    """Draw shaft, sleeves and bodies in section."""
    z = rotor.shaft.nodes
    for (begin, end), layers in zip(pairwise(z), rotor.elements, strict=True):
        for k, layer in enumerate(layers):
            _draw_element(axes, begin, end, layer, SLEEVE if k else SHAFT)
    for body in rotor.bodies:
        radius, width = _equivalent_disc(body)
        width, seat = max(width, 0.004 * (z[-1] - z[0])), z[body.node - 1]
        at = (seat + body.offset - width / 2.0, -radius)
        axes.add_patch(
            Rectangle(at, width, 2.0 * radius, facecolor=BODY, edgecolor="black", lw=0.4, alpha=0.6, zorder=3)
        )
        if body.offset:  # from the seat to the centre of mass
            axes.plot(
                (seat, seat + body.offset), (0.0, 0.0), color="black", lw=1.2, marker="|", markevery=[0], zorder=5
            )
    axes.axhline(0.0, color="black", lw=0.5, ls=(0, (12, 3, 2, 3)), zorder=4)


def _mark_parts(axes: Axes, result: RotorLayout, lanes: list[str]) -> None:
    """Draw marks for all parts on both sides of the shaft, without overlap; discs are drawn as bodies instead.

    Sensors are drawn only above the shaft. The mark of a face is at the face's mean radius, and points in the direction
    in which the seat pushes the rotor.
    """
    outward, taken = 0.11 * axes.get_ylim()[1], list[float]()
    for kind in [lane for lane in lanes if lane != "disc"]:
        colour = LANES[kind][0]
        for part in (part for part in result.parts if part.kind == kind):
            below = sum(abs(z - part.z) < 0.015 * result.length for z in taken)
            radius = _radius_at(result.description, part.z) + below * outward
            face, marker = _face(result, part), _marker(result, part)
            if face is not None:
                radius = face.radius
            for side in (1.0,) if kind == "sensor" else (1.0, -1.0):
                mark = {"^": "v", "v": "^"}.get(marker, marker) if side > 0.0 else marker
                axes.plot(part.z, side * radius, marker=mark, ms=6, color=colour, mec="white", mew=0.5, zorder=5)
            axes.axvline(part.z, color=colour, lw=0.6, ls=":", zorder=0.5)
            if face is None:
                taken.append(part.z)


def _marker(result: RotorLayout, part: LayoutEntry) -> str:
    """Return the mark of a part; the mark of a face points in the direction in which the seat pushes the rotor."""
    face = _face(result, part)
    return "<" if face is not None and face.stops == "+z" else LANES[part.kind][1]


def _face(result: RotorLayout, part: LayoutEntry) -> Face | None:
    """Return the face that a part represents; None if the part is not a face."""
    return next((face for face in result.description.faces if part.kind == "face" and face.name == part.name), None)


def _radius_at(rotor: Rotor, z: float) -> float:
    """Return the outer radius (m) of the shaft, or of the sleeve around it, at a position (m)."""
    for (begin, end), layers in zip(pairwise(rotor.shaft.nodes), rotor.elements, strict=True):
        if begin <= z <= end:
            share = (z - begin) / (end - begin)
            return max((1.0 - share) * a.diameter[0] + share * a.diameter[1] for a in layers) / 2.0
    return 0.0


def _draw_element(axes: Axes, begin: float, end: float, layer: Element, colour: str) -> None:
    outer, inner = np.array(layer.diameter) / 2.0, np.array(layer.inner_diameter) / 2.0
    for side in (1.0, -1.0):
        radii = side * np.array([inner[0], inner[1], outer[1], outer[0]])
        axes.fill((begin, end, end, begin), radii, facecolor=colour, edgecolor="black", lw=0.3)


def _draw_lanes(axes: Axes, result: RotorLayout, lanes: list[str]) -> None:
    """Draw a lane for each kind of part, and a lane for the master planes."""
    z = result.description.shaft.nodes
    for row, kind in enumerate(lanes):
        colour = LANES[kind][0]
        parts = sorted((part for part in result.parts if part.kind == kind), key=lambda part: part.z)
        for part in parts:
            axes.plot(part.z, -row, ls="", marker=_marker(result, part), ms=5, color=colour)
            turned = {"rotation": 50, "ha": "left"} if _is_crowded(result, kind) else {"ha": "center"}
            axes.text(part.z, -row + 0.17, part.name, fontsize=6.5, va="bottom", color=colour, **turned)
    row = len(lanes)
    axes.plot([z[node - 1] for node in result.planes], [-row] * len(result.planes), "|", ms=7, color="black")
    axes.set_yticks(range(-row, 1), ["planes", *(f"{kind}s" for kind in reversed(lanes))])
    axes.set(ylim=(-row - 0.5, 0.75), xlabel="$z$ (m)")
    axes.tick_params(left=False)
    axes.grid(axis="y", color="0.9", lw=0.6)
    axes.set_axisbelow(True)
    axes.spines["left"].set_visible(False)


def _is_crowded(result: RotorLayout, kind: str) -> bool:
    """Return whether the labels of two parts of a kind would overlap."""
    parts = sorted((part for part in result.parts if part.kind == kind), key=lambda part: part.z)
    width = 0.006 * result.length  # of a letter
    return any(b.z - a.z < width * len(a.name + b.name) for a, b in pairwise(parts))


def _largest_radius(rotor: Rotor) -> float:
    thickest = max(max(layer.diameter) for layers in rotor.elements for layer in layers)
    return max(thickest / 2.0, *(_equivalent_disc(body)[0] for body in rotor.bodies), 0.0)


def _equivalent_disc(body: BodyOrDisc) -> tuple[float, float]:
    """Return radius and width (m) of a homogeneous disc with a body's mass and inertias; zeros if there is no mass."""
    if body.mass == 0.0:
        return 0.0, 0.0
    radius = math.sqrt(2.0 * body.polar_inertia / body.mass)
    return radius, math.sqrt(max(0.0, 12.0 * body.diametral_inertia / body.mass - 3.0 * radius**2))
