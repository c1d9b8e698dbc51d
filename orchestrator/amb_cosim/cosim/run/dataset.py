"""A finished run with labelled signals: units, descriptions, and origin."""

from __future__ import annotations

import importlib.metadata
import json
import platform
import subprocess
from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Self
from warnings import catch_warnings

import numpy as np

from amb_cosim.cosim.errors import Interrupted
from amb_cosim.cosim.fmu.fmu_interface import Port
from amb_cosim.cosim.grid.time_grid import nearest_point
from amb_cosim.cosim.record import warnings
from amb_cosim.cosim.record.netcdf import check, netcdf, with_own_names
from amb_cosim.cosim.record.signals import AT_STEPS, EACH_STEP, Samples, Signals, SignalTable
from amb_cosim.cosim.record.untrusted_netcdf import check_content
from amb_cosim.cosim.run.checkpoint import Checkpoint
from amb_cosim.cosim.run.recording import Outcome, Recording
from amb_cosim.cosim.system.system import UNCHANGED, Output
from amb_cosim.cosim.system.tables import moment_of
from amb_cosim.cosim.system.values import Raw
from amb_files.atomic import write_file
from array_types import Array

if TYPE_CHECKING:
    import xarray as xr

FLAGS, FLAG_NAMES = "flag_values", "flag_meanings"  # attributes of an enumeration, as CF calls them
LABELS = ("units", "description", "causality", "component")  # attributes of a variable
_PACKAGES = ("amb-cosim", "fmpy", "pythonfmu", "numba", "numpy", "xarray")
_DTYPES = {"Real": np.float64, "Integer": np.int32, "Boolean": np.int8}
_WIDE_DTYPES = {"UInt32": np.int64, "Int64": np.int64, "UInt64": np.uint64}  # by the FMU's own type


class Run:
    """Recorded signals and outcome of a run.

    Attributes
    ----------
    outcome
        `status` (completed, stopped, failed, interrupted), `time` (s), `component`, `reason`.
    checkpoints
        States saved by `save_at`, by communication point; see `checkpoint`.
    """

    def __init__(
        self,
        recorded: SignalTable | xr.Dataset,
        outcome: Outcome,
        checkpoints: Mapping[int, Checkpoint] = MappingProxyType({}),
    ) -> None:
        self._recorded = recorded
        self.outcome = outcome
        self.checkpoints = checkpoints

    def unless_interrupted(self) -> Self:
        """Return this run; if Ctrl-C ended it, raise `Interrupted`, which carries it."""
        if self.outcome.status == "interrupted":
            raise Interrupted(str(self.outcome), self)
        return self

    @property
    def signals(self) -> Signals:
        """Every recorded variable, as in the data set, without importing xarray."""
        return self._recorded

    @property
    def dataset(self) -> xr.Dataset:
        """Every recorded variable over `time` (s), with units and descriptions."""
        if isinstance(self._recorded, SignalTable):
            self._recorded = self._recorded.to_dataset()
        return self._recorded

    def checkpoint(self, moment: Raw | None = None) -> Checkpoint:
        """Return the state of the run at a time of `save_at`, by default at the only such time.

        Raises
        ------
        ValueError
            If no state was saved at this time.
        """
        if moment is None and len(self.checkpoints) == 1:
            return next(iter(self.checkpoints.values()))
        h, period = float(self.signals.attrs["communication_step_s"]), self.signals.attrs.get("period_s")
        start = next((checkpoint.start_time for checkpoint in self.checkpoints.values()), 0.0)
        n = -1 if moment is None else nearest_point("moment", moment_of(moment, period), h, start)
        if n in self.checkpoints:
            return self.checkpoints[n]
        saved = [f"{checkpoint.time:.9g} s" for checkpoint in self.checkpoints.values()]
        hint = (
            f"there are {', '.join(saved)}"
            if saved
            else "save_at saves checkpoints at the given moments if the run reaches them"
        )
        raise ValueError(f"{'no moment is named' if moment is None else f'no checkpoint at {moment}'}; {hint}")

    def _save(self, path: Path) -> None:
        """Write the recorded signals as NetCDF."""
        save(self._recorded, path)


