"""The test force of an identification over speed: how strong it is, and how long ROLAC halts for it."""

from __future__ import annotations

import math
from functools import partial
from typing import Any

import numpy as np
from rich.table import Table

from amb_analysis.receptance_table import SPEEDS
from amb_cosim.studies import modal, rolac_figures
from amb_cosim.studies.outcome import Outcome
from rolac_controller.excitation import FORCE, amplitude_at, periods
from rolac_controller.names import N_SLOTS
from rotor_analysis.rotor import require

LOWEST = 5.0  # Hz, below which there is no synchronous signal
POINTS_PER_HZ = 20
JUMP = 30.0  # Hz, where the rule of 6.6 is not continuous


def test_force(up_to: str) -> Outcome:
    """S(f) and A(f) of the test force, periods of a slot and duration of an identification (Fig. 5.2; 6.3 to 6.6)."""
    highest = modal.speed(up_to, "up-to") / (2.0 * math.pi)
    require(highest > LOWEST, "up-to", f"{highest:g} Hz", f"> {LOWEST:g} Hz")
    below = math.nextafter(JUMP, 0.0)
    grid = np.linspace(LOWEST, highest, round(POINTS_PER_HZ * (highest - LOWEST)) + 1)
    jump = [below, JUMP] if highest > JUMP else []
    thesis = [speed / (2.0 * math.pi) for speed in SPEEDS]
    data: dict[str, Any] = {
        **_columns(sorted({*grid.tolist(), *jump})),
        "at_the_jump": _columns(jump),
        "at_the_speeds_of_the_thesis": _columns(thesis),
    }
    return Outcome(data, {"test_force": partial(rolac_figures.test_force, data)}, _as_text(data))


def _columns(frequencies: list[float]) -> dict[str, list[float]]:
    """S, A (N), N_per and t_halt (s) at each frequency (Hz)."""
    amplitudes = [amplitude_at(f) for f in frequencies]
    slots = [periods(f) for f in frequencies]
    return {
        "frequencies_hz": frequencies,
        "s": [FORCE / amplitude for amplitude in amplitudes],
        "amplitude_N": amplitudes,
        "periods_per_slot": slots,
        "t_halt_s": [N_SLOTS * n / f for n, f in zip(slots, frequencies, strict=True)],
    }


def _as_text(data: dict[str, Any]) -> list[Table | str]:
    table = Table(title="Test force of an identification", title_justify="left", box=None, padding=(0, 2, 0, 0))
    for heading in ("f (Hz)", "S", "A (N)", "N_per", "t_halt (s)"):
        table.add_column(heading, justify="right", no_wrap=True)
    columns = data["at_the_speeds_of_the_thesis"].values()
    for f, s, amplitude, slots, halt in zip(*columns, strict=True):
        table.add_row(f"{f:g}", f"{s:.2f}", f"{amplitude:.1f}", f"{slots:.0f}", f"{halt:.2f}")
    parts: list[Table | str] = [table]
    if data["at_the_jump"]["frequencies_hz"]:
        before, after = data["at_the_jump"]["amplitude_N"]
        parts.append(f"S is not continuous at {JUMP:g} Hz: the force jumps from {before:.0f} to {after:.0f} N")
    return parts
