"""Energies of the rotor over a run, computed from a data set."""

from __future__ import annotations

import numpy as np

from amb_cosim.cosim.record.signals import Signals
from amb_cosim.results.signal_arrays import at_every_step, cycles, parameters, signal
from array_types import Array

HEAT = ("damping", "friction", "impact")


def energies(dataset: Signals) -> dict[str, Array] | None:
    """Return the energies of the plant (J) at each sample; work, heat and balance start at cycle 0.

    The result is None if they were not recorded, or cycle 0 was not reached.
    """
    values = {name: signal(dataset, f"energy.{name}") for name in ("kinetic", "strain", *HEAT, "work", "balance")}
    begin = int(np.searchsorted(cycles(dataset), 0.0))
    if any(v is None for v in values.values()) or begin == dataset.sizes["time"]:
        return None
    stored = ("kinetic", "strain")
    return {name: v if name in stored else v - v[begin] for name, v in values.items() if v is not None}


def spin_energy(dataset: Signals) -> Array | None:
    """Return the energy (J) of a free spin at each sample, a part of `energy.kinetic`; None if the spin is driven.

    1/2 I_p Omega^2
    """
    measured, inertia = signal(dataset, "speed"), parameters(dataset).get("spin.inertia")
    if measured is None or inertia is None or not parameters(dataset).get("spin.free"):
        return None
    return np.asarray(0.5 * float(inertia) * measured**2, np.float64)


def energy_balance(dataset: Signals) -> tuple[dict[str, float] | None, float | None, float | None]:
    """Return heat, work and `balance` (J), then the ratios of the balance to the largest energy and to the heat.

    `balance` is the largest difference between the energy gained and the work done from cycle 0 on. The largest energy
    may be that of the spin, in which case the first ratio hides the error. A ratio is None if its denominator is zero.
    """
    dataset = at_every_step(dataset)
    series = energies(dataset)
    if series is None:
        return None, None, None
    after = cycles(dataset) >= 0.0
    largest = {name: float(np.abs(values[after]).max()) for name, values in series.items()}
    balance = largest.pop("balance")
    energy = {name: float(series[name][-1]) for name in (*HEAT, "work")} | {"balance": balance}
    heat, scale = heat_of(energy), max(largest.values())
    return energy, balance / scale if scale > 0.0 else None, balance / heat if heat else None


def heat_of(energy: dict[str, float]) -> float:
    """Return the sum (J) of the magnitudes of the heats; the heat of impacts is negative if they create energy."""
    return sum(abs(energy[name]) for name in HEAT)
