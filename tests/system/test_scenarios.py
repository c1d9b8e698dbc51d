"""The thesis's simulations end as the thesis reports them."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import pytest


def figures_of(name: str) -> dict[str, Any]:
    """Summary of a scenario; runs in a process of its own."""
    from orchestrator.results import summary
    from orchestrator.scenario import load_scenario
    from orchestrator.simulation import prepare, run

    outcome = run(prepare(name, load_scenario(name)))
    assert outcome.failure is None, outcome.failure
    return summary(outcome.dataset)


@pytest.fixture(scope="module")
def figures(run_python: Callable[..., Any]) -> Callable[[str], dict[str, Any]]:
    return cache(lambda name: run_python(figures_of, name=name, timeout=300))


def test_unbalance_near_the_middle_rubs_at_the_motor_side_only(figures: Any) -> None:
    """Fig. 4.7: no contact before the step, then continuous rubbing at MB2."""
    f = figures("fig4_7")
    assert f["first_contact_cycle"] > 5.0
    assert f["orbit_before_mm"]["mb2"] < 0.75
    assert f["contact_share"]["1"] == f["contact_share"]["3"] == 0.0
    assert f["contact_share"]["2"] > 0.9
    assert f["peak_contact_force_N"]["rb1"] == 0.0


def test_sudden_unbalance_touches_both_bearings_and_the_rotor_recovers(figures: Any) -> None:
    """Fig. 4.9: MB1 first, then both, phases of all kinds; free once the unbalance has been removed at cycle 10."""
    f = figures("fig4_9")
    assert 5.0 < f["first_contact_cycle"] < 6.0
    assert all(f["contact_share"][state] > 0.0 for state in "0123")
    assert f["recovered"]
    assert f["last_contact_cycle"] > 10.0
    # "up to 6 kN at MB1, 2 kN at MB2": an independent monolithic prototype had 3.9 and 2.0 kN
    assert 3000.0 < f["peak_contact_force_N"]["rb1"] < 6000.0
    assert 1500.0 < f["peak_contact_force_N"]["rb2"] < 2500.0


def test_pid_alone_stays_trapped(figures: Any) -> None:
    """Fig. 5.6 with both unbalances times 1.25: under PID the rotor rubs to the end."""
    f = figures("fig5_6_pid")
    assert f["first_contact_cycle"] == pytest.approx(5.5, abs=0.1)
    assert f["last_contact_cycle"] == pytest.approx(40.0, abs=0.01)
    assert f["contact_share"]["3"] > 0.9
    assert not f["recovered"]


def test_rolac_recovers_the_rotor(figures: Any) -> None:
    """Fig. 5.6: with ROLAC the same unbalance touches on and off for about ten cycles at most, then never again."""
    f = figures("fig5_6")
    assert f["first_contact_cycle"] == pytest.approx(5.8, abs=0.1)
    assert f["last_contact_cycle"] < 16.0
    assert f["recovered"]
    assert f["orbit_before_mm"]["mb1"] < figures("fig5_6_pid")["orbit_before_mm"]["mb1"]
