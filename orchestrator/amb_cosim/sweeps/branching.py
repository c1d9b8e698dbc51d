"""Points of a sweep that are alike until an event share what comes before it: its state is restored, not run again.

A run leaves its state before each event that the sweep varies, in the memory of the FMUs. A later point goes on from
the last of these states whose past is its own, to the last bit as if it had run alone. So points are run in an order in
which what is varied before an event changes last, and the moments of an event ascend.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from amb_cosim.cosim.master.instances import InstancePool
from amb_cosim.cosim.run.checkpoint import Checkpoint
from amb_cosim.cosim.run.saving import Saves
from amb_cosim.cosim.run.state_fingerprint import plan_past
from amb_cosim.cosim.system.assembly import Assembly
from amb_cosim.cosim.system.values import Raw
from amb_cosim.scenario.plan import ScenarioPlan
from amb_cosim.sweeps.axes import Axis
from amb_cosim.sweeps.sampling import SamplePlan


class Branches:
    """States that later points may go on from, the latest before each event that varies.

    Parameters
    ----------
    assembly, instances
        The FMUs, and the living ones, whose memory holds the states.
    labels
        Events that the sweep varies.
    """

    def __init__(self, assembly: Assembly, instances: InstancePool, labels: Sequence[str]) -> None:
        self._assembly, self._instances = assembly, instances
        able = all(interface.saves_state for interface in assembly.interfaces.values())
        self._labels = tuple(labels) if able else ()
        self._kept: dict[str, tuple[ScenarioPlan, Checkpoint]] = {}
        self._generation = instances.generation

    def start_of(self, plan: ScenarioPlan) -> Checkpoint | None:
        """Return the latest state that a run of a plan can go on from, if there is one."""
        if self._generation != self._instances.generation:
            self._kept.clear()  # the FMUs whose memory held them are gone
        usable = [state for before, state in self._kept.values() if self._is_shared(before, plan, state.point)]
        return max(usable, key=lambda state: state.point, default=None)

    def saves_of(self, plan: ScenarioPlan, start: Checkpoint | None) -> Saves:
        """Return which states a run of a plan leaves."""
        begin = plan.begin if start is None else start.point + 1
        marks = (plan.marks[label] for label in self._labels if label in plan.marks)
        return Saves(tuple(n for n in marks if begin <= n <= plan.last), held=True)

    def keep(self, plan: ScenarioPlan, states: Mapping[int, Checkpoint]) -> None:
        """Keep the states that a run of a plan left, by their points, each in place of the one for the same event."""
        for label in self._labels:
            state = states.get(plan.marks.get(label, -1))
            if state is not None:
                if label in self._kept:
                    self._instances.forget(self._kept[label][1].states)
                self._kept[label] = plan, state
        self._generation = self._instances.generation

    def _is_shared(self, before: ScenarioPlan, plan: ScenarioPlan, n: int) -> bool:
        """Return whether a plan has the past of another of the same FMUs at point n."""
        return (
            n <= plan.last
            and before.parameters == plan.parameters
            and before.recorded == plan.recorded
            and before.system.components == plan.system.components
            and plan_past(self._assembly, before, n) == plan_past(self._assembly, plan, n)
        )


def varied_labels(design: SamplePlan, labels: Sequence[str]) -> tuple[str, ...]:
    """Return which of these labels of events, in the order in which they come, a design varies."""
    result = {_label_of(axis, labels) for axis in design.axes}
    return tuple(label for label in labels if label in result)


def branching_order(design: SamplePlan, points: Sequence[int], labels: Sequence[str]) -> list[int]:
    """Return points in an order in which those that share what comes before an event of `labels` follow each other."""
    import numpy as np

    def key(point: int) -> tuple[Any, ...]:
        index = np.unravel_index(point, design.shape)
        places = [(axis, int(k)) for axis, k in zip(design.axes, index, strict=True)]
        before = tuple(k for axis, k in places if _label_of(axis, labels) is None)
        of_events = []
        for label in labels:
            of_one = [(axis, k) for axis, k in places if _label_of(axis, labels) == label]
            of_events.append(tuple(sorted((_moment(axis, k, label), k) for axis, k in of_one)))
        return before, *of_events

    return sorted(points, key=key) if labels else list(points)


def _label_of(axis: Axis, labels: Sequence[str]) -> str | None:
    """Return the first event that what an axis sets belongs to; None where some of it belongs to none."""
    names = [name for setting in axis.alternatives for name in setting] or [column.name for column in axis.columns]
    heads = {name.partition(".")[0] for name in names}
    return next((label for label in labels if label in heads), None) if heads <= set(labels) else None


def _moment(axis: Axis, k: int, label: str) -> float:
    """Return by what the moment of an event is put in order; 0 where the axis leaves it as it is."""
    values: Mapping[str, Raw] = axis.settings(k)
    moments = (values.get(f"{label}.{name}") for name in ("cycle", "time"))
    numbers = [float(str(raw).split()[0]) for raw in moments if raw is not None]
    return numbers[0] if numbers else 0.0
