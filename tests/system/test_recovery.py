"""Recovery of the rotor of Fig. 5.6: which control frees it, and up to which unbalance."""

from __future__ import annotations

from itertools import pairwise

import pytest

from amb_cosim import studies
from bath_thesis.studies.recovery_trials import CONTROLS

pytestmark = pytest.mark.slow

ADDED = "8,24,48 g.m"


@pytest.fixture(scope="module")
def shares() -> dict[str, list[float]]:
    """Recovered share for each control and added unbalance, at a single phase of the step."""
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
