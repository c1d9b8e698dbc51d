"""Responses from blows of a hammer, against the system that was struck; records that are not those of a hammer."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import curve_fit
from scipy.signal import butter, cont2discrete, lfilter, sosfilt, ss2tf

from amb_analysis.measured.estimates import estimate
from amb_analysis.measured.modal_fit import fitted_modes
from amb_analysis.measured.quality import estimate_warnings
from amb_analysis.measured.records import Channel, TimeRecord
from tests.support.messages import raises_naming

RATE = 4096.0
MODES = ((60.0, 0.004, 1.0), (220.0, 0.003, 0.7))  # Hz, damping ratio, 1/kg
FORCE, OTHER, PLACE = Channel("hammer", "N"), Channel("second", "N"), Channel("acc", "m/s2")
REGULAR = tuple(0.05 + 2.0 * k for k in range(8))
IRREGULAR = (0.19, 2.02, 4.42, 6.61, 8.30, 10.33, 12.41, 14.17)


def push(times, duration, sizes=None, width=0.002):
    """Half sines at some times."""
    t = np.arange(round(duration * RATE)) / RATE
    u = np.zeros(len(t))
    for k, at in enumerate(times):
        on = (t >= at) & (t < at + width)
        u[on] += (100.0 + 7.0 * (k % 3) if sizes is None else sizes[k]) * np.sin(np.pi * (t[on] - at) / width)
    return u


def moved(u, modes=MODES):
    """Accelerations that a force causes in a system at rest."""
    y = np.zeros(len(u))
    for hertz, zeta, gain in modes:
        w = 2 * np.pi * hertz
        A, B, C, D = [[0, 1], [-w * w, -2 * zeta * w]], [[0], [gain]], [[-w * w, -2 * zeta * w]], [[gain]]
        A, B, C, D, _ = cont2discrete((np.array(A), np.array(B), np.array(C), np.array(D)), 1 / RATE, method="foh")
        numerator, denominator = ss2tf(A, B, C, D)
        y += lfilter(numerator[0], denominator, u)
    return y


def exact(s):
    return sum(g * s**2 / (s**2 + 2 * z * 2 * np.pi * f * s + (2 * np.pi * f) ** 2) for f, z, g in MODES)


def struck(times, duration, noise=1e-3, offset=0.0, seed=0, **options):
    rng, u = np.random.default_rng(seed), push(times, duration, **options)
    y = moved(u)
    y = y + noise * np.abs(y).max() * rng.standard_normal(len(y)) + offset * np.abs(y).max()
    return TimeRecord(1 / RATE, {FORCE: u + noise * u.max() * rng.standard_normal(len(u)) + 3.0 * offset, PLACE: y})


def own_fit(record, begin, length):
    """Frequencies (Hz) and damping ratios of two decaying vibrations, fitted to the samples after a blow."""
    t = np.arange(round(length * RATE)) / RATE
    y = record.signals[PLACE][round(begin * RATE) :][: len(t)]

    def decay(t, a, b, f, s, c, d, g, r, mean):
        first = np.exp(-s * t) * (a * np.cos(2 * np.pi * f * t) + b * np.sin(2 * np.pi * f * t))
        return mean + first + np.exp(-r * t) * (c * np.cos(2 * np.pi * g * t) + d * np.sin(2 * np.pi * g * t))

    start = (*[np.abs(y).max() / 3] * 2, 60.05, 2.0, *[np.abs(y).max() / 3] * 2, 219.95, 5.0, 0.0)
    p, _ = curve_fit(decay, t, y, start)
    return (p[2], p[6]), (p[3] / np.hypot(p[3], 2 * np.pi * p[2]), p[7] / np.hypot(p[7], 2 * np.pi * p[6]))


CASES = {
    "one blow": dict(times=(0.05,), duration=8.0),
    "eight blows every 2 s": dict(times=REGULAR, duration=16.0),
    "eight blows at any time": dict(times=IRREGULAR, duration=18.0),
    "without a pre-trigger": dict(times=(0.0,), duration=6.0),
    "a long pre-trigger": dict(times=(3.0,), duration=8.0),
    "the decay does not end in the record": dict(times=(0.02,), duration=1.2),
    "with an offset": dict(times=IRREGULAR, duration=18.0, offset=0.02),
    "with 1 % of noise": dict(times=IRREGULAR, duration=18.0, noise=0.01),
    "a double hit": dict(times=(0.1, 0.13, 2.6, 5.0), duration=8.0, sizes=(100.0, 40.0, 90.0, 110.0)),
    "an early second blow": dict(times=(0.1, 2.1, 2.7, 4.2, 6.3), duration=8.5),
    "a downward blow": dict(times=REGULAR[:4], duration=8.0, sizes=(-100.0, -90.0, -80.0, -120.0)),
    "the last blow is cut by the end": dict(times=(0.1, 2.2, 4.2, 6.1), duration=6.3),
}


@pytest.mark.parametrize("name", CASES)
def test_blows_give_the_response_and_modes_of_the_system(name):
    """A Hann window over an eighth of the record is zero where the blow is."""
    record = struck(**CASES[name])
    (curve,) = estimate(record, ["hammer"])
    curve = curve.between(20.0, curve.estimate.highest)
    assert curve.frequencies[-1] == pytest.approx(650.0, rel=0.05)  # a half sine of 2 ms at -20 dB
    H = exact(2j * np.pi * curve.frequencies + curve.decay)
    decibel = 20 * np.log10(np.abs(curve.values / H))
    clear = np.abs(H) > 0.3 * np.median(np.abs(H))
    assert np.sqrt(np.mean(decibel[clear] ** 2)) < (1.0 if "noise" in name else 0.5)
    assert max(np.abs(decibel[np.argmin(np.abs(curve.frequencies - hertz))]) for hertz, _, _ in MODES) < 1.0
    modes = fitted_modes([curve])
    assert len(modes) == 2
    first = CASES[name]["times"][0] + (0.035 if name == "a double hit" else 0.003)
    fitted = own_fit(record, first, min(1.5, CASES[name]["duration"] - first))
    for mode, hertz, ratio, (true, zeta, _) in zip(modes, *fitted, MODES, strict=True):
        assert mode.is_resolved
        assert mode.frequency == pytest.approx(hertz, rel=2e-3)
        assert mode.damping_ratio == pytest.approx(ratio, rel=0.1)
        assert (mode.frequency, mode.damping_ratio) == (
            pytest.approx(true, rel=1e-3), pytest.approx(zeta, rel=0.05))  # fmt: skip


def test_rebounds_are_counted_and_the_ringing_of_a_filter_is_not():
    (curve,) = estimate(struck(**CASES["a double hit"]), ["hammer"])
    assert (curve.estimate.blows, curve.estimate.rebounds) == (3, 1)
    record = struck(IRREGULAR, 18.0)
    ringing = {c: sosfilt(butter(8, 1000.0, fs=RATE, output="sos"), y) for c, y in record.signals.items()}
    (curve,) = estimate(TimeRecord(1 / RATE, ringing), ["hammer"])
    assert (curve.estimate.blows, curve.estimate.rebounds) == (8, 0)


@pytest.mark.parametrize(
    ("times", "duration", "window"),
    [
        (REGULAR, 16.0, "exponential"),  # exp(-1.5 2) = 5 % is left after 2 s
        (IRREGULAR, 18.0, "exponential"),
        ((0.05,), 8.0, "boxcar"),
        ((0.02,), 1.2, "exponential"),
    ],
)
def test_only_a_response_that_has_not_decayed_has_an_exponential_window(times, duration, window):
    for shift in (0.0, 1 / RATE):  # an odd and an even number of samples
        (curve,) = estimate(struck(tuple(t + shift for t in times), duration), ["hammer"])
        assert curve.estimate.window == window
        assert (curve.decay > 0.0) == (window == "exponential")


def noise(n, seed=0):
    return np.random.default_rng(seed).standard_normal(n)


def sweep(n, low, high):
    return np.sin(2 * np.pi * np.cumsum(np.geomspace(low, high, n)) / RATE)


N = round(8 * RATE)
T = np.arange(N) / RATE
NOT_BLOWS = {
    "random": noise(N),
    "random with pauses": noise(N) * (T % 2.0 < 0.5),
    "short bursts": noise(N) * (T % 2.0 < 0.1),
    "a sweep": sweep(N, 5.0, 500.0),
    "a slow sweep": sweep(N, 0.2, 50.0),
    "sweeps with pauses": np.tile(np.r_[sweep(N // 16, 20.0, 400.0), np.zeros(N // 4 - N // 16)], 4),
    "bursts of a sine": np.sin(2 * np.pi * 120.0 * T) * (T % 1.0 < 0.05),
    "steps": np.sign(np.sin(2 * np.pi * T)),
    "one sine": np.sin(2 * np.pi * 50.0 * T) * (T < 0.02),
    "released": (T < 4.0).astype(float),
}


@pytest.mark.parametrize("name", NOT_BLOWS)
def test_what_is_not_a_hammer_is_divided_into_segments(name):
    u = NOT_BLOWS[name] + 1e-3 * noise(N, 7)
    (curve,) = estimate(TimeRecord(1 / RATE, {FORCE: u, PLACE: moved(u)}), ["hammer"])
    assert (curve.estimate.blows, curve.estimate.window, curve.estimate.blocks) == (0, "hann", 15)


def test_two_hammers_in_one_record_are_separated():
    """Blows along x and y in turn; the response along x to the second is half of that to the first."""
    u, v = push((0.1, 4.1), 16.0), push((8.1, 12.1), 16.0)
    record = TimeRecord(1 / RATE, {FORCE: u, OTHER: v, PLACE: moved(u) + 0.5 * moved(v)})
    along, across = estimate(record, ["hammer", "second"])
    within = (along.frequencies > 20.0) & (along.frequencies < 600.0)
    np.testing.assert_allclose(across.values[within], 0.5 * along.values[within], rtol=0.06)  # 0.3 % is left after 4 s
    H = exact(2j * np.pi * along.frequencies + along.decay)
    assert np.abs(along.values / H - 1)[within & (np.abs(H) > 0.5)].max() < 0.05


def test_each_of_repeated_records_contains_a_blow():
    parts = [struck((0.1 + 0.01 * k,), 4.0, seed=k, offset=0.01) for k in range(3)]
    signals = {c: np.concatenate([part.signals[c] for part in parts]) for c in (FORCE, PLACE)}
    (curve,) = estimate(TimeRecord(1 / RATE, signals, 3), ["hammer"])
    assert curve.estimate.blows == 3
    assert [mode.damping_ratio for mode in fitted_modes([curve.between(20.0, 600.0)])] == pytest.approx(
        [0.004, 0.003], rel=0.03
    )


def test_a_record_that_begins_within_its_only_blow_is_warned_of():
    late = {channel: values[round(0.0508 * RATE) :] for channel, values in struck((0.05,), 8.0).signals.items()}
    curves = estimate(TimeRecord(1 / RATE, late), ["hammer"])
    assert any("begins within the blow" in text for text in estimate_warnings(curves))


def test_the_coherence_of_one_blow_is_that_of_its_noise():
    """It is 1 by (3) of `estimates`. Of the power at 220 Hz and 400 Hz, N_yy/S_yy is noise."""
    options = {"window": "boxcar", "segment": 2.0}
    curves = [estimate(struck((0.05,), 8.0, noise=0.02, seed=k), ["hammer"], **options)[0] for k in range(8)]
    n = round(curves[0].estimate.length * RATE)
    y = moved(push((0.05,), 8.0))
    S = np.abs(np.fft.rfft(y[:n])) ** 2
    gamma = np.mean([curve.coherence for curve in curves], axis=0)
    for hertz in (100.0, 300.0, 400.0):
        k = round(hertz * n / RATE)
        share = S[k - 5 : k + 6].mean() / (S[k - 5 : k + 6].mean() + n * (0.02 * np.abs(y).max()) ** 2)
        assert gamma[k - 6 : k + 5].mean() == pytest.approx(share, abs=0.05)
    assert 0.2 < gamma[np.searchsorted(curves[0].frequencies, 400.0)] < 0.99


def test_a_response_that_has_not_decayed_and_a_low_coherence_are_warned_of():
    (close,) = estimate(struck(tuple(0.1 + 0.5 * k for k in range(12)), 6.2), ["hammer"])
    assert any("falls only to" in text for text in estimate_warnings([close]))
    (hann,) = estimate(struck(IRREGULAR, 18.0), ["hammer"], window="hann")
    assert any(text.startswith("the median coherence of acc/hammer (0.") for text in estimate_warnings([hann]))
    (good,) = estimate(struck(IRREGULAR, 18.0), ["hammer"])
    assert estimate_warnings([good]) == []


@pytest.mark.parametrize("name", ["rect", "rectangular", "boxcar"])
def test_names_of_the_rectangular_window_mean_the_same(name):
    """`rect` overlapped by half."""
    record = TimeRecord(1 / RATE, {FORCE: noise(N), PLACE: moved(noise(N))})
    (curve,) = estimate(record, ["hammer"], window=name)
    (same,) = estimate(record, ["hammer"], window="boxcar")
    assert curve.estimate.blocks == 8
    np.testing.assert_array_equal(curve.values, same.values)


def test_the_exponential_window_has_one_side_and_a_stated_decay():
    """SciPy's window of this name has two sides and a time constant of one sample; |H| was 41 times too large."""
    record = struck(REGULAR, 16.0)
    for options, rate in (({"window": "exponential"}, np.log(100.0) / 1.954), ({"decay": 5.0}, 5.0)):
        (curve,) = estimate(record, ["hammer"], **options)
        assert curve.decay == pytest.approx(rate, rel=2e-3)
        assert [m.damping_ratio for m in fitted_modes([curve.between(20.0, 600.0)])] == pytest.approx(
            [0.004, 0.003], rel=0.02
        )
    random = TimeRecord(1 / RATE, {FORCE: noise(N), PLACE: noise(N, 1)})
    for options in ({"window": "exponential"}, {"decay": 5.0}):
        with raises_naming(ValueError, "exponential", "hammer"):
            estimate(random, ["hammer"], **options)
    with raises_naming(ValueError, "exponential", "'hann'"):
        estimate(record, ["hammer"], window="hann", decay=5.0)


@pytest.mark.parametrize("segment", [1e-4, 3.0])
def test_a_segment_longer_than_the_time_between_blows_is_refused(segment):
    with raises_naming(ValueError, "segment", "2 s"):
        estimate(struck(REGULAR, 16.0), ["hammer"], segment=segment)


def test_a_stated_segment_leaves_out_blows_that_another_one_follows():
    (curve,) = estimate(struck((0.1, 2.1, 3.1, 5.1, 7.1), 8.0), ["hammer"], segment=1.9)
    assert (curve.estimate.blows, curve.estimate.length) == (3, pytest.approx(1.9, rel=1e-3))
