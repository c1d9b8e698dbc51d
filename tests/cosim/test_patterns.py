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
def test_a_pattern_connects_the_variables_of_both_components(bearings):
    result = expand(SYSTEM, interfaces(bearings))
    links = {(link.source, link.target) for link in result.connections}
    expected = {(f"rotor.{b}.{a}", f"magnet.{b}.{a}") for b in bearings for a in "xy"}
    expected |= {(f"magnet.{b}.f_{a}", f"rotor.{b}.f_{a}") for b in bearings for a in "xy"}
    assert links == expected  # neither disc.f_x, which the magnet does not drive, nor probe.x, which it does not read
    assert set(result.component("magnet").mandatory) == {f"{b}.{a}" for b in bearings for a in "xy"}
    result.check(interfaces(bearings))


def test_explicit_connections_and_signals_take_precedence_over_patterns():
    named = (*SYSTEM.connections, Connection("rotor.probe.x", "magnet.mb1.x"))
    signal = Signal("load", ("rotor.mb2.f_y",))
    result = expand(replace(SYSTEM, connections=named, signals=(signal,)), interfaces(("mb1", "mb2")))
    assert result.source_of("magnet.mb1.x") == "rotor.probe.x"
    assert result.source_of("magnet.mb1.y") == "rotor.mb1.y"
    assert result.source_of("rotor.mb2.f_y") is None


def test_inputs_may_have_a_suffix_that_outputs_lack():
    added = replace(SYSTEM, connections=(Connection("rotor.*.x", "magnet.*.x.added"),))
    ports = interfaces(("a", "b"))
    ports["magnet"] = of_reals(["a.x.added", "b.x.added", "c.x.added"], [])
    ends = expand(replace(added, components=(*SYSTEM.components[1:], Component("magnet", "magnet"))), ports)
    assert {(c.source, c.target) for c in ends.connections} == {(f"rotor.{b}.x", f"magnet.{b}.x.added") for b in "ab"}


def test_a_parameter_pattern_without_a_match_is_ignored():
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
def test_an_invalid_pattern_is_refused(change, facts):
    with raises_naming(ValueError, *facts):
        expand(replace(SYSTEM, **change), interfaces(("mb1",)))
