"""The study of a run's spectra: whirl of known amplitudes and directions, resonance of a sweep, bad input."""

import json
from dataclasses import replace

import numpy as np
import pytest

from amb_cosim import studies
from amb_cosim.cosim.run.recording import Outcome
from amb_cosim.results.result import Result
from tests.support.messages import assert_names, raises_naming

PERIOD = 0.02  # s, of the synthetic run
DONE = Outcome("completed", 4.0)


@pytest.fixture
def make(synthetic):
    """`make(orbit, **attributes)`: a run of 200 cycles with the orbit x + j y = orbit(time) at MB1."""

    def result(orbit, **attributes) -> Result:
        dataset = synthetic(end=200, outcome=json.dumps(["completed", 4.0, None, ""]), **attributes)
        z = orbit(dataset["time"].values)
        for name, values in (("x", z.real), ("y", z.imag)):
            signal = dataset[f"rotor_contact.mb1.{name}"]
            dataset[f"rotor_contact.mb1.{name}"] = signal.copy(data=values)
        return Result(dataset, DONE)

    return result


def whirl(amplitude, frequency):
    return lambda t: amplitude * np.exp(2j * np.pi * frequency * t)


def test_forward_and_backward_whirl_have_their_amplitudes(make):
    run = make(lambda t: whirl(0.3e-3, 1.0 / PERIOD)(t) + whirl(0.1e-3, -20.0)(t) + 0.2e-3)
    result = studies.waterfall(run, window=0.5).bearings["mb1"]
    assert result.largest == pytest.approx(0.3e-3, rel=1e-3)
    assert (result.other_amplitude, result.other_frequency) == pytest.approx((0.1e-3, -20.0), rel=1e-3)
    assert result.largest_at == result.other_spin_frequency == pytest.approx(50.0)
    assert len(result.resonances) == 0  # the speed does not change


@pytest.mark.parametrize("window", [0.1, 0.137, 0.5])
def test_synchronous_run_has_no_asynchronous_vibration(make, window):
    """The side lobes of the window have 14 % two lines off, and 2.7 % further off, and the mean has them too."""
    result = studies.waterfall(make(lambda t: whirl(0.3e-3, 1.0 / PERIOD)(t) + 0.2e-3), window=window)
    assert result.bearings["mb1"].other_amplitude < 1e-3 * 0.3e-3


@pytest.mark.parametrize("frequency", [49.0, 51.5, 56.0, -3.0])
def test_the_lobe_of_a_vibration_near_the_spin_is_not_a_second_one(make, frequency):
    """Lines are 4 Hz apart: the lobe of a vibration of 49 Hz reaches lines that count as separate from 50 Hz."""
    run = make(lambda t: whirl(0.3e-3, 1.0 / PERIOD)(t) + whirl(0.1e-3, frequency)(t) + whirl(5e-6, -27.0)(t))
    spectra = studies.waterfall(run, window=0.25)
    result = spectra.bearings["mb1"]
    assert (result.other_amplitude, result.other_frequency) == pytest.approx((5e-6, -27.0), rel=0.05)
    assert "8 Hz of the spin" in str(spectra)


def cases_of_a_tone():
    """Windows (s), mean and frequency (Hz), amplitude of a vibration, and the errors of both that are allowed."""
    for window in (0.125, 0.25):  # beside a mean and a spin of twenty and a hundred times its amplitude
        for frequency in (-47.7, 61.3, 33.3, 90.1):
            if abs(frequency - 50.0) * window > 2.0:
                yield window, 0.06e-3, frequency, 3e-6, 1e-3, 2e-3
    for lines in (2.1, 2.5, 3.0):  # more than two lines from the spin it is separate
        yield 0.25, 0.0, 50.0 - lines / 0.25, 0.01e-3, 0.02, 0.02 * (50.0 - lines / 0.25)
    for window in (0.25, 0.5):  # at a line the Hann window leaves 85 % of a vibration half way to the next one
        for share in (0.0, 0.25, 0.5, 0.75):
            yield window, 0.2e-3, -20.0 - share / window, 0.1e-3, 2e-3, 0.05 / window
    yield 0.5, 0.2e-3, 23.0, 5e-6, 0.01, 0.1  # small beside the spin


@pytest.mark.parametrize(("window", "mean", "frequency", "amplitude", "rel", "off"), [*cases_of_a_tone()])
def test_a_vibration_beside_the_spin_has_its_amplitude_and_frequency(
    make, window, mean, frequency, amplitude, rel, off
):
    run = make(lambda t: whirl(0.3e-3, 50.0)(t) + whirl(amplitude, frequency)(t) + mean)
    result = studies.waterfall(run, window=window).bearings["mb1"]
    assert result.other_amplitude == pytest.approx(amplitude, rel=rel)
    assert result.other_frequency == pytest.approx(frequency, abs=off)


def test_larger_of_two_vibrations_is_located_between_the_lines(make):
    """92 um half way between two lines, of which 78 um are at these, and 85 um at a line."""
    run = make(lambda t: whirl(92e-6, -21.0)(t) + whirl(85e-6, 24.0)(t))
    result = studies.waterfall(run, window=0.5).bearings["mb1"]
    assert (result.other_amplitude, result.other_frequency) == pytest.approx((92e-6, -21.0), rel=3e-3)


