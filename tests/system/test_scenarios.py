"""The thesis's simulations agree with closed forms, and with another code.

tests/packs/test_stored_robustness.py sees how they end, and `amb-cosim report` what the thesis states of them.
"""

from functools import cache

import numpy as np
import pytest

import amb_cosim
from amb_cosim.cosim.system.values import quantity
from amb_cosim.scenario.scenario import load_scenario
from source_check import run_quantities

CLEARANCE = 0.75e-3  # m
RATIO = 0.025 / CLEARANCE  # R_s/C_r
NODAL, NEWTON = 0, 1
AWARE = {"rolac_controller__contact__aware": True, "rolac_controller__contact__source": 1}  # by its own sensors
SIDES = ("mb1", "mb2")


@cache
def result_of(name, **settings):
    """A scenario's result; `a__b=1` sets `a.b`."""
    result = amb_cosim.run(name, set={key.replace("__", "."): value for key, value in settings.items()}, progress=False)
    assert result.outcome.failure is None, result.outcome.failure
    return result


# Of an independent monolithic simulation of the rotor on continuous bearings, and its tolerance: cycles, clearances, N.
PROTOTYPE = {
    "fig3_8": {"orbit_after_mm.mb2": (0.60, 0.03)},
    "fig3_9": {"orbit_after_mm.mb2": (0.32, 0.03)},
    "fig4_5": {"first_contact_cycle": (5.35, 0.02)},
    "fig4_5_d2": {"orbit_before_mm.mb1": (0.84, 0.02), "first_contact_cycle": (5.20, 0.02)},
    "fig4_12": {"last_contact_cycle": (10.1, 0.1)},
    "fig4_14": {
        "contact_share.3": (0.87, 0.03),
        "peak_contact_force_N.rb1": (5300.0, 265.0),
        "peak_contact_force_N.rb2": (3900.0, 195.0),
    },
}


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.slow) if name.startswith("fig3") else name for name in PROTOTYPE]
)
def test_a_run_agrees_with_the_prototype(name):
    for key, (value, tolerance) in PROTOTYPE[name].items():
        found = result_of(name).summary.as_dict()
        for part in key.split("."):
            found = found[part]
        unit = 1e3 * CLEARANCE if "_mm" in key else 1.0
        assert found / unit == pytest.approx(value, abs=tolerance), key


def test_orbit_before_contact_grows_with_the_unbalance():
    """1.75 of the clearance with the stated unbalances would be 1.75 x 0.55 with those of `fig4_5_scaled`."""
    orbit = result_of("fig4_5_scaled").summary.as_dict()["orbit_before_mm"]["mb1"]
    assert 1e-3 * orbit / CLEARANCE == pytest.approx(1.75 * 0.55, abs=0.003)


@pytest.mark.parametrize(
    ("name", "law"),
    [
        ("rolling_90", NEWTON),
        pytest.param("rolling_220", NODAL, marks=pytest.mark.slow),
        pytest.param("fig4_18", NODAL, marks=pytest.mark.slow),
        pytest.param("fig4_20", NEWTON, marks=pytest.mark.slow),
    ],
)
def test_strong_friction_ends_in_rolling_at_its_whirl_speed(name, law):
    """Backward whirl at (R_s/C_r) Omega at both bearings, which outlasts the unbalance that began it."""
    result = result_of(name, rotor_contact__contact__impact_law=law)
    whirl = -RATIO * result.dataset.attrs["speed_rad_s"]
    assert result.summary.as_dict()["whirl_speed_rad_s"] == pytest.approx({"rb1": whirl, "rb2": whirl}, rel=1e-4)
    assert result.summary.recovery in (None, "rolled")


def radii_at(result, hertz):
    """Radius at MB1 over the clearance where the speed first has these values."""
    d = result.dataset
    speeds = d["Omega"].values / (2.0 * np.pi)
    r = np.hypot(*(d[f"rotor_contact.mb1.{axis}"].values for axis in "xy")) / CLEARANCE
    return np.array([r[int(np.argmin(np.abs(speeds - speed)))] for speed in hertz])


@pytest.mark.slow
def test_run_up_is_trapped_where_run_down_is_free():
    """Two critical speeds, the second with contact: on the way up the rotor keeps it to 30 Hz, on the way down not."""
    up, down = result_of("run_up"), result_of("run_down")
    speeds = (24.0, 26.0, 29.0)
    assert np.all(radii_at(up, speeds) > 0.99)
    assert np.all(radii_at(down, speeds) < 0.96)
    for result in (up, down):
        first, between = radii_at(result, (12.5, 15.8))
        assert first > 1.3 * between  # 12.5 Hz is the first critical speed


