"""Identified receptances in a TOML file: reading, updating and atomic writing."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Literal, get_args

import numpy as np
from annotated_types import Ge, Gt, Le
from numpy.typing import ArrayLike
from pydantic import PlainValidator, StrictFloat, StrictInt, StrictStr

from amb_cosim.model_constants.controller_data import condition_number, inverse_receptance, pack_rows
from amb_files.atomic import write_file
from amb_files.checks import errors_in
from amb_files.toml import read_toml, table, validate
from amb_files.validation_errors import Unit
from array_types import Array, Complex
from rolac_controller.control_loop import ControlLoop
from rolac_controller.interface import interface_of
from rolac_controller.parameters import LARGEST_ORDER
from rolac_controller.receptance_table import SAME_SPEED

Format = Literal["amb-cosim receptances 2"]
(FORMAT,) = get_args(Format)

# Controller parameters on which a synchronous receptance depends, besides those of axes, sensors and planes.
_SHARED = (
    *("sample_time", "derivative_time", "pid.direct"),
    *("chain.preset", "chain.filter", "chain.delay", "chain.cutoff"),
)
_GAINS = ("k_b", "c_b", "k_integral", "k_s", "k_i", "k_p", "k_d")


def loop_parameters(loop: ControlLoop, parameters: Mapping[str, float] | None = None) -> dict[str, float]:
    """Return the parameters on which a receptance depends, with the values that were set or else the start values."""
    values, table = parameters or {}, interface_of(loop)
    names = {
        *_SHARED,
        *(f"{bearing}.{gain}_{axis}" for bearing, axis, _ in loop.axes for gain in _GAINS),
        *(f"{sensor}.scale" for sensor in loop.sensor_names),
        *(f"plane{k + 1}.{name}" for k in range(len(loop.planes)) for name in ("z", "offset")),
    }
    return {v.name: float(values.get(v.name, v.start)) for v in table.of("parameter") if v.name in names}


@dataclass(frozen=True)
class Entry:
    """A receptance R, shape (n_sensors, n_axes) (m/N), of a harmonic at one speed (rad/s).

    `inner` is the response C of a controller that closes the loop in parallel with the PID, shape (n_axes, n_sensors)
    (N/m).
    """

    order: int
    speed: float
    receptance: Complex
    inner: Complex | None = None


@dataclass(frozen=True)
class ReceptanceTable:
    """Receptances of a rotor in a single control loop.

    Parameters
    ----------
    rotor
        Name of the only rotor for which the table is valid.
    sensors, axes
        Names of the rows and columns of a receptance.
    parameters
        Parameters of the controller during identification, as `loop_parameters` returns them.
    entries
        Entries, ascending in order and speed.
    """

    rotor: str
    sensors: tuple[str, ...]
    axes: tuple[str, ...]
    parameters: Mapping[str, float]
    entries: tuple[Entry, ...] = ()

    def updated(
        self, speed: float, receptance: ArrayLike, order: int = 1, inner: Complex | None = None
    ) -> ReceptanceTable:
        """Return the table with a new receptance, which replaces an old one at the same speed (within 0.5 %).

        `inner` has the same meaning as in `Entry`.

        Raises
        ------
        ValueError
            If the speed is not positive, or R is not finite, has the wrong shape or cannot be inverted.
        """
        if not 0.0 < speed < math.inf:
            raise ValueError(f"speed = {speed:g} rad/s is not allowed; it must be > 0 rad/s")
        inverse_receptance(receptance)
        shape = (len(self.sensors), len(self.axes))
        if np.shape(receptance) != shape:
            raise ValueError(f"receptance of shape {np.shape(receptance)} is not allowed; it must be {shape}")
        new = Entry(order, float(speed), np.asarray(receptance, dtype=np.complex128), inner)
        same = [e for e in self.entries if e.order == order and abs(e.speed - speed) <= SAME_SPEED * speed]
        old = min(same, key=lambda e: abs(e.speed - speed), default=None)
        retained = [e for e in self.entries if e is not old]
        return replace(self, entries=tuple(sorted([*retained, new], key=lambda e: (e.order, e.speed))))

    def constants(self, loop: ControlLoop) -> Array:
        """Return the constants of a controller FMU with this table.

        Raises
        ------
        ValueError
            If there is no entry, the loop has other sensors or axes, or an R cannot be inverted.
        """
        if not self.entries:
            raise ValueError(f"the table of rotor {self.rotor} has no entry")
        _check_names(self, loop, f"the table of rotor {self.rotor}")
        inner = [(e.order, e.speed, e.inner) for e in self.entries if e.inner is not None]
        return pack_rows(loop, ((e.order, e.speed, e.receptance) for e in self.entries), inner)

    def write(self, path: Path) -> None:
        """Write the table atomically: a failure or an interruption leaves the old file unchanged."""
        path.parent.mkdir(parents=True, exist_ok=True)
        write_file(path, repr(self))

    def __repr__(self) -> str:
        """Return the text of the table's file, which identifies models made with the table."""
        head = [
            "# Receptances R (m/N): Q = Q_0 + R U, displacements at sensors (rows) by forces on axes (columns).",
            f'format = "{FORMAT}"',
            f"rotor = {_quoted(self.rotor)}",
            f"sensors = {_list(self.sensors)}",
            f"axes = {_list(self.axes)}",
            f"entries = {len(self.entries)}",
            "",
            "[loop] # parameters of the controller for which the receptances hold",
            *(f"{_quoted(name)} = {value!r}" for name, value in self.parameters.items()),
        ]
        return "\n".join([*head, *(line for entry in self.entries for line in _lines(entry))]) + "\n"


