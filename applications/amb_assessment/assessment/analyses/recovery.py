"""Relevitation after a landing, and the overload at which a retainer is touched."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from amb_assessment.assessment.findings import AnalysisResult, Quantity
from amb_assessment.assessment.runs import clearance_used, has_no_gravity, simulate, without_power, worst_inputs
from amb_assessment.assessment.subject import Subject
from amb_assessment.reporting.panels import Panel, curve
from amb_cosim.results.component_names import ACTUATOR, PLANT
from amb_cosim.results.result import Result
from amb_cosim.scenario.gravity import STANDARD_GRAVITY
from array_types import Array

WITHOUT_POWER = 0.3  # s
BACK = 0.3  # s with power after that
TOUCHED = 1.0 - 1e-9  # of the clearance
OVERLOAD_STEP, OVERLOAD_TIME, MOST = 0.25, 0.02, 8.0  # of the weight, s, of the weight


def answer(subject: Subject) -> AnalysisResult:
    """Return the distance to contact after the power returns, and the overload that causes contact."""
    Omega = subject.file.speed.highest
    inputs = worst_inputs(subject)
    returned = _with_power_back(without_power(subject, 1.0), WITHOUT_POWER)
    again = simulate(subject, Omega, inputs, end_time=WITHOUT_POWER + BACK, **returned)
    overload, used = _overload(subject, Omega, inputs)
    panels = (
        _over_time("Power returns", clearance_used(subject, again), WITHOUT_POWER + BACK),
        _over_time("Rising overload", used, MOST / OVERLOAD_STEP * OVERLOAD_TIME),
    )
    notes = (
        f"The overload is an acceleration of the base along x or y, in either sense, that rises by {OVERLOAD_STEP:g} g "
        f"every {1e3 * OVERLOAD_TIME:g} ms, on top of gravity and unbalance; the worst of the four counts.",
    )
    return AnalysisResult((_relevitation(subject, again), overload), panels, (), notes)


def _with_power_back(lost: Mapping[str, Any], after: float) -> dict[str, Any]:
    back = {"role": "relief", "time": after, "set": {ACTUATOR: {"*.amplifier_off_?": False}}}
    return {**lost, "event": [*lost["event"], back]}


def _relevitation(subject: Subject, again: Result) -> Quantity:
    """Return the share of the clearance that the rotor uses in the last tenth of the run after the power returns."""
    used = clearance_used(subject, again)
    last = {site: float(of[-max(1, len(of) // 10) :].max()) for site, of in used.items()}
    site = max(last, key=lambda site_name: last[site_name])
    fallen = max(float(of[: int(len(of) * WITHOUT_POWER / (WITHOUT_POWER + BACK))].max()) for of in used.values())
    reason = "" if fallen >= TOUCHED else f"the rotor touches nothing in {WITHOUT_POWER:g} s without power"
    if has_no_gravity(subject):
        reason = "the machine has no gravity: nothing is lifted"
    where = f"{site}, {BACK:g} s after the power returns"
    return Quantity("relevitation", where, 100.0 * last[site], "%", {}, reason, reason)


def _overload(subject: Subject, Omega: float, inputs: Mapping[str, float]) -> tuple[Quantity, dict[str, Array]]:
    """Return the least acceleration of the base, over g, at which the rotor first touches anything, and its run."""
    runs = [_rising(subject, Omega, inputs, axis, sign) for axis in "xy" for sign in "+-"]
    return min(runs, key=lambda run: (run[0].value, -max(float(of.max()) for of in run[1].values())))


def _rising(
    subject: Subject, Omega: float, inputs: Mapping[str, float], axis: str, sign: str
) -> tuple[Quantity, dict[str, Array]]:
    """Return the acceleration of the base along an axis, over g, at which the rotor first touches anything."""
    count, step = round(MOST / OVERLOAD_STEP), float(f"{sign}1") * STANDARD_GRAVITY * OVERLOAD_STEP
    events = [{"time": k * OVERLOAD_TIME, "set": {PLANT: {f"base.a_{axis}": step * k}}} for k in range(1, count)]
    used = clearance_used(subject, simulate(subject, Omega, inputs, end_time=count * OVERLOAD_TIME, event=events))
    touched = np.max(list(used.values()), axis=0) >= TOUCHED
    if not touched.any():
        return Quantity("overload", "no contact", MOST, "1", {}, f"the runs end at {MOST:g} g"), used
    first = int(np.argmax(touched))
    share = first / len(touched)
    site = max(used, key=lambda site_name: float(used[site_name][first]))
    where = f"{site} is touched first, along {sign}{axis}"
    return Quantity("overload", where, OVERLOAD_STEP * int(share * count), "1", {}, "in g"), used


def _over_time(title: str, used: Mapping[str, Array], duration: float) -> Panel:
    curves = tuple(curve(site, np.linspace(0.0, duration, len(of)), 100.0 * of) for site, of in used.items())
    return Panel(title, "time (s)", "%", curves)
