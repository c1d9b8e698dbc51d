"""The verdict on a run: outcome, sentence and cause, for each ending."""

import json
from io import StringIO

import numpy as np
import pytest
from rich.console import Console
from threadpoolctl import threadpool_info, threadpool_limits

from amb_cosim.presentation.units import units
from amb_cosim.results.growth import growing_part
from amb_cosim.results.loop_stability import LoopStability
from amb_cosim.results.places import RotorPlaces
from amb_cosim.results.summary import summarise
from amb_cosim.results.summary_table import print_summary
from amb_sweeps.metrics import evaluate
from tests.support.messages import assert_names

SAMPLED = ("contact_state", "rb1.mode", "rb2.mode", "rb1.f_n", "rb2.f_n", "rb1.impulse", "rb2.impulse")


def free_of_contact(dataset):
    for name in SAMPLED:
        dataset[f"rotor_contact.{name}"] = dataset[f"rotor_contact.{name}"] * 0
    return dataset


def touching(dataset, site, cycles):
    """Contact at a retainer within cycles [begin, end)."""
    within = (dataset["cycle"].values >= cycles[0]) & (dataset["cycle"].values < cycles[1])
    dataset[f"rotor_contact.{site}.mode"].values[within] = 1
    dataset["rotor_contact.contact_state"].values[within] = 1
    return dataset


def rolling(dataset):
    """Rolling backward on RB1 from cycle 14 on, five turns of whirl a turn of the rotor."""
    late = dataset["cycle"].values >= 14.0
    dataset["rotor_contact.rb1.mode"].values[late] = 2
    dataset["rotor_contact.contact_state"].values[late] = 1
    dataset["rotor_contact.rb1.whirl_speed"].values[late] = -10.0 * np.pi / 0.02
    return dataset


def without_power(dataset):
    off = dataset["cycle"].values >= 5.0
    for axis in ("mb1.amplifier_off_x", "mb1.amplifier_off_y", "mb2.amplifier_off_x", "mb2.amplifier_off_y"):
        dataset[f"amb_actuator.{axis}"] = ("time", off)
    return dataset


def growing(dataset):
    grown = np.exp(np.maximum(dataset["cycle"].values - 10.0, 0.0) / 5.0)
    for name in ("mb1.x", "mb1.y", "mb2.x", "mb2.y"):
        dataset[f"rotor_contact.{name}"] = dataset[f"rotor_contact.{name}"] * grown
    return dataset


def with_outcome(dataset, *outcome):
    return dataset.assign_attrs(completed=0, outcome=json.dumps(outcome))


def printed(dataset, *, whole=False, width=None):
    text = StringIO()
    print_summary(summarise(dataset), Console(file=text, width=width or 200, force_terminal=width is not None), whole)
    return text.getvalue()


CASES = {
    "recovered": (lambda run: run(), "the rotor touched and has been free of contact since cycle 11.99 (0.24 s)"),
    "trapped": (
        lambda run: touching(run(22), "rb2", (12.0, 21.5)),
        "still in contact with RB2 when the run ends (cycle 22, 0.44 s), 12 turns after the last event",
    ),
    "undecided": (
        lambda run: run(16),
        "free of contact for 4.01 cycles when the run ends (cycle 16, 0.32 s); it counts as recovered after 5 cycles",
    ),
    "landed": (lambda run: without_power(run(16)), "no magnet has power, and the rotor is still moving on RB2"),
    "levitated": (lambda run: free_of_contact(run()), "the rotor does not touch after the step"),
    "rolled": (lambda run: rolling(run()), "the rotor rolls on RB1 (backward whirl, 15000 rpm) at the end"),
    "unstable": (lambda run: growing(free_of_contact(run())), "its orbit grows: a part of its motion grows by 10 1/s"),
    "failed": (lambda run: with_outcome(run(), "failed", 0.31, "west", "no bits"), "west at t = 0.31 s: no bits"),
    "interrupted": (lambda run: with_outcome(run(), "interrupted", 0.31), "by the user at t = 0.31 s"),
}


