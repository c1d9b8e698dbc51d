"""Small motion about a synchronous state: linear dynamics in the rotating frame under the contact constraints.

The axes turn with the rotor and point along the normal n and the tangent t of each site. To first order, a small motion
(a, b) of a journal in contact changes its force -N (1 + i mu) exp(i psi). The constraint requires a = 0. If lambda is
the change of N, the changes of the force with friction are

    f_n = -lambda,     f_t = -mu lambda - (1 + mu^2) (N/c) b - mu'(v) N b'                           (1)

The normal force on the circle acts as a spring of stiffness N/c, and lambda follows from a'' = 0. mu'(v) is the slope
of the friction coefficient with respect to the slip velocity. Because b' adds to the slip velocity, friction that
decreases with slip drives this motion.

The motion obeys x' = (A - i Omega) x, and held currents turn with -i Omega. Over one sample, the rotor and its control
obey x(n+1) = M x(n). The eigenvalues z of M give s = ln(z)/T. This is exact for an isotropic loop.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, TypeVar

import numpy as np
from scipy.linalg import expm, matrix_balance

from amb_analysis.steady_contact.forward_loop import Complex, ForwardLoop
from array_types import Array

Omegas = TypeVar("Omegas", float, Array)

TURNS = 1000.0  # turns of the rotor within which a vibration that settles falls to 1/e
STABLE = 1e-7  # largest growth rate over the whirl frequency that rounding can produce


@dataclass(frozen=True, eq=False)
class SmallMotion:
    """Vibrations about a state.

    growth
        Largest growth rate (1/s); negative if the state is stable.
    frequency
        Whirl frequency (rad/s) of the least damped vibration in the fixed frame; negative for backward whirl. The
        frequency equals the spin speed if the motion diverges without whirling in the rotating frame.
    damping
        Damping ratio -Re s/|s + i Omega| (1) of this vibration.
    rates, frequencies
        Rates of all vibrations (1/s) and their whirl frequencies (rad/s), least damped first.
    """

    growth: Annotated[float, "1/s"]
    frequency: Annotated[float, "rad/s"]
    damping: float
    rates: Annotated[Array, "1/s"]
    frequencies: Annotated[Array, "rad/s"]

    @property
    def is_stable(self) -> bool:
        """Whether the state is stable."""
        return self.growth < STABLE * max(abs(self.frequency), 1.0)

    def settles(self, Omega: float) -> bool:
        """Return whether vibrations at a speed (rad/s) fall to 1/e within `TURNS` turns; otherwise they persist."""
        return self.growth < slowest_decay(Omega)


def slowest_decay(Omega: Omegas) -> Omegas:
    """Return the negative growth rate (1/s) below which vibrations at a speed (rad/s) fall to 1/e in `TURNS` turns."""
    return -Omega / (2.0 * math.pi * TURNS)


class Dynamics:
    """Small motion about states of one loop; the parts common to all states are computed once."""

    def __init__(self, loop: ForwardLoop, c: Array, mu: Array, mu_slope: Array, frame: float | None = None) -> None:
        """Prepare the loop in axes that turn with `frame` (rad/s), which is the spin speed by default.

        Parameters
        ----------
        loop
            The loop of forward motion.
        c, mu, mu_slope
            Clearance (m), friction coefficient (1), and slope of the friction coefficient with respect to the slip
            velocity (s/m), for each site.
        frame
            Whirl frequency of the states (rad/s).
        """
        self.loop, self.c, self.mu, self.mu_slope = loop, c, mu, mu_slope
        self.frame = loop.Omega if frame is None else frame
        plant, m = loop.plant, len(loop.sites)
        _, (scale, _) = matrix_balance(plant.A, permute=False, separate=True)
        A = plant.A / scale[:, None] * scale - 1j * self.frame * np.eye(len(plant.A))
        B, C = plant.B / scale[:, None], plant.C * scale
        at_sites, _, at_currents = loop.columns
        self.A, self.B_sites, self.B_currents = _real(A), B[:, at_sites], _real(B[:, at_currents])
        self.C_sites, self.C_readings = C[:m], _real(C[m:])
        self.n, self.turning = len(self.A), _real(-1j * self.frame * np.eye(len(loop.late)))
        if loop.controller is not None and loop.sample_time is not None:
            k, back = loop.controller, np.exp(-1j * self.frame * loop.sample_time)
            self.K_A, self.K_B, self.K_C, self.K_D = _real(k.A * back), _real(k.B * back), _real(k.C), _real(k.D)

    def about(self, contact: tuple[int, ...], N: Array, psi: Array) -> SmallMotion:
        """Return the vibrations about a state, given N (N) and psi (rad) of the sites in contact."""
        A, B, basis = self._constrained(contact, N, psi)
        T = self._sample_time
        values, vectors = np.linalg.eig(A if T is None else self._sampled(A, B, basis, T))
        if T is not None:
            values = np.log(np.where(np.abs(values) > 1e-12, values, 1e-12).astype(complex)) / T
        return self._sorted(values, basis @ vectors[: basis.shape[1]])

    def growth(self, contact: tuple[int, ...], N: Array, psi: Array) -> float:
        """Return the largest growth rate (1/s) about a state; arguments as for `about`, which takes twice as long."""
        return self._growth(self._transition(contact, N, psi))

    def grows_below(self, limit: float, contact: tuple[int, ...], N: Array, psi: Array) -> bool:
        """Return whether the `growth` about a state is below a limit (1/s), which must not be positive.

        If det(1 - M), or det(-A) without sampling, is negative, an odd number of real eigenvalues grow. In this case,
        the eigenvalues need not be computed. Saddles are such states; for example, one of two states that meet in a
        fold is a saddle.
        """
        M = self._transition(contact, N, psi)
        identity = 0.0 if self._sample_time is None else np.eye(len(M))
        return bool(np.linalg.slogdet(identity - M)[0] >= 0.0) and self._growth(M) < limit

    @cached_property
    def free_growth(self) -> float:
        """Largest growth rate (1/s) about the contact-free orbit."""
        return self.growth((), np.zeros(0), np.zeros(0))

    def _transition(self, contact: tuple[int, ...], N: Array, psi: Array) -> Array:
        """Return the matrix M of one sample about a state, or A if there is no sampled controller."""
        A, B, basis = self._constrained(contact, N, psi)
        T = self._sample_time
        return A if T is None else self._sampled(A, B, basis, T)

    def _growth(self, M: Array) -> float:
        """Return the largest growth rate (1/s) from the matrix of `_transition`."""
        T, values = self._sample_time, np.linalg.eigvals(M)
        return float(values.real.max()) if T is None else math.log(max(float(np.abs(values).max()), 1e-12)) / T

    @property
    def _sample_time(self) -> float | None:
        """Time between samples (s); None if there is no sampled controller."""
        return None if self.loop.controller is None else self.loop.sample_time

    def _constrained(self, contact: tuple[int, ...], N: Array, psi: Array) -> tuple[Array, Array, Array]:
        """Return A and B for held currents in a basis of the motions that maintain contact, and the basis."""
        if not contact:
            return self.A, self.B_currents, np.eye(self.n)
        at = list(contact)
        turn = np.exp(1j * psi)
        radial, tangential = _rows(self.C_sites[at] / turn[:, None])
        along_n, along_t = _columns(self.B_sites[:, at] * turn)
        mu, damping = self.mu[at], self.mu_slope[at] * N
        A = self.A - along_t @ ((1.0 + mu**2) * N / self.c[at] * tangential.T + damping * (tangential @ self.A).T).T
        pushed = along_n + along_t * mu
        accelerations = radial @ A
        mobility = accelerations @ pushed
        reaction = np.eye(self.n) - pushed @ np.linalg.solve(mobility, accelerations)  # so that a'' = 0
        constraints = np.vstack([radial / np.linalg.norm(radial, axis=1)[:, None], _unit(accelerations)])
        basis = np.linalg.svd(constraints)[2][len(constraints) :].T
        return basis.T @ reaction @ A @ basis, basis.T @ reaction @ self.B_currents, basis

    def _sampled(self, A: Array, B: Array, basis: Array, T: float) -> Array:
        """Return the matrix M of one sample; its states are those of rotor and controller, and the delayed currents.

        In rotating axes, a held current turns backward, and so do the controller's states.
        """
        C, K_A, K_B, K_C, K_D = self.C_readings @ basis, self.K_A, self.K_B, self.K_C, self.K_D
        b, r = B.shape[1], len(K_A)
        Phi, now, before = self._steps(A, B, T)
        if not (self.loop.late > 0.0).any():
            return np.block([[Phi + now @ K_D @ C, now @ K_C], [K_B @ C, K_A]])
        turned = _real(np.exp(-1j * self.frame * T) * np.eye(b // 2))
        return np.block(
            [
                [Phi + now @ K_D @ C, now @ K_C, before],
                [K_B @ C, K_A, np.zeros((r, b))],
                [turned @ K_D @ C, turned @ K_C, np.zeros((b, b))],
            ]
        )

    def _steps(self, A: Array, B: Array, T: float) -> tuple[Array, Array, Array]:
        """Return Phi and the input matrices for the currents of this and the previous sample, in axes at the sample."""
        Phi, now = self._turning(A, B, T)
        before = np.zeros_like(B)
        for f in sorted({float(f) for f in self.loop.late if f > 0.0}):
            columns = np.tile(self.loop.late == f, 2)
            (_, Gamma_before), (Phi_after, Gamma_after) = self._turning(A, B, f * T), self._turning(A, B, (1.0 - f) * T)
            turned = _real(np.exp(-1j * self.frame * f * T) * np.eye(len(self.loop.late)))
            before[:, columns] = (Phi_after @ Gamma_before)[:, columns]
            now[:, columns] = (Gamma_after @ turned)[:, columns]
        return Phi, now, before

    def _turning(self, A: Array, B: Array, time: float) -> tuple[Array, Array]:
        """Return Phi and Gamma for a time (s), with currents that turn with -i Omega."""
        n, b = B.shape
        generator = np.zeros((n + b, n + b))
        generator[:n, :n], generator[:n, n:] = A, B
        generator[n:, n:] = self.turning
        transition = expm(generator * time)
        return transition[:n, :n], transition[:n, n:]

    def _sorted(self, s: Complex, vectors: Complex) -> SmallMotion:
        """Return vibrations sorted by growth: v1 + i v2 whirls with Omega + Im s, its conjugate with Omega - Im s."""
        half, Omega = self.n // 2, self.frame
        nonnegative = s.imag >= 0.0
        s, vectors = s[nonnegative], vectors[:, nonnegative]
        order = np.argsort(-s.real, kind="stable")
        s, vectors = s[order], vectors[:, order]
        upper, lower = vectors[:half] + 1j * vectors[half:], vectors[:half].conj() + 1j * vectors[half:].conj()
        sense = np.where(np.linalg.norm(upper, axis=0) >= np.linalg.norm(lower, axis=0), 1.0, -1.0)
        rates, frequencies = np.asarray(s.real, dtype=np.float64), np.asarray(Omega + sense * s.imag, dtype=np.float64)
        size = math.hypot(s[0].real, frequencies[0])
        return SmallMotion(float(s[0].real), float(frequencies[0]), float(-s[0].real / size), rates, frequencies)


def _real(A: Complex) -> Array:
    """Return the real form of a complex matrix, with the real parts of states before the imaginary parts."""
    return np.block([[A.real, -A.imag], [A.imag, A.real]])


def _rows(C: Complex) -> tuple[Array, Array]:
    """Return the rows for the real part and the imaginary part of C x."""
    return np.hstack([C.real, -C.imag]), np.hstack([C.imag, C.real])


def _columns(B: Complex) -> tuple[Array, Array]:
    """Return the columns for a real force and an imaginary force."""
    return np.vstack([B.real, B.imag]), np.vstack([-B.imag, B.real])


def _unit(rows: Array) -> Array:
    return np.asarray(rows / np.linalg.norm(rows, axis=1)[:, None])
