"""Targets that a first design misses, and the parts of the machine that limit it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

import numpy as np

from amb_analysis.machine.demand_limits import control_amplitude
from amb_analysis.machine.feedback import demanded_currents
from amb_analysis.machine.machine import Machine
from amb_analysis.machine.response import synchronous_response
from amb_analysis.studies.stability_margin import ZONES
from amb_assessment.first_design.levitation import BANDS, BEYOND, LEFT, RANGE, STIFFNESS, TRIP, Levitation, Pid
from amb_assessment.first_design.sizing import INDUSTRIAL, MachineSizes
from amb_cosim.cosim.system.values import RPM
from rotor_analysis.mode_reach import REACHED, ModeReach, mode_reaches
from rotor_analysis.rigid_body import rigid_body
from rotor_analysis.rotor import Rotor

ACCEPTED = "AB"  # zones of unrestricted long-term operation (ISO 14839-3)
MODES = 6  # of the free rotor that are examined
MET = 0.99  # share of a target from which it counts as met
WELL = 0.3  # least reach of a bearing that damps a mode well
NUTATION = 0.2  # relative difference from that of the rigid rotor, due to bearings and bending


def shortfalls(machine: Machine, levitation: Levitation, speed: float) -> tuple[str, ...]:
    """Return sentences about the targets that a stable loop misses, and the causes; empty if it meets all targets.

    Parameters
    ----------
    machine
        The machine with the gains of the design.
    levitation
        Behaviour of its loop.
    speed
        Highest speed in operation (rad/s).
    """
    return (
        *loop_shortfalls(levitation),
        *_damping_shortfall(machine.rotor, levitation),
        *hindering_positions(machine, levitation, speed),
        *saturating_axes(machine, speed),
    )


def loop_shortfalls(loop: Levitation) -> Iterator[str]:
    """Yield sentences about the sensitivity and damping targets that a loop misses, or about its growing motion."""
    if not loop.is_stable:
        yield loop.least_damped
        return
    if loop.zone != "A":
        yield (
            f"sensitivity {loop.peak.value:.3g} is in zone {loop.zone} (zone A ends at {ZONES['A']:g}): "
            f"{loop.peak.axis}, {loop.peak.frequency:.0f} Hz at {loop.peak.speed * RPM:.0f} rpm"
        )
    bands = zip(BANDS, loop.ratios, loop.wanted, strict=True)
    short = [f"{zeta:.3g} {where} ({wanted:.3g} is wanted)" for where, zeta, wanted in bands if zeta < MET * wanted]
    if short:
        yield f"damping ratio {', '.join(short)}: {loop.least_damped} is furthest from its target"
    if loop.motion_in_runs:
        yield (
            f"in simulated runs, {loop.motion_in_runs}, although the loop with all modes of the rotor is stable: "
            "control drives the residual shapes that replace the higher modes in runs; state a wider band in the "
            "[reduction] of the rotor file"
        )


def soft_bearings(pid: Pid, k_s: Mapping[str, float]) -> Iterator[str]:
    """Yield a sentence on bearings whose stiffness is below the wanted share of their K_s, and on how to lower K_s.

        |S| = K_s/K_b at low frequency,   K_s ~ I_0^2/s_0^3                                            (1)

    Parameters
    ----------
    pid
        The gains.
    k_s
        K_s of the bearings (N/m).
    """
    short = {bearing: k / k_s[bearing] for bearing, k in pid.k_b.items() if k < MET * STIFFNESS * k_s[bearing]}
    if short:
        shares = ", ".join(f"{bearing} {share:.2g}" for bearing, share in short.items())
        yield (
            f"stiffness K_b over K_s: {shares} ({STIFFNESS:g} is wanted); the sensitivity is at least K_s/K_b at low "
            "frequency; a smaller bias current or a wider gap lowers K_s"
        )


def high_voltage(sizes: MachineSizes) -> Iterator[str]:
    """Yield a sentence if the coils need more voltage than industrial amplifiers supply; it also suggests other coils.

    U = 2 R I_max + L I_b 2 Omega,   I_b ~ I_max ~ 1/N,   R ~ L ~ N^2,   hence U ~ N at the same force     (1)
    """
    if sizes.voltage_limit <= INDUSTRIAL:
        return
    turns = max(math.floor(sizes.turns * INDUSTRIAL / sizes.voltage_limit), 1)
    more = sizes.turns / turns
    yield (
        f"amplifiers of {sizes.voltage_limit:.0f} V: coils of {sizes.turns} turns with a bias of "
        f"{sizes.bias_current:.3g} A need that voltage at {sizes.speed * RPM:.0f} rpm, but industrial amplifiers "
        f"provide only about {INDUSTRIAL:g} V; for the same force, {sizes.voltage_limit / more:.0f} V suffice with "
        f"{turns} turns, a bias of {more * sizes.bias_current:.3g} A and a current limit of "
        f"{more * sizes.current_limit:.3g} A"
    )


def _damping_shortfall(rotor: Rotor, loop: Levitation) -> Iterator[str]:
    """Yield a sentence on the rotor's damping if it is so small that high modes limit the gains."""
    least = loop.wanted[2] / LEFT
    if loop.zone not in ACCEPTED and least < 2.0 * BEYOND:
        yield (
            f"rotor {rotor.name!r} has damping ratios from {least:.3g} upwards, so its high bending modes tolerate "
            "hardly any gain beyond the phase lead of the PID: measure its damping, or use faster amplifiers "
            "(--bandwidth) and samples (--sample-time)"
        )


