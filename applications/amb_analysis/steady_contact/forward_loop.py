"""The loop of a levitated rotor for forward motion with contact forces, in a complex form of half the size.

With z = x + i y for each pair of coordinates, an isotropic loop obeys one complex equation. For the real matrix [[xx,
xy], [yx, yy]] of a pair,

    forward  = ((xx + yy) + i (yx - xy))/2,      mixing  = ((xx - yy) + i (yx + xy))/2                (1)

`forward` acts on z, and `mixing` acts on its conjugate. `mixing` vanishes in an isotropic loop and is neglected in an
anisotropic one.

    forces at sites F, unbalance ---> rotor, magnets, amplifiers ---> q at sites, readings y
                                         ^ currents held over a sample (x late)      |
                                         +---------- controller, sampled <-----------+
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import matrix_balance

from amb_analysis.linear.components import (
    LinearComponent,
    connected,
    harmonic_response,
    held,
    in_order,
    loop_of,
    within,
    without_idle_states,
)
from amb_analysis.linear.linear_source import LinearSource
from amb_analysis.linear.rotor_and_magnets import rotor_component
from amb_cosim.controllers.laws import Law
from amb_cosim.results.component_names import ACTUATOR, PLANT
from array_types import Array
from rotor_contact.shaft.structure import structure_of

Complex = NDArray[np.complexfloating[Any, Any]]  # numpy types products of real and complex arrays so
Pair = tuple[str, str]

UNREACHABLE = 1e-10  # largest singular value of uncontrollable directions of a balanced law


@dataclass(frozen=True, eq=False)
class ComplexLaw:
    """Matrices of x' = A x + B w or x(n+1) = A x(n) + B w(n), y = C x + D w, complex."""

    A: Complex
    B: Complex
    C: Complex
    D: Complex


@dataclass(frozen=True, eq=False)
class ForwardLoop:
    """The loop of forward motion at one speed.

    Omega
        Spin speed (rad/s).
    plant
        Continuous part. Its inputs are the forces at the sites, the forces at the places of unbalance, and the delayed
        currents. Its outputs are the displacements at the sites, and the readings.
    controller
        Sampled part, from readings to currents; None if there is no controller.
    sample_time
        T (s); None if there is no controller.
    late
        Delay of each current as a fraction of a sample, shape (n_currents,).
    sites, unbalances, currents
        Names of the sites, of the places of unbalance, and of the bearings.
    notes
        Sentences about effects that the linear model neglects.
    """

    Omega: float
    plant: ComplexLaw
    controller: ComplexLaw | None
    sample_time: float | None
    late: Array
    sites: tuple[str, ...]
    unbalances: tuple[str, ...]
    currents: tuple[str, ...]
    notes: tuple[str, ...]

    @property
    def columns(self) -> tuple[slice, slice, slice]:
        """Input columns of the plant for the sites, the unbalances and the currents."""
        m, d, b = len(self.sites), len(self.unbalances), len(self.currents)
        return slice(0, m), slice(m, m + d), slice(m + d, m + d + b)

    @cached_property
    def held(self) -> tuple[Complex, Complex, Complex]:
        """Phi, Gamma_0 and Gamma_1 of the plant under held currents (`components.held`)."""
        assert self.sample_time is not None
        return held(self.plant.A, self.plant.B[:, self.columns[2]], self.sample_time, self.late)


def forward_loop(source: LinearSource, Omega: float, sites: Sequence[str]) -> ForwardLoop:
    """Return the loop of forward motion at a spin speed (rad/s), with forces at sites of the rotor.

    Raises
    ------
    ValueError
        If an FMU has no linear model, or if a sampled component moves the rotor other than by demands of the actuator.
    """
    at = source.at(Omega)
    layout = at.layout(PLANT)
    parts, feeds = parts_in_contact(at, at.names)
    continuous = [part for part in parts if part.law.sample_time is None]
    discrete = [part for part in parts if part.law.sample_time is not None]
    continuous_part = connected(continuous, within(continuous, feeds))
    bearings = layout["bearings"]
    places = [*layout["discs"], *bearings]
    pairs = [contact_pair(site) for site in sites] + [_pair(PLANT, f"{place}.f_{{}}") for place in places]
    displacements = [_site_pair(site) for site in sites]
    if not discrete:
        plant = _forward(continuous_part.selected(flat(pairs), flat(displacements)).law)
        notes = continuous_part.notes
        return ForwardLoop(Omega, plant, None, None, np.zeros(0), tuple(sites), tuple(places), (), notes)
    control = connected(discrete, within(discrete, feeds))
    demanded = [pair for pair in _demands(at) if any(end in feeds for end in pair)]
    read = _reading_pairs(layout, bearings, sites)
    sources = {feeds[end] for end in control.inputs if end in feeds}
    used = [pair for pair in read if set(pair) & sources]
    _require_demands_only(continuous_part, control, feeds, flat(demanded), flat(displacements))
    plant = _forward(continuous_part.selected(flat([*pairs, *demanded]), flat([*displacements, *used])).law)
    controller = _forward_control(control, used, demanded, feeds)
    delays = {name: part.late for part in discrete for name in part.outputs}
    late = np.array([max(delays.get(feeds.get(end, ""), 0.0) for end in pair) for pair in demanded])
    currents = tuple(pair[0].split(".")[1] for pair in demanded)
    time = control.law.sample_time
    notes = (*continuous_part.notes, *control.notes)
    names = (tuple(sites), tuple(places), currents)
    return ForwardLoop(Omega, plant, controller, time, late, *names, notes)


