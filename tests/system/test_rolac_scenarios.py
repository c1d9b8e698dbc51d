"""The thesis's runs with ROLAC (chapters 5 and 6) end as it reports, or the difference is stated.

Thesis, and the scenarios here: outcome, and the cycles of the first and of the last contact.

| | thesis | PID | PID + ROLAC |
| --- | --- | --- | --- |
| Fig. 5.5 | PID stays in contact, ROLAC prevents it | trapped from 5.8 | prevented |
| Fig. 5.6 | PID stays in contact, ROLAC: short contact, recovered | trapped from 5.5 | recovered, 5.8 to 14.5 |
| Fig. 6.13 | PID trapped, ROLAC recovers | trapped from 5.7 | recovered, 5.8 to 10.9 |
| Fig. 6.15 | ROLAC recovers after about two cycles | trapped from 5.1 | recovered, 5.1 to 5.9 |
| Fig. 6.18 | (force at the non-driven bearing) | trapped from 5.3, RB1 | recovered, 5.6 to 9.1 |
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from amb_cosim.results.series import speed
from amb_cosim.results.summary import summarise
from amb_cosim.scenario.plan_run import plan_run
from amb_cosim.scenario.scenario import load_scenario
from amb_cosim.scenario.simulation import run_planned

pytestmark = pytest.mark.gate

THESIS = json.loads((Path(__file__).parents[1] / "reference" / "thesis.json").read_text(encoding="utf-8"))
CLEARANCE_MM, BUSH_MM = 0.75, 0.9
DONE = 8  # identification_state
AWARE = {"rolac_controller.contact.aware": True}
OWN_SENSORS = {**AWARE, "rolac_controller.contact.source": 1}
GIVEN = {**AWARE, "rolac_controller.contact.source": 2}
PID = {"rolac_controller.rolac_enable": False}
D1 = {"rotor_contact.d1.u": "5 g.m", "rotor_contact.d2.u": 0, "rotor_contact.d3.u": 0}


@cache
def figures_of(name: str, settings: str, factor: float | None) -> dict[str, Any]:
    """Summary of a scenario, whose energy is accounted for, and outputs of its controller; settings as JSON."""
    scenario = load_scenario(name)
    if factor is not None:
        scenario = scenario.model_copy(update={"unbalance_factor": factor})
    result = run_planned(plan_run(scenario, json.loads(settings)))
    assert result.outcome.failure is None, result.outcome.failure
    assert result.summary.energy_balance < 1e-6
    d = result.dataset
    available = {v.removeprefix("rolac_controller."): d[v].values for v in d if v.startswith("rolac_controller.")}
    five = int(np.searchsorted(d["cycle"].values, 5.0)) - 1  # the last sample before step or ROLAC
    some = slice(None, None, max(1, len(d["time"]) // 2000))
    r = np.hypot(d["rotor_contact.mb1.x"].values, d["rotor_contact.mb1.y"].values)
    ends = [np.hypot(*(d[f"rotor_contact.{s}"].values for s in pair)) for pair in (("s7", "s8"), ("s1", "s2"))]
    return summarise(d).as_dict() | {
        "ends_mm": [1e3 * float(end.max()) for end in ends],
        "at_0": {v: float(x[0]) for v, x in available.items()},
        "at_5": {v: float(x[five]) for v, x in available.items()},
        "at_end": {v: float(x[-1]) for v, x in available.items()},
        "contact_speed_Hz": [
            float(np.interp(cycle, d["cycle"].values, speed(d)) / (2.0 * np.pi))
            for cycle in (summarise(d).as_dict()["first_contact_cycle"], summarise(d).as_dict()["last_contact_cycle"])
            if cycle is not None
        ],
        "trace": {"speed_Hz": (speed(d) / (2.0 * np.pi))[some].tolist(), "r_1": r[some].tolist()},
    }


@pytest.fixture
def figures() -> Callable[..., dict[str, Any]]:
    """`figures(name, settings={}, factor=None)`: results of a scenario, run once; both replace values of its file."""
    return lambda name, settings=None, factor=None: figures_of(name, json.dumps(settings or {}), factor)


def over_thesis(bearing: str, f: dict[str, Any], when: str) -> float:
    """Synchronous amplitude under PID over that which the thesis states for Fig. 5.5."""
    return f["settled_amplitude_mm"][when][bearing] / THESIS["fig_5_5"]["amplitude_mm"]["pid"][bearing]


@pytest.mark.slow
def test_rolac_prevents_contact_that_traps_the_rotor_under_pid(figures: Any, regression: Any) -> None:
    """Fig. 5.5 with both unbalances times 1.44."""
    pid, rolac = figures("fig5_5_pid"), figures("fig5_5")
    assert (pid["recovery"], rolac["recovery"]) == ("trapped", "prevented")
    regression("first contact under PID (cycle)", pid["first_contact_cycle"], abs=0.03)
    assert rolac["orbit_largest_mm"]["mb1"] < CLEARANCE_MM
    for mb in ("mb1", "mb2"):
        assert rolac["settled_amplitude_mm"]["before"][mb] < 0.75 * pid["settled_amplitude_mm"]["before"][mb]
        assert rolac["settled_amplitude_mm"]["end"][mb] < 0.6 * CLEARANCE_MM
        # The amplitudes that the thesis states, 0.220 and 0.250 mm, are a third larger.
        assert over_thesis(mb, pid, "before") == pytest.approx(1.44 / 1.9, abs=0.03)


@pytest.mark.slow
def test_unbalance_of_fig_5_5_as_stated_reaches_no_retainer(figures: Any, regression: Any) -> None:
    """5 and 18.5 g m under PID: half the stated amplitude before the step, two thirds of the clearance after it."""
    f = figures("fig5_5_pid", factor=1.0)
    assert f["recovery"] == "prevented"
    over = [over_thesis(mb, f, "before") for mb in ("mb1", "mb2")]
    regression("amplitude before the step over that of the thesis", over, abs=0.01)
    regression("amplitude at MB2 over the clearance", f["settled_amplitude_mm"]["end"]["mb2"] / CLEARANCE_MM, abs=0.01)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("factor", "pid", "rolac"),
    [
        (1.40, "recovered", "prevented"),
        (1.42, "trapped", "prevented"),
        (1.46, "trapped", "prevented"),
        (1.48, "trapped", "recovered"),
    ],
)
def test_fig_5_5_is_as_reported_within_a_range_of_factors(figures: Any, factor: float, pid: str, rolac: str) -> None:
    assert figures("fig5_5_pid", factor=factor)["recovery"] == pid
    assert figures("fig5_5", factor=factor)["recovery"] == rolac


@pytest.mark.slow
def test_with_the_amplitudes_of_fig_5_5_rolac_must_know_of_contact(figures: Any) -> None:
    """Both unbalances times 1.9: the thesis's 0.220 and 0.250 mm before the step, and a rotor that ROLAC does not free.

    Adaptation that counts with contact does, whether it sees contact by its sensors or is told by the plant.
    """
    pid = figures("fig5_5_matched", PID)
    assert over_thesis("mb1", pid, "before") == pytest.approx(1.0, abs=0.025)
    assert over_thesis("mb2", pid, "before") == pytest.approx(1.0, abs=0.025)
    assert pid["recovery"] == figures("fig5_5_matched")["recovery"] == "trapped"
    for aware in (OWN_SENSORS, GIVEN):
        f = figures("fig5_5_matched", aware)
        assert f["recovery"] == "recovered"
        assert f["last_contact_cycle"] < 10.0


@pytest.mark.slow
def test_pid_alone_stays_trapped(figures: Any, regression: Any) -> None:
    """Fig. 5.6 with both unbalances times 1.25: under PID the rotor rubs to the end."""
    f = figures("fig5_6_pid")
    regression("first contact (cycle)", f["first_contact_cycle"], abs=0.1)
    assert f["last_contact_cycle"] == pytest.approx(40.0, abs=0.01)
    assert f["contact_share"]["3"] > 0.9
    assert f["recovery"] == "trapped"


def test_rolac_recovers_the_rotor(figures: Any, regression: Any) -> None:
    """Fig. 5.6: with ROLAC the same unbalance touches on and off for about ten cycles at most, then never again."""
    f = figures("fig5_6")
    regression("first contact (cycle)", f["first_contact_cycle"], abs=0.1)
    assert f["last_contact_cycle"] < 16.0
    assert f["recovery"] == "recovered"
    assert f["orbit_before_mm"]["mb1"] < figures("fig5_6_pid")["orbit_before_mm"]["mb1"]


def components(at: dict[str, float], name: str) -> np.ndarray:
    """Complex amplitudes of the eight sensors, or of the forces of the four axes."""
    if name == "force":
        ends = [(f"{mb}.u_{a}", f"{mb}.u_phase_{a}") for mb in ("mb1", "mb2") for a in "xy"]
    else:
        ends = [(f"amplitude.s{k}", f"phase.s{k}") for k in range(1, 9)]
    return np.array([at[size] * np.exp(1j * at[phase]) for size, phase in ends])


def receptance(at: dict[str, float]) -> np.ndarray:
    """R as identified, shape (8, 4) (m/N)."""
    axes = [f"{mb}_{a}" for mb in ("mb1", "mb2") for a in "xy"]
    return np.array([[at[f"r.s{k}.{a}.re"] + 1j * at[f"r.s{k}.{a}.im"] for a in axes] for k in range(1, 9)])


SWITCHED_ON = {"fig6_6": 10.0, "fig6_8": 16.0, "fig6_10": 35.0}  # Hz


@pytest.mark.slow
@pytest.mark.parametrize("name", SWITCHED_ON)
def test_rolac_reaches_the_optimum_of_the_identified_receptance(figures: Any, regression: Any, name: str) -> None:
    """Figs 6.6, 6.8, 6.10: the eight synchronous amplitudes fall to the least-squares optimum min |Q_0 + R U|.

    The root of their sum of squares falls to less than a quarter at 10, 16 and 35 Hz.
    """
    f = figures(name)
    assert f["recovery"] is None
    assert f["first_contact_cycle"] is None
    assert (f["at_0"]["identification_state"], f["at_0"]["identification_error"]) == (DONE, 0.0)
    assert f["at_0"]["identification_speed"] == pytest.approx(2.0 * math.pi * SWITCHED_ON[name], rel=1e-9)
    q_0, q = components(f["at_5"], "displacement"), components(f["at_end"], "displacement")
    R, u = receptance(f["at_end"]), components(f["at_end"], "force")
    optimum = q_0 - R @ np.linalg.lstsq(R, q_0, rcond=None)[0]
    assert np.linalg.norm(components(f["at_5"], "force")) == 0.0
    assert np.linalg.norm(q) == pytest.approx(np.linalg.norm(optimum), rel=0.06)  # with noise, and a twentieth left
    assert np.linalg.norm(q) < 0.25 * np.linalg.norm(q_0)
    regression("amplitudes over those before", float(np.linalg.norm(q) / np.linalg.norm(q_0)), abs=0.01)
    assert np.linalg.norm(q_0 + R @ u - q) < 0.03 * np.linalg.norm(q_0)


MEASURED_MM = {"fig6_8": {"mb1": 0.20}, "fig6_10": {"mb1": 0.37, "mb2": 0.35}}  # under PID, Figs 6.8 and 6.10


@pytest.mark.slow
def test_rolac_reduces_the_vibration_at_both_bearings_of_the_rig(figures: Any, regression: Any) -> None:
    """Figs 6.6 to 6.12: under PID as measured, to which the unbalance was fitted; what ROLAC leaves was not fitted.

    At 35 Hz the thesis has 0.05 to 0.065 mm left. With 5 g m on D1 in place of the fit MB1 grows there.
    """
    amplitude = {name: figures(name)["settled_amplitude_mm"] for name in SWITCHED_ON}
    for name in SWITCHED_ON:
        assert all(amplitude[name]["end"][mb] < 0.4 * amplitude[name]["before"][mb] for mb in ("mb1", "mb2"))
    for name, measured in MEASURED_MM.items():
        for mb, value in measured.items():
            assert amplitude[name]["before"][mb] == pytest.approx(value, rel=0.2)
    assert all(0.02 < amplitude["fig6_10"]["end"][mb] < 0.08 for mb in ("mb1", "mb2"))
    regression("amplitude at 35 Hz (mm)", amplitude["fig6_10"]["end"], abs=0.003)
    one_disc = figures("fig6_10", D1)["settled_amplitude_mm"]
    assert one_disc["end"]["mb1"] > 1.1 * one_disc["before"]["mb1"]


@pytest.mark.slow
@pytest.mark.parametrize("name", ["fig6_13", "fig6_15", "fig6_18"])
def test_rolac_frees_the_rig_where_pid_leaves_it_trapped(figures: Any, regression: Any, name: str) -> None:
    """Figs 6.13, 6.15, 6.18. With forces in phase Fig. 6.15 takes 0.7 cycles where the thesis has about two."""
    pid, rolac = figures(f"{name}_pid"), figures(name)
    assert (pid["recovery"], rolac["recovery"]) == ("trapped", "recovered")
    assert pid["first_contact_cycle"] < 5.8
    assert pid["contact_share"]["0"] < 0.1
    assert rolac["at_0"]["identification_state"] == DONE
    assert rolac["last_contact_cycle"] < 12.0
    regression("first contact (cycle)", rolac["first_contact_cycle"], abs=0.1)
    regression("last contact (cycle)", rolac["last_contact_cycle"], abs=0.5)
    before, end = (rolac["settled_amplitude_mm"][when] for when in ("before", "end"))
    for mb in ("mb1", "mb2"):
        assert end[mb] < 0.12 * CLEARANCE_MM
        # Forces at the bearings are what ROLAC can cancel: what is left is as before the step.
        assert end[mb] == pytest.approx(before[mb], abs=0.04)


@pytest.mark.slow
def test_force_at_the_non_driven_bearing_rubs_there_alone(figures: Any) -> None:
    """Fig. 6.18."""
    f = figures("fig6_18_pid")
    assert f["contact_share"]["1"] > 0.95
    assert f["contact_share"]["2"] == f["contact_share"]["3"] == 0.0


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "angle"),
    [("fig6_13", 90), ("fig6_15", 90), ("fig6_15", 180)],
)
def test_other_angles_between_the_forces_are_recovered_from_too(
    figures: Any, regression: Any, name: str, angle: float
) -> None:
    f = figures(name, {"rotor_contact.mb2.phi": math.radians(angle)})
    assert f["recovery"] == "recovered"
    regression("last contact (cycle)", f["last_contact_cycle"], abs=2.0)


@pytest.mark.slow
def test_opposed_forces_at_16_hz_trap_the_rig_without_contact_aware_rolac(figures: Any) -> None:
    """Fig. 6.13 in opposition, which is not as the thesis reports it."""
    assert figures("fig6_13_opposed")["recovery"] == "trapped"
    assert figures("fig6_13_opposed", PID)["recovery"] == "trapped"
    assert figures("fig6_13_opposed", OWN_SENSORS)["recovery"] == "recovered"


FORCES_N = {
    "fig6_13": {"mb1.u": 544.0, "mb2.u": 544.0},
    "fig6_15": {"mb1.u": 800.6, "mb2.u": 800.6},
    "fig6_18": {"mb1.u": 650.0},
}


@pytest.mark.parametrize("name", FORCES_N)
def test_unbalances_at_the_bearings_are_the_forces_of_the_thesis(name: str) -> None:
    from amb_cosim.cosim.system.values import quantity
    from amb_cosim.scenario.scenario import load_scenario

    scenario = load_scenario(name)
    (step,) = scenario.event
    forces = {
        variable: quantity(value, "kg.m", variable) * scenario.initial_speed**2
        for variable, value in step.set["rotor_contact"].items()
    }
    assert forces == pytest.approx(FORCES_N[name], rel=1e-3)


@pytest.mark.slow
def test_run_up_with_rolac_passes_both_critical_speeds_without_contact(figures: Any, regression: Any) -> None:
    """Sensors at the ends weigh 0.3, and stay within the bushes there; with equal weights MB1 touches at 26 Hz."""
    pid, rolac = figures("run_up"), figures("run_up_rolac")

    def at(f: dict[str, Any], hertz: float) -> float:
        speeds, radii = f["trace"]["speed_Hz"], f["trace"]["r_1"]
        crossing = next(i for i, (a, b) in enumerate(pairwise(speeds)) if (a - hertz) * (b - hertz) <= 0.0)
        return 1e3 * radii[crossing] / CLEARANCE_MM

    assert pid["contact_speed_Hz"]
    regression("speed of contact under PID (Hz)", pid["contact_speed_Hz"], abs=0.1)
    assert rolac["contact_speed_Hz"] == []
    assert at(pid, 12.5) > 0.65
    assert at(rolac, 12.5) < 0.2
    regression("largest orbit over the clearance", rolac["orbit_largest_mm"]["mb1"] / CLEARANCE_MM, abs=0.03)
    regression("largest displacement of the ends (mm)", rolac["ends_mm"], abs=0.03)
    assert max(rolac["ends_mm"]) < BUSH_MM
    equal = figures("run_up_rolac", {"rolac_controller.s?.weight": 1.0})
    regression("speed of contact with equal weights (Hz)", equal["contact_speed_Hz"][0], abs=0.1)
    assert not equal["recovered"]
