"""Writes a prepared run as an SSP archive: structure, parameter sets, FMUs, notes."""

from __future__ import annotations

from dataclasses import replace
from importlib.metadata import version
from pathlib import Path
from typing import Any

from amb_cosim.cosim.building.build_target import BuildTarget
from amb_cosim.cosim.fmu.fmu_interface import FmuInterface
from amb_cosim.cosim.fmu.fmus import fmu_with_starts, is_model
from amb_cosim.cosim.ssp.experiment_file import EXPERIMENT, NOTES, experiment_table, notes
from amb_cosim.cosim.ssp.parameter_values import parameter_set
from amb_cosim.cosim.ssp.structure import Described, system_structure
from amb_cosim.cosim.system.experiment import Plan
from amb_files.archive import archive_of, write_archive
from fmi_export.building.integers import with_integers

STRUCTURE = "SystemStructure.ssd"


def export_ssp(
    path: Path,
    plan: Plan,
    *,
    name: str,
    target: BuildTarget,
    connectors: bool = False,
    integers: bool = False,
    **options: Any,
) -> Path:
    """Write a prepared run to `path` and return it; the file appears complete or not at all.

    Models of this project are built with the run's parameters and initial inputs as start values, so that tools that
    ignore parameter bindings reproduce the run. FMU files are used unchanged.

    Parameters
    ----------
    plan
        The plan of the run.
    name
        Name of the system.
    target, options
        Target and options of model builds; see `fmus.build_models`.
    connectors
        Whether signals and inputs that change are connectors of the system. Some tools need these connectors to change
        inputs, but others (libcosim) refuse them.
    integers
        Whether Enumerations are described as Integers, for hosts without them (libcosim, ecos).

    Raises
    ------
    ValueError
        If an FMU cannot be built, or the run cannot be written as SSP.
    """
    system = plan.system
    starts = plan.start_values()
    files = {c.name: f"resources/{c.name}" for c in system.components}
    run = Described(
        name=name,
        plan=plan,
        interfaces={c: _with_integers(i) if integers else i for c, i in plan.interfaces.items()},
        sources={component: f"{file}.fmu" for component, file in files.items()},
        bindings={component: f"{file}.ssv" for component, file in files.items() if starts[component]},
        generator=f"amb-cosim {version('amb-cosim')}",
        connectors=connectors,
    )
    content = {STRUCTURE: system_structure(run), EXPERIMENT: experiment_table(run)}
    for component, place in run.bindings.items():
        content[place] = parameter_set(component, starts[component], run.interfaces[component].ports)
    for c in system.components:
        if is_model(c.fmu):
            fmu = fmu_with_starts(c.fmu, target, starts[c.name], c.every * plan.step_size, **options)
        else:
            fmu = plan.fmus[c.name].path.read_bytes()
        content[run.sources[c.name]] = with_integers(fmu) if integers else fmu
    content[NOTES] = notes(run, has_start_values=all(is_model(c.fmu) for c in system.components))
    return write_archive(path, archive_of(content))


def _with_integers(interface: FmuInterface) -> FmuInterface:
    """Return an interface whose Enumerations are Integers."""
    return replace(interface, ports={name: replace(port, items={}) for name, port in interface.ports.items()})
