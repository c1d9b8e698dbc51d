"""The way to rest in the retainers, with more modes too; relevitation; the overload at which a retainer is touched."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w

from amb_cosim.acceptance.findings import Measured, PartResult, PartTable
from amb_cosim.acceptance.runs import clearance_used, simulate, switched_off, unbalance_inputs, worst_case
from amb_cosim.acceptance.subject import Subject, rpm
from amb_cosim.assessment.panels import Panel, curve
from amb_cosim.results.places import ACTUATOR, PLANT
from amb_cosim.results.result import Result
from amb_files.toml import read_toml
from fmi_export.model import Array
from rotor_analysis.packaged_rotors import rotor_path
from rotor_analysis.reduced_rotor import reduced_rotor
from rotor_analysis.rotor_file import load_rotor

TITLE = "Way to rest, relevitation and overload"
FRICTION = 0.15
TO_REST = 1.0  # s without power
CONVERGENCE = 0.2  # s, over which forces are compared with those of more modes
WITHOUT_POWER = 0.3  # s
BACK = 0.3  # s with power after that
ROUNDING = 1e-9  # of the speed, by which it may differ without being lost
GRAVITY = 9.81  # m/s^2
OVERLOAD_STEP, OVERLOAD_TIME, MOST = 0.25, 0.02, 8.0  # of the weight, s, of the weight


def answer(subject: Subject) -> PartResult:
    """Return time and heat to rest, how forces change with more modes, relevitation, and the overload that touches."""
    Omega = subject.file.speed.highest
    inputs = unbalance_inputs(subject, worst_case(subject, Omega))
    lost = switched_off(subject, 1.0)
    lost["parameters"] = lost["parameters"] | {PLANT: {"*.mu": FRICTION}}
    fallen = simulate(subject, Omega, inputs, end_time=TO_REST, **_coasting(lost))
    returned = _with_power_back(lost, WITHOUT_POWER)
    again = simulate(subject, Omega, inputs, end_time=WITHOUT_POWER + BACK, **returned)
    measured = [*_to_rest(subject, fallen), *_convergence(subject, Omega, inputs, lost), _relevitation(subject, again)]
    overload, used = _overload(subject, Omega, inputs)
    measured.append(overload)
    panels = (
        _over_time("Displacement over clearance without power", clearance_used(subject, fallen), TO_REST),
        _over_time("Power returns", clearance_used(subject, again), WITHOUT_POWER + BACK),
        _over_time("Overload that rises", used, MOST / OVERLOAD_STEP * OVERLOAD_TIME),
    )
    touched = fallen.summary.touchdown.retainers if fallen.summary.touchdown else {}
    rows = [(site, *_texts(found)) for site, found in touched.items()]
    heads = ("place", "free (s)", "sliding (s)", "rolling (s)", "whirl", "heat (J)", "temperature (K)")
    notes = (
        f"From {rpm(Omega):.0f} 1/min with friction {FRICTION:g}, the drive off and the spin free. At rest means that "
        "the rotor lies in its retainers within 5 % of the clearance; it may turn on. Time to standstill is by the "
        "deceleration in the second half of the run, which friction of constant force goes on with; a race without "
        "drag (`race_drag`) turns on with the rotor and takes hardly any.",
        f"The overload is an acceleration of the base along y that rises by {OVERLOAD_STEP:g} g every "
        f"{1e3 * OVERLOAD_TIME:g} ms, on top of gravity and unbalance.",
        *subject.note_on_stages,
    )
    return PartResult(tuple(measured), panels, (PartTable(f"{TO_REST:g} s without power", heads, tuple(rows)),), notes)


def _texts(found: Any) -> tuple[str, ...]:
    numbers = (found.free, found.sliding, found.rolling)
    rest = (found.heat, found.temperature)
    shown = [*(_number(one) for one in numbers), found.whirl or "-", *(_number(one) for one in rest)]
    return tuple(shown)


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.4g}"


def _coasting(lost: Mapping[str, Any]) -> dict[str, Any]:
    """Return the same loss of power with a free spin whose drive is off."""
    parameters = {**lost["parameters"], PLANT: {**lost["parameters"][PLANT], "spin.free": True}}
    event, *others = lost["event"]
    off = {**event, "set": {**event["set"], PLANT: {"drive.torque_limit": 0.0}}}
    return {**lost, "parameters": parameters, "event": [off, *others]}


def time_to_standstill(times: Array, speeds: Array) -> float:
    """Return when a rotor stands still (s) that goes on to lose speed as in the second half of a run, Omega = a + b t.

    Infinite where it loses none.

    Parameters
    ----------
    times, speeds
        Ascending (s), and spin speed (rad/s), shape (n,), n > 3.
    """
    half = len(times) // 2
    slope, start = np.polyfit(times[half:], np.abs(speeds[half:]), 1)
    lost = -slope * (times[-1] - times[half])
    return float(-start / slope) if lost > ROUNDING * abs(start) else float("inf")


def _to_rest(subject: Subject, fallen: Result) -> list[Measured]:
    """Return times and heats of a fall, and the largest temperature where retainers have a heat capacity."""
    touchdown = fallen.summary.touchdown
    if touchdown is None:
        raise ValueError("the rotor does not fall: the machine needs gravity")
    rest, sites = touchdown.rest_after, touchdown.retainers.values()
    note = f"not at rest within {TO_REST:g} s, where the run ends" if rest is None else ""
    where = f"{TO_REST:g} s without power"
    found = [
        Measured("rest_time", where, TO_REST if rest is None else rest, "s", {}, note),
        Measured("retainer_heat", where, sum(one.heat or 0.0 for one in sites), "J"),
    ]
    times, speeds = (np.asarray(fallen.signals[name].values) for name in ("time", f"{PLANT}.speed"))
    standstill = time_to_standstill(times, speeds)
    if np.isfinite(standstill):
        heat = 0.5 * subject.parameters[PLANT]["spin.inertia"] * float(speeds[0]) ** 2
        found.append(Measured("standstill_time", "extrapolated", standstill, "s", {}, "drive off, by friction alone"))
        found.append(Measured("heat_to_standstill", "all retainers", heat, "J", {}, "energy of the spin"))
    hottest = [one.temperature for one in sites if one.temperature is not None]
    return found + ([Measured("retainer_temperature", where, max(hottest), "K")] if hottest else [])


def _convergence(
    subject: Subject, Omega: float, inputs: Mapping[str, float], lost: Mapping[str, Any]
) -> list[Measured]:
    """Return by how much the largest averaged force changes with twice the modes; nothing where there are no more."""
    source = rotor_path(subject.prepared.scenario.rotor)
    rotor = load_rotor(source)
    model = reduced_rotor(rotor).model
    planes = len(model.translations)
    kept, inner = model.size // 2 - planes, 2 * len(rotor.shaft.nodes) - planes
    more = min(2 * kept or planes, inner)
    if rotor.reduction.method == "none" or more <= kept:
        return []
    content = read_toml(source, "rotor file")
    masters = {key: value for key, value in content.get("reduction", {}).items() if key == "masters"}
    content["reduction"] = masters | {"method": "craig_bampton", "modes": more}
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"{rotor.name}.toml"
        path.write_text(tomli_w.dumps(content), encoding="utf-8")
        finer = replace(subject, file=subject.file.model_copy(update={"rotor": str(path)}))
        forces = [_largest(simulate(one, Omega, inputs, end_time=CONVERGENCE, **lost)) for one in (subject, finer)]
    change = 100.0 * abs(forces[1] / forces[0] - 1.0)
    note = (
        f"{forces[0]:.4g} N with {kept} modes in a plane of motion, {forces[1]:.4g} N with {more}; averaged over 1 ms"
    )
    return [Measured("landing_force_change", "largest force, twice the modes", change, "%", {}, note)]


def _largest(result: Result) -> float:
    return max((one or 0.0 for one in result.summary.averaged_contact_force.values()), default=0.0)


def _with_power_back(lost: Mapping[str, Any], after: float) -> dict[str, Any]:
    back = {"label": "removal", "time": after, "set": {ACTUATOR: {"*.amplifier_off_?": False}}}
    return {**lost, "event": [*lost["event"], back]}


def _relevitation(subject: Subject, again: Result) -> Measured:
    """Return how much of its clearance the rotor uses in the last tenth of the run after its power is back."""
    used = clearance_used(subject, again)
    last = {site: float(of[-max(1, len(of) // 10) :].max()) for site, of in used.items()}
    site = max(last, key=lambda one: last[one])
    return Measured("relevitation", f"{site}, {BACK:g} s after the power is back", 100.0 * last[site], "%")


def _overload(subject: Subject, Omega: float, inputs: Mapping[str, float]) -> tuple[Measured, dict[str, Array]]:
    """Return the acceleration of the base, over g, at which the rotor first touches anything."""
    count = round(MOST / OVERLOAD_STEP)
    events = [
        {"time": k * OVERLOAD_TIME, "set": {PLANT: {"base.a_y": GRAVITY * OVERLOAD_STEP * k}}} for k in range(1, count)
    ]
    used = clearance_used(subject, simulate(subject, Omega, inputs, end_time=count * OVERLOAD_TIME, event=events))
    touched = np.max(list(used.values()), axis=0) >= 1.0 - 1e-9
    if not touched.any():
        return Measured("overload", "nothing is touched", MOST, "1", {}, f"the run ends at {MOST:g} g"), used
    first = int(np.argmax(touched))
    share = first / len(touched)
    site = max(used, key=lambda one: float(used[one][first]))
    return Measured("overload", f"{site} is touched first", OVERLOAD_STEP * int(share * count), "1", {}, "in g"), used


def _over_time(title: str, used: Mapping[str, Array], duration: float) -> Panel:
    curves = tuple(curve(site, np.linspace(0.0, duration, len(of)), 100.0 * of) for site, of in used.items())
    return Panel(title, "time (s)", "%", curves)