def _require_demands_only(
    continuous: LinearComponent,
    control: LinearComponent,
    feeds: Mapping[str, str],
    demanded: Sequence[str],
    displacements: Sequence[str],
) -> None:
    """Raise `ValueError` if a sampled output moves the sites and feeds neither a demand nor another sampled part."""
    others = [(t, s) for t, s in feeds.items() if t in continuous.inputs and s in control.outputs and t not in demanded]
    for target, output in others:
        if len(without_idle_states(continuous.selected([target], displacements).law).A):
            raise ValueError(
                f"{output} feeds {target}; steady contact is computed for controllers that feed only "
                f"{', '.join(demanded)}, so remove the component {output.partition('.')[0]} or simulate with `run`"
            )


def forward_rotor(source: LinearSource, Omega: float, sites: Sequence[str]) -> ComplexLaw:
    """Return the response of displacements to forces at a rotor's sites, without magnets, at a speed (rad/s)."""
    at = source.at(Omega)
    layout, constants = at.layout(PLANT), at.constants(PLANT)
    rotor = with_contact_forces(
        rotor_component(PLANT, layout, constants, at.parameters(PLANT), Omega), layout, constants
    )
    pairs, displacements = ([name(site) for site in sites] for name in (contact_pair, _site_pair))
    return _forward(rotor.selected(flat(pairs), flat(displacements)).law)


def with_contact_forces(part: LinearComponent, layout: Mapping[str, Any], constants: Array) -> LinearComponent:
    """Return the linear part of a rotor with additional inputs for forces (N) at its sites."""
    s = structure_of(constants)
    n = len(s.K)
    rows = [int(row) + k for row in s.sites for k in (0, 1)]
    law = part.law
    force = np.zeros((len(law.A), len(rows)))  # states along the shaft follow those across it
    force[n : 2 * n] = s.Minv[:, rows]
    B, D = np.hstack([law.B, force]), np.hstack([law.D, np.zeros((len(law.D), len(rows)))])
    inputs = (*part.inputs, *flat([contact_pair(site["name"]) for site in layout["sites"]]))
    return LinearComponent(Law(law.A, B, law.C, D), inputs, part.outputs, notes=part.notes)


def contact_pair(site: str) -> Pair:
    """Return the names of the contact forces (N) at a site along x and y."""
    return _pair(PLANT, f"{site} (contact).f_{{}}")


def _site_pair(site: str) -> Pair:
    """Return the names of the displacements (m) of a site along x and y."""
    return _pair(PLANT, f"{site}.{{}}")


def _pair(component: str, variable: str) -> Pair:
    return f"{component}.{variable.format('x')}", f"{component}.{variable.format('y')}"


def flat(pairs: Sequence[Pair]) -> list[str]:
    """Return the names of all pairs in one list, with x before y in each pair."""
    return [name for pair in pairs for name in pair]


def _demands(source: LinearSource) -> list[Pair]:
    """Return the names of the demanded bearing currents or, if there is no actuator, of the forces on the rotor."""
    if ACTUATOR in source.plan.interfaces:
        return [_pair(ACTUATOR, f"{b}.i_{{}}") for b in source.layout(ACTUATOR)["bearings"]]
    return [_pair(PLANT, f"{b}.f_{{}}") for b in source.layout(PLANT)["bearings"]]


def _reading_pairs(layout: Mapping[str, Any], bearings: Sequence[str], sites: Sequence[str]) -> list[Pair]:
    pairs = [(f"{PLANT}.{plane['x']}", f"{PLANT}.{plane['y']}") for plane in layout["sensors"]]
    pairs += [_pair(PLANT, f"{place}.{{}}") for place in (*bearings, *sites)]
    return list(dict.fromkeys(pairs))


def parts_in_contact(source: LinearSource, names: Sequence[str]) -> tuple[list[LinearComponent], dict[str, str]]:
    """Return the parts of a run and their connections; the rotor has additional inputs for forces at its sites."""
    layout, constants = source.layout(PLANT), source.constants(PLANT)
    rotor = rotor_component(PLANT, layout, constants, source.parameters(PLANT), source.point["Omega"])
    others = {name: source.parts([name])[0] for name in names if name != PLANT}
    parts = [others.get(name, with_contact_forces(rotor, layout, constants)) for name in names]
    return in_order(parts, source.feeds(names), names)


