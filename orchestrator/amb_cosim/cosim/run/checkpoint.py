"""The state of a run before a communication point, from which this run, or another with the same past, can continue.

Its file is a NumPy archive (`.npz`). It contains `head`, a JSON text with the format version, the point, the past and
names; arrays such as `signals`, `points` and `table`; and the serialised states of the FMUs, `state_0` and so on.
Finally, `checksum` is the SHA-256 of all other arrays with their names, types and shapes.
"""

from __future__ import annotations

import hashlib
import json
import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, field_validator
from pydantic_core import from_json

from amb_cosim.cosim.fmu.component import FmuState
from amb_cosim.cosim.system.differences import list_differences, list_other_sources
from amb_files.atomic import write_atomically
from amb_files.checks import as_path
from array_types import Array, Indices

VERSION, MOST_VERSION = 3, 1000


class Head(BaseModel):
    """The form of `head` in a file: fields of `Checkpoint`, and the names of the signals and components."""

    model_config = ConfigDict(strict=True, extra="forbid")

    version: int
    point: int
    step_size: FiniteFloat = Field(gt=0.0)
    start_time: FiniteFloat = 0.0
    past: dict[str, Any]
    sources: dict[str, tuple[str, Any]] = {}
    notice: str
    recorded: tuple[str, ...]
    recorded_each: tuple[str, ...]
    steps_in_row: int = Field(gt=0)
    since: dict[str, int]
    warnings: dict[str, list[str]]
    names: list[str]
    components: list[str]

    @field_validator("past")
    @classmethod
    def _has_parameters_by_component(cls, past: dict[str, Any]) -> dict[str, Any]:
        """Return the past; raise ValueError if its parameters are not grouped by component, as a run requires."""
        parameters = past.get("parameters", {})
        if not isinstance(parameters, dict) or not all(isinstance(values, dict) for values in parameters.values()):
            raise ValueError("parameters")
        return past


TYPES = {  # of the arrays in a file but the states, which are bytes as well
    "head": np.uint8,
    "points": np.int64,
    **dict.fromkeys(("signals", "scales", "table", "steps", "rest"), np.float64),
}
OF_FILE = ("version", "names", "components")  # fields of the form alone


