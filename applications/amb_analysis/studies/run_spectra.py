"""Study of the spectra of a run over time, such as the waterfall of a run-up."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, ClassVar

import numpy as np
from scipy.optimize import minimize_scalar
from scipy.signal import find_peaks, get_window, stft

from amb_analysis.studies.inputs import Number, spin_speed
from amb_analysis.studies.result import DrawnResult, WarnedResult
from amb_cosim.comparison.compare import Source, load
from amb_cosim.cosim.choices import FLAVOURS, Flavour
from amb_cosim.cosim.grid.time_grid import in_steps
from amb_cosim.cosim.record.signals import Signals
from amb_cosim.cosim.record.warnings import warnings_of
from amb_cosim.cosim.system.values import Raw, quantity
from amb_cosim.presentation.text_tables import TextBlock, labelled_table, number
from amb_cosim.presentation.units import speed_unit
from amb_cosim.results.places import places
from amb_cosim.results.result import Result
from amb_cosim.results.signal_arrays import cycles, signal, speed, speed_changes, turns
from amb_cosim.results.thinned import even_samples, folding, judged
from amb_cosim.results.warning_sentences import warning_sentences
from amb_cosim.scenario.simulation import run
from amb_files.checks import require, require_choice
from amb_files.pack_file import default
from array_types import Array, Complex

LONGEST_WINDOW = 1.0  # s, by default
WINDOWS = 8  # fewest in a shorter run, by default
FEWEST = 16  # samples of a window, at least
CYCLES = 2.0  # of the highest frequency in a window, at least; the lines are 1 / window apart
PROMINENCE = 0.05  # least prominence of a peak, over the largest amplitude
ORDERS = 2.5  # default of the highest frequency, over the highest spin frequency
UP_TO = 60.0  # Hz, default of the highest frequency of a rotor at rest
BETWEEN_LINES = 0.84  # least amplitude of a vibration at its nearest line, over its true amplitude
BETWEEN = 9  # frequencies between two lines and their middle one, of which the best is refined
NEAR = 2.0  # lines within which a vibration is not distinguished from another: half the width of the window's lobe


@dataclass(frozen=True, eq=False)
class BearingSpectra:
    """Spectra of the orbit x + j y at a bearing; positive frequencies are forward whirl, negative ones backward whirl.

    amplitude
        Amplitude of each line (m), shape (windows, lines).
    peak_hold
        Largest amplitude of each line in any window (m), shape (lines,).
    synchronous
        Amplitude of the motion that is synchronous with the rotor's angle, in each window (m), shape (windows,).
    resonances, resonance_amplitudes
        Spin speeds (Hz) at which the synchronous amplitude has a peak, and the peak amplitudes (m); both are empty if
        the spin speed changes by less than the spacing of the lines.
    largest, largest_at
        Largest synchronous amplitude (m), and the spin speed there (Hz).
    other_frequency, other_amplitude, other_spin_frequency
        Frequency (Hz) of the strongest vibration away from the rotation frequency, its amplitude (m), and the spin
        speed at that time (Hz).
    """

    amplitude: Annotated[Array, "m"]
    peak_hold: Annotated[Array, "m"]
    synchronous: Annotated[Array, "m"]
    resonances: Annotated[Array, "Hz"]
    resonance_amplitudes: Annotated[Array, "m"]
    largest: Annotated[float, "m"]
    largest_at: Annotated[float, "Hz"]
    other_frequency: Annotated[float, "Hz"]
    other_amplitude: Annotated[float, "m"]
    other_spin_frequency: Annotated[float, "Hz"]

    @property
    def other(self) -> tuple[str, str, str]:
        """Texts: amplitude (mm), frequency and spin speed of the strongest other vibration; dashes if there is none."""
        if not self.other_amplitude:
            return ("-", "-", "-")
        return number(1e3 * self.other_amplitude), f"{self.other_frequency:.2f}", _speed(self.other_spin_frequency)


@dataclass(frozen=True, eq=False, repr=False)
class Waterfall(WarnedResult, DrawnResult):
    """Spectra of a run's orbits over time.

    scenario
        Name of the scenario.
    window
        Length of a window (s); lines are 1/window apart.
    times, spin_frequencies
        Middle of each window (s), and the mean spin frequency in it (Hz), shape (windows,).
    frequencies
        Frequencies of the lines (Hz), ascending from below zero, shape (lines,).
    changing_speed
        Whether the spin speed changes.
    bearings
        Spectra by bearing.
    warnings
        All warnings of the run.
    folded
        What a thinned record does not show (see `thinned.folding`); empty for a record of every step.
    """

    name: ClassVar[str] = "waterfall"
    renamed: ClassVar[Mapping[str, str]] = {"speeds": "`spin_frequencies`, in Hz"}

    scenario: str
    window: Annotated[float, "s"]
    times: Annotated[Array, "s"]
    spin_frequencies: Annotated[Array, "Hz"]
    frequencies: Annotated[Array, "Hz"]
    changing_speed: bool
    bearings: dict[str, BearingSpectra]
    folded: str = ""

    def text(self) -> list[TextBlock]:
        """Return a table of the largest synchronous and non-synchronous vibrations at each bearing."""
        at, peaks, other_at = (f"{what} ({speed_unit().label})" for what in ("at", "peaks at", "at speed"))
        headings = ("synchronous (mm)", at, peaks, "other (mm)", "frequency (Hz)", other_at)
        table = labelled_table(f"{self.scenario}: spectra, windows of {self.window:.3g} s", "bearing", *headings)
        for name, result in self.bearings.items():
            table.add_row(
                name,
                number(1e3 * result.largest),
                _speed(result.largest_at),
                ", ".join(map(_speed, result.resonances)) or "-",
                *result.other,
            )
        nearby = f"within {NEAR / self.window:.3g} Hz of the spin frequency, of 0 Hz or of each other"
        note = f"negative frequencies are backward whirl; vibrations {nearby} are not distinguished"
        return [*([f"warning: {self.folded}"] if self.folded else []), table, note, *self.warning_lines()]


def _speed(turns: float) -> str:
    """Return a spin speed (turns per s) as text, in the unit in which speeds are displayed."""
    return speed_unit().number(2.0 * np.pi * turns, 5)


def waterfall(
    source: Source | None = None,
    *,
    up_to: Number | None = None,
    window: Number | None = None,
    rotor: str | Path | None = None,
    set: Mapping[str, Raw] | None = None,
    flavour: Flavour = "native",
) -> Waterfall:
    """Return the spectra of a run's orbits, one for each window of time.

    Z(f, t) = sum_n w_n (x + j y)(t_n) exp(-j 2 pi f t_n) / sum_n w_n, where w is a Hann window, and adjacent windows
    overlap by half. The synchronous part uses the rotor's angle in place of 2 pi f t, so a changing speed does not blur
    it.

    Parameters
    ----------
    source
        A scenario to run (object, name or TOML file), or a result (object, folder or file). By default, the study runs
        a packaged scenario with changing speed.
    up_to
        Highest frequency (rad/s), or a string with its unit; by default 2.5 times the highest spin frequency.
    window
        Length of a window (s), or a string with its unit; by default 1 s, or an eighth of the run if that is shorter.
    rotor, set, flavour
        As in `amb_cosim.run`; not allowed for a result.

    Raises
    ------
    ValueError
        If the source is invalid; if the run recorded no orbit, has unequal steps or is too short; if a window is
        longer than the run; or if `up_to` is more than half the sampling rate of a thinned record.
    KeyboardInterrupt
        If Ctrl-C interrupts the run.

    Examples
    --------
    >>> spectra = waterfall(run("compressor_levitated", until="0.1 s"))
    >>> f"{1e3 * max(bearing.largest for bearing in spectra.bearings.values()):.3f} mm"
    '0.039 mm'
    """
    require_choice("flavour", flavour, FLAVOURS)
    highest = None if up_to is None else spin_speed(up_to, "up_to") / (2.0 * np.pi)
    if highest is not None:
        require(highest > 0.0, "up_to", f"{highest:g} Hz", "> 0 Hz")
    window = None if window is None else quantity(window, "s", "window")
    plan = load(default("changing_speed") if source is None else source)
    if isinstance(plan, Result):
        if rotor or set:
            raise ValueError(f"{source} is a saved result; its settings cannot be changed")
        return spectra_of(plan.signals, highest, window)
    result = run(plan, rotor=rotor, set=set, flavour=flavour)
    return spectra_of(result.signals, highest, window)


def spectra_of(recorded: Signals, highest: float | None = None, window: Number | None = None) -> Waterfall:
    """Return the spectra of a recorded run up to a frequency (Hz), by default `ORDERS` times the spin frequency."""
    recorded = judged(recorded)
    time, after, folded = np.asarray(recorded["time"].values), cycles(recorded) >= 0.0, folding(recorded)
    after[even_samples(time) :] = False
    time = time[after]
    steps = np.diff(time)
    if not len(steps) or not np.allclose(steps, steps[0], rtol=1e-6):
        raise ValueError("spectra require samples at equal steps, but the steps of the run differ")
    h, duration = float(steps[0]), float(time[-1] - time[0])
    if highest is not None and folded:
        require(highest <= 0.5 / h, "up_to", f"{highest:g} Hz", f"<= {0.5 / h:.4g} Hz, because {folded}")
    if highest is None:
        highest = ORDERS * float(np.abs(speed(recorded)).max(initial=0.0)) / (2.0 * np.pi) or UP_TO
    shortest = max(FEWEST * h, CYCLES / highest)
    if duration < shortest:
        has = f"the run has only {duration:.6g} s from cycle 0 on, in steps of {h:g} s"
        raise ValueError(f"{has}; spectra require at least {shortest:.6g} s")
    length = (
        min(LONGEST_WINDOW, max(duration / WINDOWS, shortest)) if window is None else quantity(window, "s", "window")
    )
    allowed = f">= {shortest:.6g} s and <= {duration:.6g} s"
    require(shortest <= length <= duration, "window", f"{length:g} s", allowed)
    size = round(in_steps(length, h))
    Omega, theta = speed(recorded)[after], 2.0 * np.pi * turns(recorded)[after]

    def spectra(values: Complex) -> tuple[Array, Array, Complex]:
        """Return frequencies (Hz, ascending), window centres (s), and spectra, shape (windows, lines)."""
        lines, middles, Z = stft(
            values, 1.0 / h, "hann", size, size // 2, return_onesided=False, boundary=None, padded=False
        )
        order = np.argsort(lines)
        return lines[order], middles, Z[order].T

    result: dict[str, BearingSpectra] = {}
    synchronous_lobe, mean_lobe = spectra(np.exp(1j * theta))[2], spectra(np.ones(len(theta), dtype=np.complex128))[2]
    lines, middles = np.empty(0), np.empty(0)
    for bearing in places(recorded).bearings:
        x, y = signal(recorded, f"{bearing}.x"), signal(recorded, f"{bearing}.y")
        if x is None or y is None:
            continue
        orbit = np.asarray(x + 1j * y)[after]
        lines, middles, Z = spectra(orbit)
        speeds = np.interp(middles, time - time[0], Omega) / (2.0 * np.pi)
        _, _, in_rotating_frame = spectra(orbit * np.exp(-1j * theta))
        in_range, synchronous = np.abs(lines) <= highest, in_rotating_frame[:, lines == 0.0]
        others = Z - synchronous * synchronous_lobe
        mean = others[:, lines == 0.0]
        others -= mean * mean_lobe
        windows = _Windows(orbit, np.exp(1j * theta), size, h)
        amplitudes = np.abs(Z[:, in_range]), np.abs(others[:, in_range]), np.abs(synchronous[:, 0])
        result[bearing] = _bearing(*amplitudes, lines[in_range], speeds, windows)
    if not result:
        raise ValueError("the run did not record the displacement at a bearing")
    lines = lines[np.abs(lines) <= highest]
    return Waterfall(
        scenario=str(recorded.attrs["scenario"]),
        window=size * h,
        times=middles + time[0],
        spin_frequencies=speeds,
        frequencies=lines,
        changing_speed=speed_changes(recorded),
        bearings=result,
        warnings=tuple(warning_sentences(warnings_of(recorded), recorded)),
        folded=folded,
    )


@dataclass(frozen=True, eq=False)
class _Windows:
    """An orbit, modelled in each window as the sum of its synchronous motion, its mean and one other vibration.

    z(t_n) = Z_s exp(j theta_n) + Z_0 + Z exp(j 2 pi f t_n),    |n h - t| <= size h/2              (1)

    The three amplitudes are least-squares estimates with the weights of the window, so none of them leaks into another.
    """

    orbit: Complex
    turning: Complex
    size: int
    step: float

    def vibration(self, row: int, lowest: float, highest: float) -> tuple[float, float]:
        """Return amplitude (m) and frequency (Hz) of the vibration that fits (1) best between two frequencies."""
        within = slice(row * (self.size - self.size // 2), row * (self.size - self.size // 2) + self.size)
        root = np.sqrt(get_window("hann", self.size))
        others, _ = np.linalg.qr(root[:, None] * np.stack([self.turning[within], np.ones(self.size)], axis=1))
        rest, times = root * self.orbit[within], self.step * np.arange(self.size)
        rest = rest - others @ (others.conj().T @ rest)

        def amplitude_and_share(frequency: float) -> tuple[float, float]:
            wave = root * np.exp(2j * np.pi * frequency * times)
            wave = wave - others @ (others.conj().T @ wave)
            product, power = abs(np.vdot(wave, rest)), float(np.vdot(wave, wave).real)
            return product / power, product**2 / power

        coarse = np.linspace(lowest, highest, BETWEEN)
        top = int(np.argmax([amplitude_and_share(frequency)[1] for frequency in coarse]))
        bounds = coarse[max(top - 1, 0)], coarse[min(top + 1, BETWEEN - 1)]
        exact = minimize_scalar(lambda frequency: -amplitude_and_share(frequency)[1], bounds=bounds, method="bounded")
        return amplitude_and_share(exact.x)[0], float(exact.x)


def _strongest(windows: _Windows, others: Array, lines: Array, speeds: Array) -> tuple[float, float, int]:
    """Return amplitude (m), frequency (Hz) and window of the largest vibration away from 0 Hz and the spin frequencies.

    Maxima over the lines are refined between the lines, because a vibration halfway between two lines shows only 85 %
    of its amplitude at each of them. A vibration within `NEAR` lines of 0 Hz or of the spin frequency is ignored,
    because it cannot be distinguished from the motion at these frequencies.
    """
    spacing = lines[1] - lines[0] if len(lines) > 1 else 1.0

    def distance(frequencies: Array | float, spins: Array | float) -> Array:
        return np.minimum(np.abs(frequencies), np.abs(frequencies - spins)) / spacing

    padded = np.pad(others, ((0, 0), (1, 1)))
    tops = (others >= padded[:, :-2]) & (others >= padded[:, 2:]) & (others > 0.0)
    places = np.argwhere(tops & (distance(lines, speeds[:, np.newaxis]) > NEAR - 1.0))
    largest = (0.0, 0.0, 0)
    for row, column in sorted(places, key=lambda place: -others[tuple(place)]):
        if others[row, column] < BETWEEN_LINES * largest[0]:
            break
        adjacent = lines[max(column - 1, 0) : column + 2]
        amplitude, frequency = float(others[row, column]), float(lines[column])
        if len(adjacent) == 3:  # not at an end of the spectrum
            amplitude, frequency = windows.vibration(int(row), adjacent[0], adjacent[-1])
        if distance(frequency, speeds[row]) > NEAR:
            largest = max(largest, (amplitude, frequency, int(row)))
    return largest


def _bearing(
    amplitude: Array, others: Array, synchronous: Array, lines: Array, speeds: Array, windows: _Windows
) -> BearingSpectra:
    """Return the spectra at a bearing, and the largest vibrations in them.

    `others` contains the spectra without the leakage of the synchronous motion and of the orbit's mean (0 Hz).
    """
    top = int(np.argmax(synchronous))
    peaks, _ = find_peaks(synchronous, prominence=PROMINENCE * synchronous[top])
    peaks = peaks if len(lines) > 1 and np.ptp(speeds) > lines[1] - lines[0] else peaks[:0]
    strongest, frequency, row = _strongest(windows, others, lines, speeds)
    return BearingSpectra(
        amplitude=amplitude,
        peak_hold=amplitude.max(axis=0),
        synchronous=synchronous,
        resonances=speeds[peaks],
        resonance_amplitudes=synchronous[peaks],
        largest=float(synchronous[top]),
        largest_at=float(speeds[top]),
        other_frequency=frequency,
        other_amplitude=strongest,
        other_spin_frequency=float(speeds[row]),
    )
