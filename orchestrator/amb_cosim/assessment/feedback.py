"""Forces of magnetic bearings over displacements of the rotor: controller, hold, delay, amplifier, magnet.

    F(j omega) = K(j omega) q,    w = E y + u,  y = H w    =>    y = (1 - H E)^-1 H u             (1)

w are the inputs of controller, actuator and what else stands between, y their outputs, H their frequency responses in
blocks. A sampled component has H = D + C (z - A)^-1 B, z = exp(j omega T); what it shows to a continuous one is held:

    H_hold = (1 - exp(-j omega T))/(j omega T) exp(-j omega T_late)                               (2)

The images at omega + 2 pi n/T that sampling adds are left out: the rotor hardly moves there.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag

from amb_cosim.assessment.subject import AXES, Subject
from amb_cosim.controllers.laws import Law
from amb_cosim.linear.linearisable import LinearSource
from amb_cosim.linear.parts import LinearPart
from amb_cosim.results.places import PLANT
from fmi_export.model import Array

Complex = NDArray[np.complex128]


def bearing_forces(subject: Subject, omega: float, Omega: float) -> Complex:
    """Return the forces (N) at the bearings' nodes over displacements (m) at all nodes, at a frequency.

    Parameters
    ----------
    subject
        The machine.
    omega, Omega
        Frequency of the motion and spin speed (rad/s).

    Returns
    -------
    ndarray
        Shape (2 nodes, 2 nodes), x and y of each node in turn; f = K q, positive stiffness is negative.
    """
    made = subject.linear_components.at(Omega)
    fed = {target: source for target, source in made.feeds(_names(made)).items() if _is_force(target)}
    places = {bearing.name: bearing.node for bearing in subject.rotor.bearings}
    rows = []
    for force in fed:
        bearing, _, axis = force.removeprefix(f"{PLANT}.").rpartition(".f_")
        rows.append(2 * (places[bearing] - 1) + AXES.index(axis))
    whole = np.zeros((2 * len(subject.z), 2 * len(subject.z)), dtype=np.complex128)
    np.add.at(whole, rows, over_displacements(subject, made, list(fed.values()), omega))
    return whole


def demanded_currents(subject: Subject, omega: float, Omega: float) -> Complex:
    """Return the demanded currents (A) of all axes over displacements (m) at all nodes, shape (axes, 2 nodes)."""
    return over_displacements(subject, subject.linear_components.at(Omega), list(subject.loop.sources), omega)


def over_displacements(subject: Subject, made: LinearSource, outputs: Sequence[str], omega: float) -> Complex:
    """Return outputs of components over displacements (m) by (1) at a frequency (rad/s), shape (outputs, 2 nodes).

    What a sampled component shows is its fundamental, before it is held.
    """
    names = [name for name in _names(made) if name != PLANT]
    feeds, parts = made.feeds([*names, PLANT]), made.parts(names)
    inputs = [name for part in parts for name in part.inputs]
    displayed = [name for part in parts for name in part.outputs]
    H = block_diag(*(_response(part, omega) for part in parts))
    owner = {name: part for part in parts for name in (*part.inputs, *part.outputs)}
    at_input, at_output = ({name: k for k, name in enumerate(of)} for of in (inputs, displayed))
    E = np.zeros((len(inputs), len(displayed)), dtype=np.complex128)
    read = np.zeros((len(inputs), 2 * len(subject.z)))
    for target, source in feeds.items():
        if target in at_input and source in at_output:
            E[at_input[target], at_output[source]] = _link(owner[source], owner[target], omega)
        elif target in at_input and source.startswith(f"{PLANT}."):
            node, axis = subject.signals[source.removeprefix(f"{PLANT}.")]
            read[at_input[target], 2 * (node - 1) + axis] = 1.0
    closed = np.linalg.solve(np.eye(len(displayed)) - H @ E, H @ read)
    return np.asarray(closed[[at_output[name] for name in outputs]])


def _names(made: LinearSource) -> list[str]:
    return [component.name for component in made.assembly.system.components]


def _is_force(target: str) -> bool:
    return target.startswith(f"{PLANT}.") and ".f_" in target


def _response(part: LinearPart, omega: float) -> Complex:
    """Return the frequency response of a component, sampled or not."""
    law = part.law
    s = 1j * omega if law.sample_time is None else np.exp(1j * omega * law.sample_time)
    return frequency_response(law, s)


def frequency_response(law: Law, s: complex) -> Complex:
    """Return D + C (s - A)^-1 B, with z in place of s for a sampled law."""
    if not len(law.A):
        return law.D.astype(np.complex128)
    return np.asarray(law.D + law.C @ np.linalg.solve(s * np.eye(len(law.A)) - law.A, law.B.astype(np.complex128)))


def _link(source: LinearPart, target: LinearPart, omega: float) -> complex:
    """Return what a connection does: (2) from a sampled component to a continuous one, nothing otherwise."""
    time = source.law.sample_time
    if time is None or target.law.sample_time is not None:
        return 1.0
    held = (1.0 - np.exp(-1j * omega * time)) / (1j * omega * time) if omega else 1.0
    return complex(held * np.exp(-1j * omega * time * (source.late + (1.0 if source.at_end else 0.0))))


def parallel_stiffness(subject: Subject, omegas: Array, Omega: float | None = None) -> dict[str, Complex]:
    """Return the dynamic stiffness (N/m) of each magnetic bearing along x while the rotor moves in parallel.

    k(j omega) = -F_x(j omega)/x: the real part is stiffness, the imaginary part omega times the damping.

    Parameters
    ----------
    subject
        The machine.
    omegas
        Frequencies (rad/s), above 0, shape (n,).
    Omega
        Spin speed (rad/s); that of the frequency itself, for motion that is synchronous, without.

    Returns
    -------
    dict
        Arrays of shape (n,).
    """
    result: dict[str, list[complex]] = {bearing: [] for bearing in subject.magnets}
    along = np.zeros(2 * len(subject.z))
    along[0::2] = 1.0
    nodes = {bearing.name: bearing.node for bearing in subject.rotor.bearings}
    for omega in omegas:
        force = bearing_forces(subject, float(omega), float(omega) if Omega is None else Omega) @ along
        for bearing, values in result.items():
            values.append(-force[2 * (nodes[bearing] - 1)])
    return {bearing: np.array(values) for bearing, values in result.items()}
