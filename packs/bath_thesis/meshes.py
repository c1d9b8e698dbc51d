"""The same rotor on finer and coarser finite-element meshes."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import TypeVar

from amb_files.checks import require
from rotor_analysis.parts import Bearing, Body, Disc, Sensor, Site
from rotor_analysis.rotor import Rotor

Part = TypeVar("Part", bound=Body | Disc | Bearing | Site | Sensor)


def refine(rotor: Rotor, count: int) -> Rotor:
    """Return `rotor` with `count` nodes, after repeatedly halving the longest element (the first of equal elements).

    Parameters
    ----------
    rotor
        The rotor; parts and masters keep their positions on the shaft.
    count
        Number of nodes, not fewer than `rotor` has.

    Raises
    ------
    ValueError
        If `count` is less than the number of nodes of `rotor`.
    """
    z = list(rotor.shaft.nodes)
    require(count >= len(z), "number of nodes", count, f"{len(z)} or more, to refine this mesh")
    while len(z) < count:
        lengths = [round(b - a, 9) for a, b in pairwise(z)]  # a nanometre does not make an element the longer one
        longest = lengths.index(max(lengths))
        z.insert(longest + 1, 0.5 * (z[longest] + z[longest + 1]))
    return rotor.on_mesh(rotor.shaft.on_nodes(tuple(z)))


def coarsen(rotor: Rotor, nodes: tuple[int, ...]) -> Rotor:
    """Return `rotor` with a subset of its nodes.

    Parameters
    ----------
    rotor
        The rotor.
    nodes
        Node numbers to keep: both ends, and the nodes of parts and masters.

    Raises
    ------
    ValueError
        If a required node is missing, or the section of the shaft changes between two adjacent nodes.
    """
    z = rotor.shaft.nodes
    required = {1, len(z), *rotor.part_nodes, *rotor.masters}
    require(set(nodes) <= set(range(1, len(z) + 1)), "nodes", list(nodes), f"node numbers from 1 to {len(z)}")
    requirement = f"a list that includes {sorted(required)}: the ends, and the nodes of parts and masters"
    require(required <= set(nodes), "nodes", list(nodes), requirement)
    return rotor.on_mesh(rotor.shaft.on_nodes(tuple(z[node - 1] for node in sorted(set(nodes)))))


def even_nodes(rotor: Rotor) -> Rotor:
    """Return a uniform rotor with equidistant nodes, one for each master; the bearings are next to the end nodes.

    The other parts keep their order. Masses and bearings change their positions on such a coarse mesh.
    """
    bearings = [bearing.node for bearing in rotor.bearings]
    others = [node for node in rotor.masters if node not in bearings]
    order = [others[0], bearings[0], *others[1:-1], bearings[-1], others[-1]]
    count, z = len(order), rotor.shaft.nodes
    nodes = tuple(z[0] + (z[-1] - z[0]) * k / (count - 1) for k in range(count))
    at = {node: k + 1 for k, node in enumerate(order)}

    def moved(parts: tuple[Part, ...]) -> tuple[Part, ...]:
        return tuple(replace(part, node=at[part.node]) for part in parts)

    return replace(
        rotor,
        shaft=replace(
            rotor.shaft, nodes=nodes, diameter=rotor.shaft.diameter[:1], inner_diameter=rotor.shaft.inner_diameter[:1]
        ),
        bodies=moved(rotor.bodies),
        bearings=moved(rotor.bearings),
        sites=moved(rotor.sites),
        sensors=moved(rotor.sensors),
        reduction=replace(rotor.reduction, masters=tuple(range(1, count + 1))),
    )


def mesh_family(rotor: Rotor) -> dict[int, Rotor]:
    """Return `rotor` on meshes with ten more nodes, six more nodes, its own nodes, and its masters, by number of nodes.

    The last mesh is omitted if the masters alone do not form a mesh.
    """
    count = len(rotor.shaft.nodes)
    meshes = {count + added: refine(rotor, count + added) for added in (10, 6)} | {count: rotor}
    try:
        coarse = coarsen(rotor, rotor.masters)
    except ValueError:
        return meshes
    return meshes | {len(coarse.shaft.nodes): coarse}