def upright(dataset):
    """Turn gravity off, and let the rotor drift from one side of its retainers to the other after its last contact."""
    drift = np.clip(dataset["cycle"].values - 12.0, 0.0, None) / 8.0
    for name in ("mb1.x", "mb2.x"):
        dataset[f"rotor_contact.{name}"] = dataset[f"rotor_contact.{name}"] + 1e-3 * drift
    values = json.loads(dataset.attrs["parameters"])["rotor_contact"]
    return dataset.assign_attrs(parameters=json.dumps({"rotor_contact": values | {"gravity": 0.0}}))


@pytest.mark.parametrize("moved", [upright, growing])
def test_rotor_without_power_that_floats_in_its_retainers_has_landed(synthetic, moved):
    """Nothing levitates it, so that it is neither unstable nor recovered, however long it does not touch."""
    summary = summarise(moved(without_power(synthetic())))
    assert (summary.verdict.word, summary.recovery, summary.recovered) == ("landed", "landed", False)
    assert_names(summary.verdict.sentence, "no magnet has power", "not touched since cycle 11.99")


def test_verdict_on_a_loss_of_power_depends_on_axes_contact_and_time(synthetic):
    """Supported by a passive bearing and never touching, the rotor is free, even if its orbit grows."""
    one_axis, late = growing(without_power(synthetic())), without_power(synthetic())
    one_axis["amb_actuator.mb2.amplifier_off_y"] = ("time", np.zeros(one_axis.sizes["time"], bool))
    for name in [name for name in late if "amplifier_off" in str(name)]:
        late[name] = ("time", late["cycle"].values >= 13.0)
    never_touching = without_power(free_of_contact(synthetic()))
    magnetless = synthetic(places=RotorPlaces({"mb1": "rb1", "mb2": "rb2"}, ("rb1", "rb2")).to_json())
    words = {"unstable": [one_axis], "undecided": [late], "rolled": [rolling(without_power(synthetic()))]}
    words["free"] = [never_touching.copy(), growing(never_touching), free_of_contact(magnetless)]
    for word, runs in words.items():
        assert [summarise(run).verdict.word for run in runs] == [word] * len(runs)


def widening(dataset, radius, **attributes):
    """An orbit at the first bearing with a radius (m) over the cycle, free of contact and without a relief."""
    dataset = free_of_contact(dataset).assign_attrs(relief_cycle=5.0, **attributes)
    z = radius(dataset["cycle"].values) * np.exp(2j * np.pi * dataset["cycle"].values)
    for axis, values in (("x", z.real), ("y", z.imag)):
        dataset[f"rotor_contact.mb1.{axis}"] = ("time", values)
        dataset[f"rotor_contact.mb2.{axis}"] = ("time", 0.0 * values)
    return dataset


@pytest.mark.parametrize(
    ("radius", "word"),
    [
        (lambda cycle: 1.2e-3 * (1.0 - np.exp(-cycle / 30.0)), "undecided"),  # 0.5 mm of 0.75 mm, on its way to 1.2 mm
        (lambda cycle: 0.7e-3 * (1.0 - np.exp(-cycle / 8.0)), "levitated"),  # on its way to 0.7 mm
        (lambda cycle: np.full(len(cycle), 0.7e-3), "levitated"),
        (lambda cycle: 0.7e-3 * np.exp(-cycle / 30.0), "levitated"),
        (lambda cycle: 0.05e-3 * (1.0 + 0.05 * cycle), "levitated"),  # below a fifth of the clearance
    ],
)
def test_an_orbit_on_its_way_to_the_clearance_is_undecided(synthetic, word, radius):
    """A stable loop whose slowest vibration decays by 0.5 1/s, in 0.3 s after the step."""
    slow = LoopStability(0.9999, -0.5, 200.0).to_json()
    summary = summarise(widening(synthetic(), radius, loop_stability=slow))
    assert summary.verdict.word == word
    if word == "undecided":
        assert summary.recovered is False
        assert_names(summary.verdict.sentence, "too short to decide", "RB1", "widens")


