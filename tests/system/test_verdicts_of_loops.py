"""Words of runs of loops with poles just inside and just outside the circle; the truth is the motion long after a kick.

The derivative gain moves the pole of the slower rigid mode through the circle. A mode that nothing excites, an
excitation that never ends, or a record with few samples changes none of the words.
"""

from pathlib import Path

import numpy as np
import pytest

import amb_cosim
from amb_cosim.results.loop_stability import ATTRIBUTE, stability_of_loop
from amb_cosim.results.summary import summarise
from amb_cosim.scenario import final_loop
from amb_cosim.scenario.scenario import Scenario
from amb_sweeps.worker import Runner, Task
from tests.support.messages import assert_names

SLENDER = Path(__file__).parent / "slender"
KICK = [
    {"label": "kick", "time": 0, "set": {"rotor_contact": {"centre.f_x": 0.05}}},
    {"label": "end_of_kick", "time": "1 ms", "set": {"rotor_contact": {"centre.f_x": 0.0}}},
]
STABLE, UNSTABLE = (0.45, 0.5, 0.6, 0.8, 1.1), (-0.5, 0.0, 0.2, 0.35)  # derivative gains, A s/m
ENDS = np.geomspace(0.004, 0.15, 12)  # s
OFF = {"amb_actuator": {"*.amplifier_off_?": True}}


@pytest.fixture(scope="module")
def loop(tmp_path_factory):
    """`loop(gain, **changes)`: the scenario with a derivative gain (A s/m), and an integral gain (A/(m s))."""
    folder = tmp_path_factory.mktemp("loops")

    def scenario(gain: float, integral: float = 0.0, **changes) -> Scenario:
        gains = f'kd = "{gain} A.s/m"' + (f', ki = "{integral} A/(m.s)"' if integral else "")
        file = folder / f"{gain}_{integral}.toml"
        file.write_text((SLENDER / "lead.toml").read_text().replace('kd = "1.1 A.s/m"', gains))
        return Scenario.load(SLENDER / "levitation.toml").changed(fmu={"rolac_controller": str(file)}, **changes)

    return scenario


def run(scenario: Scenario, until: float):
    return amb_cosim.run(scenario, until=until, progress=False)


def cut(result, end: float, *, knows_loop: bool = True):
    """Return the data set of a run that ends earlier, perhaps without the loop's stability."""
    dataset = result.dataset.isel(time=result.dataset["time"].values <= end)
    dataset.attrs = {name: value for name, value in dataset.attrs.items() if knows_loop or name != ATTRIBUTE}
    return dataset.assign_attrs(simulated_s=end)


def word(dataset) -> str:
    return summarise(dataset).verdict.word


@pytest.mark.parametrize("gain", [*STABLE, *UNSTABLE])
def test_a_loop_has_the_word_of_its_motion_after_a_second_at_every_end(loop, gain):
    """Without its linear model, the motion never calls a stable loop unstable, and calls an unstable one so in time."""
    after = run(loop(gain, event=KICK), 1.2)
    x, time = after.dataset["rotor_contact.left.x"].values, after.dataset["time"].values
    early, late = (np.mean(x[(time >= begin) & (time < begin + 0.2)] ** 2) for begin in (0.7, 1.0))
    grows = after.summary.first_contact is not None or late > early
    assert grows == (gain in UNSTABLE)
    result = run(loop(gain, event=KICK), ENDS[-1])
    words = [word(cut(result, end)) for end in ENDS]
    assert {*words} <= ({"unstable"} if grows else {"levitated", "undecided"})
    assert words.count("undecided") <= len(ENDS) / 4
    by_motion = [word(cut(result, end, knows_loop=False)) for end in ENDS]
    assert {*by_motion} <= ({"undecided", "levitated", "unstable"} if grows else {"undecided", "levitated"})
    assert by_motion[0] == "undecided"  # 3 ms after the kick, less than a turn
    if gain == UNSTABLE[0]:
        assert by_motion[-1] == "unstable"


@pytest.mark.parametrize("law", ["linear", "nonlinear"])
@pytest.mark.parametrize("integral", [0.0, 300.0])
def test_no_end_of_a_stable_run_seems_to_grow(loop, law, integral):
    """Non-linear magnets and slow integral action: 24 poles fit such a motion with some outside the circle."""
    scenario = loop(1.1, integral, parameters={"amb_actuator": {"force_law": law}}, gravity="9.81 m/s2")
    result = run(scenario, 0.5)
    ends = np.linspace(0.04, 0.5, 31)
    assert {word(cut(result, end, knows_loop=False)) for end in ends} == {"levitated"}
    sentence = summarise(cut(result, 0.1, knows_loop=False)).verdict.sentence
    assert_names(sentence, "loop is not known", "0.1 s", "10 1/s")


def test_a_mode_that_nothing_excites_is_unstable_at_once(loop):
    """Without unbalance, weight or kick nothing moves; the loop decides, and the reason names mode, place and rate."""
    result = run(loop(-0.5), 0.02)
    assert np.abs(result.dataset["rotor_contact.left.x"].values).max() < 1e-12
    assert result.summary.recovery == "unstable"
    rate, frequency = stability_of_loop(result.dataset).growth_rate, stability_of_loop(result.dataset).frequency
    assert_names(
        result.summary.verdict.sentence, "unstable at 9000 rpm", f"{rate:.3g} 1/s", f"{frequency / 6.2832:.5g} Hz"
    )


