"""The labelled data set of a run: what was recorded, and everything needed to know where it came from."""

from __future__ import annotations

import importlib.metadata
import json
import platform
import subprocess
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from amb_cosim.cosim.interface import Interface
from amb_cosim.cosim.recorder import Recorder
from amb_cosim.plan import Plan, port_of
from amb_cosim.scenario import Scenario

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
    stopped: str | None = None,
) -> xr.Dataset:
    """Everything that a run recorded, labelled.

    `failure` says what ended it before its time, `stopped` which of its own conditions did.

    Coordinates are `time` (s) from the beginning of cycle 0 and `cycle`, in turns of the initial speed.
    Structured attributes (scenario, parameters, versions, ...) are JSON texts, so that NetCDF can hold them.
    """
    time = recorder.points * plan.step_size
    variables = {}
    for column, variable in enumerate(recorder.table.T):
        label = plan.recorded[column]
        component, port = port_of(label, plan.system, interfaces)
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
        "stopped": stopped or "",
        "scenario_data": scenario.model_dump_json(exclude_defaults=True),
        "parameters": json.dumps(plan.parameters(interfaces)),
        "initial_inputs": json.dumps(dict(plan.exogenous)),
        "fmu_guids": json.dumps({c: interface.guid for c, interface in interfaces.items()}),
        "versions": json.dumps(_versions()),
        "git_revision": git_revision() or "",
    }
    if plan.profile:
        attributes["speed_profile"] = json.dumps([(n * plan.step_size, Omega) for n, Omega in plan.profile])
    if scenario.plot.cycles is not None:
        attributes["plot_cycles"] = list(scenario.plot.cycles)
    if scenario.plot.figures is not None:
        attributes["plot_figures"] = json.dumps(scenario.plot.figures)
    for label, n in plan.marks.items():
        if n <= recorder.reached:
            attributes[f"{label}_cycle"] = n * plan.step_size / plan.period
    return xr.Dataset(variables, coordinates, attributes)


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
