"""The part of a thinned record from which extremes and frequencies follow, and what its samples do not show."""

from __future__ import annotations

import numpy as np

from amb_cosim.cosim.record.signals import Signals
from amb_cosim.results.component_names import PLANT
from amb_cosim.results.places import places
from amb_cosim.results.signal_arrays import at_every_step, thinning
from array_types import Array

SHORTER = 1e-6  # relative difference of a step that is shorter, not rounded


def judged(dataset: Signals) -> Signals:
    """Return the values of a thinned record at every step if they include the motion at the bearings, else the record.

    Extremes and frequencies are to be computed from this record. A record of an earlier version has contact at every
    step, but displacements only at its samples.
    """
    steps = at_every_step(dataset)
    if steps is dataset:
        return dataset
    motion = (f"{PLANT}.{bearing}.{axis}" for bearing in places(dataset).bearings for axis in "xy")
    return steps if all(name in steps for name in motion if name in dataset) else dataset


def folding(dataset: Signals) -> str:
    """Return a clause on what a thinned record does not show; empty for a record of every step.

    Without a filter before them, samples that are h apart are the same for the frequencies f and f - k/h, k = 1, 2, ...
    A vibration above 1/(2 h) thus appears below this frequency, possibly with the opposite direction of whirl.
    """
    every = thinning(dataset)
    if every == 1:
        return ""
    h = every * float(dataset.attrs["communication_step_s"])
    return (
        f"the record has only one sample per {every} steps, without a filter, so a vibration above {0.5 / h:.4g} Hz "
        f"appears below it, possibly with the opposite direction of whirl; record.every = 1 records all steps"
    )


def even_samples(time: Array) -> int:
    """Return the number of samples without a last one that follows sooner than the others, as a short row does."""
    steps = np.diff(time)
    return len(time) - int(len(steps) > 1 and steps[-1] < (1.0 - SHORTER) * steps[0])
