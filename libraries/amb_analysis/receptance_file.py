"""Identified receptances in a TOML file: read, updated, and written whole or not at all."""

from __future__ import annotations

import fnmatch
import json
import math
import os
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Literal, get_args

import numpy as np
from annotated_types import Ge, Gt, Le
from numpy.typing import ArrayLike, NDArray
from pydantic import PlainValidator, StrictFloat, StrictInt, StrictStr

from amb_analysis.controller_data import Complex, condition_number, inverse_receptance, pack_rows
from amb_files.atomic import write_atomically
from amb_files.toml import read_toml, table, validate
from amb_files.validation_errors import Unit
from rolac_controller.interface import INTERFACE
from rolac_controller.parameters import LARGEST_ORDER
from rolac_controller.receptance_table import SAME_SPEED
from rolac_controller.rig_layout import N_AXES, N_SENSORS

Format = Literal["amb-cosim receptances 1"]
(FORMAT,) = get_args(Format)

# Parameters of the controller that a synchronous receptance depends on.
_LOOP = (
    *("sample_time", "derivative_time", "pid.direct", "mb?.k_b_?", "mb?.c_b_?", "mb?.k_integral_?", "mb?.k_s_?"),
    *("mb?.k_i_?", "mb?.k_p_?", "mb?.k_d_?", "chain.preset", "chain.filter", "chain.delay", "chain.cutoff"),
    *("s?.scale", "plane?.z", "plane?.offset"),
)
LOOP_PARAMETERS = tuple(
    v.name for v in INTERFACE.of("parameter") if any(fnmatch.fnmatchcase(v.name, pattern) for pattern in _LOOP)
)


def loop_parameters(parameters: Mapping[str, float] | None = None) -> dict[str, float]:
    """Return the parameters that a receptance depends on: those given, and the start values of the others."""
    given = parameters or {}
    return {name: float(given.get(name, INTERFACE[name].start)) for name in LOOP_PARAMETERS}


@dataclass(frozen=True)
class Entry:
    """A receptance R, shape (8, 4) (m/N), of one harmonic at one speed (rad/s)."""

    order: int
    speed: float
    receptance: Complex


@dataclass(frozen=True)
class ReceptanceTable:
    """Receptances of one rotor in one control loop.

    Parameters
    ----------
    rotor
        Name of the rotor; a table cannot be used for another one.
    loop
        The controller's parameters that they were identified with, as `loop_parameters` returns them.
    entries
        Ascending in order and speed.
    """

    rotor: str
    loop: Mapping[str, float]
    entries: tuple[Entry, ...] = ()

    def updated(self, speed: float, receptance: ArrayLike, order: int = 1) -> ReceptanceTable:
        """Return the table with a new receptance, which replaces one at that speed (within 0.5 %) if there is one.

        Raises
        ------
        ValueError
            If the speed is not positive, or R is not finite, has the wrong shape or cannot be inverted.
        """
        if not 0.0 < speed < math.inf:
            raise ValueError(f"speed = {speed:g} rad/s is not allowed; it must be > 0 rad/s")
        inverse_receptance(receptance)
        new = Entry(order, float(speed), np.asarray(receptance, dtype=np.complex128))
        same = [e for e in self.entries if e.order == order and abs(e.speed - speed) <= SAME_SPEED * speed]
        old = min(same, key=lambda e: abs(e.speed - speed), default=None)
        kept = [e for e in self.entries if e is not old]
        return replace(self, entries=tuple(sorted([*kept, new], key=lambda e: (e.order, e.speed))))

    def h_at(self, speed: float, order: int = 1, weights: ArrayLike | None = None) -> tuple[Complex, bool]:
        """Return H at a speed, linear between the speeds of the table, and whether the speed is beyond them.

        Beyond them H is that of the nearest speed, as in the controller.

        Raises
        ------
        ValueError
            If the table has no entry of that order.
        """
        of_order = [e for e in self.entries if e.order == order]
        if not of_order:
            raise ValueError(f"the table of rotor {self.rotor} has no receptance of order {order}")
        speeds = [e.speed for e in of_order]
        matrices = np.array([inverse_receptance(e.receptance, weights) for e in of_order])
        flat = matrices.reshape(len(speeds), -1)
        h = [np.interp(speed, speeds, column.real) + 1j * np.interp(speed, speeds, column.imag) for column in flat.T]
        return np.array(h).reshape(N_AXES, N_SENSORS), not speeds[0] <= speed <= speeds[-1]

    def constants(self) -> NDArray[np.float64]:
        """Return the constants of a controller FMU with this table.

        Raises
        ------
        ValueError
            If there is no entry, or an R cannot be inverted.
        """
        if not self.entries:
            raise ValueError(f"the table of rotor {self.rotor} has no entry")
        return pack_rows((e.order, e.speed, e.receptance) for e in self.entries)

    def write(self, path: Path) -> None:
        """Write the table; a failure or an interruption leaves the old file as it was."""

        def to_disk(temporary: Path) -> None:
            with temporary.open("w", encoding="utf-8") as file:
                file.write(self._text())
                file.flush()
                os.fsync(file.fileno())

        path.parent.mkdir(parents=True, exist_ok=True)
        write_atomically(path, to_disk)

    def _text(self) -> str:
        head = [
            "# Receptances R (m/N): Q = Q_0 + R U, sensors s1 to s8 (rows) by forces at mb1.x, mb1.y, mb2.x, mb2.y.",
            f'format = "{FORMAT}"',
            f"rotor = {_quoted(self.rotor)}",
            f"entries = {len(self.entries)}",
            "",
            "[loop] # parameters of the controller that they hold for",
            *(f"{_quoted(name)} = {value!r}" for name, value in self.loop.items()),
        ]
        return "\n".join([*head, *(line for entry in self.entries for line in _lines(entry))]) + "\n"


