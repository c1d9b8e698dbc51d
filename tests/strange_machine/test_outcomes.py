"""Outcomes of a diverging loop, of a run without an event, and of a rotor that relevitates."""

import json

import numpy as np
import pytest
import xarray as xr
from strange_machine import LEVITATION, TOUCHDOWN

import amb_cosim
from amb_cosim.results.contact_history import recovered, recovery
from amb_cosim.results.orbits import notices_of_start
from amb_cosim.results.places import RotorPlaces
from amb_cosim.results.summary import Summary
from amb_cosim.results.summary_table import table
from amb_cosim.scenario.scenario import Scenario
from amb_sweeps.worker import Runner, Task
from tests.support.messages import assert_names

QUIET = Scenario.load(LEVITATION).changed(event=[], end_cycle=20)
UNDAMPED = {"rolac_controller.*.c_b_?": 0.0, "rotor_contact.guide.c_b": 0.0}
NOTHING_TO_TOUCH = {f"rotor_contact.{site}.enabled": False for site in ("catch_n", "catch_s", "labyrinth", "shroud")}


def rows(summary: Summary) -> dict[str, str]:
    labels, texts = (list(column.cells) for column in table(summary, whole=True).columns)
    return dict(zip(labels, texts, strict=True))


def test_an_undamped_loop_is_unstable_before_it_touches():
    summary = amb_cosim.run(QUIET.changed(end_cycle=40), set=UNDAMPED).summary
    assert (summary.first_contact, summary.recovery, summary.recovered) == (None, "unstable", False)
    assert_names(summary.verdict.sentence, "loop is unstable", "15000 rpm", "grows by")


@pytest.mark.parametrize("c_b", [7600.0, 7750.0, 7850.0, 7900.0, 8200.0])
def test_a_limit_cycle_at_the_current_limits_is_unstable_as_its_poles(c_b):
    """With a vibration of its own no rotor levitates, however short it is at the limits, or most of the time."""
    settings = {"rolac_controller.*.c_b_?": c_b}
    result = amb_cosim.run(QUIET.changed(settle_cycles=120), set=settings, progress=False)
    limited = result.dataset["rolac_controller.current_limited"].values.astype(bool)
    radius = np.abs(amb_cosim.linearise(LEVITATION, set=settings).poles()).max()
    assert limited.mean() > 0.5 if c_b == 8200.0 else limited.mean() < 0.35
    assert result.summary.verdict.word == ("unstable" if radius > 1.0 else "levitated")
    assert (result.summary.recovery == "unstable") == (radius > 1.0)


def test_an_aborted_run_has_not_recovered():
    loose = {"rolac_controller.*.k_b_?": "-0.1 N/um", **NOTHING_TO_TOUCH}
    result = amb_cosim.run(QUIET.changed(settle_cycles=0), set=loose)
    assert result.outcome.status == "failed"
    assert (result.summary.recovered, result.summary.recovery) == (False, "unstable")
    at_once = amb_cosim.run(QUIET, set={"rolac_controller.*.c_b_?": 3e4, **NOTHING_TO_TOUCH}).summary
    assert (at_once.recovered, at_once.recovery) == (None, None)
    assert (result.summary.verdict.word, at_once.verdict.word) == ("failed", "failed")


def test_a_run_without_event_and_contact_has_no_recovery():
    summary = amb_cosim.run(QUIET).summary
    assert (summary.recovered, summary.recovery) == (None, None)
    assert str(summary.verdict) == "levitated: the rotor does not touch"
    assert "margin to the clearance" in rows(summary)
    assert not any("contact" in label for label in rows(summary))
    assert [label for label, text in rows(summary).items() if text.rstrip(" -mN,").endswith("-") or "- " in text] == []
    assert not any(label.startswith("orbit before") for label in rows(summary))


def test_a_sweep_counts_an_unstable_point_as_such():
    runner = Runner(Task(QUIET.changed(end_cycle=40)))
    points = [runner.run(0, settings) for settings in (UNDAMPED, {})]
    runner.close()
    assert [point.outcome for point in points] == ["unstable", "completed"]
    np.testing.assert_equal([point.metrics["recovered"] for point in points], [0.0, np.nan])


