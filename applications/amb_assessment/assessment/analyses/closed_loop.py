"""Frequencies and logarithmic decrements of the controlled machine's vibrations over speed, with seals and stages."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from amb_analysis.machine.coupled import coupled_loop
from amb_analysis.studies.damping_zones import REQUIRED, ZONES
from amb_analysis.studies.loop_vibrations import Vibrations, begun_later, followed, vibrations, whirl_of
from amb_assessment.assessment.format.quantities import AnalysisResult, Quantity, ResultTable, declare
from amb_assessment.assessment.physics.assessed_machine import AssessedMachine, hertz, rpm
from amb_assessment.assessment.physics.stability import least_stable, motion_and_speed, spectral_radius
from amb_assessment.assessment.physics.stages import real_coefficients, table_notes, with_tables
from amb_assessment.reporting.panels import Curve, Panel, curve
from amb_cosim.results.loop_stability import LARGEST
from array_types import Array
from rotor_analysis.refinement import refined

declare("spectral_radius", "1", ("growth_rate", "frequency", "N"))
declare("decrement", "1", ("frequency", "N"))
declare("decrement_anywhere", "1", ("frequency", "N"), "Smallest logarithmic decrement over all frequencies")

POINTS = 41  # speeds
MIN_DECREMENT, MAX_DECREMENT = 1e-3, 3.0  # logarithmic decrements in the figure, whose axis is logarithmic
ROUNDING = 1e-9  # relative difference of decrements of the same pole


def result_of(subject: AssessedMachine) -> AnalysisResult:
    """Return the stability up to the trip speed, the damped frequencies, and the smallest decrement in operation."""
    loop = coupled_loop(subject, real_coefficients(subject))
    speed, limit = subject.file.speed, subject.file.highest_frequency
    speeds = np.unique([*np.linspace(0.01 * speed.tripping, speed.tripping, POINTS), speed.lowest, speed.highest])
    speeds = with_tables(subject, speeds)
    result = [vibrations(loop, float(Omega)).up_to(limit) for Omega in speeds]
    operating = speeds[(speeds >= speed.lowest) & (speeds <= speed.tripping)]
    least = least_decrement_over("decrement", lambda Omega: vibrations(loop, Omega).up_to(limit), operating)
    at_all_frequencies = least_decrement_over("decrement_anywhere", lambda Omega: vibrations(loop, Omega), operating)
    stability = spectral_radius("spectral_radius", least_stable(subject))
    tracks = followed(result, len(result[0].poles))
    tracks += begun_later(result, tracks)
    at = int(np.flatnonzero(speeds == speed.highest)[0])
    rows = tuple(
        (f"{hertz(s.imag):.1f}", f"{rpm(s.imag):.0f}", f"{decrement:.3f}", whirl_of(sense))
        for s, decrement, sense in zip(result[at].poles, result[at].decrements(), result[at].senses, strict=True)
    )
    heads = ("frequency (Hz)", "synchronous at (rpm)", "decrement", "whirl")
    table = ResultTable(f"Vibrations at {rpm(speed.highest):.0f} rpm", heads, rows)
    notes = table_notes(subject, speed.tripping)
    notes += [
        f"Vibrations of the sampled loop up to {hertz(limit):.0f} Hz; z = exp(s T). The frequencies are damped, at one "
        "speed; the part `critical_map` has the modes without damping."
    ]
    if hertz(limit) > 0.5 / loop.sample_time:
        half = f"Half the sample rate is {0.5 / loop.sample_time:.0f} Hz"
        notes.append(
            f"{half}: faster vibrations are listed at the frequency of the rotor's mode, but control sees their alias."
        )
    notes += [
        "Stability is judged from all poles, including drifts without vibration, at all speeds from 0 to "
        f"{rpm(speed.tripping):.0f} rpm; for stages without a table over speed, the coefficients at the largest speed "
        "are used."
    ]
    if subject.file.has_synchronous_control:
        notes.append("The scenario's synchronous control (rolac_enable) is off in all parts of this assessment.")
    measured = (stability, least, at_all_frequencies)
    return AnalysisResult(measured, _panels(subject, speeds, result, tracks), (table,), tuple(notes))


def least_decrement(quantity: str, vibrations: Sequence[tuple[float, Vibrations]]) -> Quantity:
    """Return the smallest logarithmic decrement of vibrations at several speeds (rad/s), and where it occurs.

    If the loop is not stable, the decrement of its fastest-growing pole is included. A growing drift, which does not
    vibrate, has the value -`LARGEST`.
    """
    candidates = [
        (float(d), Omega, float(s.imag), float(sense))
        for Omega, at_speed in vibrations
        for d, s, sense in zip(at_speed.decrements(), at_speed.poles, at_speed.senses, strict=True)
    ]
    least, Omega, omega, sense = min(candidates, default=(LARGEST, 0.0, 0.0, 0.0))
    growing = [at_speed.stability for _, at_speed in vibrations if not at_speed.stability.is_stable]
    worst = min(growing, key=lambda stability: stability.decrement, default=None)
    if worst is not None and worst.decrement < least * (1.0 + ROUNDING):
        facts = {"frequency": hertz(worst.frequency), "N": float(rpm(worst.speed))}
        note = "the value stands for any growing drift" if worst.is_drift else ""
        return Quantity(quantity, motion_and_speed(worst), worst.decrement, "1", facts, note, needs_stable_loop=True)
    if not candidates:
        return Quantity(quantity, "nothing vibrates", LARGEST, "1", needs_stable_loop=True)
    where = f"{hertz(omega):.1f} Hz at {rpm(Omega):.0f} rpm, {whirl_of(sense)}"
    facts = {"frequency": hertz(omega), "N": float(rpm(Omega))}
    return Quantity(quantity, where, least, "1", facts, needs_stable_loop=True)


def least_decrement_over(quantity: str, vibrating: Callable[[float], Vibrations], speeds: Array) -> Quantity:
    """Return the smallest logarithmic decrement at any speed (rad/s) from the first to the last of `speeds`."""
    by_speed: dict[float, Vibrations] = {}

    def growths(more: Array) -> Array:
        new = {Omega: vibrating(Omega) for Omega in map(float, more)}
        by_speed.update(new)
        return np.array([-least_decrement(quantity, [item]).value for item in new.items()])

    refined(growths, speeds, lambda values: values, resonant=False)
    return least_decrement(quantity, list(by_speed.items()))


def _panels(
    subject: AssessedMachine, speeds: Array, vibrations: list[Vibrations], tracks: list[list[int | None]]
) -> tuple[Panel, ...]:
    frequency: list[Curve] = []
    damping: list[Curve] = []
    beyond: list[Curve] = []
    for track in tracks:
        rows = [k for k, n in enumerate(track) if n is not None]
        chosen = [(k, n) for k, n in enumerate(track) if n is not None]
        s = np.array([vibrations[k].poles[n] for k, n in chosen])
        last, number = chosen[-1]
        name = f"{hertz(s[-1].imag):.0f} Hz {whirl_of(vibrations[last].senses[number])}"
        decrement = -2.0 * np.pi * s.real / s.imag
        is_drawn = decrement.min() < MAX_DECREMENT
        (frequency if is_drawn else beyond).append(curve(name, rpm(speeds[rows]), hertz(s.imag)))
        if is_drawn:
            damping.append(curve(name, rpm(speeds[rows]), np.clip(decrement, MIN_DECREMENT, MAX_DECREMENT)))
    frequency += beyond  # last, so that the others have the same colours in both figures
    lowest = min((float(line.y.min()) for line in damping), default=MIN_DECREMENT)
    lowest = min(lowest, 0.5 * REQUIRED)  # the axis holds the limit and shows what is below it
    ends = rpm(np.array([0.0, subject.file.speed.tripping]))
    frequency.append(curve("1x", ends, ends / 60.0, "dashed"))
    for limit in (subject.file.speed.lowest, subject.file.speed.highest):
        at = rpm(np.array([limit, limit]))
        frequency.append(curve(f"{at[0]:.0f} rpm", at, [0.0, hertz(subject.file.highest_frequency)], "dashed"))
        damping.append(curve(f"{at[0]:.0f} rpm", at, [lowest, MAX_DECREMENT], "dashed"))
    title = f"Logarithmic decrements, up to {MAX_DECREMENT:g}"
    if lowest <= MIN_DECREMENT:
        title += f"; {MIN_DECREMENT:g} stands for all smaller values, including those of growing vibrations"
    return (
        Panel("Damped frequencies", "speed (rpm)", "Hz", tuple(frequency)),
        Panel(title, "speed (rpm)", "decrement", tuple(damping), log="y", zones=ZONES[1:], holds=(REQUIRED,)),
    )
