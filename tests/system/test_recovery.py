"""Recovery of the rotor of Fig. 5.6: which control frees it, and up to which unbalance."""

from itertools import pairwise

import pytest

from amb_cosim import studies
from bath_thesis.studies.recovery_trials import adapted_controls

pytestmark = pytest.mark.slow

ADDED = "12,20,32,60 g.m"
LABELS = [control.label for control in adapted_controls([3.5, 7.0])]
ROLAC = [label for label in LABELS if label.startswith("PID + ROLAC")]
AWARE = [label for label in LABELS if label.startswith("PID + contact-aware ROLAC")]


@pytest.fixture(scope="module")
def shares() -> dict[str, list[float]]:
    """Recovered share for each control and added unbalance, at a single phase of the step."""
    result = studies.recovery(ADDED, instants=1, progress=False)
    return {control: [cell.recovered_share for cell in cells] for control, cells in result.controls.items()}


@pytest.mark.parametrize("control", LABELS)
def test_the_more_unbalance_the_fewer_runs_recover(shares: dict[str, list[float]], control: str) -> None:
    assert all(more <= less for less, more in pairwise(shares[control]))
    assert (shares[control][0], shares[control][-1]) == (1.0, 0.0)


def test_each_adaptation_frees_the_rotor_from_more(shares: dict[str, list[float]]) -> None:
    """With both rates, and with H of the model and identified: ROLAC from 20 g m, contact-aware ROLAC from 32."""
    assert len(ROLAC) == len(AWARE) == 4
    assert shares["PID"] == [1.0, 0.0, 0.0, 0.0]
    assert [shares[control] for control in ROLAC] == [[1.0, 1.0, 0.0, 0.0]] * 4
    assert [shares[control] for control in AWARE] == [[1.0, 1.0, 1.0, 0.0]] * 4
    assert [control for control in LABELS if shares[control][2] == 1.0] == AWARE
