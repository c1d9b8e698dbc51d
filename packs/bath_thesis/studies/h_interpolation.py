"""Study of exact, interpolated and printed H, the inverse of the receptance, by spin speed (thesis Fig. 5.3)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Annotated, ClassVar

import numpy as np

from amb_analysis.studies.inputs import Number, speed_range
from amb_analysis.studies.result import DrawnResult, WarnedResult
from amb_analysis.studies.sensor_receptance import HERTZ, POINTS, levitated_receptance, sensor_planes
from amb_cosim.model_constants.controller_data import SPEEDS, condition_number, inverse_receptance, pack
from amb_cosim.model_constants.rotor_models import control_loop
from amb_cosim.presentation.json_data import JsonKey, Layout
from amb_cosim.presentation.text_tables import TextBlock, labelled_table
from amb_cosim.presentation.units import SIZES, speed_unit
from array_types import Array, Complex
from bath_thesis.studies.printed_h import FREQUENCY, PrintedH, compare_with_print
from rolac_controller.control_loop import ControlLoop
from rolac_controller.receptance_table import built_table, find_bracket, interpolate
from rolac_controller.sizes import sizes_of
from rotor_analysis.implausible_sizes import implausible_sizes
from rotor_analysis.rotor_file import RotorSource, load_rotor


@dataclass(frozen=True, eq=False)
class InterpolationError:
    """Error of an interpolated H at each speed, shape (n,).

    relative_error
        |H - H_exact| / |H_exact| in the Frobenius norm (1).
    left_by_a_step
        |I + H R|, the largest share of a synchronous force that remains after a full step U <- U + H Q (1). It is 0 for
        exact H.
    """

    relative_error: Array
    left_by_a_step: Array


@dataclass(frozen=True, eq=False, repr=False)
class InverseReceptance(WarnedResult, DrawnResult):
    """H as a function of spin speed, exact and interpolated.

    rotor
        Name of the rotor.
    planes
        Axial positions of the sensor planes (m), each with a sensor in x and one in y.
    spin_frequencies
        Spin frequencies (Hz), shape (n,).
    table
        Speeds in the thesis's table (Hz).
    forces
        Names of the forces.
    h, h_interpolated
        Exact H, and H interpolated in the thesis's table (N/m), both complex, of shape (n, 4, 8).
    condition_number
        Condition number of R at each speed (1), shape (n,).
    tables
        Errors of interpolation in the thesis's table (`thesis`), and in a table with a row for each Hz (`every_hertz`).
    norm_by_force
        |H_i| (N/m) of each force (Fig. 5.3), shape (n, 4).
    at_10_hz
        H at 10 Hz and the matrix printed in the thesis; None for any rotor except the thesis's rig.
    """

    name: ClassVar[str] = "h_matrix"
    renamed: ClassVar[Mapping[str, str]] = {"speeds": "`spin_frequencies`, in Hz"}

    rotor: str
    planes: Annotated[tuple[float, ...], JsonKey("planes_z_m")]
    spin_frequencies: Annotated[Array, "Hz"]
    table: Annotated[Array, "Hz"]
    forces: tuple[str, ...]
    h: Annotated[Complex, "N/m"]
    h_interpolated: Annotated[Complex, "N/m"]
    condition_number: Array
    tables: dict[str, InterpolationError]
    norm_by_force: Annotated[Array, "N/m"]
    at_10_hz: Annotated[PrintedH | None, Layout.OMITTED_IF_NONE]

    def text(self) -> list[TextBlock]:
        """Return a table of the largest errors between adjacent speeds of the thesis's table, and H at 10 Hz."""
        unit, hertz = speed_unit(), SIZES["speed"]["Hz"]
        table = labelled_table(
            f"{self.rotor}: H interpolated between the speeds of the table",
            f"speed ({unit.label})",
            "largest error of H (%)",
            f"at ({unit.label})",
            "left by a full step (%)",
            "condition number of R",
        )
        errors, last = self.tables["thesis"], self.table[-1]
        for low, high in pairwise([*self.table, max(self.spin_frequencies[-1], last)]):
            within = np.flatnonzero((self.spin_frequencies >= low) & (self.spin_frequencies <= high))
            if low < high and len(within) > 1:
                worst = within[np.argmax(errors.relative_error[within])]
                table.add_row(
                    f"{unit.number(hertz * low)} to {unit.number(hertz * high)}"
                    + (", beyond the table" if low == last else ""),
                    f"{100.0 * errors.relative_error[worst]:.2f}",
                    unit.number(hertz * self.spin_frequencies[worst]),
                    f"{100.0 * errors.left_by_a_step[within].max():.2f}",
                    f"{self.condition_number[within].max():.1f}",
                )
        return [table, *(self.at_10_hz.text() if self.at_10_hz is not None else ()), *self.warning_lines()]


