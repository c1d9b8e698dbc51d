"""Key values of a synthetic run whose exact values are known."""

import itertools
import json
from dataclasses import replace
from fnmatch import fnmatch

import numpy as np
import pytest

from amb_cosim.results import contact_history, orbits, signal_arrays
from amb_cosim.results.summary import summarise
from amb_cosim.results.summary_table import table
from amb_sweeps.metrics import evaluate, needed
from tests.orchestrator.conftest import PLACES, acting
from tests.support.messages import assert_names


def figures_of(dataset):
    return summarise(dataset).as_dict()


def set_within(dataset, name, cycles, value):
    """Set a variable of the plant within cycles [begin, end)."""
    within = (dataset["cycle"].values >= cycles[0]) & (dataset["cycle"].values < cycles[1])
    dataset[f"rotor_contact.{name}"] = dataset[f"rotor_contact.{name}"].where(~within, value)
    return dataset


def test_summary_of_a_known_run(synthetic):
    figures = figures_of(synthetic())
    assert figures["peak_contact_force_N"] == {"rb1": 1234.5, "rb2": 700.0}
    assert figures["peak_impulse_Ns"] == {"rb1": 2.5, "rb2": 1.5}
    assert figures["contact_share"] == pytest.approx({"0": 0.7, "1": 0.2, "2": 0.0, "3": 0.1})
    assert figures["first_contact_cycle"] == pytest.approx(6.0)
    assert figures["last_contact_cycle"] == pytest.approx(11.99)
    assert figures["recovered"] is True
    assert figures["recovery"] == "recovered"
    assert figures["orbit_before_mm"] == pytest.approx({"mb1": 0.1, "mb2": 0.2})
    assert figures["orbit_after_mm"] == pytest.approx({"mb1": 0.3, "mb2": 0.4})
    assert figures["orbit_largest_mm"] == pytest.approx({"mb1": 0.5, "mb2": 0.6})
    assert figures["settled_amplitude_mm"] == {
        "before": pytest.approx({"mb1": 0.1, "mb2": 0.2}, rel=0.1),  # the window ends with the first sample of the step
        "end": pytest.approx({"mb1": 0.3, "mb2": 0.4}),
    }
    assert figures["simulated_s"] == pytest.approx(0.4)
    assert figures["real_time_factor"] == pytest.approx(4.0)
    assert figures["flavour"] == "python"
    json.dumps(figures, allow_nan=False)


def test_shares_of_methods_count_steps_after_the_settling(synthetic):
    dataset = synthetic()
    assert figures_of(dataset)["steps_by_method"] is None
    method = np.select([dataset["cycle"].values < 0.0, dataset["cycle"].values < 5.0], [2, 1], 0)
    flags = {"flag_values": np.arange(3, dtype=np.int32), "flag_meanings": "exact pieces integrated"}
    dataset["rotor_contact.solver.method"] = ("time", method.astype(np.int32), flags)
    steps = dataset["cycle"].values > 0.0  # each sample ends a step
    in_pieces = float(np.mean(method[steps] == 1))
    assert figures_of(dataset)["steps_by_method"] == pytest.approx({"exact": 1.0 - in_pieces, "pieces": in_pieces})


def test_share_spans_from_the_step_to_the_end_or_the_whole_run(synthetic, without):
    share = contact_history.contact_share(without(synthetic(15), "relief_cycle"))
    assert share["2"] == pytest.approx(100 / 1000)
    assert sum(share.values()) == pytest.approx(1.0)
    whole = contact_history.contact_share(without(synthetic(10), "disturbance_cycle", "relief_cycle"))
    assert whole["1"] == pytest.approx(100 / 1000)


@pytest.mark.parametrize(("end", "expected"), [(20, True), (17, True), (16, False), (12, False), (4, True)])
def test_recovered_means_free_for_the_last_five_cycles_or_from_the_start(synthetic, end, expected):
    assert contact_history.recovered(synthetic(end)) is expected


def free_of_contact(dataset, begin=0.0, end=np.inf):
    """Return the run without contact within cycles [begin, end)."""
    for name in ("contact_state", "rb1.mode", "rb2.mode", "rb1.impulse", "rb2.impulse"):
        set_within(dataset, name, (begin, end), 0)
    return dataset


