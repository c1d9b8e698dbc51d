"""Robustness of outcomes: the parameters of a machine that are varied, and the verdict."""

from itertools import pairwise

import numpy as np
import pytest
from scipy import stats

from amb_cosim import studies
from amb_cosim.model_constants.receptance_file import ReceptanceTable
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.scenario import load_scenario
from amb_sweeps.contact_variations import Tolerances, contact_variations
from amb_sweeps.event_phases import undetected_share, with_labels
from amb_sweeps.robustness import Robustness, RobustnessRow
from amb_sweeps.stored_robustness import StoredOutcome
from amb_sweeps.variations import identification_speeds, variations
from tests.support.messages import assert_names, raises_naming

TABLE = ReceptanceTable("rig", (), (), {})
TOLERANCES = Tolerances(0.01)


def as_data(event):
    return event.model_dump(mode="json", exclude_none=True)


def row(changed, outcome):
    return RobustnessRow(changed, outcome, "", None, {}, {})


def variations_of(scenario, **settings):
    """The variations of a scenario by 1 %, with a table that nobody reads."""
    prepared = prepare_run(load_scenario(scenario), settings)
    return prepared, variations(prepared, settings, 0.01, lambda: TABLE)


def test_verdict_names_the_changes_that_flip_the_outcome():
    rows = (row("as it is", "recovered"), row("K_b + 1 %", "recovered"), row("K_b - 1 %", "trapped"))
    fragile, robust = (Robustness("mine", 0.01, some, {}) for some in (rows, rows[:2]))
    assert (robust.verdict, robust.flips) == ("robust", {})
    assert (fragile.verdict, fragile.flips) == ("fragile", {"K_b - 1 %": "trapped"})
    assert "fragile: K_b - 1 %: trapped" in str(fragile)
    assert "robust: every run is recovered" in str(robust)


def test_verdict_needs_decided_outcomes():
    """A run that ends too early for an outcome flips none, and leaves the others in doubt."""
    base, late, other = row("as it is", "recovered"), row("K_b + 1 %", "undecided, touching rb1"), row("H", "trapped")
    doubtful, fragile = (Robustness("mine", 0.01, some, {}) for some in ((base, late), (base, late, other)))
    assert (doubtful.verdict, doubtful.flips) == ("undecided", {})
    assert_names(str(doubtful), "undecided", "K_b + 1 %")
    assert (fragile.verdict, fragile.flips) == ("fragile", {"H": "trapped"})
    short = Robustness("mine", 0.01, (row("as it is", "undecided"), other), {})
    assert (short.verdict, short.flips) == ("undecided", {})
    assert StoredOutcome(outcome=short.outcome).verdict == "undecided"


def test_an_outcome_is_not_robust_while_what_decides_a_contact_was_not_varied():
    rows, reason = (row("as it is", "landed"), row("K_b + 1 %", "landed")), "the parameter is zero everywhere"
    result = Robustness("mine", 0.01, rows, {"alpha": "off", "friction": reason})
    assert (result.verdict, result.untested) == ("robust in part", ["friction"])
    assert "robust: " not in str(result)
    assert_names(str(result), "friction", "not varied")
    assert StoredOutcome(outcome="landed", untested=["friction"]).verdict == "robust in part"
    assert Robustness("mine", 0.01, rows, {"alpha": "off"}).verdict == "robust"


def contact_of(scenario, tolerances=TOLERANCES):
    prepared = prepare_run(with_labels(scenario))
    found = contact_variations(prepared, tolerances)
    return prepared, {item.name: item.settings for item in found.made}, found


