"""Co-simulations of a machine with unbalance, and the rotor's distance to contact."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from amb_cosim.assessment.stages import co_simulated
from amb_cosim.assessment.subject import Subject
from amb_cosim.assessment.unbalance_cases import UnbalanceCase, unbalance_cases
from amb_cosim.machine.response import synchronous_response
from amb_cosim.results.component_names import ACTUATOR, CONTROLLER, PLANT
from amb_cosim.results.result import Result
from amb_cosim.scenario.simulation import prepare, run_prepared
from array_types import Array

SETTLING = 20.0  # cycles
FRICTION = 0.15  # of a landing that is followed
CHAIN = "chain.preset"
NOISY = {"chain.noise": True, "chain.adc": True, "chain.dac": True, "chain.filter": False, "chain.delay": False}


def worst_case(subject: Subject, Omega: float) -> UnbalanceCase:
    """Return the unbalance case with the largest probe displacement at a speed (rad/s)."""
    cases = unbalance_cases(subject)
    loads = [case.of(subject.unbalance_of_grade()) for case in cases]
    q = np.abs(synchronous_response(subject, np.array([Omega]), loads)[0]).max(axis=2)
    probes = [node - 1 for node in subject.probes.values()]
    return cases[int(q[:, probes].max(axis=1).argmax())]


def unbalance_inputs(subject: Subject, case: UnbalanceCase) -> dict[str, float]:
    """Return the unbalance (kg m) of the balancing grade, and its phase (rad), at the rotor's planes of unbalance.

    Each part of the case is moved to the nearest plane; parts of opposite sign there subtract.
    """
    discs = subject.rotor.discs
    if not discs:
        raise ValueError(f"rotor {subject.rotor.name} has no plane of unbalance; set unbalance = true for a body")
    sums = dict.fromkeys((disc.name for disc in discs), 0.0)
    for node, u in case.of(subject.unbalance_of_grade()).items():
        nearest = min(discs, key=lambda disc, at=node: abs(subject.z[disc.node - 1] - subject.z[at - 1]))  # type: ignore[misc]
        sums[nearest.name] += u.real
    result = {f"{name}.u": abs(u) for name, u in sums.items()}
    return result | {f"{name}.phi": np.pi for name, u in sums.items() if u < 0.0}


def simulate(
    subject: Subject, Omega: float, inputs: Mapping[str, float] | None = None, *, real: bool = False, **fields: Any
) -> Result:
    """Return the run of a machine, starting at a speed (rad/s).

    Parameters
    ----------
    subject
        The machine.
    Omega
        Speed at the beginning (rad/s).
    inputs
        Initial inputs of the rotor, by name.
    real
        Whether to use sensor noise and converter resolution, unless the machine defines its signal chain.
    fields
        Fields of a scenario.

    Raises
    ------
    ValueError
        If the run fails.
    """
    parameters = fields.pop("parameters", {})
    chain = subject.parameters.get(CONTROLLER, {})
    if real and chain.get(CHAIN) == 0.0:
        parameters = {**parameters, CONTROLLER: {CHAIN: "custom", **NOISY}}
    values: dict[str, Any] = {"settle_cycles": SETTLING, "parameters": parameters, **fields}
    if inputs:
        values["inputs"] = {PLANT: dict(inputs)}
    scenario = co_simulated(subject, Omega, **values)
    result = run_prepared(prepare(scenario, None, flavour=subject.flavour))
    if result.outcome.status == "interrupted":
        raise KeyboardInterrupt
    if result.outcome.failure is not None:
        raise ValueError(f"the run ended early: {result.outcome.failure}")
    return result


def clearance_used(subject: Subject, result: Result) -> dict[str, Array]:
    """Return the displacement over the clearance at every contact site, from cycle 0 on, by site."""
    signals, matches = result.signals, {}
    displayed = np.asarray(signals["time"].values) >= 0.0
    for name, (_, clearance) in subject.clearances.items():
        x, y = (np.asarray(signals[f"{PLANT}.{name}.{axis}"].values)[displayed] for axis in "xy")
        matches[name] = np.hypot(x, y) / clearance
    return matches


def switched_off(subject: Subject, cycle: float) -> dict[str, Any]:
    """Return the fields of a scenario in which all amplifiers lose their power at a cycle, and coils discharge."""
    local = subject.parameters[ACTUATOR]
    limits = {f"{b}.discharge_voltage_{a}": local[f"{b}.voltage_limit_{a}"] for b, a in subject.loop.axes}
    return {
        "parameters": {ACTUATOR: {"amplifier": "dynamic", "mean_current": True, **limits}},
        "event": [{"role": "disturbance", "cycle": cycle, "set": {ACTUATOR: {"*.amplifier_off_?": True}}}],
    }