def read_table(path: Path, rotor: str | None = None, loop: Mapping[str, float] | None = None) -> ReceptanceTable:
    """Read a table.

    Parameters
    ----------
    path
        A file that `ReceptanceTable.write` wrote.
    rotor
        Name of the rotor that the table must belong to; any by default.
    loop
        Parameters that the table must have been identified with, as `loop_parameters` returns them; any by default.

    Raises
    ------
    ValueError
        If the file cannot be read, is not a complete table, or belongs to another rotor or loop; one line for each
        mistake.
    """
    name = f"table of receptances {path}"
    file = validate(read_toml(path, name), _File, name)
    entries = tuple(Entry(entry.order, entry.speed, entry.receptance) for entry in file.receptance)
    found = ReceptanceTable(file.rotor, file.loop, entries)
    _check_origin(found, rotor, loop, name)
    return found


def _lines(entry: Entry) -> list[str]:
    def rows(matrix: NDArray[np.float64]) -> list[str]:
        return [f"  [{', '.join(repr(float(value)) for value in row)}]," for row in matrix]

    hertz, condition = entry.speed / (2.0 * math.pi), condition_number(entry.receptance)
    return [
        "",
        f"[[receptance]] # {hertz:.6g} Hz, condition number {condition:.3g}",
        f"order = {entry.order}",
        f"speed = {entry.speed!r} # rad/s",
        "real = [",
        *rows(entry.receptance.real),
        "]",
        "imaginary = [",
        *rows(entry.receptance.imag),
        "]",
    ]


def _quoted(text: str) -> str:
    """A TOML string; JSON's is one but for the one control character that it does not escape."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def _as_matrix(value: object) -> NDArray[np.float64]:
    rows = value if isinstance(value, list) else []
    numbers = [number for row in rows if isinstance(row, list) and len(row) == N_AXES for number in row]
    finite = all(type(number) in (int, float) and math.isfinite(number) for number in numbers)
    if len(rows) != N_SENSORS or len(numbers) != N_SENSORS * N_AXES or not finite:
        raise ValueError(f"it must be {N_SENSORS} rows of {N_AXES} numbers, all finite")
    return np.array(value, dtype=np.float64)


Matrix = Annotated[NDArray[np.float64], PlainValidator(_as_matrix)]


@table
class _Receptance:
    """The form of a table `[[receptance]]`."""

    order: Annotated[StrictInt, Ge(1), Le(LARGEST_ORDER)]
    speed: Annotated[StrictFloat, Gt(0.0), Unit("rad/s")]
    real: Matrix
    imaginary: Matrix

    def __post_init__(self) -> None:
        try:
            inverse_receptance(self.receptance)
        except ValueError as error:
            raise ValueError(f"at {self.speed:g} rad/s: {error}") from error

    @property
    def receptance(self) -> Complex:
        """R = real + j imaginary, shape (8, 4)."""
        return self.real + 1j * self.imaginary


@table
class _File:
    """The form of the file."""

    format: Format
    rotor: StrictStr
    entries: Annotated[StrictInt, Ge(0)]
    loop: dict[str, StrictFloat]
    receptance: tuple[_Receptance, ...] = ()

    def __post_init__(self) -> None:
        if len(self.receptance) != self.entries:
            raise ValueError(
                f"it has {len(self.receptance)} receptances but entries = {self.entries}; the file is incomplete"
            )
        keys = [(entry.order, entry.speed) for entry in self.receptance]
        if keys != sorted(set(keys)):
            raise ValueError("receptance must ascend in order and speed")


def _check_origin(table: ReceptanceTable, rotor: str | None, loop: Mapping[str, float] | None, file: str) -> None:
    if rotor is not None and table.rotor != rotor:
        raise ValueError(f"{file}: it is of rotor {table.rotor!r}, not of {rotor!r}")
    for name, wanted in (loop or {}).items():
        found = table.loop.get(name)
        if found is None or not math.isclose(found, wanted, rel_tol=1e-9, abs_tol=1e-300):
            shown = "unknown" if found is None else f"{found:g}"
            raise ValueError(f"{file}: it was identified with {name} = {shown}, not {wanted:g}; identify again")
