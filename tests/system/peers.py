"""The same system under masters that others wrote. Each function is run in a process of its own.

All but the first take the system as plain data, and give back `{component.variable: values}` with a value for each
communication point:

- `fmus`: path of each component's FMU, in Gauss-Seidel order;
- `start`: values of parameters and unconnected inputs, `{component: {variable: value}}`;
- `connections`: pairs of ends `component.variable`, output first;
- `recorded`: outputs, `component.variable`;
- `step_size` (s), `steps`, and how many of them a step of a component spans, `every`.
"""

from __future__ import annotations

from typing import Any


def with_this_project(scenario: str, nanoseconds: bool = False) -> dict[str, Any]:
    """Results of a scenario, and its system as the others take it.

    With `nanoseconds`, the FMUs get the times that libcosim gives: a point is a whole number of nanoseconds, and a
    step the difference of two points, which deviates from a constant in the last bits.
    """
    from orchestrator.component import FmuComponent
    from orchestrator.scenario import parse_scenario
    from orchestrator.simulation import prepare, run

    if nanoseconds:
        step = FmuComponent.step

        def step_between_points(component: Any, time: float, step_size: float) -> None:
            begin, end = (round(t * 1e9) / 1e9 for t in (time, time + step_size))
            step(component, begin, end - begin)

        FmuComponent.step = step_between_points

    prepared = prepare("peers", parse_scenario(scenario, "peers"))
    outcome = run(prepared, loop="plain")  # the compiled loop does not go through the Python method replaced above
    assert outcome.failure is None, outcome.failure
    plan, system = prepared.plan, prepared.plan.system
    series = {name: s.values.tolist() for name, s in outcome.dataset.items() if name not in plan.exogenous}
    targets = {s.name: s.targets for s in system.signals}
    given = {f"{c}.{v}": value for c, values in plan.start.items() for v, value in values.items()}
    given |= {end: value for name, value in plan.exogenous.items() for end in targets.get(name, (name,))}
    start: dict[str, dict[str, Any]] = {c.name: {} for c in system.components}
    for end, value in given.items():
        component, variable = system.split(end)
        kind = system.port(end, prepared.interfaces).type
        start[component][variable] = {"Real": float, "Integer": int, "Boolean": bool}[kind](value)
    return {
        "series": series,
        "system": {
            "fmus": {c.name: str(prepared.fmus[c.name].path) for c in system.components},
            "start": start,
            "connections": [[link.source, link.target] for link in system.connections],
            "recorded": list(series),
            "step_size": plan.step_size,
            "steps": plan.last,
            "every": {c.name: c.every for c in system.components},
        },
    }


def with_libcosim(
    fmus: dict[str, str],
    start: dict[str, dict[str, Any]],
    connections: list[list[str]],
    recorded: list[str],
    step_size: float,
    steps: int,
    every: dict[str, int],
) -> dict[str, list[Any]]:
    """libcosim's fixed-step algorithm: Jacobi. It initialises in its first step, so the results begin at point 1."""
    from pathlib import Path
    from xml.etree.ElementTree import Element, ElementTree, SubElement

    from libcosimpy.CosimEnums import CosimVariableType
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
    from libcosimpy.CosimObserver import CosimObserver

    schema = "http://opensimulationplatform.com/MSMI/OSPSystemStructure"
    root = Element("OspSystemStructure", xmlns=schema, version="0.1")
    SubElement(root, "StartTime").text = "0.0"
    SubElement(root, "BaseStepSize").text = repr(step_size)
    SubElement(root, "Algorithm").text = "fixedStep"
    simulators, links = SubElement(root, "Simulators"), SubElement(root, "Connections")
    for name, path in fmus.items():
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
    variables = {
        f"{name}.{v.name.decode()}": (index, v.reference, CosimVariableType(v.type).name.lower())
        for name in fmus
        for index in [execution.slave_index_from_instance_name(name)]
        for v in execution.slave_variables(index)
    }
    observer = CosimObserver.create_last_value()
    assert execution.add_observer(observer)
    series: dict[str, list[Any]] = {name: [] for name in recorded}
    for _ in range(steps):
        assert execution.step()
        for name in recorded:
            index, reference, kind = variables[name]
            series[name] += getattr(observer, f"last_{kind}_values")(index, [reference])
    return series