def empty_table(
    rotor: str,
    loop: ControlLoop,
    parameters: Mapping[str, float] | None = None,
    inner: Mapping[str, float] | None = None,
) -> ReceptanceTable:
    """Return an empty table for the rotor of this name, its control loop and the parameters of the controller.

    `inner` contains the parameters of an inner controller, by `component.name`.
    """
    values = {**loop_parameters(loop, parameters), **(inner or {})}
    return ReceptanceTable(rotor, loop.sensor_names, loop.axis_names, values)


def read_table(
    source: Path | ReceptanceTable,
    rotor: str | None = None,
    loop: ControlLoop | None = None,
    parameters: Mapping[str, float] | None = None,
) -> ReceptanceTable:
    """Read a table, or check one.

    Parameters
    ----------
    source
        A file that `ReceptanceTable.write` wrote, or a table.
    rotor
        Name of the rotor that the table must belong to; any by default.
    loop
        Loop whose sensors and axes the table must have; any by default.
    parameters
        Parameters that the table must have been identified with, as `loop_parameters` returns them; any by default.

    Raises
    ------
    ValueError
        If the file cannot be read, is incomplete, or belongs to another rotor or loop; the message has one line for
        each error.
    """
    if isinstance(source, ReceptanceTable):
        name, receptances = f"table of receptances of rotor {source.rotor}", source
    else:
        name = f"table of receptances {source}"
        file = validate(read_toml(source, name), _ReceptanceFile, name)
        entries = tuple(Entry(entry.order, entry.speed, entry.receptance, entry.inner) for entry in file.receptance)
        receptances = ReceptanceTable(file.rotor, file.sensors, file.axes, file.loop, entries)
    if rotor is not None and receptances.rotor != rotor:
        raise ValueError(f"{name}: it belongs to rotor {receptances.rotor!r}, not {rotor!r}")
    if loop is not None:
        _check_names(receptances, loop, name)
    _check_parameters(receptances, parameters or {}, name)
    return receptances


def _lines(entry: Entry) -> list[str]:
    def rows(matrix: Array) -> list[str]:
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
        *([] if entry.inner is None else ["inner_real = [", *rows(entry.inner.real), "]"]),
        *([] if entry.inner is None else ["inner_imaginary = [", *rows(entry.inner.imag), "]"]),
    ]


