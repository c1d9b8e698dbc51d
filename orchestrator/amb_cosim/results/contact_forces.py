"""Normal contact force at a site over a run: its largest value, its largest mean over a millisecond, its impulse.

The plant outputs two values of the force in each step: `f_n_peak` is the largest force, excluding the impulses of
impacts, and `f_n_mean` is the mean, including them. If an FMU lacks these outputs, the samples `f_n` and the impulses
are used instead, and `is_sampled` reports this. A thinned record contains these quantities for every step (see
`at_every_step`).

To users, the largest mean is the "largest contact force", and the largest value the "largest force between impacts".
The latter depends on how stiff the modelled contact is, grows with the numbers of modes and nodes of the rotor, and is
not defined for an impulse. By contrast, the force averaged over `WINDOW` converges as these numbers increase.
"""

from __future__ import annotations

from functools import reduce

import numpy as np

from amb_cosim.cosim.record.signals import EACH_STEP, Signals
from amb_cosim.results.signal_arrays import at_every_step, cycles, signal, thinning
from array_types import Array, Bools

WINDOW = 1e-3  # s, over which contact forces are averaged


def is_sampled(dataset: Signals, site: str) -> bool:
    """Return whether only samples of the force at a site are recorded, and not the values between them."""
    if EACH_STEP not in dataset and thinning(dataset) > 1:
        return True
    return signal(at_every_step(dataset), f"{site}.f_n_peak") is None


def peaks(dataset: Signals, site: str) -> Array | None:
    """Return the largest normal force (N) since the previous sample, or the force at samples; None if not recorded."""
    return _largest_between(dataset, _peaks(at_every_step(dataset), site))


def peak_force(dataset: Signals, site: str, begin: float = 0.0, end: float = np.inf) -> float | None:
    """Return the largest normal force (N) at a site between two cycles; None if there are no samples."""
    steps = at_every_step(dataset)
    return largest(steps, _peaks(steps, site), begin, end)


def averaged_force(dataset: Signals, site: str) -> Array | None:
    """Return the largest mean normal force (N) over `WINDOW` since the previous sample, including impacts."""
    return _largest_between(dataset, _averaged(at_every_step(dataset), site))


def largest_averaged_force(dataset: Signals, site: str, begin: float = 0.0, end: float = np.inf) -> float | None:
    """Return the largest mean normal force (N) over `WINDOW` at a site between two cycles, including impacts."""
    steps = at_every_step(dataset)
    return largest(steps, _averaged(steps, site), begin, end)


def received_impulse(dataset: Signals, site: str) -> Array | None:
    """Return the normal impulse (N s) of forces and impacts at a site from the first sample up to each sample."""
    return _at_samples(dataset, _accumulated_impulse(at_every_step(dataset), site))


def touches(dataset: Signals, site: str) -> Bools:
    """Return at which samples the rotor touches a site, or has touched it in the step before; none if not recorded."""
    recorded = (signal(dataset, f"{site}.{name}") for name in ("mode", "impulse", "f_n_peak"))
    touching = (values > 0.0 for values in recorded if values is not None)
    return reduce(np.logical_or, touching, np.zeros(dataset.sizes["time"], bool))


def largest(dataset: Signals, values: Array | None, begin: float = 0.0, end: float = np.inf) -> float | None:
    """Return the largest value at the samples between two cycles, not before cycle 0; None if there are none."""
    first, stop = np.searchsorted(cycles(dataset), (max(begin, 0.0), end))
    return None if values is None or first >= stop else float(values[first:stop].max())


def _peaks(dataset: Signals, site: str) -> Array | None:
    forces = signal(dataset, f"{site}.f_n_peak")
    forces = signal(dataset, f"{site}.f_n") if forces is None else forces
    return None if forces is None else np.asarray(forces, np.float64)


def _averaged(dataset: Signals, site: str) -> Array | None:
    impulse, time = _accumulated_impulse(dataset, site), dataset["time"].values
    if impulse is None or len(time) < 2:
        return None
    return np.asarray((impulse - np.interp(time - WINDOW, time, impulse)) / WINDOW, np.float64)


def _accumulated_impulse(dataset: Signals, site: str) -> Array | None:
    mean, force, impacts = (signal(dataset, f"{site}.{name}") for name in ("f_n_mean", "f_n", "impulse"))
    steps = np.diff(dataset["time"].values)
    if mean is not None:
        impulses = mean[1:] * steps
    elif force is not None and impacts is not None:
        impulses = impacts[1:] + 0.5 * steps * (force[1:] + force[:-1])
    else:
        return None
    return np.asarray(np.cumsum(np.append(0.0, impulses))[: dataset.sizes["time"]], np.float64)


def _largest_between(dataset: Signals, values: Array | None) -> Array | None:
    """Return, for each sample, the largest of the `values` in the steps since the previous sample."""
    steps = at_every_step(dataset)
    if values is None or steps is dataset or not dataset.sizes["time"]:
        return values
    begins = np.searchsorted(steps["time"].values, dataset["time"].values[:-1], side="right")
    return np.maximum.reduceat(values, [0, *begins])


def _at_samples(dataset: Signals, values: Array | None) -> Array | None:
    """Return the values of the steps that end at a sample; exactly one step ends at each sample."""
    steps = at_every_step(dataset)
    if values is None or steps is dataset:
        return values
    return values[np.searchsorted(steps["time"].values, dataset["time"].values)]