@pytest.fixture(scope="module")
def caught() -> Summary:
    """The fall onto the retainers, with power again after 18 turns."""
    scenario = Scenario.load(TOUCHDOWN)
    (off,) = (event.model_dump(exclude_none=True) for event in scenario.event)
    on = {"label": "removal", "role": "relief", "cycle": 20, "set": {"amb_actuator": {"*.amplifier_off_?": False}}}
    return amb_cosim.run(scenario.changed(event=[off, on], end_cycle=80)).summary


def test_a_relevitated_rotor_is_not_at_rest(caught):
    assert caught.recovery == "recovered"
    assert caught.touchdown.rest_after is None
    assert caught.touchdown.free_after == pytest.approx((caught.last_contact - 2.0) / 250.0, abs=1e-4)
    assert rows(caught)["final state"].startswith("free of contact after")


def orbit(radius: np.ndarray, **attributes: float) -> xr.Dataset:
    """Return 20 turns of a free rotor on an orbit of this radius (m)."""
    cycle = np.linspace(0.0, 20.0, len(radius))
    z = radius * np.exp(2j * np.pi * cycle)
    signals = {"north.x": z.real, "north.y": z.imag, "contact_state": np.zeros(len(radius))}
    return xr.Dataset(
        {f"rotor_contact.{name}": ("time", values) for name, values in signals.items()},
        {"time": ("time", cycle * 4e-3), "cycle": ("time", cycle)},
        {
            "places": RotorPlaces({"north": "catch"}, ("catch",)).to_json(),
            "speed_rad_s": 500.0 * np.pi,
            "parameters": json.dumps({"rotor_contact": {"catch.clearance": 1e-4}}),
            **attributes,
        },
    )


T = np.linspace(0.0, 1.0, 2001)


@pytest.mark.parametrize("more", [{}, {"sources": '["shaker"]'}])
@pytest.mark.parametrize(
    ("radius", "expected"),
    [
        (1e-6 * np.exp(T), "unstable"),
        (1e-5 + 1e-7 * np.exp(5.0 * T), "unstable"),
        (1e-9 * np.exp(2.0 * T), None),  # a ten-thousandth of the clearance
        (1e-5 * (2.0 - np.exp(-3.0 * T)), None),  # on its way to a larger orbit
        (1e-5 * np.exp(-T), None),
        (np.full(2001, 1e-5), None),
    ],
)
def test_an_orbit_that_grows_ever_faster_is_unstable_also_when_excited(radius, expected, more):
    assert recovery(orbit(radius, **more)) == expected
    assert recovered(orbit(radius, **more)) is (expected is None)


GROWN = np.where(T < 0.5, 1e-6 * np.exp(8.0 * T), 1e-6 * np.exp(4.0))  # until cycle 10


@pytest.mark.parametrize(
    ("radius", "change", "expected"),
    [
        (1e-6 * np.exp(5.0 * T), 14.0, "unstable"),
        (1e-6 * np.exp(5.0 * T), 16.0, None),  # of 20 cycles: four are too few to decide
        (GROWN, 10.0, None),
    ],
)
def test_growth_counts_from_the_last_change_and_over_five_cycles(radius, change, expected):
    assert recovery(orbit(radius, last_change_cycle=change)) == expected


@pytest.mark.parametrize("rate", [0.01, 0.02, 0.03])
def test_a_steady_response_to_a_sine_sweep_from_outside_does_not_grow(rate):
    phase = -0.8 * 20.0 * T + 0.5 * rate * (20.0 * T) ** 2  # turns
    assert recovery(orbit(1e-5 * (1.0 + 0.3 * np.exp(2j * np.pi * phase)), sources='["shaker"]')) is None


FORCED = 1e-6 + 9e-6 * (T > 0.4)  # beside a shaker that begins at 40 % of the time
PHASE = 30.0 * T, 30.0 * T + 20.0 * T**2  # turns: of a steady vibration, and of a sweep from 30 to 70


