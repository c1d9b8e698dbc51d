"""Response of the loads on the rotor to its displacements, through controller, hold, delay, amplifier and magnet.

    F(j omega) = K(j omega) q,    w = E y + u,  y = H w    =>    y = (1 - H E)^-1 H u             (1)

w are the inputs of all components except the plant, y are their outputs, and H is the block matrix of their frequency
responses. The loads are forces on the rotor, and accelerations of its base; a casing, for example, is a component that
the bearing forces move and that accelerates the base. A sampled component has H = D + C (z - A)^-1 B with
z = exp(j omega T). Its output is held if it feeds a continuous component:

    H_hold = (1 - exp(-j omega T))/(j omega T) exp(-j omega T_late)                               (2)

The images at omega + 2 pi n/T due to sampling are neglected, because the rotor hardly responds at these frequencies.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from amb_analysis.linear.components import LinearComponent, harmonic_response
from amb_analysis.linear.linear_source import LinearSource
from amb_analysis.machine.machine import AXES, Machine
from amb_cosim.results.component_names import ACTUATOR, PLANT
from array_types import Array, Complex

ALIKE = 1e-3  # difference of directions that are reported together, over the largest stiffness


def bearing_forces(machine: Machine, omega: float, Omega: float) -> Complex:
    """Return the forces (N) of the bearings at their nodes per unit displacement (m) of each node, at a frequency.

    Forces on discs and accelerations of the base are not included (`loads_of`).

    Parameters
    ----------
    machine
        The machine.
    omega, Omega
        Frequency of the motion and spin speed (rad/s).

    Returns
    -------
    ndarray
        Matrix K of f = K q, shape (2 nodes, 2 nodes), with x and y of each node in turn. A restoring stiffness is
        negative.
    """
    linear_source = machine.run_components.at(Omega)
    bearings = {f"{PLANT}.{bearing}.f_{axis}" for bearing in machine.bearings for axis in AXES}
    rows = {name: row for name, row in fed_loads(machine, linear_source).items() if name in bearings}
    forces = np.zeros((2 * len(machine.z), 2 * len(machine.z)), dtype=np.complex128)
    np.add.at(forces, list(rows.values()), _component_outputs(machine, linear_source, list(rows), omega))
    return forces


def loads_of(machine: Machine, omega: float, Omega: float) -> tuple[list[int], list[int], Complex]:
    """Return all loads across the shaft per unit displacement (m), at a frequency and a spin speed (rad/s).

    Returns
    -------
    rows, columns, loads
        Rows of the loads among `Machine.load_rows`, columns of the displacements among x and y of all nodes, and the
        matrix of shape (rows, columns) in N/m, or 1/s^2 for an acceleration of the base.
    """
    linear_source = machine.run_components.at(Omega)
    rows = {name: row for name, row in fed_loads(machine, linear_source).items() if name[-1] in AXES}
    columns, loads = component_responses(machine, linear_source, list(rows), np.array([omega]))
    across = [k for k, column in enumerate(columns) if column != machine.axial_row]
    return list(rows.values()), [columns[k] for k in across], loads[0][:, across]


def demanded_currents(machine: Machine, omega: float, Omega: float) -> Complex:
    """Return the demanded currents (A) of all lateral axes per displacement (m) of each node, shape (axes, 2 nodes)."""
    loop = machine.run_loop
    demanded = loop.sources[: len(loop.lateral_axes)]
    return _component_outputs(machine, machine.run_components.at(Omega), demanded, omega)


def _component_outputs(machine: Machine, linear_source: LinearSource, outputs: Sequence[str], omega: float) -> Complex:
    """Return the outputs of components per displacement (m) of each node, shape (outputs, 2 nodes)."""
    rows, responses = component_responses(machine, linear_source, outputs, np.array([omega]))
    result = np.zeros((len(outputs), machine.axial_row + 1), dtype=np.complex128)
    result[:, rows] = responses[0]
    return result[:, : 2 * len(machine.z)]


def component_responses(
    machine: Machine,
    linear_source: LinearSource,
    outputs: Sequence[str],
    omegas: Array | Complex,
    injected: Sequence[str] = (),
    components: Sequence[str] | None = None,
) -> tuple[list[int], Complex]:
    """Return the response (1) of outputs to the displacements (m) that the components read, and to injected inputs.

    Parameters
    ----------
    machine, linear_source
        The machine, and the source of its linear components at the spin speed.
    outputs
        Names `component.variable` of outputs, or of loads of the plant (`fed_loads`). The response of a sampled
        component's output describes its fundamental before the hold; the response of a load includes hold and delay.
    omegas
        Frequencies (rad/s), shape (n,).
    injected
        Inputs to which a signal is added.
    components
        Components in the loop; by default all except the plant. Inputs that only other components feed are 0.

    Returns
    -------
    rows, responses
        Row of each displacement that is read: its index among x and y of all nodes, or the machine's `axial_row`. The
        responses have the shape (n, outputs, rows + injected).
    """
    names = [name for name in linear_source.names if name != PLANT and (components is None or name in components)]
    feeds, parts = linear_source.feeds([*names, PLANT]), linear_source.parts(names)
    inputs = [name for part in parts for name in part.inputs]
    available_outputs = [name for part in parts for name in part.outputs]
    owner = {name: part for part in parts for name in (*part.inputs, *part.outputs)}
    at_input, at_output = ({name: k for k, name in enumerate(names)} for names in (inputs, available_outputs))
    H = np.zeros((len(omegas), len(available_outputs), len(inputs)), dtype=np.complex128)
    first = 0, 0
    for part in parts:
        last = first[0] + len(part.outputs), first[1] + len(part.inputs)
        H[:, first[0] : last[0], first[1] : last[1]] = harmonic_response(part.law, omegas, part.law.sample_time)
        first = last
    E = np.zeros((len(omegas), len(inputs), len(available_outputs)), dtype=np.complex128)
    row_of = {f"{PLANT}.{name}": 2 * (node - 1) + axis for name, (node, axis) in machine.signals.items()}
    row_of |= {f"{PLANT}.{machine.rotor.thrust}.z": machine.axial_row} if machine.rotor.thrust else {}
    read: dict[str, int] = {}
    for target, source in feeds.items():
        if target in at_input and source in at_output:
            late = linear_source.samples_late(owner[source], target)
            E[:, at_input[target], at_output[source]] = _link(owner[source], owner[target], late, omegas)
        elif target in at_input and source in row_of:
            read[target] = row_of[source]
    rows = sorted(set(read.values()))
    from_inputs = np.zeros((len(inputs), len(rows) + len(injected)))
    for target, row in read.items():
        from_inputs[at_input[target], rows.index(row)] = 1.0
    for k, name in enumerate(injected):
        from_inputs[at_input[name], len(rows) + k] = 1.0
    closed = np.linalg.solve(np.eye(len(available_outputs)) - H @ E, H @ from_inputs)
    result = np.asarray(closed[:, [at_output[feeds.get(name, name)] for name in outputs]])
    for k, load in enumerate(outputs):
        if load in feeds:
            feeding = owner[feeds[load]]
            link = _link(feeding, None, linear_source.samples_late(feeding, load), omegas)
            result[:, k] = result[:, k] * link[:, np.newaxis]
    return rows, result


def lateness(linear_source: LinearSource, feeds: Mapping[str, str]) -> Array:
    """Return the delay (s) of each connection relative to the sample from which its output is computed.

    Parameters
    ----------
    linear_source
        The components.
    feeds
        The output that feeds each input, by the name of the input.
    """
    parts = linear_source.parts([name for name in linear_source.names if name != PLANT])
    owner = {name: part for part in parts for name in part.outputs}
    times = [
        (owner[source].law.sample_time or 0.0) * linear_source.samples_late(owner[source], target)
        for target, source in feeds.items()
    ]
    return np.array(times)


def fed_loads(machine: Machine, linear_source: LinearSource) -> dict[str, int]:
    """Return the loads of the plant that a component feeds, each with its row (`Machine.load_rows`)."""
    feeds = linear_source.feeds(linear_source.names)
    return {name: row for name, row in machine.load_rows.items() if name in feeds}


def open_loop_components(machine: Machine, linear_source: LinearSource) -> list[str]:
    """Return the components that affect the plant's loads if nothing feeds the demands of the actuator."""
    feeds = linear_source.feeds(linear_source.names)
    feeds_of = [(target.partition(".")[0], source.partition(".")[0]) for target, source in feeds.items()]
    result: set[str] = set()
    reached = {feeds[load].partition(".")[0] for load in fed_loads(machine, linear_source)}
    while reached:
        result |= reached
        followed = reached - {ACTUATOR}
        reached = {source for target, source in feeds_of if target in followed} - result - {PLANT}
    return sorted(result)


