"""Run this project's master, and one FMU made of all three, to compare with the masters of `benchmarks.peers`.

Each function is run in a process of its own.
"""

from typing import Any


def with_this_project(scenario: str, nanoseconds: bool = False) -> dict[str, Any]:
    """Return results of a scenario, and its system as the functions of `benchmarks.peers` take it.

    With `nanoseconds`, the FMUs get the times that libcosim passes.
    """
    import tomllib

    from amb_cosim.cosim.run.options import RunOptions
    from amb_cosim.scenario.prepare_run import prepare_run
    from amb_cosim.scenario.scenario import make_scenario
    from amb_cosim.scenario.simulation import execute
    from benchmarks.system import plain_system
    from tests.support.nanoseconds import step_between_nanoseconds

    if nanoseconds:
        step_between_nanoseconds()

    prepared = prepare_run(make_scenario(tomllib.loads(scenario), "peers"))
    result = execute(prepared, RunOptions(loop="plain"))  # it alone calls the Python method replaced above
    assert result.outcome.failure is None, result.outcome.failure
    recorded = {name: s.values.tolist() for name, s in result.dataset.items() if name not in prepared.inputs}
    return {"series": recorded, "system": plain_system(prepared, list(recorded))}


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
    """One FMU made of all by fmucontainer and stepped with fmpy: inside, Gauss-Seidel if `sequential`, else Jacobi.

    The system comes as for `benchmarks.peers`; results are `{component.variable: values}`.
    """
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
            read = container.getInteger if v.type == "Enumeration" else getattr(container, f"get{v.type}")
            series[name] += read([v.valueReference])
    container.terminate()
    container.freeInstance()
    return series
