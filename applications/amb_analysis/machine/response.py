"""Synchronous response of a rotor in its bearings.

    [-Omega^2 M + i Omega (C + Omega G) + K - F(i Omega)] Q = Omega^2 (u, -i u)                   (1)

F describes all loads on the rotor that components compute from its displacements (`feedback`): forces of magnetic
bearings, and accelerations of a base that moves. M, C, G and K are the matrices of the rotor with all its other
supports.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from amb_analysis.machine.feedback import loads_of
from amb_analysis.machine.machine import Machine
from array_types import Array, Complex
from rotor_analysis.assembly import Matrices, with_bearings
from rotor_analysis.harmonic import harmonic_points
from rotor_analysis.parts import Bearing, Point
from rotor_analysis.refinement import about_resonances, refined
from rotor_analysis.resonances import resonances
from rotor_analysis.response import Stiffness, dynamic_stiffness, orbit, synchronous_motion


def passive(machine: Machine, Omega: float, others: tuple[Bearing, ...] = ()) -> Matrices:
    """Return the condensed rotor with its seals, its passive bearings and `others`, at a spin speed (rad/s)."""
    sealed = with_bearings(machine.free_rotor.model, machine.rotor.seals).at(Omega)
    return with_bearings(sealed, (*machine.passive_bearings, *others)).at(Omega)


def synchronous_response(
    machine: Machine, speeds: Array, cases: Sequence[Mapping[Point, complex]], others: tuple[Bearing, ...] = ()
) -> Complex:
    """Return the displacements (m) of all nodes at speeds (rad/s) under unbalance, shape (speeds, cases, nodes, 2).

    Parameters
    ----------
    machine
        The machine.
    speeds
        Spin speeds (rad/s), above 0, shape (n,).
    cases
        Unbalance (kg m) of each case, by node or centre of mass.
    others
        Additional bearings, such as the cross coupling of stages.
    """
    rotor = machine.free_rotor
    return synchronous_motion(rotor, stiffness_of(machine, others), cases, speeds, rotor.nodes)


def refined_response(
    machine: Machine,
    speeds: Array,
    cases: Sequence[Mapping[Point, complex]],
    nodes: Sequence[int],
    others: tuple[Bearing, ...] = (),
) -> tuple[Array, Complex]:
    """Return speeds (rad/s), denser near critical speeds and maxima, and the `synchronous_response` at these speeds.

    Parameters
    ----------
    machine, cases, others
        As for `synchronous_response`.
    speeds
        Ascending speeds (rad/s) above 0, all of which the result contains, shape (n,).
    nodes
        Nodes whose maxima are refined.
    """
    return refined(
        lambda more: synchronous_response(machine, more, cases, others),
        about_resonances(speeds, resonances(stiffness_of(machine, others), speeds)),
        lambda motion: orbit(motion[:, :, [node - 1 for node in nodes]])[0],
    )


def stiffness_of(machine: Machine, others: tuple[Bearing, ...] = ()) -> Stiffness:
    """Return the dynamic stiffness of (1) as a function of the spin speed (rad/s), in condensed coordinates."""
    rotor = machine.free_rotor
    motion, forces = rotor.displacement_of(rotor.nodes), rotor.force_at(harmonic_points(machine.rotor))
    along = np.zeros((len(forces), 1 if machine.rotor.thrust else 0))
    left = np.hstack([forces, along, rotor.base_force])

    def stiffness(Omega: float) -> Complex:
        rows, columns, loads = loads_of(machine, Omega, Omega)
        result = dynamic_stiffness(passive(machine, Omega, others), Omega)
        return np.asarray(result - left[:, rows] @ loads @ motion[columns])

    return stiffness
