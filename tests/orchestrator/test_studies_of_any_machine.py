"""Studies answer for the machine that they are given, not for the rig: its names, clearances, currents and sensors."""

from dataclasses import replace

import numpy as np
import pytest
from machines import machine

from amb_analysis.linear.linear_source import LinearSource
from amb_analysis.linear.loop import Loop
from amb_analysis.machine.machine import Machine
from amb_analysis.measured.records import Channel, FrequencyResponse, Measurement
from amb_cosim import studies
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.scenario import load_scenario
from rotor_analysis.damping import Damping
from rotor_analysis.parts import Site
from tests.support.messages import assert_names, raises_naming

COMPRESSOR = "compressor_levitated"
PROBES = (("1.x", 1.0), ("2.x", 1.1))


def test_unbalance_is_compared_with_the_clearance_of_each_place():
    """Three bearings with retainers, a seal of another clearance, and shaft ends without a site."""
    names, nodes, gaps = ("rb1", "seal1", "rb2", "rb3"), (2, 6, 12, 24), (0.2e-3, 0.35e-3, 0.2e-3, 0.25e-3)
    sites = tuple(Site(n, node, gap) for n, node, gap in zip(names, nodes, gaps, strict=True))
    result = studies.unbalance_response(machine(sites=sites).on_equal_bearings(2e7, 2e4), unbalance="1 g.m")
    clearances = {name: place.clearance for name, place in result.places.items()}
    assert clearances == {
        "end at z = 0 m": None, "mb1": 0.2e-3, "seal1": 0.35e-3, "mb2": 0.2e-3, "mb3": 0.25e-3, "end at z = 2.4 m": None
    }  # fmt: skip
    top = np.max(result.places["seal1"].amplitude)
    (row,) = (line for line in str(result).splitlines() if line.startswith("seal1"))
    assert float(row.split()[2]) == pytest.approx(top / 0.35e-3, abs=1e-3)
    assert studies.unbalance_response(machine(), clearance="1 mm").places["mb2"].clearance == 1e-3


def test_axis_has_the_currents_and_the_clearance_of_its_machine():
    """Each axis has its static current, and moves within the clearance of its bearing's retainer."""
    changes = {"amb_actuator.mb2.static_current_y": "2 A", "rotor_contact.td2.clearance": "0.1 mm"}
    first = studies.linearisation(COMPRESSOR, set=changes)
    other = studies.linearisation(COMPRESSOR, axis="mb2.y", set=changes)
    assert (first.axis, first.bias_current, first.static_current) == ("mb1.x", 5.0, 1.5)
    assert (other.axis, other.bias_current, other.static_current) == ("mb2.y", 5.0, 2.0)
    assert [axis.map.x[-1] for axis in (first, other)] == pytest.approx([0.25e-3, 0.1e-3])
    assert first.k_i / other.k_i == pytest.approx((2.0 * 5.0 + 1.5) / (2.0 * 5.0 + 2.0))  # (2.9)


def test_an_unknown_axis_is_refused_with_the_existing_axes():
    with raises_naming(ValueError, "axis", "mb3.x", "mb2.x"):
        studies.linearisation(COMPRESSOR, axis="mb3.x")
    with raises_naming(ValueError, "set", "scenario"):
        studies.linearisation(set={"amb_actuator.force_law": 0})


def test_loop_without_magnetic_bearings_has_no_sensitivity():
    with raises_naming(ValueError, "'amb_actuator'"):
        studies.sensitivity("compressor_touchdown")
    with raises_naming(ValueError, "amb_actuator"):
        studies.linearisation("compressor_touchdown")


def is_stable(machine, late):
    """Return whether the loop of a machine's runs is stable with currents that are late by a share of a sample."""

    class Late(LinearSource):
        def parts(self, names):
            shares = [late if name == "rolac_controller" else 0.0 for name in names]
            return [replace(part, late=part.late + a) for part, a in zip(super().parts(names), shares, strict=True)]

    source = machine.run_components
    return Loop(Late(source.plan, source.point)).poles(machine.Omega).stability.is_stable


