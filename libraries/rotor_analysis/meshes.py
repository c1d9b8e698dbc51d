"""The same rotor on finer and coarser finite-element meshes."""

from __future__ import annotations

from dataclasses import fields, replace
from itertools import pairwise

from rotor_analysis.rotor import Planes, Rotor, require


def refine(rotor: Rotor, count: int) -> Rotor:
    """Return `rotor` with `count` nodes: the longest element (the first of equals) is halved until there are as many.

    Parameters
    ----------
    rotor
        Its description; bodies, bearings and planes stay where they are on the shaft.
    count
        Number of nodes, at least those of `rotor`.

    Raises
    ------
    ValueError
        If `count` is below the number of nodes.
    """
    z = list(rotor.shaft.nodes)
    require(count >= len(z), "number of nodes", count, f"{len(z)} or more, to refine this mesh")
    while len(z) < count:
        lengths = [round(b - a, 9) for a, b in pairwise(z)]  # a nanometre does not make an element the longer one
        longest = lengths.index(max(lengths))
        z.insert(longest + 1, 0.5 * (z[longest] + z[longest + 1]))
    return _with_nodes(rotor, tuple(z))


def coarsen(rotor: Rotor, nodes: tuple[int, ...]) -> Rotor:
    """Return `rotor` with only the given nodes.

    Parameters
    ----------
    rotor
        Its description.
    nodes
        Node numbers to keep: both ends, and those of bodies, bearings and planes.

    Raises
    ------
    ValueError
        If a node that must stay is not among them, or the section of the shaft changes between two of them.
    """
    z = rotor.shaft.nodes
    needed = {1, len(z), *rotor.bearing_nodes, *(body.node for body in rotor.bodies)}
    needed.update(node for field in fields(Planes) for node in getattr(rotor.planes, field.name))
    require(set(nodes) <= set(range(1, len(z) + 1)), "nodes", list(nodes), f"node numbers from 1 to {len(z)}")
    require(
        needed <= set(nodes),
        "nodes",
        list(nodes),
        f"a list that includes {sorted(needed)}, with parts or planes",
    )
    return _with_nodes(rotor, tuple(z[node - 1] for node in sorted(set(nodes))))


def mesh_family(rotor: Rotor) -> dict[int, Rotor]:
    """Return `rotor` by number of nodes: with ten and six more, unchanged, and with only its master planes.

    For the rig these are the 23, 19, 13 and 6 nodes of the thesis. The last is left out where the master planes do not
    make a mesh.
    """
    count = len(rotor.shaft.nodes)
    meshes = {count + more: refine(rotor, count + more) for more in (10, 6)} | {count: rotor}
    try:
        coarse = coarsen(rotor, rotor.planes.master)
    except ValueError:
        return meshes
    return meshes | {len(coarse.shaft.nodes): coarse}


def _with_nodes(rotor: Rotor, z: tuple[float, ...]) -> Rotor:
    """Return `rotor` on the nodes at `z` (m), with bodies, bearings and planes at their positions."""
    shaft = rotor.shaft
    number = {node: z.index(place) + 1 for node, place in enumerate(shaft.nodes, start=1) if place in z}
    sections = [_section(rotor, a, b) for a, b in pairwise(z)]
    return replace(
        rotor,
        shaft=replace(
            shaft,
            nodes=z,
            diameter=tuple(outer for outer, _ in sections),
            inner_diameter=tuple(inner for _, inner in sections),
        ),
        bodies=tuple(replace(body, node=number[body.node]) for body in rotor.bodies),
        bearings=tuple(replace(bearing, node=number[bearing.node]) for bearing in rotor.bearings),
        planes=Planes(**{f.name: tuple(number[n] for n in getattr(rotor.planes, f.name)) for f in fields(Planes)}),
    )


def _section(rotor: Rotor, begin: float, end: float) -> tuple[float, float]:
    """Outer and inner diameter (m) of the shaft from `begin` to `end` (m), which must be one section."""
    shaft = rotor.shaft
    pieces = zip(pairwise(shaft.nodes), shaft.diameter, shaft.inner_diameter, strict=True)
    found = {(outer, inner) for (a, b), outer, inner in pieces if a < end and b > begin}
    between = f"{begin:g} m to {end:g} m"
    require(len(found) == 1, f"element from {between}", sorted(found), "of one diameter and one inner diameter (m)")
    return found.pop()
