"""Finds FMUs by the name of a model or by path, and extracts them; models are built once and cached.

Entry points name models: a distribution that declares

    [project.entry-points."amb_cosim.models"]
    lag_sensor = "lag_sensor.model:source"

adds the model `lag_sensor`. `source(**options)` returns the `Model` and its constants; it uses the options (`rotor`,
`receptances`, ...) that are among its parameters. Making a model imports its code and computes its constants; for a
source declared with `made_from`, this is skipped if the FMU already exists.
"""

from __future__ import annotations

import hashlib
import inspect
import json
import logging
import sysconfig
from collections.abc import Callable, Iterable, Mapping
from contextlib import nullcontext, suppress
from dataclasses import dataclass, is_dataclass
from functools import cache, cached_property
from importlib.metadata import EntryPoint, version
from importlib.util import find_spec
from os import PathLike, fspath
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol, TypeVar

from amb_cosim.cosim.building.build_target import BuildTarget
from amb_cosim.cosim.building.cache import is_first_loading, note_use, unpacked
from amb_cosim.cosim.choices import Flavour
from amb_cosim.cosim.processes.blas import one_blas_thread
from amb_files.archive import is_unpacked, unpack
from amb_files.atomic import create_atomically
from amb_files.packs import entry_points_of
from amb_files.suggestions import suggest
from amb_files.toml import read_bytes
from amb_files.user_cache import user_cache
from array_types import Array
from fmi_export.compiling import compiling

if TYPE_CHECKING:
    from fmi_export.model import Model

log = logging.getLogger(__name__)

GROUP = "amb_cosim.models"

# Models that are made from a separate file, by the suffix of the file, which a system names in place of an FMU.
MADE_FROM_FILE = {".toml": "linear_controller", ".npz": "linear_controller", ".mat": "linear_controller"}

# Suffixes of the files of a package on which the FMUs made from it depend.
CODE = (".py", ".c", ".h", ".ll", ".toml", ".md", ".svg", ".png")


class MadeModel(Protocol):
    """A Python object that stands for an FMU in a system; its `repr` identifies it."""

    @property
    def model(self) -> str:
        """Name of the model whose source takes this object as its `file`."""

    def __hash__(self) -> int:
        """Return the hash of the object, because models made from it may be cached."""


FmuSource = str | MadeModel
"""The name of a model, the file from which a model is made, the path of an FMU, or an object that represents one."""

Source = Callable[..., "tuple[Model, Array]"]
S = TypeVar("S", bound=Source)


@dataclass(frozen=True)
class Fmu:
    """An FMU: its archive, the folder to which it is extracted, and its flavour (`file` for an FMU file)."""

    path: Path
    folder: Path
    flavour: str

    @cached_property
    def layout(self) -> dict[str, Any] | None:
        """Source of the FMU's interface if this project exported the FMU, otherwise None."""
        file = self.folder / "resources" / "layout.json"
        return json.loads(file.read_text(encoding="utf-8")) if file.is_file() else None

    @cached_property
    def linear_state(self) -> dict[str, Any] | None:
        """The linear part of the FMU's state (`fmi_export.linear_state`), and the state's size; None if unknown."""
        file = self.folder / "resources" / "linear_state.json"
        return json.loads(file.read_text(encoding="utf-8")) if file.is_file() else None


def made_from(*packages: str, **files: Callable[[Any], Path]) -> Callable[[S], S]:
    """Declare the packages whose code, with the source's file, determines what a source returns for its options.

    `files` maps names of options to functions that return the file for an option's value. A value that is neither a
    string nor a path is identified by its `repr`, which must therefore be complete.
    """

    def declare(source: S) -> S:
        source.packages, source.files = packages, files  # type: ignore[attr-defined]
        return source

    return declare


@cache
def models() -> Mapping[str, EntryPoint]:
    """Return the models of this project and of other installed distributions, by name."""
    return {point.name: point for point in entry_points_of(GROUP)}


def as_fmu(fmu: FmuSource | PathLike[str]) -> FmuSource:
    """Return the source of an FMU; convert a path to text."""
    return fspath(fmu) if isinstance(fmu, PathLike) else fmu