def test_a_landing_varies_friction_restitution_and_the_phase_of_the_power_loss():
    """Friction of 0.12 by 20 %, restitution of 0 by 0.1, and the power loss by eighths of a turn."""
    prepared, settings, found = contact_of(load_scenario("drop"), Tolerances(0.01, phases=8))
    assert settings["friction + 20 %"]["rotor_contact.rb1.mu"] == pytest.approx(0.144)
    assert settings["friction - 20 %"]["rotor_contact.stator_mb1.mu"] == pytest.approx(0.24)
    assert settings["restitution + 0.1"]["rotor_contact.rb1.restitution"] == pytest.approx(0.1)
    assert settings["restitution - 0.1"]["rotor_contact.rb1.restitution"] == 0.0, "restitution is not negative"
    moments = [values["power_loss.time"] for values in settings.values() if "power_loss.time" in values]
    assert moments == pytest.approx(np.arange(1, 8) / 8.0 * 2.0 * np.pi / prepared.speed)
    assert not found.left_out
    assert found.extents["phase"].startswith("8 phases")


def test_the_phase_is_that_of_the_speed_at_which_the_power_is_lost_and_later_events_follow():
    """In relevitation the power returns; in a run-up to twice the speed, half a turn takes half as long."""
    relevitation = load_scenario("relevitation")
    prepared, settings, _ = contact_of(relevitation, Tolerances(0.01, phases=2))
    (delayed,) = [values for values in settings.values() if "power_loss.time" in values]
    moments = {event.name: event.moment(prepared.period) for event in prepared.scenario.event}
    shifts = {
        label.removesuffix(".time"): time - moments[label.removesuffix(".time")] for label, time in delayed.items()
    }
    assert len(shifts) > 1
    assert list(shifts.values()) == pytest.approx([np.pi / prepared.speed] * len(shifts))
    drop = load_scenario("drop")
    fast = drop.changed(
        Omega=100.0, speed=[{"time": 0.1, "Omega": 200.0}], event=[{**as_data(drop.event[0]), "time": 0.2}]
    )
    (delayed,) = [v for v in contact_of(fast, Tolerances(0.01, phases=2))[1].values() if "power_loss.time" in v]
    assert delayed["power_loss.time"] - 0.2 == pytest.approx(np.pi / 200.0)


def test_an_event_without_a_name_is_delayed_too():
    drop = load_scenario("drop")
    unnamed = {**as_data(drop.event[0]), "label": None, "role": None}
    settings = contact_of(drop.changed(event=[unnamed]), Tolerances(0.01, phases=4))[1]
    assert sum(any(name.endswith(".time") for name in values) for values in settings.values()) == 3


def test_what_a_contact_does_not_use_is_named():
    """A compliant contact has no restitution, and a step of unbalance turns with the rotor."""
    compliant = load_scenario("fig4_9").changed(parameters={"rotor_contact": {"*.law": "hunt_crossley"}})
    _, settings, found = contact_of(compliant)
    assert set(found.left_out) == {"restitution"}
    assert "contact stiffness + 1 %" in settings
    assert not any(name.endswith(".time") for values in settings.values() for name in values)
    assert settings["friction + 0.01"]["rotor_contact.rb1.mu"] == 0.01, "without friction, it changes by an amount"
    rows = (row("as it is", "recovered"), row("K_b + 1 %", "recovered"))
    assert Robustness("mine", 0.01, rows, dict(found.left_out)).verdict == "robust", "restitution has no effect here"
    unchanged = contact_of(load_scenario("drop"), Tolerances(0.01, friction=0.0, restitution=0.0, phases=1))[2]
    assert set(unchanged.left_out) == {"friction", "restitution", "phase"}
    assert Robustness("mine", 0.01, rows, dict(unchanged.left_out)).untested == ["friction", "restitution", "phase"]


def test_share_of_phases_that_a_number_of_equal_outcomes_leaves_open():
    """The rule of three, 3/n, and the exact bound of scipy."""
    for n in (8, 32):
        exact = stats.binomtest(0, n).proportion_ci(0.9).high  # one-sided 95 %
        assert undetected_share(n) == pytest.approx(exact)
    assert undetected_share(300) == pytest.approx(0.01, rel=0.01)


@pytest.mark.slow
def test_a_landing_that_whirls_only_at_some_phases_is_fragile():
    """With friction of 0.36, above the limit of 0.237 at which a falling rotor climbs over the top."""
    result = studies.robustness("drop", set={"rotor_contact.*.mu": 0.36}, phases=8, progress=False)
    assert result.verdict == "fragile"


