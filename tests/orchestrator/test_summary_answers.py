"""Lines that a summary puts first: the use of magnets, what a landing did, and warnings in its units."""

import json

import numpy as np
import pytest

from amb_cosim.cosim.record.warnings import WarningRecord
from amb_cosim.presentation.units import units
from amb_cosim.results.landing_rows import landing_rows
from amb_cosim.results.magnet_use import allowed_currents, largest_use, magnet_use_rows
from amb_cosim.results.places import RotorPlaces
from amb_cosim.results.plots.magnets import magnets
from amb_cosim.results.power import without_power
from amb_cosim.results.stability import is_limited
from amb_cosim.results.touchdown import Retainer, Touchdown
from amb_cosim.results.warning_sentences import warning_sentences
from tests.support.messages import assert_names


def with_parameters(dataset, **components):
    values = json.loads(dataset.attrs["parameters"])
    merged = {name: values.get(name, {}) | components.get(name, {}) for name in {*values, *components}}
    return dataset.assign_attrs(parameters=json.dumps(merged))


def with_current(dataset, axis, values):
    """Control currents (A) of an axis between -2 and 8 A by its controller."""
    bearing, direction = axis.split(".")
    limits = {f"{bearing}.i_min_{direction}": -2.0, f"{bearing}.i_max_{direction}": 8.0}
    dataset[f"rolac_controller.{bearing}.i_{direction}"] = ("time", values)
    return with_parameters(dataset, rolac_controller=limits)


def test_current_is_a_share_of_the_limit_on_its_side(synthetic):
    """-1.5 A of -2 A is 75 %, 4 A of 8 A only 50 %."""
    dataset = synthetic()
    values = np.where(dataset["cycle"].values < 3.0, 4.0, -1.5)
    (row,) = magnet_use_rows(with_current(dataset, "mb1.x", values))
    assert_names(row[1], "75 %", "MB1.X", "1.5 A", "2 A")


def test_current_before_cycle_0_and_without_power_does_not_count(synthetic):
    dataset = with_current(synthetic(), "mb2.y", np.full(synthetic().sizes["time"], 2.0))
    cycle = dataset["cycle"].values
    late = cycle >= 10.0
    dataset["rolac_controller.mb2.i_y"] = ("time", np.where(late, 8.0, 2.0))
    dataset["amb_actuator.mb2.amplifier_off_y"] = ("time", late)
    (row,) = magnet_use_rows(dataset)
    assert_names(row[1], "25 %", "2 A of 8 A")
    dataset["amb_actuator.mb2.amplifier_off_y"] = ("time", np.ones_like(late))
    assert list(magnet_use_rows(dataset)) == []


def with_coils(dataset, axis, upper, lower):
    """Currents (A) of the coil pairs of an axis with a bias of 3 A, 1 A of load and at most 10 A."""
    bearing, direction = axis.split(".")
    dataset[f"amb_actuator.{bearing}.i_upper_{direction}"] = ("time", upper)
    dataset[f"amb_actuator.{bearing}.i_lower_{direction}"] = ("time", lower)
    values = {"bias_current": 3.0, "static_current": 1.0, "current_limit": 10.0}
    return with_parameters(dataset, amb_actuator={f"{bearing}.{name}_{direction}": v for name, v in values.items()})


def test_the_current_that_flows_and_the_demand_have_a_row_each(synthetic):
    """i = (6 A - 1 A - 1 A)/2 = 2 A flow of 3 A that the lower coils can lose, while 3 A are demanded."""
    n = synthetic().sizes["time"]
    dataset = with_coils(with_current(synthetic(), "mb1.x", np.full(n, 3.0)), "mb1.x", np.full(n, 6.0), np.full(n, 1.0))
    flowing, demanded = magnet_use_rows(dataset)
    assert flowing[0] == "largest control current"
    assert_names(flowing[1], "66.7 %", "2 A of 3 A")
    assert demanded[0] == "largest demanded current"
    assert_names(demanded[1], "100 %", "3 A of 3 A")
    (row,) = magnet_use_rows(with_coils(dataset, "mb1.x", np.full(n, 6.99), np.full(n, 0.01)))
    assert_names(row[1], "99.7 %", "2.99 A of 3 A")


def test_a_demand_whose_effect_was_not_recorded_is_called_a_demand(synthetic):
    (row,) = magnet_use_rows(with_current(synthetic(), "mb1.x", np.full(synthetic().sizes["time"], 3.0)))
    assert row[0] == "largest demanded current"


