"""What a study of traps tells of a state: where a rotor can stay, by itself or with its unbalance, and what then."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from amb_actuator.force import limited_current
from amb_actuator.interface import DYNAMIC
from amb_cosim.results.places import ACTUATOR, CONTROLLER
from amb_cosim.rub.rubbing_rotor import RubbingRotor
from amb_cosim.rub.trap_map import Kind, State

KINDS = {
    Kind.FREE: "it turns without contact, and no steady contact is stable",
    Kind.BOTH: "it may turn without contact, or stay in contact",
    Kind.CONTACT: "no orbit misses all sites; it comes to rest in contact",
    Kind.WHIRL: "no orbit misses all sites, and it comes to rest in no steady contact: it rubs unsteadily",
}


@dataclass(frozen=True, eq=False)
class BearingCurrent:
    """Synchronous current of a bearing.

    amplitude, phase
        In each axis (A), and by what it leads the unbalance in x (deg).
    allowed
        Amplitude up to which the coils and the controller follow (A).
    """

    amplitude: Annotated[float, "A"]
    phase: Annotated[float, "deg"]
    allowed: Annotated[float, "A"]

    @property
    def is_allowed(self) -> bool:
        """Whether the amplitude is within the limit."""
        return self.amplitude <= self.allowed


@dataclass(frozen=True, eq=False)
class SynchronousState:
    """A state in which the rotor turns steadily.

    contact
        Sites in contact.
    normal_forces, friction_forces, phases
        At each of them (N, N, deg from the unbalance's reference).
    orbits
        Distance of the journal from the centre at every site (m).
    currents
        Of each bearing.
    growth, whirl_frequency, damping_ratio
        Of the small motion about it that decays least: rate (1/s), frequency (rad/s, negative backward), damping (1).
    stable, settles
        Whether it decays, and within a thousand turns.
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
    stable: bool
    settles: bool

    def beyond(self, Omega: float) -> str:
        """Return what becomes of the rotor there, in words."""
        if self.stable:
            return "stays" if self.settles else "stays, vibrating"
        if abs(self.whirl_frequency - Omega) < 1e-6 * Omega:
            return "leaves to another state"
        return "whirls backward" if self.whirl_frequency < 0.0 else "whirls forward"


@dataclass(frozen=True, eq=False)
class SustainedWhirl:
    """A whirl that needs no unbalance.

    contact, frequency, normal_forces
        Sites in contact, whirl frequency (rad/s, negative backward), force at each (N).
    slips
        Whether the journals slip as friction assumes; otherwise they roll first.
    stable
        Whether small motion about it decays.
    accurate
        Whether the reduced rotor is accurate at this frequency.
    """

    contact: tuple[str, ...]
    frequency: Annotated[float, "rad/s"]
    normal_forces: Annotated[dict[str, float], "N"]
    slips: bool
    stable: bool
    accurate: bool


def kind_of(states: tuple[SynchronousState, ...]) -> Kind:
    """Return what a rotor can do that has these states."""
    free = any(not state.contact and state.stable for state in states)
    trapped = any(state.contact and state.stable for state in states)
    rests = any(state.contact and state.settles for state in states)
    return (Kind.BOTH if trapped else Kind.FREE) if free else (Kind.CONTACT if rests else Kind.WHIRL)


def told(state: State, machine: RubbingRotor, Omega: float) -> SynchronousState:
    """Return a state at a speed (rad/s) as it is told."""
    small = state.small
    return SynchronousState(
        contact=state.contact,
        normal_forces=state.N,
        friction_forces=state.friction,
        phases={site: math.degrees(psi) for site, psi in state.psi.items()},
        orbits=state.radius,
        currents=currents_of(state.currents, machine),
        growth=small.growth,
        whirl_frequency=small.frequency,
        damping_ratio=small.damping,
        stable=small.is_stable,
        settles=small.settles(Omega),
    )


def currents_of(values: Mapping[str, complex], machine: RubbingRotor) -> dict[str, BearingCurrent]:
    """Return complex currents (A) as they are told, beside what each bearing allows."""
    return {
        bearing: BearingCurrent(abs(value), math.degrees(np.angle(value)), allowed_current(machine, bearing))
        for bearing, value in values.items()
    }


def allowed_current(machine: RubbingRotor, bearing: str) -> float:
    """Return the amplitude (A) that the coils (`amb_actuator.amplifier`) and the controller's limits follow."""
    interfaces, found = machine.made.assembly.interfaces, math.inf
    if ACTUATOR in interfaces:
        p = machine.made.parameters(ACTUATOR)
        for axis in "xy":
            names = ("bias_current", "static_current", "current_limit", "voltage_limit", "resistance")
            bias, static, limit, voltage, resistance = (p[f"{bearing}.{name}_{axis}"] for name in names)
            if p["amplifier"] == DYNAMIC:
                limit = min(limit, voltage / resistance)
            found = min(found, *(abs(limited_current(demand, bias, static, limit)) for demand in (-1e12, 1e12)))
    if CONTROLLER in interfaces:
        p = machine.made.parameters(CONTROLLER)
        found = min(
            found, *(abs(p.get(f"{bearing}.{name}_{a}", math.inf)) for name in ("i_min", "i_max") for a in "xy")
        )
    return max(found, 0.0)