def with_ecos(
    fmus: dict[str, str],
    start: dict[str, dict[str, Any]],
    connections: list[list[str]],
    recorded: list[str],
    step_size: float,
    steps: int,
    every: dict[str, int],
) -> dict[str, list[Any]]:
    """ecos's fixed-step algorithm: Jacobi, with one step for all.

    It has a longer step for single components too, but shows their outputs before that step has passed.
    """
    import ctypes
    import sys
    from contextlib import suppress

    import fmpy

    with suppress(OSError):  # ecos needs oneTBB: the wheel's, which no loader finds, or else the system's
        ctypes.CDLL(f"{sys.prefix}/lib/libtbb.so.12", ctypes.RTLD_GLOBAL)
    from ecospy import EcosSimulation, EcosSimulationStructure

    assert set(every.values()) == {1}
    kinds = {
        f"{name}.{v.name}": {"Real": "real", "Integer": "integer", "Boolean": "bool"}[v.type]
        for name, path in fmus.items()
        for v in fmpy.read_model_description(path).modelVariables
    }
    series: dict[str, list[Any]] = {name: [] for name in recorded}
    with EcosSimulationStructure() as structure:
        for name, path in fmus.items():
            structure.add_model(name, path)
        for source, target in connections:
            connect = {"real": structure.make_real_connection, "integer": structure.make_int_connection}[kinds[source]]
            connect(source.replace(".", "::", 1), target.replace(".", "::", 1))
        values = {f"{c}::{variable}": value for c, given in start.items() for variable, value in given.items()}
        structure.add_parameter_set("start", values)
        with EcosSimulation(step_size, structure=structure) as simulation:
            assert simulation.init(parameter_set="start")
            for n in range(steps + 1):
                if n:
                    simulation.step()
                for name in recorded:
                    series[name].append(getattr(simulation, f"get_{kinds[name]}")(name.replace(".", "::", 1)))
            simulation.terminate()
    return series


def in_a_container(
    fmus: dict[str, str],
    start: dict[str, dict[str, Any]],
    connections: list[list[str]],
    recorded: list[str],
    step_size: float,
    steps: int,
    every: dict[str, int],
    sequential: bool,
) -> dict[str, list[Any]]:
    """One FMU made of all by fmucontainer and stepped with fmpy: inside, Gauss-Seidel if `sequential`, else Jacobi."""
    import json
    from pathlib import Path

    import fmpy
    from fmpy.fmi2 import FMU2Slave
    from fmu_manipulation_toolbox.assembly import Assembly

    assert set(every.values()) == {1}

    def at(end: str) -> list[str]:
        component, _, variable = end.partition(".")
        return [f"{component}.fmu", variable]

    assembly = {
        "name": "container.fmu",
        "step_size": step_size,
        "sequential": sequential,
        "auto_link": False,
        "auto_input": False,
        "auto_output": False,
        "path": {f"{name}.fmu": path for name, path in fmus.items()},
        "fmu": [f"{name}.fmu" for name in fmus],
        "link": [[*at(source), *at(target)] for source, target in connections],
        "output": [[*at(name), f"container.{name}"] for name in recorded],
        "start": [[*at(f"{c}.{v}"), value] for c, values in start.items() for v, value in values.items()],
    }
    Path("container.json").write_text(json.dumps(assembly), encoding="utf-8")
    Assembly("container.json", fmu_directory=Path.cwd()).make_fmu()

    description = fmpy.read_model_description("container.fmu")
    variables = {v.name.removeprefix("container."): v for v in description.modelVariables if v.causality == "output"}
    container = FMU2Slave(
        guid=description.guid,
        unzipDirectory=fmpy.extract("container.fmu", Path("container").absolute()),
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName="container",
    )
    container.instantiate()
    container.setupExperiment(startTime=0.0)
    container.enterInitializationMode()
    container.exitInitializationMode()
    series: dict[str, list[Any]] = {name: [] for name in recorded}
    for n in range(steps + 1):
        if n:
            container.doStep((n - 1) * step_size, step_size)
        for name in recorded:
            v = variables[name]
            series[name] += getattr(container, f"get{v.type}")([v.valueReference])
    container.terminate()
    container.freeInstance()
    return series