def beside(radius, excitation):
    """Return the outcome of an orbit beside a shaker that exerts a force (N)."""
    dataset = orbit(radius, sources='["shaker"]', excitations='["shaker.f"]')
    return recovery(dataset.assign({"shaker.f": ("time", excitation)}))


@pytest.mark.parametrize(
    ("radius", "excitation"),
    [
        (FORCED, np.sin(2.0 * np.pi * PHASE[0]) * (T > 0.4)),  # begins
        (FORCED, 1.0 * (T > 0.4)),  # a step
        (1e-6 * np.exp(3.0 * T), np.exp(3.0 * T) * np.sin(2.0 * np.pi * PHASE[0])),  # grows
        (1e-6 / (1.1 - T), np.sin(2.0 * np.pi * PHASE[1])),  # sweeps towards a resonance
        (1e-6 * np.exp(3.0 * T), np.sin(2.0 * np.pi * PHASE[0]) * (T > 0.9)),  # too late for five cycles
    ],
)
def test_an_orbit_that_follows_a_change_from_outside_does_not_grow(radius, excitation):
    assert beside(radius, excitation) is None


@pytest.mark.parametrize(
    "excitation",
    [
        np.zeros(2001),
        np.sin(2.0 * np.pi * PHASE[0]),
        np.random.default_rng(1).standard_normal(2001),
        np.sin(2.0 * np.pi * PHASE[0]) * (T > 0.4),
        np.exp(-((T - 0.1) ** 2) / 1e-4) * (np.abs(T - 0.1) < 0.05),  # a pulse
    ],
)
def test_an_orbit_that_grows_after_the_last_change_outside_is_unstable(excitation):
    assert beside(1e-7 * np.exp(5.0 * T), excitation) == "unstable"


SETTLING = 1e-5 * (1.0 + 3.0 * np.exp(-8.0 * T))  # falls by 24.7 % in the first of its 20 turns


@pytest.mark.parametrize("role", [{}, {"disturbance_cycle": 10.0}])
def test_largest_orbit_of_an_unsettled_start_has_a_notice(role):
    """(1 + 3 exp(-0.4))/4 = 0.753."""
    (notice,) = notices_of_start(orbit(SETTLING, **role))
    assert_names(notice, "north", "25 %", "settle_cycles")


@pytest.mark.parametrize(
    ("radius", "role"),
    [
        (np.full(2001, 1e-5), {}),
        (1e-5 * np.exp(-0.4 * T), {}),  # by 2 % in a turn
        (1e-5 * (1.0 + 0.5 * np.cos(8.0 * np.pi * T)), {}),  # a beat of five turns
        (1e-6 * np.exp(T), {}),
        (SETTLING + 1e-4 * (T > 0.5), {"disturbance_cycle": 10.0}),  # the step of unbalance is larger
        (SETTLING, {"disturbance_cycle": 0.0}),  # the event is the start
    ],
)
def test_largest_orbit_of_a_later_time_has_no_notice(radius, role):
    assert not notices_of_start(orbit(radius, **role))


def orbit_of_motion(z: np.ndarray) -> xr.Dataset:
    """Return 20 turns of a free rotor with the motion x + j y (m)."""
    return orbit(z * np.exp(-40j * np.pi * T))


@pytest.mark.parametrize("phase", [0.0, 1.0, 2.0, 3.0, 4.0, 5.0])
@pytest.mark.parametrize("way", [2e-6, 2e-5, 1e-4])
@pytest.mark.parametrize("turns", [5.0, 7.3, 20.0])
def test_rotor_that_drifts_on_a_straight_line_is_not_unstable(way, phase, turns):
    """A free rotor moves uniformly and whirls about its line; a damped or steady orbit of 10 um adds no growth."""
    line = way * T * np.exp(1j * phase)
    for amplitude in (0.0, 1e-5, 1e-5 * np.exp(-3.0 * T)):
        assert recovery(orbit_of_motion(line + amplitude * np.exp(2j * np.pi * turns * T + 1j))) is None


