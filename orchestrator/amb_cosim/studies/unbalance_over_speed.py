"""Study of the steady response of a rotor to unbalance over the spin speed."""

from __future__ import annotations

from dataclasses import dataclass
from types import SimpleNamespace
from typing import Annotated, Any, ClassVar

import numpy as np

from amb_cosim.presentation.text_tables import TextPart, labelled_table
from amb_cosim.studies.inputs import Number, RotorSource, positive, rotor_of, speed_range
from amb_cosim.studies.result import DrawnResult
from fmi_export.model import Array
from rotor_analysis.response import orbit
from rotor_analysis.response import unbalance_response as steady_response
from rotor_analysis.rotor import Rotor
from rotor_analysis.shaft import MassModel
from rotor_analysis.supported_rotor import supported_rotor

POINTS = 644  # speeds of the curves, with the standstill, which is left out


@dataclass(frozen=True, eq=False)
class PlaceResponse:
    """Response at one place of the shaft.

    node
        Number of its node.
    amplitude
        Major semi-axis of the orbit (m), shape (n,).
    phase
        Angle by which the forward part of the motion leads the unbalance (rad), continuous, shape (n,).
    clearance
        Radial clearance there (m), the least of the sites at this node; None where nothing can be touched.
    """

    node: int
    clearance: Annotated[float | None, "m"]
    amplitude: Annotated[Array, "m"]
    phase: Annotated[Array, "rad"]


@dataclass(frozen=True, eq=False, repr=False)
class UnbalanceResponse(DrawnResult):
    """Steady response of a rotor to unbalance at one node.

    rotor, mass
        Name of the rotor, and the mass matrix of its model.
    unbalance
        Unbalance (kg m).
    node
        Number of the node that it is on.
    speeds
        Spin speeds (rad/s), ascending, shape (n,).
    places
        Response at the bearings, the other sites where the rotor can touch, and the ends of the shaft, by name.
    """

    name: ClassVar[str] = "unbalance_response"

    rotor: str
    mass: MassModel
    unbalance: Annotated[float, "kg.m"]
    node: int
    speeds: Annotated[Array, "rad/s"]
    places: dict[str, PlaceResponse]

    def text(self) -> list[TextPart]:
        """Return a table of the largest amplitudes."""
        table = labelled_table("Largest amplitude", "place", "(mm)", "of the clearance", "at (rad/s)")
        for name, place in self.places.items():
            top = int(np.argmax(place.amplitude))
            peak = place.amplitude[top]
            share = "-" if place.clearance is None else f"{peak / place.clearance:.3f}"
            table.add_row(name, f"{1e3 * peak:.4f}", share, f"{self.speeds[top]:.1f}")
        return [table]


def unbalance_response(
    rotor: RotorSource = None,
    *,
    mass: MassModel | None = None,
    up_to: Number = "628 rad/s",
    unbalance: Number = "10 g.m",
    node: int | None = None,
    clearance: Number | None = None,
) -> UnbalanceResponse:
    """Return amplitude and phase at bearings, contact sites and shaft ends over the spin speed, unbalance at one node.

    [-Omega^2 M + i Omega (C + Omega G) + K] Q = Omega^2 (u, -i u)

    Parameters
    ----------
    rotor
        A rotor or a rotor file; the packs' default without.
    mass
        Mass matrix, `diagonal` or `consistent`; as the rotor says by default.
    up_to
        Highest spin speed (rad/s), or a text with its unit.
    unbalance
        Unbalance (kg m), or a text with its unit.
    node
        Number of its node; that of the first disc by default.
    clearance
        Radial clearance (m), or a text with its unit, that all amplitudes are compared with; by default each is with
        that of the site there.

    Raises
    ------
    ValueError
        If the rotor file cannot be read, or an argument is out of range.
    """
    description = rotor_of(rotor)
    mass = mass or description.shaft.mass_matrix
    u = positive(unbalance, "kg.m", "unbalance")
    everywhere = None if clearance is None else positive(clearance, "m", "clearance")
    loaded = _first_disc(description) if node is None else node
    places = _places(description)
    speeds = speed_range(up_to, POINTS)[1:]
    response = steady_response(supported_rotor(description, mass), {loaded: u}, speeds, tuple(places.values()))
    amplitude, _, phase = orbit(response)
    continuous = np.unwrap(phase, axis=0)
    result = {
        name: PlaceResponse(place, everywhere or _clearance(description, place), amplitude[:, k], continuous[:, k])
        for k, (name, place) in enumerate(places.items())
    }
    return UnbalanceResponse(description.name, mass, u, loaded, speeds, result)


def _first_disc(rotor: Rotor) -> int:
    """Return the node of the first disc plane or, without one, of the first body."""
    nodes = (*rotor.disc_nodes, *(body.node for body in rotor.bodies))
    if not nodes:
        raise ValueError("node is missing: a rotor without disc planes and bodies does not say where its unbalance is")
    return nodes[0]


def _places(rotor: Rotor) -> dict[str, int]:
    """Return the nodes of the bearings, of the sites and of the shaft ends, by name; each node once."""
    z = rotor.shaft.nodes
    ends = (SimpleNamespace(name=f"end at z = {z[node - 1]:.4g} m", node=node) for node in (1, len(z)))
    parts: tuple[Any, ...] = (*rotor.bearings, *rotor.sites, *ends)
    first = {part.node: part.name for part in reversed(parts)}
    return {name: node for node, name in sorted(first.items())}


def _clearance(rotor: Rotor, node: int) -> float | None:
    """Return the least clearance (m) of the sites at a node; None without one."""
    return min((site.clearance for site in rotor.sites if site.node == node), default=None)
