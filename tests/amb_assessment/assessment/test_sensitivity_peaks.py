"""Peaks of the sensitivity: those of the curve, and above the frequencies of ISO 14839-3 too."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from amb_analysis.linear.loop import Loop, diagonal_response
from amb_analysis.machine.coupled import coupled_loop
from amb_assessment.assessment.analyses.sensitivity import sensitivities
from amb_assessment.assessment.criteria import load_criteria
from amb_assessment.assessment.findings import Judgement, Quantity, judge
from amb_assessment.assessment.machine_file import load_machine
from amb_assessment.assessment.stages import real_coefficients
from amb_assessment.assessment.subject import subject_of

BLOWER = Path(__file__).parent / "blower" / "machine.toml"


def loop_of(machine):
    subject = subject_of(load_machine(machine))
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


def test_a_mode_above_2_khz_has_its_own_peak():
    """The turbo-expander at its least speed: zone A up to 2 kHz, and 34 at 4.6 kHz, where a mode is hardly damped."""
    loop, speed = loop_of("turbo_expander")
    below, above = np.moveaxis(np.array([axis.peaks for axis in sensitivities(loop, speed.lowest)]), 1, 0)
    assert below[:, 0].max() == pytest.approx(2.68, abs=0.01)
    assert above[:, 0].max() == pytest.approx(33.7, rel=0.01)
    assert above[:, 1] == pytest.approx(4627.0, abs=1.0)
    item = Quantity("sensitivity_peak_beyond", "far_end.x", float(above[:, 0].max()), "1")
    (found,) = judge([item], load_criteria(["physics"]), {})
    assert found.verdict is Judgement.MISSED
