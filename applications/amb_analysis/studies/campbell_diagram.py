"""Study of the natural frequencies of a rotor as a function of its spin speed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, ClassVar

from amb_analysis.studies.coefficient_limits import EXTRAPOLATED, Limits, is_extrapolated, limit_notes, limits_of
from amb_analysis.studies.damping_zones import damping_cells
from amb_analysis.studies.inputs import Number, reach_of, speed_range, spin_speed
from amb_analysis.studies.result import DrawnResult, WarnedResult
from amb_cosim.presentation.json_data import Layout
from amb_cosim.presentation.text_tables import TextBlock, text_table
from amb_cosim.presentation.units import speed_unit
from amb_files.checks import require
from array_types import Array
from rotor_analysis.analysis_model import ACCURACY, analysis_model
from rotor_analysis.campbell import campbell as follow_modes
from rotor_analysis.implausible_sizes import implausible_sizes
from rotor_analysis.modes import Whirl
from rotor_analysis.parts import table_speeds
from rotor_analysis.refinement import with_samples
from rotor_analysis.rotor_file import RotorSource, load_rotor
from rotor_analysis.shaft import MassModel

POINTS = 161  # speeds of the diagram, with those of tables of coefficients


@dataclass(frozen=True, eq=False)
class ModeOverSpeed:
    """A mode, followed over the speeds of the diagram.

    frequencies
        Damped natural frequencies (rad/s), shape (n,); NaN where the mode does not oscillate.
    damping_ratios
        Damping ratios (1), shape (n,); NaN where the mode does not oscillate.
    whirl
        Whirl direction at each speed; None where the mode does not oscillate.
    """

    frequencies: Annotated[Array, "rad/s"]
    damping_ratios: Array
    whirl: tuple[Whirl | None, ...]


@dataclass(frozen=True)
class CriticalSpeedRow:
    """A spin speed (rad/s) that equals the damped frequency of a mode; `mode` is its number, counted from 1.

    `extrapolated` is true if a table of coefficients does not cover this speed.
    """

    speed: Annotated[float, "rad/s"]
    mode: int
    damping_ratio: float
    whirl: Whirl
    extrapolated: bool = False


@dataclass(frozen=True, eq=False, repr=False)
class CampbellDiagram(WarnedResult, DrawnResult):
    """Natural frequencies and damping ratios over the spin speed, and critical speeds.

    rotor, mass
        Name of the rotor, and the mass matrix of its model.
    speeds
        Spin speeds (rad/s), ascending, shape (n,).
    modes
        The lowest modes at the first speed, followed over the other speeds.
    critical_speeds
        Crossings of the modes with the synchronous line, ascending.
    coordinates, of
        Numbers of coordinates of the analysed model and of the full model.
    error
        Largest relative error of the modes' eigenvalues, compared with the full model at the lowest and the highest
        speed.
    operating_speed
        Operating speed of the machine (rad/s); None if it is not stated.
    limits
        Validity limits of the coefficients of bearings and seals.
    is_free
        Whether the rotor has no bearings; if so, the title of the figure says so.
    """

    name: ClassVar[str] = "campbell"

    rotor: str
    mass: MassModel
    speeds: Annotated[Array, "rad/s"]
    modes: tuple[ModeOverSpeed, ...]
    critical_speeds: tuple[CriticalSpeedRow, ...]
    coordinates: int
    of: int
    error: float
    operating_speed: Annotated[float | None, "rad/s"] = None
    limits: Limits = ()
    is_free: Annotated[bool, Layout.OMITTED] = False

    def text(self) -> list[TextBlock]:
        """Return a table of the critical speeds, and a line about their accuracy."""
        unit = speed_unit()
        table = text_table(
            f"Critical speeds up to {unit.text(self.speeds[-1])}",
            (f"speed ({unit.label})", "mode", "damping ratio", "whirl"),
            left=("whirl",),
        )
        for row in self.critical_speeds:
            mark = f", {EXTRAPOLATED}" if row.extrapolated else ""
            ratio, whirl = damping_cells(row.damping_ratio, row.speed, row.whirl)
            table.add_row(unit.number(row.speed, 6), str(row.mode), ratio, whirl + mark)
        notes = [*limit_notes(self.limits, self.speeds), *self.warning_lines()]
        if self.coordinates == self.of:
            return [self._answer(), table, *notes]
        reduced = (
            f"computed with {self.coordinates} coordinates instead of {self.of}; eigenvalues agree within "
            f"{self.error:.0e} with those of the"
        )
        return [self._answer(), table, *notes, f"{reduced} full model; the option `full` analyses it"]

    def _answer(self) -> str:
        """State the number of critical speeds, the least damped of them, and the nearest to the operating speed.

        The whirl of both is stated, because unbalance hardly excites backward whirl.
        """
        unit, criticals = speed_unit(), self.critical_speeds
        if not criticals:
            return f"No critical speed of {self.rotor} up to {unit.text(self.speeds[-1])}"
        worst = min(criticals, key=lambda row: row.damping_ratio)
        count = f"{len(criticals)} critical speed{'s' * (len(criticals) > 1)} of {self.rotor}"
        least = (
            f"the least damped at {unit.text(worst.speed)} (mode {worst.mode}, {worst.whirl}, damping ratio "
            f"{worst.damping_ratio:.3g})"
        )
        answer = f"{count} up to {unit.text(self.speeds[-1])}, {least}"
        if self.operating_speed is None:
            return answer
        speed = self.operating_speed
        nearest = min(criticals, key=lambda row: abs(row.speed - speed))
        return f"{answer}; the nearest to {unit.text(speed)} is {unit.text(nearest.speed)} ({nearest.whirl})"


def campbell(
    rotor: RotorSource = None,
    *,
    mass: MassModel | None = None,
    up_to: Number | None = None,
    count: int = 8,
    speed: Number | None = None,
    full: bool = False,
) -> CampbellDiagram:
    """Return the natural frequencies and damping ratios of a rotor over the spin speed, and its critical speeds.

    (lambda^2 M + lambda (C + Omega G) + K) phi = 0     (3.1 to 3.6);   critical speeds: |Im lambda| = Omega

    Parameters
    ----------
    rotor
        A rotor or a rotor file; by default the packs' default rotor.
    mass
        Mass matrix, `diagonal` or `consistent`; by default that of the rotor file.
    up_to
        Highest spin speed (rad/s), or a string with its unit; by default 1.25 times `speed`. If `speed` is not given,
        the default is the highest speed that the rotor file states (`[reduction] speed`), or else 6000 rpm.
    count
        Number of modes, the lowest first.
    speed
        Operating speed of the machine, which the figure marks.
    full
        Whether to analyse the full model instead of the smallest model with eigenvalues accurate to 1e-5.

    Raises
    ------
    ValueError
        If the rotor file cannot be read or an argument is out of range.

    Examples
    --------
    >>> diagram = campbell("compressor", up_to="12000 rpm", count=4)
    >>> f"{diagram.critical_speeds[-1].speed:.0f} rad/s"
    '331 rad/s'
    """
    description = load_rotor(rotor)
    mass = mass or description.shaft.mass_matrix
    operating = None if speed is None else spin_speed(speed)
    highest = reach_of(description, operating) if up_to is None else up_to
    speeds = with_samples(speed_range(highest, POINTS), table_speeds((*description.bearings, *description.seals)))
    require(count >= 1, "count", count, "1 or more")
    analysed = analysis_model(description, mass, speeds, count, 0.0 if full else ACCURACY)
    model = analysed.supported.model
    diagram = follow_modes(model, speeds, count)
    modes = tuple(
        ModeOverSpeed(frequencies, ratios, tuple(mode.whirl if mode else None for mode in track))
        for frequencies, ratios, track in zip(diagram.frequencies, diagram.damping_ratios, diagram.tracks, strict=True)
    )
    limits = limits_of((*description.bearings, *description.seals))
    critical = tuple(
        CriticalSpeedRow(c.Omega, c.number, c.damping_ratio, c.whirl, is_extrapolated(limits, c.Omega))
        for c in diagram.critical_speeds
    )
    sizes = model.size, analysed.supported.full.size
    return CampbellDiagram(
        description.name,
        mass,
        speeds,
        modes,
        critical,
        *sizes,
        analysed.error,
        operating,
        limits,
        not description.bearings,
        warnings=implausible_sizes(description),
    )
