"""All synchronous states for ranges of speed and unbalance, and the regime at each point.

* free: the orbit without contact is stable, and no contact state is stable
* both: the orbit without contact and a contact state are stable; the initial motion determines which is reached
* contact: no orbit without contact is stable, and a contact state settles (`SmallMotion.settles`)
* whirl: no orbit without contact is stable, and no contact state settles, so the rub is unsteady
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from enum import IntEnum
from functools import cached_property
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from amb_analysis.steady_contact.forward_loop import Complex
from amb_analysis.steady_contact.rubbing_rotor import RubbingRotor
from amb_analysis.steady_contact.stability import Dynamics, SmallMotion, slowest_decay
from amb_analysis.steady_contact.synchronous_states import States, all_sets, states_of_all
from array_types import Array, Bools
from rotor_analysis.refinement import refined

ACCURACY = 1e-4  # of the smallest factor that traps at a speed, relative
PARTS, ROUNDS = 5, 16  # parts of the interval that encloses it, and divisions


class Regime(IntEnum):
    """Possible behaviour of a rotor at a speed and an unbalance."""

    FREE, BOTH, CONTACT, WHIRL = range(4)


@dataclass(frozen=True, eq=False)
class StatesOfSet:
    """The n synchronous states of one set of sites in contact, for ranges of speed and unbalance.

    contact
        Indices of the sites in contact.
    speed, amount
        Indices of speed and unbalance of each state, shape (n,).
    N, psi
        Normal forces (N) and angles of the journals (rad), shape (n, m).
    radius
        Distances of all journals from their centres (m), shape (n, n_sites).
    dynamics
        Small motion at each speed.
    """

    contact: tuple[int, ...]
    speed: NDArray[np.int64]
    amount: NDArray[np.int64]
    N: Annotated[Array, "N"]
    psi: Annotated[Array, "rad"]
    radius: Annotated[Array, "m"]
    dynamics: tuple[Dynamics, ...]
    _below: dict[int, bool] = field(default_factory=dict)

    @cached_property
    def growth(self) -> Annotated[Array, "1/s"]:
        """Growth rate of small motion (1/s), shape (n,)."""
        at = zip(self.speed.tolist(), self.N, self.psi, strict=True)
        if not self.contact:
            return np.array([self.dynamics[speed].free_growth for speed, _, _ in at])
        return np.array([self.dynamics[speed].growth(self.contact, N, psi) for speed, N, psi in at])

    def grows_below(self, k: int, limit: float) -> bool:
        """Return whether the growth rate about state k is below a limit (1/s), which is at most 0."""
        dynamics = self.dynamics[int(self.speed[k])]
        if not self.contact:
            return dynamics.free_growth < limit
        if k not in self._below:
            self._below[k] = dynamics.grows_below(limit, self.contact, self.N[k], self.psi[k])
        return self._below[k]

    @property
    def stable(self) -> Bools:
        """Mask of stable states."""
        return np.asarray(self.growth < 0.0)


@dataclass(frozen=True, eq=False)
class TrapMap:
    """States at all pairs of a speed (rad/s) and a factor on an unbalance (1), for n speeds and k factors.

    To determine the regime of a point, the stability of only a few of its states is needed: one stable state in contact
    is sufficient.

    states
        States of each set of sites in contact, contact-free states first.
    """

    speeds: Annotated[Array, "rad/s"]
    factors: Array
    states: tuple[StatesOfSet, ...]

    def regimes(self) -> NDArray[np.int64]:
        """Return the `Regime` of each point, shape (n, k)."""
        shape = len(self.speeds), len(self.factors)
        found = [[self._regime(speed, amount) for amount in range(shape[1])] for speed in range(shape[0])]
        return np.array(found, dtype=np.int64).reshape(shape)

    def least_trapping(self) -> Array:
        """Return the smallest factor that gives the regime `BOTH` or `CONTACT` at each speed; NaN if there is none."""
        result = np.full(len(self.speeds), np.nan)
        for speed in range(len(self.speeds)):
            for amount, factor in enumerate(self.factors):
                if self._regime(speed, amount) in (Regime.BOTH, Regime.CONTACT):
                    result[speed] = factor
                    break
        return result

    @cached_property
    def _states_at(self) -> dict[tuple[int, int], list[tuple[int, int]]]:
        """All states at each point, as pairs of set index and state index, by the indices of speed and unbalance."""
        result: dict[tuple[int, int], list[tuple[int, int]]] = {}
        for n, of_set in enumerate(self.states):
            for k, point in enumerate(zip(of_set.speed.tolist(), of_set.amount.tolist(), strict=True)):
                result.setdefault(point, []).append((n, k))
        return result

    def _regime(self, speed: int, amount: int) -> Regime:
        """Return the regime of a point."""
        here = [(self.states[n], k) for n, k in self._states_at.get((speed, amount), [])]
        free = any(states.grows_below(k, 0.0) for states, k in here if not states.contact)
        limit = 0.0 if free else slowest_decay(float(self.speeds[speed]))
        if any(states.grows_below(k, limit) for states, k in here if states.contact):
            return Regime.BOTH if free else Regime.CONTACT
        return Regime.FREE if free else Regime.WHIRL


def least_trapping_at(
    rotor: RubbingRotor, Omega: float, factors: Array, most: int | None = 2, below: float = 0.0
) -> float:
    """Return the smallest factor that traps the rotor at a speed (rad/s) (`TrapMap.least_trapping`); NaN if none does.

    The limit lies between the first of the ascending factors that traps the rotor and the factor before it. The
    interval is divided until its width is at most `ACCURACY` times the limit. The factor `below` must not trap the
    rotor.
    """
    least = np.nan
    for _ in range(ROUNDS):
        first = float(trap_map(rotor, np.array([Omega]), factors, most).least_trapping()[0])
        if np.isnan(first):
            break
        below, least = float(max(factors[factors < first], default=below)), first
        if least - below <= ACCURACY * least:
            break
        factors = np.linspace(below, least, PARTS + 1)[1:]
    return least


def least_trapping_curve(rotor: RubbingRotor, coarse: TrapMap, most: int | None = 2) -> Array:
    """Return the smallest factor that traps the rotor at each speed of a map, refined between factors of the map.

    The result is NaN at speeds at which no factor traps the rotor.
    """
    curve = coarse.least_trapping()
    for k in np.flatnonzero(np.isfinite(curve)):
        below = float(max(coarse.factors[coarse.factors < curve[k]], default=0.0))
        between = np.linspace(below, curve[k], PARTS + 1)[1:]
        curve[k] = least_trapping_at(rotor, float(coarse.speeds[k]), between, most, below)
    return curve


def least_trapping_over(
    rotor: RubbingRotor, speeds: Array, curve: Array, most: int | None = 2
) -> tuple[float, float] | None:
    """Return the smallest factor with which the rotor is trapped at one of the speeds (rad/s), and that speed, or None.

    The minimum is refined between the two speeds beside the lowest point of the curve. If no factor traps the rotor at
    one of these speeds, the curve ends before this speed, often at the minimum of the curve. This end is located to
    within `ACCURACY` times the distance between the two speeds.

    Parameters
    ----------
    rotor
        The rotor.
    speeds, curve
        The speeds of a map and its `least_trapping_curve`, shape (n,) each.
    """
    if np.isnan(curve).all():
        return None
    at = int(np.nanargmin(curve))
    end = 2.0 * float(curve[at])
    factors = np.linspace(0.0, end, 2 * PARTS + 1)[1:]

    def least(more: Array) -> Array:
        return np.array([least_trapping_at(rotor, float(Omega), factors, most) for Omega in more])

    near = [float(speeds[at])]
    for k in (at - 1, at + 1):
        if 0 <= k < len(speeds):
            near.append(float(speeds[k]) if np.isfinite(curve[k]) else _last_trapping(least, near[0], float(speeds[k])))
    closer, values = refined(
        lambda more: np.nan_to_num(least(more), nan=end), np.unique(near), lambda factors: -factors, resonant=False
    )
    best = int(np.argmin(values))
    return float(values[best]), float(closer[best])


def _last_trapping(least: Callable[[Array], Array], inside: float, outside: float) -> float:
    """Return the speed (rad/s) closest to `outside` at which the rotor is trapped.

    The rotor is trapped at the speed `inside` and not trapped at the speed `outside`.
    """
    enough = ACCURACY * abs(outside - inside)
    while abs(outside - inside) > enough:
        middle = 0.5 * (inside + outside)
        inside, outside = (inside, middle) if np.isnan(least(np.array([middle]))[0]) else (middle, outside)
    return inside


def least_touching(rotor: RubbingRotor, speeds: Array) -> tuple[float, float]:
    """Return the smallest factor of the unbalance at which the contact-free orbit touches a site, and the speed there.

    k = min_s c_s / |P_s u Omega^2|,    refined between the speeds     (1)

    Parameters
    ----------
    rotor
        The rotor, with the unbalance u that the factor multiplies.
    speeds
        Ascending speeds above zero (rad/s), shape (n,).
    """
    closer, shares = refined(lambda more: clearance_shares(rotor, more), speeds, lambda shares: shares)
    at = int(shares.max(axis=1).argmax())
    with np.errstate(divide="ignore"):
        return float(1.0 / shares[at].max()), float(closer[at])


def clearance_shares(rotor: RubbingRotor, speeds: Array) -> Array:
    """Return the contact-free orbits |P_s u Omega^2| relative to the clearances c_s, shape (speeds, n_sites)."""
    orbits = [np.abs(rotor.receptances(float(Omega)).P @ rotor.unbalance) * Omega**2 for Omega in speeds]
    return np.array(orbits) / rotor.c


def trap_map(rotor: RubbingRotor, speeds: Array, factors: Array, most: int | None = 2) -> TrapMap:
    """Return all synchronous states, and their stability, at speeds (rad/s) and factors on the rotor's unbalance.

    Parameters
    ----------
    rotor
        The rotor, with the unbalance that the factors multiply.
    speeds, factors
        Ascending values; speeds must be above zero.
    most
        Largest number of sites in contact at once; None allows all sites.
    """
    sets = all_sets(len(rotor.sites), most)
    found: list[list[States]] = []
    dynamics = tuple(rotor.dynamics(float(Omega)) for Omega in speeds)
    for Omega, of_speed in zip(speeds, dynamics, strict=True):
        at = rotor.receptances(float(Omega))
        r = np.outer(factors, at.P @ rotor.unbalance * Omega**2)
        found.append(states_of_all(sets, at.R, of_speed.mu, rotor.c, r))
    joined = (_joined(contact, pieces, dynamics) for contact, *pieces in zip(sets, *found, strict=True))
    return TrapMap(speeds, factors, tuple(joined))


def _joined(contact: tuple[int, ...], pieces: list[States], dynamics: tuple[Dynamics, ...]) -> StatesOfSet:
    return StatesOfSet(
        contact,
        np.concatenate([np.full(len(states.points), k, dtype=np.int64) for k, states in enumerate(pieces)]),
        np.concatenate([states.points for states in pieces]),
        np.concatenate([states.N for states in pieces]),
        np.concatenate([states.psi for states in pieces]),
        np.abs(np.concatenate([states.q for states in pieces])),
        dynamics,
    )


@dataclass(frozen=True, eq=False)
class SolvedState:
    """A synchronous state with its forces, orbits, currents and stability.

    contact
        Names of the sites in contact.
    N, psi
        Normal force (N) and angle of the journal from the reference of unbalance (rad) at each site in contact.
    friction
        Friction force at each site in contact (N).
    radius
        Distance of the journal from the centre at each site (m).
    currents
        Complex demanded current of each bearing, in the rotating frame (A).
    small
        Small motion about the state.
    """

    contact: tuple[str, ...]
    N: Annotated[dict[str, float], "N"]
    psi: Annotated[dict[str, float], "rad"]
    friction: Annotated[dict[str, float], "N"]
    radius: Annotated[dict[str, float], "m"]
    currents: dict[str, complex]
    small: SmallMotion


def states_at(rotor: RubbingRotor, Omega: float, injected: Complex | None = None) -> list[SolvedState]:
    """Return all synchronous states of a rotor at a speed (rad/s), whichever sites it touches.

    Parameters
    ----------
    injected
        Synchronous currents (A) added to those of the controller, shape (n_bearings,).
    """
    at, loop, dynamics, result = rotor.receptances(Omega), rotor.loop(Omega), rotor.dynamics(Omega), []
    mu = dynamics.mu
    added = np.zeros(len(loop.currents), dtype=complex) if injected is None else injected
    R_i, P_i, S_i = at.currents
    force = rotor.unbalance * Omega**2
    r = (at.P @ force + at.S @ added)[None]
    for states in states_of_all(all_sets(len(rotor.sites)), at.R, mu, rotor.c, r):
        contact, names = states.contact, tuple(rotor.sites[k] for k in states.contact)
        for n in range(len(states.points)):
            currents = R_i @ states.force[n] + P_i @ force + S_i @ added
            N = dict(zip(names, map(float, states.N[n]), strict=True))
            result.append(
                SolvedState(
                    names,
                    N,
                    dict(zip(names, map(float, states.psi[n]), strict=True)),
                    {name: float(mu[k]) * N[name] for k, name in zip(contact, names, strict=True)},
                    dict(zip(rotor.sites, map(float, np.abs(states.q[n])), strict=True)),
                    dict(zip(loop.currents, map(complex, currents), strict=True)),
                    dynamics.about(contact, states.N[n], states.psi[n]),
                )
            )
    return result
