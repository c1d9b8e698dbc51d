"""Touchdown summaries of a synthetic fall whose exact values are known."""

import json
from dataclasses import replace

import numpy as np
import pytest
from falls import CLEARANCE, DOWN, END, LANDED, OMEGA, RELEASE, WHIRL, WHIRLED, H, fall

from amb_cosim.results.contact_history import ROLLING
from amb_cosim.results.plots import figure
from amb_cosim.results.rocking import steady_swing
from amb_cosim.results.summary import summarise
from amb_cosim.results.summary_table import table
from amb_cosim.results.touchdown import SLIDING, WHIRL_TURNS, landing_whirl, touchdown
from tests.support.messages import assert_names


@pytest.fixture(scope="module")
def fall_summary():
    return touchdown(fall())


def test_the_fall_begins_when_an_amplifier_is_switched_off(fall_summary):
    assert fall_summary.release == pytest.approx(RELEASE)
    assert fall_summary.drop == pytest.approx({"mb1": 0.75, "mb2": 0.75}, rel=1e-6)
    assert fall_summary.orbit == pytest.approx({"mb1": 0.75, "mb2": 0.75}, rel=1e-6)


def test_without_a_switch_the_fall_begins_with_contact():
    begun = touchdown(fall().drop_vars("amb_actuator.mb1.amplifier_off_x"))
    assert begun.release == pytest.approx(LANDED, abs=1.5 * H)


def test_the_first_five_impacts_are_listed_in_order(fall_summary):
    assert [(hit.site, hit.impulse) for hit in fall_summary.first_impacts] == [
        ("rb1", 3.0),
        ("rb2", 2.0),
        ("rb1", 1.0),
        ("rb2", 0.5),
        ("rb2", 0.5),
    ]
    assert fall_summary.first_impacts[0].after == pytest.approx(LANDED - RELEASE, abs=1.5 * H)


def test_rounding_of_a_lasting_contact_is_no_impact(fall_summary):
    rounding = fall()["rotor_contact.rb1.impulse"].values.copy()
    rounding[(rounding == 0.0) & (fall()["rotor_contact.rb1.mode"].values > 0)] = 7e-15
    assert touchdown(fall(**{"rb1.impulse": rounding})).first_impacts == fall_summary.first_impacts


@pytest.mark.parametrize("force", [450.0, 4.5e6])
def test_the_first_touch_is_an_impact_however_long_a_contact_lasts(force):
    """A first touch of 1e-4 N s bounces; the contact that follows has an impulse of 1e7 N s."""
    impulse, mode = (fall()[f"rotor_contact.rb1.{name}"].values.copy() for name in ("impulse", "mode"))
    at = int(np.argmax(fall()["time"].values > RELEASE)) + 20
    impulse[at] = 1e-4
    dataset = fall(**{"rb1.impulse": impulse, "rb1.f_n": np.where(mode > 0, force, 0.0)})
    hits = touchdown(dataset).first_impacts
    assert (hits[0].site, hits[0].impulse) == ("rb1", 1e-4)
    assert hits[1].impulse == 3.0


def test_a_rotor_without_contact_at_the_end_is_not_at_rest():
    lifted = fall()["time"].values > 2.0
    up = {
        f"{mb}.{axis}": np.where(lifted, 0.0, fall()[f"rotor_contact.{mb}.{axis}"])
        for mb in ("mb1", "mb2")
        for axis in "xy"
    }
    modes = {f"{site}.mode": np.where(lifted, 0, fall()[f"rotor_contact.{site}.mode"]) for site in ("rb1", "rb2")}
    state = np.where(lifted, 0, fall()["rotor_contact.contact_state"])
    result = touchdown(fall(**up, **modes, contact_state=state))
    assert result.rest_after is None
    assert result.free_after == pytest.approx(2.0 - RELEASE, abs=2 * H)