def _flags(port: Port) -> dict[str, Any]:
    """Return the names of an Enumeration's values in the form of the CF conventions."""
    if not port.items:
        return {}
    names = ["_".join(name.split()) or "_" for name in port.items]  # which CF parts by blanks
    return {FLAGS: np.array([*port.items.values()], np.int32), FLAG_NAMES: " ".join(names)}


def to_signals(recording: Recording) -> SignalTable:
    """Return all recorded signals of a run with labels, over `time` (s).

    Structured attributes (parameters, versions, ...) are JSON texts, which NetCDF can store.
    """
    plan, recorder, outcome = recording.plan, recording.recorder, recording.outcome
    variables = {}
    every_step = {f"{label}{AT_STEPS}": (label, column) for label, column in steps_of(recording).items()}
    sampled = {label: (label, column) for label, column in zip(plan.recorded, recorder.table.T, strict=True)}
    for name, (label, variable) in (sampled | every_step).items():
        component, port = plan.port(label)
        variables[name] = Samples(
            variable.astype(_WIDE_DTYPES.get(port.stored, _DTYPES[port.type])),
            {
                "units": port.unit or "1",
                "description": port.description,
                "causality": port.causality,
                "component": component,
                **_flags(port),
            },
            "time" if name in sampled else EACH_STEP,
        )
    for output in plan.system.outputs:
        if (source := variables.get(output.source)) is not None and output.name not in variables:
            variables[output.name] = _of_output(output, source)
    times = plan.grid.times(recorder.points)
    time = Samples(times, {"units": "s", "description": "Time"})
    attributes: dict[str, Any] = {
        "system": plan.system.name,
        "flavour": recording.plan.assembly.flavour,
        "communication_step_s": plan.step_size,
        "settling": plan.settling if plan.settling == "simulated" else "solved",
        "settling_s": -plan.begin * plan.step_size,
        "simulated_s": plan.time(recorder.reached) - plan.start_time,
        "wall_s": recorder.wall_time,
        "completed": int(outcome.failure is None),
        "failure": outcome.failure or "",
        "stopped": outcome.stopped or "",
        "notices": json.dumps(plan.notices),
        warnings.ATTRIBUTE: warnings.to_json(_warnings(recording, times)),
        "outcome": json.dumps([outcome.status, outcome.time, outcome.component, outcome.reason]),
        "parameters": json.dumps(parameters_of(recording)),
        "initial_inputs": json.dumps(dict(plan.inputs)),
        "fmu_guids": json.dumps({c: interface.guid for c, interface in recording.plan.interfaces.items()}),
        "versions": json.dumps(_versions()),
        "git_revision": git_revision() or "",
    }
    return SignalTable(variables, {"time": time} | step_times(recording), attributes)


def _of_output(output: Output, source: Samples) -> Samples:
    """Return the samples of a system output, computed from the samples of the component output that is its source."""
    law = output.factor, output.offset
    values = source.values if law == UNCHANGED else output.factor * source.values + output.offset
    return Samples(values, {**source.attrs, "units": output.unit or "1"})


def parameters_of(recording: Recording) -> dict[str, dict[str, Any]]:
    """Return the parameters of every component: numbers, and the texts that were set."""
    texts = recording.plan.all_texts()
    numbers = recording.plan.all_parameters()
    return {component: values | texts.get(component, {}) for component, values in numbers.items()}


def steps_of(recording: Recording) -> dict[str, Array]:
    """Return, by name, the variables that a decimated record contains at every step, or for several steps together."""
    return dict(zip(recording.plan.recorded_each, recording.recorder.step_rows.values.T, strict=True))


def step_times(recording: Recording) -> dict[str, Samples]:
    """Return the times of all steps as a coordinate, if a decimated record contains variables at every step."""
    plan, rows = recording.plan, recording.recorder.step_rows
    if not plan.recorded_each:
        return {}
    description = "Time of every step" if rows.steps == 1 else f"Time at the end of every {rows.steps} steps"
    return {EACH_STEP: Samples(plan.grid.times(rows.points), {"units": "s", "description": description}, EACH_STEP)}


