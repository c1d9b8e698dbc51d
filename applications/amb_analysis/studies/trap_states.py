"""States in a study of traps: where a rotor can stay with or without unbalance, and what follows."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from amb_actuator.force import limited_current
from amb_actuator.interface import DYNAMIC
from amb_analysis.steady_contact.rolling import rolling
from amb_analysis.steady_contact.rubbing_rotor import RubbingRotor
from amb_analysis.steady_contact.trap_map import Regime, SolvedState
from amb_cosim.results.component_names import ACTUATOR, CONTROLLER
from rotor_contact.friction import friction_excess

VIBRATIONS = 6  # about a state that are reported, what decays least first
KINDS = {
    Regime.FREE: "free rotation; no stable steady contact",
    Regime.BOTH: "free rotation or contact, depending on the start",
    Regime.CONTACT: "contact; no stable orbit misses all sites",
    Regime.WHIRL: "unsteady rub; no stable orbit misses all sites, and no steady contact is stable",
}


@dataclass(frozen=True, eq=False)
class BearingCurrent:
    """Synchronous current of a bearing.

    amplitude, phase
        Amplitude in each axis (A), and phase lead over the unbalance in x (deg).
    allowed
        Largest amplitude that the coils and the controller can follow (A).
    """

    amplitude: Annotated[float, "A"]
    phase: Annotated[float, "deg"]
    allowed: Annotated[float, "A"]

    @property
    def is_allowed(self) -> bool:
        """Whether the amplitude is within the limit."""
        return self.amplitude <= self.allowed


@dataclass(frozen=True, eq=False)
class Vibration:
    """A small vibration about a state: whirl frequency (rad/s, negative backward), growth (1/s), damping ratio (1)."""

    frequency: Annotated[float, "rad/s"]
    growth: Annotated[float, "1/s"]
    damping_ratio: float


@dataclass(frozen=True, eq=False)
class SynchronousState:
    """A state of steady rotation.

    contact
        Sites in contact.
    normal_forces, friction_forces, phases
        Values at each of them (N, N, deg from the unbalance's reference).
    orbits
        Distance of the journal from the centre at each site (m).
    currents
        Current of each bearing.
    growth, whirl_frequency, damping_ratio
        Least damped small motion about the state: rate (1/s), frequency (rad/s, negative backward), damping (1).
    vibrations
        Vibrations of the rotor in this state, the least damped first.
    stable, settles
        Whether small motion decays, and within a thousand turns.
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
        """Return in words whether the rotor stays there."""
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

    @property
    def grows_backward(self) -> bool:
        """Whether friction accelerates a backward whirl that is faster than this one."""
        return self.frequency < 0.0 and self.slips and not self.stable


@dataclass(frozen=True, eq=False)
class RollingContact:
    """Rolling at sites: a journal rolls without slip in its ring once something makes it whirl backward fast enough.

    contact, frequency
        One or two sites, and the whirl frequency (rad/s), negative.
    normal_forces, swings
        Force at each site, averaged over the angle between the two, and the deviation from it (N).
    least_friction
        Friction coefficient below which the journal slips (1).
    possible
        Whether the friction of all these sites is above that.
    accurate
        Whether the reduced rotor is accurate at this frequency.
    """

    contact: tuple[str, ...]
    frequency: Annotated[float, "rad/s"]
    normal_forces: Annotated[dict[str, float], "N"]
    swings: Annotated[dict[str, float], "N"]
    least_friction: float
    possible: bool
    accurate: bool

    def __str__(self) -> str:
        forces = ", ".join(f"{site} {force:.4g} N" for site, force in self.normal_forces.items())
        beyond = "" if self.accurate else "; the reduced rotor is not accurate there"
        return (
            f"{'+'.join(self.contact)} may roll at {self.frequency:.4g} rad/s ({forces}), which requires a friction "
            f"coefficient of "
            f"{self.least_friction:.2g}{beyond}"
        )


def regime_of(states: tuple[SynchronousState, ...]) -> Regime:
    """Return the possible behaviour of a rotor with these states."""
    free = any(not state.contact and state.stable for state in states)
    trapped = any(state.contact and state.stable for state in states)
    rests = any(state.contact and state.settles for state in states)
    return (Regime.BOTH if trapped else Regime.FREE) if free else (Regime.CONTACT if rests else Regime.WHIRL)


def rolling_contacts(machine: RubbingRotor, Omega: float, valid_to: float) -> tuple[RollingContact, ...]:
    """Return the possible rolling at a speed (rad/s) of a rotor model that is accurate up to a frequency (rad/s)."""
    records = dict(zip(machine.sites, machine.records, strict=True))
    return tuple(
        RollingContact(
            contact=result.contact,
            frequency=result.frequency,
            normal_forces=result.N,
            swings=result.swing,
            least_friction=result.friction,
            possible=all(friction_excess(records[site], 1.0, result.friction) <= 0.0 for site in result.contact),
            accurate=abs(result.frequency) <= valid_to,
        )
        for result in rolling(machine, Omega)
    )


def report_state(state: SolvedState, machine: RubbingRotor, Omega: float) -> SynchronousState:
    """Return a state at a speed (rad/s) for the report."""
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
        vibrations=tuple(
            Vibration(float(w), float(rate), float(-rate / math.hypot(rate, w)))
            for rate, w in zip(small.rates[:VIBRATIONS], small.frequencies[:VIBRATIONS], strict=True)
        ),
        stable=small.is_stable,
        settles=small.settles(Omega),
    )


def currents_of(values: Mapping[str, complex], machine: RubbingRotor) -> dict[str, BearingCurrent]:
    """Return complex currents (A) for the report, with the limit of each bearing."""
    return {
        bearing: BearingCurrent(abs(value), math.degrees(np.angle(value)), allowed_current(machine, bearing))
        for bearing, value in values.items()
    }


def allowed_current(machine: RubbingRotor, bearing: str) -> float:
    """Return the largest amplitude (A) that coils (`amb_actuator.amplifier`) and controller can follow."""
    interfaces, result = machine.linear_components.assembly.interfaces, math.inf
    if ACTUATOR in interfaces:
        p = machine.linear_components.parameters(ACTUATOR)
        for axis in "xy":
            names = ("bias_current", "static_current", "current_limit", "voltage_limit", "resistance")
            bias, static, limit, voltage, resistance = (p[f"{bearing}.{name}_{axis}"] for name in names)
            if p["amplifier"] == DYNAMIC:
                limit = min(limit, voltage / resistance)
            result = min(result, *(abs(limited_current(demand, bias, static, limit)) for demand in (-1e12, 1e12)))
    if CONTROLLER in interfaces:
        p = machine.linear_components.parameters(CONTROLLER)
        result = min(
            result, *(abs(p.get(f"{bearing}.{name}_{a}", math.inf)) for name in ("i_min", "i_max") for a in "xy")
        )
    return max(result, 0.0)
