"""A batch of copies (members) of one scenario, stepped side by side; values are arrays with one element per member."""

from __future__ import annotations

import operator
import threading
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from types import TracebackType
from typing import Any, NoReturn

import numpy as np
from numpy.typing import ArrayLike, NDArray

from amb_cosim.cosim.basics.choices import Flavour
from amb_cosim.cosim.run.batch_runner import BatchRunner, States
from amb_cosim.cosim.system.assembly import Assembly
from amb_cosim.cosim.system.values import Raw
from amb_cosim.scenario.plan import ScenarioPlan
from amb_cosim.scenario.rotors import RotorSource
from amb_cosim.scenario.scenario import Scenario, given_scenario
from amb_cosim.scenario.simulation import assemble_scenario, plan_prepared
from amb_files.suggestions import suggest
from array_types import Array, Bools

Mask = Bools | Sequence[bool] | None

MOST_STEPS = 2**31 - 1  # of one call


class _OpenLock:
    """A lock of a batch that is open; `with` raises ValueError once it is closed."""

    def __init__(self) -> None:
        self.lock, self.is_closed = threading.RLock(), False

    def __enter__(self) -> None:
        self.lock.acquire()
        if self.is_closed:
            self.lock.release()
            raise ValueError("the batch is closed; make another one")

    def __exit__(self, *_: object) -> None:
        self.lock.release()


