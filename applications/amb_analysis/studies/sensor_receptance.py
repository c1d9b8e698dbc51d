"""Study of the receptance of the levitated rotor as a function of the spin speed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np

from amb_analysis.studies.inputs import Number, positive, speed_range
from amb_analysis.studies.result import DrawnResult, WarnedResult
from amb_cosim.model_constants.rotor_models import control_loop
from amb_cosim.presentation.json_data import JsonKey
from amb_cosim.presentation.text_tables import TextBlock, labelled_table, number
from amb_cosim.presentation.units import speed_unit
from array_types import Array, Complex
from rotor_analysis.implausible_sizes import implausible_sizes
from rotor_analysis.receptance import receptance as receptance_of
from rotor_analysis.refinement import refined
from rotor_analysis.rotor import Rotor
from rotor_analysis.rotor_file import RotorSource, load_rotor

HERTZ = 2.0 * np.pi  # rad/s
LOWEST = 1.0 * HERTZ
POINTS = 491  # of a range of speeds: every 0.1 Hz from 1 to 50 Hz


@dataclass(frozen=True, eq=False, repr=False)
class SensorReceptance(WarnedResult, DrawnResult):
    """Synchronous displacement at the sensors per bearing force.

    rotor
        Name of the rotor.
    planes
        Axial positions of the sensor planes (m), each with a sensor in x and one in y.
    sensors
        Names of the sensors' signals, in x and y of each plane.
    spin_frequencies
        Spin frequencies (Hz), shape (n,).
    forces
        Names of the forces, in x and y of each bearing.
    receptance
        R (m/N), complex, shape (n, n_sensors, n_axes).
    """

    name: ClassVar[str] = "receptance"
    renamed: ClassVar[Mapping[str, str]] = {"speeds": "`spin_frequencies`, in Hz"}

    rotor: str
    planes: Annotated[tuple[float, ...], JsonKey("planes_z_m")]
    sensors: tuple[str, ...]
    spin_frequencies: Annotated[Array, "Hz"]
    forces: tuple[str, ...]
    receptance: Annotated[Complex, "m/N"]

    def text(self) -> list[TextBlock]:
        """Return a table of the largest displacement at each sensor in x, per force in x."""
        title = f"{self.rotor}: largest receptance of the sensors in x"
        unit = speed_unit()
        table = labelled_table(title, "sensor", "force", "(µm/N)", f"speed ({unit.label})", "phase (deg)")
        for plane, z in enumerate(self.planes):
            for k in range(0, len(self.forces), 2):
                curve = self.receptance[:, 2 * plane, k]
                top = int(np.argmax(np.abs(curve)))
                table.add_row(
                    f"{self.sensors[2 * plane]}, z = {z:.4g} m",
                    self.forces[k],
                    number(1e6 * abs(curve[top])),
                    unit.number(HERTZ * self.spin_frequencies[top]),
                    f"{np.degrees(np.angle(curve[top])):z.1f}",
                )
        return [table, *self.warning_lines()]


def receptance(
    rotor: RotorSource = None, *, up_to: Number = "50 Hz", k_b: Number = "1e6 N/m", c_b: Number = "5000 N.s/m"
) -> SensorReceptance:
    """Return the synchronous displacement at the sensors per bearing force, as a function of the spin speed.

    R = S [-Omega^2 M + j Omega (C + Omega G) + K]^-1 B     (5.6)

    Speeds are denser near the maxima of all elements of R (`rotor_analysis.refinement`).

    Parameters
    ----------
    rotor
        A rotor or a rotor file; by default the packs' default rotor.
    up_to
        Highest spin speed (rad/s), or a string with its unit.
    k_b, c_b
        Net stiffness (N/m) and damping (N s/m) of the bearings in closed loop, or strings with their units.

    Raises
    ------
    ValueError
        If the rotor lacks the planes of the sensors and bearings, or an argument is out of range.

    Examples
    --------
    >>> result = receptance("compressor", up_to="200 Hz", k_b="1.3e7 N/m", c_b="4e4 N.s/m")
    >>> f"{1e6 * abs(result.receptance[:, 0, 0]).max():.3f} um/N"
    '0.083 um/N'
    """
    description = load_rotor(rotor)
    speeds, R = refined(
        lambda more: levitated_receptance(description, more, k_b, c_b), speed_range(up_to, POINTS, LOWEST), np.abs
    )
    loop = control_loop(description)
    return SensorReceptance(
        description.name,
        sensor_planes(description),
        loop.sensor_names,
        speeds / HERTZ,
        loop.axis_names,
        R,
        warnings=implausible_sizes(description),
    )


def levitated_receptance(rotor: Rotor, speeds: Array, k_b: Number, c_b: Number) -> Complex:
    """Return R (m/N) of a rotor on its bearings in closed loop at speeds (rad/s), shape (n, n_sensors, n_axes).

    Raises
    ------
    ValueError
        If the rotor lacks planes of sensors or bearings, or if stiffness (N/m) or damping (N s/m) is not positive.
    """
    control_loop(rotor)
    stiffness = positive(k_b, "N/m", "k_b")
    damping = positive(c_b, "N.s/m", "c_b", ", because nothing else damps the rotor")
    return receptance_of(speeds, stiffness, damping, rotor)


def sensor_planes(rotor: Rotor) -> tuple[float, ...]:
    """Return the axial positions (m) of the sensor planes."""
    return tuple(rotor.shaft.nodes[node - 1] for node in rotor.sensor_nodes)