def _link(source: LinearComponent, target: LinearComponent | None, late: float, omegas: Array | Complex) -> Complex:
    """Return the response of a connection that is `late` samples late: (2) to a continuous component, or 1.

    A `target` of None is the plant, which is continuous.
    """
    time = source.law.sample_time
    if time is None or (target is not None and target.law.sample_time is not None):
        return np.ones(len(omegas), np.complex128)
    angles = omegas * time
    held = np.sinc(angles / (2.0 * np.pi)) * np.exp(-0.5j * angles)
    return np.asarray(held * np.exp(-1j * angles * late))


def parallel_stiffness(machine: Machine, omegas: Array, axis: str = "x") -> dict[str, Complex]:
    """Return the dynamic stiffness (N/m) of each bearing along an axis for parallel synchronous motion.

    k(j omega) = -F_x(j omega)/x + k_b + j omega c_b, where F is the force of a magnet, and k_b and c_b are the passive
    coefficients of the plant. The real part is the stiffness, and the imaginary part is omega times the damping.

    Parameters
    ----------
    machine
        The machine.
    omegas
        Positive frequencies (rad/s), shape (n,); each is also the spin speed.
    axis
        `x` or `y`.

    Returns
    -------
    dict
        Arrays of shape (n,), for the bearings that have a magnet or passive coefficients.
    """
    result: dict[str, list[complex]] = {bearing: [] for bearing in machine.magnets}
    along = np.zeros(2 * len(machine.z))
    along[AXES.index(axis) :: 2] = 1.0
    for omega in omegas:
        force = bearing_forces(machine, float(omega), float(omega)) @ along
        for bearing, values in result.items():
            values.append(-force[2 * (machine.bearings[bearing] - 1) + AXES.index(axis)])
    dynamic = {bearing: np.array(values) for bearing, values in result.items()}
    for support in machine.passive_bearings:
        k, c = support.stiffness[0][0], support.damping[0][0]
        if k or c:
            dynamic[support.name] = dynamic.get(support.name, 0.0) + k + 1j * omegas * c
    return dynamic


def springs(machine: Machine, stiffness: Mapping[str, float], floor: float) -> dict[int, float]:
    """Return the stiffness (N/m) of the bearings at each node; each bearing contributes at least `floor`."""
    result: dict[int, float] = {}
    for bearing, k in stiffness.items():
        node = machine.bearings[bearing]
        result[node] = result.get(node, 0.0) + max(k, floor)
    return result


def directional_stiffness(machine: Machine, omegas: Array) -> dict[str, dict[str, Complex]]:
    """Return the synchronous `parallel_stiffness` with the keys " along x" and " along y", or only "" if both agree."""
    x, y = (parallel_stiffness(machine, omegas, axis=axis) for axis in AXES)
    size = max(float(np.abs(x[bearing]).max()) for bearing in machine.magnets)
    if all(np.allclose(x[bearing], y[bearing], rtol=0.0, atol=ALIKE * size) for bearing in x):
        return {"": x}
    return {" along x": x, " along y": y}
