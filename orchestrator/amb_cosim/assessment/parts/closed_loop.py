"""Vibrations of the machine under control over speed, with seals and stages: frequencies and logarithmic decrements."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from amb_cosim.assessment.coefficients import real_coefficients
from amb_cosim.assessment.coupled import coupled_loop
from amb_cosim.assessment.findings import PartResult, PartTable, Quantity
from amb_cosim.assessment.more_modes import kept_modes, with_modes
from amb_cosim.assessment.subject import MODES, Subject, hertz, rpm
from amb_cosim.linear.loop import Loop
from amb_cosim.reporting.panels import Curve, Panel, curve
from amb_cosim.studies.closed_loop_poles import Vibrations, followed, vibrations
from fmi_export.model import Array
from rotor_analysis.parts import Bearing

TITLE = "Closed loop over speed: damped frequencies and logarithmic decrements"
POINTS = 41  # speeds
SHOWN = 3.0  # largest logarithmic decrement in the figure
LARGEST = 1e3  # decrement that stands for motion that hardly vibrates


def answer(subject: Subject) -> PartResult:
    """Return damped frequencies and decrements over speed, and the least decrement over the operating speeds."""
    loop = coupled_loop(subject, real_coefficients(subject))
    speed, limit = subject.file.speed, subject.file.highest_frequency
    speeds = np.unique([*np.linspace(0.01 * speed.tripping, speed.tripping, POINTS), speed.lowest, speed.highest])
    result = [_within(vibrations(loop, float(Omega)), limit) for Omega in speeds]
    operating = [k for k, Omega in enumerate(speeds) if speed.lowest <= Omega <= speed.tripping]
    least = least_decrement("decrement", [(float(speeds[k]), result[k]) for k in operating])
    edges = (speed.lowest, speed.highest, speed.tripping)
    everything = least_decrement("decrement_anywhere", [(edge, vibrations(loop, edge)) for edge in edges])
    tracks = followed(result, len(result[0].poles))
    at = int(np.flatnonzero(speeds == speed.highest)[0])
    rows = tuple(
        (f"{hertz(s.imag):.1f}", f"{rpm(s.imag):.0f}", f"{-2.0 * np.pi * s.real / s.imag:.3f}", _sense(sense))
        for s, sense in zip(result[at].poles, result[at].senses, strict=True)
    )
    table = PartTable(f"Vibrations at {rpm(speed.highest):.0f} 1/min", ("Hz", "1/min", "decrement", "whirl"), rows)
    ends = [f"{s.name} from {s.at_speed[0].speed:g} to {s.at_speed[-1].speed:g} rad/s" for s in _not_covering(subject)]
    notes = [f"Coefficients of seals are held beyond their tables: {', '.join(ends)}."] if ends else []
    notes += [
        f"Vibrations up to {hertz(limit):.0f} Hz, of the sampled loop, z = exp(s T); at most half the sample rate."
    ]
    if hertz(limit) > 0.5 / loop.sample_time:
        notes.append(f"Half the sample rate is {0.5 / loop.sample_time:.0f} Hz: what is beyond it appears below.")
    measured = (least, everything, *_with_all_modes(subject, edges))
    return PartResult(measured, _panels(subject, speeds, result, tracks), (table,), tuple(notes))


def _with_all_modes(subject: Subject, speeds: Sequence[float]) -> list[Quantity]:
    """Return the least decrement of a rotor with the modes too that its reduction leaves out, if it leaves out any.

    Sampled control may drive a mode that no co-simulation has (spillover: M. J. Balas, IEEE Trans. Autom. Control 23
    (1978) 673). Those far above half the sample rate are left out still.
    """
    retained, most = kept_modes(subject)
    if subject.rotor.reduction.method == "none" or retained >= min(MODES, most):
        return []
    with with_modes(subject, min(MODES, most)) as finer:
        loop = coupled_loop(finer, real_coefficients(finer))
        result = least_decrement("decrement_all_modes", [(speed, vibrations(loop, speed)) for speed in speeds])
    note = f"with {min(MODES, most)} modes in a plane of motion, {retained} in co-simulation"
    return [replace(result, note=note)]


def _not_covering(subject: Subject) -> list[Bearing]:
    """Return the seals whose tables do not reach from the least to the trip speed."""
    low, high = subject.file.speed.lowest, subject.file.speed.tripping
    tabled = [seal for seal in subject.rotor.seals if seal.at_speed]
    return [seal for seal in tabled if seal.at_speed[0].speed > low or seal.at_speed[-1].speed < high]


def least_decrement(quantity: str, found: list[tuple[float, Vibrations]]) -> Quantity:
    """Return the least logarithmic decrement of vibrations at speeds (rad/s), and where it is."""
    all_of = [
        (float(d), Omega, float(s.imag), float(sense))
        for Omega, of in found
        for d, s, sense in zip(decrements(of), of.poles, of.senses, strict=True)
    ]
    if not all_of:
        return Quantity(quantity, "nothing vibrates", LARGEST, "1")
    least, Omega, omega, sense = min(all_of)
    where = f"{hertz(omega):.1f} Hz at {rpm(Omega):.0f} 1/min, {_sense(sense)}"
    return Quantity(quantity, where, least, "1", {"frequency": hertz(omega), "N": float(rpm(Omega))})


def decrements(found: Vibrations) -> Array:
    """Return logarithmic decrements, -2 pi Re s/Im s."""
    return np.asarray(-2.0 * np.pi * found.poles.real / found.poles.imag)


def vibrations_within(loop: Loop, Omega: float, limit: float) -> Vibrations:
    """Return the vibrations of a loop at a speed up to a frequency (rad/s both)."""
    return _within(vibrations(loop, Omega), limit)


def _within(found: Vibrations, limit: float) -> Vibrations:
    retained = found.poles.imag <= limit
    return Vibrations(found.poles[retained], found.senses[retained])


def _sense(sense: float) -> str:
    return "mixed" if abs(sense) < 0.05 else "forward" if sense > 0.0 else "backward"


def _panels(
    subject: Subject, speeds: Array, found: list[Vibrations], tracks: list[list[int | None]]
) -> tuple[Panel, ...]:
    frequency: list[Curve] = []
    damping: list[Curve] = []
    beyond: list[Curve] = []
    for track in tracks:
        alive = [k for k, n in enumerate(track) if n is not None]
        chosen = [(k, n) for k, n in enumerate(track) if n is not None]
        s = np.array([found[k].poles[n] for k, n in chosen])
        last, number = chosen[-1]
        name = f"{hertz(s[-1].imag):.0f} Hz {_sense(found[last].senses[number])}"
        decrement = -2.0 * np.pi * s.real / s.imag
        displayed = decrement.min() < SHOWN
        (frequency if displayed else beyond).append(curve(name, rpm(speeds[alive]), hertz(s.imag)))
        if displayed:
            damping.append(curve(name, rpm(speeds[alive]), np.minimum(decrement, SHOWN)))
    frequency += beyond  # last, so that the others have the same colours in both figures
    ends = rpm(np.array([0.0, subject.file.speed.tripping]))
    frequency.append(curve("once per turn", ends, ends / 60.0, "dashed"))
    damping.append(curve("0.1", ends, [0.1, 0.1], "dashed"))
    for limit in (subject.file.speed.lowest, subject.file.speed.highest):
        at = rpm(np.array([limit, limit]))
        frequency.append(curve(f"{at[0]:.0f} 1/min", at, [0.0, hertz(subject.file.highest_frequency)], "dashed"))
        damping.append(curve(f"{at[0]:.0f} 1/min", at, [0.0, SHOWN], "dashed"))
    return (
        Panel("Damped frequencies", "speed (1/min)", "Hz", tuple(frequency)),
        Panel(f"Logarithmic decrements, up to {SHOWN:g}", "speed (1/min)", "decrement", tuple(damping)),
    )