def hindering_positions(machine: Machine, loop: Levitation, speed: float) -> Iterator[str]:
    """Yield a sentence on each bending mode, up to twice the trip speed, that bearings drive or cannot damp."""
    is_short = any(zeta < wanted for zeta, wanted in zip(loop.ratios[:2], loop.wanted[:2], strict=True))
    for mode in mode_reaches(machine.rotor, machine.magnets, MODES):
        if mode.frequency <= 2.0 * TRIP * speed and mode.deciding.value < (WELL if is_short else REACHED):
            yield _mode_shortfall(mode)


def _mode_shortfall(mode: ModeReach) -> str:
    at, name = mode.deciding, f"bending mode {mode.number} ({mode.frequency / (2.0 * math.pi):.0f} Hz)"
    if at.value < -REACHED:
        return (
            f"{name} has a node between {at.bearing} and {at.sensor}: the shape is {at.at_magnet:+z.2f} at the magnet "
            f"and {at.at_sensor:+z.2f} at the sensor, so the damping of a PID drives it; move the sensor to the "
            "magnet's side of the node"
        )
    places = ", ".join(
        f"{reach.bearing} {reach.at_magnet:+z.2f}, {reach.sensor} {reach.at_sensor:+z.2f}" for reach in mode.bearings
    )
    return f"{name} has nodes close to magnets or sensors, so no gains damp it well: its shape is {places}"


def advice(rotor: Rotor, loop: Levitation, speed: float) -> str:
    """Return what to change if a motion of the loop grows, depending on the kind of motion.

    Far above its natural frequencies on the bearings, a rigid rotor whirls forward at the nutation frequency omega:

        I_d omega = I_p Omega                                                                          (1)

    This frequency exceeds the spin speed Omega if I_p > I_d, as in a flywheel, although the rotor does not bend.

    Parameters
    ----------
    rotor
        The rotor.
    loop
        Behaviour of the loop.
    speed
        Highest speed in operation (rad/s).
    """
    if loop.frequency <= RANGE * speed:
        return "move sensors to their bearings, move bearings apart, or lower the speed"
    body = rigid_body(rotor)
    ratio = body.polar_inertia / body.diametral_inertia
    if abs(loop.frequency - ratio * loop.speed) <= NUTATION * loop.frequency:
        return (
            f"it is the nutation of the rigid rotor, at I_p/I_d = {ratio:.3g} times its speed: lower the speed or the "
            "ratio, or enter the measured [damping] of the rotor, because damped bending modes tolerate more gain"
        )
    return (
        "the rotor bends: enter its measured [damping], and move sensors to their bearings, away from nodes of the mode"
    )


def saturating_axes(machine: Machine, speed: float) -> Iterator[str]:
    """Yield sentences on axes that saturate at top speed because unbalance demands too much current from them."""
    motion = synchronous_response(machine, np.array([speed]), [machine.unbalanced_points]).reshape(-1)
    demands = np.abs(demanded_currents(machine, speed, speed) @ motion)
    for (bearing, axis), demand in zip(machine.loop.lateral_axes, demands, strict=True):
        largest = float(control_amplitude(machine, bearing, axis, speed / (2.0 * math.pi)))
        if demand > largest:
            yield (
                f"{bearing}.{axis} saturates: the unbalance demands {demand:.3g} A at {speed * RPM:.0f} rpm, but "
                f"controller, coils and amplifiers allow only {largest:.3g} A"
            )
