"""The expander, a machine unlike the rig of the packs, in its scenarios."""

import numpy as np
import pytest
from strange_machine import LEVITATION, RUB, TOUCHDOWN

import amb_cosim
from amb_cosim.results.places import places
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.scenario import Scenario
from tests.support.messages import raises_naming


def test_one_of_three_bearings_is_passive(levitation):
    bearings = places(levitation.signals).bearings
    assert bearings == {"north": "catch_n", "guide": "", "south": "catch_s"}
    system = amb_cosim.load_system(RUB.parent / "levitated_expander.toml")
    assert not [link for link in system.connections if link.target.startswith("rotor_contact.guide.")]


def test_expander_levitates_off_its_retainers_at_20_khz(levitation):
    assert levitation.outcome.status == "completed"
    assert levitation.summary.recovery == "prevented"
    assert np.allclose(np.diff(levitation.dataset["time"].values), 50e-6)


def test_gravity_leaves_the_weight_to_the_magnets(tmp_path):
    """Without stated static currents, the scenario has those that its file states for two bearings; guide has none.

    The guide is soft: shared as by three rigid bearings, the weight would leave the rotor hanging from it.
    """
    unstated = tmp_path / "gravity.toml"
    unstated.write_text(f'base = "{LEVITATION}"\nremove = ["amb_actuator.*static_current_?"]\n', encoding="utf-8")
    stated, found = (
        prepare_run(Scenario.load(path)).parameters["amb_actuator"] for path in (str(LEVITATION), str(unstated))
    )
    for bearing in ("north", "guide", "south"):
        name = f"{bearing}.static_current_y"
        assert found[name] == pytest.approx(stated[name], rel=0.01, abs=1e-9), name


@pytest.mark.parametrize(
    ("wrong", "facts"),
    [({"gravity_angle": "225 m"}, ("'225 m'", "rad")), ({"gravity": "9.81 m"}, ("'9.81 m'", "m/s2"))],
)
def test_gravity_is_refused_with_the_name_of_its_scenario(wrong, facts):
    scenario = Scenario.load(str(LEVITATION))
    with raises_naming(ValueError, f"scenario {scenario.name}: ", *facts):
        prepare_run(scenario.changed(**wrong))


def test_expander_falls_onto_both_retainers_and_stays(touchdown):
    assert touchdown.summary.recovery == "landed"
    assert set(touchdown.summary.touchdown.retainers) == {"catch_n", "catch_s"}


@pytest.mark.parametrize(("lost", "outcome"), [(("north", "south"), "landed"), (("north",), "trapped")])
def test_expander_without_power_in_both_magnets_has_landed(lost, outcome):
    off = {f"{magnet}.amplifier_off_?": True for magnet in lost}
    event = {"label": "step", "role": "disturbance", "cycle": 2, "set": {"amb_actuator": off}}
    result = amb_cosim.run(Scenario.load(TOUCHDOWN).changed(end_cycle=14, event=[event]))
    assert result.summary.recovery == outcome


def test_expander_rubs_hardest_at_a_site_without_bearing(rub):
    peaks = rub.summary.peak_contact_force
    assert peaks["labyrinth"] > 1.5 * peaks["catch_n"] > 0.0
    assert peaks["shroud"] > 0.0
    assert rub.summary.recovery == "recovered"


def test_figures_show_no_contact_at_the_bearing_without_retainer(touchdown):
    labels = [label.get_text() for axes in touchdown.plot.contact().axes for label in axes.get_yticklabels()]
    assert {"catch_n", "catch_s"} <= set(labels)
    assert not [label for label in labels if "GUIDE" in label]


def test_a_spin_that_hardly_changes_has_no_panel(touchdown):
    speeds = touchdown.signals["rotor_contact.speed"].values
    assert 0.0 < np.ptp(speeds) < 0.01 * speeds[0]
    assert "Spin speed" not in [axes.get_title(loc="left") for axes in touchdown.plot.displacement().axes]
