"""The same rotor on finer and coarser finite-element meshes."""

from __future__ import annotations

from itertools import pairwise

from amb_files.checks import require
from rotor_analysis.rotor import Rotor


def refine(rotor: Rotor, count: int) -> Rotor:
    """Return `rotor` with `count` nodes, by repeatedly halving the longest element (the first of equal ones).

    Parameters
    ----------
    rotor
        The rotor; parts and masters keep their positions on the shaft.
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
    return rotor.on_mesh(rotor.shaft.on_nodes(tuple(z)))


def coarsen(rotor: Rotor, nodes: tuple[int, ...]) -> Rotor:
    """Return `rotor` with a subset of its nodes.

    Parameters
    ----------
    rotor
        The rotor.
    nodes
        Node numbers to keep: both ends, and those of parts and masters.

    Raises
    ------
    ValueError
        If a required node is missing, or the section of the shaft changes between two of the nodes.
    """
    z = rotor.shaft.nodes
    required = {1, len(z), *rotor.part_nodes, *rotor.masters}
    require(set(nodes) <= set(range(1, len(z) + 1)), "nodes", list(nodes), f"node numbers from 1 to {len(z)}")
    requirement = f"a list that includes {sorted(required)}, with parts or masters"
    require(required <= set(nodes), "nodes", list(nodes), requirement)
    return rotor.on_mesh(rotor.shaft.on_nodes(tuple(z[node - 1] for node in sorted(set(nodes)))))


def mesh_family(rotor: Rotor) -> dict[int, Rotor]:
    """Return meshes of `rotor` by number of nodes: with ten and six more nodes, unchanged, and only its masters.

    The last is omitted if the masters do not form a mesh.
    """
    count = len(rotor.shaft.nodes)
    meshes = {count + added: refine(rotor, count + added) for added in (10, 6)} | {count: rotor}
    try:
        coarse = coarsen(rotor, rotor.masters)
    except ValueError:
        return meshes
    return meshes | {len(coarse.shaft.nodes): coarse}
