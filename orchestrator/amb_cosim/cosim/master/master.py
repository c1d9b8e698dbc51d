"""The master algorithm: explicit or iterative coupling on an integer time grid, without knowledge of FMI.

All signals are in a single flat array `values`: the exogenous inputs first, then the outputs of each component. Inputs
of components are gathered from it, and outputs are written to it. Communication points are t_n = t_0 + n h with integer
n; a component with `every = m` steps by m h at every m-th point.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from graphlib import CycleError, TopologicalSorter
from typing import Generic, Protocol, TypeVar

import numpy as np

from amb_cosim.cosim.choices import COUPLINGS, Coupling
from amb_cosim.cosim.errors import StartFailed, StepFailed
from amb_cosim.cosim.grid.schedules import Schedule
from amb_cosim.cosim.grid.time_grid import TimeGrid
from amb_cosim.cosim.master.iteration import MOST_REPETITIONS, Iteration, Unsettled
from amb_cosim.cosim.system.signal_map import SignalMap
from amb_files.checks import require_choice
from array_types import Array

Observer = Callable[[int, Array], None]


class Participant(Protocol):
    """The part of a component that the algorithm uses; only iterative coupling uses `save` and `restore`."""

    name: str
    every: int
    inputs: Array
    outputs: Array

    def enter(self, start_time: float) -> None: ...
    def leave(self) -> None: ...
    def write(self) -> None: ...
    def read(self) -> None: ...
    def step(self, time: float, step_size: float) -> None: ...
    def save(self) -> None: ...
    def restore(self) -> None: ...
    def close(self) -> None: ...


P = TypeVar("P", bound=Participant)


class Master(Generic[P]):
    """Steps components together, and frees them at the end.

    Parameters
    ----------
    components
        The components, in Gauss-Seidel order.
    wiring
        Sources of their inputs.
    step_size
        Communication step h in s.
    coupling
        `gauss_seidel`: each component reads the outputs of earlier components at the end of their steps. `jacobi`: all
        components read the outputs at the beginning of the step; a slower component's outputs appear after its step.
        `iterative`: steps are repeated until inputs agree with the outputs at the end of the step; see `iteration`.
    start_time
        t_0 in s, the time of communication point 0.
    values
        Array of zeros for the values; it is needed only if it is part of another array.
    end
        Last point and its time (s), if the step to this point is shorter than the others.
    last_steps
        For components whose last step is shorter, by component number: the point at which this step begins, and its
        size (s).

    As a context manager, it always closes all components on exit.
    """

    def __init__(
        self,
        components: Sequence[P],
        wiring: SignalMap,
        step_size: float,
        coupling: Coupling = "gauss_seidel",
        start_time: float = 0.0,
        values: Array | None = None,
        end: tuple[int, float] | None = None,
        last_steps: Mapping[int, tuple[int, float]] | None = None,
    ) -> None:
        require_choice("coupling", coupling, COUPLINGS)
        if not 0.0 < step_size < math.inf:
            raise ValueError(f"communication step = {step_size:g} s is not allowed; it must be > 0 s")
        self.components = list(components)
        self.wiring = wiring
        self.step_size = step_size
        self.coupling = coupling
        self.grid = TimeGrid(step_size, start_time, *(end or ()))
        self.last_steps = last_steps or {}
        self.values = np.zeros(len(wiring.names)) if values is None else values
        self._iteration = Iteration(self.components, wiring.sources, wiring.weights)
        self.exogenous = self.values[: wiring.n_exogenous]
        self.slots: list[slice] = []
        first = wiring.n_exogenous
        for component in self.components:
            self.slots.append(slice(first, first + len(component.outputs)))
            first += len(component.outputs)
        if first != len(self.values):
            raise ValueError(f"the wiring names {len(self.values)} signals, but the components have {first} outputs")

    def __enter__(self) -> Master[P]:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Terminate and free every component."""
        for component in self.components:
            component.close()

    def time(self, n: int) -> float:
        """Return the time t_0 + n h (s) of communication point n; it is not a sum of steps, which would add errors."""
        return self.grid.time(n)

    def step_size_of(self, i: int, n: int) -> float:
        """Return the size of the step (s) of component i from point n."""
        begin, size = self.last_steps.get(i, (math.inf, 0.0))
        return size if n >= begin else self.components[i].every * self.step_size

    def initialise(self, n: int = 0) -> None:
        """Initialise all components at point n, passing outputs along the connections until none changes.

        Outputs are read again after initialisation mode, because some FMUs compute them only when it ends. Outputs that
        have changed by then are passed along the connections once more, so that the values at point n are those from
        which the first step begins.

        Raises
        ------
        StartFailed
            If a component refuses, or if outputs still change after all connections have been passed; the message then
            names the loop.
        """
        for component in self.components:
            self._guarded_start(component, component.enter, self.time(n))
        sweeps = 1 + sum(len(sources) for sources in self.wiring.sources)
        for _ in range(sweeps + 1):
            before = self.values.copy()
            for i, component in enumerate(self.components):
                self._guarded_start(component, self._send_inputs, i)
                self._guarded_start(component, self._fetch_outputs, i)
            if np.array_equal(before, self.values, equal_nan=True):
                break
        else:
            raise StartFailed(self._describe_loop())
        for component in self.components:
            self._guarded_start(component, component.leave)
        for i, component in enumerate(self.components):
            self._guarded_start(component, self._fetch_outputs, i)
        self._pass_changes()

    def _pass_changes(self) -> None:
        """Send changed inputs and fetch outputs in step mode, in at most as many rounds as there are components."""
        for _ in self.components:
            changed = [i for i in range(len(self.components)) if self._has_other_inputs(i)]
            if not changed:
                return
            for i in changed:
                self._guarded_start(self.components[i], self._send_inputs, i)
                self._guarded_start(self.components[i], self._fetch_outputs, i)

    def _has_other_inputs(self, i: int) -> bool:
        """Return whether the sources of component i differ from its present inputs."""
        return not np.array_equal(self.values[self.wiring.sources[i]], self.components[i].inputs, equal_nan=True)

    def run(
        self,
        first: int,
        last: int,
        schedules: Sequence[Schedule] = (),
        observers: Sequence[Observer] = (),
        stop: int | None = None,
    ) -> None:
        """Advance from communication point `first` to `last`.

        At every point, including the last, schedules write the exogenous inputs; then observers are called with the
        values at this point. With `stop`, the run ends at the point `stop` before its schedules are applied, and can
        continue from that point.

        Raises
        ------
        StepFailed
            If a component does not complete a step. Observers have received everything before that step.
        """
        self.check_start(first)
        advance = {"gauss_seidel": self._gauss_seidel, "jacobi": self._jacobi, "iterative": self._iterative}[
            self.coupling
        ]
        for n in range(first, last + 1 if stop is None else stop):
            for schedule in schedules:
                schedule(n, self.exogenous)
            for observe in observers:
                observe(n, self.values)
            if n < last:
                advance(n)

    def complete(self, i: int, n: int, end: float) -> bool:
        """Complete the step from point n in which component i ended the run at `end` (s).

        Return whether all values then belong to the time `end`. This is false if component i does not step at every
        point. Otherwise, it is true if the system has no other component, or if `end` is the time of point n + 1 and
        the coupling is not iterative.
        """
        is_at_point = self.grid.is_at(n + 1, end) and self.coupling != "iterative"
        if self.components[i].every > 1 or not (is_at_point or len(self.components) == 1):
            return False
        try:
            if self.coupling != "jacobi":
                self._guarded(n, self.components[i], self._fetch_outputs, i)
            (self._jacobi if self.coupling == "jacobi" else self._gauss_seidel)(n, i + 1)
        except StepFailed as error:
            ends_as_well = error.end is not None and self.grid.is_at(n + 1, error.end)
            return ends_as_well and self.complete(self.position(error.component), n, end)
        return True

    def position(self, name: str) -> int:
        """Return the position of a component in the order of all components."""
        return [component.name for component in self.components].index(name)

    @property
    def scales(self) -> Array:
        """The largest magnitude of each input so far; iterative coupling measures changes relative to it."""
        return self._iteration.largest

    @scales.setter
    def scales(self, largest: Array) -> None:
        self._iteration.largest = largest

    def check_start(self, first: int) -> None:
        """Raise ValueError if a slower component cannot step at point `first`, or if its steps must be repeated."""
        for component in self.components:
            if component.every > 1 and self.coupling == "iterative":
                raise ValueError(
                    f"{component.name} steps only every {component.every} communication points; iterative coupling "
                    "requires a step at every point"
                )
            if first % component.every:
                raise ValueError(
                    f"{component.name} steps only every {component.every} communication points and cannot start at "
                    f"point {first}"
                )

    def _gauss_seidel(self, n: int, first: int = 0) -> None:
        """Step from point n, starting with component `first`."""
        for i, component in enumerate(self.components):
            if i >= first and n % component.every == 0:
                self._guarded(n, component, self._send_inputs, i)
                self._guarded(n, component, self._step, i, n)
                self._guarded(n, component, self._fetch_outputs, i)

    def _jacobi(self, n: int, first: int = 0) -> None:
        """Step from point n; if `first` > 0, inputs have been sent, and the components before `first` have stepped."""
        due = [(i, c) for i, c in enumerate(self.components) if n % c.every == 0]
        for i, component in due if first == 0 else ():
            self._guarded(n, component, self._send_inputs, i)
        for i, component in due:
            if i >= first:
                self._guarded(n, component, self._step, i, n)
        for i, component in enumerate(self.components):
            if (n + 1) % component.every == 0:
                self._guarded(n, component, self._fetch_outputs, i)

    def _iterative(self, n: int) -> None:
        def advance(i: int) -> None:
            component = self.components[i]
            self._guarded(n, component, component.write)
            self._guarded(n, component, self._step, i, n)
            self._guarded(n, component, self._fetch_outputs, i)

        try:
            self._iteration.step(self.values, advance)
        except Unsettled as error:
            name, source = self.components[error.component].name, self.wiring.names[error.source]
            reason = f"its input from {source} still changes after {MOST_REPETITIONS} repetitions of the step"
            raise StepFailed(name, self.time(n), f"{reason}; a shorter communication step helps") from error

    @staticmethod
    def _guarded_start(component: Participant, action: Callable[..., None], *arguments: float) -> None:
        try:
            action(*arguments)
        except Exception as error:
            raise StartFailed(f"{component.name}: {error}") from error

    def _guarded(self, n: int, component: Participant, action: Callable[..., None], *arguments: int) -> None:
        try:
            action(*arguments)
        except Exception as error:
            raise self.failure(component, n, error) from error

    def failure(self, component: Participant, n: int, error: Exception) -> StepFailed:
        """Return the error for a component whose step from point n raised `error`; it names any input that is NaN."""
        sources = self.wiring.sources[self.position(component.name)]
        nan = [self.wiring.names[position] for position in sources if math.isnan(self.values[position])]
        return StepFailed.by(component.name, self.time(n), error, f"; its input from {nan[0]} is nan" if nan else "")

    def _send_inputs(self, i: int) -> None:
        component = self.components[i]
        np.take(self.values, self.wiring.sources[i], out=component.inputs)
        component.write()

    def _step(self, i: int, n: int) -> None:
        component = self.components[i]
        component.step(self.time(n), self.step_size_of(i, n))

    def _fetch_outputs(self, i: int) -> None:
        component = self.components[i]
        component.read()
        self.values[self.slots[i]] = component.outputs

    def _describe_loop(self) -> str:
        loop = find_loop(self.wiring.depends_on)
        if not loop:
            return "outputs do not settle during initialisation, although no loop is declared"
        path = " -> ".join(self.wiring.names[i] for i in loop)
        return f"outputs do not settle during initialisation; the algebraic loop is {path}"


def find_loop(depends_on: Sequence[Sequence[int]]) -> list[int]:
    """Return the positions of the signals on a closed path, with the first one repeated at the end; empty if none."""
    try:
        TopologicalSorter(dict(enumerate(depends_on))).prepare()
    except CycleError as error:
        return list(error.args[1])
    return []
