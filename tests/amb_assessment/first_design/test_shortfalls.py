"""Reasons of a first design: coils that the unbalance drives to their limits, and magnets with much K_s."""

import math
import re
from dataclasses import replace

import pytest

from amb_analysis.machine.machine import Machine
from amb_assessment.first_design.levitation import Levitation, Pid
from amb_assessment.first_design.loop_search import Peak
from amb_assessment.first_design.rotor_text import plain_shaft, supports
from amb_assessment.first_design.shortfalls import (
    advice,
    high_voltage,
    loop_shortfalls,
    saturating_axes,
    soft_bearings,
)
from amb_assessment.first_design.sizing import MU_0, machine_sizes
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.scenario import load_scenario
from rotor_analysis.parts import Body
from rotor_analysis.rotor import Rotor
from rotor_analysis.rotor_file import load_rotor
from rotor_analysis.shaft import Shaft
from tests.support.messages import assert_names

SLOW = 0.1  # rad/s: the rotor follows the rotating force as a static one
Z_MB1, Z_MB2, Z_DISC = 0.624, 1.321, 0.455  # m
K_B, K_S, K_I = 1e6, 2e6, 563.0  # closed bearing (N/m), magnet (N/m, N/A)
BIAS = 4.43  # A, the largest control current that keeps current in all coils


OF_MB1, OF_BOTH = ["mb1.x", "mb1.y"], ["mb1.x", "mb1.y", "mb2.x", "mb2.y"]


@pytest.mark.parametrize(("share", "saturating"), [(0.99, []), (1.01, OF_MB1), (6.0, OF_BOTH)])
def test_unbalance_that_saturates_the_coils_is_a_shortfall(share, saturating):
    """F_1 = u Omega^2 (z_2 - z_d)/(z_2 - z_1), F_2 = u Omega^2 - F_1, |i| = (K_b + K_s)/(K_i K_b) |F|."""
    levers = {"mb1": (Z_MB2 - Z_DISC) / (Z_MB2 - Z_MB1), "mb2": (Z_MB1 - Z_DISC) / (Z_MB2 - Z_MB1)}
    u = share * BIAS * K_I * K_B / (K_B + K_S) / (levers["mb1"] * SLOW**2)
    machine = Machine(prepare_run(load_scenario("fig4_9").machine(), {"rotor_contact.d2.u": u}))
    reasons = list(saturating_axes(machine, SLOW))
    assert len(reasons) == len(saturating)
    for axis, reason in zip(saturating, reasons, strict=True):
        demand = BIAS * share * abs(levers[axis[:3]]) / levers["mb1"]
        assert_names(reason, axis, f"{demand:.3g} A", "4.43 A", "1 rpm")


@pytest.mark.parametrize(("peak", "name"), [(2.999, "A"), (3.0, "B"), (5.0, "D"), (math.inf, "D")])
def test_zones_of_a_design_begin_at_their_limits(peak, name):
    """ISO 14839-3: A below 3, B below 4, C below 5."""
    assert Levitation(0.1, 0.1, 0.1, 1.0, 1.0, Peak(peak), Peak(1.0), (0.1, 0.02, 0.002)).zone == name


def test_bearings_softer_than_their_magnets_require_are_a_shortfall():
    """Three bearings with net stiffnesses of 0.58, 0.72 and 0.53 of their K_s, where 0.7 is required."""
    k_s = {"top": 5e6, "mid": 7e6, "low": 6e6}
    shares = {"top": 0.58, "mid": 0.72, "low": 0.53}
    pid = Pid({name: shares[name] * k_s[name] for name in k_s}, dict.fromkeys(k_s, 5e3), 1e-5)
    (reason,) = soft_bearings(pid, k_s)
    assert_names(reason, "top 0.58", "low 0.53", "0.7", "bias current", "gap")
    assert "mid" not in reason
    assert not list(soft_bearings(Pid(k_s, pid.c_b, 1e-5), k_s))


@pytest.mark.parametrize(("mass", "length", "rpm"), [(5e4, 8.0, 3000.0), (1500.0, 3.2, 6000.0)])
def test_voltage_beyond_industrial_amplifiers_is_a_shortfall(tmp_path, mass, length, rpm):
    """Coils with the advised turns, bias and limit have the same flux, and the voltage of their own inductance."""
    file, speed = tmp_path / "rotor.toml", rpm * math.pi / 30.0
    file.write_text(plain_shaft("motor", mass, length, speed))
    file.write_text(file.read_text() + supports(load_rotor(file), None))
    sizes = machine_sizes(load_rotor(file), speed)
    reasons = list(high_voltage(sizes))
    assert len(reasons) == (mass > 1e4)
    for reason in reasons:
        advice = re.search(r"; for .* (\S+) V .* (\d+) turns, a bias of (\S+) A .* (\S+) A", reason)
        U, N, bias, limit = (float(value) for value in advice.groups())
        assert N * bias == pytest.approx(sizes.turns * sizes.bias_current, rel=0.01)
        inductance = 2.0 * MU_0 * N**2 * sizes.pole_area / sizes.gap
        resistance = sizes.resistance * (N / sizes.turns) ** 2  # of coils with the same copper
        assert pytest.approx(2.0 * resistance * limit + 2.0 * inductance * bias * speed, rel=0.01) == U
        assert U <= 600.0
        assert U * (N + 1.0) / N > 600.0  # with one turn more
        assert_names(reason, f"{sizes.voltage_limit:.0f} V", f"{sizes.turns} turns", "600 V", f"{rpm:.0f} rpm")


@pytest.mark.parametrize(("share", "facts"), [(0.98, ("nutation", "I_p/I_d = 1.5 ")), (2.5, ("bends",))])
def test_nutation_of_a_flywheel_is_not_called_bending(share, facts):
    """A rigid disc of I_p = 1.5 I_d on a massless shaft nutates at 1.5 times its speed."""
    shaft = Shaft((0.0, 0.1, 0.2), (0.05,), youngs_modulus=2.1e11, density=0.0, poissons_ratio=0.3)
    flywheel = Rotor("flywheel", shaft, (Body("disc", 2, 20.0, 0.2, 0.3),))
    speed = 3600.0
    growing = Levitation(-0.01, -0.01, -0.01, share * 1.5 * speed, speed, Peak(9.0), Peak(9.0), (0.1, 0.02, 0.002))
    assert_names(advice(flywheel, growing, speed), *facts)


@pytest.mark.parametrize(("damping", "count"), [(0.0201, 0), (0.01999, 0), (0.0197, 1)])
def test_a_damping_that_prints_as_its_target_meets_it(damping, count):
    loop = Levitation(0.2, damping, 0.01, 1.0, 1.0, Peak(2.0), Peak(1.0), (0.1, 0.02, 0.002))
    reasons = list(loop_shortfalls(loop))
    assert len(reasons) == count
    for reason in reasons:
        assert_names(reason, "0.0197", "0.02")


def test_a_motion_that_grows_in_runs_only_is_named_with_its_cure():
    """The real rotor is stable, so its targets are met; its scenarios would end as unstable."""
    loop = Levitation(0.2, 0.1, 0.01, 1.0, 1.0, Peak(2.0), Peak(1.0), (0.1, 0.02, 0.002))
    grows = replace(loop, motion_in_runs="a vibration of 1876 Hz grows at 9450 rpm")
    assert (loop.holds, grows.holds) == (True, False)
    assert grows.lack > loop.lack == 0.0
    (reason,) = loop_shortfalls(grows)
    assert_names(reason, "in runs", "1876 Hz", "9450 rpm", "[reduction]", "band")
