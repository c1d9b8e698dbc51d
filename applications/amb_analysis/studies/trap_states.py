"""Synchronous states and bearing currents, in the form in which the study of traps reports them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from amb_actuator.interface import DYNAMIC
from amb_analysis.machine.axis_capability import current_amplitude
from amb_analysis.machine.demand_limits import demand_amplitude
from amb_analysis.steady_contact.rubbing_rotor import RubbingRotor
from amb_analysis.steady_contact.stability import TURNS
from amb_analysis.steady_contact.trap_map import Regime, SolvedState
from amb_cosim.model_constants.magnetic_bearing import current_range
from amb_cosim.results.component_names import ACTUATOR

VIBRATIONS = 6  # reported vibrations about a state, the least damped first
KINDS = {
    Regime.FREE: "the rotor rotates freely; no steady contact is stable",
    Regime.BOTH: "the rotor rotates freely or stays in contact, depending on the start",
    Regime.CONTACT: "the rotor stays in contact; no stable contact-free orbit exists",
    Regime.WHIRL: "the rotor rubs unsteadily; no stable contact-free orbit exists, and no steady contact settles in "
    f"{TURNS:.0f} turns",
}


@dataclass(frozen=True, eq=False)
class BearingCurrent:
    """Synchronous current of a bearing.

    amplitude, phase
        Amplitude in each axis (A), and phase by which the current in x leads the unbalance (deg).
    allowed
        Largest amplitude that the coils and the controller permit (A).
    """

    amplitude: Annotated[float, "A"]
    phase: Annotated[float, "deg"]
    allowed: Annotated[float, "A"]

    @property
    def is_allowed(self) -> bool:
        """Whether the amplitude does not exceed `allowed`."""
        return self.amplitude <= self.allowed


@dataclass(frozen=True, eq=False)
class Vibration:
    """A small vibration about a state: whirl frequency (rad/s), growth rate (1/s) and damping ratio (1).

    The frequency of backward whirl is negative.
    """

    frequency: Annotated[float, "rad/s"]
    growth: Annotated[float, "1/s"]
    damping_ratio: float


@dataclass(frozen=True, eq=False)
class SynchronousState:
    """A state of steady rotation.

    contact
        Sites in contact.
    normal_forces, friction_forces, phases
        Normal force (N), friction force (N) and phase relative to the unbalance's reference (deg) at each site in
        contact.
    orbits
        Distance of the journal from the centre at each site (m).
    currents
        Current of each bearing.
    growth, whirl_frequency, damping_ratio
        Growth rate (1/s), frequency (rad/s, negative if backward) and damping ratio (1) of the least damped small
        motion about the state.
    vibrations
        Vibrations of the rotor in this state, the least damped first.
    stable, settles
        Whether small motions decay, and whether they decay to 1/e within a thousand turns.
    """

    contact: tuple[str, ...]
    normal_forces: Annotated[dict[str, float], "N"]
    friction_forces: Annotated[dict[str, float], "N"]
    phases: Annotated[dict[str, float], "deg"]
    orbits: Annotated[dict[str, float], "m"]
    currents: dict[str, BearingCurrent]
    growth: Annotated[float, "1/s"]
    whirl_frequency: Annotated[float, "rad/s"]
    damping_ratio: float
    vibrations: tuple[Vibration, ...]
    stable: bool
    settles: bool

    def beyond(self, Omega: float) -> str:
        """Describe in words whether the rotor stays in this state."""
        if self.stable:
            stays = "stays in contact" if self.contact else "stays free"
            return stays if self.settles else f"{stays}, vibrating"
        if abs(self.whirl_frequency - Omega) < 1e-6 * Omega:
            return "moves to another state"
        return "whirls backward" if self.whirl_frequency < 0.0 else "whirls forward"


def regime_of(states: tuple[SynchronousState, ...]) -> Regime:
    """Return the possible behaviour of a rotor that has these states."""
    free = any(not state.contact and state.stable for state in states)
    trapped = any(state.contact and state.stable for state in states)
    settled = any(state.contact and state.settles for state in states)
    return (Regime.BOTH if trapped else Regime.FREE) if free else (Regime.CONTACT if settled else Regime.WHIRL)


def report_state(state: SolvedState, machine: RubbingRotor, Omega: float) -> SynchronousState:
    """Convert a solved state at a speed (rad/s) to the form that the study reports."""
    small = state.small
    return SynchronousState(
        contact=state.contact,
        normal_forces=state.N,
        friction_forces=state.friction,
        phases={site: math.degrees(psi) for site, psi in state.psi.items()},
        orbits=state.radius,
        currents=currents_of(state.currents, machine, Omega),
        growth=small.growth,
        whirl_frequency=small.frequency,
        damping_ratio=small.damping,
        vibrations=tuple(
            Vibration(float(w), float(rate), float(-rate / math.hypot(rate, w)))
            for rate, w in zip(small.rates[:VIBRATIONS], small.frequencies[:VIBRATIONS], strict=True)
        ),
        stable=small.is_stable,
        settles=small.settles(Omega),
    )


def currents_of(values: Mapping[str, complex], machine: RubbingRotor, Omega: float) -> dict[str, BearingCurrent]:
    """Convert complex currents (A) at a speed (rad/s) to the form that the study reports, with each bearing's limit."""
    return {
        bearing: BearingCurrent(abs(value), math.degrees(np.angle(value)), allowed_current(machine, bearing, Omega))
        for bearing, value in values.items()
    }


def allowed_current(machine: RubbingRotor, bearing: str, Omega: float) -> float:
    """Return the largest amplitude (A) that coils, voltage, controller and DAC permit at a speed (rad/s).

    The voltage limit applies only to the coils of dynamic amplifiers (`amb_actuator.amplifier`).
    """
    levitated, result = machine.machine, math.inf
    if ACTUATOR in levitated.parameters:
        is_dynamic = levitated.parameters[ACTUATOR]["amplifier"] == DYNAMIC
        for axis in "xy":
            p = levitated.axis(bearing, axis)
            result = min(result, *map(abs, current_range(p)))
            if is_dynamic:
                result = min(result, float(current_amplitude(p, Omega / (2.0 * math.pi))))
        axes = [direction for name, direction in levitated.loop.axes if name == bearing]
        result = min([result, *(demand_amplitude(levitated, bearing, axis) for axis in axes)])
    return max(result, 0.0)
