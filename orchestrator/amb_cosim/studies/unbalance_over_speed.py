"""Study of the steady response of a rotor to unbalance over the spin speed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np

from amb_cosim.presentation.json_data import Layout
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
    """

    node: int
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
        Response at the bearings and the ends of the shaft, by name.
    clearance
        Radial clearance (m) that the amplitudes are compared with.
    """

    name: ClassVar[str] = "unbalance_response"

    rotor: str
    mass: MassModel
    unbalance: Annotated[float, "kg.m"]
    node: int
    speeds: Annotated[Array, "rad/s"]
    places: dict[str, PlaceResponse]
    clearance: Annotated[float, Layout.OMITTED]

    def text(self) -> list[TextPart]:
        """Return a table of the largest amplitudes."""
        table = labelled_table("Largest amplitude", "place", "(mm)", "of the clearance", "at (rad/s)")
        for name, place in self.places.items():
            top = int(np.argmax(place.amplitude))
            peak = place.amplitude[top]
            table.add_row(name, f"{1e3 * peak:.4f}", f"{peak / self.clearance:.3f}", f"{self.speeds[top]:.1f}")
        return [table]


def unbalance_response(
    rotor: RotorSource = None,
    *,
    mass: MassModel | None = None,
    up_to: Number = "628 rad/s",
    unbalance: Number = "10 g.m",
    node: int | None = None,
    clearance: Number = "0.75 mm",
) -> UnbalanceResponse:
    """Return amplitude and phase at the bearings and the shaft ends over the spin speed, with unbalance at one node.

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
        Radial clearance (m), or a text with its unit, that the amplitudes are compared with.

    Raises
    ------
    ValueError
        If the rotor file cannot be read, or an argument is out of range.
    """
    description = rotor_of(rotor)
    mass = mass or description.shaft.mass_matrix
    u, radial_clearance = positive(unbalance, "kg.m", "unbalance"), positive(clearance, "m", "clearance")
    loaded = _first_disc(description) if node is None else node
    places = _places(description)
    speeds = speed_range(up_to, POINTS)[1:]
    response = steady_response(supported_rotor(description, mass), {loaded: u}, speeds, tuple(places.values()))
    amplitude, _, phase = orbit(response)
    continuous = np.unwrap(phase, axis=0)
    found = {
        name: PlaceResponse(place, amplitude[:, k], continuous[:, k]) for k, (name, place) in enumerate(places.items())
    }
    return UnbalanceResponse(description.name, mass, u, loaded, speeds, found, radial_clearance)


def _first_disc(rotor: Rotor) -> int:
    """Return the node of the first disc plane or, without one, of the first body."""
    nodes = (*rotor.disc_nodes, *(body.node for body in rotor.bodies))
    if not nodes:
        raise ValueError("node is missing: a rotor without disc planes and bodies does not say where its unbalance is")
    return nodes[0]


def _places(rotor: Rotor) -> dict[str, int]:
    """Return the nodes of the bearings and the shaft ends, by name."""
    z, bearings = rotor.shaft.nodes, {bearing.name: bearing.node for bearing in rotor.bearings}
    ends = {f"end at z = {z[node - 1]:.4g} m": node for node in (1, len(z)) if node not in bearings.values()}
    return bearings | ends