def test_without_contact_after_the_step_the_outcome_is_prevented(synthetic):
    assert contact_history.recovery(free_of_contact(synthetic())) == "prevented"
    earlier = set_within(free_of_contact(synthetic()), "contact_state", (4.0, 4.2), 1)
    assert contact_history.recovery(earlier) == "prevented", "contact before the step is not due to it"
    later = set_within(free_of_contact(synthetic()), "contact_state", (5.01, 5.2), 1)
    assert contact_history.recovery(later) == "recovered"


def without_amplifiers(dataset, axes, begin, end=np.inf):
    """The run with the amplifiers of some axes off within cycles [begin, end)."""
    cycle = dataset["cycle"].values
    for bearing, axis in itertools.product(("mb1", "mb2"), "xy"):
        off = (cycle >= begin) & (cycle < end) & (f"{bearing}.{axis}" in axes)
        dataset[f"amb_actuator.{bearing}.amplifier_off_{axis}"] = ("time", off)
    return dataset


@pytest.mark.parametrize(
    ("axes", "end", "outcome"),
    [
        (("mb1.x", "mb1.y", "mb2.x", "mb2.y"), np.inf, "landed"),
        (("mb1.x", "mb1.y", "mb2.x", "mb2.y"), 12.0, "undecided"),
        (("mb1.x", "mb1.y", "mb2.x"), np.inf, "undecided"),
    ],
    ids=["power gone", "power back", "one axis left"],
)
def test_a_rotor_that_nothing_can_lift_has_landed(synthetic, axes, end, outcome):
    dataset = without_amplifiers(synthetic(16), axes, 5.0, end)
    assert contact_history.recovery(dataset) == outcome
    assert contact_history.recovered(dataset) is False
    unrecorded = dataset.drop_vars("amb_actuator.mb2.amplifier_off_y")
    assert contact_history.recovery(unrecorded) == "undecided"


def test_a_run_without_a_step_has_an_outcome_if_it_ends_in_contact(synthetic, without):
    """The rotor touches until cycle 12: five cycles later it is free."""
    assert contact_history.recovery(without(synthetic(), "disturbance_cycle")) is None
    assert contact_history.recovery(without(synthetic(16.0), "disturbance_cycle")) == "undecided"
    fallen = without_amplifiers(synthetic(16), ("mb1.x", "mb1.y", "mb2.x", "mb2.y"), 5.0)
    assert contact_history.recovery(without(fallen, "disturbance_cycle")) == "landed"
    assert contact_history.recovery(synthetic().drop_vars("rotor_contact.contact_state")) is None


@pytest.mark.parametrize("end", [5.5, 6.5, 9.0, 12.0, 16.0, 17.0, 20.0])
def test_outcome_and_recovery_agree(synthetic, end):
    for dataset in (synthetic(end), free_of_contact(synthetic(end), begin=5.0), free_of_contact(synthetic(end))):
        assert (contact_history.recovery(dataset) != "undecided") is contact_history.recovered(dataset)


@pytest.mark.parametrize(
    ("last", "end", "outcome"),
    [
        (12.4, 12.41, "undecided"),  # the end of `fig4_9 --until 0.3`
        (19.93, 19.94, "undecided"),
        (19.95, 19.96, "trapped"),  # ten turns after the relief, within a communication step
        (20.4, 22.0, "undecided"),  # free for more than a cycle
        (21.1, 22.0, "trapped"),
        (17.0, 22.1, "recovered"),
    ],
)
def test_a_rotor_is_trapped_if_contact_outlasts_its_cause_by_ten_turns(synthetic, last, end, outcome):
    """The unbalance is removed in cycle 10; the rotor then touches until `last`, and the run ends at `end`."""
    dataset = set_within(synthetic(end), "contact_state", (10.0, last), 1)
    assert contact_history.recovery(dataset) == outcome
    assert contact_history.recovered(dataset) is (outcome == "recovered")


def test_any_event_and_point_of_the_speed_begins_the_ten_turns_anew(synthetic):
    dataset = set_within(synthetic(22), "contact_state", (10.0, 22.1), 1)
    assert contact_history.recovery(dataset.assign_attrs(last_change_cycle=11.0)) == "trapped"
    assert contact_history.recovery(dataset.assign_attrs(last_change_cycle=13.0)) == "undecided"
    assert contact_history.recovery(dataset.assign_attrs(last_change_cycle=23.0)) == "trapped", "after the end"


