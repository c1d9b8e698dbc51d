"""Reads an SSP archive as a system and an experiment.

All systems of the archive become one system (`hierarchy`), with connections along the nets of connectors (`nets`) and
the values of parameter bindings (`bindings`). Each connector of the outermost system that feeds inputs becomes a
signal, and each connector to which outputs lead becomes an output. The experiment comes from this package's extra file
(`experiment_file`) or, without this file, from the default experiment. The communication step and the order of
components come from annotations (see `structure`); without an annotation, the step comes from the FMUs. Parameters that
exist in no FMU are ignored, as SSP allows. Arrays of SSP 2.0 are supported: a connection of two arrays connects each
element, row by row, and indices count from 1, as in FMI 3.0. Transformations of values and conversions of units require
the loop in Python.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

from amb_cosim.cosim.building.cache import unpacked
from amb_cosim.cosim.choices import COUPLINGS, Coupling
from amb_cosim.cosim.ssp.experiment_file import EXPERIMENT
from amb_cosim.cosim.ssp.flat_system import FlatSystem
from amb_cosim.cosim.ssp.hierarchy import NAMES, Document, number_of
from amb_cosim.cosim.ssp.schema import STRUCTURE, parse
from amb_cosim.cosim.ssp.structure import MASTER
from amb_cosim.cosim.system.experiment import Experiment
from amb_cosim.cosim.system.system import System
from amb_cosim.cosim.system.system_tables import ExperimentTable
from amb_files.checks import errors_in, require_choice
from amb_files.toml import read_toml, validate


def load_ssp(
    path: str | Path, step_size: float | None = None, stop_time: float | None = None
) -> tuple[System, Experiment]:
    """Return the system of an archive, and its experiment.

    Parameters
    ----------
    path
        The archive.
    step_size, stop_time
        Values (s) that replace the values in the archive.

    Raises
    ------
    ValueError
        If it is not an archive of SSP 1.0 or 2.0, contains unsupported elements, or lacks a step or a stop time.
    """
    what = f"archive {path}"
    if not Path(path).is_file():
        raise ValueError(f"no {what}")
    folder = unpacked(Path(path), what)
    structure = Document(None, folder, what, folder).file("SystemStructure.ssd")
    root = parse(structure.read_bytes(), STRUCTURE, f"{what}: SystemStructure.ssd")
    flat = FlatSystem(root, folder, what)
    parameters, inputs, unknown = flat.values()
    system = System(
        name=Path(path).stem,
        description=root.find("ssd:System", NAMES).get("description") or "",
        components=flat.components(),
        connections=flat.connections,
        signals=flat.signals(inputs),
        outputs=flat.outputs(),
        coupling=_coupling(root, what),
        parameters=parameters,
        unknown=unknown,
        remarks=flat.remarks(),
    )
    experiment_file = folder / EXPERIMENT
    if experiment_file.is_file():
        experiment = validate(read_toml(experiment_file, f"{what}: {EXPERIMENT}"), ExperimentTable, what).experiment()
        end = experiment.stop_time if stop_time is None else stop_time
        experiment = replace(experiment, step_size=step_size or experiment.step_size, stop_time=end)
    else:
        experiment = _experiment(root, flat.fmu_steps, what, step_size, stop_time)
    return system, replace(experiment, inputs={**inputs, **experiment.inputs})


def _experiment(
    root: Any, fmu_steps: Iterable[float | None], what: str, step_size: float | None, stop_time: float | None
) -> Experiment:
    """Return the default experiment."""
    table = root.find("ssd:DefaultExperiment", NAMES)
    start, stop = (
        None if table is None or table.get(name) is None else float(table.get(name))
        for name in ("startTime", "stopTime")
    )
    step = step_size or _step(root, fmu_steps)
    end = stop if stop_time is None else stop_time
    if step is None or end is None:
        missing = "communication step; set --step (step_size" if step is None else "stop time; set --until (stop_time"
        raise ValueError(f"{what} defines no {missing} in Python)")
    return Experiment(step_size=step, stop_time=end, start_time=start or 0.0, settles=False, record_settling=True)


def _step(root: Any, fmu_steps: Iterable[float | None]) -> float | None:
    """Return the communication step: the step in an annotation, or otherwise the shortest step of the FMUs."""
    for path, name in (
        (f".//{MASTER}", "stepSize"),
        (".//osp:FixedStepAlgorithm", "baseStepSize"),
        (".//oms:FixedStepMaster", "stepSize"),
    ):
        step = number_of(root, path, name)
        if step:
            return step
    return min((step for step in fmu_steps if step), default=None)


def _coupling(root: Any, what: str) -> Coupling:
    """Return the coupling from an annotation of this package, or Jacobi for an annotation of libcosim."""
    master = root.find(f".//{MASTER}")
    if master is not None:
        with errors_in(what):
            require_choice("coupling", master.get("coupling"), COUPLINGS)
        return cast(Coupling, master.get("coupling"))
    return "jacobi" if root.find(".//osp:FixedStepAlgorithm", NAMES) is not None else "gauss_seidel"
