"""Points of a sweep that do not differ before an event share the run up to it; its end state is saved and restored.

Before each event that the sweep varies, a run saves its state in the memory of the FMUs. A later point continues from
the latest saved state with the same past; its results are bitwise equal to those of a complete run. Points are ordered
so that variations with an early effect change least often, and the moments of each event ascend.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from amb_cosim.cosim.master.instances import InstancePool
from amb_cosim.cosim.run.checkpoint import Checkpoint
from amb_cosim.cosim.run.options import Saves
from amb_cosim.cosim.run.state_fingerprint import plan_past
from amb_cosim.cosim.system.assembly import Assembly
from amb_cosim.cosim.system.experiment import Plan
from amb_cosim.cosim.system.values import Raw
from amb_sweeps.axes import Axis
from amb_sweeps.sampling import SamplePlan


class Branches:
    """States from which later points can continue: the latest state before each varied event.

    Parameters
    ----------
    assembly, instances
        The FMUs, and their instances, whose memory holds the states.
    labels
        Events that the sweep varies.
    """

    def __init__(self, assembly: Assembly, instances: InstancePool, labels: Sequence[str]) -> None:
        self._instances = instances
        can_save = all(interface.saves_state for interface in assembly.interfaces.values())
        self._labels = tuple(labels) if can_save else ()
        self._plans: dict[str, tuple[Plan, Checkpoint]] = {}
        self._generation = instances.generation

    def start_of(self, plan: Plan) -> Checkpoint | None:
        """Return the latest state from which the run of a plan can continue, if any."""
        if self._generation != self._instances.generation:
            self._plans.clear()  # the FMUs whose memory held the states are gone
        usable = [state for earlier, state in self._plans.values() if self._is_shared(earlier, plan, state.point)]
        return max(usable, key=lambda state: state.point, default=None)

    def saves_of(self, plan: Plan, start: Checkpoint | None) -> Saves:
        """Return the communication points at which a run of a plan saves its state."""
        begin = plan.begin if start is None else start.point + 1
        marks = (plan.marks[label] for label in self._labels if label in plan.marks)
        return Saves(tuple(n for n in marks if begin <= n <= plan.last), held=True)

    def keep(self, plan: Plan, states: Mapping[int, Checkpoint]) -> None:
        """Store the states that a run of a plan saved; each replaces the earlier state of its event."""
        for label in self._labels:
            state = states.get(plan.marks.get(label, -1))
            if state is not None:
                if label in self._plans:
                    self._instances.forget(self._plans[label][1].states)
                self._plans[label] = plan, state
        self._generation = self._instances.generation

    def _is_shared(self, earlier: Plan, plan: Plan, n: int) -> bool:
        """Return whether a plan and an earlier plan of the same FMUs are identical up to communication point n."""
        return (
            n <= plan.last
            and earlier.parameters == plan.parameters
            and earlier.recorded == plan.recorded
            and earlier.system.components == plan.system.components
            and earlier.system.coupling == plan.system.coupling
            and plan_past(earlier, n) == plan_past(plan, n)
        )


def varied_labels(design: SamplePlan, labels: Sequence[str]) -> tuple[str, ...]:
    """Return the event labels that a design varies; they keep the order of `labels`, which is the order in time."""
    varied = {_label_of(axis, labels) for axis in design.axes}
    return tuple(label for label in labels if label in varied)


def branching_order(design: SamplePlan, points: Sequence[int], labels: Sequence[str]) -> list[int]:
    """Return points in an order that keeps points with the same past before an event of `labels` together."""
    import numpy as np

    def key(point: int) -> tuple[Any, ...]:
        index = np.unravel_index(point, design.shape)
        places = [(axis, int(k)) for axis, k in zip(design.axes, index, strict=True)]
        without_event = tuple(k for axis, k in places if _label_of(axis, labels) is None)
        by_event = []
        for label in labels:
            of_label = [(axis, k) for axis, k in places if _label_of(axis, labels) == label]
            by_event.append(tuple(sorted((_moment(axis, k, label), k) for axis, k in of_label)))
        return without_event, *by_event

    return sorted(points, key=key) if labels else list(points)


def _label_of(axis: Axis, labels: Sequence[str]) -> str | None:
    """Return the first event to which the settings of an axis belong, or None if a setting belongs to no event."""
    names = [name for setting in axis.alternatives for name in setting] or [column.name for column in axis.columns]
    heads = {name.partition(".")[0] for name in names}
    return next((label for label in labels if label in heads), None) if heads <= set(labels) else None


def _moment(axis: Axis, k: int, label: str) -> float:
    """Return the sort key for the moment of an event; 0 if the axis does not change it."""
    values: Mapping[str, Raw] = axis.settings(k)
    moments = (values.get(f"{label}.{name}") for name in ("cycle", "time"))
    numbers = [float(str(raw).split()[0]) for raw in moments if raw is not None]
    return numbers[0] if numbers else 0.0