@pytest.mark.parametrize(("factor", "outcome"), [(4.0, "trapped"), (0.5, "undecided"), (0.0, "trapped")])
def test_turns_are_those_of_the_rotor_unless_it_stands(synthetic, without, factor, outcome):
    """The speed changes from cycle 9 to 10 by a factor and stays for ten cycles of the first speed, or for four."""
    first, end = 2.0 * np.pi / 0.02, 14.0 if factor > 1.0 else 20.0
    profile = json.dumps([(0.0, first), (0.18, first), (0.2, factor * first)])
    dataset = without(synthetic(end, speed_profile=profile, last_change_cycle=10.0), "relief_cycle")
    assert contact_history.recovery(set_within(dataset, "contact_state", (10.0, end + 1.0), 1)) == outcome


def test_a_rotor_that_rolls_at_the_end_has_rolled_at_once(synthetic):
    """Five turns of whirl a turn of the rotor, from cycle 11 to the end in cycle 11.5."""
    whirling = rolling(synthetic(11.5), "rb2", (11.0, 12.0), turns=2.5)
    assert contact_history.recovery(whirling) == "rolled"


def test_an_impact_between_samples_counts_as_contact(synthetic):
    dataset = synthetic()
    dataset["rotor_contact.rb2.impulse"][1801] = 0.01
    assert contact_history.contact_cycles(dataset)[1] == pytest.approx(18.01)
    assert contact_history.recovered(dataset) is False


def test_settling_is_excluded_from_the_key_values(synthetic):
    dataset = synthetic()
    early = dataset.assign_coords(cycle=dataset["cycle"] - 8.0)  # the contacts of cycles 6 to 7.5 are settling now
    assert contact_history.peak(early, "rb1.f_n") == 0.0
    assert contact_history.contact_cycles(early)[0] == pytest.approx(3.0)


def test_key_values_need_no_variables_and_no_samples(synthetic):
    dataset = synthetic().drop_vars(["rotor_contact.contact_state", "rotor_contact.rb1.f_n", "rotor_contact.mb1.x"])
    figures = figures_of(dataset)
    assert figures["recovered"] is None
    assert figures["peak_contact_force_N"]["rb1"] is None
    assert figures["orbit_after_mm"] == {"mb1": None, "mb2": pytest.approx(0.4)}
    empty = figures_of(synthetic().isel(time=slice(0, 0)).assign_attrs(wall_s=0.0))
    assert empty["real_time_factor"] is None
    assert empty["first_contact_cycle"] is None


def whirling(dataset, forward, backward, offset=0.0, turns=None, mb="mb1"):
    """Let a bearing follow an ellipse, the sum of a forward and a backward circle (m) with phases."""
    theta = 2 * np.pi * (dataset["cycle"].values if turns is None else turns)
    z = offset + forward * np.exp(1j * theta) + backward * np.exp(-1j * theta)
    dataset[f"rotor_contact.{mb}.x"] = ("time", z.real)
    dataset[f"rotor_contact.{mb}.y"] = ("time", z.imag)
    return dataset


def test_settled_amplitude_is_the_major_semi_axis_of_the_orbit(synthetic):
    """0.2 mm forward, 0.05 mm backward: 0.25 by 0.15 mm, whichever way the ellipse lies and wherever its centre is."""
    dataset = whirling(synthetic(), 0.2e-3 * np.exp(0.7j), 0.05e-3 * np.exp(-2j), offset=(1 + 2j) * 1e-4)
    amplitude = orbits.settled_amplitudes(dataset)
    assert [amplitude[when]["mb1"] for when in ("before", "end")] == pytest.approx([0.25, 0.25], rel=1e-9)
    assert orbits.orbit_after(dataset)["mb1"] > 0.3


def test_settled_amplitude_excludes_asynchronous_motion(synthetic):
    dataset = synthetic()
    second = 0.1e-3 * np.cos(4 * np.pi * dataset["cycle"].values)
    dataset["rotor_contact.mb2.x"] = dataset["rotor_contact.mb2.x"] + second
    assert orbits.settled_amplitudes(dataset)["end"]["mb2"] == pytest.approx(0.4, rel=1e-6)