def _warnings(recording: Recording, times: Array) -> list[warnings.WarningRecord]:
    """Return the warnings of the plan, then the warnings about partial events and the warnings of all components."""
    plan, columns = recording.plan, dict(zip(recording.plan.recorded, recording.recorder.table.T, strict=True))
    return [
        *(warnings.WarningRecord("parameters", "", text, text) for text in plan.warnings),
        *(warnings.WarningRecord("events", "", text, text, first=time) for time, text in plan.partial_events),
    ] + [
        replace(warned, sampled=warned.share is not None and plan.record_every > 1)
        for component, interface in recording.plan.interfaces.items()
        for warned in warnings.of_component(
            component,
            interface.ports,
            recording.warnings[component],
            plan.time(plan.begin),
            times,
            {name: columns[f"{component}.{name}"] for name in interface.ports if f"{component}.{name}" in columns},
        )
    ]


def save(dataset: SignalTable | xr.Dataset, path: Path) -> None:
    """Write signals as NetCDF; the file appears complete or not at all."""
    write_file(path, netcdf(dataset))


def load(path: Path) -> xr.Dataset:
    """Read a data set back into memory; it takes at most `MOST_INFLATED` times the size of its file."""
    import xarray as xr

    check(path)
    check_content(path)  # before h5netcdf, which prints a traceback for a file that is not HDF5
    # The unit `hours` of an FMU makes no times of its numbers.
    plain: Any = {"decode_times": False, "decode_timedelta": False}
    try:
        with catch_warnings(action="ignore"), xr.open_dataset(path, engine="h5netcdf", **plain) as dataset:
            loaded = dataset.load()
    except OSError:
        raise
    except Exception as error:  # of xarray or h5netcdf, about their own variables
        raise ValueError("its arrays, dimensions or attributes are not those of a NetCDF file") from error
    result = with_own_names(loaded)
    _check_form(result)
    return result


def _check_form(dataset: xr.Dataset) -> None:
    """Raise ValueError unless the times ascend, all variables of a data set depend on time, and all labels are texts.

    Times without a unit are taken to be in s, and this function adds the unit.
    """
    for name, variable in dataset.variables.items():
        if variable.dims not in (("time",), (EACH_STEP,)) or variable.dims[0] not in dataset.coords:
            raise ValueError(f"{name} must have the dimension time or {EACH_STEP}, and a coordinate for this dimension")
        n, shape = dataset.sizes[variable.dims[0]], np.shape(variable.values)
        if shape != (n,):  # h5netcdf does not compare them
            raise ValueError(f"{name} has the shape {shape}, which is not allowed; it must be ({n},)")
        _check_flags(str(name), variable.attrs)
        for label in set(LABELS) & variable.attrs.keys():
            if not isinstance(variable.attrs[label], str):
                raise ValueError(f"{label} of {name} is not allowed; it must be text")
    for name in {"time", EACH_STEP} & set(dataset.sizes):
        times, unit = dataset[name].values, dataset[name].attrs.setdefault("units", "s")
        if unit != "s":
            raise ValueError(f"{name} has units = {unit!r}, which is not allowed; the units must be s")
        if not np.isfinite(times).all() or (np.diff(times) < 0.0).any():
            raise ValueError(f"{name} must be finite and must not decrease")
    if "time" not in dataset.sizes:
        raise ValueError("it has no dimension time")


def _check_flags(name: str, attributes: Mapping[str, Any]) -> None:
    """Raise ValueError if the variable is an enumeration, but its values do not have one name each."""
    if FLAG_NAMES not in attributes and FLAGS not in attributes:
        return
    names, values = attributes.get(FLAG_NAMES), np.asarray(attributes.get(FLAGS, ()))
    if not isinstance(names, str) or values.dtype.kind not in "iu" or len(names.split()) != values.size:
        raise ValueError(
            f"{FLAGS} and {FLAG_NAMES} of {name} are not allowed; each whole number must have exactly one name"
        )


@cache
def _versions() -> dict[str, str]:
    return {"python": platform.python_version()} | {name: importlib.metadata.version(name) for name in _PACKAGES}


@cache
def git_revision() -> str | None:
    """Return the Git commit of this package's checkout, with `-dirty` if files differ; None if there is none."""
    folder = Path(__file__).parent

    def git(*arguments: str) -> str:
        command = ["git", "-C", str(folder), *arguments]
        return subprocess.run(command, check=True, capture_output=True, text=True, timeout=10).stdout.strip()

    try:
        git("ls-files", "--error-unmatch", Path(__file__).name)
        return git("describe", "--always", "--dirty", "--abbrev=40", "--exclude=*")
    except (OSError, subprocess.SubprocessError):
        return None
