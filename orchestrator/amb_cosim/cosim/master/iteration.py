"""Iterative coupling: a step is repeated from saved states until inputs and outputs of all components agree.

A component holds its inputs u over a step from t to t + h. The weight w of a source y defines the value of an input for
the step, u = (1 - w) y(t) + w y(t + h):

    w = 1/2   y follows from states; this is the trapezoidal rule, of second order in h
    w = 1     y depends directly on inputs of the same step, so y(t + h) already is the value for the step
    w = 0     the component samples y at the beginning of the step, or y is an integer or a Boolean

y(t + h) is known only after the step. All components first step with the values at t, in Gauss-Seidel order. Then the
components whose inputs have changed step again from their states at t, until no input changes by more than `TOLERANCE`
of its largest value so far. Each repetition multiplies the error by the loop gain over a step; this gain vanishes with
h. If inputs still change after `MOST_REPETITIONS`, the step fails.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Protocol

import numpy as np

from array_types import Array, Indices

TOLERANCE = 1e-10
MOST_REPETITIONS = 30


class Repeatable(Protocol):
    """The methods and data of a component that repetitions of steps use."""

    inputs: Array

    def save(self) -> None: ...
    def restore(self) -> None: ...


class Unsettled(RuntimeError):
    """An input of component number `component` still changes; `source` is the position of the input's source."""

    def __init__(self, component: int, source: int) -> None:
        super().__init__()
        self.component = component
        self.source = source


class Iteration:
    """Steps of components in iterative coupling.

    Parameters
    ----------
    components
        The components, in the order in which a repetition steps them.
    sources, weights
        For each component, the positions of its inputs' sources in the value array, and their weights w.
    """

    def __init__(self, components: Sequence[Repeatable], sources: Sequence[Indices], weights: Sequence[Array]) -> None:
        self.components = components
        self.sources = sources
        self.weights = weights
        self._largest = [np.zeros(len(positions)) for positions in sources]

    @property
    def largest(self) -> Array:
        """The largest magnitude of each input so far, component by component."""
        return np.concatenate([np.zeros(0), *self._largest])

    @largest.setter
    def largest(self, largest: Array) -> None:
        ends = np.cumsum([len(group) for group in self._largest])
        self._largest = [part.copy() for part in np.split(largest, ends[:-1])]

    def step(self, values: Array, advance: Callable[[int], None]) -> None:
        """Carry out a communication step.

        Parameters
        ----------
        values
            The value array; it contains the values at the beginning of the step when called, and at the end on return.
        advance
            Function that sends component i its inputs, steps it, and writes its outputs to `values`.

        Raises
        ------
        Unsettled
            If inputs still change after `MOST_REPETITIONS`.
        """
        before = values.copy()
        for i, component in enumerate(self.components):
            component.save()
            self._gather(i, before, values)
            advance(i)
        for _ in range(MOST_REPETITIONS):
            changed = [i for i in range(len(self.components)) if self._repeat(i, before, values, advance)]
            if not changed:
                return
        i = changed[0]
        change = self._change(i, before, values)
        raise Unsettled(i, int(self.sources[i][int(np.argmax(change))]))

    def _repeat(self, i: int, before: Array, values: Array, advance: Callable[[int], None]) -> bool:
        """Step component i again if its inputs have changed, and return whether they have."""
        if not np.any(self._change(i, before, values) > TOLERANCE):
            return False
        self.components[i].restore()
        self._gather(i, before, values)
        advance(i)
        return True

    def _between(self, i: int, before: Array, values: Array) -> Array:
        at = self.sources[i]
        return before[at] + self.weights[i] * (values[at] - before[at])

    def _gather(self, i: int, before: Array, values: Array) -> None:
        self.components[i].inputs[:] = self._between(i, before, values)
        np.maximum(self._largest[i], np.abs(self.components[i].inputs), out=self._largest[i])

    def _change(self, i: int, before: Array, values: Array) -> Array:
        """Return the change of each input of component i since its last step, relative to its largest magnitude."""
        change = np.abs(self._between(i, before, values) - self.components[i].inputs)
        return np.divide(
            change, self._largest[i], out=np.where(change > 0.0, np.inf, 0.0), where=self._largest[i] > 0.0
        )