@pytest.mark.parametrize("ratio", [-0.08, -0.3, 0.48, 1.3])
def test_a_whirl_at_another_frequency_has_no_synchronous_part(synthetic, ratio):
    """0.15 mm at a fraction of the speed leaks into the ellipse of one turn, as 12 um at -0.08."""
    dataset = synthetic()
    whirling(dataset, 0.0, 0.0, offset=0.15e-3 * np.exp(2j * np.pi * ratio * dataset["cycle"].values))
    assert orbits.settled_amplitudes(dataset)["end"]["mb1"] is None
    assert orbits.settled_amplitudes(dataset)["end"]["mb2"] == pytest.approx(0.4)
    rows = dict(zip(*(column.cells for column in table(summarise(dataset), whole=True).columns), strict=True))
    assert rows["synchronous part at the end"] == "MB2 0.4 mm"


def test_a_synchronous_part_that_adapts_is_that_of_the_last_turn(synthetic):
    """It falls by a twentieth in each turn, as under adaptive control: the mean over the last turn is printed."""
    dataset = synthetic()
    cycle = dataset["cycle"].values
    whirling(dataset, 0.2e-3 * 0.95 ** (cycle - cycle[-1]), 0.0)
    assert orbits.settled_amplitudes(dataset)["end"]["mb1"] == pytest.approx(0.2 * 0.95**-0.5, rel=0.01)


@pytest.mark.parametrize("stride", [3, 7, 11])
def test_a_turn_need_not_be_a_whole_number_of_samples(synthetic, stride):
    dataset = whirling(synthetic(), 0.2e-3, 0.1e-3j, offset=1e-3).isel(time=slice(None, None, stride))
    assert orbits.settled_amplitudes(dataset)["end"]["mb1"] == pytest.approx(0.3, rel=1e-9)


def test_amplitudes_need_a_step_before_them_and_a_whole_turn_of_samples(synthetic, without):
    nothing, stepless = {"mb1": None, "mb2": None}, without(synthetic(), "disturbance_cycle")
    assert orbits.settled_amplitudes(synthetic().isel(time=slice(None, None, 20)))["end"] == nothing
    assert orbits.orbit_before(stepless) == orbits.settled_amplitudes(stepless)["before"] == nothing
    assert orbits.settled_amplitudes(synthetic(20, disturbance_cycle=0.5))["before"] == nothing
    assert orbits.settled_amplitudes(synthetic(0.5))["end"] == nothing


def test_without_a_step_the_change_is_that_rolac_begins(synthetic, without):
    dataset = acting(without(synthetic(), "disturbance_cycle", "relief_cycle"), 8.0)
    assert signal_arrays.change(dataset) == pytest.approx(8.0)
    assert orbits.settled_amplitudes(dataset)["before"]["mb1"] == pytest.approx(0.5)
    assert signal_arrays.change(acting(synthetic(), 8.0)) == 5.0, "a step counts first"
    assert signal_arrays.change(acting(without(synthetic(), "disturbance_cycle"), 0.0)) is None, "it acts all the time"
    assert signal_arrays.change(acting(without(synthetic(), "disturbance_cycle"), 99.0)) is None, "it never acts"


def test_turns_follow_a_changing_speed(synthetic):
    """From 50 to 150 turns per second within 0.2 s: 0.1 s at 50, 20 turns on the way, 0.1 s at 150."""
    points = [(0.0, 50.0), (0.1, 50.0), (0.3, 150.0)]
    dataset = synthetic(speed_profile=json.dumps([(t, 2 * np.pi * f) for t, f in points]))
    turned = signal_arrays.turns(dataset)
    assert np.interp([0.1, 0.3, 0.4], dataset["time"].values, turned) == pytest.approx([5.0, 25.0, 40.0])
    whirling(dataset, 0.2e-3j, 0.1e-3, turns=turned)
    assert orbits.settled_amplitudes(dataset)["end"]["mb1"] == pytest.approx(0.3, rel=1e-9)


def test_turns_are_counted_from_cycle_0(synthetic):
    dataset = synthetic()
    assert signal_arrays.turns(dataset).tolist() == dataset["cycle"].values.tolist()
    early = dataset.assign_coords(cycle=dataset["cycle"] - 8.0, time=dataset["time"] - 0.16)
    early = early.assign_attrs(speed_profile=json.dumps([(0.0, 100 * np.pi), (0.1, 200 * np.pi)]))
    assert signal_arrays.turns(early)[[0, 800]] == pytest.approx([-8.0, 0.0])


def rolling(dataset, site, cycles, turns):
    """Let a site roll within cycles [begin, end) through some turns of backward whirl."""
    span = (cycles[1] - cycles[0]) * dataset.attrs["period_s"]
    set_within(dataset, f"{site}.whirl_speed", cycles, -2 * np.pi * turns / span)
    return set_within(dataset, f"{site}.mode", cycles, 2)


