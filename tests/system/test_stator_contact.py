"""A rotor whose magnets have no power, and whose retainers do not stop it, lands on the stators of the magnets."""

from functools import cache

import numpy as np
import pytest
from messages import assert_names, raises_naming

import amb_cosim
from amb_cosim.model_constants.plant_data import plant
from amb_cosim.results.result import Result
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.scenario import Scenario
from amb_sweeps.metrics import evaluate, outcome_of
from rotor_analysis.parts import Bearing, Site
from rotor_analysis.rotor import Rotor
from rotor_analysis.rotor_file import load_rotor
from rotor_analysis.shaft import Shaft

GAP, CLEARANCE, GRAVITY = 1.2e-3, 0.75e-3, 9.81  # m of magnets and retainers, m/s^2
BRIEF = {"Omega": "10 Hz", "settle_cycles": 1, "end_time": 0.3}
LANDING = Scenario.load("drop").changed(**BRIEF)
WORN = {"rotor_contact.rb?.clearance": "5 mm", "rotor_contact.eb?.enabled": False}
SMOOTH = WORN | {"rotor_contact.stator_*.mu": 0, "rotor_contact.d?.u": 0}
SOFT = {"rotor_contact.rb?.mount_stiffness_?": "1e5 N/m", "rotor_contact.eb?.enabled": False}


@cache
def landing(kind: str) -> Result:
    """Return a landing with `worn` retainers and smooth stators, or with retainers in `soft` mounts."""
    if kind == "worn":
        return amb_cosim.run(LANDING, set=SMOOTH)
    return amb_cosim.run(Scenario.load("drop_mount").changed(**BRIEF), set=SOFT)


def sample(result: Result, name: str) -> np.ndarray:
    return np.asarray(result.dataset[name].values)


def test_stators_carry_the_weight_of_the_rotor():
    """Impulse of all stators upwards = m g t, within the momentum that the bending rotor had at its first impact.

    That of a fall by the gap is m sqrt(2 g l). It vibrates on between the bearings, so the mean rate is closer.
    """
    result, mass = landing("worn"), load_rotor("bath_rig").mass
    time = sample(result, "time")
    up = np.sqrt(0.5)  # against gravity, which pulls towards negative x and y alike
    upwards = sum(
        -up * (sample(result, f"{site}.x") + sample(result, f"{site}.y")) / GAP * sample(result, f"{site}.f_n_mean")
        for site in ("rotor_contact.stator_mb1", "rotor_contact.stator_mb2")
    )
    received = np.cumsum(upwards * np.diff(time, prepend=time[0]))
    assert received[-1] == pytest.approx(mass * GRAVITY * time[-1], abs=0.5 * mass * np.sqrt(2.0 * GRAVITY * GAP))
    lying = time > 0.05
    assert np.polyfit(time[lying], received[lying], 1)[0] == pytest.approx(mass * GRAVITY, rel=0.02)


def test_rotor_lies_in_the_bore_at_the_air_gap():
    for bearing in ("mb1", "mb2"):
        x, y = (sample(landing("worn"), f"rotor_contact.{bearing}.{a}") for a in "xy")
        assert np.hypot(x, y).max() == pytest.approx(GAP, rel=2e-3)
        assert (x[-1], y[-1]) == pytest.approx((-GAP / np.sqrt(2.0),) * 2, rel=0.05)


def test_landing_on_the_stator_is_an_outcome_with_key_values():
    """Magnets that lose their power push it down at most, so that it falls no slower than freely."""
    result = landing("worn")
    summary = result.summary
    assert result.outcome.status == "completed"
    assert (summary.verdict.word, summary.recovery) == ("stator", "stator")
    assert_names(summary.verdict.sentence, "stator", "MB1", "MB2", "no magnet has power")
    assert outcome_of(result.outcome, evaluate(result.dataset)[0])[0] == "stator"
    for touch in summary.stators.values():
        assert 0.5 * np.sqrt(2.0 * GAP / GRAVITY) < touch.first < 1.02 * np.sqrt(2.0 * GAP / GRAVITY)
        assert (touch.force or 0.0) > 0.5 * 96.0 * GRAVITY / 2.0
    assert (summary.energy_balance or 1.0) < 1e-3