@pytest.mark.parametrize(("lost", "upper", "lower"), [("upper", 0.0, 1.0), ("lower", 6.0, 0.0)])
def test_a_coil_pair_without_turns_does_not_count(synthetic, lost, upper, lower):
    """The other pair carries 2 A more than at the operating point, 4 A above and 3 A below."""
    n = synthetic().sizes["time"]
    dataset = with_coils(
        with_current(synthetic(), "mb1.x", np.full(n, 2.0)), "mb1.x", np.full(n, upper), np.full(n, lower)
    )
    dataset[f"amb_actuator.mb1.coil_loss_{lost}_x"] = ("time", np.ones(n))
    (row,) = magnet_use_rows(dataset)
    assert_names(row[1], "66.7 %", "2 A of 3 A")


def test_permanent_magnets_reduce_the_current_of_both_coil_pairs(synthetic):
    """With 2 A from magnets the coils carry 2 A and 1 A at the operating point."""
    n = synthetic().sizes["time"]
    dataset = with_current(synthetic(), "mb1.x", np.full(n, 1.0))
    dataset = with_coils(dataset, "mb1.x", np.full(n, 3.0), np.full(n, 0.0))
    dataset = with_parameters(dataset, amb_actuator={"mb1.permanent_bias_x": 2.0})
    (row,) = magnet_use_rows(dataset)
    assert_names(row[1], "33.3 %", "1 A of 3 A")


def test_coils_limit_a_current_more_than_the_controller(synthetic):
    """Bias 3 A, 1 A of load, at most 5 A: the loaded pair has 1 A left, and can lose 4 A; its opposite 3 A and 2 A."""
    coils = {"mb1.bias_current_x": 3.0, "mb1.static_current_x": 1.0, "mb1.current_limit_x": 5.0}
    dataset = with_parameters(
        with_current(synthetic(), "mb1.x", np.full(synthetic().sizes["time"], 0.5)), amb_actuator=coils
    )
    assert allowed_currents(dataset, "mb1.x") == (-2.0, 1.0)
    assert allowed_currents(with_parameters(dataset, rolac_controller={"mb1.i_max_x": 0.8}), "mb1.x") == (-2.0, 0.8)


UPRIGHT = RotorPlaces({"mb1": "rb1", "mb2": "rb2"}, ("rb1", "rb2"), magnetic=("mb1", "mb2", "thrust"), thrust="thrust")


def test_magnets_along_the_shaft_count_as_those_across_it_do(synthetic):
    """3 A of 4 A along the shaft are more than 4 A of 8 A across it, until the axial amplifier is off."""
    dataset = synthetic(places=UPRIGHT.to_json())
    n = dataset.sizes["time"]
    dataset = with_current(with_current(dataset, "mb1.x", np.full(n, 4.0)), "thrust.z", np.full(n, 3.0))
    dataset = with_parameters(dataset, rolac_controller={"thrust.i_max_z": 4.0})
    (row,) = magnet_use_rows(dataset)
    assert_names(row[1], "75 %", "thrust.z", "3 A of 4 A")
    assert magnets(dataset).axes[2].get_lines()[0].get_ydata()[-1] == 3.0
    dataset["amb_actuator.thrust.amplifier_off_z"] = ("time", np.ones(n, bool))
    assert_names(next(iter(magnet_use_rows(dataset)))[1], "50 %", "MB1.X")


def test_rotor_has_lost_power_when_its_axial_magnet_has_too(synthetic):
    dataset = synthetic(places=UPRIGHT.to_json())
    off = np.ones(dataset.sizes["time"], bool)
    for axis in ("mb1.{}_x", "mb1.{}_y", "mb2.{}_x", "mb2.{}_y"):
        dataset[f"amb_actuator.{axis.format('amplifier_off')}"] = ("time", off)
    assert not without_power(dataset).any()
    dataset["amb_actuator.thrust.amplifier_off_z"] = ("time", off)
    assert without_power(dataset).all()


def test_a_demand_along_the_shaft_that_stays_at_its_limit_is_limited(synthetic):
    dataset = synthetic(places=UPRIGHT.to_json())
    n = dataset.sizes["time"]
    assert not is_limited(dataset, slice(0, n))
    dataset["amb_actuator.thrust.voltage_limited_z"] = ("time", np.ones(n, bool))
    assert is_limited(dataset, slice(0, n))


