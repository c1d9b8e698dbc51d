"""Study of traps: where a rotor can stay in contact, and what frees it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from os import PathLike
from pathlib import Path
from typing import Annotated, ClassVar

import numpy as np
from numpy.typing import NDArray

from amb_analysis.steady_contact.contact_whirl import ContactWhirl, contact_whirls
from amb_analysis.steady_contact.freeing import smallest_demand, smallest_freeing
from amb_analysis.steady_contact.rolling import Rolling, rolling
from amb_analysis.steady_contact.rubbing_rotor import RubbingRotor, rubbing_rotor
from amb_analysis.steady_contact.trap_map import (
    TrapMap,
    clearance_shares,
    least_touching,
    least_trapping_at,
    least_trapping_curve,
    least_trapping_over,
    states_at,
    trap_map,
)
from amb_analysis.steady_contact.whirl import Whirl, whirls
from amb_analysis.studies.inputs import GRADE, Number, controlled, positive, speed_range, spin_speed
from amb_analysis.studies.result import MachineResult
from amb_analysis.studies.trap_control import Freed, control_of
from amb_analysis.studies.trap_states import (
    KINDS,
    BearingCurrent,
    SynchronousState,
    allowed_current,
    currents_of,
    regime_of,
    report_state,
)
from amb_cosim.cosim.choices import Flavour
from amb_cosim.cosim.fmu.fmus import FmuSource
from amb_cosim.cosim.run.options import RunOptions
from amb_cosim.cosim.system.values import Raw
from amb_cosim.presentation.json_data import Layout
from amb_cosim.presentation.text_tables import TextBlock, number, text_table
from amb_cosim.presentation.units import force_unit, speed_unit
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.scenario import Scenario
from amb_files.checks import require
from array_types import Array
from rotor_analysis.rotor_file import load_rotor

SPEEDS, AMOUNTS, CURVE, LEAST = 200, 50, 400, 500  # points of the map, of the curves, and of unbalance at a speed
BEYOND_GRADE = 10.0  # largest unbalance of a map, over the limit of G 2.5, if nothing traps or touches before
SEARCH_SPEEDS, SEARCH_AMOUNTS, MARGIN = 40, 30, 1.25  # points of the search for traps; extent of the map beyond them
WIDE = 10.0  # largest unbalance over the machine's, above which the unbalances of a map are on a logarithmic scale
LOWEST = 0.02  # smallest unbalance of a linear map, over the largest
MOST_LISTED = 4  # printed vibrations about a state, and printed sustained whirls
AT_ONCE = 2  # most sites in contact on the map and on the curves; at the machine's point all


@dataclass(frozen=True, eq=False, repr=False)
class Traps(MachineResult):
    """States in which a rotor can stay in contact.

    speed, unbalance
        Spin speed (rad/s) of the machine, and its largest unbalance at one place (kg m).
    sites
        Contact sites.
    loop_growth, loop_frequency
        Growth rate (1/s) and whirl frequency (rad/s) of the rotor without contact; the loop is unstable if the growth
        rate is positive.
    kind
        Possible behaviour at this speed and unbalance.
    states
        All synchronous states at this speed and unbalance.
    own
        Whirls near the spin frequency that last for a long time without unbalance.
    sustained, rolling
        Whirls that last without unbalance at the machine's speed, with slip and without slip (rolling).
    least_trapping
        Smallest unbalance (kg m) at which a stable contact exists at the machine's speed; None if no unbalance of the
        map traps at this speed.
    touching, trapping
        Smallest unbalance (kg m), over the speeds of the map, at which the contact-free orbit touches a site, and the
        smallest at which a stable contact exists. Each is given with its speed (rad/s); `trapping` is None if no
        unbalance of the map traps.
    grade_limit, grade_limit_at_speed
        Unbalance (kg m) that balancing grade G 2.5 allows: at each speed of the map, shape (n,), and at the machine's
        speed.
    smallest_force
        Smallest additional currents of the bearings that leave no state in contact; None if there are no such currents,
        or if the loop is unstable.
    control
        Whether each kind of control frees the rotor; empty if the loop is unstable, because steady currents do not
        stabilise it.
    speeds, unbalances
        Axes of the map (rad/s, kg m), shapes (n,) and (k,).
    kinds
        Possible behaviour at each point (0 free, 1 both, 2 contact, 3 whirl), shape (n, k).
    least_trapping_over_speed
        Smallest unbalance that traps at each speed (kg m), shape (n,); NaN if no unbalance of the map traps.
    curves, orbits
        All states at the machine's unbalance as functions of speed, and the contact-free orbits at the sites (m).
    clearances
        Clearances of the sites (m).
    notes
        Sentences about the approximations.
    """

    name: ClassVar[str] = "traps"

    speed: Annotated[float, "rad/s"]
    unbalance: Annotated[float, "kg.m"]
    sites: tuple[str, ...]
    loop_growth: Annotated[float, "1/s"]
    loop_frequency: Annotated[float, "rad/s"]
    kind: str
    states: tuple[SynchronousState, ...]
    own: tuple[ContactWhirl, ...]
    sustained: tuple[Whirl, ...]
    rolling: tuple[Rolling, ...]
    least_trapping: Annotated[float | None, "kg.m"]
    touching: tuple[float, float]
    trapping: tuple[float, float] | None
    grade_limit: Annotated[Array, "kg.m"]
    grade_limit_at_speed: Annotated[float, "kg.m"]
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

    def text(self) -> list[TextBlock]:
        """Return lines about the states of the machine, about what frees the rotor, and about the approximations."""
        unit = speed_unit()
        force = force_unit(max((N for state in self.states for N in state.normal_forces.values()), default=0.0))
        table = text_table(
            f"{self.rotor}: states at {unit.text(self.speed, 5)} with {_grams(self.unbalance)}",
            (
                "contact",
                f"normal forces ({force.label})",
                "current (A)",
                "allowed (A)",
                "growth (1/s)",
                f"whirl ({unit.label})",
                "outcome",
            ),
            left=("contact", "outcome"),
        )
        for state in self.states:
            forces = ", ".join(map(force.number, state.normal_forces.values())) or "-"
            worst = max(state.currents.values(), key=lambda i: i.amplitude / max(i.allowed, 1e-12), default=None)
            currents = ("-", "-") if worst is None else (number(worst.amplitude), number(worst.allowed))
            place = "+".join(state.contact) or "free"
            motion = f"{state.growth:.3g}", unit.number(state.whirl_frequency)
            table.add_row(place, forces, *currents, *motion, state.beyond(self.speed))
        answer = f"At {unit.text(self.speed)} with {_grams(self.unbalance)} {self.kind}"
        lines: list[TextBlock] = [*self._instability(), answer, table, self._reach(), *self._freeing()]
        for state in (state for state in self.states if state.contact):
            whirling = [v for v in state.vibrations if abs(v.frequency - self.speed) > 1e-6 * self.speed][:MOST_LISTED]
            frequencies = [f"{unit.text(v.frequency)} ({100.0 * v.damping_ratio:.2g} %)" for v in whirling]
            where = " and ".join(f"{site} ({force.text(N)})" for site, N in state.normal_forces.items())
            if frequencies:
                lines.append(
                    f"in contact at {where} the rotor vibrates at {', '.join(frequencies)}; the damping is in brackets"
                )
        for lasting in self.own:
            slow, fast = (", ".join(f"{site} {_force_text(N[k])}" for site, N in lasting.N.items()) for k in (0, 1))
            opposite = " on opposite sides" if -1 in lasting.signs else ""
            where = "+".join(lasting.contact) + opposite
            low, high = map(unit.text, lasting.frequencies)
            lines.append(
                f"a large knock can start a long-lasting whirl in contact with {where}, at {low} ({slow}) to {high} "
                f"({fast})"
            )
        stable = [whirl for whirl in self.sustained if whirl.stable and whirl.accurate]
        for whirl in sorted(stable, key=lambda whirl: abs(whirl.frequency))[:MOST_LISTED]:
            forces = ", ".join(f"{name} {_force_text(N)}" for name, N in whirl.N.items())
            rolls = "" if whirl.slips else "; the rotor rolls before it whirls this fast"
            lines.append(f"a whirl at {unit.text(whirl.frequency)} lasts even without unbalance ({forces}{rolls})")
        for contact in {whirl.frequency: whirl for whirl in self.rolling if whirl.possible}.values():  # the most sites
            slower = [w.frequency for w in self.sustained if w.grows_backward and {*w.contact} <= {*contact.contact}]
            onset = f"; a backward whirl faster than {unit.text(max(slower))} grows" if slower else ""
            lines.append(f"{contact}{onset}")
        return [*lines, *(f"notice: {note}" for note in self.notes), *self.warning_lines()]

    def _instability(self) -> list[str]:
        if self.loop_growth <= 0.0:
            return []
        return [
            f"the loop is unstable at this speed: without contact a whirl at {speed_unit().text(self.loop_frequency)} "
            f"grows at {self.loop_growth:.3g} 1/s, until the rotor touches"
        ]

    def _reach(self) -> str:
        """Describe the smallest unbalances over all speeds that cause contact and trapping, or report their absence."""
        unit = speed_unit()
        highest, largest, (touching, at) = self.speeds[-1], self.unbalances[-1], self.touching
        least = f"contact needs at least {_grams(touching)} (at {unit.text(at)})"
        touches = least if touching <= largest else f"no unbalance up to {_grams(largest)} leads to contact"
        if self.trapping is not None:
            smallest = f"{_grams(self.trapping[0])} on (at {unit.text(self.trapping[1])})"
            traps = f"a rotor already in contact can stay there from {smallest}"
        else:
            times = f"{largest / self.grade_limit_at_speed:.3g} times the limit of G 2.5 at {unit.text(self.speed)}"
            traps = f"no contact is stable with unbalances up to {_grams(largest)}, which is {times}"
        return f"up to {unit.text(highest)}: {touches}; {traps}"

    def _freeing(self) -> list[str]:
        lines = []
        if self.least_trapping is None and self.loop_growth > 0.0:
            lines.append(f"at this speed no contact becomes steady with unbalances up to {_grams(self.unbalances[-1])}")
        elif self.least_trapping is None:
            lines.append(f"at this speed no contact is stable with unbalances up to {_grams(self.unbalances[-1])}")
        else:
            lines.append(f"at this speed a rotor in contact can stay there from {_grams(self.least_trapping)} on")
        if self.loop_growth > 0.0:
            return lines
        if self.smallest_force is None:
            lines.append("no synchronous currents of these bearings were found that exclude all states in contact")
        elif any(current.amplitude for current in self.smallest_force.values()):
            added = ", ".join(f"{b} {i.amplitude:.3g} A at {i.phase:z.0f} deg" for b, i in self.smallest_force.items())
            lines.append(f"the smallest additional currents found that exclude all states in contact: {added}")
        return [*lines, *(f"{name}: {freed.words}" for name, freed in self.control.items())]


def traps(
    scenario: str | Path | Scenario | None = None,
    *,
    rotor: str | Path | None = None,
    controller: FmuSource | PathLike[str] | None = None,
    speed: Number | None = None,
    unbalance: Number | None = None,
    place: str | None = None,
    up_to: Number | None = None,
    unbalance_up_to: Number | None = None,
    set: Mapping[str, Raw] | None = None,
    flavour: Flavour = "native",
) -> Traps:
    """Return the speeds and unbalances at which a rotor under control can stay in contact, and the forces that free it.

    The result contains all synchronous states (`synchronous_states`), their stability, the map, and the smallest force
    that frees the rotor.

    Parameters
    ----------
    scenario, rotor, controller
        The machine with its rotor and its controller, as for `studies.inputs.controlled`, and its final speed and
        unbalance.
    speed
        Spin speed (rad/s) of the machine, or a string with its unit; by default the final speed of the scenario.
    unbalance, place
        Unbalance (kg m) of the machine, or a string with its unit, and the disc that carries it. By default, the
        machine has the unbalance of the scenario. In the map, the unbalances at all places are multiplied by the same
        factor.
    up_to, unbalance_up_to
        Highest speed and largest unbalance of the map. By default, the map extends to twice the machine's speed. The
        default largest unbalance exceeds the smallest unbalances at which the rotor touches and at which it can be
        trapped at these speeds, and is at least twice the machine's unbalance. If no unbalance traps the rotor, the
        default is also at least ten times the limit of G 2.5 at the machine's speed.
    set, flavour
        Parameter values by `component.variable`, as numbers or strings with units, and the flavour of the FMUs.

    Raises
    ------
    ValueError
        If a value is not allowed, the machine has no unbalance, or no site is enabled.
    """
    values = controlled(scenario, rotor, controller)
    prepared = prepare_run(values, set, options=RunOptions(flavour=flavour))
    machine = _with_unbalance(rubbing_rotor(prepared), unbalance, place)
    Omega = machine.machine.last_speed if speed is None else spin_speed(speed)
    require(Omega > 0.0, "speed", speed_unit().text(Omega), f"> {speed_unit().text(0.0)}")
    amount = float(np.abs(machine.unbalance).max())
    highest = 2.0 * Omega if up_to is None else spin_speed(up_to, "up_to")
    speeds = speed_range(highest, SPEEDS + 1)[1:]
    described = load_rotor(values.rotor)
    limit = described.mass * GRADE / Omega
    largest = (
        _largest(machine, speeds, limit / amount) * amount
        if unbalance_up_to is None
        else positive(unbalance_up_to, "kg.m", "unbalance_up_to")
    )
    factors = _factors(largest / amount)
    map_states = trap_map(machine, speeds, factors, AT_ONCE)
    touching, touching_at = least_touching(machine, speeds)
    curves = trap_map(machine, speed_range(highest, CURVE + 1)[1:], np.ones(1), AT_ONCE)
    states = tuple(report_state(state, machine, Omega) for state in states_at(machine, Omega))
    least = least_trapping_at(machine, Omega, np.linspace(0.0, 1.0, LEAST + 1)[1:] * largest / amount, AT_ONCE) * amount
    curve = least_trapping_curve(machine, map_states, AT_ONCE)
    least_over_speeds = least_trapping_over(machine, speeds, curve, AT_ONCE)
    loop = machine.dynamics(Omega).about((), np.zeros(0), np.zeros(0))
    freeing = smallest_freeing(machine, Omega) if loop.is_stable else None
    freeing_currents = None if freeing is None else currents_of(freeing.injected, machine, Omega)
    allowed = np.array([allowed_current(machine, bearing, Omega) for bearing in machine.loop(Omega).currents])
    demand = smallest_demand(machine, Omega, allowed) if loop.is_stable else None
    demands = [currents_of(result.demanded, machine, Omega) for result in (freeing, demand) if result is not None]
    notes = list(machine.notes)
    if len(machine.sites) > AT_ONCE:
        notes.append(
            f"the map and the curves show only states with at most {AT_ONCE} sites in contact; the list of states "
            "also contains states with more sites in contact"
        )
    return Traps(
        scenario=values.name,
        rotor=described.name,
        speed=Omega,
        unbalance=amount,
        sites=machine.sites,
        loop_growth=0.0 if loop.is_stable and loop.growth > 0.0 else loop.growth,
        loop_frequency=loop.frequency,
        kind=KINDS[regime_of(states)],
        states=states,
        own=tuple(contact_whirls(machine, Omega)),
        sustained=tuple(whirls(machine, Omega)),
        rolling=tuple(rolling(machine, Omega)),
        least_trapping=least if math.isfinite(least) else None,
        touching=(touching * amount, touching_at),
        trapping=None if least_over_speeds is None else (least_over_speeds[0] * amount, least_over_speeds[1]),
        grade_limit=limit * Omega / speeds,
        grade_limit_at_speed=limit,
        smallest_force=freeing_currents,
        control=control_of(machine, Omega, states, demands) if loop.is_stable else {},
        speeds=speeds,
        unbalances=factors * amount,
        kinds=map_states.regimes(),
        least_trapping_over_speed=curve * amount,
        curves=curves,
        orbits=clearance_shares(machine, curves.speeds) * machine.c,
        clearances=machine.c,
        notes=tuple(notes),
        warnings=prepared.warnings,
    )


def _largest(machine: RubbingRotor, speeds: Array, limit: float) -> float:
    """Return the largest factor of a map: at least 2, and above the smallest factors that cause contact and trapping.

    Parameters
    ----------
    limit
        Factor that balancing grade G 2.5 allows at the machine's speed; the search covers at least ten times this
        factor.
    """
    touching, _ = least_touching(machine, speeds)
    end = max(BEYOND_GRADE * limit, MARGIN * touching, 2.0)
    searched = np.geomspace(min(0.1 * touching, 0.1 * end), end, SEARCH_AMOUNTS)
    step = max(1, len(speeds) // SEARCH_SPEEDS)
    least = trap_map(machine, speeds[::step], searched, AT_ONCE).least_trapping()
    if np.isnan(least).all():
        return end
    return max(MARGIN * float(np.nanmin(least)), MARGIN * touching, 2.0)


def _factors(largest: float) -> Array:
    """Return the factors of a map: evenly spaced for `largest` up to `WIDE`, otherwise logarithmic from 0.5."""
    if largest <= WIDE:
        return np.linspace(LOWEST, 1.0, AMOUNTS) * largest
    return np.geomspace(0.5, largest, AMOUNTS)


def _force_text(force: float | None) -> str:
    return "without limit" if force is None else force_unit(force).text(force)


def _grams(unbalance: float) -> str:
    return f"{1e3 * unbalance:.4g} g m"


def _with_unbalance(machine: RubbingRotor, unbalance: Number | None, place: str | None) -> RubbingRotor:
    if place is not None:
        require(place in machine.places, "place", place, f"one of {', '.join(machine.places)}")
    if unbalance is None and place is None:
        require(
            bool(np.any(machine.unbalance)),
            "unbalance",
            "0 kg m",
            "> 0 kg m: set unbalance, or use a scenario with unbalance",
        )
        return machine
    amount = np.abs(machine.unbalance).max() if unbalance is None else positive(unbalance, "kg.m", "unbalance")
    require(amount > 0.0, "unbalance", "0 kg m", "> 0 kg m")
    where = machine.places[0] if place is None else place
    if place is None and np.any(machine.unbalance):
        return replace(machine, unbalance=machine.unbalance * amount / np.abs(machine.unbalance).max())
    placed = np.array([amount if name == where else 0.0 for name in machine.places], dtype=complex)
    return replace(machine, unbalance=placed)