@pytest.mark.parametrize(("distance", "amplitude"), [(0.4, 0.149e-3), (4.5, 0.1e-3)])
def test_vibrations_within_two_lines_of_each_other_are_one(make, distance, amplitude):
    """A window of 0.5 s sees 20 and 20.4 Hz of 0.1 and 0.05 mm as one vibration; it states the 4 Hz of two lines."""
    both = make(lambda t: whirl(0.3e-3, 50.0)(t) + whirl(0.1e-3, 20.0)(t) + whirl(0.05e-3, 20.0 + distance)(t))
    result = studies.waterfall(both, window=0.5)
    assert result.bearings["mb1"].other_amplitude == pytest.approx(amplitude, rel=0.02)
    assert_names(result, "4 Hz", "each other")


def test_peak_of_a_sweep_is_its_resonance(make):
    """From 10 to 50 Hz in 4 s, with an amplitude that is largest as the frequency passes 30 Hz after 2 s."""
    profile = [(0.0, 20.0 * np.pi), (4.0, 100.0 * np.pi)]
    sweep = lambda t: (1e-4 + 4e-4 * np.exp(-((t - 2.0) ** 2))) * np.exp(2j * np.pi * (10.0 * t + 5.0 * t**2))  # noqa: E731
    result = studies.waterfall(make(sweep, speed_profile=json.dumps(profile)), window="0.25 s")
    assert result.changing_speed
    assert result.bearings["mb1"].resonances == pytest.approx([30.0], abs=1.5)
    assert result.bearings["mb1"].resonance_amplitudes == pytest.approx([5e-4], rel=0.2)
    assert result.spin_frequencies == pytest.approx(10.0 + 10.0 * result.times)
    panel = studies.figure(result).axes[0]
    assert panel.get_ylim()[0] == pytest.approx(60.0 * result.spin_frequencies[0])
    assert "rpm" in panel.get_ylabel()


def test_peaks_of_a_fast_spin_are_printed_apart(make):
    """A micro-turbine of 1500 Hz passes two peaks that are 4 rpm apart."""
    spectra = studies.waterfall(make(whirl(1e-4, 50.0)))
    spectra.bearings["mb1"] = replace(spectra.bearings["mb1"], resonances=np.array([1469.28, 1469.35]))
    assert "88157, 88161" in str(spectra)  # rpm


def test_a_spin_that_hardly_slows_down_passes_no_resonance(make):
    """From 50 to 49.8 Hz in 4 s, with windows whose lines are 4 Hz apart, and an amplitude that rises and falls."""
    profile = json.dumps([(0.0, 100.0 * np.pi), (4.0, 99.6 * np.pi)])
    run = make(
        lambda t: 3e-4 * np.cos(np.pi * t) * np.exp(2j * np.pi * (50.0 * t - 0.025 * t**2)), speed_profile=profile
    )
    assert len(studies.waterfall(run, window="0.25 s").bearings["mb1"].resonances) == 0


@pytest.mark.slow
def test_saved_result_gives_figure_and_data(make, runner, check_picture, tmp_path):
    make(whirl(0.3e-3, 50.0)).save(tmp_path / "run", plots=False)
    result = runner("study", "waterfall", "run", "--up-to", "80 Hz", "-o", "out")
    assert result.exit_code == 0, result.output
    data = json.loads((tmp_path / "out" / "waterfall.json").read_text(), parse_constant=pytest.fail)
    assert data["window_s"] == pytest.approx(0.5)
    assert max(np.abs(data["frequencies_hz"])) <= 80.0
    assert len(data["bearings"]["mb1"]["amplitude_m"]) == len(data["times_s"])
    check_picture(tmp_path / "out" / "waterfall.png")


@pytest.mark.parametrize("samples", [0, 1])
def test_run_without_samples_is_refused(make, samples):
    run = make(whirl(0.3e-3, 50.0))
    with raises_naming(ValueError, "equal steps"):
        studies.waterfall(Result(run.dataset.isel(time=slice(samples)), DONE))


def test_a_run_of_few_samples_has_one_window_or_is_refused(make):
    """A window has two cycles of the highest frequency; the message states the duration, not an empty range."""
    run = make(whirl(1e-4, 1.0 / PERIOD))
    begin = int(np.searchsorted(run.dataset["cycle"].values, 0.0))
    h = float(np.diff(run.dataset["time"].values[:2])[0])
    spectra = studies.waterfall(Result(run.dataset.isel(time=slice(begin, begin + 82)), DONE))
    assert spectra.window == pytest.approx(80 * h)  # two cycles of 125 Hz
    with raises_naming(ValueError, f"{9 * h:g} s", f"{h:g} s", f"{80 * h:g} s"):
        studies.waterfall(Result(run.dataset.isel(time=slice(begin, begin + 10)), DONE))


def test_a_window_has_two_cycles_of_the_highest_frequency(make):
    """Lines of shorter windows lie further apart than that frequency, so that a spectrum would have one line."""
    run = make(whirl(1e-4, 1.0 / PERIOD))
    assert len(studies.waterfall(run, up_to="100 Hz", window="20 ms").frequencies) == 5
    with raises_naming(ValueError, "window = 0.019 s", ">= 0.02 s"):
        studies.waterfall(run, up_to="100 Hz", window="19 ms")
