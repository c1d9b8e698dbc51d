"""Warnings of settings and demands without effect, and of no others."""

import pytest
from strange_machine import LEVITATION, TOUCHDOWN

import amb_cosim
from amb_cosim.scenario.scenario import Scenario

LOW = {"rolac_controller.*.i_max_?": "0.6 A", "rolac_controller.*.i_min_?": "-0.6 A"}
SHORT = Scenario.load(LEVITATION).changed(event=[], end_cycle=2, settle_cycles=1)


@pytest.mark.parametrize(
    ("settings", "expected"),
    [
        (
            {"chain.delay": True},
            "rolac_controller.chain.delay = true has no effect while rolac_controller.chain.preset = ideal",
        ),
        ({"chain.preset": "rig", "chain.adc": False}, "rolac_controller.chain.adc = false has no effect"),
        ({"chain.preset": "custom", "chain.delay": True}, None),
        ({"chain.preset": "rig", "chain.delay": True}, None),
        ({"chain.delay": False}, None),
        ({}, None),
    ],
)
def test_an_ineffective_switch_of_the_chain_is_the_first_warning(settings, expected):
    chosen = {f"rolac_controller.{name}": value for name, value in settings.items()}
    warnings = amb_cosim.run(SHORT, set=chosen).summary.warnings
    idle = [warning for warning in warnings if "has no effect while" in warning]
    assert idle == ([] if expected is None else warnings[:1])
    assert expected is None or warnings[0].startswith(expected)


def limited(warnings: list[str]) -> list[str]:
    return [warning for warning in warnings if "current_limited" in warning]


def test_a_demand_while_all_amplifiers_are_off_is_no_warning():
    """All amplifiers go off at cycle 2; the rotor falls out of the reach of 0.6 A after that."""
    fall = Scenario.load(TOUCHDOWN).changed(end_cycle=6)
    result = amb_cosim.run(fall, set=LOW)
    assert result.dataset["rolac_controller.current_limited"].values.any()
    assert limited(result.summary.warnings) == []


def test_a_demand_while_an_amplifier_is_on_is_a_warning():
    event = {"cycle": 2, "set": {"amb_actuator": {"north.amplifier_off_?": True}}}
    fall = Scenario.load(TOUCHDOWN).changed(end_cycle=6, event=[event])
    result = amb_cosim.run(fall, set=LOW)
    assert len(limited(result.summary.warnings)) == 1
