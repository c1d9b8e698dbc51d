"""Finds FMUs by the name of a model or by path, and extracts them; models are built once and cached.

Models are found by entry points: a distribution that declares

    [project.entry-points."amb_cosim.models"]
    lag_sensor = "lag_sensor.model:source"

adds the model `lag_sensor`. `source(**options)` returns the `Model` and its constants; of the options (`rotor`,
`receptances`, ...) it uses those that it knows.
"""

from __future__ import annotations

import hashlib
import zipfile
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cache, partial
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np
import platformdirs
from numpy.typing import NDArray

from amb_files.atomic import create_atomically
from amb_files.suggestions import suggest
from fmi_export.building.identity import guid_of
from fmi_export.building.python_fmu import build_python_fmu
from fmi_export.model import Model

Flavour = Literal["python", "native"]  # run by PythonFMU, or compiled code that needs no Python
FLAVOURS: tuple[Flavour, ...] = get_args(Flavour)

GROUP = "amb_cosim.models"

Constants = NDArray[np.float64]
Source = Callable[..., tuple[Model, Constants]]
Build = Callable[[Model, Constants, Path], Path]
Guid = Callable[[Model, Constants], str]


@dataclass(frozen=True)
class Fmu:
    """An FMU: its archive, the folder it is extracted to, and its flavour, `file` if it was given as one."""

    path: Path
    folder: Path
    flavour: str


@cache
def models() -> Mapping[str, Source]:
    """Return the models of this project and of other installed distributions, by name."""
    return {point.name: partial(_load, point) for point in entry_points(group=GROUP)}


def model_source(name: str, **options: Any) -> tuple[Model, Constants]:
    """Return a model and its constants for these options.

    Raises
    ------
    ValueError
        If there is no such model, or it cannot be made with these options.
    """
    if name not in models():
        raise ValueError(f"no model {name!r}; {suggest(name, models())}")
    return models()[name](**options)


def build_models(
    names: Iterable[str],
    folder: Path,
    flavour: Flavour = "python",
    platforms: Iterable[str] | None = None,
    **options: Any,
) -> list[Path]:
    """Write the FMUs of models into `folder` and return their paths; nothing is written unless all can be made.

    Parameters
    ----------
    names, options
        The models and what they are made for, as for `model_source`.
    flavour, platforms
        Which flavour, and what a native FMU runs on; see `build_native_fmu`.
    """
    made = [model_source(name, **options) for name in names]
    build, _ = _flavoured(flavour, platforms)
    return [build(model, constants, folder) for model, constants in made]


def provide(fmu: str, flavour: Flavour = "python", **options: Any) -> Fmu:
    """Return the FMU of a model, built if need be, or the FMU file at a path.

    Raises
    ------
    ValueError
        If it is neither, or the model cannot be made with these options.
    """
    if fmu in models():
        return ensure_built(fmu, flavour, **options)
    path = Path(fmu)
    if not path.is_file():
        raise ValueError(f"no FMU {fmu!r}; it must be a path or one of {', '.join(models())}")
    if not zipfile.is_zipfile(path):
        raise ValueError(f"{fmu} is no FMU: it is no zip archive")
    return extracted(path)


def ensure_built(name: str, flavour: Flavour = "python", **options: Any) -> Fmu:
    """Return the FMU of a model, built and extracted into the user's cache if it is not there yet.

    A native one is built for this machine. Its folder is named by the guid, so it changes when interface, code or
    constants do, and what numba compiles is found again by the next run.

    Raises
    ------
    ValueError
        If there is no such model, or it cannot be made with these options.
    """
    model, constants = model_source(name, **options)
    build, guid = _flavoured(flavour)
    home = cache_folder() / f"{name}-{guid(model, constants).strip('{}')}"

    def fill(stage: Path) -> None:
        _unzip(build(model, constants, stage), stage / "extracted")

    create_atomically(home, fill)
    return Fmu(home / f"{model.name}.fmu", home / "extracted", flavour)


def extracted(path: Path) -> Fmu:
    """Extract an FMU file into the user's cache, into a folder named by its content."""
    digest = hashlib.sha256(path.read_bytes()).hexdigest()[:32]
    home = cache_folder() / f"{path.stem}-{digest}"
    create_atomically(home, lambda stage: _unzip(path, stage / "extracted"))
    return Fmu(path, home / "extracted", "file")


def cache_folder() -> Path:
    """Return the folder of built and extracted FMUs."""
    folder = platformdirs.user_cache_path("amb-cosim", appauthor=False)
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def _load(point: Any, **options: Any) -> tuple[Model, Constants]:
    source: Source = point.load()
    return source(**options)


def _flavoured(flavour: Flavour, platforms: Iterable[str] | None = None) -> tuple[Build, Guid]:
    """Return the functions that build an FMU of that flavour and give its guid."""
    if flavour == "python":
        if platforms is not None:
            raise ValueError("platforms are for native FMUs alone; those of flavour python run where PythonFMU does")
        return build_python_fmu, guid_of
    from fmi_export.building.native.package import build_native_fmu, native_guid

    return partial(build_native_fmu, platforms=platforms), native_guid


def _unzip(archive: Path, folder: Path) -> None:
    with zipfile.ZipFile(archive) as content:
        content.extractall(folder)
