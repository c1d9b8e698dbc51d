"""A sweep from request to data set: check, run missing points, refine, save."""

from __future__ import annotations

import hashlib
import importlib.metadata
import inspect
import json
import os
import platform
import stat
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any

from amb_analysis.studies.processes import end_if_imported_anew
from amb_cosim.cosim.choices import Flavour
from amb_cosim.cosim.run.dataset import git_revision
from amb_cosim.cosim.run.options import RunOptions
from amb_cosim.cosim.system.values import Raw, quantity
from amb_cosim.presentation.text_tables import html_of
from amb_cosim.presentation.units import convert_units_in_text, speed_unit, with_speeds_in
from amb_cosim.scenario.rotors import RotorSource, is_rotor
from amb_cosim.scenario.scenario import Scenario, as_scenario, load_scenario
from amb_files.checks import as_items, as_names, as_path, require, require_given
from amb_files.pack_file import rotor_path
from amb_files.plain_values import plain_values
from amb_files.toml import read_toml
from amb_sweeps import outcomes
from amb_sweeps.axes import Vary
from amb_sweeps.branching import varied_labels
from amb_sweeps.check import check_points
from amb_sweeps.engine import MetricFailed, connect, run_missing
from amb_sweeps.refine import BOUNDARIES, Refinement, check_refinement
from amb_sweeps.sampling import SamplePlan, sample_plan
from amb_sweeps.store import SweepStore, open_sweep
from amb_sweeps.sweep_bar import Report, sweep_bar
from amb_sweeps.worker import Metric, Task
from fmi_export.building.extras import require_extra

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr
    from distributed import Client

PACKAGES = ("amb-cosim", "numpy", "scipy", "xarray", "zarr", "dask", "distributed")


@dataclass(frozen=True)
class Sweep:
    """A completed sweep.

    Attributes
    ----------
    folder
        Folder of the store.
    design
        Points of the sweep.
    boundary
        Metric with the values 0 and 1; the maps draw its boundary.
    description
        Description of a ready sweep, empty for other sweeps.
    """

    folder: Path
    design: SamplePlan
    boundary: str = "recovered"
    description: str = ""

    @property
    def dataset(self) -> xr.Dataset:
        """Metrics, outcome, reason and run time of each point, over the axes."""
        return open_sweep(self.folder)

    def to_xarray(self) -> xr.Dataset:
        """Return `dataset`."""
        return self.dataset

    def to_dataframe(self) -> pd.DataFrame:
        """Return a table of pandas with a row for each point: varied values, metrics, outcome, reason and run time."""
        return self.dataset.to_dataframe().reset_index()

    def _repr_html_(self) -> str:
        return html_of([self.summary])

    @property
    def name(self) -> str:
        """Name of the sweep's scenario."""
        return str(json.loads(self.dataset.attrs["request"])["scenario"].get("name", ""))

    @property
    def title(self) -> str:
        """Title of the figures: the sweep's description in chosen units, or the name of its scenario.

        The scenario's description is left out, because it states values and an outcome that vary here.
        """
        return with_speeds_in(self.description or (self.name and f"Variations of {self.name}"), speed_unit())

    @property
    def summary(self) -> str:
        """Outcomes of the runs, one line per alternative."""
        from amb_sweeps.summary import summarise_sweep

        lines = summarise_sweep(self.dataset, self.design, self.folder, self.boundary)
        return convert_units_in_text("\n".join(lines))

    @property
    def outcomes(self) -> dict[str, int]:
        """Number of points with each outcome."""
        import numpy as np

        names, counts = np.unique(self.dataset["outcome"].values, return_counts=True)
        return {str(name): int(count) for name, count in zip(names, counts, strict=True)}


