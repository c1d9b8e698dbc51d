"""Identified receptances in a text file: read, renewed and written without ever losing the old ones."""

from __future__ import annotations

import fnmatch
import json
import math
import os
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from amb_analysis.controller_data import Complex, condition_number, inverse_receptance, pack_rows
from amb_files.atomic import write_atomically
from rolac_controller.interface import INTERFACE
from rolac_controller.parameters import LARGEST_ORDER
from rolac_controller.receptance_table import SAME_SPEED
from rolac_controller.rig_layout import N_AXES, N_SENSORS

FORMAT = "amb-cosim receptances 1"

# Parameters of the controller that a synchronous receptance depends on.
_LOOP = (
    *("sample_time", "derivative_time", "pid.direct", "mb?.k_b_?", "mb?.c_b_?", "mb?.k_integral_?", "mb?.k_s_?"),
    *("mb?.k_i_?", "mb?.k_p_?", "mb?.k_d_?", "chain.preset", "chain.filter", "chain.delay", "chain.cutoff"),
    *("s?.scale", "plane?.z", "plane?.offset"),
)
LOOP_PARAMETERS = tuple(
    v.name for v in INTERFACE.of("parameter") if any(fnmatch.fnmatchcase(v.name, pattern) for pattern in _LOOP)
)


def loop_of(parameters: Mapping[str, float] | None = None) -> dict[str, float]:
    """The parameters that a receptance depends on: those given, and the start values of the others."""
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
        What the rotor is called; a table is refused for another.
    loop
        The controller's parameters that they hold for, as of `loop_of`.
    entries
        Ascending in order and speed.
    """

    rotor: str
    loop: Mapping[str, float]
    entries: tuple[Entry, ...] = ()

    def updated(self, speed: float, receptance: ArrayLike, order: int = 1) -> ReceptanceTable:
        """The table with a receptance in place of the one at that speed (within 0.5 %), or in addition.

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
        """H at a speed, linear between the speeds of the table, and whether the speed is beyond them.

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
        """Constants of a controller FMU with this table.

        Raises
        ------
        ValueError
            If there is no entry, or an R cannot be inverted.
        """
        if not self.entries:
            raise ValueError(f"the table of rotor {self.rotor} has no entry")
        return pack_rows((e.order, e.speed, e.receptance) for e in self.entries)

    def write(self, path: Path) -> None:
        """Write the table; the file is the old one or the new one, whole, whatever happens meanwhile."""

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
        The rotor it is wanted for, if that matters.
    loop
        The parameters it is wanted for, as of `loop_of`, if they matter.

    Raises
    ------
    ValueError
        If the file cannot be read, is no such table or not a whole one, or belongs to another rotor or loop.
    """
    try:
        data = tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise ValueError(f"table of receptances {path} cannot be read: {error}") from error
    try:
        table = _table(data)
        _belongs(table, rotor, loop)
    except ValueError as error:
        raise ValueError(f"table of receptances {path}: {error}") from error
    return table


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


def _table(data: Mapping[str, Any]) -> ReceptanceTable:
    if data.get("format") != FORMAT:
        raise ValueError(f"format = {data.get('format')!r} is not allowed; it must be {FORMAT!r}")
    rotor, count, loop, found = (data.get(key) for key in ("rotor", "entries", "loop", "receptance"))
    if not isinstance(rotor, str) or not isinstance(loop, dict) or not isinstance(count, int):
        raise ValueError("rotor, entries or [loop] is missing or no name, number or table")
    if not all(isinstance(value, int | float) for value in loop.values()):
        raise ValueError("[loop] must hold numbers")
    tables = found if isinstance(found, list) else []
    if len(tables) != count:
        raise ValueError(f"it has {len(tables)} receptances where entries = {count}; it is not whole")
    entries = tuple(_entry(table, number) for number, table in enumerate(tables, 1))
    keys = [(e.order, e.speed) for e in entries]
    if keys != sorted(set(keys)):
        raise ValueError("its receptances must ascend in order and speed")
    return ReceptanceTable(rotor, {name: float(value) for name, value in loop.items()}, entries)


def _entry(table: Any, number: int) -> Entry:
    where = f"receptance {number}"
    if not isinstance(table, dict):
        raise ValueError(f"{where} must be a table [[receptance]]")
    order, speed = table.get("order"), table.get("speed")
    if not isinstance(order, int) or not 1 <= order <= LARGEST_ORDER:
        raise ValueError(f"{where}: order = {order!r} is not allowed; it must be from 1 to {LARGEST_ORDER}")
    if isinstance(speed, bool) or not isinstance(speed, int | float) or not 0.0 < speed < math.inf:
        raise ValueError(f"{where}: speed = {speed!r} rad/s is not allowed; it must be > 0 rad/s and finite")
    try:
        real, imaginary = (np.asarray(table.get(part), dtype=np.float64) for part in ("real", "imaginary"))
    except (TypeError, ValueError) as error:
        raise ValueError(f"{where}: real and imaginary must be 8 rows of 4 numbers") from error
    if real.shape != (N_SENSORS, N_AXES) or imaginary.shape != real.shape:
        raise ValueError(f"{where}: real and imaginary must be 8 rows of 4 numbers")
    receptance = real + 1j * imaginary
    try:
        inverse_receptance(receptance)
    except ValueError as error:
        raise ValueError(f"{where}, at {speed:g} rad/s: {error}") from error
    return Entry(order, float(speed), receptance)


def _belongs(table: ReceptanceTable, rotor: str | None, loop: Mapping[str, float] | None) -> None:
    if rotor is not None and table.rotor != rotor:
        raise ValueError(f"it is of rotor {table.rotor!r}, not of {rotor!r}")
    for name, wanted in (loop or {}).items():
        found = table.loop.get(name)
        if found is None or not math.isclose(found, wanted, rel_tol=1e-9, abs_tol=1e-300):
            shown = "unknown" if found is None else f"{found:g}"
            raise ValueError(f"it was identified with {name} = {shown}, not {wanted:g}; identify again")