def test_without_limits_there_is_no_use(synthetic):
    assert largest_use(synthetic(), lambda *_: np.ones(synthetic().sizes["time"]), lambda *_: None) is None


def retainer(whirl="none", speed=None, heat=10.0, temperature=None):
    return Retainer(0.1, 0.2, 0.3, whirl, speed, 1.0, heat, heat, None, temperature)


def fall(**retainers):
    return Touchdown(0.1, {}, {}, (), retainers, None, None, None, None, None)


def test_a_landing_states_whirl_contact_heat_temperature_and_final_speed(synthetic):
    slows = json.dumps([(0.0, 100.0 * np.pi), (0.4, 50.0 * np.pi)])  # 3000 to 1500 rpm
    sites = RotorPlaces({"mb1": "rb1", "mb2": "rb2"}, ("rb1", "rb2", "bush"), magnetic=("mb1", "mb2"))
    dataset = synthetic(speed_profile=slows, places=sites.to_json())
    rows = dict(
        landing_rows(dataset, fall(rb1=retainer("backward", -20.0 * np.pi, 40.0, 350.0), bush=retainer(heat=2.0)))
    )
    assert_names(rows["whirl"], "backward", "RB1", "600 rpm")
    before, _, after = rows["touched"].partition("outside")
    assert ("RB1" in before, "bush" in after) == (True, True)
    assert_names(rows["heat in contact"], "42 J", "40 J at RB1")
    assert_names(rows["highest temperature"], "76.85 °C", "RB1")
    assert float(rows["speed at the end"].split()[0]) == pytest.approx(1500.0, rel=0.01)


def test_a_landing_without_heat_capacity_says_what_its_temperature_needs(synthetic):
    rows = dict(landing_rows(synthetic(), fall(rb2=retainer())))
    assert_names(rows["highest temperature"], "rb2.heat_capacity")
    assert rows["whirl"] == "none"
    assert "highest temperature" not in dict(landing_rows(synthetic(), fall(rb2=retainer(heat=None))))


def passed(site):
    return WarningRecord("rotor_contact", f"{site}.passed", "k", f"{site} passed by -0.001 m", 0.1, 0.2, 0.3)


def test_sites_that_are_off_share_a_sentence_with_depth_clearance_and_times(synthetic):
    """1.5 mm beyond a clearance of 0.9 mm from 0.1 to 0.3 s at EB2, less and earlier at EB1."""
    dataset = synthetic()
    time = dataset["time"].values
    for site, depth, begin in (("eb1", 5e-4, 0.05), ("eb2", 1.5e-3, 0.1)):
        within = (time >= begin - 1e-9) & (time <= 0.3 + 1e-9)
        dataset[f"rotor_contact.{site}.gap"] = ("time", np.where(within, -depth, 2e-4))
    dataset = with_parameters(dataset, rotor_contact={"eb1.clearance": 9e-4, "eb2.clearance": 9e-4})
    (sentence,) = warning_sentences([passed("eb1"), passed("eb2")], dataset)
    assert_names(sentence, "EB1 and EB2", "1.5 mm", "0.9 mm", "0.050 to 0.300 s", "eb1.enabled")
    (single,) = warning_sentences([passed("eb1")], dataset)
    assert_names(single, "EB1", "0.5 mm")
    assert "EB2" not in single


def test_sites_that_are_off_without_a_recorded_gap_keep_the_sentence_of_the_fmu(synthetic):
    assert_names(warning_sentences([passed("eb1")], synthetic())[0], "-0.001 m")


def test_speeds_of_warnings_have_the_unit_of_the_summary(synthetic):
    """A whirl is compared with a frequency, which a summary prints in Hz; a spin speed is in rpm."""
    whirl = "the whirl at RB1, -628.319 to -62.8319 rad/s, is faster than the frequency"
    spin = "Omega = 104.72 rad/s is outside the table"
    records = [
        WarningRecord("rotor_contact", "rb1.beyond_reduction", "a", whirl),
        WarningRecord("linear_controller", "outside", "b", spin),
    ]
    first, second = warning_sentences(records, synthetic())
    assert_names(first, "-100 to -10 Hz")
    assert_names(second, "1000 rpm")
    assert "rad/s" not in first + second
    with units("rad/s"):
        assert_names(warning_sentences(records, synthetic())[0], "-628.3 to -62.83 rad/s")