def test_a_loop_that_is_not_known_is_judged_by_its_motion(synthetic, without):
    """Four cycles after the step are too few; for fifteen the verdict states the growth that they may hide: 1/0.3 s."""
    for end, word, facts in ((9, "undecided", ("too short to decide", "4 cycles")), (20, "levitated", ("3.3 1/s",))):
        dataset = free_of_contact(synthetic(end)).assign_attrs(relief_cycle=5.0)
        assert summarise(dataset).verdict.word == "levitated"
        verdict = summarise(without(dataset, "loop_stability")).verdict
        assert verdict.word == word
        assert_names(verdict.sentence, *facts)


def test_a_rotor_that_bounces_slowly_has_not_recovered_between_two_bounces(synthetic):
    """Contacts in cycles 6.5 and 11.5 make a flight of five; 5.5 cycles later it may still be in the next one."""
    dataset = touching(free_of_contact(synthetic(17)).assign_attrs(relief_cycle=5.0), "rb2", (11.4, 11.5))
    assert summarise(dataset).verdict.word == "recovered"
    verdict = summarise(touching(dataset, "rb2", (6.4, 6.5))).verdict
    assert verdict.word == "undecided"
    assert_names(verdict.sentence, "recovered after 9.82 cycles")


def vibrating(dataset, frequency, decay=0.0, limited=lambda cycle: cycle % 1.0 < 0.1, **chain):
    """A vibration in x, 1/20 of the clearance, of a multiple of the speed, beside the orbit from the step on."""
    dataset = free_of_contact(dataset).assign_attrs(relief_cycle=5.0)
    cycle = dataset["cycle"].values
    for name in ("mb1.x", "mb2.x"):
        r = 4e-5 * np.exp(-decay * np.maximum(cycle - 5.0, 0.0)) * np.sin(2.0 * np.pi * frequency * cycle)
        dataset[f"rotor_contact.{name}"] = ("time", 2e-4 * np.cos(2.0 * np.pi * cycle) + r)
        dataset[f"rotor_contact.{name[:-1]}y"] = ("time", 2e-4 * np.sin(2.0 * np.pi * cycle))
    dataset["rolac_controller.current_limited"] = ("time", limited(cycle))
    values = json.loads(dataset.attrs["parameters"]) | {"rolac_controller": chain}
    return dataset.assign_attrs(parameters=json.dumps(values))


@pytest.mark.parametrize(
    ("case", "word"),
    [
        ({"frequency": 7.37}, "unstable"),
        ({"frequency": 0.43}, "unstable"),  # 6.45 periods in the time after the step
        ({"frequency": 3.0}, "levitated"),  # a harmonic of the forced motion
        ({"frequency": 7.37, "decay": 0.05}, "levitated"),
        ({"frequency": 7.37, "limited": lambda cycle: (cycle % 1.0 < 0.1) & (cycle < 16.0)}, "levitated"),
        ({"frequency": 7.37, "chain.preset": 1.0}, "levitated"),
        ({"frequency": 7.37, "chain.preset": 2.0, "chain.noise": 0.0}, "unstable"),
    ],
)
def test_a_lasting_vibration_that_reaches_limits_is_a_limit_cycle(synthetic, case, word):
    """A tenth of the time at limits: the loop is unstable if rotation does not force the vibration and it lasts."""
    assert summarise(vibrating(synthetic(), **case)).verdict.word == word


def test_a_vibration_is_not_its_own_where_a_component_excites_it(synthetic):
    shaken = vibrating(synthetic(), 7.37).assign_attrs(sources='["shaker"]')
    assert summarise(shaken).verdict.word == "levitated"