def sweep(
    scenario: str | Path | Scenario,
    vary: Vary,
    *,
    output: str | Path,
    sample: str = "grid",
    seed: int = 0,
    set: Mapping[str, Raw] | None = None,
    until: Raw | None = None,
    rotor: RotorSource = None,
    receptances: str | Path | None = None,
    flavour: Flavour = "native",
    metrics: Metric | Sequence[Metric] = (),
    keep: str | Sequence[str] = (),
    boundary: str = "recovered",
    certainty: float = 0.01,
    scheduler: str | None = None,
    jobs: int | None = None,
    progress: bool | Report | None = None,
) -> Sweep:
    """Run a scenario over a grid or a sample of its values, and return the results.

    To resume an interrupted sweep, call this again with the same folder. A `random` or `sobol` sample also grows there.

    Parameters
    ----------
    scenario, set, until, rotor, receptances, flavour
        As for `amb_cosim.run`.
    vary
        Values by name: `{"Omega": "60:300 rpm:60"}`, `{"Omega": [90, 120]}`. Alternatives have a table of settings for
        each label; names joined by `&` have a sequence of values each. A name is a `component.variable`, a shared
        signal, an event label followed by an input or by `cycle` or `time`, a field (such as `unbalance_factor`),
        `fmu.COMPONENT` or `scenario`.
    output
        Folder of the sweep, with `sweep.zarr`.
    sample, seed
        The sampling method, and the seed of random points. The method is `grid`; `boundary:METRIC` for a grid in which
        the boundary of recovered, contact or rolling is bisected; or `random:N`, `lhs:N`, `sobol:N` or `saltelli:N` for
        N points in the ranges without a count and the distributions.
    metrics
        Function or functions that take a result and return named numbers, in addition to the key values. An error of a
        metric is stored as `metric_error`; outcome and other numbers of the run remain.
    keep
        Outcomes whose full records are saved in the folder `runs`: `trapped`, `failed`, ...; `all` for every run.
    boundary
        Metric that provides the boundary in maps without bisection: recovered, contact or rolling.
    certainty
        Length, as a fraction of an axis, below which intervals at a boundary are not bisected further.
    scheduler, jobs
        Address of a Dask scheduler, or the number of processes of a local cluster, which is one per processor by
        default. A script that starts a local cluster must do so under `if __name__ == "__main__":`.
    progress
        Whether to show a bar, or a function that is called with the numbers of finished and of all points, and the
        address of the dashboard.

    Raises
    ------
    ValueError
        If a name, value or file is invalid, the folder contains the sweep of another request, or a metric fails in the
        first run because of an error of its own, such as a misspelt attribute.
    ClusterFailed
        If the cluster ended before the sweep was complete; earlier results are stored.
    KeyboardInterrupt
        If the sweep was interrupted; earlier results are stored.
    """
    end_if_imported_anew()
    require_extra("sweep", "a sweep", "cryptography", "dask", "distributed", "zarr", "SALib")
    require_given("scenario", scenario)
    options, folder = RunOptions(flavour=flavour), as_path("output", output)
    scenario = as_scenario(scenario, rotor, receptances)
    metrics, keep = as_items(metrics), as_names("keep", keep)
    for metric in metrics:
        require(callable(metric), "metrics", repr(metric), "functions that take a result")
    unknown = [name for name in keep if name not in (*outcomes.RUN, "all")]
    if unknown:
        raise ValueError(f"keep = {unknown[0]!r} is not allowed; it must be all or one of {', '.join(outcomes.RUN)}")
    kind, _, metric = sample.partition(":")
    bisected = kind == "boundary"
    design = sample_plan(vary, "grid" if bisected else sample, seed)
    boundary = metric if bisected else boundary
    if boundary not in BOUNDARIES:
        option = f"sample = {sample!r}" if bisected else f"boundary = {boundary!r}"
        raise ValueError(f"{option} is not allowed; the metric must be one of {', '.join(BOUNDARIES)}")
    if bisected:
        check_refinement(design, certainty, boundary)
    until = None if until is None else quantity(until, "s", "until")
    labels = varied_labels(design, _labels(scenario, design))
    task = Task(scenario, plain_values(set, "set"), until, options, metrics, keep, labels)
    guids, units, descriptions = check_points(task, design)
    design = design.with_units(units)
    requested = {**_request(task), "guids": guids}
    provenance = {**_provenance(), "descriptions": descriptions}
    with only_writer(folder):
        store = SweepStore(folder, design, {**requested, "design": design.as_dict()}, provenance)
        name = hashlib.sha256(json.dumps(requested, sort_keys=True).encode()).hexdigest()
        with sweep_bar(progress) as report:
            if store.missing or bisected:
                with connect(scheduler, jobs) as client:
                    try:
                        run_missing(client, name, task, store, report)
                    except MetricFailed:
                        store.discard()
                        raise
                    if bisected:
                        _refine(client, name, task, store, requested, report, certainty, boundary)
    return Sweep(folder, design, boundary)