BACKWARD = ("backward", pytest.approx(WHIRL, rel=0.05))
MOTIONS = {  # mode and whirl speed of RB1 over time, None as in the fall, and the whirl that the summary states
    "backward whirl, then rest": (None, None, ("backward", pytest.approx(WHIRL))),
    "rocking at the bottom": (None, lambda t: 30.0 * np.cos(50.0 * t), ("none", None)),
    "rocking that gets around": (None, lambda t: 30.0 * np.cos(50.0 * t) + 4.0, ("none", None)),
    # 6.4 turns within a second, and then to and fro by 15 of them
    "rocking after a whirl": (None, lambda t: np.where(t < WHIRLED, WHIRL, 80.0 * np.cos(100.0 * t)), BACKWARD),
    # the orbit continues at 25 rad/s for the rest of the run, of which 5 ms are in contact
    "free orbit after a short contact": (
        lambda t: np.where((t > LANDED) & (t < LANDED + 5e-3), SLIDING, 0),
        lambda t: np.full(len(t), 25.0),
        ("none", None),
    ),
    # from 1.2 s on the rotor turns forward with the spin by 86 turns, without contact to the end or until 3 s
    **{
        f"free orbit after a whirl{', touching again' * touched}": (
            lambda t, touched=touched: 1 * ((t > LANDED) & (t < WHIRLED) | (t > 2.99) & touched),
            lambda t: np.where(t < WHIRLED, WHIRL, OMEGA),
            ("backward", pytest.approx(WHIRL)),
        )
        for touched in (False, True)
    },
    # the sample next to the centre has v/r = 1e5 rad/s, 100 rad in its step of 1 ms; on its way it turns by pi
    "passing the centre": (
        lambda t: np.where((t > LANDED) & ~np.isclose(t, 0.3), SLIDING, 0),
        lambda t: np.where(t < 0.5, 80.0 * np.cos(100.0 * t), 0.0) - 1e5 * np.isclose(t, 0.3),
        ("none", None),
    ),
}


def landing(until=END, whirl=WHIRL):
    """Return the fall without power, until a time (s), with a whirl at a speed (rad/s) for one second."""
    t = fall()["time"].values
    dataset = fall(**{f"{site}.whirl_speed": np.where(t < WHIRLED, whirl, 0.0) for site in ("rb1", "rb2")})
    off = dataset["amb_actuator.mb1.amplifier_off_x"]
    return dataset.assign({"amb_actuator.mb1.amplifier_off_y": off}).isel(time=t <= until)


@pytest.mark.parametrize("until", [WHIRLED + 0.05, 2.0, END])
def test_the_whirl_number_does_not_depend_on_the_length_of_the_run(until):
    """A whirl at 40 rad/s for one second is 40/(2 pi) = 6.37 turns; the whirl of a longer run is the same."""
    number, _ = landing_whirl(landing(until))
    assert number == pytest.approx(40.0 / (2.0 * np.pi), rel=2e-3)


@pytest.mark.parametrize(
    ("until", "whirl", "whirls", "decided"),
    [
        (WHIRLED + 0.05, -40.0, False, False),  # 6.4 turns, and the races turn at a third of the rotor's speed
        (END, -40.0, False, True),  # the rotor has stopped
        (1.0, -100.0, True, True),  # 12.7 turns by then, which a longer run cannot undo
        (END, -100.0, True, True),
        (END, 100.0, False, True),  # forward
    ],
)
def test_ten_backward_turns_are_a_whirl_and_a_short_run_leaves_it_undecided(until, whirl, whirls, decided):
    number, is_decided = landing_whirl(landing(until, whirl))
    assert (number >= WHIRL_TURNS, is_decided) == (whirls, decided)


def test_races_at_speed_decide_only_if_the_whirl_has_ended_for_ten_turns():
    """At 300 rad/s ten turns take 0.21 s; the whirl ends at 1.2 s, and the rotor never comes to rest."""
    for until, decided in ((WHIRLED + 0.15, False), (WHIRLED + 0.3, True)):
        run = landing(until)
        turning = np.full(run.sizes["time"], OMEGA)
        races = {f"rotor_contact.{name}": ("time", turning) for name in ("speed", "rb1.race_speed", "rb2.race_speed")}
        swing = ("time", 0.5 * CLEARANCE * np.sin(50.0 * run["time"].values))
        moving = {f"rotor_contact.{bearing}.{axis}": swing for bearing in ("mb1", "mb2") for axis in "xy"}
        assert touchdown(run.assign(races | moving)).rest_after is None
        assert landing_whirl(run.assign(races | moving))[1] is decided


def test_a_run_with_power_is_no_landing():
    powered = fall().assign(
        {f"amb_actuator.mb1.amplifier_off_{axis}": ("time", fall()["time"].values < 1.0) for axis in "xy"}
    )
    assert landing_whirl(powered) is None


@pytest.mark.parametrize("case", MOTIONS)
def test_whirl_is_a_lasting_turning_in_contact(case):
    mode, whirl, expected = MOTIONS[case]
    t = fall()["time"].values
    changes = {"rb1.mode": mode, "rb1.whirl_speed": whirl}
    retainer = touchdown(fall(**{name: of(t) for name, of in changes.items() if of})).retainers["rb1"]
    assert (retainer.whirl, retainer.whirl_speed) == expected
    if case == "free orbit after a short contact":
        assert retainer.sliding == pytest.approx(5e-3, abs=2 * H)


