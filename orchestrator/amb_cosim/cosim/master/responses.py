"""The response of an FMU, in one step, to changes of its state and inputs, found by stepping from a saved state.

This requires FMUs exported by this project that declare the linear part of their state (`fmi_export.linear_state`).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from amb_cosim.cosim.fmu.component import FmuComponent
from amb_cosim.cosim.fmu.fmu_interface import FmuInterface
from array_types import Array, Bools, Indices

CHANGE = 1e-6  # of a state (SI units) and, at least, of an input; any serves where all is linear
SHARE = 1e-3  # of an input, by which it is changed; a change by its full size may exceed a limit
ANGLES = 2.0 * math.pi / 3.0 * np.arange(3)
BALANCE = "energy.balance"
HUGE = 1e300  # J; with this as its largest energy, the plant accepts any energy balance


def first_harmonic(values: Array) -> Array:
    """Return the constant, cosine and sine parts, shape (n, 3), of values given at `ANGLES`, shape (3, n)."""
    weights = np.array([np.full(3, 0.5), np.cos(ANGLES), np.sin(ANGLES)]) / 1.5
    result: Array = (weights @ values).T
    return result


class Response(NamedTuple):
    """A step: x' = A x + B u + f, y = C x + D u + g.

    matrix
        [[A, B], [C, D]], shape (n_x + n_y, n_x + n_u).
    forcing
        [f; g]: the constant part, and the parts with the cosine and the sine of the angle, shape (n_x + n_y, 3).
    """

    matrix: Array
    forcing: Array


class StateMap:
    """The state and values of a component as numbers in its memory; changes take effect when the memory is restored.

    Parameters
    ----------
    component
        The component, some steps after its start.
    interface
        Its interface.
    names
        Names of the variables that the master sends, and of those that it reads.
    positions
        Positions of these variables among the master's values.
    linear_state
        The FMU's `Fmu.linear_state`.
    """

    def __init__(
        self,
        component: FmuComponent,
        interface: FmuInterface,
        names: tuple[Sequence[str], Sequence[str]],
        positions: tuple[Indices, Indices],
        linear_state: Mapping[str, Any],
    ) -> None:
        self.component, self.interface = component, interface
        component.save()
        self.memory = component.memory()
        n_values = len(interface.ports)
        state = len(self.memory) - int(linear_state["size"])
        self._values = state - n_values - n_values % 2  # both begin at multiples of 16 bytes
        self._inputs, self._outputs = (
            self._values + np.array([interface.ports[name].position for name in group], np.intp) for group in names
        )
        self.sources, self.slot = positions
        rows = state + np.concatenate([np.arange(begin, end) for begin, end in linear_state["rows"]])
        self.moves = self.memory[rows] != 0.0  # states that are still zero never move
        self.rows = rows[self.moves]
        self.unless: tuple[str, ...] = tuple(linear_state["unless"])
        self._angle = None if linear_state["angle"] is None else state + int(linear_state["angle"])
        self.angle = None if self._angle is None else float(self.memory[self._angle])
        self._energy = [state + int(place) for place in linear_state["energy"] or ()]
        self._balance = self._values + interface.ports[BALANCE].position if self._energy else 0

    def value(self, position: int) -> float:
        """Return the value of a variable, by its position among all values."""
        return float(self.memory[self._values + position])

    def advance(self, time: float, step_size: float) -> float:
        """Return the increase of the angle per step (rad)."""
        growth = float(self.component.answer(time, step_size)[self._angle] - self.memory[self._angle])
        return growth % (2.0 * math.pi)

    def response(self, moving: Bools, turning: Bools, scales: Array, time: float, step_size: float) -> Response:
        """Find the response of a step from rest to each single state and input.

        Parameters
        ----------
        moving, turning
            Masks of the master's values: the signals that move linearly, and the angles.
        scales
            Magnitude of each value.
        time, step_size
            Time and size of the step (s).
        """
        fed = moving[self.sources]
        sizes = np.maximum(SHARE * scales[self.sources[fed]], CHANGE)
        changes = np.concatenate([np.full(len(self.rows), CHANGE), sizes])
        changed = np.concatenate([self.rows, self._inputs[fed]])
        observed = np.concatenate([self.rows, self._outputs[moving[self.slot]]])
        angles = [] if self._angle is None else [self._angle]
        turned = np.array([*self._inputs[turning[self.sources]], *angles], np.intp)
        touched = np.concatenate([changed, turned, np.array(self._energy[1:], np.intp)])
        before = self.memory[touched]
        self.memory[changed] = 0.0
        self.memory[self._energy[1:]] = HUGE
        at_angles = np.repeat(ANGLES[:, None], len(turned), axis=1)
        forced = self.component.answers(turned, at_angles, observed, time, step_size)
        self.memory[turned] = ANGLES[0]
        answers = self.component.answers(changed, np.diag(changes), observed, time, step_size)
        self.memory[touched] = before
        matrix = np.ascontiguousarray((answers - forced[0]).T / changes)
        return Response(matrix, first_harmonic(forced))

    def places_of(self, chosen: Bools) -> tuple[Indices, Indices]:
        """Return the memory indices of the `chosen` values of the master, and the positions of these values."""
        places, at = np.append(self._inputs, self._outputs), np.append(self.sources, self.slot)
        return places[chosen[at]], at[chosen[at]]

    def start(self, states: Array, places: Indices, values: Array, angle: float) -> None:
        """Set the states of the component, its angle (rad), and the `values` at the memory indices `places`."""
        self.memory[self.rows] = states
        self.memory[self._energy[1:]] = HUGE
        self.memory[places] = values
        if self._angle is not None:
            self.memory[self._angle] = angle
        self.component.restore()

    def balance_energy(self) -> None:
        """Restart the energy balance of the component, with any present deficit counted as initial energy."""
        if self._energy:
            start, largest = self._energy
            self.component.save()
            self.memory[start] += self.memory[self._balance]
            self.memory[largest] = 0.0
            self.component.restore()
