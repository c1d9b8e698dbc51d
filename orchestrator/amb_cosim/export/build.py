"""The models as FMUs, one each: the three of the rotor, or the components of a scenario with its values."""

from __future__ import annotations

import shutil
from collections.abc import Iterable
from functools import partial
from pathlib import Path

from amb_cosim.cosim.basics.build_target import BuildTarget
from amb_cosim.cosim.basics.choices import Flavour, Fmi
from amb_cosim.cosim.fmu.fmus import build_models
from amb_cosim.export.models import MODELS
from amb_cosim.export.planned import plan_models
from amb_cosim.scenario.scenario import Scenario
from amb_files.atomic import write_atomically
from amb_files.temporary_folders import temporary_folder


def build(
    folder: str | Path,
    flavour: Flavour = "native",
    rotor: str | Path | None = None,
    receptances: str | Path | None = None,
    platforms: Iterable[str] | None = None,
    fmi: Fmi = 2,
    scenario: str | Path | Scenario | None = None,
    arrays: bool = True,
    sources: bool = False,
) -> list[Path]:
    """Write the FMUs of the three models, or of a scenario's components, into a folder and return their paths.

    Parameters
    ----------
    folder
        Where the FMUs go; made if it is missing.
    flavour, platforms
        `native` FMUs are compiled, for this machine or for the platforms named (`linux64`, `win64`, `darwin64`,
        `aarch64-linux`, `aarch64-darwin`, `wasm32`); `python` ones are run by PythonFMU.
    rotor
        Name of a rotor of a pack, or rotor file (TOML); the scenario's, or the packs' default, without.
    receptances
        Table file that the controller gets its H from; the scenario's, or the rotor model's, by default.
    fmi
        Version of FMI of native FMUs, 2 or 3; FMUs of flavour python have 2.
    scenario
        Whose parameters and first inputs are the start values: a `Scenario`, a name or the path of a TOML file, or of
        a system file. Each FMU is then called like its component. Events and what changes the speed are not in them.
    arrays
        Whether FMUs of FMI 3.0 have array variables; without, each value has a reference of its own.
    sources
        Whether native FMUs hold their C code too, for targets that none is compiled for here.

    Raises
    ------
    ValueError
        If a file is wrong, or has not what the plant's interface shows, if the table is of another rotor, if a
        component of the scenario is no model, or the platforms or the compiler are not what they must be.
    """
    target = BuildTarget(flavour, platforms, fmi, arrays, sources)
    if scenario is not None:
        return _build_planned(Path(folder), target, scenario, rotor, receptances)
    table = None if receptances is None else Path(receptances)
    return build_models(MODELS, Path(folder), target, rotor=rotor, receptances=table)


def _build_planned(
    folder: Path,
    target: BuildTarget,
    scenario: str | Path | Scenario,
    rotor: str | Path | None,
    receptances: str | Path | None,
) -> list[Path]:
    """Write the FMU of each component of a scenario, with its values to start with."""
    from fmi_export.model import with_starts

    planned = plan_models(scenario, rotor, receptances)
    starts = planned.plan.start_values()
    models = {name: (with_starts(model, starts[name]), constants) for name, (model, constants) in planned.made.items()}
    with temporary_folder() as temporary:
        built = {name: target.build(model, constants, temporary / name) for name, (model, constants) in models.items()}
        folder.mkdir(parents=True, exist_ok=True)
        paths = {name: folder / f"{name}.fmu" for name in built}
        for name, path in paths.items():
            write_atomically(path, partial(shutil.copyfile, built[name]))
    return list(paths.values())
