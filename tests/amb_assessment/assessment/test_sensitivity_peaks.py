"""Peaks of the sensitivity: those of the curve, and above the frequencies of ISO 14839-3 too."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from amb_analysis.linear.loop import Loop
from amb_analysis.linear.responses import diagonal_response, disk_margin, response
from amb_analysis.machine.coupled import MachineVariation, coupled_loop
from amb_analysis.studies.stability_margin import _all_loops
from amb_assessment.assessment.analyses import robustness, sensitivity
from amb_assessment.assessment.analyses.sensitivity import AxisPeaks, sensitivities
from amb_assessment.assessment.engine.findings import Judgement, judge
from amb_assessment.assessment.format.criteria import load_criteria
from amb_assessment.assessment.format.machine_file import load_machine
from amb_assessment.assessment.format.quantities import Quantity
from amb_assessment.assessment.physics import stages
from amb_assessment.assessment.physics.assessed_machine import assessed_machine_of
from amb_assessment.assessment.physics.axial_cases import load_cases
from amb_assessment.assessment.physics.stages import real_coefficients
from amb_cosim.results.loop_stability import LoopStability

BLOWER = Path(__file__).parent / "blower" / "machine.toml"


def loop_of(machine, modes=None):
    subject = assessed_machine_of(load_machine(machine), modes=modes)
    return coupled_loop(subject, real_coefficients(subject)), subject.file.speed


@pytest.mark.parametrize("machine", ["turbo_expander", BLOWER])
def test_peaks_are_those_of_many_frequencies_below_and_above_2_khz(machine):
    loop, speed = loop_of(machine)
    system = Loop(loop.linear_components.at(speed.lowest)).sensitivity()
    result = sensitivities(loop, speed.lowest)
    for band, ends in enumerate(((1.0, 2000.0), (2000.0, 0.5 / system.dt))):
        S = np.abs(diagonal_response(system, np.linspace(*ends, 8000)))
        for axis, row in zip(result, S, strict=True):
            assert axis.peaks[band][0] >= row.max() * (1.0 - 1e-3)


@pytest.mark.parametrize(("machine", "up_to"), [("turbo_expander", "high"), (BLOWER, "low")])
def test_disk_margin_is_the_least_at_any_frequency(machine, up_to):
    """That of many frequencies, closer about the least; it is above 2 kHz for the turbo-expander."""
    loop, speed = loop_of(machine)
    loop = Loop(loop.linear_components.at(speed.highest))
    _, margins = _all_loops(loop, np.geomspace(1.0, 0.5 / loop.sample_time, 300))
    n, wide = len(loop.demands), response(loop.closed, np.linspace(0.0, 0.5 / loop.sample_time, 2000))
    for rows, margin in zip((slice(None, n), slice(n, None)), margins.values(), strict=True):
        close = response(loop.closed, margin.frequency + np.linspace(-5, 5, 201))
        least = min(disk_margin(part[rows, rows]).min() for part in (wide, close))
        assert margin.least == pytest.approx(least, rel=1e-3)
        assert (margin.frequency > 2000.0) == (up_to == "high")


def test_no_gain_within_the_disk_margin_makes_the_loop_unstable():
    """All gains times 1.14 make the turbo-expander unstable: the margin at 2 kHz and below would allow 1.26."""
    subject = assessed_machine_of(load_machine("turbo_expander"))
    loop = Loop(coupled_loop(subject, ()).linear_components.at(subject.file.speed.highest))
    _, margins = _all_loops(loop, np.geomspace(1.0, 0.5 / loop.sample_time, 2000))
    more = coupled_loop(subject, (), MachineVariation(k_i=1.14))
    assert not more.poles(subject.file.speed.highest).stability.is_stable
    assert all(margin.gain < 1.14 for margin in margins.values())


def test_the_axial_loop_has_a_peak_above_2_khz_too():
    for case in load_cases(assessed_machine_of(load_machine("turbo_expander"))):
        ends = (1.0, 2000.0), (2000.0, 0.5 / case.loop.sample_time)
        largest = [np.abs(case.loop.sensitivity(np.linspace(*band, 4000))).max() for band in ends]
        assert [peak for peak, _ in case.peaks] == pytest.approx(largest, rel=1e-3)
        assert case.peaks[1][1] >= 2000.0


def test_a_mode_above_2_khz_has_its_own_peak():
    """The turbo-expander at its least speed: zone A up to 2 kHz, and a peak at 4.6 kHz, where a mode is hardly damped.

    With twenty elastic modes, of which the plant has five, the peaks are the same within what these are damped.
    """
    result = []
    for modes in (None, 20):
        loop, speed = loop_of("turbo_expander", modes)
        peaks = np.array([axis.peaks for axis in sensitivities(loop, speed.lowest)])
        result.append(np.moveaxis(peaks, 1, 0))
    (below, above), (exact_below, exact_above) = result
    assert below[:, 0].max() == pytest.approx(exact_below[:, 0].max(), rel=1e-3)
    assert below[:, 0].max() < 3.0
    assert above[:, 0] == pytest.approx(exact_above[:, 0], rel=0.15)
    assert above[:, 1] == pytest.approx(exact_above[:, 1], rel=2e-3)
    assert above[:, 0].max() > 4.0
    item = Quantity("sensitivity_peak_beyond", "far_end.x", 34.0, "1")
    (found,) = judge([item], load_criteria(["physics"]), {})
    assert found.verdict is Judgement.FAILED


def resonant(loop, Omega):
    """|S| = 4 + 1.2/(1 + ((Omega - 700)/150)^2) of the corner with the most K_i, and 3.9 of all others."""
    height = 4.0 + 1.2 / (1.0 + ((Omega - 700.0) / 150.0) ** 2) if loop.variation.k_i > 1.05 else 3.9
    return [AxisPeaks(np.array([100.0]), np.array([height]), ((height, 100.0),))]


def test_sensitivity_of_the_worst_corner_is_that_between_its_speeds(monkeypatch):
    """5.2 at 700 rad/s, zone D; at the least and the largest speed, 500 and 1000 rad/s, it is 4.4."""
    monkeypatch.setattr(robustness, "sensitivities", resonant)
    monkeypatch.setattr(sensitivity, "sensitivities", resonant)

    def corner(subject, others, variation):
        return SimpleNamespace(variation=variation, axis_names=("left.x",))

    monkeypatch.setattr(robustness, "coupled_loop", corner)
    monkeypatch.setattr(sensitivity, "with_tables", lambda subject, speeds: speeds)
    monkeypatch.setattr(robustness, "speeds_of_run_up", lambda subject, count: np.linspace(0.0, 1050.0, count))
    monkeypatch.setattr(robustness, "real_coefficients", lambda subject: ())
    monkeypatch.setattr(robustness, "least_decrement_over", lambda quantity, *_: Quantity(quantity, "", 0.2, "1"))
    monkeypatch.setattr(robustness, "least_stable", lambda *_: LoopStability(0.99, -100.0, 10.0))
    speed = SimpleNamespace(lowest=500.0, highest=1000.0, tripping=1050.0)
    tolerances = SimpleNamespace(k_i=0.1, k_s=0.0, gap=0.0, modes=0.0)
    result = robustness.result_of(
        SimpleNamespace(file=SimpleNamespace(speed=speed, tolerances=tolerances, highest_frequency=1e3))
    )
    (worst,) = [item for item in result.quantities if item.quantity == "sensitivity_varied"]
    assert worst.value == pytest.approx(5.2, rel=1e-3)
    assert worst.where.startswith("K_i 1.1")
    assert "5.20" in {row[-1] for row in result.tables[0].rows}


def test_sensitivity_over_speed_includes_the_entries_of_tables(monkeypatch):
    """|S| is 9 at 812 rad/s alone, an entry of a seal between operating speeds, and 2 elsewhere."""

    def narrow(loop, Omega):
        height = 9.0 if Omega == 812.0 else 2.0
        return [AxisPeaks(np.array([100.0]), np.array([height]), ((height, 100.0),))]

    monkeypatch.setattr(sensitivity, "sensitivities", narrow)
    monkeypatch.setattr(stages, "real_coefficients", lambda subject: ())
    speed = SimpleNamespace(lowest=500.0, highest=1000.0)
    machine = SimpleNamespace(file=SimpleNamespace(speed=speed), table_speeds=(300.0, 812.0, 1200.0))
    found = sensitivity.sensitivities_over(machine, SimpleNamespace())
    assert found[812.0][0].peaks[0][0] == 9.0
    assert min(found) == 500.0
    assert max(found) == 1000.0
