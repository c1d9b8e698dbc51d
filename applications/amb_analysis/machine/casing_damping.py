"""Damping that the loop of a levitated rotor takes from a mode of the casing in which the machine stands.

Magnets push on the casing, and sensors measure relative to it. In a mode of the casing with modal mass m, the magnets
move by y and all other planes P, such as sensors and seals, by psi_P y:

    (D - L F R) q = (sum_k S_k 1 psi_k - L F_in psi_in) y                                         (1)
    Z y = psi' f,    f_magnets = F R q - F_in psi_in y,    f_k = -S_k (q - 1 psi_k y)             (2)
    m (-omega^2 + 2 i zeta_0 omega_0 omega + omega_0^2) y + Z y = 0
    m Delta zeta = Im Z/(2 omega^2)                                                               (3)

q is the motion of the rotor in space, and 1 is a unit displacement of the whole rotor. D is the rotor's dynamic
stiffness with its passive bearings and seals k, whose stiffnesses are S_k. F maps displacements to the magnets' forces,
and F_in maps signals at all inputs that read displacements to these forces. The forces f act on the rotor, and their
reaction acts on the casing. (3) is the first term of a series in Z/(m omega^2). R. R. Craig and A. J. Kurdila,
Fundamentals of Structural Dynamics, 2nd edition, Wiley 2006, chapter 17 (substructure coupling).
"""

from __future__ import annotations

import numpy as np

from amb_analysis.machine.feedback import component_responses, fed_loads
from amb_analysis.machine.machine import AXES, Machine
from amb_cosim.results.component_names import ACTUATOR
from array_types import Array
from rotor_analysis.assembly import with_bearings
from rotor_analysis.harmonic import harmonic_model
from rotor_analysis.response import dynamic_stiffness


def damping_taken(machine: Machine, frequencies: Array, others: float) -> Array:
    """Return -m Delta zeta (kg) of (3), the larger of casing modes along x and along y, shape (n,).

    The mode stays stable if the product of its modal mass and its damping ratio is larger.

    Parameters
    ----------
    machine
        The machine, at the spin speed at the start of its scenario.
    frequencies
        Natural frequencies (Hz) of the mode, above 0, shape (n,).
    others
        Motion psi of sensors and seals over that of the magnets, for which m is stated: 1 if the casing moves as a
        whole, 0 if only the magnets move.
    """
    omegas, Omega = 2.0 * np.pi * np.asarray(frequencies, np.float64), machine.Omega
    source, rotor = machine.run_components.at(Omega), machine.rotor
    loads = {name: row for name, row in fed_loads(machine, source).items() if name.endswith((".f_x", ".f_y"))}
    feeds = source.feeds(source.names).items()
    ends = {target: end.partition(".")[2] for target, end in feeds}
    read = {target: machine.signals[name][1] for target, name in ends.items() if name in machine.signals}
    columns, responses = component_responses(machine, source, list(loads), omegas, list(read))
    psi = np.zeros((len(read), 2))
    for k, (name, axis) in enumerate(read.items()):
        psi[k, axis] = 1.0 if name.startswith(f"{ACTUATOR}.") else others
    F, F_in = responses[:, :, : len(columns)], responses[:, :, len(columns) :] @ psi
    of_magnets = np.array([[float(name.endswith(axis)) for axis in AXES] for name in loads])
    supports = ((machine.passive_bearings, 1.0), (rotor.seals, others))
    nodes = [machine.bearings[name] for name in machine.magnets] + [k.node for group, _ in supports for k in group]
    free = harmonic_model(rotor, nodes, float(omegas.max()), ())
    n = free.model.size  # without the motion along the shaft
    left, right = free.left[:n, list(loads.values())], free.right[columns, :n]
    one = -np.linalg.solve(free.model.M, free.left[:n, free.base_columns])
    D = dynamic_stiffness(free.model.at(Omega), Omega, omegas)
    stiffness, driven = D - left @ F @ right, -left @ F_in
    S_psi = []
    for group, psi_k in supports:
        S = dynamic_stiffness(with_bearings(free.model, group).at(Omega), Omega, omegas) - D
        stiffness, driven = stiffness + S, driven + psi_k * S @ one
        S_psi.append((S, psi_k))
    q = np.linalg.solve(stiffness, driven)
    Z = of_magnets.T @ (F @ right @ q - F_in) - sum(psi_k * one.T @ S @ (q - psi_k * one) for S, psi_k in S_psi)
    return -np.asarray(np.imag(Z)[:, (0, 1), (0, 1)] / (2.0 * omegas[:, np.newaxis] ** 2)).min(axis=1)
