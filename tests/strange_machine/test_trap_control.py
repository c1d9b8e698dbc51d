"""Verdicts of the study of traps on what control can do within the currents that coils and voltage allow."""

import math

import pytest
from strange_machine import LEVITATION

from amb_analysis.steady_contact.rubbing_rotor import rubbing_rotor
from amb_analysis.steady_contact.trap_map import states_at
from amb_analysis.studies.contact_traps import _with_unbalance
from amb_analysis.studies.trap_control import control_of
from amb_analysis.studies.trap_states import allowed_current, report_state
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.scenario import as_scenario

RESISTANCE, INDUCTANCE, BIAS, STATIC = 0.5, 4e-3, 3.0, 0.85  # Ohm, H, A, A of north.y, which carries the most


@pytest.fixture(scope="module", params=[("ideal", 12.0), ("dynamic", 12.0)])
def machine(request):
    """The expander with amplifiers, and their voltage (V)."""
    amplifier, voltage = request.param
    settings = {"amb_actuator.amplifier": amplifier, "amb_actuator.*.voltage_limit_?": voltage}
    return rubbing_rotor(prepare_run(as_scenario(LEVITATION, None), settings)), amplifier, voltage


def test_the_voltage_of_the_amplifiers_limits_the_synchronous_current(machine):
    """R (I_b + I_s) + I |R + i Omega L| = V: 1.6 A with 12 V. Otherwise the bias current limits."""
    rotor, amplifier, voltage = machine
    reactance = abs(RESISTANCE + 1j * rotor.Omega * INDUCTANCE)
    possible = (voltage - RESISTANCE * (BIAS + STATIC)) / reactance if amplifier == "dynamic" else math.inf
    assert allowed_current(rotor, "north", rotor.Omega) == pytest.approx(min(possible, BIAS))
    assert allowed_current(rotor, "north", 0.0) == pytest.approx(BIAS)


@pytest.mark.parametrize(("unbalance", "needed"), [(10e-6, 0.85), (20e-6, 1.70), (40e-6, 3.40)])
def test_synchronous_control_holds_the_rotor_free_within_its_limits_alone(machine, unbalance, needed):
    """The current that cancels the motion is proportional to the unbalance."""
    rotor = _with_unbalance(machine[0], unbalance, None)
    Omega = rotor.Omega
    verdict = control_of(rotor, Omega, (), [])["synchronous control"]
    north = verdict.currents["north"]
    assert north.amplitude == pytest.approx(needed, rel=0.03)
    assert verdict.frees == (needed <= north.allowed)
    assert verdict.words.startswith(
        "can hold the rotor free" if verdict.frees else "cannot hold the rotor free within its limits"
    )


def test_feedback_whose_currents_exceed_their_limits_does_not_free(machine):
    """20 g mm needs 0.214 A of the feedback, beyond a limit of 0.1 A of its demands."""
    rotor = _with_unbalance(machine[0], 20e-6, None)
    limited = rubbing_rotor(prepare_run(as_scenario(LEVITATION, None), {"rolac_controller.*.i_max_?": 0.1}))
    states = states_at(rotor, rotor.Omega)
    verdicts = [
        control_of(rotor, rotor.Omega, tuple(report_state(state, limits, rotor.Omega) for state in states), [])
        for limits in (rotor, limited)
    ]
    enough, beyond = (verdict["feedback alone"] for verdict in verdicts)
    assert enough.frees
    assert enough.words.startswith("free (no stable steady contact)")
    assert not beyond.frees
    assert beyond.words.startswith("free only with currents beyond its limits")