def _quoted(text: str) -> str:
    """Return a TOML string: a JSON string in which the control character DEL, which JSON allows, is escaped as well."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def _list(names: Iterable[str]) -> str:
    return f"[{', '.join(_quoted(name) for name in names)}]"


def _as_matrix(value: object) -> Array:
    rows = value if isinstance(value, list) and all(isinstance(row, list) for row in value) else []
    numbers = [number for row in rows for number in row]
    finite = all(type(number) in (int, float) and math.isfinite(number) for number in numbers)
    if not numbers or len({len(row) for row in rows}) != 1 or not finite:
        raise ValueError("it must consist of rows of equal length with finite numbers")
    return np.array(value, dtype=np.float64)


Matrix = Annotated[Array, PlainValidator(_as_matrix)]


@table
class _Receptance:
    """The form of a table `[[receptance]]`."""

    order: Annotated[StrictInt, Ge(1), Le(LARGEST_ORDER)]
    speed: Annotated[StrictFloat, Gt(0.0), Unit("rad/s")]
    real: Matrix
    imaginary: Matrix
    inner_real: Matrix | None = None
    inner_imaginary: Matrix | None = None

    def __post_init__(self) -> None:
        if self.real.shape != self.imaginary.shape:
            raise ValueError(
                f"real has {_shape(self.real)}, but imaginary has {_shape(self.imaginary)}; the sizes must be equal"
            )
        if (self.inner_real is None) != (self.inner_imaginary is None):
            raise ValueError("inner_real and inner_imaginary must be set together or not at all")
        for name, matrix in (("inner_real", self.inner_real), ("inner_imaginary", self.inner_imaginary)):
            if matrix is not None and matrix.shape != self.real.T.shape:
                raise ValueError(f"{name} has {_shape(matrix)}; it must have {_shape(self.real.T)}, axes by sensors")
        with errors_in(f"at {self.speed:g} rad/s"):
            inverse_receptance(self.receptance)

    @property
    def receptance(self) -> Complex:
        """R = real + j imaginary, shape (n_sensors, n_axes)."""
        return self.real + 1j * self.imaginary

    @property
    def inner(self) -> Complex | None:
        """C = inner_real + j inner_imaginary, shape (n_axes, n_sensors), if any."""
        if self.inner_real is None or self.inner_imaginary is None:
            return None
        return self.inner_real + 1j * self.inner_imaginary


@table
class _ReceptanceFile:
    """The form of a receptance file."""

    format: Format
    rotor: StrictStr
    sensors: tuple[StrictStr, ...]
    axes: tuple[StrictStr, ...]
    entries: Annotated[StrictInt, Ge(0)]
    loop: dict[str, StrictFloat]
    receptance: tuple[_Receptance, ...] = ()

    def __post_init__(self) -> None:
        if len(self.receptance) != self.entries:
            raise ValueError(
                f"it has {len(self.receptance)} receptances but entries = {self.entries}; the file is incomplete"
            )
        shape = (len(self.sensors), len(self.axes))
        for k, entry in enumerate(self.receptance):
            if entry.real.shape != shape:
                raise ValueError(
                    f"receptance[{k}] of {_shape(entry.real)} is not allowed; it must be {shape[0]} rows of {shape[1]} "
                    "numbers, sensors by axes"
                )
        keys = [(entry.order, entry.speed) for entry in self.receptance]
        if keys != sorted(set(keys)):
            raise ValueError("the receptances must be sorted by harmonic order and, for each order, by ascending speed")


def _shape(matrix: Array) -> str:
    return f"{matrix.shape[0]} rows of {matrix.shape[1]} numbers"


def _check_names(table: ReceptanceTable, loop: ControlLoop, what: str) -> None:
    for kind, names, expected in (
        ("sensors", table.sensors, loop.sensor_names),
        ("axes", table.axes, loop.axis_names),
    ):
        if names != expected:
            raise ValueError(f"{what}: its {kind} are {', '.join(names)}, not {', '.join(expected)}")


def _check_parameters(table: ReceptanceTable, parameters: Mapping[str, float], file: str) -> None:
    for name, expected in parameters.items():
        identified = table.parameters.get(name)
        if identified is None or not math.isclose(identified, expected, rel_tol=1e-9, abs_tol=1e-300):
            text = "unknown" if identified is None else f"{identified:g}"
            raise ValueError(f"{file}: it was identified with {name} = {text}, not {expected:g}; identify again")
