"""The axial loop of a machine under each static force of its thrust bearing."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from amb_analysis.linear.axial_loop import AxialLoop
from amb_analysis.linear.stability import stability_of
from amb_analysis.studies.sensitivity_curves import bands, curve_frequencies, peaks_of
from amb_assessment.assessment.format.thrust_bearing import ThrustBearing
from amb_assessment.assessment.physics.assessed_machine import AssessedMachine, hertz
from amb_cosim.results.loop_stability import LARGEST, LoopStability
from array_types import Array
from rotor_analysis.refinement import refined
from thrust_bearings.disc import OperatingPoint

NAME = "thrust.z"


@dataclass(frozen=True)
class LoadCase:
    """The axial loop at the operating point of the bearing under a static force (N)."""

    load: float
    point: OperatingPoint
    loop: AxialLoop

    @property
    def name(self) -> str:
        """The force as text."""
        return f"{self.load:.4g} N"

    @cached_property
    def stability(self) -> LoopStability:
        """Stability of the loop, which does not depend on the spin speed."""
        return stability_of(self.loop.whole.A, self.loop.sample_time)

    @cached_property
    def sensitivity(self) -> tuple[Array, Array]:
        """Frequencies (Hz) up to the 2 kHz of ISO 14839-3, and |S| at these; valid only for a stable loop."""
        return self._bands[0]

    @property
    def peaks(self) -> list[tuple[float, float]]:
        """Largest |S| of a stable loop and its frequency (Hz), up to 2 kHz and, if the sample rate allows, above it."""
        return [peaks_of(frequencies, S[None])[0] for frequencies, S in self._bands]

    @cached_property
    def _bands(self) -> list[tuple[Array, Array]]:
        first = [curve_frequencies(self.loop.poles, self.loop.sample_time, *b) for b in bands(self.loop.sample_time)]
        return [refined(lambda more: np.abs(self.loop.sensitivity(more)), hertz, lambda S: S) for hertz in first]

    @cached_property
    def least(self) -> tuple[float, float]:
        """Smallest logarithmic decrement of the vibrations (-`LARGEST` for a growing drift), and its frequency (Hz)."""
        decrements = [(float(-2.0 * np.pi * s.real / s.imag), float(hertz(s.imag))) for s in self.loop.vibrations]
        if not self.stability.is_stable and not any(decrement <= 0.0 for decrement, _ in decrements):
            decrements.append((-LARGEST, 0.0))  # without enough stiffness the rotor drifts away
        return min(decrements, default=(LARGEST, 0.0))


def thrust_bearing_of(subject: AssessedMachine) -> ThrustBearing:
    """Return the thrust bearing of a machine.

    Raises
    ------
    ValueError
        If the machine has no thrust bearing.
    """
    bearing = subject.file.thrust_bearing
    if bearing is None:
        raise ValueError(f"machine {subject.file.name} has no [thrust_bearing]")
    return bearing


def weight_along_z(subject: AssessedMachine) -> float:
    """Return the weight of the rotor along z (N)."""
    return subject.file.axial_gravity * subject.rotor.mass


def static_forces(subject: AssessedMachine) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Return the static forces (N) that the bearing can carry, and the static forces beyond its capacity.

    Together, the two results contain at most three forces. Two of them balance the smallest and the largest thrust. The
    third is the force of least magnitude between these two, at which the negative stiffness of the bearing is smallest.
    """
    bearing = thrust_bearing_of(subject)
    ends = bearing.loads(weight_along_z(subject))
    between = float(np.clip(0.0, min(ends), max(ends)))
    loads, capacity = tuple(dict.fromkeys((*ends, between))), bearing.bearing.capacity
    return tuple(x for x in loads if abs(x) <= capacity), tuple(x for x in loads if abs(x) > capacity)


def load_case(subject: AssessedMachine, load: float, factors: tuple[float, float] = (1.0, 1.0)) -> LoadCase:
    """Return the loop under a static force (N), with K_i and K_s multiplied by `factors` (1)."""
    bearing = thrust_bearing_of(subject)
    point = bearing.bearing.operating_point(load)
    return LoadCase(load, point, bearing.loop(subject.rotor.mass, point, subject.axial_control, factors))


def load_cases(subject: AssessedMachine) -> list[LoadCase]:
    """Return the loops under the static forces that the bearing carries."""
    return [load_case(subject, load) for load in static_forces(subject)[0]]


def least_stable_case(cases: Mapping[str, LoadCase]) -> tuple[str, LoopStability]:
    """Return the name and the stability of the least stable loop."""
    name = max(cases, key=lambda key: cases[key].stability.radius)
    return name, cases[name].stability


def axial_instability(subject: AssessedMachine) -> str:
    """Return why a machine's thrust bearing does not hold the rotor; "" if the bearing holds it or does not exist."""
    if subject.file.thrust_bearing is None:
        return ""
    _, beyond = static_forces(subject)
    if beyond:
        capacity = subject.file.thrust_bearing.bearing.capacity
        forces = " and ".join(f"{load:.4g} N" for load in beyond)
        return f"the thrust bearing cannot carry {forces}; its capacity is {capacity:.4g} N"
    name, worst = least_stable_case({case.name: case for case in load_cases(subject)})
    return "" if worst.is_stable else f"the axial loop under {name} is not stable: {worst.motion}"
