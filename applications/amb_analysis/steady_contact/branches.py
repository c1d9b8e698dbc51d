"""Branches of states as functions of speed, continued through folds."""

from __future__ import annotations

import numpy as np
from scipy.optimize import linear_sum_assignment

from amb_analysis.steady_contact.trap_map import StatesOfSet
from array_types import Array

NEAR = 0.5  # largest distance (`_distance`) of two states of a branch at neighbouring speeds
MEETS = 0.9  # largest distance of the end states of two branches that meet in a fold


def branches(states: StatesOfSet, n_speeds: int) -> list[list[int]]:
    """Return the branches for one unbalance as lists of state indices; branches that meet in a fold are joined.

    States at neighbouring speeds are paired so that the sum of their distances is minimal. If two branches begin, or
    end, close to each other between the same two speeds, they meet there.
    """
    states_at_speed = [np.flatnonzero(states.speed == k) for k in range(n_speeds)]
    closed: list[list[int]] = []
    open_branches: list[list[int]] = []
    for here in states_at_speed:
        matched = _matched([branch[-1] for branch in open_branches], list(here), states)
        ended = [branch for k, branch in enumerate(open_branches) if k not in matched]
        for k, number in matched.items():
            open_branches[k].append(number)
        continued = [open_branches[k] for k in matched]
        new_branches = [[int(number)] for number in here if number not in matched.values()]
        closed += _joined_ends(ended, states)
        open_branches = continued + new_branches
    closed += open_branches
    return _joined_starts(closed, states)


def _distance(a: int, b: int, states: StatesOfSet) -> float:
    """Return the largest change between two states: the relative change of a force, or the change of an angle (rad)."""
    if not states.contact:
        return 0.0
    force = np.abs(np.log(states.N[a] / states.N[b])).max()
    return float(max(force, np.abs(np.exp(1j * (states.psi[a] - states.psi[b])) - 1.0).max()))


def _matched(before: list[int], here: list[int], states: StatesOfSet) -> dict[int, int]:
    """Return the state that continues each branch, by the index of the branch."""
    if not before or not here:
        return {}
    cost: Array = np.array([[_distance(a, b, states) for b in here] for a in before])
    pairs = zip(*linear_sum_assignment(cost), strict=True)
    return {int(k): int(here[j]) for k, j in pairs if cost[k, j] < NEAR}


def _joined_ends(ended: list[list[int]], states: StatesOfSet) -> list[list[int]]:
    """Join branches that end between the same two speeds, if their last states are so close that they meet."""
    remaining, result = list(ended), []
    while remaining:
        branch = remaining.pop()
        nearest = min(remaining, key=lambda other: _distance(branch[-1], other[-1], states), default=None)
        if nearest is not None and _distance(branch[-1], nearest[-1], states) < MEETS:
            remaining.remove(nearest)
            result.append(branch + nearest[::-1])
        else:
            result.append(branch)
    return result


def _joined_starts(ends_joined: list[list[int]], states: StatesOfSet) -> list[list[int]]:
    """Join branches that begin at the same speed, if their first states are so close that they meet."""
    result = list(ends_joined)
    merged = True
    while merged:
        merged = False
        for i, branch in enumerate(result):
            for j in range(i + 1, len(result)):
                joined = _at_start(branch, result[j], states)
                if joined is not None:
                    result[i] = joined
                    del result[j]
                    merged = True
                    break
            if merged:
                break
    return result


def _at_start(first: list[int], other: list[int], states: StatesOfSet) -> list[int] | None:
    for a in (first, first[::-1]):
        for b in (other, other[::-1]):
            begins = len(a) < 2 or states.speed[a[0]] < states.speed[a[1]]
            same = states.speed[a[0]] == states.speed[b[0]] and (len(b) < 2 or states.speed[b[0]] < states.speed[b[1]])
            if begins and same and states.contact and _distance(a[0], b[0], states) < MEETS:
                return a[::-1] + b
    return None