def test_times_in_each_mode_add_up_to_the_time_from_the_release(fall_summary):
    rb1, rb2 = fall_summary.retainers["rb1"], fall_summary.retainers["rb2"]
    assert (rb1.free, rb1.sliding, rb1.rolling) == pytest.approx((0.1, 1.0, 1.8), abs=2 * H)
    assert (rb2.free, rb2.sliding, rb2.rolling) == pytest.approx((0.15, 0.95, 1.8), abs=2 * H)
    assert rb1.free + rb1.sliding + rb1.rolling == pytest.approx(END - RELEASE)


def test_impulse_and_heat_are_those_of_each_retainer(fall_summary):
    rb1, rb2 = fall_summary.retainers["rb1"], fall_summary.retainers["rb2"]
    assert rb1.impulse == pytest.approx(4.0 + 450.0 * 2.8, abs=450.0 * 2 * H)
    assert rb2.impulse == pytest.approx(4.5 + 450.0 * 2.75, abs=450.0 * 2 * H)
    assert rb1.friction == pytest.approx(200.0, abs=1.0)
    assert rb1.heat == pytest.approx(200.0, abs=1.0)
    assert (rb1.temperature, rb2.temperature) == (None, 300.0)


def test_printed_impulses_say_whether_lasting_contact_is_included():
    """RB1 receives 1264 N s, of which impacts are 4 N s; `rb1.impulse` has only these."""
    summary = summarise(fall())
    labels, texts = (list(column.cells) for column in table(summary, whole=True).columns)
    rows = dict(zip(labels, texts, strict=True))
    assert_names(rows["in RB1"], f"force, with impacts, {summary.touchdown.retainers['rb1'].impulse:.4g} N s")
    of_impacts = [label for label, text in rows.items() if text.startswith(f"RB1 {summary.peak_impulse['rb1']:g} N s")]
    assert len(of_impacts) == 2
    assert all("impacts" in label for label in of_impacts)


def test_a_race_is_at_speed_at_95_percent_of_its_largest(fall_summary):
    assert fall_summary.retainers["rb1"].race_spin_up == pytest.approx(0.19, abs=2 * H)
    still = touchdown(fall(**{"rb1.race_speed": np.zeros(fall().sizes["time"])}))
    assert still.retainers["rb1"].race_spin_up is None


def test_a_race_with_slip_until_the_end_is_not_at_speed():
    mode = fall()["rotor_contact.rb1.mode"].values
    sliding = touchdown(fall(**{"rb1.mode": np.where(mode == ROLLING, SLIDING, mode)}))
    assert sliding.retainers["rb1"].race_spin_up is None


def rocked(amplitude, **options):
    """A fall after which both journals swing about the bottom 20 times a second, by an amplitude (rad) over time."""
    t = fall()["time"].values
    fallen = np.clip((t - RELEASE) / (LANDED - RELEASE), 0.0, 1.0) * CLEARANCE
    angle = 1.25 * np.pi + amplitude(t) * np.sin(40.0 * np.pi * t)
    moved = {f"mb{k}.{axis}": fallen * of(angle) for k in (1, 2) for axis, of in (("x", np.cos), ("y", np.sin))}
    return fall(**options, **moved)


@pytest.mark.parametrize(
    ("amplitude", "degrees"),
    [
        (lambda t: np.full(len(t), 0.8), np.degrees(0.8)),
        (lambda t: np.where(t < 1.5, 2.5, 0.8), np.degrees(0.8)),
        (lambda t: 1.2 * np.exp(-(t - 2.275) / 1.5), np.degrees(1.2)),
        (lambda t: 0.3 * np.exp((t - 3.0) / 4.0), np.degrees(0.3)),
    ],
)
def test_a_rotor_that_swings_at_the_bottom_without_growing_rocks(amplitude, degrees):
    """In the last quarter of the 2.9 s after the release; earlier motion does not matter."""
    dataset = rocked(amplitude)
    result = touchdown(dataset)
    assert (result.rest_after, result.rocks_within) == (None, pytest.approx(degrees, rel=0.03))
    off = {f"amb_actuator.mb1.amplifier_off_{axis}": ("time", dataset["time"].values >= RELEASE) for axis in "xy"}
    assert_names(summarise(dataset.assign(off)).verdict.sentence, f"swings up to {result.rocks_within:.0f} deg")


