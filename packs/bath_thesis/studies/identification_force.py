"""Study of an identification's test force as a function of spin speed (Fig. 5.2, equations 6.3 to 6.6)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np

from amb_analysis.studies.inputs import Number, spin_speed
from amb_analysis.studies.result import DrawnResult
from amb_analysis.studies.sensor_receptance import levitated_receptance
from amb_cosim.model_constants.controller_data import SPEEDS
from amb_cosim.model_constants.rotor_models import control_loop
from amb_cosim.presentation.json_data import Layout
from amb_cosim.presentation.text_tables import TextBlock, text_table
from amb_cosim.presentation.units import SIZES, speed_unit
from amb_files.checks import require
from array_types import Array
from rolac_controller.excitation import FORCE, amplitude_at, periods
from rotor_analysis.rotor_file import load_rotor

K_B, C_B = 1e6, 5000.0  # N/m and N s/m of the closed bearings
LOWEST = 5.0  # Hz, below which there is no synchronous signal
POINTS_PER_HZ = 20
HEADINGS = ("S", "A (N)", "N_per", "t_halt (s)", "moves mb1 (mm)", "mb2 (mm)")
INTENDED = 1e-4  # m, amplitude for which the gain of 220 N is chosen
SLOTS = 6  # of an identification of four axes
JUMP = 30.0  # Hz, where S of (6.6) is not continuous


@dataclass(frozen=True, eq=False)
class ForceColumns:
    """Test force as a function of frequency; all arrays have the shape (n,).

    frequencies
        Frequencies (Hz).
    s
        S(f) (1) (6.6).
    amplitude
        Amplitude of the force, A = 220 N/S (N) (6.5).
    periods_per_slot
        Revolutions in a slot, N_per (1) (6.3).
    t_halt
        Duration of an identification (s), during which ROLAC is halted (6.4).
    response_mb1, response_mb2
        Amplitude (m) of the rig's journal in each bearing under the test force there, with bearings of 1e6 N/m and 5000
        N s/m. The thesis aims at about 0.1 mm.
    """

    frequencies: Annotated[Array, "Hz"]
    s: Array
    amplitude: Annotated[Array, "N"]
    periods_per_slot: Array
    t_halt: Annotated[Array, "s"]
    response_mb1: Annotated[Array, "m"]
    response_mb2: Annotated[Array, "m"]


@dataclass(frozen=True, eq=False, repr=False)
class IdentificationForce(DrawnResult):
    """Test force of an identification as a function of frequency.

    columns
        The force over the range of frequencies.
    at_the_jump
        The force just below 30 Hz and at 30 Hz; empty if the range does not extend beyond 30 Hz.
    at_the_speeds_of_the_thesis
        The force at the identification speeds of the thesis.
    """

    name: ClassVar[str] = "test_force"

    columns: Annotated[ForceColumns, Layout.MERGED]
    at_the_jump: ForceColumns
    at_the_speeds_of_the_thesis: ForceColumns

    def text(self) -> list[TextBlock]:
        """Return a table for the speeds of the thesis, and a line about the jump."""
        unit, hertz = speed_unit(), SIZES["speed"]["Hz"]
        table = text_table("Test force of an identification", (f"speed ({unit.label})", *HEADINGS))
        at = self.at_the_speeds_of_the_thesis
        responses = zip(1e3 * at.response_mb1, 1e3 * at.response_mb2, strict=True)
        rows = zip(at.frequencies, at.s, at.amplitude, at.periods_per_slot, at.t_halt, responses, strict=True)
        for f, s, amplitude, slots, halt, by_bearing in rows:
            cells = (f"{response:.3f}" for response in by_bearing)
            table.add_row(unit.number(hertz * f), f"{s:.2f}", f"{amplitude:.1f}", f"{slots:.0f}", f"{halt:.2f}", *cells)
        over_range = 1e3 * np.concatenate([self.columns.response_mb1, self.columns.response_mb2])
        parts: list[TextBlock] = [
            table,
            f"the test force moves the journal in its bearing by {over_range.min():.3f} to {over_range.max():.3f} mm; "
            f"the thesis chose the gain of the force for about {1e3 * INTENDED:g} mm",
        ]
        if len(self.at_the_jump.frequencies):
            before, after = self.at_the_jump.amplitude
            at_jump = unit.text(hertz * JUMP)
            parts.append(f"S is not continuous at {at_jump}: the force jumps from {before:.0f} to {after:.0f} N")
        return parts


def test_force(up_to: Number = "50 Hz") -> IdentificationForce:  # noqa: PT028  # no test: a force
    """Return amplitude and duration of an identification's test force as functions of spin speed (6.3 to 6.6).

    Parameters
    ----------
    up_to
        Highest spin speed (rad/s), or a string with its unit.

    Raises
    ------
    ValueError
        If `up_to` is not a speed above 5 Hz.
    """
    highest = spin_speed(up_to, "up_to") / (2.0 * math.pi)
    require(highest > LOWEST, "up_to", f"{highest:g} Hz", f"> {LOWEST:g} Hz")
    below = math.nextafter(JUMP, 0.0)
    grid = np.linspace(LOWEST, highest, round(POINTS_PER_HZ * (highest - LOWEST)) + 1)
    jump = [below, JUMP] if highest > JUMP else []
    return IdentificationForce(
        columns=_columns(sorted({*grid.tolist(), *jump})),
        at_the_jump=_columns(jump),
        at_the_speeds_of_the_thesis=_columns([speed / (2.0 * math.pi) for speed in SPEEDS]),
    )


def _columns(frequencies: Sequence[float]) -> ForceColumns:
    """Return the test force at each frequency (Hz)."""
    amplitudes = [amplitude_at(f) for f in frequencies]
    slots = [periods(f) for f in frequencies]
    durations = [SLOTS * n / f for n, f in zip(slots, frequencies, strict=True)]
    s = [FORCE / amplitude for amplitude in amplitudes]
    columns = (np.array(column, dtype=np.float64) for column in (frequencies, s, amplitudes, slots, durations))
    return ForceColumns(*columns, *_responses(frequencies, amplitudes))


def _responses(frequencies: Sequence[float], amplitudes: Sequence[float]) -> tuple[Array, ...]:
    """Return the amplitude (m) of the rig's journal in each bearing under a test force (N) in x at that bearing."""
    rotor = load_rotor("bath_rig_thesis")
    loop = control_loop(rotor)
    R = levitated_receptance(rotor, 2.0 * math.pi * np.array(frequencies), K_B, C_B).reshape(-1, *loop.shape)
    pairs = [
        (loop.sensor_names.index(sensor), k) for k, (_, direction, sensor) in enumerate(loop.axes) if direction == "x"
    ]
    return tuple(np.array(amplitudes) * np.abs(R[:, sensor, k]) for sensor, k in pairs)