def test_machine_without_controller_varies_its_passive_bearings():
    """A rotor in springs and dampers has K_b and C_b in the plant; what it does not have is named."""
    prepared, result = variations_of("nelson_mcvaugh_rub")
    values = prepared.all_parameters()["rotor_contact"]
    settings = {item.name: item.settings for item in result.made}
    stiffer = settings["K_b + 1 %"]
    assert set(stiffer) == {"rotor_contact.b1.k_b", "rotor_contact.b2.k_b"}
    assert stiffer["rotor_contact.b1.k_b"] == pytest.approx(1.01 * values["b1.k_b"])
    assert settings["clearance - 1 %"] == {"rotor_contact.rim.clearance": pytest.approx(0.99 * values["rim.clearance"])}
    assert settings["unbalance + 1 %"] == {"unbalance_factor": pytest.approx(1.01)}
    assert dict(result.left_out) == dict.fromkeys(("identified H", "alpha"), "the synchronous control is off")


def test_unbalance_set_by_the_user_is_varied():
    _, result = variations_of("nelson_mcvaugh_rub", **{"rotor_contact.disc.u": "1 g.m"})
    settings = {item.name: item.settings for item in result.made}
    assert settings["unbalance - 1 %"]["rotor_contact.disc.u"] == pytest.approx(0.99e-3)


def test_direct_gains_are_varied_if_the_controller_uses_them():
    _, result = variations_of("compressor_levitated", **{"rolac_controller.pid.direct": True})
    names = {item.name for item in result.made}
    assert {"k_p + 1 %", "k_d - 1 %"} <= names
    assert not {"K_b + 1 %", "C_b - 1 %"} & names


def test_h_is_identified_if_the_run_uses_a_table_that_it_does_not_make():
    with_h, without = (
        {item.name: item.settings for item in variations_of(scenario)[1].made} for scenario in ("fig5_6", "fig5_6_pid")
    )
    assert with_h["identified H"] == {"receptances": TABLE}, "the table itself, not a file of it"
    assert "alpha + 1 %" in with_h
    assert not {"identified H", "alpha + 1 %"} & without.keys()
    assert variations_of("fig6_13")[1].left_out["identified H"] == "the run identifies H itself"


def test_h_of_a_run_up_is_identified_every_hertz_of_it():
    prepared, _ = variations_of("run_up_rolac")
    speeds = identification_speeds(prepared)
    assert speeds[-1] == pytest.approx(max(speed for _, speed in prepared.profile))
    assert max(b - a for a, b in pairwise(speeds)) < 7.0
    assert len(identification_speeds(variations_of("fig5_6")[0])) == 1


@pytest.mark.slow
def test_outcome_that_larger_changes_flip_is_fragile():
    """The rotor of Fig. 5.6 tolerates H of its sampled loop, but no 10 % more unbalance or less clearance."""
    result = studies.robustness("fig5_6", change=0.1, progress=False)
    rows = {row.changed: row for row in result.rows}
    assert result.outcome == "recovered, touching rb1 rb2"
    trapping = {name for name, outcome in result.flips.items() if outcome.startswith("trapped")}
    assert trapping == {"clearance - 10 %", "unbalance + 10 %"}
    assert {result.flips[name] for name in result.flips.keys() - trapping} == {"recovered, touching rb1"}
    for trapped in trapping:
        assert rows[trapped].last_contact == pytest.approx(40.0, abs=0.1)
        assert min(rows[trapped].contact_force.values()) > 1500.0
    forces, others = (list(rows[name].contact_force.values()) for name in ("as it is", "identified H"))
    assert others == pytest.approx(forces, rel=0.15)
    assert others != forces


def test_scenario_that_does_not_reach_its_end_is_refused():
    with raises_naming(ValueError, "change", "2", "1e-6", "0.5"):
        studies.robustness("nelson_mcvaugh_rub", change=2)