def _labels(scenario: Scenario, design: SamplePlan) -> tuple[str, ...]:
    """Return the event labels of all scenarios of a sweep; the labels of each scenario are in order of time."""
    names = {str(name) for point in design.corners() if (name := design.settings(point).get("scenario"))}
    others = (load_scenario(name).labels for name in sorted(names))
    return tuple(dict.fromkeys((*scenario.labels, *chain.from_iterable(others))))


def _refine(
    client: Client,
    name: str,
    task: Task,
    store: SweepStore,
    request: Mapping[str, Any],
    report: Report,
    tolerance: float,
    boundary: str,
) -> None:
    refinement = Refinement(store.design, store.dataset(), tolerance, boundary)
    while (points := refinement.next_round()) is not None:
        group = f"{boundary}_{refinement.rounds}"
        request = {**request, "design": points.as_dict()}
        round_store = SweepStore(store.folder, points, request, _provenance(), group)
        run_missing(client, name, task, round_store, report)
        refinement.learn(round_store.dataset())
    refinement.save(store)


def _request(task: Task) -> dict[str, Any]:
    """Return everything that determines the results of a point, as JSON data."""
    return {
        "scenario": task.scenario.model_dump(mode="json", exclude_unset=True, exclude_none=True),
        "set": dict(task.settings),
        "until": task.until,
        "flavour": task.options.flavour,
        "metrics": [_metric_identity(metric) for metric in task.metrics],
        "keep": list(task.keep),
        "rotor": _rotor_file(task.scenario.rotor),
    }


def _rotor_file(rotor: RotorSource) -> dict[str, Any] | None:
    """Return the content of a scenario's rotor file; None if there is none or it was created in Python."""
    if is_rotor(rotor):
        return None
    with suppress(ValueError):  # no pack has a rotor
        path = rotor_path(rotor)
        return read_toml(path, f"rotor file {path}")
    return None


def _metric_identity(metric: Metric) -> str:
    """Return the name of a function and the digest of its source, if any."""
    name = getattr(metric, "__qualname__", type(metric).__name__)
    try:
        source = inspect.getsource(metric)
    except (OSError, TypeError):
        return name
    return f"{name} {hashlib.sha256(source.encode()).hexdigest()[:12]}"


def _provenance() -> dict[str, Any]:
    versions = {package: importlib.metadata.version(package) for package in PACKAGES}
    return {"versions": {"python": platform.python_version(), **versions}, "git_revision": git_revision() or ""}


@contextmanager
def only_writer(folder: Path) -> Iterator[None]:
    """Hold the lock of a folder, which the system releases when the process ends; Windows has no such lock.

    Raises
    ------
    ValueError
        If another process holds the lock, or the path of the lock is not a file. In both cases, nothing is changed.
    """
    try:
        import fcntl
    except ImportError:
        yield
        return
    folder.mkdir(parents=True, exist_ok=True)
    lock = folder / ".lock"
    try:  # do not follow links or wait for pipes
        file = os.open(lock, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC, 0o666)
    except OSError as error:
        raise ValueError(f"{lock} cannot be the lock of a sweep: {error.strerror}") from error
    try:
        if not stat.S_ISREG(os.fstat(file).st_mode):
            raise ValueError(f"{lock} cannot be the lock of a sweep; it is not a file")
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            raise ValueError(f"another sweep is writing to {folder}") from error
        yield
    finally:
        os.close(file)