@pytest.mark.slow
def test_run_up_with_rolac_passes_both_critical_speeds_without_contact():
    pid, rolac = result_of("run_up"), result_of("run_up_rolac")
    assert pid.summary.first_contact is not None
    assert rolac.summary.first_contact is None
    assert radii_at(rolac, [12.5]) < 0.3 * radii_at(pid, [12.5])


def amplitudes(result, n, name):
    """Complex synchronous amplitudes of the eight sensors, or forces of the four axes, at a sample."""
    ends = [(f"{mb}.u_{a}", f"{mb}.u_phase_{a}") for mb in SIDES for a in "xy"]
    if name == "displacement":
        ends = [(f"amplitude.s{k}", f"phase.s{k}") for k in range(1, 9)]
    d = result.dataset
    size, phase = (np.array([d[f"rolac_controller.{end[k]}"].values[n] for end in ends]) for k in (0, 1))
    return size * np.exp(1j * phase)


@pytest.mark.parametrize(
    "name", ["fig6_8", *(pytest.param(name, marks=pytest.mark.slow) for name in ("fig6_6", "fig6_10"))]
)
def test_rolac_reaches_the_optimum_of_the_identified_receptance(name):
    """The eight synchronous amplitudes fall to the least-squares optimum min |Q_0 + R U|, below a quarter of Q_0."""
    result = result_of(name)
    assert result.summary.first_contact is None
    before = int(np.searchsorted(result.dataset["cycle"].values, 5.0)) - 1
    q_0, q = (amplitudes(result, n, "displacement") for n in (before, -1))
    axes = [f"{mb}_{a}" for mb in SIDES for a in "xy"]
    parts = [
        [[result.dataset[f"rolac_controller.r.s{k}.{a}.{part}"].values[-1] for a in axes] for k in range(1, 9)]
        for part in ("re", "im")
    ]
    R = np.array(parts[0]) + 1j * np.array(parts[1])
    optimum = q_0 - R @ np.linalg.lstsq(R, q_0, rcond=None)[0]
    assert np.linalg.norm(amplitudes(result, before, "force")) == 0.0
    assert np.linalg.norm(q) == pytest.approx(np.linalg.norm(optimum), rel=0.06)  # with noise, and a twentieth left
    assert np.linalg.norm(q) < 0.25 * np.linalg.norm(q_0)
    assert np.linalg.norm(q_0 + R @ amplitudes(result, -1, "force") - q) < 0.03 * np.linalg.norm(q_0)


@pytest.mark.parametrize("factor", [1.4, 1.7])
def test_contact_aware_rolac_frees_a_rotor_that_rolac_traps(factor):
    scenario = load_scenario("fig5_6").changed(unbalance_factor=factor)
    rolac, aware = (
        amb_cosim.run(scenario, set={key.replace("__", "."): value for key, value in settings.items()}, progress=False)
        for settings in ({}, AWARE)
    )
    assert (rolac.summary.recovery, aware.summary.recovery) == ("trapped", "recovered")


def test_figure_5_6_is_as_the_thesis_describes_it():
    """RB1 touches first, then RB2, for less than two cycles, with H of the model and identified; PID is trapped."""
    from amb_analysis import studies

    scenario = load_scenario("fig5_6")
    table = studies.identify([scenario.initial_speed], scenario=scenario, progress=False).table
    for run in (scenario, scenario.changed(receptances=table)):
        signals = amb_cosim.run(run, progress=False).signals
        assert run_quantities.outcome(signals) == "recovered"
        assert run_quantities.first_site(signals) == "RB1"
        assert run_quantities.sites_touched(signals) == "RB1 and RB2"
        assert 1.0 < run_quantities.contact_duration(signals) < 2.0
    assert result_of("fig5_6_pid").summary.recovery == "trapped"


FORCES_N = {
    "fig6_13": {"mb1.u": 544.0, "mb2.u": 544.0},
    "fig6_15": {"mb1.u": 800.6, "mb2.u": 800.6},
    "fig6_18": {"mb1.u": 650.0},
}


@pytest.mark.parametrize("name", FORCES_N)
def test_unbalances_at_the_bearings_are_the_forces_of_the_thesis(name):
    """F = u Omega^2."""
    scenario = load_scenario(name)
    (step,) = scenario.event
    forces = {
        variable: quantity(value, "kg.m", variable) * scenario.initial_speed**2
        for variable, value in step.set["rotor_contact"].items()
    }
    assert forces == pytest.approx(FORCES_N[name], rel=1e-3)
