"""A run's results: one labelled data set, its file, and its figures."""

from __future__ import annotations

import importlib.metadata
import json
import platform
import subprocess
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from orchestrator.interface import Interface, Port
from orchestrator.plan import Plan
from orchestrator.recorder import Recorder
from orchestrator.scenario import Scenario

BEARINGS = {"rb1": "mb1", "rb2": "mb2"}  # each retainer bearing and the magnetic bearing that it protects
RECOVERY_CYCLES = 5.0
_PLANT = "rotor_contact"
_PACKAGES = ("amb-cosim", "fmpy", "pythonfmu", "numba", "numpy", "xarray")
_DTYPES = {"Real": np.float64, "Integer": np.int32, "Boolean": np.int8}


def to_dataset(
    name: str,
    scenario: Scenario,
    plan: Plan,
    interfaces: Mapping[str, Interface],
    flavour: str,
    recorder: Recorder,
    failure: str | None,
) -> xr.Dataset:
    """Everything that a run recorded, labelled.

    Coordinates are `time` (s) from the beginning of cycle 0 and `cycle`, in turns of the initial speed.
    Structured attributes (scenario, parameters, versions, ...) are JSON texts, so that NetCDF can hold them.
    """
    time = recorder.points * plan.step_size
    variables = {}
    for column, variable in enumerate(recorder.table.T):
        label = plan.recorded[column]
        component, port = _port_of(label, plan, interfaces)
        variables[label] = (
            "time",
            variable.astype(_DTYPES[port.type]),
            {
                "units": port.unit or "1",
                "description": port.description,
                "causality": port.causality,
                "component": component,
            },
        )
    coordinates = {
        "time": ("time", time, {"units": "s", "description": "Time from the beginning of cycle 0"}),
        "cycle": ("time", time / plan.period, {"units": "1", "description": "Turns of the initial speed"}),
    }
    attributes: dict[str, Any] = {
        "scenario": name,
        "description": scenario.description,
        "source": scenario.source,
        "flavour": flavour,
        "speed_rad_s": plan.speed,
        "period_s": plan.period,
        "communication_step_s": plan.step_size,
        "settling_s": -plan.first * plan.step_size,
        "simulated_s": recorder.reached * plan.step_size,
        "wall_s": recorder.wall_time,
        "completed": int(failure is None),
        "failure": failure or "",
        "scenario_data": scenario.model_dump_json(exclude_defaults=True),
        "parameters": json.dumps(_parameters(plan, interfaces)),
        "initial_inputs": json.dumps(dict(plan.exogenous)),
        "fmu_guids": json.dumps({c: interface.guid for c, interface in interfaces.items()}),
        "versions": json.dumps(_versions()),
        "git_revision": git_revision() or "",
    }
    if scenario.plot.cycles is not None:
        attributes["plot_cycles"] = list(scenario.plot.cycles)
    for label, n in plan.marks.items():
        if n <= recorder.reached:
            attributes[f"{label}_cycle"] = n * plan.step_size / plan.period
    return xr.Dataset(variables, coordinates, attributes)


def _port_of(label: str, plan: Plan, interfaces: Mapping[str, Interface]) -> tuple[str, Port]:
    signal = next((s for s in plan.system.signals if s.name == label), None)
    component, variable = plan.system.split(signal.targets[0] if signal is not None else label)
    return component, interfaces[component].ports[variable]


def _parameters(plan: Plan, interfaces: Mapping[str, Interface]) -> dict[str, dict[str, float | None]]:
    """Every parameter of every component: what was set, or what it starts with."""
    return {
        c: {p.name: plan.start[c].get(p.name, p.start) for p in interface.of("parameter")}
        for c, interface in interfaces.items()
    }


def _versions() -> dict[str, str]:
    return {"python": platform.python_version()} | {name: importlib.metadata.version(name) for name in _PACKAGES}


def git_revision() -> str | None:
    """Commit of the checkout that this package runs from, `-dirty` if changed; None outside of one."""
    folder = Path(__file__).parent

    def git(*arguments: str) -> str:
        command = ["git", "-C", str(folder), *arguments]
        return subprocess.run(command, check=True, capture_output=True, text=True, timeout=10).stdout.strip()

    try:
        git("ls-files", "--error-unmatch", Path(__file__).name)
        return git("describe", "--always", "--dirty", "--abbrev=40", "--exclude=*")
    except (OSError, subprocess.SubprocessError):
        return None


def write_atomically(path: Path, write: Any) -> None:
    """Call `write` with a temporary path beside `path`, then move the result there, whole or not at all."""
    with tempfile.TemporaryDirectory(prefix=".", dir=path.parent) as folder:
        temporary = Path(folder) / path.name
        write(temporary)
        temporary.replace(path)


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
        "settling_s": float(dataset.attrs["settling_s"]),
        "simulated_s": simulated,
        "wall_s": wall,
        "real_time_factor": simulated / wall if wall > 0.0 else None,
        "peak_contact_force_N": {site: peak(dataset, f"{site}.f_n") for site in BEARINGS},
        "peak_impulse_Ns": {site: peak(dataset, f"{site}.impulse") for site in BEARINGS},
        "contact_share": contact_share(dataset),
        "first_contact_cycle": first,
        "last_contact_cycle": last,
        "recovered": recovered(dataset),
        "orbit_before_mm": orbit_before(dataset),
        "orbit_after_mm": orbit_after(dataset),
    }


def signal(dataset: xr.Dataset, name: str) -> NDArray[Any] | None:
    """Samples of a variable of the plant, or None if it was not recorded."""
    label = f"{_PLANT}.{name}"
    return np.asarray(dataset[label].values) if label in dataset else None


def cycles(dataset: xr.Dataset) -> NDArray[np.float64]:
    """Cycle of each sample."""
    return np.asarray(dataset["cycle"].values, dtype=np.float64)


def peak(dataset: xr.Dataset, name: str) -> float | None:
    """Largest value of a variable of the plant from cycle 0 on."""
    values = signal(dataset, name)
    if values is None or not (cycles(dataset) >= 0.0).any():
        return None
    return float(values[cycles(dataset) >= 0.0].max())


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
    for site in BEARINGS:
        impulse = signal(dataset, f"{site}.impulse")
        if impulse is not None:
            touching |= impulse > 0.0
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


def orbit_before(dataset: xr.Dataset) -> dict[str, float | None]:
    """Largest radius (mm) at each bearing in the last cycle before the step; None without a step."""
    step, cycle = float(dataset.attrs.get("step_cycle", -np.inf)), cycles(dataset)
    return _largest_radii(dataset, (cycle >= max(step - 1.0, 0.0)) & (cycle < step))


def orbit_after(dataset: xr.Dataset) -> dict[str, float | None]:
    """Largest radius (mm) at each bearing in the last cycle of the run."""
    cycle = cycles(dataset)
    return _largest_radii(dataset, (cycle >= max(cycle.max(initial=0.0) - 1.0, 0.0)))


def radius(dataset: xr.Dataset, bearing: str) -> NDArray[np.float64] | None:
    """Radial displacement at a magnetic bearing, in m."""
    x, y = signal(dataset, f"{bearing}.x"), signal(dataset, f"{bearing}.y")
    return None if x is None or y is None else np.hypot(x, y)


def _largest_radii(dataset: xr.Dataset, within: NDArray[np.bool_]) -> dict[str, float | None]:
    radii = {mb: radius(dataset, mb) for mb in BEARINGS.values()}
    return {mb: None if r is None or not within.any() else float(1e3 * r[within].max()) for mb, r in radii.items()}
