"""Run a system with the masters of other projects. Each function runs in a separate process.

They take the system as plain data:

- `fmus`: path of each component's FMU, in Gauss-Seidel order;
- `start`: values of parameters and unconnected inputs, `{component: {variable: value}}`;
- `connections`: pairs of ends `component.variable`, output first;
- `recorded`: outputs, `component.variable`;
- `step_size` (s), `steps`, and how many of them a step of a component spans, `every`.

and return `series`, `{component.variable: values}` with a value for each communication point. With nothing to
record they make all steps in one call, without Python between steps, and return the time per step, `seconds`. The
first step, in which a master may still initialise, is not timed.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any


def step_time(advance: Callable[[int], object], steps: int) -> float:
    """Return the time (s) of one of `steps` steps; `advance(n)` makes n of them."""
    advance(1)
    begin = time.perf_counter()
    advance(steps - 1)
    return (time.perf_counter() - begin) / (steps - 1)


def described_as_integers(fmus: dict[str, str]) -> dict[str, str]:
    """Return copies of FMUs in the working folder that describe Enumerations as Integers: libcosim and ecos need it."""
    from pathlib import Path

    from fmi_export.building.integers import with_integers

    copies = {name: Path(f"{name}.fmu").absolute() for name in fmus}
    for name, copy in copies.items():
        copy.write_bytes(with_integers(Path(fmus[name]).read_bytes()))
    return {name: str(copy) for name, copy in copies.items()}


def with_libcosim(
    fmus: dict[str, str],
    start: dict[str, dict[str, Any]],
    connections: list[list[str]],
    recorded: list[str],
    step_size: float,
    steps: int,
    every: dict[str, int],
) -> dict[str, Any]:
    """Run with libcosim's fixed-step algorithm, in Jacobi order.

    It initialises in its first step, so the results begin at point 1.
    """
    from pathlib import Path
    from xml.etree.ElementTree import Element, ElementTree, SubElement

    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimLogging import CosimLogLevel, log_output_level

    schema = "http://opensimulationplatform.com/MSMI/OSPSystemStructure"
    root = Element("OspSystemStructure", xmlns=schema, version="0.1")
    SubElement(root, "StartTime").text = "0.0"
    SubElement(root, "BaseStepSize").text = repr(step_size)
    SubElement(root, "Algorithm").text = "fixedStep"
    simulators, links = SubElement(root, "Simulators"), SubElement(root, "Connections")
    for name, path in described_as_integers(fmus).items():
        simulator = {"name": name, "source": Path(path).as_uri(), "stepSize": repr(every[name] * step_size)}
        initial = SubElement(SubElement(simulators, "Simulator", simulator), "InitialValues")
        for variable, value in start[name].items():
            kind = {float: "Real", int: "Integer", bool: "Boolean"}[type(value)]
            text = repr(value).lower()
            SubElement(SubElement(initial, "InitialValue", variable=variable), kind, value=text)
    for ends in connections:
        link = SubElement(links, "VariableConnection")
        for end in ends:
            component, _, variable = end.partition(".")
            SubElement(link, "Variable", simulator=component, name=variable)
    ElementTree(root).write("OspSystemStructure.xml", encoding="utf-8", xml_declaration=True)

    log_output_level(CosimLogLevel.WARNING)
    execution = CosimExecution.from_osp_config_file(str(Path("OspSystemStructure.xml").absolute()))
    if not recorded:
        return {"series": {}, "seconds": step_time(execution.step, steps)}
    return {"series": outputs_by_libcosim(execution, recorded, steps)}


def outputs_by_libcosim(execution: Any, recorded: list[str], steps: int) -> dict[str, list[Any]]:
    """Return the outputs after each of `steps` steps, except those of types that libcosim does not have."""
    from libcosimpy.CosimEnums import CosimVariableType
    from libcosimpy.CosimObserver import CosimObserver

    variables = {
        f"{name}.{v.name.decode()}": (index, v.reference, CosimVariableType(v.type).name.lower())
        for name in sorted({name.partition(".")[0] for name in recorded})
        for index in [execution.slave_index_from_instance_name(name)]
        for v in execution.slave_variables(index)
    }
    observer = CosimObserver.create_last_value()
    assert execution.add_observer(observer)
    series: dict[str, list[Any]] = {name: [] for name in recorded if name in variables}
    for _ in range(steps):
        assert execution.step()
        for name, values in series.items():
            index, reference, kind = variables[name]
            if hasattr(observer, f"last_{kind}_values"):
                values += getattr(observer, f"last_{kind}_values")(index, [reference])
    return series


def with_ecos(
    fmus: dict[str, str],
    start: dict[str, dict[str, Any]],
    connections: list[list[str]],
    recorded: list[str],
    step_size: float,
    steps: int,
    every: dict[str, int],
) -> dict[str, Any]:
    """Run with ecos's fixed-step algorithm, in Jacobi order, with the same step for all components.

    ecos also has longer steps for single components, but their outputs then appear before that step has passed.
    """
    load_tbb()
    from ecospy import EcosSimulation, EcosSimulationStructure

    assert set(every.values()) == {1}
    fmus = described_as_integers(fmus)
    kinds = kinds_in_ecos(fmus)
    with EcosSimulationStructure() as structure:
        for name, path in fmus.items():
            structure.add_model(name, path)
        for source, target in connections:
            connect = {"real": structure.make_real_connection, "integer": structure.make_int_connection}[kinds[source]]
            connect(source.replace(".", "::", 1), target.replace(".", "::", 1))
        values = {f"{c}::{variable}": value for c, settings in start.items() for variable, value in settings.items()}
        structure.add_parameter_set("start", values)
        with EcosSimulation(step_size, structure=structure) as simulation:
            assert simulation.init(parameter_set="start")
            if not recorded:
                return {"series": {}, "seconds": step_time(simulation.step, steps)}
            return {"series": outputs_by_ecos(simulation, kinds, recorded, steps)}


def load_tbb() -> None:
    """Load oneTBB, which ecos needs, from its wheel, where the loader does not search, or else the system's."""
    import ctypes
    import sys
    from contextlib import suppress

    with suppress(OSError):
        ctypes.CDLL(f"{sys.prefix}/lib/libtbb.so.12", ctypes.RTLD_GLOBAL)


def kinds_in_ecos(fmus: dict[str, str]) -> dict[str, str]:
    """Return the type of each variable, `component.variable`, as ecos calls it."""
    import fmpy

    kinds = {"Real": "real", "Integer": "integer", "Enumeration": "integer", "Boolean": "bool"}
    described = {name: fmpy.read_model_description(path).modelVariables for name, path in fmus.items()}
    return {f"{name}.{v.name}": kinds[v.type] for name, variables in described.items() for v in variables}


def outputs_by_ecos(simulation: Any, kinds: dict[str, str], recorded: list[str], steps: int) -> dict[str, list[Any]]:
    """Return the outputs at the beginning and after each of `steps` steps, and end the simulation."""
    series: dict[str, list[Any]] = {name: [] for name in recorded}
    for n in range(steps + 1):
        if n:
            simulation.step()
        for name in recorded:
            series[name].append(getattr(simulation, f"get_{kinds[name]}")(name.replace(".", "::", 1)))
    simulation.terminate()
    return series