@pytest.mark.slow
def test_orders_of_the_master_are_compared_on_any_scenario():
    """A delay of 8 us destabilises the loop of a compressor's run, whose poles agree; prediction removes it."""
    row_of = {(row.order, round(1e6 * row.step)): row for row in studies.coupling(COMPRESSOR).rows}
    assert row_of["Gauss-Seidel", 20].deviation < 1e-4
    assert row_of["Jacobi", 50].outcome == "trapped"
    compressor = Machine(prepare_run(load_scenario(COMPRESSOR)))
    for order, step, late in (("Gauss-Seidel", 100, 0.0), ("Jacobi", 10, 0.2), ("Jacobi", 4, 0.08)):
        assert row_of[order, step].outcome == ("prevented" if is_stable(compressor, late) else "unstable")
    assert not is_stable(compressor, 0.08)
    predicting = row_of["Jacobi, predicting", 10]
    assert (predicting.outcome, predicting.deviation < 1e-3) == ("prevented", True)


@pytest.mark.usefixtures("few_speeds")
def test_a_response_needs_a_stable_loop():
    """Gains of the other sign push the rotor away; the message says how it moves."""
    values = {"rolac_controller.mb?.k_b_?": -1e6}
    for study, arguments in (
        (studies.unbalance_response, {"up_to": "500 rad/s"}),
        (studies.response, {"inputs": ["mb1.f_x"], "outputs": ["mb1.x"]}),
    ):
        with raises_naming(ValueError, "not stable", "|z|", "rpm"):
            study(scenario=COMPRESSOR, set=values, **arguments)


@pytest.mark.slow
def test_peaks_of_a_machine_do_not_depend_on_the_range():
    whole, part = (studies.unbalance_response(scenario=COMPRESSOR, up_to=f"{top} rad/s") for top in (2000, 700))
    assert part.critical_speeds
    for a, b in zip(whole.critical_speeds, part.critical_speeds, strict=False):
        assert (a.place, a.speed) == (b.place, pytest.approx(b.speed, rel=0.01))
        assert a.amplitude == pytest.approx(b.amplitude, rel=2e-3)
        assert a.amplification == pytest.approx(b.amplification, rel=0.02)


def test_an_undamped_peak_is_reported_as_unbounded():
    """Stiff bearings without damping: the tables print this and not a value that is due to rounding."""
    result = studies.unbalance_response(machine().on_equal_bearings(2e7, 0.0), unbalance="1 g.m")
    assert any(not item.is_bounded for item in result.critical_speeds)
    assert_names(str(result), "no bound", "nothing damps the motion")


def test_largest_frequency_response_does_not_depend_on_the_range():
    """Of a rotor on its bearings, between a force and the motion there: peaks do not shrink as the range grows."""
    channels = {"inputs": ["impeller3.f_x"], "outputs": ["seal.x"], "loop": "linear", "speed": "500 rad/s"}
    peaks = []
    for top in ("200 Hz", "5 kHz"):
        (curve,) = studies.response(rotor="compressor", up_to=top, **channels).responses.values()
        within = curve.frequencies <= 200.0
        peaks.append(np.abs(curve.computed[within]).max())
    assert peaks[0] == pytest.approx(peaks[1], rel=2e-3)


def test_two_measurements_of_one_response_are_both_compared():
    """Two probes of one place, of which one reads 10 % too much."""
    f, names = np.linspace(10.0, 100.0, 91), {"1.x": "seal.x", "2.x": "seal.x"}
    exact = studies.response(rotor="compressor", inputs=["impeller3.f_x"], outputs=["seal.x"], up_to="200 Hz")
    (curve,) = exact.responses.values()
    values = np.interp(f, curve.frequencies, curve.computed.real) + 0j
    both = (FrequencyResponse(Channel(n, "m"), Channel("impeller3.f_x", "N"), f, k * values) for n, k in PROBES)
    named = (replace(r, output=r.output.renamed(names)) for r in both)
    result = studies.response(rotor="compressor", measured=Measurement(tuple(named)))
    first, second = result.responses.values()
    assert second.measured == pytest.approx(1.1 * first.measured)


def test_an_undamped_resonance_is_reported_as_unbounded():
    rotor = replace(machine().on_equal_bearings(2e7, 0.0), damping=Damping())
    result = studies.response(rotor=rotor, loop="linear", inputs=["impeller1.f_x"], outputs=["seal1.x"])
    assert_names(str(result), "no bound")
