"""Study of traps: where a rotor can stay in contact, and what frees it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Annotated, ClassVar

import numpy as np
from numpy.typing import NDArray

from amb_actuator.force import limited_current
from amb_actuator.interface import DYNAMIC
from amb_cosim.cosim.choices import Flavour
from amb_cosim.cosim.values import Raw
from amb_cosim.presentation.json_data import Layout
from amb_cosim.presentation.text_tables import TextPart, text_table
from amb_cosim.results.places import ACTUATOR, CONTROLLER, PLANT
from amb_cosim.rub.forward_loop import Complex
from amb_cosim.rub.freeing import smallest_demand, smallest_freeing
from amb_cosim.rub.rubbing_rotor import RubbingRotor, rubbing_rotor
from amb_cosim.rub.synchronous_control import adaptation_rates, settled
from amb_cosim.rub.synchronous_states import all_sets, states_of
from amb_cosim.rub.trap_map import Kind, State, TrapMap, states_at, trap_map
from amb_cosim.rub.whirl import whirls
from amb_cosim.scenario.scenario import given_scenario
from amb_cosim.scenario.simulation import prepare
from amb_cosim.studies.inputs import Number, positive, speed_range, spin_speed, with_controller
from amb_cosim.studies.result import DrawnResult
from fmi_export.model import Array
from rotor_analysis.checks import require
from rotor_analysis.rotor_file import load_rotor

SPEEDS, AMOUNTS, CURVE, LEAST = 200, 50, 400, 500  # points of the map, of the curves, and of unbalance at one speed
LOWEST = 0.02  # of the highest speed and of the largest unbalance, where the map begins
SHOWN = 5  # sustained whirls that are printed, the slowest
AT_ONCE = 2  # sites in contact at once on the map and on the curves; at the machine's point all
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


@dataclass(frozen=True, eq=False)
class Freed:
    """Whether a control frees the rotor at the machine's point.

    frees
        Whether it leaves no state in contact.
    currents
        What it demands of each bearing for that.
    words
        The same in a sentence.
    """

    frees: bool
    currents: dict[str, BearingCurrent]
    words: str


@dataclass(frozen=True, eq=False, repr=False)
class Traps(DrawnResult):
    """Where a rotor can stay in contact.

    scenario, rotor
        Names of the scenario and of its rotor.
    speed, unbalance
        Spin speed (rad/s) and largest unbalance of a place (kg m) of the machine.
    sites
        Sites where it may touch.
    kind
        What it can do at this point.
    states
        All synchronous states there.
    sustained
        Whirls that need no unbalance, at its speed.
    least_trapping
        Smallest unbalance with which a stable contact exists at its speed (kg m); None up to the largest of the map.
    smallest_force
        Smallest additional currents of the bearings that leave no state in contact; None where none do.
    control
        Whether each kind of control frees it.
    speeds, unbalances
        Of the map (rad/s, kg m), shapes (n,) and (k,).
    kinds
        What a rotor can do at each point (0 free, 1 both, 2 contact, 3 whirl), shape (n, k).
    least_trapping_over_speed
        Smallest unbalance of the map that traps at each speed (kg m), NaN where none does, shape (n,).
    curves, orbits
        All states over speed at the machine's unbalance, and orbits of the sites that nothing stops (m).
    clearances
        Of the sites (m).
    notes
        What holds only nearly, in sentences.
    """

    name: ClassVar[str] = "traps"

    scenario: str
    rotor: str
    speed: Annotated[float, "rad/s"]
    unbalance: Annotated[float, "kg.m"]
    sites: tuple[str, ...]
    kind: str
    states: tuple[SynchronousState, ...]
    sustained: tuple[SustainedWhirl, ...]
    least_trapping: Annotated[float | None, "kg.m"]
    smallest_force: dict[str, BearingCurrent] | None
    control: dict[str, Freed]
    speeds: Annotated[Array, "rad/s"]
    unbalances: Annotated[Array, "kg.m"]
    kinds: NDArray[np.int64]
    least_trapping_over_speed: Annotated[Array, "kg.m"]
    curves: Annotated[TrapMap, Layout.OMITTED]
    orbits: Annotated[Array, Layout.OMITTED]
    clearances: Annotated[Array, "m"]
    notes: tuple[str, ...]

    def text(self) -> list[TextPart]:
        """Return the states of the machine, what frees it, and what holds only nearly."""
        table = text_table(
            f"{self.rotor}: states at {self.speed:.5g} rad/s with {1e3 * self.unbalance:.4g} g m",
            ("contact", "normal forces (N)", "current (A)", "allowed (A)", "growth (1/s)", "whirl (rad/s)", "it"),
            left=("contact", "it"),
        )
        for state in self.states:
            forces = ", ".join(f"{force:.1f}" for force in state.normal_forces.values()) or "-"
            worst = max(state.currents.values(), key=lambda i: i.amplitude / max(i.allowed, 1e-12), default=None)
            currents = ("-", "-") if worst is None else (f"{worst.amplitude:.2f}", f"{worst.allowed:.2f}")
            place = "+".join(state.contact) or "free"
            motion = f"{state.growth:.3g}", f"{state.whirl_frequency:.4g}"
            table.add_row(place, forces, *currents, *motion, state.beyond(self.speed))
        lines: list[TextPart] = [table, f"{self.kind}", *self._freeing()]
        lasting = [whirl for whirl in self.sustained if whirl.stable and whirl.accurate]
        for whirl in sorted(lasting, key=lambda whirl: abs(whirl.frequency))[:SHOWN]:
            forces = ", ".join(f"{name} {force:.4g} N" for name, force in whirl.normal_forces.items())
            rolling = "" if whirl.slips else "; it rolls before"
            lines.append(f"a whirl at {whirl.frequency:.4g} rad/s needs no unbalance, and lasts ({forces}{rolling})")
        return [*lines, *(f"notice: {note}" for note in self.notes)]

    def _freeing(self) -> list[str]:
        lines = []
        if self.least_trapping is None:
            lines.append(f"up to {1e3 * self.unbalances[-1]:.4g} g m nothing traps it at this speed")
        else:
            lines.append(f"the smallest unbalance that traps it at this speed is {1e3 * self.least_trapping:.4g} g m")
        if self.smallest_force is None:
            lines.append("no synchronous currents of these bearings leave it without a state in contact")
        elif any(current.amplitude for current in self.smallest_force.values()):
            told = ", ".join(f"{b} {i.amplitude:.3g} A at {i.phase:.0f} deg" for b, i in self.smallest_force.items())
            lines.append(f"the smallest additional currents that leave it no state in contact: {told}")
        return [*lines, *(f"{name}: {freed.words}" for name, freed in self.control.items())]


def traps(
    scenario: str | Path | None = None,
    *,
    rotor: str | Path | None = None,
    controller: str | PathLike[str] | None = None,
    speed: Number | None = None,
    unbalance: Number | None = None,
    place: str | None = None,
    up_to: Number | None = None,
    unbalance_up_to: Number | None = None,
    set: Mapping[str, Raw] | None = None,
    flavour: Flavour = "native",
) -> Traps:
    """Return where a rotor under control can stay in contact over speed and unbalance, and what frees it.

    Every synchronous state (`amb_cosim.rub.synchronous_states`), its stability, the map, and the smallest force that
    frees.

    Parameters
    ----------
    scenario
        Name of a scenario of a pack, or a TOML file, with the machine, its speed and its unbalance at the end; the
        packs' default without.
    rotor
        Name of a rotor of a pack, or rotor file, in place of the scenario's.
    controller
        Controller file, object or FMU in place of the scenario's controller.
    speed
        Spin speed of the machine's point (rad/s), or a text with its unit.
    unbalance, place
        Unbalance of the machine's point (kg m), or a text with its unit, and the disc where it is. By default as the
        scenario has them; the map multiplies the unbalances of all places by one factor.
    up_to, unbalance_up_to
        Highest speed and largest unbalance of the map; twice those of the machine by default.
    set
        Values of parameters by `component.variable`, numbers or texts with units.
    flavour
        Flavour of the FMUs.

    Raises
    ------
    ValueError
        If a value is not allowed, there is no unbalance, or the rotor can touch nowhere.
    """
    given = with_controller(given_scenario(scenario, rotor), controller)
    prepared = prepare(given, set, flavour=flavour)
    machine = _with_unbalance(rubbing_rotor(prepared), unbalance, place)
    Omega = prepared.plan.speed if speed is None else spin_speed(speed)
    require(Omega > 0.0, "speed", f"{Omega:g} rad/s", "> 0 rad/s")
    amount = float(np.abs(machine.unbalance).max())
    highest = 2.0 * Omega if up_to is None else spin_speed(up_to, "up-to")
    speeds = speed_range(highest, SPEEDS + 1)[1:]
    largest = 2.0 * amount if unbalance_up_to is None else positive(unbalance_up_to, "kg.m", "unbalance-up-to")
    factors = np.linspace(LOWEST, 1.0, AMOUNTS) * largest / amount
    whole = trap_map(machine, speeds, factors, AT_ONCE)
    curves = trap_map(machine, speed_range(highest, CURVE + 1)[1:], np.ones(1), AT_ONCE)
    states = tuple(_told(state, machine, Omega) for state in states_at(machine, Omega))
    here = trap_map(machine, np.array([Omega]), np.linspace(0.0, 1.0, LEAST + 1)[1:] * largest / amount, AT_ONCE)
    least = float(here.least_trapping()[0]) * amount
    freeing = smallest_freeing(machine, Omega)
    needed = None if freeing is None else _currents(freeing.injected, machine)
    allowed = np.array([_allowed(machine, bearing) for bearing in machine.loop(Omega).currents])
    demand = smallest_demand(machine, Omega, allowed)
    demands = [_currents(found.demanded, machine) for found in (freeing, demand) if found is not None]
    valid_to = machine.made.layout(PLANT).get("valid_to") or math.inf
    notes = list(machine.notes)
    if len(machine.sites) > AT_ONCE:
        notes.append(f"map and curves have at most {AT_ONCE} sites in contact at once; the machine's states all")
    return Traps(
        scenario=given.name,
        rotor=load_rotor(given.rotor).name,
        speed=Omega,
        unbalance=amount,
        sites=machine.sites,
        kind=KINDS[_kind(states)],
        states=states,
        sustained=tuple(
            SustainedWhirl(w.contact, w.frequency, w.N, w.slips, w.stable, abs(w.frequency) <= valid_to)
            for w in whirls(machine, Omega)
        ),
        least_trapping=least if math.isfinite(least) else None,
        smallest_force=needed,
        control=_control(machine, Omega, states, demands),
        speeds=speeds,
        unbalances=factors * amount,
        kinds=whole.kinds(),
        least_trapping_over_speed=whole.least_trapping() * amount,
        curves=curves,
        orbits=np.array(
            [np.abs(machine.receptances(w).P @ machine.unbalance * w**2) for w in map(float, curves.speeds)]
        ),
        clearances=machine.c,
        notes=tuple(notes),
    )


def _with_unbalance(machine: RubbingRotor, unbalance: Number | None, place: str | None) -> RubbingRotor:
    if place is not None:
        require(place in machine.places, "place", place, f"one of {', '.join(machine.places)}")
    if unbalance is None and place is None:
        require(
            bool(np.any(machine.unbalance)), "unbalance", "0 kg m", "> 0 kg m: give unbalance, or a run that has one"
        )
        return machine
    amount = np.abs(machine.unbalance).max() if unbalance is None else positive(unbalance, "kg.m", "unbalance")
    require(amount > 0.0, "unbalance", "0 kg m", "> 0 kg m")
    where = machine.places[0] if place is None else place
    if place is None and np.any(machine.unbalance):
        return machine.with_unbalance(machine.unbalance * amount / np.abs(machine.unbalance).max())
    return machine.with_unbalance(
        np.array([amount if name == where else 0.0 for name in machine.places], dtype=complex)
    )


def _orbits(machine: RubbingRotor, speeds: Array) -> Array:
    """Return the orbits of the sites that nothing stops (m), shape (n, n_sites)."""
    return np.array([np.abs(machine.receptances(w).P @ machine.unbalance) * w**2 for w in map(float, speeds)])


def _kind(states: tuple[SynchronousState, ...]) -> Kind:
    free = any(not state.contact and state.stable for state in states)
    trapped = any(state.contact and state.stable for state in states)
    rests = any(state.contact and state.settles for state in states)
    return (Kind.BOTH if trapped else Kind.FREE) if free else (Kind.CONTACT if rests else Kind.WHIRL)


def _told(state: State, machine: RubbingRotor, Omega: float) -> SynchronousState:
    small = state.small
    return SynchronousState(
        contact=state.contact,
        normal_forces=state.N,
        friction_forces=state.friction,
        phases={site: math.degrees(psi) for site, psi in state.psi.items()},
        orbits=state.radius,
        currents=_currents(state.currents, machine),
        growth=small.growth,
        whirl_frequency=small.frequency,
        damping_ratio=small.damping,
        stable=small.is_stable,
        settles=small.settles(Omega),
    )


def _currents(values: Mapping[str, complex], machine: RubbingRotor) -> dict[str, BearingCurrent]:
    return {
        bearing: BearingCurrent(abs(value), math.degrees(np.angle(value)), _allowed(machine, bearing))
        for bearing, value in values.items()
    }


def _allowed(machine: RubbingRotor, bearing: str) -> float:
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


def _control(
    machine: RubbingRotor,
    Omega: float,
    states: tuple[SynchronousState, ...],
    demands: Sequence[dict[str, BearingCurrent]],
) -> dict[str, Freed]:
    """Return whether feedback, synchronous control and control that knows of the contact free the rotor."""
    trapped = [state for state in states if state.contact and state.stable]
    free = [state for state in states if not state.contact and state.stable]
    own = free[0].currents if free else {}
    if free and not trapped:
        words = "frees it: no steady contact is stable" + _within(own)
    else:
        words = "may leave it in contact" if free else "cannot free it: no orbit misses all sites"
    found = {"feedback alone": Freed(bool(free) and not trapped, own, words)}
    if not machine.loop(Omega).currents:
        return found
    found["synchronous control"] = _synchronous(machine, Omega)
    if not demands:
        freed = Freed(False, {}, "cannot free it: no synchronous currents do")
    else:
        within = [d for d in demands if all(current.is_allowed for current in d.values())]
        shown = within[0] if within else demands[-1]
        words = "can free it from any steady contact" if within else "cannot free it from all contact within its limits"
        freed = Freed(bool(within), shown, f"{words}{_within(shown)}")
    found["synchronous control that knows of the contact"] = freed
    return found


def _synchronous(machine: RubbingRotor, Omega: float) -> Freed:
    """Return what the steady force of synchronous control leaves, and whether it gets there from contact."""
    at, mu = machine.receptances(Omega), machine.mu(Omega)
    rest, force = settled(at), machine.unbalance * Omega**2
    r = (rest.P @ force)[None]
    orbit = states_of((), rest.R, mu, machine.c, r)
    values: Complex = rest.currents[1] @ force
    currents = _currents(dict(zip(machine.loop(Omega).currents, values, strict=True)), machine)
    stuck = []
    for contact in all_sets(len(machine.sites))[1:]:
        states = states_of(contact, rest.R, mu, machine.c, r)
        for n in range(len(states.points)):
            if adaptation_rates(at, states, n, machine.c, mu).real.max() < 0.0:
                stuck.append("+".join(machine.sites[k] for k in contact))
    if not len(orbit.points):
        return Freed(False, currents, "cannot free it: its steady force leaves no orbit that misses all sites")
    words = "can hold it free" + _within(currents)
    own = _rates_of_feedback(machine, Omega)
    turned = [name for name, rate in own.items() if rate > 0.0]
    if stuck:
        words += f"; it may also come to rest in contact at {', '.join(sorted(frozenset(stuck)))}"
    elif turned:
        words += f"; in contact at {', '.join(turned)} its adaptation goes the wrong way"
    possible = all(current.is_allowed for current in currents.values())
    return Freed(possible and not stuck and not turned, currents, words)


def _rates_of_feedback(machine: RubbingRotor, Omega: float) -> dict[str, float]:
    """Return the largest rate of adaptation, over alpha, in each state in contact under feedback alone (1)."""
    at, mu = machine.receptances(Omega), machine.mu(Omega)
    r = (at.P @ machine.unbalance * Omega**2)[None]
    found: dict[str, float] = {}
    for contact in all_sets(len(machine.sites))[1:]:
        states = states_of(contact, at.R, mu, machine.c, r)
        for n in range(len(states.points)):
            name = "+".join(machine.sites[k] for k in contact)
            rate = float(adaptation_rates(at, states, n, machine.c, mu).real.max())
            found[name] = max(rate, found.get(name, -math.inf))
    return found


def _within(currents: Mapping[str, BearingCurrent]) -> str:
    if not currents:
        return ""
    told = ", ".join(
        f"{bearing} {current.amplitude:.2f} of {current.allowed:.2f} A" for bearing, current in currents.items()
    )
    return f" ({told})"
