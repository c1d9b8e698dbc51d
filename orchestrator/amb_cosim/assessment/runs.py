"""Co-simulations of a machine with unbalance, and how near the rotor comes to what it can touch."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from amb_cosim.assessment.response import synchronous_response
from amb_cosim.assessment.subject import Subject
from amb_cosim.assessment.unbalance_cases import UnbalanceCase, unbalance_cases
from amb_cosim.results.places import ACTUATOR, CONTROLLER, PLANT
from amb_cosim.results.result import Result
from amb_cosim.scenario.simulation import prepare, run_prepared
from fmi_export.model import Array

SETTLING = 20.0  # cycles
FRICTION = 0.15  # of a landing that is followed
CHAIN = "chain.preset"
NOISY = {"chain.noise": True, "chain.adc": True, "chain.dac": True, "chain.filter": False, "chain.delay": False}


def worst_case(subject: Subject, Omega: float) -> UnbalanceCase:
    """Return the case of unbalance under which the probes move most at a speed (rad/s)."""
    cases = unbalance_cases(subject)
    loads = [case.of(subject.unbalance_of_grade()) for case in cases]
    q = np.abs(synchronous_response(subject, np.array([Omega]), loads)[0]).max(axis=2)
    probes = [node - 1 for node in subject.probes.values()]
    return cases[int(q[:, probes].max(axis=1).argmax())]


def unbalance_inputs(subject: Subject, case: UnbalanceCase) -> dict[str, float]:
    """Return the unbalance (kg m) of the balancing grade, and its phase (rad), at the rotor's own planes of unbalance.

    Each part of the case is at the plane that is nearest to it; those of opposite sign that meet there subtract.
    """
    discs = subject.rotor.discs
    if not discs:
        raise ValueError(f"rotor {subject.rotor.name} has no plane of unbalance: give a body unbalance = true")
    sums = dict.fromkeys((disc.name for disc in discs), 0.0)
    for node, u in case.of(subject.unbalance_of_grade()).items():
        nearest = min(discs, key=lambda disc, at=node: abs(subject.z[disc.node - 1] - subject.z[at - 1]))  # type: ignore[misc]
        sums[nearest.name] += u.real
    result = {f"{name}.u": abs(u) for name, u in sums.items()}
    return result | {f"{name}.phi": np.pi for name, u in sums.items() if u < 0.0}


def simulate(
    subject: Subject, Omega: float, inputs: Mapping[str, float] | None = None, *, real: bool = False, **fields: Any
) -> Result:
    """Return the run of a machine from a speed (rad/s) on.

    Parameters
    ----------
    subject
        The machine.
    Omega
        Speed at the beginning (rad/s).
    inputs
        First inputs of the rotor, by name.
    real
        Whether sensors are noisy and converters step, unless the machine says what its signal chain does.
    fields
        As of a scenario.

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
    scenario = subject.co_simulated.as_scenario(Omega, **values)
    result = run_prepared(prepare(scenario, None, flavour=subject.flavour))
    if result.outcome.status == "interrupted":
        raise KeyboardInterrupt
    if result.outcome.failure is not None:
        raise ValueError(f"the run ended early: {result.outcome.failure}")
    return result


def clearance_used(subject: Subject, result: Result) -> dict[str, Array]:
    """Return the displacement over the clearance at every place that the rotor can touch, from cycle 0 on, by place."""
    signals, matches = result.signals, {}
    displayed = np.asarray(signals["time"].values) >= 0.0
    for name, (_, clearance) in subject.clearances.items():
        x, y = (np.asarray(signals[f"{PLANT}.{name}.{axis}"].values)[displayed] for axis in "xy")
        matches[name] = np.hypot(x, y) / clearance
    return matches


def switched_off(subject: Subject, cycle: float) -> dict[str, Any]:
    """Return the fields of a scenario in which all amplifiers lose their power at a cycle: coils discharge."""
    local = subject.parameters[ACTUATOR]
    limits = {f"{b}.discharge_voltage_{a}": local[f"{b}.voltage_limit_{a}"] for b, a in subject.loop.axes}
    return {
        "parameters": {ACTUATOR: {"amplifier": "dynamic", "mean_current": True, **limits}},
        "event": [{"role": "disturbance", "cycle": cycle, "set": {ACTUATOR: {"*.amplifier_off_?": True}}}],
    }
