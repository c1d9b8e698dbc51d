"""Stability of a machine with its seals and stages, from zero to the trip speed."""

from __future__ import annotations

import numpy as np

from amb_analysis.machine.coupled import NOMINAL, MachineVariation, coupled_loop
from amb_assessment.assessment.format.quantities import Quantity
from amb_assessment.assessment.physics.assessed_machine import AssessedMachine, hertz, rpm
from amb_assessment.assessment.physics.axial_cases import axial_instability
from amb_assessment.assessment.physics.stages import real_coefficients, with_tables
from amb_cosim.results.loop_stability import LoopStability
from array_types import Array

SPEEDS = 41  # from zero to the trip speed, before refinement


def least_stable(subject: AssessedMachine, variation: MachineVariation = NOMINAL, count: int = SPEEDS) -> LoopStability:
    """Return the stability at the least stable speed of a run-up from zero to the trip speed."""
    return coupled_loop(subject, real_coefficients(subject), variation).least_stable(speeds_of_run_up(subject, count))


def speeds_of_run_up(subject: AssessedMachine, count: int) -> Array:
    """Return ascending speeds (rad/s) up to the trip speed: `count` evenly spaced ones, and the speeds in the files."""
    speed = subject.file.speed
    return with_tables(subject, np.unique([*np.linspace(0.0, speed.tripping, count), speed.lowest, speed.highest]))


def spectral_radius(quantity: str, stability: LoopStability, name: str = "") -> Quantity:
    """Return the spectral radius of a loop, labelled with `name`, the decisive pole's motion, and the spin speed."""
    N = float(rpm(stability.speed))
    facts = {"growth_rate": stability.growth_rate, "frequency": hertz(stability.frequency), "N": N}
    return Quantity(quantity, f"{name}{motion_and_speed(stability)}", stability.radius, "1", facts, stability.note)


def motion_and_speed(stability: LoopStability) -> str:
    """Return the motion of the decisive pole and the spin speed, as text."""
    return f"{stability.motion}, |z| = {stability.radius:.7f}, at {rpm(stability.speed):.0f} rpm"


def instability(subject: AssessedMachine) -> str:
    """Return why a machine's rotor does not levitate (across or along its shaft), or "" if it levitates."""
    stability = least_stable(subject)
    if not stability.is_stable:
        return f"the loop is not stable: {motion_and_speed(stability)}"
    return axial_instability(subject)
