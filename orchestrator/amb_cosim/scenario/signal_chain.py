"""Switches of the controller's signal chain that its preset leaves without effect."""

from __future__ import annotations

from collections.abc import Collection

from amb_cosim.cosim.assignments import Assignments
from amb_cosim.results.places import CONTROLLER

PRESET, CUSTOM = "chain.preset", "custom"
IDEAL, SWITCHES = "ideal", ("noise", "filter", "adc", "dac", "delay")


def idle_switches(values: Assignments, given: Collection[str]) -> list[str]:
    """Return a sentence on switches that were set, and to which the preset of the chain does not listen.

    Under `ideal` no effect is on, under any other preset but `custom` all are: a switch that says otherwise is idle.

    Parameters
    ----------
    given
        Parameters, `component.variable`, that were set.
    """
    controller = values.interfaces.get(CONTROLLER)
    preset = None if controller is None else controller.ports.get(PRESET)
    if preset is None or CUSTOM not in preset.items:
        return []
    name = f"{CONTROLLER}.{PRESET}"
    chosen = next(item for item, number in preset.items.items() if number == values.parameter(name))
    switches = [f"{CONTROLLER}.chain.{effect}" for effect in SWITCHES]
    idle = [s for s in switches if s in given and bool(values.parameter(s)) == (chosen == IDEAL)]
    if chosen == CUSTOM or not idle:
        return []
    told = ", ".join(f"{switch} = {'true' if values.parameter(switch) else 'false'}" for switch in idle)
    return [f"{told} changes nothing while {name} = {chosen}; it counts with {name} = {CUSTOM}"]
