"""From a model's name, or the path of an FMU, to an extracted FMU; models are built once and cached."""

from __future__ import annotations

import hashlib
import shutil
import tempfile
import zipfile
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Protocol

import numpy as np
import platformdirs
from numpy.typing import NDArray

from amb_cosim.cosim.interface import suggest
from amb_cosim.flavours import Flavour
from fmi_export.build import build_python_fmu, guid_of
from fmi_export.model import Model
from rotor_analysis.rotor import Rotor
from rotor_analysis.rotor_file import load_rotor

Build = Callable[[Model, NDArray[np.float64], Path], Path]
Guid = Callable[[Model, NDArray[np.float64]], str]
Made = tuple[Model, NDArray[np.float64]]


class Source(Protocol):
    """A model and its constants for a rotor, the rig by default, and for the receptances in a file, if it uses them."""

    def __call__(self, rotor: Rotor | None = None, receptances: Path | None = None) -> Made: ...


@dataclass(frozen=True)
class Fmu:
    """An FMU at hand: its archive, the folder it is extracted to, and how it came about."""

    path: Path
    folder: Path
    flavour: str


def _rotor_contact(rotor: Rotor | None = None, receptances: Path | None = None) -> Made:
    from rotor_analysis.plant_data import plant_constants
    from rotor_contact.plant import MODEL

    return MODEL, plant_constants(rotor)


def _amb_actuator(rotor: Rotor | None = None, receptances: Path | None = None) -> Made:
    from amb_actuator.actuator import MODEL

    return MODEL, np.zeros(1)


def _rolac_controller(rotor: Rotor | None = None, receptances: Path | None = None) -> Made:
    """The controller with H of the table in a file, or from the plant on bearings K_b = 1e6 N/m, C_b = 5000 N s/m.

    The plant gives it from 5 to 100 Hz.
    """
    from amb_analysis.controller_data import pack
    from amb_analysis.table_file import read_table
    from rolac_controller.controller import MODEL
    from rotor_analysis.receptance import receptance

    if receptances is not None:
        return MODEL, read_table(receptances, rotor=(rotor or load_rotor()).name).constants()
    speeds = 2.0 * np.pi * np.arange(5.0, 101.0)
    return MODEL, pack(speeds, receptance(speeds, k_b=1e6, c_b=5000.0, rotor=rotor))


CONTROLLER = "rolac_controller"
MODELS: dict[str, Source] = {
    "rotor_contact": _rotor_contact,
    "amb_actuator": _amb_actuator,
    CONTROLLER: _rolac_controller,
}


def build_all(
    folder: Path,
    rotor_file: Path | None = None,
    flavour: Flavour = "python",
    platforms: Iterable[str] | None = None,
    receptances: Path | None = None,
) -> list[Path]:
    """Build the FMU of every model into `folder`, for the rotor in a file or for the rig of the thesis.

    Parameters
    ----------
    folder, rotor_file
        Where the FMUs go, and the rotor they are made for.
    flavour, platforms
        Which flavour, and what a native FMU runs on; see `build_native_fmu`.
    receptances
        Table file that the controller gets its H from; by default H is the model's.

    Raises
    ------
    ValueError
        If the rotor file is wrong, or has not the bearings and planes that the plant shows, if the table cannot be used
        or is of another rotor, or the platforms or the compiler of native FMUs are not what they must be.
    """
    if platforms is not None and flavour != "native":
        raise ValueError("platforms are chosen for native FMUs alone; those of flavour python run where PythonFMU does")
    rotor = _read(rotor_file)
    models = [source(rotor, receptances) for source in MODELS.values()]  # all of them, before anything is written
    build, _ = _flavoured(flavour, platforms)
    return [build(model, constants, folder) for model, constants in models]


def _read(rotor_file: Path | None) -> Rotor | None:
    return None if rotor_file is None else load_rotor(rotor_file)


def _flavoured(flavour: Flavour, platforms: Iterable[str] | None = None) -> tuple[Build, Guid]:
    """What builds an FMU of that flavour, and what names it."""
    if flavour == "python":
        return build_python_fmu, guid_of
    from fmi_export.native.package import build_native_fmu, native_guid

    return partial(build_native_fmu, platforms=platforms), native_guid


def provide(
    fmu: str, flavour: Flavour = "python", rotor_file: Path | None = None, receptances: Path | None = None
) -> Fmu:
    """The FMU for a component: a model's name, or the path of an FMU, whose flavour is what it is.

    Raises
    ------
    ValueError
        If it is neither, or the model cannot be made for this rotor and this table; see `build_all`.
    """
    if fmu in MODELS:
        return ensure_built(fmu, flavour, rotor_file, receptances)
    path = Path(fmu)
    if not path.is_file():
        raise ValueError(f"no FMU {fmu!r}; it must be a path or one of {', '.join(MODELS)}")
    if not zipfile.is_zipfile(path):
        raise ValueError(f"{fmu} is no FMU: it is no zip archive")
    return extracted(path)


def ensure_built(
    name: str, flavour: Flavour = "python", rotor_file: Path | None = None, receptances: Path | None = None
) -> Fmu:
    """The FMU of a model of this project, built and extracted into the user's cache if it is not there yet.

    A native one is built for this machine. Its folder is named by the guid, so it changes when interface, code or
    constants do, and what numba compiles is found again by the next run.

    Raises
    ------
    ValueError
        If there is no such model, or it cannot be made for this rotor and this table; see `build_all`.
    """
    if name not in MODELS:
        raise ValueError(f"no model {name!r}; {suggest(name, MODELS)}")
    model, constants = MODELS[name](_read(rotor_file), receptances)
    build, guid = _flavoured(flavour)
    home = cache_folder() / f"{name}-{guid(model, constants).strip('{}')}"

    def fill(stage: Path) -> None:
        _unzip(build(model, constants, stage), stage / "extracted")

    _appear(home, fill)
    return Fmu(home / f"{name}.fmu", home / "extracted", flavour)


def extracted(path: Path) -> Fmu:
    """An FMU file extracted into the user's cache, named by its content."""
    digest = hashlib.sha256(path.read_bytes()).hexdigest()[:32]
    home = cache_folder() / f"{path.stem}-{digest}"
    _appear(home, lambda stage: _unzip(path, stage / "extracted"))
    return Fmu(path, home / "extracted", "file")


def check_loop(receptances: Path, parameters: Mapping[str, float | None]) -> None:
    """Raise a ValueError if a table was identified in another loop than that of a controller with these parameters."""
    from amb_analysis.table_file import loop_of, read_table

    read_table(receptances, loop=loop_of({name: value for name, value in parameters.items() if value is not None}))


def cache_folder() -> Path:
    """Where built and extracted FMUs are kept."""
    folder = platformdirs.user_cache_path("amb-cosim", appauthor=False)
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def _unzip(archive: Path, folder: Path) -> None:
    with zipfile.ZipFile(archive) as content:
        content.extractall(folder)


def _appear(home: Path, fill: Callable[[Path], None]) -> None:
    """Make the folder `home` whole or not at all; where two processes try, the first one's stays."""
    if home.is_dir():
        return
    stage = Path(tempfile.mkdtemp(prefix=f".{home.name}-", dir=home.parent))
    try:
        fill(stage)
        try:
            stage.rename(home)
        except OSError:
            if not home.is_dir():
                raise
    finally:
        shutil.rmtree(stage, ignore_errors=True)