STEADY = 1e-5 * np.exp(40j * np.pi * T)  # synchronous orbit
PHASES = np.arange(12) * np.pi / 6.0


@pytest.mark.parametrize("rate", [0.4, 1.0, 3.0, 8.0])  # of the amplitude, per duration
@pytest.mark.parametrize("frequency", [0.0, 0.05, 0.25, 5.0, 40.0])  # periods in the duration
@pytest.mark.parametrize("others", [0.0, 3e-6j * T, STEADY])
def test_exponential_growth_is_unstable_with_drift_and_orbit(rate, frequency, others):
    """Of a real pole, too; the drift is three amplitudes long, the orbit ten amplitudes large."""
    vibration = 1e-6 * np.exp((rate + 2j * np.pi * frequency) * T)
    assert recovery(orbit_of_motion(vibration + others)) == "unstable"


@pytest.mark.parametrize("rate", [0.4, 1.0, 3.0])
@pytest.mark.parametrize("periods", [0.1, 0.25, 0.5, 1.0, 1.5, 2.0, 3.0, 5.0, 20.5])
@pytest.mark.parametrize("others", [0.0, 3e-6j * T, STEADY])
def test_growth_along_a_line_is_unstable_at_every_phase(rate, periods, others):
    """x = exp(sigma t) cos(omega t + phi): the mean square of a third of the time depends on the phase."""
    for phase in PHASES:
        vibration = 1e-6 * np.exp(rate * T) * np.cos(2.0 * np.pi * periods * T + phase)
        assert recovery(orbit_of_motion(vibration + others)) == "unstable"


@pytest.mark.parametrize("rate", [-3.0, -0.4, 0.0])
@pytest.mark.parametrize("periods", [0.1, 0.5, 1.5, 2.0, 20.5])
def test_vibration_that_does_not_grow_is_stable_at_every_phase(rate, periods):
    """Slow vibrations and beats with the orbit, whose mean square rises within the time at some phases."""
    for phase in PHASES:
        vibration = 1e-5 * np.exp(rate * T) * np.cos(2.0 * np.pi * periods * T + phase)
        assert recovery(orbit_of_motion(vibration + STEADY)) is None


@pytest.mark.parametrize("noise", [1e-9, 1e-8, 1e-7, 1e-6])
def test_noise_neither_grows_nor_hides_growth(noise):
    """The growing vibration reaches at least seven times the noise."""
    random = np.random.default_rng(7)
    for motion in (STEADY, STEADY + 3e-6j * T, STEADY * (2.0 - np.exp(-3.0 * T))):
        noisy = motion + noise * (random.standard_normal(len(T)) + 1j * random.standard_normal(len(T)))
        assert recovery(orbit_of_motion(noisy)) is None
        for phase in PHASES:
            vibration = 1e-6 * np.exp(3.0 * T) * np.cos(8.0 * np.pi * T + phase)
            assert recovery(orbit_of_motion(noisy + vibration)) == "unstable"


@pytest.mark.parametrize("change", [1e-4, 2e-3, 9e-3])
def test_synchronous_orbit_at_a_speed_that_varies_a_little_is_steady(change):
    """In time, a sine whose frequency rises by 1 % is fitted by growing and decaying ones."""
    noise = 1e-9 * np.random.default_rng(7).standard_normal(len(T))
    turns = 20.0 * (T + 0.5 * change * T**2)
    dataset = orbit(1e-5 * np.exp(2j * np.pi * (turns - 20.0 * T)) + noise)
    dataset["rotor_contact.speed"] = ("time", 500.0 * np.pi * (1.0 + change * T))
    assert recovery(dataset) is None


def test_an_orbit_that_grows_with_the_speed_is_not_unstable():
    profile = json.dumps([(0.0, 1000.0), (0.08, 1500.0)])
    assert recovery(orbit(1e-6 * np.exp(T), speed_profile=profile)) is None
