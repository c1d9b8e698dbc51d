"""Runs an SSP archive with other tools. Each function is run in a process of its own."""

from __future__ import annotations

from typing import Any


def exported(
    scenario: str, archive: str, flavour: str = "native", connectors: bool = False, integers: bool = False
) -> list[str]:
    """Write a scenario (TOML) as an archive; return the names in it."""
    import zipfile

    import amb_cosim
    from amb_cosim.scenario.scenario import parse_scenario

    amb_cosim.export_ssp(
        parse_scenario(scenario, "rig"), archive, flavour=flavour, connectors=connectors, integers=integers
    )
    return zipfile.ZipFile(archive).namelist()


def with_this_project(
    scenario: str, flavour: str = "native", set: dict[str, Any] | None = None, nanoseconds: bool = False
) -> dict[str, list[Any]]:
    """Return what a run of the scenario records. With `nanoseconds` steps are those of libcosim (`system/peers.py`)."""
    import amb_cosim
    from amb_cosim.cosim.component import FmuComponent
    from amb_cosim.scenario.scenario import parse_scenario

    if nanoseconds:
        step = FmuComponent.step

        def step_between_points(component: Any, time: float, step_size: float) -> None:
            begin, end = (round(t * 1e9) / 1e9 for t in (time, time + step_size))
            step(component, begin, end - begin)

        FmuComponent.step = step_between_points

    result = amb_cosim.run(parse_scenario(scenario, "rig"), flavour=flavour, set=set, loop="plain", progress=False)
    assert result.outcome.failure is None, result.outcome.failure
    return {name: values.values.tolist() for name, values in result.dataset.items()}


def read_back(archive: str, set: dict[str, Any] | None = None) -> dict[str, list[Any]]:
    """Return what a run of the archive by this project records."""
    import amb_cosim

    result = amb_cosim.simulate(archive, set=set)
    assert result.outcome.failure is None, result.outcome.failure
    return {"time": result.dataset.time.values.tolist()} | {n: v.values.tolist() for n, v in result.dataset.items()}


def with_libcosim(archive: str, recorded: list[str], steps: int) -> dict[str, list[Any]]:
    """Return the recorded outputs from point 1 on, by libcosim, which reads step and parameters from the archive."""
    from libcosimpy.CosimEnums import CosimVariableType
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
    from libcosimpy.CosimObserver import CosimObserver

    log_output_level(CosimLogLevel.WARNING)
    execution = CosimExecution.from_ssp_file(archive)
    components = sorted({name.partition(".")[0] for name in recorded})
    variables = {
        f"{name}.{v.name.decode()}": (index, v.reference, CosimVariableType(v.type).name.lower())
        for name in components
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


def with_fmpy(archive: str, stop_time: float, step_size: float) -> dict[str, list[Any]]:
    """Return the outputs that are connectors, by FMPy, which ignores parameter bindings."""
    from fmpy.ssp.simulation import simulate_ssp

    found = simulate_ssp(archive, stop_time=stop_time, step_size=step_size)
    return {name: found[name].tolist() for name in found.dtype.names}


def with_ecos(archive: str, recorded: list[str], steps: int, step_size: float) -> dict[str, list[Any]]:
    """Return the recorded outputs by ecos, which takes wiring and FMUs from the archive."""
    import ctypes
    import sys
    import zipfile
    from contextlib import suppress
    from pathlib import Path

    import fmpy

    with suppress(OSError):  # ecos needs oneTBB: the wheel's, which no loader finds, or else the system's
        ctypes.CDLL(f"{sys.prefix}/lib/libtbb.so.12", ctypes.RTLD_GLOBAL)
    from ecospy import EcosSimulation

    zipfile.ZipFile(archive).extractall("unpacked")
    kinds = {
        f"{file.stem}.{v.name}": {"Real": "real", "Integer": "integer", "Enumeration": "integer", "Boolean": "bool"}[
            v.type
        ]
        for file in Path("unpacked/resources").glob("*.fmu")
        for v in fmpy.read_model_description(str(file)).modelVariables
    }
    series: dict[str, list[Any]] = {name: [] for name in recorded}
    with EcosSimulation(step_size, ssp_path=archive) as simulation:
        simulation.init()
        for n in range(steps + 1):
            if n:
                simulation.step()
            for name in recorded:
                series[name].append(getattr(simulation, f"get_{kinds[name]}")(name.replace(".", "::", 1)))
        simulation.terminate()
    return series