@pytest.mark.parametrize("every", [1, 3, 7])
def test_a_limit_cycle_is_one_in_a_thinned_record(synthetic, every):
    limited = lambda cycle: np.sin(2.0 * np.pi * 7.37 * cycle) > 0.9  # noqa: E731
    for frequency, word in ((7.37, "unstable"), (3.0, "levitated")):
        dataset = vibrating(synthetic(), frequency, limited=limited).isel(time=slice(None, None, every))
        assert summarise(dataset).verdict.word == word


@pytest.mark.parametrize("word", CASES)
def test_first_line_and_outcome_of_a_sweep_are_the_verdict(synthetic, word):
    make, sentence = CASES[word]
    dataset = make(synthetic)
    assert printed(dataset).startswith(f"{word}: {sentence}")
    if word not in ("levitated", "failed", "interrupted"):  # a sweep has other words for these
        assert evaluate(dataset)[0] == summarise(dataset).recovery == summarise(dataset).verdict.word == word


def facts(dataset):
    return dict(summarise(dataset).verdict.facts)


def test_margin_of_a_levitated_rotor_is_that_of_its_largest_orbit(synthetic):
    """0.6 mm of 0.75 mm at the second bearing, after the step; its retainers never carry a force."""
    assert facts(free_of_contact(synthetic())) == {
        "speed": "3000 rpm",
        "margin to the clearance": "20 % at RB2; largest orbit 0.6 mm in 0.75 mm",
    }


@pytest.mark.parametrize(
    ("speeds", "text"),
    [
        ((180.0, 180.0, 1800.0), "180 to 1800 rpm"),
        ((1800.0, 180.0, 180.0), "1800 to 180 rpm"),
        ((180.0, 1800.0, 180.0), "180 to 1800 rpm"),
        ((1800.0, 1800.0, 1800.0), "1800 rpm"),
    ],
)
def test_speed_is_printed_whether_it_changes_or_not(synthetic, speeds, text):
    points = [(at, n * np.pi / 30.0) for at, n in zip((0.0, 0.2, 0.4), speeds, strict=True)]
    assert facts(synthetic(speed_profile=json.dumps(points)))["speed"] == text
    with units("Hz"):
        assert facts(synthetic())["speed"] == "50 Hz"


def test_a_run_whose_speed_changes_is_told_in_seconds_and_speeds(synthetic):
    """From 3000 to 6000 rpm in 0.4 s; the last contact at 0.2398 s is at 4798 rpm, in cycle 11.99 of 20 ms."""
    points = [(0.0, 100.0 * np.pi), (0.4, 200.0 * np.pi)]
    summary = summarise(rolling(synthetic(speed_profile=json.dumps(points))))
    assert "cycle" not in " ".join([summary.verdict.sentence, *dict(summary.verdict.facts).values()])
    assert_names(dict(summary.verdict.facts)["time in contact"], "0.12 s (3900 rpm)")
    assert (summary.cycle_duration, summary.speed_changes) == (0.02, True)
    recovered = summarise(synthetic(speed_profile=json.dumps(points)))
    assert_names(recovered.verdict.sentence, "0.2398 s (4798 rpm)")
    text = printed(rolling(synthetic(speed_profile=json.dumps(points))), whole=True)
    assert_names(text, "rolling", "from 0.28 s")
    undecided = summarise(synthetic(16, speed_profile=json.dumps(points))).verdict
    assert undecided.word == "undecided"
    assert_names(undecided.sentence, "0.0802 s", "5400 rpm", "recovered after 0.1 s without contact")


def test_undecided_contact_states_the_turns_after_which_it_is_trapped(synthetic):
    """The contact lasts until the end, six turns after the relief in cycle 10."""
    sentence = summarise(touching(synthetic(16), "rb2", (12.0, 16.5))).verdict.sentence
    assert_names(sentence, "RB2", "6 turns", "trapped after 10 turns")
    assert "counts as" not in summarise(CASES["trapped"][0](synthetic)).verdict.sentence


