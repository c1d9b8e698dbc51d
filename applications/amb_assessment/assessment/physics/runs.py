"""Co-simulations of a machine with unbalance, and the rotor's distance to contact."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from amb_analysis.machine.machine import air_gap
from amb_analysis.machine.response import refined_response
from amb_assessment.assessment.physics.assessed_machine import AssessedMachine
from amb_assessment.assessment.physics.stages import co_simulated, real_coefficients, with_tables
from amb_assessment.assessment.physics.unbalance_cases import UnbalanceCase, unbalance_cases
from amb_cosim.cosim.run.checkpoint import Checkpoint
from amb_cosim.cosim.run.options import RunOptions, Saves
from amb_cosim.results.component_names import ACTUATOR, CONTROLLER, PLANT
from amb_cosim.results.contact_forces import touches
from amb_cosim.results.result import Result
from amb_cosim.results.thinned import judged
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.simulation import execute
from array_types import Array
from rotor_analysis.response import orbit

SETTLING, LONGEST_SETTLING = 20.0, 400.0  # cycles
REMAINS = 0.01  # share of the transient that remains when a run is judged
EXCITED = 2.0  # highest frequency of the transient, over the spin speed
CYCLES = 60.0  # of a run at a speed
SPEEDS = 81  # of a response, before refinement about critical speeds and maxima
FRICTION = 0.15  # of a landing to rest
CHAIN = "chain.preset"
NOISY = {"chain.noise": True, "chain.adc": True, "chain.dac": True, "chain.filter": False, "chain.delay": False}


@dataclass(frozen=True)
class PlacedUnbalance:
    """The unbalance of the balancing grade, placed at planes of the co-simulated rotor to excite a mode.

    case
        The mode.
    at
        Unbalance (kg m) by plane, with the sign of the mode's shape; the absolute values sum to the total.
    """

    case: UnbalanceCase
    at: Mapping[str, float]

    @property
    def inputs(self) -> dict[str, float]:
        """Inputs of the rotor: unbalance (kg m) and its phase (rad)."""
        result = {f"{plane}.u": abs(u) for plane, u in self.at.items()}
        return result | {f"{plane}.phi": np.pi for plane, u in self.at.items() if u < 0.0}

    @property
    def note(self) -> str:
        """The unbalance in words."""
        places = ", ".join(f"{1e6 * u:+.4g} g mm at {plane}" for plane, u in self.at.items() if u)
        return f"{places}, for {self.case.name.split(',')[0]}"


@dataclass(frozen=True)
class WorstResponse:
    """The largest steady displacement relative to the clearance, and the speed and unbalance that cause it.

    unbalance, Omega
        The unbalance and the speed (rad/s).
    site, share
        Place with the largest displacement relative to the clearance, and this ratio (1).
    shares
        Displacement relative to the clearance at each place (1).
    """

    unbalance: PlacedUnbalance
    Omega: float
    site: str
    shares: Mapping[str, float]

    @property
    def share(self) -> float:
        """The largest displacement relative to the clearance (1)."""
        return self.shares[self.site]

    def with_run(self, site: str, simulated: float) -> tuple[float, str]:
        """Return the larger of steady and simulated displacement at a site (% of clearance), and a note on both.

        The steady displacement is included because a short run may not reach it. It is limited to the clearance,
        because the retainers stop the rotor there.
        """
        steady = min(self.shares[site], 1.0)
        note = f"steady response {100.0 * steady:.3g} %, simulated {100.0 * simulated:.3g} %"
        return 100.0 * max(simulated, steady), note


def planes_of_unbalance(subject: AssessedMachine) -> dict[str, int]:
    """Return, by name, the nodes of disc planes and bearings, where the co-simulated rotor can have unbalance."""
    return {part.name: part.node for part in (*subject.rotor.bearings, *subject.rotor.discs)}


def placed_unbalances(subject: AssessedMachine) -> list[PlacedUnbalance]:
    """Return the unbalance of the balancing grade, placed to excite each mode.

    Each lobe of a mode shape receives a share in proportion to its modal mass, at the plane in this lobe where the
    shape is largest. If a lobe contains no plane, its share is distributed to the other lobes in proportion to their
    shares. Therefore, the whole unbalance is always placed, and no part of it cancels another.
    """
    planes, total = planes_of_unbalance(subject), subject.unbalance_of_grade()
    result = []
    for case in unbalance_cases(subject):
        shares: dict[str, float] = {}
        for share, (first, last) in zip(case.shares.values(), case.lobes, strict=True):
            within = [plane for plane, node in planes.items() if first <= node <= last]
            if within:
                chosen = max(within, key=lambda plane: abs(case.shape[planes[plane] - 1]))
                shares[chosen] = share
        scale = total / sum(map(abs, shares.values()))
        result.append(PlacedUnbalance(case, {plane: scale * share for plane, share in shares.items()}))
    return result


def worst_response(subject: AssessedMachine, lowest: float, highest: float, sites: Sequence[str] = ()) -> WorstResponse:
    """Return the largest steady response to any mode's unbalance at any speed (rad/s) from the lowest to the highest.

    The offset of a place is added to the major axis of the orbit there. The speeds are refined about critical speeds
    and maxima (`rotor_analysis.refinement`). The forces of the magnetic bearings are linear, and seals and stages are
    included.

    Parameters
    ----------
    subject, lowest, highest
        The machine, and the limits of the speed range.
    sites
        Places to consider; all by default.
    """
    unbalances, others = placed_unbalances(subject), real_coefficients(subject)
    loads = [{subject.rotor.point_of(plane): complex(u) for plane, u in placed.at.items()} for placed in unbalances]
    names = list(subject.clearances)
    nodes, limits, _, offsets = zip(*subject.clearances.values(), strict=True)
    considered = [names.index(site) for site in sites or names]
    speeds = with_tables(subject, np.unique(np.linspace(lowest, highest, SPEEDS)))
    speeds, motion = refined_response(subject, speeds, loads, [nodes[site] for site in considered], others)
    amplitudes = orbit(motion[:, :, [node - 1 for node in nodes]])[0]
    used = (np.array(offsets) + amplitudes) / np.array(limits)
    n, k, top = np.unravel_index(int(used[:, :, considered].argmax()), (*used.shape[:2], len(considered)))
    at_sites = dict(zip(names, used[n, k].tolist(), strict=True))
    return WorstResponse(unbalances[k], float(speeds[n]), names[considered[top]], at_sites)


def worst_inputs(subject: AssessedMachine) -> dict[str, float]:
    """Return the unbalance that causes the largest steady response at the largest speed, as inputs of the rotor."""
    Omega = subject.file.speed.highest
    return worst_response(subject, Omega, Omega).unbalance.inputs


def steady_vibration(subject: AssessedMachine, response: WorstResponse) -> dict[str, Array]:
    """Return, by site, the displacement relative to the clearance in a run at the speed and unbalance of a response.

    The run includes sensor noise and converter resolution.
    """
    inputs = response.unbalance.inputs
    run = simulate(subject, response.Omega, inputs, real=True, to_magnets=True, levitated=True, end_cycle=CYCLES)
    return clearance_used(subject, run)


def simulate(
    subject: AssessedMachine,
    Omega: float,
    inputs: Mapping[str, float] | None = None,
    *,
    real: bool = False,
    to_magnets: bool = False,
    levitated: bool = False,
    start: Checkpoint | None = None,
    goes_on: bool = False,
    **fields: Any,
) -> Result:
    """Return a run of a machine; the rotor initially turns at a given speed (rad/s).

    Parameters
    ----------
    subject
        The machine.
    Omega
        Speed at the beginning (rad/s).
    inputs
        Initial inputs of the rotor, by name.
    real
        Whether to simulate sensor noise and converter resolution. A signal chain that the machine defines takes
        precedence.
    to_magnets
        Whether the rotor may reach a magnet, which ends the run.
    levitated
        Whether the magnets have power throughout (`co_simulated`).
    start
        Saved end of a shorter version of the same run, from which this run continues; see `end_of`.
    goes_on
        Whether to save the end of the run, so that another run can continue from it.
    fields
        Further fields of the scenario.

    Raises
    ------
    ValueError
        If the run fails.
    """
    parameters = fields.pop("parameters", {})
    chain = subject.parameters.get(CONTROLLER, {})
    if real and chain.get(CHAIN) == 0.0:
        parameters = {**parameters, CONTROLLER: {CHAIN: "custom", **NOISY}}
    values: dict[str, Any] = {"settle_cycles": settling_cycles(subject, Omega), "parameters": parameters, **fields}
    if inputs:
        values["inputs"] = {PLANT: dict(inputs)}
    scenario = co_simulated(subject, Omega, levitated=levitated, **values)
    options = RunOptions(flavour=subject.flavour, start=start)
    prepared = prepare_run(scenario, None, options=options)
    if goes_on and all(interface.serialises_state for interface in prepared.interfaces.values()):
        options = replace(options, saves=Saves(points=(prepared.last,)))
    result = execute(prepared, options)
    if result.outcome.status == "interrupted":
        raise KeyboardInterrupt
    if result.outcome.failure is not None and not (to_magnets and ended_at_magnet(subject, result)):
        raise ValueError(f"the run ended early: {result.outcome.failure}")
    return result


def has_chain(subject: AssessedMachine) -> bool:
    """Return whether the controller models sensor noise and converters."""
    return CHAIN in subject.prepared.interfaces[CONTROLLER].ports


def end_of(result: Result) -> Checkpoint | None:
    """Return the state at the end of a run that `goes_on`; None if the run ended early or an FMU cannot save states."""
    return next(iter(result.checkpoints.values()), None)


def ended_at_magnet(subject: AssessedMachine, result: Result) -> bool:
    """Return whether a run ended because the actuator failed after the rotor had crossed an air gap."""
    used = clearance_used(subject, result)
    gaps = [used[air_gap(bearing)] for bearing in subject.air_gaps]
    return result.outcome.component == ACTUATOR and any(len(shares) and shares[-1] >= 1.0 for shares in gaps)


def settling_cycles(subject: AssessedMachine, Omega: float) -> float:
    """Return the number of cycles, from 20 to 400, in which the initial vibrations decay to the share `REMAINS`.

        n = ln(1/REMAINS) Omega/(2 pi |sigma|)                                                         (1)

    sigma is the real part of the pole whose vibration decays most slowly. Only vibrations of the loop without stages,
    at frequencies up to twice the spin speed, are considered.

    Parameters
    ----------
    subject, Omega
        The machine, and its spin speed at the beginning (rad/s).
    """
    s = subject.loop.poles(Omega).s
    decays = -s.real[(s.real < 0.0) & (s.imag > 0.0) & (s.imag <= EXCITED * Omega)]
    slowest = float(decays.min(initial=np.inf))
    needed = -np.log(REMAINS) * Omega / (2.0 * np.pi * slowest)
    return float(np.ceil(np.clip(needed, SETTLING, LONGEST_SETTLING)))


def clearance_used(subject: AssessedMachine, result: Result) -> dict[str, Array]:
    """Return the displacement relative to the clearance at every place that the rotor can touch, from cycle 0 on.

    This ratio is taken at every step (see `judged`), and it is at least 1 at the end of a step in which the rotor
    touches the place. At a face, the ratio describes the displacement along the shaft, and it is 0 if the rotor moves
    away from the face.
    """
    signals, used = judged(result.signals), {}
    has_settled = _recorded(result) >= 0.0
    for name, place in subject.clearances.items():
        x, y = (np.asarray(signals[f"{PLANT}.{place.signal}.{axis}"].values)[has_settled] for axis in "xy")
        share, touched = np.hypot(x, y) / place.clearance, touches(signals, place.signal)[has_settled]
        used[name] = np.where(touched, np.maximum(share, 1.0), share)
    for face in subject.rotor.faces:
        gap = np.asarray(signals[f"{PLANT}.{face.name}.gap"].values)[has_settled]
        share = np.maximum(1.0 - gap / subject.parameters[PLANT][f"{face.name}.clearance"], 0.0)
        used[face.name] = np.where(touches(signals, face.name)[has_settled], np.maximum(share, 1.0), share)
    return used


def times_of(result: Result) -> Array:
    """Return the times (s) of the samples in `clearance_used`."""
    times = _recorded(result)
    return times[times >= 0.0]


def _recorded(result: Result) -> Array:
    return np.asarray(judged(result.signals)["time"].values)


def without_power(subject: AssessedMachine, cycle: float, friction: float = FRICTION) -> dict[str, Any]:
    """Return the fields of a scenario in which all amplifiers lose power at the given cycle and the coils discharge.

    `friction` is the friction coefficient of all contacts.
    """
    parameters = subject.parameters[ACTUATOR]
    limits = {f"{b}.discharge_voltage_{a}": parameters[f"{b}.voltage_limit_{a}"] for b, a in subject.controlled_axes}
    actuator = {"amplifier": "dynamic", "mean_current": True, **limits}
    return {
        "parameters": {ACTUATOR: actuator, PLANT: {"*.mu": friction}},
        "event": [{"role": "disturbance", "cycle": cycle, "set": {ACTUATOR: {"*.amplifier_off_?": True}}}],
    }


def longest(subject: AssessedMachine, duration: float, steps: int) -> float:
    """Return the time (s) that a number of steps takes, but at most the given duration (s)."""
    return min(duration, steps * float(subject.prepared.step_size))


def check_falls(subject: AssessedMachine) -> None:
    """Raise a ValueError if a machine has no gravity, because its rotor does not fall without power."""
    if has_no_gravity(subject):
        raise ValueError("the machine has no gravity, so the rotor does not fall; set gravity in the machine file")


def upright(subject: AssessedMachine) -> str:
    """Return why landings are not realistic if no face stops the fall of an upright machine's rotor; otherwise ""."""
    if subject.gravity_across or not subject.file.axial_gravity or subject.falls_onto_a_face:
        return ""
    return "gravity acts only along the shaft, and the rotor file has no [[faces]] to stop the fall"


def has_no_gravity(subject: AssessedMachine) -> bool:
    """Return whether gravity acts neither across nor along the shaft."""
    return not subject.gravity_across and not subject.file.axial_gravity