def fmu_name(fmu: FmuSource) -> str:
    """Return the name of a model or of a file, for messages."""
    return Path(fmu).name if isinstance(fmu, str) else fmu.model


def model_of(fmu: FmuSource) -> str | None:
    """Return the name of a component's model, even if the model is made from a file; None for the path of an FMU."""
    if not isinstance(fmu, str):
        return fmu.model
    return fmu if fmu in models() else MADE_FROM_FILE.get(Path(fmu).suffix)


def is_model(fmu: FmuSource) -> bool:
    """Return whether a component of a system is a model (given by a name, a file or an object) and not an FMU file."""
    return model_of(fmu) is not None


def is_placeholder(fmu: FmuSource) -> bool:
    """Return whether a component is given only by the name of a model that must be made from a file."""
    return fmu in MADE_FROM_FILE.values()


def is_made_from_file(fmu: FmuSource) -> bool:
    """Return whether a component is a model that is made from a separate file, or from an object in place of a file."""
    return model_of(fmu) in MADE_FROM_FILE.values()


def _resolved(fmu: FmuSource, options: Mapping[str, Any]) -> tuple[str, dict[str, Any]]:
    """Return the name of a model and its options, including the file or object that the model is made from."""
    name = model_of(fmu)
    if name is None or name == fmu:
        return str(fmu), dict(options)
    return name, {**options, "file": Path(fmu) if isinstance(fmu, str) else fmu}


def model_source(name: FmuSource, **options: Any) -> tuple[Model, Array]:
    """Return a model, given by name or by the object that it is made from, and its constants for these options.

    Raises
    ------
    ValueError
        If no such model exists, or it cannot be made with these options.
    """
    model, options = _resolved(name, options)
    return _made(_source(model), options)


def build_models(
    names: Iterable[str],
    folder: Path,
    target: BuildTarget,
    **options: Any,
) -> list[Path]:
    """Make models as `model_source` does, write their FMUs into `folder`, and return the paths.

    Nothing is written unless all can be built.
    """
    made = [model_source(name, **options) for name in names]
    return [target.build(model, constants, folder) for model, constants in made]


def fmu_with_starts(
    name: FmuSource, target: BuildTarget, starts: Mapping[str, float], step_size: float, **options: Any
) -> bytes:
    """Return the FMU of a model with these start values of parameters and inputs, and with this default step (s).

    Raises
    ------
    ValueError
        If no model or variable has this name, a value is out of its range, or the model cannot be made with these
        options.
    """
    from fmi_export.model import with_starts

    model, constants = model_source(name, **options)
    return target.fmu(with_starts(model, starts, step_size), constants)


def ingredients(fmu: FmuSource, **options: Any) -> dict[str, Any]:
    """Return the files and objects that a component's model is made from, by option of the model, or the FMU's file."""
    if not is_model(fmu):
        return {"FMU": Path(str(fmu))}
    name, options = _resolved(fmu, options)
    source, result = _source(name), {}
    for option in inspect.signature(source).parameters:
        with suppress(ValueError):  # no pack provides a default rotor
            value = _with_file(source, option, options.get(option))
            if is_dataclass(value) or (isinstance(value, str | Path) and Path(value).is_file()):
                result[option] = value
    return result


def provide(fmu: FmuSource, flavour: Flavour = "native", **options: Any) -> Fmu:
    """Return the FMU of a model (given by name or file), built if needed, or the FMU file at a path.

    Raises
    ------
    ValueError
        If `fmu` is neither a model nor a file, or the model cannot be made with these options.
    """
    if is_model(fmu):
        return ensure_built(fmu, flavour, **options)
    path = Path(str(fmu))
    if not path.is_file():
        raise ValueError(f"no FMU {fmu!r}; it must be a path or one of {', '.join(models())}")
    return Fmu(path, unpacked(path, f"FMU {fmu}"), "file")


def note_first_loading(fmu: Fmu) -> None:
    """Log a notice if an FMU file is loaded here for the first time; call this function before loading the FMU."""
    if fmu.flavour == "file" and is_first_loading(fmu.folder):
        log.warning(
            "%s runs here for the first time: an FMU is a program that runs with all your permissions", fmu.path
        )


