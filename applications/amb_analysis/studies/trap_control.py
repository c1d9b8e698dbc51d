"""Kinds of control that free a trapped rotor within the current limits of its bearings."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from amb_analysis.steady_contact.forward_loop import Complex
from amb_analysis.steady_contact.receptances import Receptances
from amb_analysis.steady_contact.rubbing_rotor import RubbingRotor
from amb_analysis.steady_contact.synchronous_control import adaptation_rates, settled
from amb_analysis.steady_contact.synchronous_states import all_sets, states_of
from amb_analysis.studies.trap_states import BearingCurrent, SynchronousState, currents_of
from amb_cosim.presentation.text_tables import number


@dataclass(frozen=True, eq=False)
class Freed:
    """Whether a kind of control frees the rotor at the machine's speed and unbalance.

    frees
        Whether the control excludes all states in contact.
    currents
        Demanded current of each bearing.
    words
        The result in words.
    """

    frees: bool
    currents: dict[str, BearingCurrent]
    words: str


def control_of(
    machine: RubbingRotor,
    Omega: float,
    states: tuple[SynchronousState, ...],
    demands: Sequence[dict[str, BearingCurrent]],
) -> dict[str, Freed]:
    """Return, for feedback, synchronous control and contact-aware control, whether each frees the rotor.

    The loop without contact must be stable at this speed.
    """
    trapped = [state for state in states if state.contact and state.stable]
    free = [state for state in states if not state.contact and state.stable]
    free_currents = free[0].currents if free else {}
    possible = _are_allowed(free_currents)
    if free and not trapped:
        words = "free (no stable steady contact)" if possible else "free only with currents beyond its limits"
        words += _within(free_currents)
    else:
        words = (
            "may leave the rotor in contact" if free else "cannot free the rotor: no stable contact-free orbit exists"
        )
    result = {"feedback alone": Freed(bool(free) and not trapped and possible, free_currents, words)}
    if not machine.loop(Omega).currents:
        return result
    result["synchronous control"] = _synchronous(machine, Omega)
    if not demands:
        freed = Freed(False, {}, "cannot free the rotor: no synchronous currents can")
    else:
        within = [d for d in demands if _are_allowed(d)]
        needed = within[0] if within else demands[-1]
        words = (
            "can free the rotor from any steady contact"
            if within
            else "cannot free the rotor from all contact within its limits"
        )
        freed = Freed(bool(within), needed, f"{words}{_within(needed)}")
    result["contact-aware synchronous control"] = freed
    return result


def _synchronous(machine: RubbingRotor, Omega: float) -> Freed:
    """Return whether synchronous control frees the rotor, both with its steady force and while it adapts in contact."""
    at, mu = machine.receptances(Omega), machine.mu(Omega)
    converged, force = settled(at), machine.unbalance * Omega**2
    orbit = states_of((), converged.R, mu, machine.c, (converged.P @ force)[None])
    values: Complex = converged.currents[1] @ force
    currents = currents_of(dict(zip(machine.loop(Omega).currents, values, strict=True)), machine, Omega)
    if not len(orbit.points):
        return Freed(False, currents, "cannot free the rotor: every orbit under its steady force touches a site")
    possible = _are_allowed(currents)
    words = ("can hold the rotor free" if possible else "cannot hold the rotor free within its limits") + _within(
        currents
    )
    stuck = {contact for contact, rate in _adaptation_growth(machine, at, converged) if rate < 0.0}
    diverging = list(dict.fromkeys(contact for contact, rate in _adaptation_growth(machine, at, at) if rate > 0.0))
    if stuck:
        words += f"; the rotor may also settle in contact at {', '.join(sorted(stuck))}"
    elif diverging:
        words += f"; its adaptation diverges during contact at {', '.join(diverging)}"
    return Freed(possible and not stuck and not diverging, currents, words)


def _adaptation_growth(machine: RubbingRotor, at: Receptances, held: Receptances) -> Iterator[tuple[str, float]]:
    """Yield the sites of each contact state under `held`, and the adaptation's growth rate divided by alpha (1).

    Of the growth rates in a state, the largest is used. `held` contains the receptances that determine the states, and
    `at` contains the receptances under feedback alone.
    """
    mu, r = machine.mu(at.Omega), (held.P @ (machine.unbalance * at.Omega**2))[None]
    for contact in all_sets(len(machine.sites))[1:]:
        states = states_of(contact, held.R, mu, machine.c, r)
        for n in range(len(states.points)):
            rates = adaptation_rates(at, states, n, machine.c, mu)
            yield "+".join(machine.sites[k] for k in contact), float(rates.real.max())


def _are_allowed(currents: Mapping[str, BearingCurrent]) -> bool:
    return all(current.is_allowed for current in currents.values())


def _within(currents: Mapping[str, BearingCurrent]) -> str:
    if not currents:
        return ""
    amounts = ", ".join(
        f"{bearing} {number(current.amplitude)} of {number(current.allowed)} A" for bearing, current in currents.items()
    )
    return f" ({amounts})"
