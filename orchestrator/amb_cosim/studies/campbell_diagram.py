"""Study of the natural frequencies of a rotor over its spin speed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np

from amb_cosim.presentation.text_tables import TextPart, text_table
from amb_cosim.studies.inputs import Number, RotorSource, rotor_of, speed_range
from amb_cosim.studies.result import DrawnResult
from fmi_export.model import Array
from rotor_analysis.campbell import campbell as follow_modes
from rotor_analysis.modes import Whirl
from rotor_analysis.shaft import MassModel
from rotor_analysis.supported_rotor import supported_rotor

POINTS = 161  # speeds of the diagram


@dataclass(frozen=True, eq=False)
class ModeOverSpeed:
    """One mode at each speed of the diagram.

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
    """A spin speed (rad/s) that equals the damped frequency of a mode, with the number of the mode, from 1."""

    speed: Annotated[float, "rad/s"]
    mode: int
    damping_ratio: float
    whirl: Whirl


@dataclass(frozen=True, eq=False, repr=False)
class CampbellDiagram(DrawnResult):
    """Natural frequencies and damping ratios over the spin speed, and critical speeds.

    rotor, mass
        Name of the rotor, and the mass matrix of its model.
    speeds
        Spin speeds (rad/s), ascending, shape (n,).
    modes
        The lowest modes at the first speed, followed over the others.
    critical_speeds
        Where modes cross the synchronous line, ascending.
    """

    name: ClassVar[str] = "campbell"

    rotor: str
    mass: MassModel
    speeds: Annotated[Array, "rad/s"]
    modes: tuple[ModeOverSpeed, ...]
    critical_speeds: tuple[CriticalSpeedRow, ...]

    def text(self) -> list[TextPart]:
        """Return the table of critical speeds."""
        table = text_table("Critical speeds", ("(rad/s)", "(Hz)", "mode", "damping ratio", "whirl"), left=("whirl",))
        for row in self.critical_speeds:
            hertz = f"{row.speed / (2 * np.pi):.3f}"
            table.add_row(f"{row.speed:.3f}", hertz, str(row.mode), f"{row.damping_ratio:.4f}", row.whirl)
        return [table]


def campbell(
    rotor: RotorSource = None, *, mass: MassModel | None = None, up_to: Number = "628 rad/s", count: int = 8
) -> CampbellDiagram:
    """Return the natural frequencies and damping ratios of a rotor over the spin speed, and its critical speeds.

    (lambda^2 M + lambda (C + Omega G) + K) phi = 0     (3.1 to 3.6);   critical speeds: |Im lambda| = Omega

    Parameters
    ----------
    rotor
        A rotor or a rotor file; the packs' default without.
    mass
        Mass matrix, `diagonal` or `consistent`; as the rotor says by default.
    up_to
        Highest spin speed (rad/s), or a text with its unit.
    count
        Number of modes, the lowest first.

    Raises
    ------
    ValueError
        If the rotor file cannot be read or an argument is out of range.
    """
    description = rotor_of(rotor)
    mass = mass or description.shaft.mass_matrix
    diagram = follow_modes(supported_rotor(description, mass).model, speed_range(up_to, POINTS), count)
    modes = tuple(
        ModeOverSpeed(frequencies, ratios, tuple(mode.whirl if mode else None for mode in track))
        for frequencies, ratios, track in zip(diagram.frequencies, diagram.damping_ratios, diagram.tracks, strict=True)
    )
    critical = tuple(CriticalSpeedRow(c.Omega, c.number, c.damping_ratio, c.whirl) for c in diagram.critical_speeds)
    return CampbellDiagram(description.name, mass, diagram.speeds, modes, critical)