@dataclass(frozen=True)
class Checkpoint:
    """The state of a run before communication point `point`: changes at that point are still to come.

    Attributes
    ----------
    point, step_size, start_time
        The communication point, the communication step (s), and the time of point 0 (s).
    past
        Data that determined the state; see `state_fingerprint`.
    notice
        Reason why the motion before point 0 was simulated instead of solved for.
    signals, scales
        Values of all signals by name, and the memory of iterative coupling, which is empty in any other coupling.
    recorded, points, table
        Names of the recorded variables, communication points, and a row of values for each point.
    recorded_each, steps
        Names of the variables that a decimated record contains at every step, and the rows of their values.
    rest, steps_in_row
        Values of these variables at the points after the last row, and the number of steps in a row.
    since
        For each stop condition, the point since which it has been met without a break.
    states, warnings
        State and logged warnings of each component.
    sources
        Files that the FMUs are made from (see `Assembly.sources`); empty if the states are held in memory.
    file
        The file that it was read from.
    """

    point: int
    step_size: float
    past: Mapping[str, Any]
    notice: str
    signals: Mapping[str, float]
    scales: Array
    recorded: tuple[str, ...]
    points: Indices
    table: Array
    recorded_each: tuple[str, ...]
    steps: Array
    rest: Array
    steps_in_row: int
    since: Mapping[str, int]
    states: Mapping[str, FmuState]
    warnings: Mapping[str, Sequence[str]]
    start_time: float = 0.0
    sources: Mapping[str, Any] = field(default_factory=dict)
    file: str = field(default="", compare=False)

    @property
    def title(self) -> str:
        """The name of the checkpoint in messages."""
        return f"the checkpoint {self.file}" if self.file else "the checkpoint"

    @property
    def time(self) -> float:
        """Time of the communication point (s)."""
        return self.start_time + self.point * self.step_size

    @property
    def is_held(self) -> bool:
        """Whether the states are held in the memory of loaded FMUs."""
        return not all(isinstance(state, bytes) for state in self.states.values())

    def check_past(self, past: Mapping[str, Any], sources: Mapping[str, Any]) -> None:
        """Raise ValueError unless the checkpoint has the `past` of a run whose FMUs are made from `sources`.

        The message lists the differences. If the sources differ, these differences are listed in place of the resulting
        differences in FMU identifiers.
        """
        lines = list_differences(self.past, past)
        if lines and (others := list_other_sources(self.sources, sources)):
            rest = list_differences({**self.past, "fmus": None}, {**past, "fmus": None})
            lines = "\n".join(filter(None, (others, rest)))
        if lines:
            raise ValueError(f"{self.title} at t = {self.time:.9g} s belongs to another run, which differs in\n{lines}")

    def save(self, path: str | Path) -> Path:
        """Write the checkpoint to a file, which appears completely or not at all, and return its path.

        Raises
        ------
        ValueError
            If the states are held only in the memory of loaded FMUs.
        """
        if self.is_held:
            raise ValueError("the state cannot be written to a file, because the FMUs hold it in memory")
        head = {
            "version": VERSION,
            **{name: getattr(self, name) for name in Head.model_fields if name not in OF_FILE},
            "names": list(self.signals),
            "components": list(self.states),
        }
        arrays: dict[str, Any] = {
            "head": np.frombuffer(json.dumps(head).encode(), np.uint8),
            "signals": np.array([*self.signals.values()], np.float64),
            "scales": self.scales,
            "points": self.points.astype(np.int64),
            "table": self.table,
            "steps": self.steps,
            "rest": self.rest,
            **{f"state_{k}": np.frombuffer(state, np.uint8) for k, state in enumerate(self._bytes())},
        }

        def write(temporary: Path) -> None:
            with temporary.open("wb") as file:
                np.savez(file, allow_pickle=False, **arrays, checksum=_checksum(arrays))

        write_atomically(Path(path), write)
        return Path(path)

    def _bytes(self) -> list[bytes]:
        return [state for state in self.states.values() if isinstance(state, bytes)]

    @classmethod
    def load(cls, path: str | Path) -> Checkpoint:
        """Read a checkpoint from its file.

        Raises
        ------
        ValueError
            If there is no file, or the file is damaged, has been changed, or has another version.
        """
        if not Path(path).is_file():
            raise ValueError(f"no checkpoint {path}; it must be a file that `save_at` wrote")
        try:
            arrays = _read_arrays(Path(path))
            text = arrays["head"].tobytes()
            version = int(from_json(text)["version"])  # which, unlike json, limits how deep its lists are nested
            if version == VERSION:
                if arrays.pop("checksum").tobytes() != _checksum(arrays).tobytes():
                    raise ValueError("checksum")
                return replace(cls._read(Head.model_validate_json(text), arrays), file=str(path))
            if not 0 < version < MOST_VERSION:
                raise ValueError("version")
        except Exception as error:  # numpy, zipfile and json each raise their own
            raise ValueError(
                f"{path} is not a checkpoint, or is damaged; it must be an unchanged file from `save_at`"
            ) from error
        raise ValueError(f"{path} is a checkpoint of format {version}; this version reads only format {VERSION}")

    @classmethod
    def _read(cls, head: Head, arrays: Mapping[str, Any]) -> Checkpoint:
        states = [f"state_{k}" for k in range(len(head.components))]
        types = {**TYPES, **dict.fromkeys(states, np.uint8)}
        if {name: array.dtype for name, array in arrays.items()} != types:
            raise ValueError("types")
        points = arrays["points"].astype(np.intp)
        n, shape = len(points), np.shape(arrays["steps"])
        n_each, rest = len(head.recorded_each), np.shape(arrays["rest"])
        sizes = {"table": (n, len(head.recorded)), "points": (n,)}
        sizes |= {"steps": (*shape[:1], n_each), "rest": (*rest[:1], n_each)}
        sizes |= {"signals": (len(head.names),), "scales": (np.size(arrays["scales"]),)}
        for name, size in sizes.items():
            if arrays[name].shape != size:
                raise ValueError(name)
        if (np.diff(points) <= 0).any() or points.max(initial=head.point) > head.point:
            raise ValueError("points")
        if not ((arrays["scales"] >= 0.0) & (arrays["scales"] < np.inf)).all():  # infinite ones switch iteration off
            raise ValueError("scales")
        return cls(
            **{name: value for name, value in head if name not in OF_FILE},
            signals=dict(zip(head.names, arrays["signals"].tolist(), strict=True)),
            scales=arrays["scales"],
            points=points,
            table=arrays["table"],
            steps=arrays["steps"],
            rest=arrays["rest"],
            states={name: arrays[state].tobytes() for name, state in zip(head.components, states, strict=True)},
        )


def as_checkpoint(start: Checkpoint | str | Path | None) -> Checkpoint | None:
    """Return a checkpoint, read from its file if necessary; raises ValueError like `Checkpoint.load`."""
    return start if isinstance(start, Checkpoint | None) else Checkpoint.load(as_path("start", start))


def _read_arrays(path: Path) -> dict[str, Any]:
    """Return the arrays of an archive by name; contents larger than the file are refused."""
    with zipfile.ZipFile(path) as archive:
        if sum(entry.file_size for entry in archive.infolist()) > path.stat().st_size:
            raise ValueError("size")
    with np.load(path, allow_pickle=False) as file:
        return {name: file[name] for name in file.files}


def _checksum(arrays: Mapping[str, Any]) -> Any:
    """Return the SHA-256 of arrays with their names, types and shapes, as an array of 32 bytes."""
    content = hashlib.sha256()
    for name, array in sorted(arrays.items()):
        content.update(f"{name} {array.dtype.str} {array.shape}\n".encode())
        content.update(array.tobytes())
    return np.frombuffer(content.digest(), np.uint8)