def test_sampling_and_speed_do_not_change_the_word(loop):
    """A slow shaft makes three turns in 0.3 s; of a record with every 100th step a period has 16 samples."""
    for gain, expected in ((-0.5, "unstable"), (1.1, "levitated")):
        slow = loop(gain, Omega="600 rpm", inputs={"rotor_contact": {"centre.u": "0.7 g.mm"}})
        assert run(slow, 0.1).summary.verdict.word == expected
        assert run(slow.changed(record={"every": 100}), 0.1).summary.verdict.word == expected


def test_a_base_that_never_rests_does_not_hide_growth(loop):
    times = np.linspace(0.0, 0.2, 41)
    points = [[float(t), float(0.01 * np.sin(300.0 * t) * (1.0 + t))] for t in times]
    for gain, expected in ((0.0, "unstable"), (1.1, "levitated")):
        shaken = loop(gain, profile=[{"variable": "rotor_contact.base.a_x", "points": points}])
        assert run(shaken, 0.2).summary.verdict.word == expected


def test_a_coasting_rotor_with_few_samples_a_turn_is_levitated(loop):
    """5.3 samples a turn, between which a spline finds other angles than those of the shaft."""
    unbalance = {"rotor_contact": {"centre.u": "0.7 g.mm", "drive.torque_limit": 0.0}}
    coasting = loop(1.1, system="levitated_free_spin", inputs=unbalance, settle_cycles=5)
    coasting = coasting.changed(
        record={"every": 50}, parameters=coasting.parameters | {"rotor_contact": {"spin.drag": "1e-7 N.m.s"}}
    )
    result = run(coasting, 0.5)
    assert result.summary.verdict.word == "levitated"
    assert word(cut(result, 0.5, knows_loop=False)) == "levitated"


def test_a_rotor_that_loses_its_power_before_it_touches_again_is_undecided(loop):
    """A kick of 15 N throws it into its retainers; 3 ms before the end all amplifiers are switched off."""
    hit = [{**KICK[0], "set": {"rotor_contact": {"centre.f_x": 15.0}}}, KICK[1]]
    result = run(loop(1.1, event=hit), 0.2)
    assert result.summary.verdict.word == "recovered"
    off = run(loop(1.1, event=[*hit, {"label": "off", "time": "0.197 s", "set": OFF}]), 0.2)
    assert (off.summary.verdict.word, off.summary.recovery, off.summary.recovered) == ("undecided", "undecided", False)
    assert_names(off.summary.verdict.sentence, "no magnet has power", "0.197 s")


@pytest.mark.parametrize("until", [0.1, 0.2, 0.4])
def test_a_rotor_whose_loop_grows_has_not_recovered_between_two_contacts(loop, until):
    """It grows by 3 1/s, and flies for up to seven turns between contacts that never end."""
    hit = [{**KICK[0], "set": {"rotor_contact": {"centre.f_x": 15.0}}}, KICK[1]]
    summary = run(loop(0.2, event=hit), until).summary
    assert summary.last_contact > 5.0
    assert not summary.recovered
    assert summary.verdict.word in ("unstable", "undecided", "trapped")


def test_a_sweep_has_the_same_words(loop):
    runner = Runner(Task(loop(1.1), until=0.02))
    words = [runner.run(0, {"fmu.rolac_controller": loop(gain).fmu["rolac_controller"]}).outcome for gain in (0.0, 1.1)]
    runner.close()
    assert words == ["unstable", "completed"]


def test_a_kept_answer_is_that_of_the_same_loop_alone(loop, monkeypatch):
    """Run again with other unbalance, it is read from beside the rotor's FMU; with another gain or speed it is not."""
    first = run(loop(1.1), 0.004).dataset.attrs[ATTRIBUTE]

    class Computed(Exception):
        pass

    def compute(*_):
        raise Computed

    monkeypatch.setattr(final_loop, "_computed", compute)
    again = run(loop(1.1, inputs={"rotor_contact": {"centre.u": "0.3 g.mm"}}), 0.008)
    assert again.dataset.attrs[ATTRIBUTE] == first
    for other in (loop(1.1, Omega="9011 rpm"), loop(1.1, integral=11.0)):
        with pytest.raises(Computed):
            run(other, 0.004)


@pytest.mark.parametrize("changed", [{"left.amplifier_off_x": True}, {"left.stuck_x": True}])
def test_the_loop_is_not_known_once_an_event_has_changed_it(loop, changed):
    fault = {"label": "fault", "time": "10 ms", "set": {"amb_actuator": changed}}
    before, after = (run(loop(1.1, event=[fault]), until).dataset for until in (0.009, 0.02))
    assert stability_of_loop(before).is_stable
    assert stability_of_loop(after) is None


def test_the_loop_is_that_of_the_final_speed(loop):
    up = loop(1.1, speed=[{"time": "20 ms", "Omega": "60000 rpm"}])
    assert stability_of_loop(run(up, 0.03).dataset).speed == pytest.approx(2000.0 * np.pi)