@pytest.mark.parametrize(
    "amplitude",
    [
        lambda t: 0.4 * np.exp(t / 3.0),  # 62 degrees at the end, and 90 degrees 1.1 s later
        lambda t: np.full(len(t), 1.8),
        lambda t: np.where(t < 2.0, 0.8, 40.0 * np.pi * (t - 2.0)),
    ],
)
def test_a_growing_swing_or_one_beyond_90_degrees_is_no_rocking(amplitude):
    assert touchdown(rocked(amplitude)).rocks_within is None


def test_a_rotor_at_rest_or_without_gravity_does_not_rock(fall_summary):
    assert fall_summary.rest_after is not None
    assert fall_summary.rocks_within is None
    assert touchdown(rocked(lambda t: np.full(len(t), 0.8), gravity=0.0)).rocks_within is None


def test_rocking_needs_five_periods_of_the_pendulum_in_a_quarter():
    """T = 2 pi sqrt(c/g): 55 ms for 0.75 mm, so 1.1 s."""
    shortest = 20.0 * 2.0 * np.pi * np.sqrt(CLEARANCE / 9.81)
    for end, rocks in ((1.02 * shortest, True), (0.98 * shortest, False)):
        t = np.linspace(0.0, end, 4000)
        z = CLEARANCE * np.exp(1j * (4.0 + 0.7 * np.sin(200.0 * t)))
        swing = steady_swing(t, z, CLEARANCE, 9.81)
        assert (swing == pytest.approx(0.7, rel=0.01)) if rocks else swing is None


def test_the_rotor_rests_when_its_whirl_has_ended(fall_summary):
    assert fall_summary.rest_after == pytest.approx(WHIRLED - RELEASE, abs=2 * H)
    assert fall_summary.standstill_after == pytest.approx(2.0, abs=2 * H)
    assert fall_summary.slow_after == pytest.approx(0.99 * 2.0, abs=2 * H)


def test_a_pendulum_does_not_rest_where_it_turns():
    """It swings by 0.1 rad with T = 2 pi sqrt(c/g) = 55 ms for ever; a tenth of the time is as short as 5 ms."""
    period = 2.0 * np.pi * np.sqrt(CLEARANCE / 9.81)
    words = set()
    for end in np.linspace(LANDED + 0.02, LANDED + 1.0, 24):
        dataset = fall()
        t = dataset["time"].values
        angle = 1.25 * np.pi + 0.1 * np.cos(2.0 * np.pi * (t - RELEASE) / period)
        moved = {f"mb{k}.{axis}": CLEARANCE * of(angle) for k in (1, 2) for axis, of in (("x", np.cos), ("y", np.sin))}
        words.add(touchdown(fall(**moved).isel(time=t <= end)).rest_after)
    assert words == {None}


def test_a_rotor_that_moves_at_the_end_is_not_at_rest():
    dataset = fall()
    moving = 0.2 * CLEARANCE * np.sin(40.0 * dataset["time"].values)
    assert touchdown(fall(**{"mb2.x": moving})).rest_after is None
    assert touchdown(fall(speed=np.full(len(moving), OMEGA))).standstill_after is None


@pytest.mark.parametrize(
    ("spin", "ends"),
    [
        (lambda t: np.where(t < 1.0, OMEGA, 1.0), None),  # rolls on at 0.3 % of the first speed
        (lambda t: np.where(t < 1.0, OMEGA * (1.0 - t), -np.sin(30.0 * (t - 1.0))), 1.0),  # rocks
        (lambda t: np.clip(OMEGA * (1.0 - t), -5.0, OMEGA), None),  # rolls backward
        (lambda t: OMEGA * np.exp(-5.0 * t), None),  # slows down without an end
        (lambda t: np.where(t < 1.0, -OMEGA * (1.0 - t), 0.0), 1.0),  # turns the other way
    ],
)
def test_the_spin_ends_when_the_rotor_turns_no_more(spin, ends):
    t = fall()["time"].values
    found = touchdown(fall(speed=spin(np.clip(t - RELEASE, 0.0, None)))).standstill_after
    assert found is None if ends is None else found == pytest.approx(ends, abs=2 * H)


def with_bush(dataset, x, y, mode=SLIDING):
    """The fall with a bush `eb` of 50 um besides the retainers, in which the journal moves along x and y (m)."""
    t = dataset["time"].values
    moved = {"x": x, "y": y, "mode": np.where(t > LANDED, mode, 0), "f_n": np.where(t > LANDED, 10.0, 0.0)}
    values = {f"rotor_contact.eb.{name}": ("time", value) for name, value in moved.items()}
    places = json.loads(dataset.attrs["places"]) | {"sites": ["rb1", "rb2", "eb"]}
    known = json.loads(dataset.attrs["parameters"])
    known["rotor_contact"]["eb.clearance"] = 50e-6
    return dataset.assign(values).assign_attrs(places=json.dumps(places), parameters=json.dumps(known))


