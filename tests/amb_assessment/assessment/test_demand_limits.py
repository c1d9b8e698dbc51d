"""The largest amplitude of a control current: the least of controller, DAC, coils and voltage decides."""

import math

import pytest

from amb_analysis.machine.axis_capability import current_amplitude
from amb_analysis.machine.demand_limits import control_amplitude, demand_amplitude
from amb_assessment.assessment.analyses import envelope
from amb_assessment.assessment.format.machine_file import load_machine
from amb_assessment.assessment.physics.assessed_machine import assessed_machine_of
from tests.amb_assessment.assessment.test_stability import BLOWER

AXIS = ("amb_a", "y")


def blower(angle="225 deg", **controller):
    """Return the blower with parameters of its controller."""
    file = load_machine(BLOWER / "machine.toml")
    parameters = {**file.parameters, "rolac_controller": controller}
    return assessed_machine_of(file.model_copy(update={"gravity_angle": angle, "parameters": parameters}))


def with_law_limits(low, high, **others):
    return blower(**{"amb_a.i_y.lower": low, "amb_a.i_y.upper": high}, **others)


@pytest.mark.parametrize(("low", "high", "amplitude"), [(-0.5, 2.0, 0.5), (-2.0, 0.25, 0.25), (0.5, 2.0, 0.0)])
def test_the_nearer_limit_of_a_law_ends_the_amplitude(low, high, amplitude):
    machine = with_law_limits(low, high)
    assert demand_amplitude(machine, *AXIS) == amplitude
    assert demand_amplitude(machine, "amb_b", "x") == pytest.approx(1e9)


def test_an_offset_of_the_demand_reduces_the_usable_limits():
    assert demand_amplitude(with_law_limits(-1.0, 2.0, **{"amb_a.i_y.offset": 1.5}), *AXIS) == pytest.approx(0.5)


def test_a_dac_in_use_limits_the_demand_to_gain_times_range():
    dac = {"chain.dac_range": 2.0, "chain.amplifier_gain": 0.3, "chain.dac_bits": 4, "chain.preset": "custom"}
    on, off = (blower(**dac, **{"chain.dac": is_on}) for is_on in (True, False))
    assert demand_amplitude(on, *AXIS) == pytest.approx(0.3 * (2.0 - 4.0 / 16.0))  # less the highest of 16 levels
    assert demand_amplitude(off, *AXIS) == pytest.approx(1e9)


def test_coils_and_voltage_limit_a_demand_within_its_controller_limits():
    machine = with_law_limits(-3.0, 3.0)
    for frequency in (1.0, 400.0, 4000.0):
        of_coils = float(current_amplitude(machine.axis(*AXIS), frequency))
        assert float(control_amplitude(machine, *AXIS, frequency)) == pytest.approx(min(of_coils, 3.0))


def test_a_tenth_of_the_demand_limit_uses_ten_times_its_share():
    def shares(machine):
        found = envelope.result_of(machine).quantities
        return {item.where.split()[0]: item.value for item in found if item.quantity == "current_demand"}

    whole = shares(with_law_limits(-4.0, 4.0))["amb_a.y"]
    demand = 4.0 * whole / 100.0  # of 4 A, which coils carry, too
    tenth = shares(with_law_limits(-demand / 10.0, 1e9))
    assert tenth["amb_a.y"] == pytest.approx(1000.0, rel=0.02)
    assert tenth["amb_a.x"] == pytest.approx(whole, rel=0.05)


def test_axes_that_differ_show_a_limit_each():
    """With 60 V, amb_a.y gives (V - R (I_b + I_s))/|R + i Omega L| at 400 Hz; equal axes show one limit."""
    file = load_machine(BLOWER / "machine.toml")
    weak = file.model_copy(update={"parameters": {**file.parameters, "amb_actuator": {"amb_a.voltage_limit_y": 60.0}}})
    subject = assessed_machine_of(weak)
    curves = {
        item.name: item for item in envelope.result_of(subject).panels[1].curves if item.name.endswith("can give")
    }
    assert list(curves) == ["amb_a.x can give", "amb_a.y can give", "amb_b can give"]
    y, p = curves["amb_a.y can give"], subject.axis(*AXIS)
    Omega = y.x[-1] * math.pi / 30.0
    expected = (60.0 - 0.5 * (4.0 + p.static_current)) / math.hypot(0.5, Omega * 17.4e-3)
    assert y.y[-1] == pytest.approx(expected, rel=1e-6)
    assert y.y[-1] < 0.5 * curves["amb_a.x can give"].y[-1]