def test_rolling_counts_from_the_first_turn_of_whirl_without_a_break(synthetic):
    """In a single sample, before cycle 0, which is settling, and to and fro there is no turn."""
    rolling_from = contact_history.rolling_from
    dataset = rolling(synthetic(), "rb2", (11.2, 11.6), turns=30)
    assert rolling_from(dataset) == pytest.approx(11.2)
    assert rolling_from(rolling(dataset, "rb1", (7.1, 7.3), turns=2)) == pytest.approx(7.1)
    parts = rolling(synthetic(), "rb1", (6.0, 6.2), turns=0.9)
    settling = rolling(synthetic(), "rb1", (6.0, 7.0), turns=10)
    settling = settling.assign_coords(cycle=settling["cycle"] - 8.0)
    to_and_fro = rolling(synthetic(), "rb1", (6.0, 12.0), turns=30)
    to_and_fro["rotor_contact.rb1.whirl_speed"].values[1::2] *= -1.0
    for none in (synthetic(), parts, rolling(synthetic(), "rb1", (6.0, 6.01), turns=100), settling, to_and_fro):
        assert rolling_from(none) is None
    assert rolling_from(rolling(parts, "rb1", (6.3, 6.5), turns=0.9)) is None, "two parts do not make a turn"


def test_rolling_on_a_turning_race_is_reported_but_no_whirl(synthetic):
    dataset = rolling(synthetic(), "rb1", (6.0, 12.0), turns=0.5)
    race = np.full(dataset.sizes["time"], dataset.attrs["speed_rad_s"])
    dataset["rotor_contact.rb1.race_speed"] = ("time", race)
    figures = figures_of(dataset)
    assert figures["rolling_from_cycle"] is None
    assert figures["rolling_on_race_from_cycle"] == pytest.approx(6.0)
    assert "rolling on a turning race" in table(summarise(dataset), whole=True).columns[0].cells


def test_whirl_at_the_end_is_a_mean_over_the_last_cycle_at_sites_in_contact(synthetic):
    dataset = rolling(synthetic(), "rb1", (6.0, 21.0), turns=-15 * 9)
    figures = figures_of(dataset)
    assert figures["whirl_speed_rad_s"] == {"rb1": pytest.approx(9 * dataset.attrs["speed_rad_s"]), "rb2": None}
    assert figures["rolling_from_cycle"] == pytest.approx(6.0)
    whirl = dataset["rotor_contact.rb1.whirl_speed"].values
    mean, whirl[-1] = float(whirl[-1]), 0.0
    assert contact_history.whirl_at_the_end(dataset, "rb1") == pytest.approx(mean, rel=0.02)


def test_bushes_are_listed_only_after_contact(synthetic):
    dataset = set_within(synthetic(), "eb2.f_n", (19.0, 19.1), 250.0)
    set_within(dataset, "eb2.mode", (19.0, 19.1), 1)
    figures = figures_of(dataset)
    assert figures["peak_contact_force_N"] == {"rb1": 1234.5, "rb2": 700.0, "eb2": 250.0}
    assert figures["peak_impulse_Ns"] == {"rb1": 2.5, "rb2": 1.5, "eb2": 0.0}
    assert figures["last_contact_cycle"] == pytest.approx(19.09)
    assert figures["recovered"] is False


def ledger(dataset):
    """200 J of work before cycle 0; then 30 J: 5, 10, 12 J become heat, 2 J remain, 1 J is the error of the balance."""
    k = np.arange(dataset.sizes["time"]) / (dataset.sizes["time"] - 1)
    for name, begin, gain in (
        ("work", 200.0, 30.0),
        ("damping", 100.0, 5.0),
        ("friction", 60.0, 10.0),
        ("impact", 35.0, 12.0),
        ("kinetic", 5.0, 2.0),
        ("balance", -3.0, -1.0),
    ):
        dataset[f"rotor_contact.energy.{name}"] = ("time", begin + gain * k)
    return dataset


def test_energies_are_counted_from_cycle_0(synthetic):
    figures = figures_of(ledger(synthetic()))
    assert figures["energy_J"] == pytest.approx(
        {"damping": 5.0, "friction": 10.0, "impact": 12.0, "work": 30.0, "balance": 1.0}
    )
    assert figures["energy_balance_relative"] == pytest.approx(1.0 / 30.0)
    json.dumps(figures, allow_nan=False)


