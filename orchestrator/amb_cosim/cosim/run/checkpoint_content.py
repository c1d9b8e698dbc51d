"""Checks of the content of a checkpoint against the run that continues from it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from amb_cosim.cosim.fmu.component import FmuComponent
from amb_cosim.cosim.master.master import Master
from amb_cosim.cosim.record.step_rows import complete_rows
from amb_cosim.cosim.run.checkpoint import Checkpoint
from amb_cosim.cosim.system.experiment import Plan
from array_types import Array


def check_parts(start: Checkpoint, plan: Plan, master: Master[FmuComponent]) -> None:
    """Raise ValueError if parts of a checkpoint are inconsistent with the run that its past describes."""
    if (start.step_size, start.start_time) != (plan.step_size, plan.start_time):
        raise ValueError(
            f"{start.title} has steps of {start.step_size:g} s that begin at {start.start_time:g} s; this run has "
            f"steps of {plan.step_size:g} s that begin at {plan.start_time:g} s"
        )
    for part, names in (("states", start.states), ("warnings", start.warnings)):
        if missing := sorted({component.name for component in master.components} - names.keys()):
            raise ValueError(f"{start.title} has no {part} of {missing[0]}")
    if unknown := sorted({*master.wiring.names} - start.signals.keys() - plan.inputs.keys()):
        raise ValueError(f"{start.title} has no value of {unknown[0]}")
    due = np.arange(plan.first_recorded, start.point)
    rows = complete_rows(plan.first_recorded, start.point, start.steps_in_row)
    has_steps = not start.recorded_each or (len(start.steps), len(start.rest)) == rows
    if not has_steps or not np.array_equal(start.points, due[due % plan.record_every == 0]):
        raise ValueError(f"{start.title} has a different record; it must contain all points before the checkpoint")
    n, inputs = len(start.scales), len(master.scales) if master.coupling == "iterative" else 0
    if n != inputs:
        raise ValueError(f"{start.title} has the scales of {n} inputs, but {master.coupling} coupling needs {inputs}")


def check_numbers(start: Checkpoint, plan: Plan) -> None:
    """Raise ValueError if a checkpoint contains NaN from an FMU of this project, whose outputs are never NaN."""
    signals = np.array([[*start.signals.values()]])
    for names, rows in (
        (start.recorded, start.table),
        (start.recorded_each, start.steps),
        (start.recorded_each, start.rest),
        (tuple(start.signals), signals),
    ):
        for column in np.flatnonzero(np.isnan(rows).any(axis=0)):
            if plan.system.divide(names[column])[0] not in plan.assembly.from_elsewhere:
                raise ValueError(
                    f"{start.title} has {names[column]} = nan, which no run writes, so the file is damaged"
                )


def columns_of(start: Checkpoint, recorded: Sequence[str], table: Array, names: Sequence[str], plan: Plan) -> Array:
    """Return the record of a checkpoint, with the columns of a plan's record.

    For an input that only the resumed run changes, the rows up to the checkpoint contain its initial value.
    """
    columns = dict(zip(recorded, table.T, strict=True))
    missing = [name for name in names if name not in columns and name not in plan.inputs]
    if missing:
        raise ValueError(f"{start.title} has no record of {missing[0]}; it must be recorded up to the checkpoint")
    record = np.empty((len(table), len(names)))
    for k, name in enumerate(names):
        record[:, k] = columns[name] if name in columns else plan.inputs[name]
    return record
