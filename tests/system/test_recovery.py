"""Recovery of the rotor of Fig. 5.6: which control frees it, and up to which unbalance."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import Any

import pytest

from amb_cosim import studies
from bath_thesis.studies.recovery_trials import CONTROLS

pytestmark = pytest.mark.slow

ADDED = "8,24,48 g.m"


@pytest.fixture(scope="module")
def shares() -> dict[str, list[float]]:
    """Share recovered for each control and each unbalance added, one instant of the step."""
    result = studies.recovery(ADDED, instants=1, progress=False)
    return {control: [cell.recovered_share for cell in cells] for control, cells in result.controls.items()}


@pytest.mark.parametrize("control", CONTROLS)
def test_the_more_unbalance_the_fewer_runs_recover(shares: dict[str, list[float]], control: str) -> None:
    assert all(more <= less for less, more in pairwise(shares[control]))
    assert (shares[control][0], shares[control][-1]) == (1.0, 0.0)


@pytest.mark.parametrize(("better", "worse"), [("PID + ROLAC", "PID"), ("PID + contact-aware ROLAC", "PID + ROLAC")])
def test_adaptation_frees_no_fewer_runs(shares: dict[str, list[float]], better: str, worse: str) -> None:
    assert all(b >= w for b, w in zip(shares[better], shares[worse], strict=True))


def test_contact_aware_adaptation_alone_frees_the_rotor_from_24_g_m(shares: dict[str, list[float]]) -> None:
    assert [control for control in CONTROLS if shares[control][1] == 1.0] == ["PID + contact-aware ROLAC"]


def compared() -> dict[str, Any]:
    """Cycle of the last contact in the scenario and in the study; cycles from step to contact for three instants."""
    from amb_cosim.results.contact_history import contact_cycles
    from amb_cosim.scenario.plan_run import plan_run
    from amb_cosim.scenario.scenario import load_scenario
    from amb_cosim.scenario.simulation import run_planned
    from bath_thesis.studies.recovery_trials import RecoveryTrial, simulate_trial

    def last(added: float, cycle: float) -> float | None:
        return simulate_trial(RecoveryTrial("PID + ROLAC", added, cycle, 7.0)).last_contact_cycle

    return {
        "scenario": contact_cycles(run_planned(plan_run(load_scenario("fig5_6"))).dataset)[1],
        "study": last(20e-3, 5.0),
        "after": [last(16e-3, cycle) - cycle for cycle in (5.0, 5.4, 5.8)],
    }


@pytest.fixture(scope="module")
def comparison(run_once: Callable[..., Any]) -> dict[str, Any]:
    return run_once(compared, timeout=300)


def test_study_finds_what_the_scenario_finds(comparison: dict[str, Any]) -> None:
    assert comparison["study"] == comparison["scenario"] > 10.0


def test_first_touch_comes_as_long_after_the_step_whenever_that_is(comparison: dict[str, Any]) -> None:
    """The rig is the same in all directions; 0.4 cycles are a whole number of samples, and rounding decides on one."""
    assert comparison["after"] == pytest.approx([comparison["after"][0]] * 3, abs=1.01 / 250)
