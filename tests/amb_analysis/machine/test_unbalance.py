"""Unbalance of a prepared run: places at one node add up, and events count in the order of time."""

import cmath
from dataclasses import replace

import numpy as np
import pytest

from amb_analysis.machine.machine import machine_of
from amb_analysis.machine.response import synchronous_response
from amb_cosim import studies
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.scenario import load_scenario
from rotor_analysis.parts import Body
from rotor_analysis.rotor_file import load_rotor

RING = "ring"


def with_ring(**fields):
    """The levitated compressor with a light ring on the plane of an impeller, `impeller2`."""
    rotor = load_rotor("compressor")
    ring = Body(RING, rotor.node_of("impeller2"), 1e-6, 1e-9, 1e-9, unbalance=True)
    return load_scenario("compressor_levitated").changed(rotor=replace(rotor, bodies=(*rotor.bodies, ring)), **fields)


ELSEWHERE = {"impeller3.u": 0.0}


def of(place, u, phi=0.0):
    return {f"{place}.u": u, f"{place}.phi": phi}


def unbalance_of(*event, inputs):
    scenario = with_ring(inputs={"rotor_contact": ELSEWHERE | inputs}, event=list(event))
    machine = machine_of(prepare_run(scenario))
    return machine, machine.unbalanced_points


def test_unbalances_of_places_at_one_node_add_up_as_vectors():
    """3 g m and 4 g m at a right angle are 5 g m at atan(4/3), and excite as one of that amount."""
    machine, at = unbalance_of(inputs={**of("impeller2", 3e-3), **of(RING, 4e-3, np.pi / 2.0)})
    node = machine.rotor.node_of(RING)
    one = 5e-3 * cmath.exp(1j * np.arctan2(4.0, 3.0))
    assert at == {node: pytest.approx(one)}
    both, alone = (synchronous_response(machine, np.array([400.0]), [case]) for case in (at, {node: one}))
    assert both == pytest.approx(alone)


def test_opposite_unbalances_of_one_node_leave_none():
    _, at = unbalance_of(inputs={**of("impeller2", 3e-3), **of(RING, 3e-3, np.pi)})
    assert list(np.abs(list(at.values()))) == pytest.approx([0.0], abs=1e-15)


@pytest.mark.usefixtures("few_speeds")
def test_response_lists_each_place_and_the_sum_of_the_node():
    inputs = {"rotor_contact": {**ELSEWHERE, **of("impeller2", 3e-3), **of(RING, 5e-3)}}
    result = studies.unbalance_response(scenario=with_ring(inputs=inputs, event=[]), up_to="20 rad/s")
    assert result.unbalance == pytest.approx(8e-3)
    assert {name: u.amount for name, u in result.unbalances.items()} == {"impeller2": 3e-3, RING: 5e-3}
    assert "3 g m at impeller2, 5 g m at ring" in str(result)


@pytest.mark.parametrize("reverse", [False, True])
def test_the_last_event_before_the_end_decides_the_unbalance(reverse):
    """Events count by time, not by their order in the file, and those after the end have no effect."""
    moments = {1.0: 1e-3, 2.0: 2e-3, 1e3: 9e-3}
    events = [{"cycle": t, "set": {"rotor_contact": of("impeller2", u)}} for t, u in moments.items()]
    machine, _ = unbalance_of(*(reversed(events) if reverse else events), inputs={})
    assert machine.unbalance["impeller2"] == 2e-3
