"""Names with * and ? in a system: one file for rotors with any number of bearings."""

from dataclasses import replace

import pytest
from interfaces import of_reals

from amb_cosim.cosim.system.patterns import expand
from amb_cosim.cosim.system.system import Component, Connection, Signal, System
from tests.support.messages import raises_naming


def interfaces(bearings):
    axes = [f"{b}.{a}" for b in bearings for a in "xy"]
    return {
        "magnet": of_reals(axes, [f"{b}.f_{a}" for b in bearings for a in "xy"], [f"{b}.gap" for b in bearings]),
        "rotor": of_reals([*(f"{b}.f_{a}" for b in bearings for a in "xy"), "disc.f_x"], [*axes, "probe.x"]),
    }


SYSTEM = System(
    "pair",
    "",
    (Component("magnet", "magnet", mandatory=("*.[xy]",)), Component("rotor", "rotor")),
    (Connection("rotor.*.[xy]", "magnet.*.[xy]"), Connection("magnet.*.f_[xy]", "rotor.*.f_[xy]")),
    parameters={"magnet": {"*.gap": 1.0, "*.k_s": 2.0}},
)


@pytest.mark.parametrize("bearings", [("front",), ("mb1", "mb2"), ("a", "b", "c")])
def test_a_pattern_connects_what_both_components_have(bearings):
    result = expand(SYSTEM, interfaces(bearings))
    links = {(link.source, link.target) for link in result.connections}
    expected = {(f"rotor.{b}.{a}", f"magnet.{b}.{a}") for b in bearings for a in "xy"}
    expected |= {(f"magnet.{b}.f_{a}", f"rotor.{b}.f_{a}") for b in bearings for a in "xy"}
    assert links == expected  # neither disc.f_x, which the magnet does not drive, nor probe.x, which it does not read
    assert set(result.component("magnet").mandatory) == {f"{b}.{a}" for b in bearings for a in "xy"}
    result.check(interfaces(bearings))


def test_a_named_connection_and_a_signal_come_before_a_pattern():
    named = (*SYSTEM.connections, Connection("rotor.probe.x", "magnet.mb1.x"))
    signal = Signal("load", ("rotor.mb2.f_y",))
    result = expand(replace(SYSTEM, connections=named, signals=(signal,)), interfaces(("mb1", "mb2")))
    assert result.source_of("magnet.mb1.x") == "rotor.probe.x"
    assert result.source_of("magnet.mb1.y") == "rotor.mb1.y"
    assert result.source_of("rotor.mb2.f_y") is None


def test_inputs_may_have_an_ending_that_outputs_lack():
    added = replace(SYSTEM, connections=(Connection("rotor.*.x", "magnet.*.x.added"),))
    ports = interfaces(("a", "b"))
    ports["magnet"] = of_reals(["a.x.added", "b.x.added", "c.x.added"], [])
    ends = expand(replace(added, components=(*SYSTEM.components[1:], Component("magnet", "magnet"))), ports)
    assert {(c.source, c.target) for c in ends.connections} == {(f"rotor.{b}.x", f"magnet.{b}.x.added") for b in "ab"}


def test_a_parameter_whose_pattern_matches_nothing_is_left_out():
    assert expand(SYSTEM, interfaces(("mb1",))).parameters == {"magnet": {"*.gap": 1.0}}


@pytest.mark.parametrize(
    ("change", "facts"),
    [
        ({"connections": (Connection("rotor.q?", "magnet.q?"),)}, ("rotor", "q?")),
        ({"connections": (Connection("rotor.*.x", "magnet.*.y"),)}, ("patterns",)),
        ({"connections": (Connection("roter.*", "magnet.*"),)}, ("roter", "rotor")),
        ({"components": (Component("magnet", "m", mandatory=("i?",)), Component("rotor", "r"))}, ("input i?",)),
    ],
)
def test_a_pattern_that_cannot_be_meant_is_refused(change, facts):
    with raises_naming(ValueError, *facts):
        expand(replace(SYSTEM, **change), interfaces(("mb1",)))
