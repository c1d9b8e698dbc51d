"""Energies of the rotor over a run, from a data set."""

from __future__ import annotations

import numpy as np

from amb_cosim.cosim.record.signals import Signals
from amb_cosim.results.series import at_every_step, cycles, signal
from array_types import Array

HEAT = ("damping", "friction", "impact")


def energies(dataset: Signals) -> dict[str, Array] | None:
    """Return the energies of the plant (J) at each sample; work, heat and balance start at cycle 0.

    None if they were not recorded, or cycle 0 was not reached.
    """
    values = {name: signal(dataset, f"energy.{name}") for name in ("kinetic", "strain", *HEAT, "work", "balance")}
    begin = int(np.searchsorted(cycles(dataset), 0.0))
    if any(v is None for v in values.values()) or begin == dataset.sizes["time"]:
        return None
    stored = ("kinetic", "strain")
    return {name: v if name in stored else v - v[begin] for name, v in values.items() if v is not None}


def final_energies(dataset: Signals) -> dict[str, float] | None:
    """Return heat and work from cycle 0 to the end, and `balance`: the largest difference of gain and work (J)."""
    dataset = at_every_step(dataset)
    series = energies(dataset)
    if series is None:
        return None
    balance = np.abs(series["balance"][cycles(dataset) >= 0.0])
    return {name: float(series[name][-1]) for name in (*HEAT, "work")} | {"balance": float(balance.max())}


def relative_balance(dataset: Signals) -> float | None:
    """Return the error of the energy balance over the largest of all energies from cycle 0 on."""
    dataset = at_every_step(dataset)
    series = energies(dataset)
    if series is None:
        return None
    after = cycles(dataset) >= 0.0
    largest = {name: float(np.abs(values[after]).max()) for name, values in series.items()}
    balance = largest.pop("balance")
    scale = max(largest.values())
    return balance / scale if scale > 0.0 else None


def heat_of(energy: dict[str, float]) -> float:
    """Return the heat (J) of `final_energies`, its parts without their signs: a rule of impacts may create energy."""
    return sum(abs(energy[name]) for name in HEAT)


def balance_of_heat(dataset: Signals) -> float | None:
    """Return the error of the energy balance over the heat from cycle 0 on; None without heat.

    The largest energy may be that of the spin, which hides the error.
    """
    energy = final_energies(dataset)
    return None if energy is None or not heat_of(energy) else energy["balance"] / heat_of(energy)
