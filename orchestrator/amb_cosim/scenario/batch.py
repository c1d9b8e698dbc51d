"""Many members of one scenario, stepped side by side: values in and out as arrays with an element for each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from amb_cosim.cosim.assembly import Assembly
from amb_cosim.cosim.choices import Flavour
from amb_cosim.cosim.members import Members, States
from amb_cosim.cosim.schedules import Array
from amb_cosim.cosim.values import Raw
from amb_cosim.scenario.plan import ScenarioPlan
from amb_cosim.scenario.scenario import Scenario, given_scenario
from amb_cosim.scenario.simulation import assemble_scenario, plan_prepared
from amb_files.suggestions import suggest

Mask = NDArray[np.bool_] | Sequence[bool] | None


class Batch:
    """Members of a scenario, which begin at cycle 0, settled.

    A member has the bits of a run alone: the scenario's events come at their points, and what `set` writes holds until
    an event writes it. After the end of the scenario members go on without events; conditions that end a run are
    not judged.

    Parameters
    ----------
    scenario, rotor, receptances, flavour
        As for `amb_cosim.run`.
    n
        Number of members.
    set
        Values by name as for `amb_cosim.run`, one for all members or a sequence of n.
    inputs
        Names of inputs and tunable parameters that `Batch.set` writes, besides those that the scenario gives; patterns
        too.
    variables
        Patterns of what `get` reads, by default what the scenario records.
    threads
        That step members; one a processor by default. They change no bit.

    Raises
    ------
    ValueError
        If anything in it does not fit, or the FMUs cannot save their state.
    StartFailed, FmuError, StepFailed
        If an FMU cannot be loaded, refuses to start, or fails before cycle 0.
    """

    def __init__(
        self,
        scenario: str | Path | Scenario,
        n: int,
        *,
        set: Mapping[str, Raw | Sequence[Raw] | NDArray[Any]] | None = None,
        inputs: Sequence[str] = (),
        variables: Sequence[str] | None = None,
        rotor: str | Path | None = None,
        receptances: str | Path | None = None,
        flavour: Flavour = "native",
        threads: int | None = None,
    ) -> None:
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
        self._members = Members(assembly, plans, scenario.coupling, threads)
        self._at = {name: k for k, name in enumerate(self._members.names)}

    def __len__(self) -> int:
        return len(self._plans)

    @property
    def names(self) -> list[str]:
        """Names that `get` reads."""
        return list(self._at)

    @property
    def inputs(self) -> list[str]:
        """Names that `set` writes."""
        return list(self._plans[0].inputs)

    @property
    def step_size(self) -> float:
        """Communication step (s)."""
        return self._plans[0].step_size

    @property
    def time(self) -> Array:
        """Time of each member (s), shape (n,); what happens then has not happened yet."""
        return np.asarray(self._members.points * self.step_size, np.float64)

    @property
    def failed(self) -> NDArray[np.bool_]:
        """Which members did not complete a step, shape (n,); they rest until they are reset."""
        return self._members.failed

    def reason(self, member: int) -> str:
        """Return why a member failed; empty where it did not."""
        return self._members.reason(member)

    def get(self, name: str) -> Array:
        """Return the values of a variable, shape (n,): a live view of what the members work with, not a copy."""
        if name not in self._at:
            raise ValueError(f"the batch has no variable {name!r}; {suggest(name, list(self._at))}")
        return self._members.values[:, self._at[name]]

    def set(self, name: str, values: ArrayLike, mask: Mask = None) -> None:
        """Give an input a value for all members, or those of a mask, from the next step on.

        Raises
        ------
        ValueError
            If there is no such input, or a value is not allowed.
        """
        if name not in self._plans[0].inputs:
            raise ValueError(
                f"the batch has no input {name!r}; {suggest(name, self.inputs)}; argument inputs adds some"
            )
        given = np.broadcast_to(np.asarray(values, np.float64), (len(self),))
        chosen = np.ones(len(self), np.bool_) if mask is None else np.asarray(mask, np.bool_)
        port = self._assembly.assignments().port(name)
        wrong = given[chosen & ~((given >= port.minimum) & (given <= port.maximum) & np.isfinite(given))]
        if len(wrong):
            raise ValueError(f"{name} = {wrong[0]:.9g}{port.shown_unit} is not allowed; it must be {port.allowed()}")
        np.copyto(self.get(name), given, where=chosen)

    def step(self, k: int = 1) -> None:
        """Step all members that have not failed by k communication steps; `failed` tells which failed."""
        if k < 1:
            raise ValueError(f"{k} steps are not allowed; it must be 1 or more")
        self._members.step(k)

    def reset(self, mask: Mask = None) -> None:
        """Bring all members, or those of a mask, back to cycle 0."""
        self.restore(self._members.start, mask)

    def save(self) -> States:
        """Return the states of all members, which `restore` takes, until the batch is closed."""
        return self._members.save()

    def restore(self, states: States, mask: Mask = None) -> None:
        """Bring all members, or those of a mask, back to states that `save` returned."""
        chosen = range(len(self)) if mask is None else np.flatnonzero(np.asarray(mask, np.bool_)).tolist()
        self._members.restore(states, chosen)

    def close(self) -> None:
        """Free the FMUs."""
        self._members.close()

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