class Batch:
    """A batch of copies (members) of one scenario, settled at cycle 0.

    Each member has the same bits as a single run: the scenario's events occur at their points, and values from `set`
    hold until an event overwrites them. After the end of the scenario members continue without events; stop conditions
    are not checked. Threads may share a batch: its methods run one at a time.

    Parameters
    ----------
    scenario, rotor, receptances, flavour
        As for `amb_cosim.run`.
    n
        Number of members.
    set
        Values by name as for `amb_cosim.run`, one for all members or a sequence of n.
    inputs
        Names or patterns of further inputs and tunable parameters for `Batch.set`, in addition to those of the
        scenario.
    variables
        Patterns of variables for `get`; default: those that the scenario records.
    threads
        Number of threads; one per processor by default. Results do not depend on it.

    Raises
    ------
    ValueError
        If an argument is invalid, or the FMUs cannot save their state.
    StartFailed, FmuError, StepFailed
        If an FMU cannot be loaded, refuses to start, or fails before cycle 0.

    Examples
    --------
    >>> batch = Batch("compressor_levitated", 2, set={"rotor_contact.impeller3.u": ["0.5 g.m", "1 g.m"]})
    >>> batch.step(20)
    >>> time, unbalance = batch.time, batch.get("rotor_contact.impeller3.u")
    >>> [f"{1e3 * u:.1f} g m after {1e3 * t:.1f} ms" for u, t in zip(unbalance, time)]
    ['0.5 g m after 2.0 ms', '1.0 g m after 2.0 ms']
    """

    def __init__(
        self,
        scenario: str | Path | Scenario,
        n: int,
        *,
        set: Mapping[str, Raw | Sequence[Raw] | NDArray[Any]] | None = None,
        inputs: Sequence[str] = (),
        variables: Sequence[str] | None = None,
        rotor: RotorSource = None,
        receptances: str | Path | None = None,
        flavour: Flavour = "native",
        threads: int | None = None,
    ) -> None:
        self._open = _OpenLock()
        if n < 1 or (threads is not None and threads < 1):
            raise ValueError(f"a batch of {n} members in {threads} threads is not allowed; it must be 1 or more")
        scenario = given_scenario(scenario, rotor, receptances)
        assembly = assemble_scenario(scenario, flavour)
        planned: dict[str, ScenarioPlan] = {}  # members alike have one plan
        plans = []
        for settings in _settings(set or {}, n):
            key = repr(sorted(settings.items()))
            if key not in planned:
                plan = plan_prepared(scenario, assembly, settings, None, variables).plan
                planned[key] = _with_inputs(plan, assembly, inputs)
            plans.append(planned[key])
        self._assembly, self._plans = assembly, plans
        self._members = BatchRunner(assembly, plans, threads)
        self._at = {name: k for k, name in enumerate(self._members.names)}

    def __len__(self) -> int:
        return len(self._plans)

    @property
    def names(self) -> list[str]:
        """Names of variables for `get`."""
        return list(self._at)

    @property
    def inputs(self) -> list[str]:
        """Names of inputs for `set`."""
        return list(self._plans[0].inputs)

    @property
    def step_size(self) -> float:
        """Communication step (s)."""
        return self._plans[0].step_size

    @property
    def time(self) -> Array:
        """Time of each member (s), shape (n,); events at that time are still to come."""
        with self._open:
            return np.asarray(self._members.points * self.step_size, np.float64)

    @property
    def failed(self) -> Bools:
        """Which members failed to complete a step, shape (n,); they stop until they are reset."""
        with self._open:
            return self._members.failed

    def reason(self, member: int) -> str:
        """Return the cause of a member's failure; empty if it did not fail."""
        with self._open:
            return self._members.reason(member)

    def get(self, name: str) -> Array:
        """Return the values of a variable, shape (n,): a live view of the members' values, not a copy."""
        if name not in self._at:
            raise ValueError(f"the batch has no variable {name!r}; {suggest(name, list(self._at))}")
        with self._open:
            return self._members.values[:, self._at[name]]

    def set(self, name: str, values: ArrayLike, mask: Mask = None) -> None:
        """Set an input for all members, or those of a mask, from the next step on.

        Raises
        ------
        ValueError
            If there is no such input, or a value is not allowed.
        """
        if name not in self._plans[0].inputs:
            raise ValueError(
                f"the batch has no input {name!r}; {suggest(name, self.inputs)}; argument inputs adds some"
            )
        settings, chosen = self._column(name, values), self._chosen(mask)
        port = self._assembly.assignments().port(name)
        wrong = settings[chosen & ~((settings >= port.minimum) & (settings <= port.maximum) & np.isfinite(settings))]
        if len(wrong):
            raise ValueError(f"{name} = {wrong[0]:.9g}{port.display_unit} is not allowed; it must be {port.allowed()}")
        with self._open:
            np.copyto(self.get(name), settings, where=chosen)

    def step(self, k: int = 1) -> None:
        """Step all members that have not failed by k communication steps; see `failed` afterwards.

        Raises
        ------
        ValueError
            If k is not a whole number from 1 to 2**31 - 1.
        KeyboardInterrupt
            If Ctrl-C was pressed; all members are then at the same, earlier point.
        """
        try:
            steps = operator.index(k)
        except TypeError:
            steps = 0
        if not 1 <= steps <= MOST_STEPS:
            raise ValueError(f"{k!r} steps are not allowed; it must be a whole number from 1 to {MOST_STEPS}")
        with self._open:
            self._members.step(steps)

    def reset(self, mask: Mask = None) -> None:
        """Reset all members, or those of a mask, to cycle 0."""
        self.restore(self._members.start, mask)

    def save(self) -> States:
        """Return the states of all members, for `restore`; deleting the object frees them."""
        with self._open:
            return self._members.save()

    def restore(self, states: States, mask: Mask = None) -> None:
        """Restore states from `save` in all members, or those of a mask."""
        chosen = np.flatnonzero(self._chosen(mask)).tolist()
        with self._open:
            self._members.restore(states, chosen)

    def close(self) -> None:
        """Free the FMUs, once a step in another thread has ended."""
        with self._open.lock:
            self._open.is_closed = True
            self._members.close()

    def _chosen(self, mask: Mask) -> Bools:
        """Return the members that a mask selects, shape (n,)."""
        chosen = np.ones(len(self), np.bool_) if mask is None else np.asarray(mask)
        if chosen.dtype != np.bool_ or chosen.shape != (len(self),):
            what = f"a mask of type {chosen.dtype} and shape {chosen.shape}"
            raise ValueError(f"{what} is not allowed; it must have {len(self)} elements, each True or False")
        return chosen

    def _column(self, name: str, values: ArrayLike) -> Array:
        """Return values for all members, shape (n,)."""
        try:
            settings = np.asarray(values, np.float64)
        except (TypeError, ValueError):
            settings = np.zeros((0, 0))
        if settings.shape not in ((), (len(self),)):
            raise ValueError(f"{name} takes a number, or a number for each of {len(self)} members")
        return np.broadcast_to(settings, (len(self),))

    def __reduce__(self) -> NoReturn:
        raise TypeError("a batch cannot be pickled, since its FMUs live in this process; make one in each process")

    def __enter__(self) -> Batch:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def _settings(given: Mapping[str, Raw | Sequence[Raw] | NDArray[Any]], n: int) -> list[dict[str, Raw]]:
    """Return the values of each member; raises ValueError for a sequence that has not n."""
    columns: dict[str, Sequence[Any]] = {}
    for name, value in given.items():
        column = [value] * n if isinstance(value, bool | int | float | str) else list(np.asarray(value).tolist())
        if len(column) != n:
            raise ValueError(f"{name} has {len(column)} values; it must have one, or one for each of {n} members")
        columns[name] = column
    return [{name: column[i] for name, column in columns.items()} for i in range(n)]


def _with_inputs(plan: ScenarioPlan, assembly: Assembly, inputs: Sequence[str]) -> ScenarioPlan:
    """Return a plan with further inputs, at the values that they have without."""
    values = assembly.assignments()
    values.parameters = {component: dict(of_one) for component, of_one in plan.parameters.items()}
    added = dict(plan.inputs)
    for pattern in inputs:
        for name in values.matching(pattern):
            start = values.start_value(name)
            added.setdefault(values.read_change(name, start)[0], start)
    return replace(plan, inputs=added)
