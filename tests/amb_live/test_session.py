"""Sessions of the live rig: changes, refusals, rewinding, saved scenarios and links."""

import numpy as np
import pytest

import amb_cosim

X, Y, CONTACT, UNBALANCE = (
    "rotor_contact.mb1.x",
    "rotor_contact.mb1.y",
    "rotor_contact.contact_state",
    "rotor_contact.d1.u",
)
pytestmark = pytest.mark.slow  # the engine is compiled as WebAssembly first

WATCHED = [X, Y, CONTACT, UNBALANCE, "Omega", "rolac_controller.mb1.c_b_x"]
CLEARANCE = 0.75e-3  # m


def run(to):
    return {"type": "run", "to": to}


def test_bad_values_are_refused_with_the_message_of_the_fmu(session):
    answers = session(
        "fig5_6",
        WATCHED,
        {"type": "speed", "speed": 200000, "acceleration": 10},
        {"type": "set", "values": {UNBALANCE: -1}},
        {"type": "set", "values": {"rolac_controller.mb1.c_b_x": -5}},
        {"type": "set", "values": {"rotor_contact.rb1.mu": 0.2}},
        {"type": "push", "disc": "d9", "force": [1, 0]},
        {"type": "reset", "settings": {"values": {"rotor_contact.rb1.clearance": -1}}},
        {"type": "reset", "settings": {"values": {"rotor_contact.nonsense": 1}}},
    )
    said = [refused["text"] for refused in answers.of("refused")]
    assert len(said) == 7
    assert "Omega = 200000 rad/s is not allowed; it must be >= -100000 and <= 100000 rad/s" in said[0]
    assert "d1.u = -1 kg.m is not allowed; it must be >= 0 kg.m" in said[1]
    assert "mb1.c_b_x = -5 N.s/m is not allowed; it must be >= 0 N.s/m" in said[2]
    assert "rotor_contact.rb1.mu cannot be set during a run" in said[3]
    assert "rotor_contact.d9.f_x cannot be set" in said[4]
    assert "rb1.clearance = -1 m is not allowed; it must be >= 1e-06 and <= 0.1 m" in said[5]
    assert "there is no parameter and no free input rotor_contact.nonsense" in said[6]
    assert answers.of("userChanges")[-1]["userChanges"] == {"settings": {}, "changes": []}


def test_a_refused_value_leaves_no_trace(session):
    bad = {"type": "set", "values": {UNBALANCE: -1}}
    plain = session("fig4_9", WATCHED, run(0.2))
    tried = session("fig4_9", WATCHED, run(0.05), bad, run(0.15), bad, bad, run(0.2))
    assert len(tried.of("refused")) == 3
    np.testing.assert_array_equal(tried.rows, plain.rows)


def test_rewinding_repeats_a_run_through_contact(session):
    plain = session("fig4_9", WATCHED, run(0.3))
    rewound = session("fig4_9", WATCHED, run(0.3), {"type": "rewind", "time": 0.1237}, run(0.3))
    assert plain.column(CONTACT)[: round(0.1237 * 4000)].max() == 0
    assert plain.column(CONTACT).max() > 0
    np.testing.assert_array_equal(rewound.rows, plain.rows)


def test_rewinding_discards_or_keeps_later_changes(session):
    heavier = {"type": "set", "values": {UNBALANCE: 0.002}}
    back = {"type": "rewind", "time": 0.02}
    once = session("fig4_9", WATCHED, run(0.05), heavier, run(0.1))
    forgotten = session("fig4_9", WATCHED, run(0.05), heavier, run(0.1), back, run(0.1))
    retained = session("fig4_9", WATCHED, run(0.05), heavier, run(0.1), back | {"keep": True}, run(0.1))
    assert (once.column(UNBALANCE)[-1], forgotten.column(UNBALANCE)[-1]) == (0.002, 0.0005)
    np.testing.assert_array_equal(retained.rows, once.rows)


def test_a_change_takes_effect_where_it_is_made_and_is_recorded(session):
    answers = session("fig4_9", WATCHED, run(0.05), {"type": "set", "values": {UNBALANCE: 0.002}}, run(0.06))
    assert answers.of("userChanges")[-1]["userChanges"]["changes"] == [
        {"point": 200, "time": 0.05, "values": {UNBALANCE: 0.002}}
    ]
    assert list(answers.rows[199:202, 0]) == pytest.approx([0.04975, 0.05, 0.05025])
    assert list(answers.column(UNBALANCE)[199:202]) == [0.0005, 0.002, 0.002]


def test_the_speed_changes_to_its_target_at_the_chosen_rate(session):
    faster = {"type": "speed", "speed": 115.0, "acceleration": 50.0}
    answers = session("fig5_6", WATCHED, run(0.1), faster, run(0.5))
    speed, rise = answers.column("Omega"), np.diff(answers.column("Omega")) * 4000.0
    assert speed[-1] == 115.0
    turning = rise != 0.0
    assert rise[turning] == pytest.approx(50.0, rel=2e-3)
    assert np.count_nonzero(turning) == round((115.0 - speed[0]) / 50.0 * 4000.0)


def test_a_new_target_speed_takes_effect_after_the_current_piece(session, tmp_path):
    up, down = ({"type": "speed", "speed": speed, "acceleration": 50.0} for speed in (130.0, 90.0))
    save = {"type": "save", "name": "mine"}
    answers = session("fig5_6", WATCHED, run(0.1), up, run(0.25), up, down, down, run(0.6), save)
    speed = answers.column("Omega")
    turn = int(np.argmax(speed))
    assert answers.rows[turn, 0] == pytest.approx(0.3, abs=5e-4)  # pieces of 0.1 s from 0.1 s on
    assert (np.diff(speed)[turn:] <= 0.0).all()
    file = tmp_path / "mine.toml"
    file.write_text(answers.of("saved")[0]["toml"], encoding="utf-8")
    np.testing.assert_array_equal(amb_cosim.run(file, progress=False).dataset["Omega"][: len(speed)], speed)


