"""Sensitivity, disk margin and poles are those of all elements of the rotor, whatever the reduction of its runs."""

from pathlib import Path

import numpy as np
import pytest

from amb_analysis.linear.linearise import model_of
from amb_analysis.linear.loop import Loop
from amb_analysis.linear.responses import disk_margin, response
from amb_analysis.machine.coupled import coupled_loop
from amb_analysis.machine.machine import Machine
from amb_analysis.studies.sensitivity_curves import curve_frequencies
from amb_assessment.assessment.format.machine_file import load_machine
from amb_assessment.assessment.physics.assessed_machine import assessed_machine_of
from amb_assessment.assessment.physics.stages import real_coefficients
from amb_assessment.first_design.files import new_machine
from amb_assessment.first_design.rotor_text import plain_shaft
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.scenario import as_scenario
from tests.support.independent_loop import independent_loop, smallest_disk_margin
from tests.support.slow import slow_but_first

WITHIN = 0.01
LEAST_DAMPED = 24  # poles that are compared
MARGINS = 6  # frequencies at which the disk margin is minimised


def machines(name: str, folder: Path):
    """The machine of a packaged machine file or scenario, or of a new one, and its stages."""
    if name == "compressor_levitated":
        return Machine(prepare_run(as_scenario(name))), ()
    if name == "new":
        speed = 12000.0 * np.pi / 30.0
        new_machine(folder / "fan", plain_shaft("fan", 30.0, 0.9, speed), speed)
        name = str(folder / "fan" / "machine.toml")
    subject = assessed_machine_of(load_machine(name))
    return subject, real_coefficients(subject)


@pytest.mark.parametrize("name", slow_but_first(["turbo_expander", "compressor", "compressor_levitated", "new"]))
@pytest.mark.parametrize("share", slow_but_first([1.0, 0.1]))
def test_sampled_loop_is_that_of_all_elements(name, share, tmp_path):
    """At every frequency to half the sample rate, closely about every resonance, at two speeds, with stages."""
    machine, stages = machines(name, tmp_path)
    Omega = share * machine.Omega
    exact = independent_loop(machine, Omega, stages)
    loop = Loop(coupled_loop(machine, stages).linear_components.at(Omega))
    poles = exact.closed_poles()
    sharp = poles[np.argsort(-np.abs(poles))[:LEAST_DAMPED]]
    hertz = curve_frequencies(sharp, exact.time, 1.0, 0.499999 / exact.time)
    expected = np.moveaxis(exact.sensitivity(hertz), 0, -1)
    S = response(model_of(loop.linear_components, loop.demands, loop.demands), hertz)
    of_axes = np.abs(np.einsum("kkn->kn", expected))
    np.testing.assert_allclose(np.abs(np.einsum("kkn->kn", S)), of_axes, rtol=WITHIN)
    alpha = disk_margin(S)
    np.testing.assert_allclose(alpha, disk_margin(expected), rtol=WITHIN)
    chosen = np.unique([int(alpha.argmin()), *np.linspace(0, len(hertz) - 1, MARGINS, dtype=int)])
    np.testing.assert_allclose(alpha[chosen], [smallest_disk_margin(expected[:, :, k]) for k in chosen], rtol=WITHIN)
    ours = loop.poles(Omega).z
    for z in sharp[~exact.is_unseen(sharp)]:
        s, nearest = np.log(z) / exact.time, np.log(ours[np.abs(ours - z).argmin()]) / exact.time
        assert abs(nearest - s) < WITHIN * abs(s.real), f"{s.imag / (2.0 * np.pi):.0f} Hz"


def test_reduced_rotor_of_the_runs_has_another_loop():
    """Its pseudo-modes of 751, 1349 and 1817 Hz are not those of the rotor, 613, 1027, 1489 and 1927 Hz."""
    machine = Machine(prepare_run(as_scenario("compressor_levitated")))
    hertz = np.linspace(500.0, 2000.0, 200)
    S, of_run = (
        np.abs(np.einsum("kkn->kn", response(model_of(source, machine.loop.demands, machine.loop.demands), hertz)))
        for source in (machine.linear_components, machine.run_components)
    )
    assert np.abs(of_run / S - 1.0).max() > 0.3
