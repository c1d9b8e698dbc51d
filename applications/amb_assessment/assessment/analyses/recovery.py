"""Relevitation after a landing, and the overload and the axial force at which the rotor comes into contact."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from amb_assessment.assessment.format.quantities import AnalysisResult, Quantity, declare
from amb_assessment.assessment.physics.assessed_machine import AssessedMachine
from amb_assessment.assessment.physics.axial_cases import weight_along_z
from amb_assessment.assessment.physics.runs import (
    clearance_used,
    has_no_gravity,
    simulate,
    times_of,
    upright,
    without_power,
    worst_inputs,
)
from amb_assessment.reporting.panels import Panel, curve
from amb_cosim.results.component_names import ACTUATOR, PLANT
from amb_cosim.results.result import Result
from amb_cosim.scenario.gravity import STANDARD_GRAVITY
from array_types import Array

declare("relevitation", "%")
declare("overload", "1", title="Acceleration that the rotor withstands without contact, over g")
declare("axial_capacity", "N", ("capacity",), "Force along the shaft that the rotor withstands without contact")

WITHOUT_POWER = 0.3  # s
BACK = 0.3  # s, with power again
TOUCHED = 1.0 - 1e-9  # of the clearance
ROUNDING = 1e-9  # of a time: contact at the end of a step belongs to the acceleration of this step
OVERLOAD_STEP, OVERLOAD_TIME, MOST = 0.25, 0.02, 8.0  # of the weight, s, of the weight
ALIKE = 6  # digits of displacements over clearance: of directions that agree to these, the first is named
FORCE_STEPS, FORCE_TIME, MOST_FORCE = 50, 0.04, 1.25  # s of each, of the capacity by formula


def result_of(subject: AssessedMachine) -> AnalysisResult:
    """Return how close the rotor is to contact after the power returns, and the overload that causes contact."""
    Omega = subject.file.speed.highest
    inputs = worst_inputs(subject)
    returned = _with_power_back(without_power(subject, 1.0), WITHOUT_POWER)
    again = simulate(subject, Omega, inputs, to_magnets=True, end_time=WITHOUT_POWER + BACK, **returned)
    overload, rising = _overload(subject, Omega, inputs)
    panels = tuple(
        Panel(
            title, "time (s)", "%", tuple(curve(site, times_of(run), 100.0 * shares) for site, shares in used.items())
        )
        for title, run, used in (
            ("Power returns", again, clearance_used(subject, again)),
            ("Rising overload", rising, clearance_used(subject, rising)),
        )
    )
    notes: tuple[str, ...] = (
        f"The overload is an acceleration of the base along {' or '.join(subject.directions_of_contact)}, in either "
        f"direction, in addition to gravity and unbalance. It rises by {OVERLOAD_STEP:g} g every "
        f"{1e3 * OVERLOAD_TIME:g} ms; the worst direction is judged.",
        "A rotor that crosses the air gap of a magnet is in contact; if the magnet is energised, the run ends.",
    )
    carried = _carried(subject, Omega, inputs)
    if carried:
        notes += (
            f"The force along the shaft rises in {FORCE_STEPS} steps over {FORCE_STEPS * FORCE_TIME:g} s. If the "
            "integrator of the controller is slow, the axis carries less in this time than its magnet could.",
        )
    relevitation = _relevitation(subject, again)
    if relevitation.value >= 100.0 * TOUCHED:
        notes += (
            "The controller continues while the power is off. If its integrators have no anti-windup, they hold the "
            f"rotor against its retainers for longer than {BACK:g} s after the power returns.",
        )
    return AnalysisResult((relevitation, overload, *carried), panels, (), notes)


def _with_power_back(lost: Mapping[str, Any], after: float) -> dict[str, Any]:
    back = {"role": "relief", "time": after, "set": {ACTUATOR: {"*.amplifier_off_?": False}}}
    return {**lost, "event": [*lost["event"], back]}


def _relevitation(subject: AssessedMachine, again: Result) -> Quantity:
    """Return the displacement relative to the clearance at the end of the run, after the power has returned."""
    used = clearance_used(subject, again)
    last = {site: float(shares[-max(1, len(shares) // 10) :].max()) for site, shares in used.items()}
    site = max(last, key=lambda site_name: last[site_name])
    is_off = times_of(again) < WITHOUT_POWER
    largest = max(float(shares[is_off].max()) for shares in used.values())
    reason = "" if largest >= TOUCHED else f"the rotor touches nothing in {WITHOUT_POWER:g} s without power"
    if has_no_gravity(subject):
        reason = "the machine has no gravity, so there is nothing to lift"
    reason = upright(subject) or reason
    when = f"{BACK:g} s after the power returns" if again.outcome.failure is None else "when the run ends"
    where = f"{site}, {when}"
    return Quantity("relevitation", where, 100.0 * last[site], "%", {}, reason, reason)


def _overload(subject: AssessedMachine, Omega: float, inputs: Mapping[str, float]) -> tuple[Quantity, Result]:
    """Return the smallest base acceleration, in g, at which the rotor touches anything, and its run."""
    runs = [_rising(subject, Omega, inputs, axis, sign) for axis in subject.directions_of_contact for sign in "+-"]
    *_, overload, run = min(runs, key=lambda rising: (rising[0], round(rising[1], ALIKE)))
    return overload, run


def _carried(subject: AssessedMachine, Omega: float, inputs: Mapping[str, float]) -> tuple[Quantity, ...]:
    """Return the force along the shaft that the axial axis carries in co-simulation before the rotor touches a face.

    This is the force in the weaker direction, and it includes the weight. The result is empty if the rotor has no faces
    or the machine has no thrust bearing.
    """
    thrust = subject.file.thrust_bearing
    if thrust is None or not subject.rotor.faces:
        return ()
    capacity, weight, found = thrust.bearing.capacity, weight_along_z(subject), []
    for sign in (1.0, -1.0):
        forces = np.linspace(weight, sign * MOST_FORCE * capacity, FORCE_STEPS + 1)
        of_process = forces[1:] - weight
        *_, step = _stepped(subject, Omega, inputs, f"{subject.rotor.thrust}.f_process", of_process, FORCE_TIME)
        carried = sign * float(forces[FORCE_STEPS if step is None else max(step - 1, 0)])
        found.append((max(carried, 0.0), "along +z" if sign > 0.0 else "along -z"))
    value, where = min(found)
    note = f"the capacity of the bearing by formula, which ignores the limits of the controller, is {capacity:.4g} N"
    return (Quantity("axial_capacity", where, value, "N", {"capacity": capacity}, note),)


def _stepped(
    subject: AssessedMachine, Omega: float, inputs: Mapping[str, float], name: str, values: Array, each: float
) -> tuple[Result, str, float, int | None]:
    """Return a run in which an input of the rotor takes the `values` in turn, and data on the first contact.

    The input takes its next value every `each` seconds, starting after `each` seconds. Besides the run, the function
    returns the place that the rotor touches first, the largest displacement relative to the clearance, and the position
    in `values`, counted from 1, of the value that acts at contact. Without contact, the place is empty and the position
    is None.
    """
    events = [{"time": k * each, "set": {PLANT: {name: float(value)}}} for k, value in enumerate(values, 1)]
    end = (len(values) + 1) * each
    run = simulate(subject, Omega, inputs, to_magnets=True, levitated=True, end_time=end, event=events)
    used = clearance_used(subject, run)
    largest = np.max(list(used.values()), axis=0)
    touched = np.flatnonzero(largest >= TOUCHED)
    if not len(touched):
        return run, "", float(largest.max()), None
    first = touched[0]
    site = max(used, key=lambda place: float(used[place][first]))
    return run, site, float(largest.max()), int(times_of(run)[first] / each * (1.0 - ROUNDING))


def _rising(
    subject: AssessedMachine, Omega: float, inputs: Mapping[str, float], axis: str, sign: str
) -> tuple[float, float, Quantity, Result]:
    """Return the base acceleration along an axis, in g, at which the rotor first touches anything.

    The function also returns the negative of the largest displacement relative to the clearance, the acceleration as a
    `Quantity`, and the run.
    """
    levels: Array = OVERLOAD_STEP * np.arange(1.0, round(MOST / OVERLOAD_STEP) + 1.0)
    accelerations = float(f"{sign}1") * STANDARD_GRAVITY * levels
    run, site, largest, step = _stepped(subject, Omega, inputs, f"base.a_{axis}", accelerations, OVERLOAD_TIME)
    if step is None:
        overload = Quantity("overload", "no contact", MOST, "1", {}, f"the overload rises to at most {MOST:g} g")
    else:
        where = f"{site} is touched first, along {sign}{axis}"
        overload = Quantity("overload", where, OVERLOAD_STEP * step, "1", {}, "in g")
    return overload.value, -largest, overload, run
