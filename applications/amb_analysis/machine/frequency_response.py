"""Responses of a rotor, free or in its machine, from forces and injected currents to motion and demanded currents.

The magnetic bearing forces depend on the displacements x of all nodes and on the injected currents i:

    x = H (p + F x + F_i i),    c = T x + T_i i,    y = (j omega)^k S x                            (1)

H is the response of the rotor with its passive bearings and seals (`rotor_analysis.harmonic`), and p are external
forces. The demanded currents c are taken after their delay. y are displacements (k = 0), velocities (k = 1) or
accelerations (k = 2). Forces and motions are positive in the same direction, so the receptance of a free mass m is
-1/(m omega^2).

If records were multiplied by exp(-a t), their response is that at j omega + a, so (1) is evaluated at omega - j a.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal, get_args

import numpy as np

from amb_analysis.machine.channels import Place, node_rows
from amb_analysis.machine.feedback import component_responses, fed_loads, lateness, open_loop_components
from amb_analysis.machine.machine import Machine
from amb_cosim.results.component_names import ACTUATOR
from array_types import Array, Complex
from rotor_analysis.harmonic import Forces, HarmonicModel, harmonic_model, harmonic_points
from rotor_analysis.parts import Bearing, seat
from rotor_analysis.resonances import resonances
from rotor_analysis.rotor import Rotor

BLOCK = 512  # frequencies that are computed together, which bounds the memory

Loop = Literal["free", "linear", "open", "closed"]
LOOPS: tuple[Loop, ...] = get_args(Loop)
"""Support of the rotor: none, the bearings and seals of its file, magnets without control, or magnets with control."""


@dataclass(frozen=True)
class Structure:
    """A rotor and its support, whose responses are computed.

    rotor
        Description of the rotor, with a node at every place.
    loop
        Support of the rotor.
    Omega
        Spin speed (rad/s).
    machine
        The machine, if `loop` is `open` or `closed`.
    """

    rotor: Rotor
    loop: Loop
    Omega: float = 0.0
    machine: Machine | None = None
    _models: dict[object, HarmonicModel] = field(default_factory=dict, compare=False, repr=False)

    def with_machine(self, machine: Machine | None) -> Structure:
        """Return the structure with a machine that has other parameter values; reduced models of the rotor are kept."""
        return replace(self, machine=machine)

    def model(self, nodes: Sequence[int], highest: float) -> HarmonicModel:
        """Return the reduced rotor for forces at some nodes up to a frequency (rad/s); it is computed only once."""
        key = tuple(sorted(set(nodes))), highest, self.bearings
        if key not in self._models:
            self._models[key] = harmonic_model(self.rotor, nodes, highest, self.bearings)
        return self._models[key]

    @property
    def bearings(self) -> tuple[Bearing, ...]:
        """Passive bearings and seals."""
        if self.loop == "free":
            return ()
        if self.machine is None:
            return (*self.rotor.bearings, *self.rotor.seals)
        return (*self.machine.passive_bearings, *self.rotor.seals)


def frequency_response(
    structure: Structure,
    inputs: Sequence[Place],
    outputs: Sequence[Place],
    frequencies: Array,
    highest: float | None = None,
    decay: float = 0.0,
) -> Complex:
    """Return the response of each output to each input by (1), shape (n, outputs, inputs).

    Parameters
    ----------
    structure
        Rotor and support.
    inputs, outputs
        Places with their quantities (`channels`).
    frequencies
        Frequencies (Hz), shape (n,).
    highest
        Frequency (Hz) up to which the rotor's model is accurate; by default the highest of `frequencies`.
    decay
        Rate a (1/s) of an exponential window of the records of input and output; 0 for none.

    Raises
    ------
    ValueError
        If a current belongs to a place without a controlled magnet, or the response is unbounded.
    """
    omegas, magnets = 2.0 * np.pi * np.asarray(frequencies, np.float64), _magnets(structure, inputs, outputs)
    top = float(omegas.max()) if highest is None else 2.0 * np.pi * highest
    model = structure.model(_loaded(structure, inputs, magnets), top)
    at = omegas - 1j * decay if decay else omegas
    blocks = np.split(at, range(BLOCK, len(at), BLOCK))
    return np.concatenate([_response(structure, inputs, outputs, block, model, magnets) for block in blocks])


def _response(
    structure: Structure,
    inputs: Sequence[Place],
    outputs: Sequence[Place],
    omegas: Array | Complex,
    model: HarmonicModel,
    magnets: _Magnets | None,
) -> Complex:
    """Return the responses (1) at frequencies (rad/s); all displacements at all frequencies are held in memory."""
    rotor = structure.rotor
    points, n_loads = len(model.right), model.left.shape[1]
    loads = np.zeros((len(omegas), n_loads, len(inputs)), dtype=np.complex128)
    currents = [k for k, place in enumerate(inputs) if place.unit == "A"]
    for k, place in enumerate(inputs):
        if place.unit == "N":
            loads[:, node_rows(rotor, [place])[0], k] = 1.0
    forces, columns, electric = None, list[int](), np.zeros((len(omegas), 0, 0), np.complex128)
    if magnets is not None:
        columns, electric = magnets.at(omegas)
        forces = magnets.forces(columns, electric)
        for j, row in enumerate(magnets.rows):
            loads[:, row, currents] += electric[:, j, len(columns) :]
    motion = model.response(omegas, structure.Omega, loads, np.eye(points), forces)
    result = np.empty((len(omegas), len(outputs), len(inputs)), dtype=np.complex128)
    for k, place in enumerate(outputs):
        if place.unit == "A":
            assert magnets is not None
            axis = magnets.axes.index(place.axis_name)
            demand = electric[:, len(magnets.rows) + axis] * np.exp(-1j * omegas * magnets.late[axis])[:, None]
            result[:, k] = np.einsum("nr,nri->ni", demand[:, : len(columns)], motion[:, columns])
            result[:, k, currents] += demand[:, len(columns) :]
        else:
            result[:, k] = (1j * omegas[:, None]) ** place.order * motion[:, node_rows(rotor, [place])[0]]
    return result


def resonant_frequencies(
    structure: Structure, inputs: Sequence[Place], outputs: Sequence[Place], frequencies: Array
) -> list[tuple[float, float]]:
    """Return the resonances (Hz) between the first and the last frequency, and their half widths (Hz).

    The arguments are those of `frequency_response`; the frequencies must be ascending. Each interval between successive
    frequencies may contain only one resonance of each mode.
    """
    magnets = _magnets(structure, inputs, outputs)
    model = structure.model(_loaded(structure, inputs, magnets), 2.0 * np.pi * float(frequencies[-1]))
    model = model.at(structure.Omega)

    def stiffness(omega: float) -> Complex:
        omegas = np.array([omega])
        forces = magnets.forces(*magnets.at(omegas)) if magnets else None
        return np.asarray(model.stiffness(omegas, structure.Omega, forces)[0])

    found = resonances(stiffness, 2.0 * np.pi * frequencies)
    return [(omega / (2.0 * np.pi), width / (2.0 * np.pi)) for omega, width in found]


def _loaded(structure: Structure, inputs: Sequence[Place], magnets: _Magnets | None) -> list[int]:
    """Return the nodes at which forces act across the shaft."""
    rotor = structure.rotor
    points = harmonic_points(rotor)
    nodes = [seat(place.point_on(rotor)) for place in inputs if place.unit == "N" and place.direction != "z"]
    rows = [] if magnets is None else magnets.rows
    return nodes + [seat(points[row // 2]) for row in rows if row < 2 * len(points)]


@dataclass(frozen=True, eq=False)
class _Magnets:
    """Magnets of a machine: the rows of all loads (`Machine.load_rows`), and the axes of the demanded currents.

    At frequencies (rad/s), `at` returns the rows of the displacements that are read, and [F F_i; T T_i] of (1), shape
    (n, rows + axes, displacements + injected). The demands in this matrix are the values at the samples; they appear
    `late` (s) after the samples.
    """

    rows: list[int]
    axes: tuple[str, ...]
    late: Array
    at: Callable[[Array | Complex], tuple[list[int], Complex]]

    def forces(self, columns: list[int], electric: Complex) -> Forces:
        """Return F of (1) from a result of `at`, at the frequencies of this result."""
        return Forces(self.rows, columns, lambda _: electric[:, : len(self.rows), : len(columns)])


def _magnets(structure: Structure, inputs: Sequence[Place], outputs: Sequence[Place]) -> _Magnets | None:
    """Return the magnets of the structure's machine; None if there is no machine."""
    electric = [place for place in (*inputs, *outputs) if place.unit == "A"]
    machine = structure.machine
    if machine is None:
        if electric:
            raise ValueError(f"{electric[0].name} is a current, which needs loop 'open' or 'closed'")
        return None
    if structure.loop == "open" and any(place.unit == "A" for place in outputs):
        raise ValueError("an open loop demands no current; use loop 'closed'")
    axes = machine.run_loop.axis_names
    for place in electric:
        if place.axis_name not in axes:
            raise ValueError(f"{place.name} is not a current of this machine, whose axes are {', '.join(axes)}")
    linear_source = machine.run_components.at(structure.Omega)
    injected = [f"{ACTUATOR}.{p.place}.i_{p.direction}" for p in inputs if p.unit == "A"]
    loads, loop = fed_loads(machine, linear_source), machine.run_loop
    components = open_loop_components(machine, linear_source) if structure.loop == "open" else None
    demanded = dict(zip(loop.demands, loop.sources, strict=True)) if structure.loop == "closed" else {}
    ends, late = [*loads, *demanded.values()], lateness(linear_source, demanded)
    return _Magnets(
        list(loads.values()),
        axes,
        late,
        lambda omegas: component_responses(machine, linear_source, ends, omegas, injected, components),
    )


def refined(rotor: Rotor, places: Sequence[Place]) -> Rotor:
    """Return a rotor with a node at every place that is a position.

    Raises
    ------
    ValueError
        If a position is not on the shaft, or a part does not exist.
    """
    positions = [place.position for place in places if place.position is not None]
    nodes = rotor.shaft.nodes
    for place in places:
        if place.position is not None and not nodes[0] <= place.position <= nodes[-1]:
            limits = f"{nodes[0]:g} m to {nodes[-1]:g} m"
            raise ValueError(f"{place.name} is not on the shaft; a position must be from {limits}")
    shaft = rotor.shaft.with_nodes_at(positions)
    refined_rotor = rotor if shaft is rotor.shaft else rotor.on_mesh(shaft)
    for place in places:
        if place.direction != "z":
            place.point_on(refined_rotor)
    return refined_rotor if refined_rotor is rotor else replace(refined_rotor, mesh=None)