def test_margin_of_a_rotor_that_recovered_is_that_of_its_last_cycle(synthetic):
    assert facts(synthetic())["margin to the clearance"].startswith("46.7 % at RB2; orbit in the last cycle 0.4 mm")
    assert "margin to the clearance" not in facts(synthetic(16))


def test_margin_leaves_out_sites_that_cannot_touch(synthetic):
    dataset = free_of_contact(synthetic())
    values = json.loads(dataset.attrs["parameters"])["rotor_contact"]
    dataset.attrs["parameters"] = json.dumps({"rotor_contact": values | {"rb2.enabled": False}})
    assert facts(dataset)["margin to the clearance"].startswith("33.3 % at RB1")


def test_contact_force_is_printed_with_definition_and_bandwidth(synthetic):
    """2.5 N s within a step of 0.2 ms, averaged over 1 ms, beside the force of 1000 N."""
    places = RotorPlaces({"mb1": "rb1", "mb2": "rb2"}, ("rb1", "rb2"), valid_to=200.0 * np.pi, magnetic=("mb1", "mb2"))
    text = facts(synthetic().assign_attrs(places=places.to_json()))["largest contact force"]
    assert text.endswith("kN at RB1 (mean over 1 ms with impacts; the model's modes reach to 100 Hz)")


def test_time_in_contact_is_counted_for_the_rotor_and_each_site(synthetic):
    """RB1 for 1.5 cycles of 20 ms, RB2 for 1.5 cycles, half a cycle of both."""
    text = facts(synthetic())["time in contact"]
    assert text.startswith("0.05 s of 0.4 s (12.5 %); RB1 0.03 s, RB2 0.03 s; cycle 6 (0.12 s) to cycle 11.99")


def test_bounces_touch_at_their_instants_but_take_no_time(synthetic):
    """A hundred bounces on RB2 from cycle 14 to the end, none of which is closed at the end of a step."""
    dataset = without_power(synthetic())
    late = (dataset["cycle"].values >= 14.0) & (np.arange(dataset.sizes["time"]) % 6 == 0)
    dataset["rotor_contact.rb2.impulse"].values[late] = 0.1
    summary = summarise(dataset)
    assert_names(summary.verdict.sentence, "no magnet has power", "still moving", "RB2")
    text = dict(summary.verdict.facts)["time in contact"]
    assert text.startswith("0.05 s of 0.4 s (12.5 %); RB1 0.03 s, RB2 0.03 s;")


def test_run_that_did_not_record_contact_is_completed(synthetic):
    assert summarise(synthetic().drop_vars("rotor_contact.contact_state")).verdict.word == "completed"


def warned(dataset, *variables):
    records = [
        {"component": "rotor_contact", "variable": name, "kind": name, "sentence": f"{name} is off; change it"}
        for name in variables
    ]
    return dataset.assign_attrs(warnings=json.dumps(records))


def test_warnings_without_effect_on_the_verdict_are_one_counted_line(synthetic):
    lines = printed(warned(synthetic(), "solver.tolerance_missed", "eb1.passed", "mb1.saturated")).splitlines()
    assert lines[-2].startswith("warning: eb1.passed is off; change it (eb1.passed")
    assert lines[-1] == "2 more warnings, printed by --all: solver.tolerance_missed is off; mb1.saturated is off"


def test_growth_is_judged_with_one_blas_thread(monkeypatch):
    """Threads of a busy machine wait for each other: 0.1 s in place of 1 ms for 160 samples of eight signals."""
    seen, solve = [], np.linalg.lstsq

    def lstsq(*args, **options):
        seen.extend(library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas")
        return solve(*args, **options)

    monkeypatch.setattr(np.linalg, "lstsq", lstsq)
    with threadpool_limits(2, user_api="blas"):
        assert growing_part(np.exp(0.1 * np.arange(60.0))[:, None], 1e-6)
        after = {library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas"}
    assert set(seen) == {1}
    assert after == {2}
