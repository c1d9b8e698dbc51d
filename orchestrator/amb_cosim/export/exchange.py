"""Export of scenarios as SSP archives."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path

from amb_cosim.cosim.building.build_target import BuildTarget
from amb_cosim.cosim.choices import Flavour
from amb_cosim.cosim.run.options import RunOptions
from amb_cosim.cosim.system.values import Raw
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.rotors import RotorSource, TableSource
from amb_cosim.scenario.scenario import Scenario, as_scenario
from amb_files.checks import as_path, require_given


def export_ssp(
    scenario: str | Path | Scenario,
    path: str | Path,
    *,
    set: Mapping[str, Raw] | None = None,
    until: Raw | None = None,
    rotor: RotorSource = None,
    receptances: TableSource = None,
    flavour: Flavour = "native",
    platforms: str | Iterable[str] | None = None,
    connectors: bool = False,
    integers: bool = False,
) -> Path:
    """Write a scenario with its FMUs as an SSP 1.0 archive and return its path.

    Parameters
    ----------
    scenario, set, until, rotor, receptances, flavour
        As for `amb_cosim.run`.
    path
        Path of the archive.
    platforms
        Platforms of the archive's FMUs; by default this machine. See `amb_cosim.build`.
    connectors, integers
        Whether signals and changing inputs become connectors of the system, and whether Enumerations become Integers;
        see `cosim.ssp.export_ssp`.

    Raises
    ------
    ValueError
        If the scenario, a value or a file is invalid.

    Examples
    --------
    >>> export_ssp("compressor_levitated", "compressor.ssp").name
    'compressor.ssp'
    """
    from amb_cosim.cosim import ssp

    require_given("scenario", scenario)
    path = as_path("path", path)
    scenario = as_scenario(scenario, rotor, receptances)
    prepared = prepare_run(scenario, set, until, options=RunOptions(flavour=flavour))
    return ssp.export_ssp(
        path,
        prepared,
        name=scenario.name,
        target=BuildTarget(flavour, platforms),
        connectors=connectors,
        integers=integers,
        **prepared.assembly.options,
    )