def test_error_of_the_balance_is_printed_beside_the_heat(synthetic):
    """1 J of 27 J of heat, regardless of the spin energy, 1 MJ of which would hide it."""
    dataset = ledger(synthetic())
    dataset["rotor_contact.energy.kinetic"] = dataset["rotor_contact.energy.kinetic"] + 1e6
    summary = summarise(dataset)
    assert summary.energy_balance < 2e-6
    assert summary.energy_balance_of_heat == pytest.approx(1.0 / 27.0)
    rows = dict(zip(*(column.cells for column in table(summary, whole=True).columns), strict=True))
    assert rows["error of the energy balance"] == "1 J, 0.04 of the heat of 27 J"
    assert "energy gained in impacts" not in rows


def test_energy_that_impacts_create_is_printed_and_no_heat(synthetic):
    """Only the nodal impact rule can create energy, as it does not conserve momentum."""
    dataset = ledger(synthetic())
    dataset["rotor_contact.energy.impact"] = -dataset["rotor_contact.energy.impact"]
    rows = dict(zip(*(column.cells for column in table(summarise(dataset), whole=True).columns), strict=True))
    assert_names(rows["energy gained in impacts"], "12 J", "nodal")
    assert "gain in impacts" in rows["error of the energy balance"]


def test_run_without_heat_has_no_error_of_the_balance_beside_it(synthetic):
    summary = summarise(synthetic())
    assert summary.energy_balance_of_heat is None
    assert summary.as_dict()["energy_balance_relative"] is None
    assert "error of the energy balance" not in list(table(summary, whole=True).columns[0].cells)


def test_energy_error_is_the_largest_of_the_run(synthetic):
    dataset = ledger(synthetic())
    assert figures_of(set_within(dataset, "energy.balance", (3.0, 3.01), 5.0))["energy_J"]["balance"] == pytest.approx(
        8.0
    )


def test_energies_without_a_record_are_none(synthetic):
    figures = figures_of(synthetic().drop_vars("rotor_contact.energy.work"))
    assert (figures["energy_J"], figures["energy_balance_relative"]) == (None, None)


def test_share_in_contact_counts_bushes_too(synthetic):
    """The retainers for 1.5 of the 5 cycles between disturbance and relief, a bush for another one."""
    dataset = synthetic()
    within = (dataset["cycle"].values >= 8.0) & (dataset["cycle"].values < 9.0)
    assert contact_history.share_in_contact(dataset) == pytest.approx(0.3)
    dataset["rotor_contact.eb1.mode"] = ("time", 1 * within)
    assert contact_history.share_in_contact(dataset) == pytest.approx(0.5)
    assert evaluate(dataset)[1]["contact_share"] == pytest.approx(0.5)


def test_a_point_of_a_sweep_without_contact_has_not_recovered(synthetic, without):
    """The retainers touch until cycle 7.5, at which this record begins; its disturbance may have prevented contact."""
    quiet = synthetic()
    quiet = quiet.assign_coords(cycle=quiet["cycle"] - 13.0).assign_attrs(disturbance_cycle=3.0)  # of 7 cycles
    for dataset, ended in ((quiet, "prevented"), (without(quiet, "disturbance_cycle", "disturbance_label"), None)):
        recovery, values = evaluate(dataset)
        assert (recovery, values["contact"]) == (ended, 0.0)
        np.testing.assert_equal(values["recovered"], np.nan if ended is None else 1.0)


def test_a_sweep_has_the_forces_and_contacts_of_faces(synthetic):
    """A face touches until the end with 9 kN, more than any retainer."""
    faced = replace(PLACES, faces={"seat": "rb1"})
    assert any(fnmatch("rotor_contact.seat.f_n_peak", pattern) for pattern in needed(faced))
    dataset = synthetic(places=faced.to_json())
    touching = (dataset["cycle"].values > 14.0).astype(np.float64)
    dataset["rotor_contact.seat.f_n"] = ("time", 9e3 * touching)
    dataset["rotor_contact.seat.mode"] = ("time", touching)
    recovery, values = evaluate(dataset)
    assert (recovery, values["last_contact"]) == ("trapped", 20.0)
    assert values["peak_contact_force.seat"] == values["peak_contact_force"] == 9e3
