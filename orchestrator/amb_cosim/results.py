"""What a run's data set says: its figures, and its file."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Literal

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from amb_cosim.orbits import orbit_after, orbit_before, orbit_largest, settled_amplitudes
from amb_cosim.series import BEARINGS, cycles, signal
from fmi_export.files import write_atomically

BUSHES = ("eb1", "eb2")  # at the rotor's ends
RECOVERY_CYCLES = 5.0
FREE, ROLLING = 0, 2  # values of a site's mode
_HEAT = ("damping", "friction", "impact")


def save(dataset: xr.Dataset, path: Path) -> None:
    """Write a data set as NetCDF; the file appears complete or not at all."""
    encoding = {name: {"zlib": True, "complevel": 4, "shuffle": True} for name in dataset.data_vars}
    write_atomically(path, lambda p: dataset.to_netcdf(p, engine="h5netcdf", encoding=encoding))


def load(path: Path) -> xr.Dataset:
    """Read a data set back into memory."""
    with xr.open_dataset(path, engine="h5netcdf") as dataset:
        return dataset.load()


# Figures. Each is a function of the data set alone; None where the data set does not hold what it takes.


def summary(dataset: xr.Dataset) -> dict[str, Any]:
    """All figures of a run, ready for JSON."""
    simulated, wall = float(dataset.attrs["simulated_s"]), float(dataset.attrs["wall_s"])
    first, last = contact_cycles(dataset)
    return {
        "scenario": dataset.attrs["scenario"],
        "flavour": dataset.attrs["flavour"],
        "completed": bool(dataset.attrs["completed"]),
        "stopped": dataset.attrs.get("stopped") or None,
        "settling_s": float(dataset.attrs["settling_s"]),
        "simulated_s": simulated,
        "wall_s": wall,
        "real_time_factor": simulated / wall if wall > 0.0 else None,
        "peak_contact_force_N": {site: peak(dataset, f"{site}.f_n") for site in touchable(dataset)},
        "peak_impulse_Ns": {site: peak(dataset, f"{site}.impulse") for site in touchable(dataset)},
        "contact_share": contact_share(dataset),
        "first_contact_cycle": first,
        "last_contact_cycle": last,
        "recovered": recovered(dataset),
        "outcome": outcome(dataset),
        "rolling_from_cycle": rolling_from(dataset),
        "whirl_speed_rad_s": {site: whirl_at_the_end(dataset, site) for site in BEARINGS},
        "orbit_before_mm": orbit_before(dataset),
        "orbit_after_mm": orbit_after(dataset),
        "orbit_largest_mm": orbit_largest(dataset),
        "settled_amplitude_mm": settled_amplitudes(dataset),
        **energy_figures(dataset),
    }


def peak(dataset: xr.Dataset, name: str) -> float | None:
    """Largest value of a variable of the plant from cycle 0 on."""
    values = signal(dataset, name)
    if values is None or not (cycles(dataset) >= 0.0).any():
        return None
    return float(values[cycles(dataset) >= 0.0].max())


def touchable(dataset: xr.Dataset) -> list[str]:
    """The retainer bearings, and the end bushes that the rotor has touched."""
    return [*BEARINGS, *(site for site in BUSHES if peak(dataset, f"{site}.f_n") or peak(dataset, f"{site}.impulse"))]


def loaded_interval(dataset: xr.Dataset) -> tuple[float, float]:
    """Cycles between the step and its removal: the whole run without a step, to the end without a removal."""
    return float(dataset.attrs.get("step_cycle", 0.0)), float(dataset.attrs.get("removal_cycle", np.inf))


def contact_share(dataset: xr.Dataset) -> dict[str, float | None]:
    """Share of the time between step and removal in each contact state: 0 none, 1 RB1, 2 RB2, 3 both."""
    begin, end = loaded_interval(dataset)
    state = signal(dataset, "contact_state")
    within = (cycles(dataset) >= begin) & (cycles(dataset) < end)
    if state is None or not within.any():
        return {str(k): None for k in range(4)}
    return {str(k): float(np.mean(state[within] == k)) for k in range(4)}


def in_contact(dataset: xr.Dataset) -> NDArray[np.bool_] | None:
    """Samples that end in contact, or that follow an impact within the step before them."""
    state = signal(dataset, "contact_state")
    if state is None:
        return None
    touching = state != 0
    for site in (*BEARINGS, *BUSHES):
        for name in ("mode", "impulse"):
            values = signal(dataset, f"{site}.{name}")
            if values is not None:
                touching |= values > 0
    return np.asarray(touching)


def contact_cycles(dataset: xr.Dataset) -> tuple[float | None, float | None]:
    """Cycles of the first and of the last sample in contact, counted from the beginning of cycle 0."""
    touching = in_contact(dataset)
    if touching is None:
        return None, None
    when = cycles(dataset)[touching & (cycles(dataset) >= 0.0)]
    return (float(when[0]), float(when[-1])) if len(when) else (None, None)


def recovered(dataset: xr.Dataset) -> bool | None:
    """Whether the rotor is free of contact for good: the run goes on for five cycles after the last contact.

    A rotor that never touched has nothing to recover from, and counts as recovered.
    """
    if in_contact(dataset) is None:
        return None
    _, last = contact_cycles(dataset)
    return last is None or bool(cycles(dataset)[-1] - last >= RECOVERY_CYCLES)


def outcome(dataset: xr.Dataset) -> Literal["prevented", "recovered", "trapped"] | None:
    """What the step led to; None without a step, or where contact was not recorded.

    `trapped` is a rotor that has not `recovered`. Of the others, `prevented` is one that never touches after the step.
    """
    free, step = recovered(dataset), dataset.attrs.get("step_cycle")
    if free is None or step is None:
        return None
    if not free:
        return "trapped"
    _, last = contact_cycles(dataset)
    return "prevented" if last is None or last <= step else "recovered"


def whirl_at_the_end(dataset: xr.Dataset, site: str) -> float | None:
    """Whirl speed (rad/s) at a site at the end of the run; None where the rotor does not touch it then."""
    mode, whirl = signal(dataset, f"{site}.mode"), signal(dataset, f"{site}.whirl_speed")
    if mode is None or whirl is None or not len(mode) or mode[-1] == FREE:
        return None
    return float(whirl[-1])


def rolling_from(dataset: xr.Dataset) -> float | None:
    """First cycle from which a retainer bearing rolls without a break through a turn of its whirl or more."""
    starts = [start for site in BEARINGS for start in _turns_rolled(dataset, site)]
    return min(starts, default=None)


def _turns_rolled(dataset: xr.Dataset, site: str) -> list[float]:
    """Cycles at which the rolling of at least a turn begins."""
    mode, whirl = signal(dataset, f"{site}.mode"), signal(dataset, f"{site}.whirl_speed")
    if mode is None or whirl is None:
        return []
    rolls = np.concatenate([[False], (mode == ROLLING) & (cycles(dataset) >= 0.0), [False]])
    begins, ends = np.flatnonzero(rolls[1:] & ~rolls[:-1]), np.flatnonzero(rolls[:-1] & ~rolls[1:])
    steps = np.diff(dataset["time"].values, prepend=np.nan)  # a sample's mode is that at the end of its step
    turned = [float(np.sum(np.abs(whirl[i + 1 : j]) * steps[i + 1 : j])) for i, j in zip(begins, ends, strict=True)]
    return [float(cycles(dataset)[i]) for i, angle in zip(begins, turned, strict=True) if angle >= 2.0 * np.pi]


def energies(dataset: xr.Dataset) -> dict[str, NDArray[np.float64]] | None:
    """Energies of the plant (J) at each sample: those stored, and work, heat and balance counted from cycle 0.

    None if they were not recorded, or cycle 0 was not reached.
    """
    values = {name: signal(dataset, f"energy.{name}") for name in ("kinetic", "strain", *_HEAT, "work", "balance")}
    begin = int(np.searchsorted(cycles(dataset), 0.0))
    if any(v is None for v in values.values()) or begin == dataset.sizes["time"]:
        return None
    stored = ("kinetic", "strain")
    return {name: v if name in stored else v - v[begin] for name, v in values.items() if v is not None}


def energy_figures(dataset: xr.Dataset) -> dict[str, Any]:
    """What became of the energy from cycle 0 to the end (J), and how well the plant accounts for it.

    `balance` is the largest difference between what the rotor gained and the work done on it; relative, it is divided
    by the largest of all energies.
    """
    series = energies(dataset)
    if series is None:
        return {"energy_J": None, "energy_balance_relative": None}
    after = cycles(dataset) >= 0.0
    largest = {name: float(np.abs(values[after]).max()) for name, values in series.items()}
    balance = largest.pop("balance")
    figures = {name: float(series[name][-1]) for name in (*_HEAT, "work")} | {"balance": balance}
    scale = max(largest.values())
    return {"energy_J": figures, "energy_balance_relative": balance / scale if scale > 0.0 else None}
