"""The state of a run before a communication point, from which it, or another with the same past, goes on.

In a file it is an archive of numpy (`.npz`): `head`, JSON text with the version of the form, the point, the past and
names; `signals`, `points`, `table`; the states of the FMUs, `state_0` and so on, as they serialise them; and
`checksum`, the SHA-256 of all other arrays with their names, types and shapes.
"""

from __future__ import annotations

import hashlib
import json
import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from amb_cosim.cosim.basics.differences import told_differences
from amb_cosim.cosim.basics.schedules import Array, IntArray
from amb_cosim.cosim.fmu.component import FmuState
from amb_files.atomic import write_atomically

VERSION, MOST_VERSION = 2, 1000
HEAD = ("point", "step_size", "past", "notice", "names", "recorded", "recorded_each", "since", "components", "warnings")


@dataclass(frozen=True)
class Checkpoint:
    """The state of a run before communication point `point`: what happens at that point has not happened yet.

    Attributes
    ----------
    point, step_size
        The communication point, and the communication step (s).
    past
        What decided the state; see `past`.
    notice
        Why the motion before point 0 was simulated, where it might have been solved for.
    signals, scales
        Values of all signals by name, and what iterative coupling keeps.
    recorded, points, table
        Names of the variables that were recorded, communication points, and a row of values for each.
    recorded_each, steps
        Names of those that were recorded at every point where others were not, and a row of values for each.
    since
        For each condition that ends the run, since which point it has been met without a break.
    states, warnings
        Of each component: its state, and what it logged as warnings.
    """

    point: int
    step_size: float
    past: Mapping[str, Any]
    notice: str
    signals: Mapping[str, float]
    scales: Array
    recorded: tuple[str, ...]
    points: IntArray
    table: Array
    recorded_each: tuple[str, ...]
    steps: Array
    since: Mapping[str, int]
    states: Mapping[str, FmuState]
    warnings: Mapping[str, Sequence[str]]

    @property
    def time(self) -> float:
        """Time of the communication point (s)."""
        return self.point * self.step_size

    @property
    def is_held(self) -> bool:
        """Whether the states lie in the memory of living FMUs."""
        return not all(isinstance(state, bytes) for state in self.states.values())

    def check_past(self, past: Mapping[str, Any]) -> None:
        """Raise ValueError, with what differs, unless this is the past of the run that is to go on."""
        if self.past != past and (message := told_differences(self.past, past)):
            raise ValueError(f"the checkpoint at t = {self.time:.9g} s is of another run; until then it had\n{message}")

    def save(self, path: str | Path) -> Path:
        """Write the checkpoint to a file, which appears whole or not at all, and return its path.

        Raises
        ------
        ValueError
            If the states are only held in the memory of living FMUs.
        """
        if self.is_held:
            raise ValueError("the state cannot be written; it lies in the memory of its FMUs")
        head = {
            "version": VERSION,
            **{name: getattr(self, name) for name in HEAD if hasattr(self, name)},
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
            If there is none, it is damaged or changed, or of another version.
        """
        if not Path(path).is_file():
            raise ValueError(f"no checkpoint {path}; it must be a file that --save-at wrote")
        try:
            arrays = _read_arrays(Path(path))
            head = json.loads(arrays["head"].tobytes())
            version = int(head["version"])
            if version == VERSION:
                if arrays.pop("checksum").tobytes() != _checksum(arrays).tobytes():
                    raise ValueError("checksum")
                return cls._read(head, arrays)
            if not 0 < version < MOST_VERSION:
                raise ValueError("version")
        except Exception as error:  # numpy, zipfile and json have each their own
            raise ValueError(
                f"{path} is no checkpoint, or damaged; it must be a file that --save-at wrote, unchanged"
            ) from error
        raise ValueError(f"{path} is a checkpoint of form {version}; it must be {VERSION}, as this version writes it")

    @classmethod
    def _read(cls, head: Mapping[str, Any], arrays: Mapping[str, Any]) -> Checkpoint:
        return cls(
            point=int(head["point"]),
            step_size=float(head["step_size"]),
            past=head["past"],
            notice=head["notice"],
            signals=dict(zip(head["names"], arrays["signals"].tolist(), strict=True)),
            scales=arrays["scales"],
            recorded=tuple(head["recorded"]),
            points=arrays["points"].astype(np.intp, casting="same_kind"),
            table=arrays["table"],
            recorded_each=tuple(head["recorded_each"]),
            steps=arrays["steps"],
            since=head["since"],
            states={name: arrays[f"state_{k}"].tobytes() for k, name in enumerate(head["components"])},
            warnings=head["warnings"],
        )


def _read_arrays(path: Path) -> dict[str, Any]:
    """Return the arrays of an archive by name; one whose content is larger than its file was not written here."""
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
