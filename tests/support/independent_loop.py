"""Sensitivity, disk margin and poles of the sampled loop of an isotropic machine, from elements of its shaft alone.

The elements have the energies of the static deflections of Timoshenko beams. In z = x + i y

    M z'' + (C_i - i Omega G) z' + (K - i Omega C_i) z = f,    C_i = sum 2 zeta_k omega_k (M phi_k) (M phi_k)^T   (1)

over all of their modes, which turn with the shaft. Nothing is reduced. The forces K_i i + K_s z, with the lag of the
amplifiers, are held over a sample, by the eigenvectors of (1). Only the law of the controller, the magnets' slopes and
sizes from the files are those of the package. A circle exp(-i omega t) is the conjugate of exp(i omega t), so that

    S_xx = (F + B)/2,  S_xy = i (F - B)/2,   F = S(omega),  B = conj(S(-omega)).                                 (2)
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg import eigh
from scipy.optimize import minimize

from amb_actuator.interface import DYNAMIC
from amb_analysis.linear.rotor_and_magnets import bearing_slopes
from amb_analysis.machine.machine import Machine
from amb_cosim.results.component_names import ACTUATOR, PLANT

UNSEEN = 0.05  # of its decay rate, by which control moves a pole
POINTS, WEIGHTS = np.polynomial.legendre.leggauss(4)


def static_shapes(layer):
    """Coefficients of w over z of the deflections of a beam by unit w_1, beta_1, w_2, beta_2, in rows.

    Without load between its ends w = a_0 + a_1 z + a_2 z^2 + a_3 z^3, and the section turns by beta = dw/dz + 6 c a_3
    with c = E I/(kappa G A), the ratio of the stiffnesses in bending and in shear.
    """
    L, c = layer.length, flexibility(layer)
    first, last = [0.0, 1.0, 0.0, 6.0 * c], [0.0, 1.0, 2.0 * L, 3.0 * L**2 + 6.0 * c]
    return np.linalg.inv([[1.0, 0.0, 0.0, 0.0], first, [1.0, L, L**2, L**3], last]).T


def flexibility(layer):
    """c = E I/(kappa G A) (m^2)."""
    shear = layer.shear_coefficient * layer.material.shear_modulus * layer.area
    return layer.material.youngs_modulus * layer.second_moment / shear


def beam(rotor):
    """M, G and K of the free rotor in a plane, from the energies of its elements; w and beta of each node in turn."""
    n = len(rotor.shaft.nodes)
    M, G, K = np.zeros((3, 2 * n, 2 * n))
    for e, layers in enumerate(rotor.elements):
        rows = slice(2 * e, 2 * e + 4)
        for layer in layers:
            a, c, EI = static_shapes(layer), flexibility(layer), layer.material.youngs_modulus * layer.second_moment
            for s, weight in zip(POINTS, WEIGHTS, strict=True):
                z, length = layer.length * (1.0 + s) / 2.0, layer.length * weight / 2.0
                w, beta = a @ [1.0, z, z**2, z**3], a @ [0.0, 1.0, 2.0 * z, 3.0 * z**2 + 6.0 * c]
                bending, shear = a @ [0.0, 0.0, 2.0, 6.0 * z], 6.0 * a[:, 3]
                K[rows, rows] += EI * length * (np.outer(bending, bending) + c * np.outer(shear, shear))
                inertia = layer.material.density * layer.second_moment * length * np.outer(beta, beta)
                M[rows, rows] += layer.material.density * layer.area * length * np.outer(w, w) + inertia
                G[rows, rows] += 2.0 * inertia
    for body in rotor.bodies:
        at = 2 * (body.node - 1)
        M[at, at] += body.mass
        M[at + 1, at + 1] += body.diametral_inertia
        G[at + 1, at + 1] += body.polar_inertia
    return M, G, K


@dataclass(frozen=True, eq=False)
class IndependentLoop:
    """x(n+1) = A x(n) + B i(n), y = C x of plant and magnets in z = x + i y, and the law of the controller.

    `poles` are exp(s T) of the plant, and `rates` its s (rad/s).
    """

    A: Any
    B: Any
    C: Any
    poles: Any
    rates: Any
    modal: tuple[Any, Any]
    law: Any
    time: float

    def control(self, z):
        """Currents over readings in z = x + i y at points z, shape (n, bearings, bearings)."""
        law = self.law
        x = np.linalg.solve(
            z[:, None, None] * np.eye(len(law.A)) - law.A, np.broadcast_to(law.B, (len(z), *law.B.shape))
        )
        K = law.C @ x + law.D
        return 0.5 * ((K[:, 0::2, 0::2] + K[:, 1::2, 1::2]) + 1j * (K[:, 1::2, 0::2] - K[:, 0::2, 1::2]))

    def forward(self, hertz):
        """S of z = x + i y over injected currents, shape (n, bearings, bearings)."""
        z = np.exp(2j * np.pi * hertz * self.time)
        P = (self.modal[0] / (z[:, None, None] - self.poles)) @ self.modal[1]
        return np.linalg.inv(np.eye(P.shape[2]) - self.control(z) @ P)

    def sensitivity(self, hertz):
        """S by (2), x and y of each bearing in turn, shape (n, axes, axes)."""
        F, B = self.forward(hertz), self.forward(-hertz).conj()
        n = 2 * F.shape[1]
        S = np.zeros((len(hertz), n, n), dtype=complex)
        S[:, 0::2, 0::2] = S[:, 1::2, 1::2] = (F + B) / 2.0
        S[:, 0::2, 1::2], S[:, 1::2, 0::2] = 1j * (F - B) / 2.0, -1j * (F - B) / 2.0
        return S

    def is_unseen(self, z):
        """Whether poles are those of modes faster than half the sample rate that the control does not move."""
        nearest = np.abs(self.poles - z[:, None]).argmin(axis=1)
        moved = np.abs(np.log(z / self.poles[nearest])) / self.time
        s = self.rates[nearest]
        return (np.abs(s.imag) > math.pi / self.time) & (moved < UNSEEN * np.abs(s.real))

    def closed_poles(self):
        """Poles z of the loop; forward whirl has a positive frequency, backward whirl a negative one."""
        law, unit = self.law, np.array([[1.0], [-1.0j]])
        turn = np.kron(np.eye(len(self.C)), unit)  # x and y of a forward circle
        back = np.kron(np.eye(self.B.shape[1]), 0.5 * unit.conj().T)
        loop = np.block(
            [
                [self.A + self.B @ back @ law.D @ turn @ self.C, self.B @ back @ law.C],
                [law.B @ turn @ self.C, law.A],
            ]
        )
        z, uncoupled = (
            np.linalg.eigvals(loop),
            np.linalg.eigvals(law.A),
        )  # of backward circles, half of the law's states
        return z[np.abs(z[:, None] - uncoupled).min(axis=1, initial=np.inf) > 1e-7]


def independent_loop(machine: Machine, Omega: float, others=()) -> IndependentLoop:
    """Return the loop of a machine at a spin speed (rad/s); `others` are isotropic bearings such as stages."""
    rotor, loop = machine.rotor, machine.loop
    M, G, K = beam(rotor)
    squares, phi = eigh(K, M)
    omega, momenta = np.sqrt(squares[2:]), M @ phi[:, 2:]
    C_i = (momenta * (2.0 * rotor.damping.ratios(len(omega)) * omega)) @ momenta.T
    assert rotor.damping.rotating == 1.0
    assert [rotor.seals, rotor.damping.mass, rotor.damping.stiffness, rotor.damping.loss_factor] == [(), 0, 0, 0]
    nodes = {bearing.name: bearing.node for bearing in rotor.bearings}
    magnets, parameters = list(machine.magnets), machine.parameters
    at = [2 * (nodes[name] - 1) for name in magnets]
    slopes = np.array([bearing_slopes(name, "x", parameters[ACTUATOR]) for name in magnets])
    stiffness = K - 1j * Omega * C_i
    for bearing in others:
        for part, row in ((bearing, 2 * (bearing.node - 1)), (bearing.tilting, 2 * bearing.node - 1)):
            if part is not None:
                (k, q), (minus_q, _) = part.at(Omega)[0]
                assert minus_q == -q
                stiffness[row, row] += k - 1j * q
    stiffness[at, at] -= slopes[:, 0]
    damping = C_i - 1j * Omega * G
    dynamic = parameters[ACTUATOR]["amplifier"] == DYNAMIC
    n, m, zero = len(M), len(magnets), np.zeros((len(M), len(M)))
    force = np.zeros((n, m))
    force[at, range(m)] = slopes[:, 1]
    A = np.block([[zero, np.eye(n)], [-np.linalg.solve(M, stiffness), -np.linalg.solve(M, damping)]])
    B = np.vstack([np.zeros((n, m)), np.linalg.solve(M, force)])
    if dynamic:
        lag = np.diag([2.0 * np.pi * parameters[ACTUATOR][f"{name}.bandwidth_x"] for name in magnets])
        A = np.block([[A, B], [np.zeros((m, 2 * n)), -lag]])
        B = np.vstack([np.zeros((2 * n, m)), lag])
    links = {link.target: link.source for link in loop.linear_components.plan.system.connections}
    read = [links[reading].removeprefix(f"{PLANT}.") for reading in loop.readings]
    C = np.zeros((len(read) // 2, A.shape[1]))
    for k, name in enumerate(read[0::2]):
        C[k, 2 * (machine.signals[name][0] - 1)] = 1.0
    assert [machine.signals[name][1] for name in read] == [0, 1] * len(C)
    s, V = np.linalg.eig(A)
    inverse, T = np.linalg.solve(V, B.astype(complex)), loop.sample_time
    growth = np.exp(s * T)
    held = ((growth - 1.0) / s)[:, None] * inverse
    (name,) = {source.partition(".")[0] for source in loop.sources}
    (part,) = loop.linear_components.at(Omega).parts([name])
    law = part.selected(loop.readings, loop.sources).law
    assert part.late == 0.0
    modal = C @ V, held
    sampled = (V * growth) @ np.linalg.inv(V)
    return IndependentLoop(sampled, V @ held, C, growth, s, modal, law, T)


def smallest_disk_margin(S) -> float:
    """1/alpha = min over D of sigma_max(D (S - 1/2) D^-1), D diagonal and positive, of S at a frequency."""
    M = S - 0.5 * np.eye(len(S))

    def largest(logarithms):
        d = np.exp(np.append(logarithms, 0.0))
        return np.linalg.norm(M * d[:, None] / d, 2)

    options = {"xatol": 1e-6, "fatol": 1e-9}
    return 1.0 / minimize(largest, np.zeros(len(S) - 1), method="Nelder-Mead", options=options).fun
