"""Self-sustained whirl in contact without unbalance: forward at a natural frequency, or backward by friction.

Without unbalance, a journal on its circle, q = c exp(i (omega t + psi)), needs forces that turn with it:

    c_j p_j + sum_k R_jk(omega) (1 + i mu_k) N_k p_k = 0,   N_j > 0,   |q| < c elsewhere              (1)

For a single site, N = -c/(R (1 + i mu)) must be real and positive (H. F. Black, J. Mechanical Engineering Science 10
(1968) 1-12). For two sites, the angle between them has two solutions, and the frequency is found for each solution.
Friction acts against the spin while the journal slips, that is, while Omega R_s + omega c > 0. In a faster backward
whirl, the journal rolls.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache, partial
from typing import Annotated

import numpy as np
from scipy.optimize import brentq

from amb_analysis.steady_contact.forward_loop import Complex
from amb_analysis.steady_contact.receptances import receptances
from amb_analysis.steady_contact.rubbing_rotor import RubbingRotor
from amb_analysis.steady_contact.stability import Dynamics
from amb_analysis.steady_contact.synchronous_states import all_sets
from amb_cosim.presentation.json_data import JsonKey, Layout
from array_types import Array

POINTS = 400  # searched frequencies, each way
REACH = 30.0  # highest frequency, over the speed


@dataclass(frozen=True, eq=False)
class Whirl:
    """A whirl sustained by friction or rotation.

    contact
        Sites in contact.
    frequency
        Whirl frequency (rad/s), negative for backward whirl.
    N, friction, psi
        Normal force (N), friction force (N) and angle of the journal (rad) at each site.
    slips
        Whether the journals slip forward, as (1) assumes; otherwise they roll before they whirl this fast.
    growth, stable
        Largest growth rate (1/s) of small motion about the whirl, ignoring shifts of the whirl's phase, and whether no
        such motion grows.
    accurate
        Whether the reduced rotor is accurate at this frequency.
    """

    contact: tuple[str, ...]
    frequency: Annotated[float, "rad/s"]
    N: Annotated[dict[str, float], JsonKey("normal_forces_N")]
    friction: Annotated[dict[str, float], Layout.OMITTED]
    psi: Annotated[dict[str, float], Layout.OMITTED]
    slips: bool
    growth: Annotated[float, "1/s"]
    stable: bool = field(init=False)
    accurate: bool

    def __post_init__(self) -> None:
        object.__setattr__(self, "stable", self.growth <= 0.0)

    @property
    def grows_backward(self) -> bool:
        """Whether friction accelerates a backward whirl that is faster than this whirl."""
        return self.frequency < 0.0 and self.slips and not self.stable


def whirls(rotor: RubbingRotor, Omega: float, highest: float | None = None) -> list[Whirl]:
    """Return the sustained whirls at a speed (rad/s), with one or two sites in contact.

    Parameters
    ----------
    highest
        Largest searched frequency (rad/s); `REACH` times the speed by default, and at most 0.95 of the Nyquist
        frequency.
    """
    loop, c = rotor.loop(Omega), rotor.c
    nyquist = math.inf if loop.sample_time is None else 0.95 * math.pi / loop.sample_time
    reach = min(REACH * Omega if highest is None else highest, nyquist)
    mu_at = cache(partial(rotor.mu, Omega))

    @cache
    def R(omega: float) -> Complex:
        return receptances(loop, omega).R

    grid = np.geomspace(1e-3 * reach, reach, POINTS)
    radii = [site.journal_radius for site in rotor.records]
    result = []
    for contact in all_sets(len(rotor.sites), 2)[1:]:
        for branch in range(1 if len(contact) == 1 else 2):
            for line in (grid, -grid[::-1]):
                for omega, forces, q in _on_branch(R, line, contact, branch, mu_at, c):
                    others = [k for k in range(len(c)) if k not in contact]
                    if (forces > 0.0).all() and (np.abs(q[others]) < c[others]).all():
                        names = tuple(rotor.sites[k] for k in contact)
                        slips = all(Omega * radii[k] + omega * c[k] > 0.0 for k in contact)
                        psi = np.asarray(np.angle(q[list(contact)]), dtype=np.float64)
                        mu = mu_at(omega)
                        dynamics = Dynamics(loop, c, mu, rotor.mu_slope(Omega, omega), omega)
                        small = dynamics.about(contact, forces, psi)
                        at_rest = int(np.argmin(np.hypot(small.rates, small.frequencies - omega)))
                        growth = float(np.delete(small.rates, at_rest).max(initial=-math.inf))
                        forces_and_angles = (forces, mu[list(contact)] * forces, psi)
                        dicts = (dict(zip(names, map(float, values), strict=True)) for values in forces_and_angles)
                        N, friction, angles = dicts
                        accurate = abs(omega) <= rotor.valid_to
                        result.append(Whirl(names, omega, N, friction, angles, slips, growth, accurate))
    return sorted(result, key=lambda whirl: whirl.frequency)


def _on_branch(
    R: Callable[[float], Complex],
    frequencies: Array,
    contact: tuple[int, ...],
    branch: int,
    mu: Callable[[float], Array],
    c: Array,
) -> list[tuple[float, Array, Complex]]:
    """Return frequency, contact forces and motion of all sites at each zero of the last imaginary part of (1)."""

    def parts(omega: float) -> tuple[float, Complex, Complex]:
        at = list(contact)
        R_omega = R(omega)
        E = np.linalg.inv(R_omega[np.ix_(at, at)] * (1.0 + 1j * mu(omega)[at]))
        p: Complex = np.ones(len(at), dtype=complex)
        if len(at) == 2:
            g = E[0, 1] * c[at[1]]
            sine = -(E[0, 0] * c[at[0]]).imag / abs(g)
            if abs(sine) > 1.0:
                return math.nan, p, p
            angle = math.asin(sine) if branch == 0 else math.pi - math.asin(sine)
            p[1] = np.exp(1j * (angle - np.angle(g)))
        N: Complex = -p.conj() * (E @ (c[at] * p))
        return float(N[-1].imag), p, N

    values = [parts(float(omega))[0] for omega in frequencies]
    result: list[tuple[float, Array, Complex]] = []
    for k in range(len(frequencies) - 1):
        if values[k] * values[k + 1] < 0.0:  # false for NaN, where (1) has no solution
            try:
                omega = float(brentq(lambda x: parts(x)[0], frequencies[k], frequencies[k + 1], xtol=1e-10, rtol=1e-13))
            except ValueError:
                continue
            error, p, N = parts(omega)
            if math.isfinite(error) and abs(error) < 1e-6 * np.abs(N).max():
                force = np.zeros(len(c), dtype=complex)
                force[list(contact)] = -N.real * (1.0 + 1j * mu(omega)[list(contact)]) * p
                result.append((omega, np.asarray(N.real, dtype=np.float64), np.asarray(R(omega) @ force)))
    return result