def h_matrix(
    rotor: RotorSource = None, *, up_to: Number = "50 Hz", k_b: Number = "1e6 N/m", c_b: Number = "5000 N.s/m"
) -> InverseReceptance:
    """Return exact H by spin speed, H as the controller interpolates it, and the interpolation errors for two tables.

    H = -(R^H W R)^-1 R^H W     (5.10)

    Parameters
    ----------
    rotor
        A rotor or a rotor file; the rig of the thesis by default.
    up_to
        Highest spin speed (rad/s), or a string with its unit.
    k_b, c_b
        Net stiffness (N/m) and damping (N s/m) of the closed bearings, or strings with their units.

    Raises
    ------
    ValueError
        If the rotor lacks the planes of the sensors and bearings, an argument is out of range, or R is singular at a
        speed.
    """
    rotor_data = load_rotor(rotor)
    loop = control_loop(rotor_data)
    speeds = np.unique(np.concatenate([speed_range(up_to, POINTS, SPEEDS[0]), SPEEDS]))
    R = levitated_receptance(rotor_data, speeds, k_b, c_b)
    exact = np.array([inverse_receptance(r) for r in R])
    every_hertz = HERTZ * np.arange(5.0, np.ceil(speeds[-1] / HERTZ) + 1.0)
    table_speeds = {"thesis": np.array(SPEEDS), "every_hertz": every_hertz}
    interpolated_h = {
        name: interpolated(loop, rows, levitated_receptance(rotor_data, rows, k_b, c_b), speeds)
        for name, rows in table_speeds.items()
    }
    comparison = None
    if rotor_data == load_rotor("bath_rig_thesis"):
        (at_10_hz,) = levitated_receptance(rotor_data, np.array([FREQUENCY * HERTZ]), k_b, c_b)
        comparison = compare_with_print(inverse_receptance(at_10_hz), loop.axis_names)
    return InverseReceptance(
        rotor=rotor_data.name,
        planes=sensor_planes(rotor_data),
        spin_frequencies=speeds / HERTZ,
        table=np.array([speed / HERTZ for speed in SPEEDS]),
        forces=loop.axis_names,
        h=exact,
        h_interpolated=interpolated_h["thesis"],
        condition_number=np.array([condition_number(r) for r in R]),
        tables={
            name: InterpolationError(_relative_error(H, exact), _force_after_step(H, R))
            for name, H in interpolated_h.items()
        },
        norm_by_force=np.linalg.norm(exact, axis=2),
        at_10_hz=comparison,
        warnings=implausible_sizes(rotor_data),
    )


def interpolated(loop: ControlLoop, table_speeds: Array, receptances: Complex, speeds: Array) -> Complex:
    """Return H as the controller interpolates it: linearly between the speeds of a table, and constant outside.

    Parameters
    ----------
    loop
        Names of the controller's bearings and sensors.
    table_speeds, receptances
        Ascending speeds of the table (rad/s), shape (m,), and R at these speeds (m/N), shape (m, n_sensors, n_axes).
    speeds
        Speeds at which H is returned (rad/s), shape (n,).

    Returns
    -------
    array, shape (n, n_axes, n_sensors), complex
        N/m.

    Raises
    ------
    ValueError
        If R cannot be inverted at one of the speeds.
    """
    constants = pack(loop, table_speeds, receptances)
    table = built_table(constants, sizes_of(constants))
    H = np.empty((len(speeds), *table.H.shape[1:]), dtype=np.complex128)
    for n, speed in enumerate(speeds):
        lower, upper, weight, _ = find_bracket(table, 1.0, float(speed))
        interpolate(table.H[lower], table.H[upper], weight, H[n])
    return H


def _relative_error(H: Complex, exact: Complex) -> Array:
    """Return the relative error of each H in the Frobenius norm, shape (n,)."""
    return np.linalg.norm(H - exact, axis=(1, 2)) / np.linalg.norm(exact, axis=(1, 2))


def _force_after_step(H: Complex, R: Complex) -> Array:
    """Return |I + H R|, the largest share of a synchronous force that remains after a full step, shape (n,)."""
    return np.linalg.norm(np.eye(R.shape[2]) + H @ R, ord=2, axis=(1, 2))