def ensure_built(fmu: FmuSource, flavour: Flavour = "native", **options: Any) -> Fmu:
    """Return the FMU of a model; build and extract it into the user's cache unless a complete copy is already there.

    The FMU is built for this machine. The name of its folder contains a digest of its sources, which changes with the
    interface, the code and the constants.

    Raises
    ------
    ValueError
        If no such model exists, or it cannot be made with these options.
    """
    name, options = _resolved(fmu, options)
    home = user_cache() / f"{name}-{_key(_source(name), BuildTarget(flavour), options)}"

    def fill(stage: Path) -> None:
        built = BuildTarget(flavour).build(*model_source(name, **options), stage)
        unpack(built, stage / "extracted", f"the FMU of {name}")

    def is_whole(folder: Path) -> bool:
        return any(is_unpacked(archive, folder / "extracted") for archive in folder.glob("*.fmu"))

    is_new = not home.is_dir()
    with compiling(home, f"the FMU of {name}") if is_new else nullcontext():
        create_atomically(home, fill, is_whole)
    note_use(home, is_new)
    return Fmu(next(home.glob("*.fmu")), home / "extracted", flavour)


def options_of(fmu: FmuSource) -> frozenset[str]:
    """Return the names of the options with which a model can be made; an FMU file has no options."""
    name = model_of(fmu)
    if name is None:
        return frozenset()
    named = inspect.signature(_source(name)).parameters.values()
    return frozenset(p.name for p in named if p.kind in (p.POSITIONAL_OR_KEYWORD, p.KEYWORD_ONLY)) - {"file"}


def _source(name: str) -> Source:
    if name not in models():
        raise ValueError(f"no model {name!r}; {suggest(name, models())}")
    source: Source = models()[name].load()
    return source


def _made(source: Source, options: Mapping[str, Any]) -> tuple[Model, Array]:
    """Return a model and its constants, which are the same to the last bit for any number of threads."""
    import scipy.linalg  # noqa: F401  # which has a BLAS, to be limited, too

    with one_blas_thread():
        made: tuple[Model, Array] = source(**options)
    return made


def _key(source: Source, target: BuildTarget, options: Mapping[str, Any]) -> str:
    """Return an identifier that depends on everything that an FMU is made from."""
    packages: tuple[str, ...] | None = getattr(source, "packages", None)
    if packages is None:
        return target.guid(*_made(source, options)).strip("{}")
    used = {name: options.get(name) for name in inspect.signature(source).parameters}
    facts = [source.__qualname__, target.flavour, sysconfig.get_platform(), *_versions()]
    sha = hashlib.sha256(repr(facts).encode() + _content(Path(inspect.getfile(source)), "source"))
    for name, option in used.items():
        value = _with_file(source, name, option)
        is_file = isinstance(value, str | Path) and Path(value).is_file()
        sha.update(name.encode() + (_content(Path(value), name) if is_file else repr(value).encode()))
    for package in (*packages, "amb_files", "fmi_export"):
        sha.update(_code(package))
    return sha.hexdigest()[:32]


@cache
def _versions() -> tuple[str, str]:
    """Return the versions of the packages that compute constants; reading them takes milliseconds."""
    return version("numpy"), version("scipy")


def _with_file(source: Source, name: str, option: Any) -> Any:
    """Return the file that an option's value names if the source declares files for this option, or else the value."""
    files = getattr(source, "files", {})
    return files[name](option) if name in files and isinstance(option, str | Path | None) else option


def _content(file: Path, kind: str) -> bytes:
    """Return the digest of a file; raises ValueError if it cannot be read."""
    return hashlib.sha256(read_bytes(file, f"{kind} file {file}")).digest()


@cache
def _code(package: str) -> bytes:
    """Return the digest of the code of an installed package."""
    spec = find_spec(package)
    if spec is None or spec.origin is None:
        raise ValueError(f"package {package} is not installed")
    folder, sha = Path(spec.origin).parent, hashlib.sha256()
    for file in sorted(folder.rglob("*")):
        if file.suffix in CODE:
            sha.update(file.relative_to(folder).as_posix().encode() + b"\0" + file.read_bytes() + b"\0")
    return sha.digest()