def test_a_rotor_that_whirls_in_a_narrow_bush_is_not_at_rest(fall_summary):
    """A circle of 30 um is 4 % of the clearance of the retainers, and 60 % of that of the bush."""
    t = fall()["time"].values
    circle = 30e-6 * np.exp(40j * t)
    moved = {
        f"{mb}.{axis}": fall()[f"rotor_contact.{mb}.{axis}"].values + of
        for mb in ("mb1", "mb2")
        for axis, of in (("x", circle.real), ("y", circle.imag))
    }
    assert touchdown(fall(**moved)).rest_after == pytest.approx(fall_summary.rest_after, abs=0.01)
    assert touchdown(with_bush(fall(**moved), circle.real, circle.imag)).rest_after is None


def test_a_journal_that_does_not_touch_its_retainer_does_not_swing_in_it():
    """The journal of an offset retainer RB2 moves about its centre, while the rotor rocks on RB1 and the bush."""
    t = fall()["time"].values
    swing, turning = 1.25 * np.pi + 0.8 * np.sin(40.0 * np.pi * t), 1e-6 * np.exp(40j * np.pi * t)
    rocking = with_bush(rocked(lambda t: np.full(len(t), 0.8)), 50e-6 * np.cos(swing), 50e-6 * np.sin(swing))
    dataset = rocking.assign(
        {f"rotor_contact.mb2.{a}": ("time", of) for a, of in zip("xy", (turning.real, turning.imag), strict=True)}
    )
    assert touchdown(dataset).rocks_within is None
    free = {f"rotor_contact.rb2.{name}": ("time", np.zeros(len(t))) for name in ("mode", "impulse")}
    assert touchdown(dataset.assign(free)).rocks_within == pytest.approx(np.degrees(0.8), rel=0.03)


@pytest.mark.parametrize("name", ["speed", "rb1.heat", "rb1.race_speed", "mb1.x", "rb1.mode"])
def test_summary_of_a_touchdown_tolerates_missing_signals(name):
    summary = summarise(fall().drop_vars(f"rotor_contact.{name}"))
    json.dumps(summary.as_dict(), allow_nan=False)
    table(summary, whole=True)


def test_upright_rotor_touches_down_when_its_magnets_are_switched_off(fall_summary):
    """All values but the drop are as with gravity; without a drop the table has the orbit."""
    upright = fall(gravity=0.0)
    result = touchdown(upright)
    assert result == replace(fall_summary, drop={"mb1": None, "mb2": None})
    rows = dict(zip(*(column.cells for column in table(summarise(upright), whole=True).columns[:2]), strict=True))
    assert "depth of the fall" not in rows
    assert_names(str(rows["largest orbit from then on"]), "MB1", "0.75 mm")
    panels = [axes.get_title(loc="left") for axes in figure(upright, "touchdown").axes]
    over_time = ["Spin speed of rotor and races", "Heat in the retainers", "Temperature of the retainers"]
    assert panels == ["", "", "Gap to the retainer", *over_time]


def test_heights_are_drawn_in_retainers_also_if_one_is_offset_downwards():
    """RB1 by 0.1 mm along gravity: the rotor lies there, too, where the figure marks the clearance of 0.75 mm."""
    dataset = fall()
    values = json.loads(dataset.attrs["parameters"])
    values["rotor_contact"] |= {"rb1.offset_x": 1e-4 * np.cos(DOWN), "rb1.offset_y": 1e-4 * np.sin(DOWN)}
    (panel,) = (
        axes
        for axes in figure(dataset.assign_attrs(parameters=json.dumps(values)), "touchdown").axes
        if axes.get_title(loc="left").startswith("Height")
    )
    marked = {round(float(line.get_ydata()[0]), 6) for line in panel.lines if len(line.get_ydata()) == 2}
    assert -0.75 in marked
    assert -0.85 not in marked


def test_neither_a_rub_with_power_nor_a_flight_is_a_touchdown(synthetic):
    assert touchdown(fall(gravity=0.0).drop_vars("amb_actuator.mb1.amplifier_off_x")) is None
    assert summarise(synthetic()).touchdown is None
    free = {f"{site}.{name}": np.zeros(fall().sizes["time"]) for site in ("rb1", "rb2") for name in ("mode", "impulse")}
    assert touchdown(fall(contact_state=free["rb1.mode"], **free)) is None
