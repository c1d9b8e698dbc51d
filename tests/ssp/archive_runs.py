"""Runs an SSP archive with other tools. Each function is run in a separate process."""

from typing import Any


def exported(
    scenario: str, archive: str, flavour: str = "native", connectors: bool = False, integers: bool = False
) -> list[str]:
    """Write a scenario (TOML) as an archive; return the names in it."""
    import tomllib
    import zipfile

    import amb_cosim
    from amb_cosim.scenario.scenario import make_scenario

    case = make_scenario(tomllib.loads(scenario), "rig")
    amb_cosim.export_ssp(case, archive, flavour=flavour, connectors=connectors, integers=integers)
    return zipfile.ZipFile(archive).namelist()


def with_this_project(scenario: str, nanoseconds: bool = False) -> dict[str, list[Any]]:
    """Return the values of a run of the scenario at its steps. With `nanoseconds` steps are those of libcosim."""
    import tomllib

    import amb_cosim
    from amb_cosim.cosim.record.signals import AT_STEPS
    from amb_cosim.scenario.scenario import make_scenario
    from tests.support.nanoseconds import step_between_nanoseconds

    if nanoseconds:
        step_between_nanoseconds()

    case = make_scenario(tomllib.loads(scenario), "rig")
    result = amb_cosim.run(case, loop="plain", progress=False)
    assert result.outcome.failure is None, result.outcome.failure
    return {name: v.values.tolist() for name, v in result.dataset.items() if not str(name).endswith(AT_STEPS)}


def read_back(archive: str) -> dict[str, list[Any]]:
    """Return what a run of the archive by this project records at its samples."""
    import amb_cosim
    from amb_cosim.cosim.record.signals import AT_STEPS

    result = amb_cosim.simulate(archive)
    assert result.outcome.failure is None, result.outcome.failure
    sampled = {n: v.values.tolist() for n, v in result.dataset.items() if not str(n).endswith(AT_STEPS)}
    return {"time": result.dataset.time.values.tolist()} | sampled


def with_libcosim(archive: str, recorded: list[str], steps: int) -> dict[str, list[Any]]:
    """Return the recorded outputs from point 1 on, by libcosim, which reads step and parameters from the archive."""
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimLogging import CosimLogLevel, log_output_level

    from benchmarks.peers import outputs_by_libcosim

    log_output_level(CosimLogLevel.WARNING)
    return outputs_by_libcosim(CosimExecution.from_ssp_file(archive), recorded, steps)


def ends_in_libcosim(archive: str, steps: int) -> dict[str, bool]:
    """Return whether libcosim takes so many steps, and whether it then reports an error."""
    from libcosimpy.CosimEnums import CosimExecutionState
    from libcosimpy.CosimExecution import CosimExecution

    execution = CosimExecution.from_ssp_file(archive)
    goes_on = bool(execution.step(steps))
    return {"goes_on": goes_on, "is_error": execution.status().state == CosimExecutionState.ERROR.value}


def with_fmpy(archive: str, stop_time: float, step_size: float) -> dict[str, list[Any]]:
    """Return the outputs that are connectors, by FMPy, which ignores parameter bindings."""
    from fmpy.ssp.simulation import simulate_ssp

    result = simulate_ssp(archive, stop_time=stop_time, step_size=step_size)
    return {name: result[name].tolist() for name in result.dtype.names}


def with_ecos(archive: str, recorded: list[str], steps: int, step_size: float) -> dict[str, list[Any]]:
    """Return the recorded outputs by ecos, which takes wiring and FMUs from the archive."""
    import zipfile
    from pathlib import Path

    from benchmarks.peers import kinds_in_ecos, load_tbb, outputs_by_ecos

    load_tbb()
    from ecospy import EcosSimulation

    zipfile.ZipFile(archive).extractall("unpacked")
    kinds = kinds_in_ecos({file.stem: str(file) for file in Path("unpacked/resources").glob("*.fmu")})
    with EcosSimulation(step_size, ssp_path=archive) as simulation:
        simulation.init()
        return outputs_by_ecos(simulation, kinds, recorded, steps)