def test_a_speed_profile_of_the_scenario_cannot_be_changed(session):
    faster = {"type": "speed", "speed": 400.0, "acceleration": 50.0}
    answers = session("run_up", ["Omega"], run(0.01), faster, {"type": "set", "values": {"Omega": 300.0}}, run(0.02))
    plain = session("run_up", ["Omega"], run(0.02))
    said = [refused["text"] for refused in answers.of("refused")]
    assert "Omega follows the scenario's points until t = " in said[0]
    assert "Omega cannot jump" in said[1]
    np.testing.assert_array_equal(answers.rows, plain.rows)


def test_rotor_whose_power_the_user_switches_off_lands_on_the_stator(session):
    """Without retainers it lies in the bores at the air gap of 1.2 mm, in a scenario that keeps the power on."""
    reset = {"type": "reset", "settings": {"values": {f"rotor_contact.rb{k}.enabled": 0 for k in (1, 2)}}}
    dark = {f"amb_actuator.mb{k}.amplifier_off_{axis}": 1 for k in (1, 2) for axis in "xy"}
    answers = session("fig5_6", WATCHED, reset, run(0.01), {"type": "set", "values": dark}, run(0.2))
    assert not answers.of("failed")
    distance = np.hypot(answers.column(X), answers.column(Y))
    assert distance.max() == pytest.approx(1.2e-3, rel=5e-3)


def test_a_failed_step_reports_its_cause_and_can_be_rewound(session):
    free = {"rotor_contact.rb1.enabled": 0, "rotor_contact.rb2.enabled": 0}
    answers = session(
        "fig5_6",
        WATCHED,
        {"type": "reset", "settings": {"values": free}},
        run(0.01),
        {"type": "push", "disc": "d1", "force": [2e5, 0]},
        run(1.0),
        run(1.1),
        {"type": "rewind", "time": 0.01},
        run(0.02),
    )
    (failed,) = answers.of("failed")
    assert failed["component"] == "amb_actuator"
    assert "the rotor must stay within the air gap, |mb1.x| < 0.0012 m" in failed["text"]
    assert "the run has failed" in answers.of("refused")[0]["text"]
    assert answers.of("ended")[-1]["time"] == pytest.approx(0.02)


def test_a_saved_scenario_repeats_the_run_of_the_session(session, tmp_path):
    requests = (
        run(0.1),
        {"type": "set", "values": {UNBALANCE: 0.04, "rolac_controller.rolac_enable": 0}},
        run(0.2),
        {"type": "push", "disc": "d2", "force": [300.0, -200.0]},
        run(0.21),
        {"type": "push", "disc": "d2", "force": [0.0, 0.0]},
        {"type": "set", "values": {"rolac_controller.mb1.c_b_x": 7000.0}},
        run(0.3),
        {"type": "speed", "speed": 110.0, "acceleration": 60.0},
        {"type": "set", "values": {"rolac_controller.rolac_enable": 1}},
        run(0.7),
        {"type": "save", "name": "mine"},
    )
    values = {"rotor_contact.rb1.clearance": 0.6e-3, "rotor_contact.rb2.mu": 0.05, "Omega": 95.0}
    answers = session("fig5_6", WATCHED, {"type": "reset", "settings": {"values": values}}, *requests)
    file = tmp_path / "mine.toml"
    file.write_text(answers.of("saved")[0]["toml"], encoding="utf-8")
    dataset = amb_cosim.run(file, progress=False).dataset
    np.testing.assert_array_equal(answers.rows[:, 0], dataset["time"])
    for name in (CONTACT, "Omega"):
        np.testing.assert_array_equal(answers.column(name), dataset[name])
    assert answers.column(CONTACT).max() == 3
    for name in (X, Y):
        assert np.abs(answers.column(name) - dataset[name].values).max() < 1e-6 * CLEARANCE


@pytest.mark.parametrize("name", ["fig4_9", "run_up", "drop"])
def test_a_scenario_saved_without_changes_is_the_same(name, session, tmp_path):
    answers = session(name, [X], run(0.02), {"type": "save", "name": "same"})
    file = tmp_path / "same.toml"
    file.write_text(answers.of("saved")[0]["toml"], encoding="utf-8")
    scenario = amb_cosim.Scenario.load(name).changed(settling="simulated")
    ours, theirs = (amb_cosim.run(item, until=0.02, progress=False).dataset for item in (file, scenario))
    every = scenario.record.every
    for signal in (X, Y, "rotor_contact.theta"):
        np.testing.assert_array_equal(ours[signal][::every], theirs[signal])


def test_repeated_changes_give_the_same_run(session):
    requests = (
        run(0.05),
        {"type": "set", "values": {UNBALANCE: 0.01}},
        {"type": "speed", "speed": 250, "acceleration": 100},
    )
    first = session("fig4_9", WATCHED, *requests, run(0.3))
    changes = first.of("userChanges")[-1]["userChanges"]
    again = session("fig4_9", WATCHED, run(0.3), userChanges=changes)
    np.testing.assert_array_equal(again.rows, first.rows)


def test_a_run_plays_at_the_chosen_pace(session):
    answers = session("fig4_9", [X], {"type": "play", "pace": 0.2}, {"type": "wait", "ms": 500}, {"type": "pause"})
    played = answers.of("frame")[-1]
    assert played["status"] == "paused"
    assert 0.05 < played["time"] <= 0.2  # in half a second; a busy machine may be slow, and is never early
