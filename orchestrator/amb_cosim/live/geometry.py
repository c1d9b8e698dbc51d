"""What the page draws of a rotor: shaft, discs and places, and how its shape follows from what the plant shows of it.

The plant shows the displacement of a few planes. Between them the shaft is drawn in the shape that needs the least
strain energy to pass through them, which is exact where no inertia acts between the planes.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np

from amb_cosim.places import PLANT
from fmi_export.model import Array
from rotor_analysis.assembly import assemble
from rotor_analysis.parts import BodyOrDisc, Disc
from rotor_analysis.rotor import Rotor

PIECES = 40  # of the shaft, at least
STEEL = 7850.0  # kg/m^3
DIGITS = 6


def geometry(rotor: Rotor, gravity_angle: float) -> dict[str, Any]:
    """Return a rotor as it is drawn, the `Geometry` of `page/protocol.js`.

    Parameters
    ----------
    rotor
        Its description.
    gravity_angle
        Direction of gravity, from x towards y (rad).
    """
    fine = rotor.on_mesh(rotor.shaft.with_nodes_at(_between(rotor.shaft.nodes)))
    z, places = fine.shaft.nodes, _places(fine)
    retainers = {site.bearing: site.name for site in reversed(fine.sites) if site.bearing}
    radii = [max(layer.diameter[0] for layer in layers) / 2.0 for layers in fine.elements]
    radii.append(max(layer.diameter[1] for layer in fine.elements[-1]) / 2.0)

    def place(node: int) -> dict[str, Any]:
        x, y = places.get(node, ("", ""))
        return {"z": _short(z[node - 1]), "x": x, "y": y}

    return {
        "nodes": [{"z": _short(a), "radius": _short(radius)} for a, radius in zip(z, radii, strict=True)],
        "discs": [
            {"name": b.name, **place(b.node), **_size(b, z[-1] - z[0]), "unbalance": b.unbalance} for b in fine.bodies
        ],
        "bearings": [{"name": b.name, **place(b.node), "retainer": retainers.get(b.name, "")} for b in fine.bearings],
        "sites": [
            {
                "name": s.name,
                "bearing": s.bearing or "",
                **place(s.node),
                "radius": _short(s.journal_radius or radii[s.node - 1]),
                "clearance": s.clearance,
            }
            for s in fine.sites
        ],
        "planes": [{"name": s.name, **place(s.node)} for s in fine.sensors],
        "shape": {
            "places": [place(node) for node in places],
            "rows": [[_short(share) for share in row] for row in shape_between(fine, tuple(places)).tolist()],
        },
        "gravityAngle": gravity_angle,
    }


def shape_between(rotor: Rotor, nodes: tuple[int, ...]) -> Array:
    """Return the displacement of all nodes over that of `nodes`, for the least strain energy, shape (all, nodes).

    Parameters
    ----------
    rotor
        The rotor, whose bearings do not count.
    nodes
        Node numbers whose displacement is given. With one alone the whole shaft moves with it.
    """
    count = len(rotor.shaft.nodes)
    if len(nodes) < 2:
        return np.ones((count, len(nodes)))
    K = assemble(rotor).K[::2, ::2]  # in one plane: displacement and slope of each node
    given = np.array([2 * (node - 1) for node in nodes])
    free = np.setdiff1d(np.arange(2 * count), given)
    moved = np.zeros((2 * count, len(nodes)))
    moved[given] = np.eye(len(nodes))
    moved[free] = -np.linalg.solve(K[np.ix_(free, free)], K[np.ix_(free, given)])
    return moved[::2]


def _places(rotor: Rotor) -> dict[int, tuple[str, str]]:
    """The signals of the displacement at each node that has some, in the order of the nodes."""
    sensors = {sensor.node: (f"{PLANT}.{sensor.x}", f"{PLANT}.{sensor.y}") for sensor in rotor.sensors}
    bearings = {b.node: (f"{PLANT}.{b.name}.x", f"{PLANT}.{b.name}.y") for b in rotor.bearings}
    return dict(sorted({**sensors, **bearings}.items()))


def _between(nodes: tuple[float, ...]) -> list[float]:
    """Points within the elements, so that the shaft has `PIECES` or more."""
    longest = (nodes[-1] - nodes[0]) / PIECES
    return [z for a, b in pairwise(nodes) for z in np.linspace(a, b, int(np.ceil((b - a) / longest)) + 1)[1:-1].tolist()]


def _size(body: BodyOrDisc, length: float) -> dict[str, float]:
    """Radius and width (m) of a body; of one that is known by its inertia alone, those of a steel disc like it."""
    if isinstance(body, Disc):
        return {"radius": body.radius, "width": body.width}
    if body.mass <= 0.0 or body.polar_inertia <= 0.0:
        return {"radius": 0.0, "width": 0.0}
    radius = float(np.sqrt(2.0 * body.polar_inertia / body.mass))
    width = float(body.mass / (STEEL * np.pi * radius**2))
    return {"radius": _short(min(radius, 0.2 * length)), "width": _short(min(width, 0.1 * length))}


def _short(number: float) -> float:
    return round(float(number), DIGITS)
