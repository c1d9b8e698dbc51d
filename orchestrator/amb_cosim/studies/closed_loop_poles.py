"""Study of the poles of the levitated rotor under its controller, over the spin speed."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Annotated, ClassVar

import numpy as np
from scipy.optimize import linear_sum_assignment

from amb_cosim.cosim.basics.choices import Flavour
from amb_cosim.cosim.system.values import Raw
from amb_cosim.linear.linearisable import of_prepared
from amb_cosim.linear.linearise import model_of
from amb_cosim.linear.loop import Complex, Loop
from amb_cosim.presentation.text_tables import TextPart, text_table
from amb_cosim.results.places import PLANT
from amb_cosim.scenario.simulation import prepare
from amb_cosim.studies.inputs import Number, controlled, speed_range
from amb_cosim.studies.result import MachineResult
from fmi_export.model import Array
from rotor_analysis.checks import require
from rotor_analysis.modes import Whirl
from rotor_analysis.rotor_file import load_rotor

POINTS = 61  # speeds of the diagram
LOWEST = 1e-3  # of the highest speed, where the diagram begins: a rotor that stands still has no sense of whirl
OVERDAMPED = 0.995  # damping ratio from which a pole does not count as a vibration
TURN = 0.3  # of a pole's size: what counts as much as another sense of whirl when poles are paired
CLEAR = 0.05  # sense of whirl, from -1 to 1, up to which it is mixed


@dataclass(frozen=True, eq=False)
class PoleOverSpeed:
    """One vibration at each speed of the diagram; NaN where it is none.

    frequencies
        Damped frequencies |Im s| (rad/s), shape (n,).
    damping_ratios
        -Re s / |s| (1), shape (n,); negative where the loop is not stable.
    decrements
        Logarithmic decrements, -2 pi Re s / |Im s| (1), shape (n,): the logarithm of one amplitude over the next.
    whirl
        Sense of whirl of the bearings; None where there is no vibration.
    """

    frequencies: Annotated[Array, "rad/s"]
    damping_ratios: Array
    decrements: Array
    whirl: tuple[Whirl | None, ...]


@dataclass(frozen=True, eq=False, repr=False)
class ClosedLoopPoles(MachineResult):
    """Poles of the sampled loop over the spin speed, z = exp(s T).

    sample_time
        Sample time of the controller (s).
    speeds
        Spin speeds (rad/s), ascending, shape (n,).
    poles
        The slowest vibrations at the first speed, followed over the others.
    least_damped
        Least damping ratio of all vibrations at each speed (1), shape (n,), followed or not.
    unstable
        Speeds (rad/s) at which the loop is not stable.
    operating_speed
        That of the scenario (rad/s).
    """

    name: ClassVar[str] = "poles"

    sample_time: Annotated[float, "s"]
    speeds: Annotated[Array, "rad/s"]
    poles: tuple[PoleOverSpeed, ...]
    least_damped: Array
    unstable: Annotated[tuple[float, ...], "rad/s"]
    operating_speed: Annotated[float, "rad/s"]

    def text(self) -> list[TextPart]:
        """Return a table of the poles at the lowest and at the highest speed, and where the loop is not stable."""
        table = text_table(
            f"{self.rotor}: poles under control",
            ("(rad/s)", "frequency (Hz)", "damping ratio", "logarithmic decrement", "whirl"),
            left=("whirl",),
        )
        for k in (0, -1):
            for pole in self.poles:
                if pole.whirl[k] is not None:
                    hertz = f"{pole.frequencies[k] / (2.0 * math.pi):.2f}"
                    shares = (f"{pole.damping_ratios[k]:.4f}", f"{pole.decrements[k]:.3f}")
                    table.add_row(f"{self.speeds[k]:.4g}", hertz, *shares, pole.whirl[k] or "")
        if not self.unstable:
            return [table, "stable at all of these speeds"]
        return [table, f"not stable from {self.unstable[0]:.4g} to {self.unstable[-1]:.4g} rad/s"]


@dataclass(frozen=True)
class Vibrations:
    """Poles s (rad/s) with Im s > 0, and their senses of whirl from -1, backward, to 1, forward; shape (n,) each."""

    poles: Complex
    senses: Array

    def ratios(self) -> Array:
        """Return the damping ratios."""
        return np.asarray(-self.poles.real / np.abs(self.poles))


def poles(
    scenario: str | Path | None = None,
    *,
    rotor: str | Path | None = None,
    controller: str | PathLike[str] | None = None,
    up_to: Number | None = None,
    count: int = 8,
    set: Mapping[str, Raw] | None = None,
    flavour: Flavour = "native",
) -> ClosedLoopPoles:
    """Return frequencies, damping and sense of whirl of the vibrations of a levitated rotor over its spin speed.

    s = ln(z) / T, z the eigenvalues of the sampled loop (`amb_cosim.linearise`): the Campbell diagram of the levitated
    machine. A vibration beyond half the sampling frequency appears below it.

    Parameters
    ----------
    scenario, rotor, controller
        Machine, its parameters and its control (`studies.inputs.controlled`).
    up_to
        Highest spin speed (rad/s), or a text with its unit; 1.5 times that of the scenario by default.
    count
        Number of vibrations that are followed, the slowest first.
    set, flavour
        Values of parameters by `component.variable`, numbers or texts with units; flavour of the FMUs.

    Raises
    ------
    ValueError
        If a value is not allowed, or the scenario has no magnetic bearings under a controller.
    """
    require(count >= 1, "count", count, "1 or more")
    values = controlled(scenario, rotor, controller)
    prepared = prepare(values.machine(), set, flavour=flavour)
    loop = Loop(of_prepared(prepared))
    highest = 1.5 * prepared.plan.speed if up_to is None else up_to
    speeds = speed_range(highest, POINTS)
    speeds[0] = LOWEST * speeds[-1]
    result = [vibrations(loop, float(Omega)) for Omega in speeds]
    tracks = followed(result, count)
    least = np.array([of_speed.ratios().min(initial=1.0) for of_speed in result])
    return ClosedLoopPoles(
        scenario=values.name,
        rotor=load_rotor(values.rotor).name,
        sample_time=loop.sample_time,
        speeds=speeds,
        poles=tuple(_over_speed(result, track) for track in tracks),
        least_damped=least,
        unstable=tuple(float(Omega) for Omega, ratio in zip(speeds, least, strict=True) if ratio <= 0.0),
        operating_speed=prepared.plan.speed,
    )


def vibrations(loop: Loop, Omega: float) -> Vibrations:
    """Return the vibrations of a loop at a spin speed (rad/s), the slowest first.

    The sense of whirl is 2 Im(x conj(y)) / (|x|^2 + |y|^2), summed over the journals of the bearings.
    """
    bearings = list(dict.fromkeys(bearing for bearing, _ in loop.axes))
    displayed = [f"{PLANT}.{bearing}.{axis}" for bearing in bearings for axis in "xy"]
    model = model_of(loop.linear_components.at(Omega), loop.demands[:1], displayed)
    z, vectors = np.linalg.eig(model.A)
    alive = np.abs(z) > 1e-9
    s = np.zeros(len(z), dtype=np.complex128)
    s[alive] = np.log(z[alive].astype(np.complex128)) / loop.sample_time
    below = s.imag < (1.0 - 1e-9) * math.pi / loop.sample_time
    vibrates = alive & below & (s.imag > 0.0) & (-s.real < OVERDAMPED * np.abs(s))
    chosen = np.flatnonzero(vibrates)[np.argsort(s[vibrates].imag, kind="stable")]
    x, y = (model.C @ vectors[:, chosen])[0::2], (model.C @ vectors[:, chosen])[1::2]
    size = (np.abs(x) ** 2 + np.abs(y) ** 2).sum(axis=0)
    turning = 2.0 * (x * y.conj()).imag.sum(axis=0)
    return Vibrations(s[chosen], np.divide(turning, size, out=np.zeros(len(chosen)), where=size > 0.0))


def followed(found: list[Vibrations], count: int) -> list[list[int | None]]:
    """Return, for each of the first vibrations, its number at every speed; None from where it is lost.

    Each is paired with what is nearest to where its last two poles lead, |s - s_expected| / |s|, the sense of whirl
    counting as `TURN`.
    """
    tracks: list[list[int | None]] = [[k] for k in range(min(count, len(found[0].poles)))]
    for n in range(1, len(found)):
        alive = [track for track in tracks if track[-1] is not None]
        now = found[n]
        cost = np.array([_distances(found, track, now, n) for track in alive]).reshape(len(alive), len(now.poles))
        pairs = dict(zip(*map(list, linear_sum_assignment(cost)), strict=True))
        for k, track in enumerate(alive):
            best = pairs.get(k)
            track.append(best if best is not None and cost[k, best] < TURN else None)
        for track in tracks:
            if len(track) == n:
                track.append(None)
    return tracks


def _distances(found: list[Vibrations], track: list[int | None], now: Vibrations, n: int) -> Array:
    last, before = track[-1], track[-2] if n > 1 else None
    assert last is not None
    expected = found[n - 1].poles[last]
    if before is not None:
        expected = 2.0 * expected - found[n - 2].poles[before]
    turn = np.abs(now.senses - found[n - 1].senses[last]) / 2.0
    return np.asarray(np.abs(now.poles - expected) / np.abs(expected) + TURN * turn)


def _over_speed(found: list[Vibrations], track: list[int | None]) -> PoleOverSpeed:
    pairs = list(zip(found, track, strict=True))
    s = np.array([np.nan if k is None else at.poles[k] for at, k in pairs], dtype=np.complex128)
    ratios = np.array([np.nan if k is None else at.ratios()[k] for at, k in pairs])
    whirl = tuple(None if k is None else _whirl(float(at.senses[k])) for at, k in pairs)
    return PoleOverSpeed(s.imag, ratios, -2.0 * math.pi * s.real / s.imag, whirl)


def _whirl(sense: float) -> Whirl:
    return "mixed" if abs(sense) <= CLEAR else "forward" if sense > 0.0 else "backward"
