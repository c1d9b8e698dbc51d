"""Study of the modes of a rotor: frequencies and mode shapes at several spin speeds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Annotated, ClassVar

import numpy as np

from amb_analysis.studies.coefficient_limits import EXTRAPOLATED, Limits, is_extrapolated, limit_notes, limits_of
from amb_analysis.studies.damping_zones import damping_cells
from amb_analysis.studies.inputs import Number, spin_speeds
from amb_analysis.studies.result import DrawnResult, StudyResult, WarnedResult
from amb_cosim.presentation.json_data import JsonKey, Layout
from amb_cosim.presentation.text_tables import TextBlock, labelled_table, text_table
from amb_cosim.presentation.units import frequency_unit, speed_unit
from amb_files.checks import require
from array_types import Array, Complex
from rotor_analysis.assembly import Matrices
from rotor_analysis.implausible_sizes import implausible_sizes
from rotor_analysis.mode_kinds import kind_of
from rotor_analysis.modes import Mode, Whirl, overdamped_modes, translations
from rotor_analysis.modes import modes as modes_of
from rotor_analysis.rotor import Rotor
from rotor_analysis.rotor_file import RotorSource, load_rotor
from rotor_analysis.shaft import MassModel
from rotor_analysis.supported_rotor import supported_rotor
from rotor_analysis.tracking import RESONANT


@dataclass(frozen=True)
class ModesAtSpeed:
    """The lowest modes at a spin speed, in order of frequency; modes without resonance come last.

    frequencies
        Damped natural frequencies (rad/s).
    damping_ratios
        Damping ratios (1); negative if the motion grows.
    whirl
        Whirl directions.
    real_eigenvalues
        Eigenvalues (1/s) of the motions that do not oscillate.
    extrapolated
        Whether this speed is outside a table of coefficients.
    """

    frequencies: Annotated[tuple[float, ...], "rad/s"]
    damping_ratios: tuple[float, ...]
    whirl: tuple[Whirl, ...]
    real_eigenvalues: Annotated[tuple[float, ...], "1/s"]
    extrapolated: bool = False


@dataclass(frozen=True, repr=False)
class NaturalFrequencies(StudyResult):
    """Natural frequencies of a rotor at several spin speeds.

    rotor, mass
        Name of the rotor, and the mass matrix of its model.
    speeds
        The lowest modes by spin speed (rad/s).
    limits
        Validity limits of the coefficients of bearings and seals.
    """

    rotor: str
    mass: MassModel
    speeds: dict[float, ModesAtSpeed]
    limits: Limits = ()

    def text(self) -> list[TextBlock]:
        """Return a table of all modes, and a line for each speed with aperiodic motion."""
        unit, cycles = speed_unit(), frequency_unit()
        heads = (f"speed ({unit.label})", "mode", f"frequency ({cycles.label})", "damping ratio", "whirl")
        table = text_table(f"{self.rotor}, {self.mass} mass", heads, left=("whirl",))
        remarks: list[TextBlock] = []
        for speed, result in self.speeds.items():
            mark = f", {EXTRAPOLATED}" if result.extrapolated else ""
            modes = zip(result.frequencies, result.damping_ratios, result.whirl, strict=True)
            for number, (frequency, ratio, whirl) in enumerate(modes, start=1):
                ratio_text, direction = damping_cells(ratio, frequency, whirl)
                shown = unit.number(speed, 6), str(number), cycles.number(frequency, 6)
                table.add_row(*shown, ratio_text, direction + mark)
            if result.real_eigenvalues:
                real = ", ".join(f"{value:.4g}" for value in result.real_eigenvalues)
                remarks.append(
                    f"at {unit.text(speed, 6)} there is also aperiodic motion, exp(s t), with s = {real} 1/s"
                )
        return [table, *remarks, *limit_notes(self.limits, self.speeds)]


@dataclass(frozen=True, eq=False)
class ModeShape:
    """A mode shape.

    x, y
        Complex displacement of each node, each of shape (nodes,). It is dimensionless, and the largest displacement has
        the size 1. The phase is that of `rotor_analysis.modes.Mode.shape`, and the figure shows the real part.
    kind
        `cylindrical` or `conical` for rigid-body motion, `flexural` for bending.
    rigid_share
        Fraction of the kinetic energy in rigid-body motion (1).
    crossings
        Number of points between the ends where the shaft line crosses the axis.
    """

    x: Annotated[Complex, Layout.PAIRS]
    y: Annotated[Complex, Layout.PAIRS]
    kind: str
    rigid_share: float
    crossings: int


@dataclass(frozen=True, eq=False, repr=False)
class ModeShapes(WarnedResult, DrawnResult):
    """Modes of a rotor at several spin speeds.

    frequencies
        Frequencies, damping ratios and whirl directions at all speeds.
    shapes
        Mode shapes, by spin speed (rad/s).
    z
        Axial position of the nodes (m), shape (nodes,).
    description, modes
        The rotor, and its modes by spin speed, which the figure shows.
    """

    name: ClassVar[str] = "modes"

    frequencies: Annotated[NaturalFrequencies, Layout.MERGED]
    shapes: dict[float, tuple[ModeShape, ...]]
    z: Annotated[tuple[float, ...], JsonKey("z_m")]
    description: Annotated[Rotor, Layout.OMITTED]
    modes: Annotated[dict[float, tuple[Mode, ...]], Layout.OMITTED]

    @property
    def speed(self) -> float:
        """First spin speed (rad/s)."""
        return next(iter(self.frequencies.speeds))

    def text(self) -> list[TextBlock]:
        """Return tables of the modes and of their shapes."""
        headings = (f"speed ({speed_unit().label})", "mode", "rigid motion (% of kinetic energy)", "crossings")
        table = labelled_table("Mode shapes", "kind", *headings)
        for speed, shapes in self.shapes.items():
            for number, shape in enumerate(shapes, start=1):
                share = f"{100.0 * shape.rigid_share:.1f}"
                table.add_row(shape.kind, speed_unit().number(speed, 6), str(number), share, str(shape.crossings))
        return [*self.frequencies.text(), table, *self.warning_lines()]


def modes(
    rotor: RotorSource = None,
    *,
    mass: MassModel | None = None,
    speeds: Number | Sequence[Number] = "0",
    count: int = 8,
) -> ModeShapes:
    """Return the natural frequencies, damping ratios, whirl directions and shapes of the modes at several speeds.

    (lambda^2 M + lambda (C + Omega G) + K + D) phi = 0     (3.1 to 3.6)

    Modes with a damping ratio above 1/sqrt(2) come last, because their response has no peak.

    Parameters
    ----------
    rotor
        A rotor or a rotor file; by default the packs' default rotor.
    mass
        Mass matrix, `diagonal` or `consistent`; by default that of the rotor file.
    speeds
        Spin speeds (rad/s), each a number or a string with its unit, or one string separated by commas.
    count
        Number of modes, the lowest first.

    Raises
    ------
    ValueError
        If the rotor file cannot be read or an argument is out of range.

    Examples
    --------
    >>> print(str(modes("compressor", speeds="0", count=1)).splitlines()[0].strip())
    compressor, consistent mass
    """
    description = load_rotor(rotor)
    mass = mass or description.shaft.mass_matrix
    model = supported_rotor(description, mass).model
    modes_at = {Omega: _lowest(model, Omega, count) for Omega in spin_speeds(speeds)}
    limits = limits_of((*description.bearings, *description.seals))
    frequencies = {
        Omega: replace(_at_speed(model, Omega, result), extrapolated=is_extrapolated(limits, Omega))
        for Omega, result in modes_at.items()
    }
    z = np.array(description.shaft.nodes)
    shapes = {Omega: tuple(_shape(model, z, mode) for mode in result) for Omega, result in modes_at.items()}
    natural_frequencies = NaturalFrequencies(description.name, mass, frequencies, limits)
    warnings = implausible_sizes(description)
    return ModeShapes(natural_frequencies, shapes, description.shaft.nodes, description, modes_at, warnings=warnings)


def _lowest(model: Matrices, Omega: float, count: int) -> tuple[Mode, ...]:
    """Return the lowest modes with a resonance and, if more are needed, the lowest modes without one."""
    require(count >= 1, "count", count, "1 or more")
    ordered = sorted(modes_of(model, Omega), key=lambda mode: mode.damping_ratio > RESONANT)
    return tuple(ordered[:count])


def _at_speed(model: Matrices, Omega: float, modes: Sequence[Mode]) -> ModesAtSpeed:
    return ModesAtSpeed(
        tuple(mode.frequency for mode in modes),
        tuple(mode.damping_ratio for mode in modes),
        tuple(mode.whirl for mode in modes),
        tuple(mode.eigenvalue.real for mode in overdamped_modes(model, Omega)),
    )


def _shape(model: Matrices, z: Array, mode: Mode) -> ModeShape:
    x, y = translations(model, mode.shape).T
    return ModeShape(x, y, *kind_of(model, z, mode.shape))
