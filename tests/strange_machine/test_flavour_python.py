"""FMUs with Python inside: continued runs and branched points of the expander are plain runs."""

import pytest
from shared_past import assert_shared_past_changes_nothing
from strange_machine import RUB

import amb_cosim
from amb_cosim.scenario.scenario import Scenario

SHORT = Scenario.load(RUB).changed(end_cycle=6, settle_cycles=2)
SIZE = "step.rotor_contact.turbine.u"

pytestmark = pytest.mark.slow  # without compiled kernels it takes minutes


@pytest.fixture(scope="module")
def plain():
    run = amb_cosim.run(SHORT, flavour="python")
    assert run.outcome.status == "completed"
    assert max(run.signals["rotor_contact.shroud.f_n"].values) > 0.0, "it rubs"
    return run


def test_a_continued_run_is_the_whole_run(plain, tmp_path):
    file = amb_cosim.run(SHORT, flavour="python", save_at=["cycle 5"]).checkpoint().save(tmp_path / "rub.npz")
    result = amb_cosim.run(SHORT, flavour="python", start=file)
    for name, samples in plain.signals.variables.items():
        assert result.signals[name].values.tobytes() == samples.values.tobytes(), name
    assert result.outcome == plain.outcome


def test_points_that_share_a_past_lead_to_the_same_bits():
    assert_shared_past_changes_nothing(SHORT, SIZE, "python")