def mixing(source: LinearSource, Omega: float, sites: Sequence[str]) -> float:
    """Return the largest backward receptance of a loop at the sites, divided by the largest forward receptance (1).

    This measure of anisotropy is 0 in an isotropic loop, where synchronous orbits are circles.
    """
    at = source.at(Omega)
    whole = loop_of(*parts_in_contact(at, at.names))
    law = whole.selected(flat([contact_pair(s) for s in sites]), flat([_site_pair(s) for s in sites])).law
    forward, backward = _split(harmonic_response(law, Omega, law.sample_time))
    return float(np.abs(backward).max() / np.abs(forward).max())


def _forward(law: Law) -> ComplexLaw:
    """Return the forward part (1) of a law whose inputs, outputs and states alternate between x and y."""
    law = without_idle_states(law)
    return ComplexLaw(*(_split(matrix)[0] for matrix in (law.A, law.B, law.C, law.D)))


def _split(matrix: NDArray[Any]) -> tuple[Complex, Complex]:
    xx, xy, yx, yy = matrix[0::2, 0::2], matrix[0::2, 1::2], matrix[1::2, 0::2], matrix[1::2, 1::2]
    return 0.5 * ((xx + yy) + 1j * (yx - xy)), 0.5 * ((xx - yy) + 1j * (yx + xy))


def _forward_control(
    control: LinearComponent, read: Sequence[Pair], demanded: Sequence[Pair], feeds: dict[str, str]
) -> ComplexLaw:
    """Return a minimal realisation of a controller for forward motion.

    With y = w (1, -i) and u = (1, i) . (u_x, u_y)/2, the response from w to u is `forward` (1) of the real controller's
    response, in any state basis.
    """
    law, row = control.law, {name: k for k, name in enumerate(control.outputs)}
    S = np.zeros((len(control.inputs), 2 * len(read)))  # currents over readings
    at = {name: k for k, name in enumerate(flat(read))}
    for k, name in enumerate(control.inputs):
        if feeds.get(name) in at:
            S[k, at[feeds[name]]] = 1.0
    T = np.zeros((2 * len(demanded), len(row)))
    for k, name in enumerate(flat(demanded)):
        if name in feeds:
            T[k, row[feeds[name]]] = 1.0
    B, C, D = law.B @ S, T @ law.C, T @ law.D @ S
    B_forward = B[:, 0::2] - 1j * B[:, 1::2]
    C_forward = np.asarray(0.5 * (C[0::2] + 1j * C[1::2]), dtype=np.complex128)
    return minimal(ComplexLaw(np.asarray(law.A, dtype=np.complex128), B_forward, C_forward, _split(D)[0]))


def minimal(law: ComplexLaw) -> ComplexLaw:
    """Return the controllable and observable part of a law, by the staircase algorithm.

    P. van Dooren, IEEE Trans. Automatic Control 26 (1981) 111-129. States are balanced first, because a delayed
    controller holds readings (m) and currents (A), which differ by a factor of 1e6.
    """
    law = _balanced(law)
    controllable = _reachable(law.A, law.B)
    A, B, C = controllable.conj().T @ law.A @ controllable, controllable.conj().T @ law.B, law.C @ controllable
    observable = _reachable(A.conj().T, C.conj().T)
    return ComplexLaw(observable.conj().T @ A @ observable, observable.conj().T @ B, C @ observable, law.D)


def _balanced(law: ComplexLaw) -> ComplexLaw:
    """Return a law with its states scaled so that each state has equal input and output gains."""
    n, (rows, columns) = len(law.A), law.D.shape
    gains = np.block([[np.abs(law.A), np.abs(law.B)], [np.abs(law.C), np.zeros((rows, columns))]])
    square = np.zeros((max(gains.shape),) * 2)
    square[: gains.shape[0], : gains.shape[1]] = gains
    unit = matrix_balance(square, permute=False, separate=True)[1][0][:n]
    return ComplexLaw(law.A / unit[:, None] * unit, law.B / unit[:, None], law.C * unit, law.D)


def _reachable(A: Complex, B: Complex) -> Complex:
    """Return an orthonormal basis of the controllable states, shape (n, r)."""
    n = len(A)
    basis = np.zeros((n, 0), dtype=complex)
    if not n or not B.size:
        return basis
    columns = np.linalg.norm(B, axis=0)
    new = B / np.where(columns > 0.0, columns, 1.0)
    scale = max(float(np.linalg.norm(A, 2)), 1e-300)
    while new.shape[1] and basis.shape[1] < n:
        for _ in range(2):
            new = new - basis @ (basis.conj().T @ new)
        U, s, _ = np.linalg.svd(new, full_matrices=False)
        fresh = U[:, s > UNREACHABLE]
        basis = np.hstack([basis, fresh])
        new = A @ fresh / scale
    return basis[:, :n]
