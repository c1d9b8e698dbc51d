"""FMUs of the models: the three models of a rotor, or the components of a scenario with the scenario's values."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from amb_cosim.cosim.building.build_target import BuildTarget
from amb_cosim.cosim.choices import Flavour, Fmi
from amb_cosim.cosim.fmu.fmus import build_models
from amb_cosim.export.models import MODELS
from amb_cosim.export.planned import plan_models
from amb_cosim.scenario.rotors import RotorSource, TableSource, table_source
from amb_cosim.scenario.scenario import Scenario
from amb_files.archive import write_archive
from amb_files.checks import as_path


def build(
    folder: str | Path,
    flavour: Flavour = "native",
    rotor: RotorSource = None,
    receptances: TableSource = None,
    platforms: str | Iterable[str] | None = None,
    fmi: Fmi = 2,
    scenario: str | Path | Scenario | None = None,
    arrays: bool = True,
    sources: bool = False,
) -> list[Path]:
    """Write the FMUs of the three models, or of a scenario's components, into a folder and return their paths.

    Parameters
    ----------
    folder
        Folder for the FMUs, created if it is missing.
    flavour, platforms
        `native` FMUs are compiled, for this machine or for the named platforms (`linux64`, `win64`, `darwin64`,
        `aarch64-linux`, `aarch64-darwin`, `wasm32`); `python` FMUs are run by PythonFMU.
    rotor
        Name of a packaged rotor, or a rotor file (TOML); by default the rotor of the scenario or of the packs.
    receptances
        Table with the controller's H: a `ReceptanceTable` or its file. The default is the table of the scenario, or
        else H from the rotor model.
    fmi
        FMI version of native FMUs, 2 or 3; FMUs of flavour python use 2.
    scenario
        Source of the start values of parameters and inputs, and of the step of the default experiment: a `Scenario`,
        the name or TOML file of a scenario, or a system file. Each FMU is then named after its component. Events and
        speed profiles are not included.
    arrays
        Whether FMUs of FMI 3.0 have array variables; otherwise each value has a separate reference.
    sources
        Whether native FMUs include their C code, so that they can be compiled for other targets.

    Raises
    ------
    ValueError
        If a file is invalid or incomplete, the table belongs to another rotor, a component of the scenario is not a
        model, or a platform or the compiler is not available.

    Examples
    --------
    >>> [file.name for file in build("fmus", scenario="compressor_levitated")]
    ['rolac_controller.fmu', 'amb_actuator.fmu', 'rotor_contact.fmu']
    """
    folder, target = as_path("folder", folder), BuildTarget(flavour, platforms, fmi, arrays, sources)
    if scenario is None:
        return build_models(MODELS, folder, target, rotor=rotor, receptances=table_source(receptances))
    from fmi_export.model import with_starts

    prepared = plan_models(scenario, rotor, receptances)
    plan, fmus = prepared.plan, {}
    starts = plan.start_values()
    for component in plan.system.components:
        model, constants = prepared.made[component.name]
        model = with_starts(model, starts[component.name], component.every * plan.step_size)
        fmus[component.name] = target.fmu(model, constants)
    folder.mkdir(parents=True, exist_ok=True)
    return [write_archive(folder / f"{name}.fmu", fmu) for name, fmu in fmus.items()]
