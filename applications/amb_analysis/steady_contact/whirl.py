"""Self-sustained whirl in contact without unbalance: forward at a natural frequency, or backward by friction.

Without unbalance, a journal on its circle, q = c exp(i (omega t + psi)), needs forces that turn with it:

    c_j p_j + sum_k R_jk(omega) (1 + i mu_k) N_k p_k = 0,   N_j > 0,   |q| < c elsewhere              (1)

For a single site, N = -c/(R (1 + i mu)) must be real and positive (H. F. Black, J. Mechanical Engineering Science 10
(1968) 1-12). For two sites, let F_jk = E_jk c_k with E the inverse of the matrix R_jk (1 + i mu_k), p_1 = 1 and
p_2 = (X + i Y)/D. Both forces are real if

    X = Im F_11 Re F_21 + Im F_22 Re F_12,   Y = Im F_11 Im F_21 - Im F_22 Im F_12,   D = -Im(F_12 F_21)   (2)

and p_2 is a direction where the mismatch

    (X^2 + Y^2 - D^2)/(X^2 + Y^2 + D^2)                                                                      (3)

vanishes. The mismatch of a single site is Im E/|E|. Both are continuous in omega and do not depend on the order of the
sites. Friction acts against the spin while the journal slips, that is, while Omega R_s + omega c > 0. In a faster
backward whirl, the journal rolls.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache, partial
from typing import Annotated

import numpy as np
from scipy.optimize import brentq, minimize_scalar

from amb_analysis.steady_contact.forward_loop import Complex
from amb_analysis.steady_contact.receptances import receptances
from amb_analysis.steady_contact.rubbing_rotor import RubbingRotor
from amb_analysis.steady_contact.stability import Dynamics
from amb_analysis.steady_contact.synchronous_states import all_sets
from amb_cosim.presentation.json_data import JsonKey, Layout
from array_types import Array
from rotor_analysis.refinement import refined

POINTS = 400  # searched frequencies, each way, before refinement
REACH = 30.0  # highest frequency, over the speed
CLOSE = 1e-9  # accuracy of an extremum of the mismatch, relative to the frequency
ZERO = 1e-6  # largest mismatch at a zero; rounding where F is almost singular changes its sign without a zero
FLAT = 1e-6  # least depth of an extremum of the mismatch


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
        at = list(contact)
        stiffness = cache(partial(_stiffness, R, mu_at, at, c[at]))
        for omega in (omega for line in (-grid[::-1], grid) for omega in _zeros(stiffness, line)):
            p, mu = _mismatch(stiffness(omega))[1], mu_at(omega)
            N = -p.conj() * (stiffness(omega) @ p)
            force = np.zeros(len(c), dtype=complex)
            force[at] = -N.real * (1.0 + 1j * mu[at]) * p
            q = R(omega) @ force
            others = np.delete(np.arange(len(c)), at)
            if not ((N.real > 0.0).all() and (np.abs(q[others]) < c[others]).all()):
                continue
            names = tuple(rotor.sites[k] for k in contact)
            forces, psi = np.asarray(N.real, dtype=np.float64), np.asarray(np.angle(q[at]), dtype=np.float64)
            small = Dynamics(loop, c, mu, rotor.mu_slope(Omega, omega), omega).about(contact, forces, psi)
            at_rest = int(np.argmin(np.hypot(small.rates, small.frequencies - omega)))
            growth = float(np.delete(small.rates, at_rest).max(initial=-math.inf))
            slips = all(Omega * radii[k] + omega * c[k] > 0.0 for k in contact)
            by_site = (dict(zip(names, map(float, v), strict=True)) for v in (forces, mu[at] * forces, psi))
            normal, friction, angles = by_site
            accurate = abs(omega) <= rotor.valid_to
            result.append(Whirl(names, omega, normal, friction, angles, slips, growth, accurate))
    return sorted(result, key=lambda whirl: whirl.frequency)


def _stiffness(
    R: Callable[[float], Complex], mu: Callable[[float], Array], at: list[int], c: Array, omega: float
) -> Complex:
    """Return F (N) of (2), shape (n, n), at a frequency; `at` are the sites in contact, and c their clearances (m)."""
    return np.asarray(np.linalg.inv(R(omega)[np.ix_(at, at)] * (1.0 + 1j * mu(omega)[at])) * c)


def _mismatch(F: Complex) -> tuple[float, Complex]:
    """Return the mismatch (3), and the directions p of the journals, shape (n,)."""
    if len(F) == 1:
        return float(F[0, 0].imag / abs(F[0, 0])), np.ones(1, dtype=complex)
    first, second = F[0, 0].imag, F[1, 1].imag
    p = complex(first * F[1, 0].real + second * F[0, 1].real, first * F[1, 0].imag - second * F[0, 1].imag)
    D = -float((F[0, 1] * F[1, 0]).imag)
    size = abs(p) ** 2 + D**2
    if size == 0.0:  # neither damping nor friction: real forces at any frequency
        return math.nan, np.ones(2, dtype=complex)
    return (abs(p) ** 2 - D**2) / size, np.array([1.0, math.copysign(1.0, D) * np.exp(1j * np.angle(p))])


def _zeros(stiffness: Callable[[float], Complex], line: Array) -> list[float]:
    """Return the zeros (rad/s) of the mismatch between the ends of ascending frequencies.

    Samples are added where F is large, about the natural frequencies of the rotor that is pinned at the sites. Two
    zeros between samples are found from the extremum between them.
    """

    def mismatch(omega: float) -> float:
        return _mismatch(stiffness(omega))[0]

    def norms(more: Array) -> Array:
        return np.array([np.abs(stiffness(omega)).max() for omega in more.tolist()])

    x = refined(norms, line, lambda values: values)[0].tolist()
    values = [mismatch(omega) for omega in x]
    ends = [(a, b) for a, b, v, w in zip(x, x[1:], values, values[1:], strict=False) if v * w < 0.0]
    for k in range(1, len(x) - 1):
        before, value, after = values[k - 1 : k + 2]
        sign = math.copysign(1.0, value)
        if 0.0 < sign * value < min(sign * before, sign * after) - FLAT:
            extremum = minimize_scalar(
                lambda omega, sign=sign: sign * mismatch(float(omega)),
                bounds=(x[k - 1], x[k + 1]),
                method="bounded",
                options={"xatol": CLOSE * abs(x[k])},
            )
            if extremum.fun < 0.0:
                ends += [(x[k - 1], float(extremum.x)), (float(extremum.x), x[k + 1])]
    found = sorted(float(brentq(mismatch, a, b, xtol=1e-10, rtol=1e-13)) for a, b in ends)
    return [omega for omega in found if abs(mismatch(omega)) < ZERO]