def test_soft_mounts_let_the_rotor_pass_the_retainers():
    """A mount that m g/2 deflects by mm leaves the weight to the stator, after 0.75 mm of free fall to the retainer."""
    result = landing("soft")
    fall, stators = result.summary.touchdown, result.summary.stators
    assert fall is not None
    assert set(stators) == {"stator_mb1", "stator_mb2"}
    assert set(fall.retainers) == {"rb1", "rb2", *stators}
    first = result.summary.first_contact
    assert first is not None
    assert first / 10.0 < min(touch.first for touch in stators.values())
    for retainer in ("rb1", "rb2"):
        housing = np.hypot(*(sample(result, f"rotor_contact.{retainer}.housing_{a}") for a in "xy"))
        assert housing.max() > GAP - CLEARANCE - 0.05e-3


def test_power_that_returns_on_the_stator_is_a_fault():
    back = {"role": "relief", "time": 0.1, "set": {"amb_actuator": {"*.amplifier_off_?": False}}}
    events = [event.model_dump(exclude_none=True) for event in LANDING.event]
    result = amb_cosim.run(LANDING.changed(gravity_angle="180 deg", event=[*events, back]), set=SMOOTH)
    assert result.outcome.status == "failed"
    assert result.outcome.time == pytest.approx(0.1, abs=1e-3)
    assert_names(result.outcome.reason, "mb1.x", "air gap", "0.0012 m")


def test_clearance_of_a_stator_is_the_smaller_air_gap():
    """Patterns that retainers match as well do not make a stator a retainer."""
    settings = {
        "amb_actuator.mb1.gap_y": "1 mm",
        "rotor_contact.*.clearance": "0.6 mm",
        "rotor_contact.*.race_inertia": "1e-3 kg.m2",
        "rotor_contact.stator_mb2.mu": 0.15,
    }
    values = prepare_run(LANDING, settings).parameters["rotor_contact"]
    assert (values["stator_mb1.clearance"], values["stator_mb2.clearance"]) == pytest.approx((1e-3, GAP), rel=2e-3)
    assert (values["rb1.clearance"], values["stator_mb2.mu"]) == (0.6e-3, 0.15)
    assert values.get("stator_mb1.race_inertia", 0.0) == 0.0


SHAFT = Shaft((0.0, 0.5, 1.0), (0.05,), youngs_modulus=210e9, density=7850.0, poissons_ratio=0.3)
ENDS = (Bearing("left", 1), Bearing("right", 3))


def test_a_declared_bore_keeps_its_clearance():
    rotor = Rotor("fan", SHAFT, (), ENDS, (Site("bore", 1, 0.3e-3, stator="left"),))
    sites = plant(rotor, ("left", "right"))[0].layout["sites"]
    assert [(s["name"], s["stator"]) for s in sites] == [("bore", "left"), ("stator_right", "right")]
    assert sites[0]["clearance"] == 0.3e-3


def test_site_is_retainer_or_stator_of_a_bearing():
    with raises_naming(ValueError, "sites[0]", "catch", "bearing", "stator", "one of them"):
        Rotor("fan", SHAFT, (), ENDS, (Site("catch", 1, bearing="left", stator="left"),))
    with raises_naming(ValueError, "sites[0].stator", "catch", "'lift'", "left"):
        Rotor("fan", SHAFT, (), ENDS, (Site("catch", 1, stator="lift"),))


def test_a_part_named_like_a_stator_is_refused():
    with raises_naming(ValueError, "stator_left", "fan", "stator bore of left"):
        plant(Rotor("fan", SHAFT, (), ENDS, (Site("stator_left", 2),)), ("left",))
