"""Drawing data of a rotor: shaft, discs, bearings, contact sites, faces, and deflection between measured points."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from typing import Any

import numpy as np

from amb_cosim.results.component_names import PLANT
from array_types import Array
from rotor_analysis.assembly import assemble
from rotor_analysis.parts import Disc
from rotor_analysis.reduction import msdc
from rotor_analysis.rotor import Rotor
from rotor_analysis.rotor_file import RotorSource, load_rotor

DENSITY = 7850.0  # kg/m3, of steel, for bodies described by their inertia


def geometry(
    source: RotorSource, layout: Mapping[str, Any], gravity_angle: float, magnetic: Collection[str]
) -> dict[str, Any]:
    """Return a `Geometry` as defined by `protocol.js`.

    Parameters
    ----------
    source
        The rotor, or its name or file; by default the default rotor of the packs.
    layout
        Layout of the plant's interface.
    gravity_angle
        Direction of gravity (rad), from x towards y.
    magnetic
        Names of the bearings whose magnets pull the rotor.
    """
    rotor = load_rotor(source)
    z = rotor.shaft.nodes
    signals = {s.node: (f"{PLANT}.{s.x}", f"{PLANT}.{s.y}") for s in reversed(rotor.sensors)}
    signals |= {b.node: (f"{PLANT}.{b.name}.x", f"{PLANT}.{b.name}.y") for b in reversed(rotor.bearings)}
    sites = {site["name"]: site for site in layout["sites"]}
    retainers = {site.bearing: site.name for site in reversed(rotor.sites) if site.bearing}
    return {
        "nodes": [{"z": z[k], "radius": radius} for k, radius in enumerate(_radii(rotor))],
        "discs": [
            {"name": body.name, "z": z[body.node - 1] + body.offset, "unbalance": body.unbalance, **_cylinder(body)}
            for body in rotor.bodies
        ],
        "bearings": [
            {
                "name": bearing.name,
                "z": z[bearing.node - 1],
                "x": f"{PLANT}.{bearing.name}.x",
                "y": f"{PLANT}.{bearing.name}.y",
                "retainer": retainers.get(bearing.name, ""),
                "magnetic": bearing.name in magnetic,
            }
            for bearing in rotor.bearings
        ],
        "sites": [
            {
                "name": site.name,
                "bearing": site.bearing or "",
                "z": z[site.node - 1],
                "radius": sites[site.name]["journal_radius"],
                "clearance": site.clearance,
                "x": f"{PLANT}.{site.name}.x",
                "y": f"{PLANT}.{site.name}.y",
            }
            for site in rotor.sites
        ],
        "thrust": rotor.thrust,
        "faces": [
            {
                "name": face.name,
                "z": z[face.node - 1],
                "radius": face.radius,
                "clearance": face.clearance,
                "stops": -1 if face.stops == "-z" else 1,
                "retainer": face.retainer or "",
            }
            for face in rotor.faces
        ],
        "planes": [
            {"name": s.name, "z": z[s.node - 1], "x": f"{PLANT}.{s.x}", "y": f"{PLANT}.{s.y}"} for s in rotor.sensors
        ],
        "shape": {
            "places": [{"z": z[node - 1], "x": x, "y": y} for node, (x, y) in sorted(signals.items())],
            "rows": _shape(rotor, tuple(sorted(signals))).tolist(),
        },
        "gravityAngle": gravity_angle,
    }


def _shape(rotor: Rotor, places: tuple[int, ...]) -> Array:
    """Return the displacements of all nodes if one of several given nodes is displaced by 1 and the others by 0.

    That is q = -K_ss^-1 K_sm q_m in a single plane of motion (3.8), shape (nodes, places).
    """
    full = assemble(rotor)
    if len(places) == 1:
        return np.ones((len(rotor.shaft.nodes), 1))
    rows = full.rows(tuple(range(1, len(rotor.shaft.nodes) + 1)))[::2]
    return msdc(full, places).right[rows, ::2]


def _radii(rotor: Rotor) -> list[float]:
    """Return the outer radius (m) at each node, from the element that begins there or, at the end, the last element."""
    radii = [max(layer.diameter[0] for layer in layers) / 2.0 for layers in rotor.elements]
    return [*radii, radii[-1]]


def _cylinder(body: Any) -> dict[str, float]:
    """Return the radius and width (m) of a steel cylinder with the same mass and polar inertia as a body.

    They follow from I_p = m r^2 / 2 and m = rho pi r^2 b. A disc keeps its own dimensions. A point mass is drawn with
    the radius and the diameter of a steel sphere of the same mass.
    """
    if isinstance(body, Disc):
        return {"radius": body.radius, "width": body.width}
    if body.polar_inertia <= 0.0 or body.mass <= 0.0:
        radius = (3.0 * body.mass / (4.0 * math.pi * DENSITY)) ** (1.0 / 3.0)
        return {"radius": radius, "width": 2.0 * radius}
    radius = math.sqrt(2.0 * body.polar_inertia / body.mass)
    return {"radius": radius, "width": body.mass / (DENSITY * math.pi * radius**2)}
