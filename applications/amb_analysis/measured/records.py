"""Records of measured data, in SI units."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np

from amb_analysis.measured.force_noise import ForceNoise
from array_types import Array, Bools, Complex, Indices
from fmi_export.building.units import LEAST, MOST

EXCITATIONS = ("N", "A", "V")  # units of inputs
ROUNDED = 1e-3  # of a coherence that a file rounds


def check_sizes(values: Array | Complex, name: str) -> None:
    """Raise ValueError if squares or products of numbers other than 0 could underflow or overflow."""
    sizes = np.abs(values)
    beyond = (sizes > MOST) | ((sizes < LEAST) & (sizes > 0.0))
    if beyond.any():
        raise ValueError(
            f"{name}: {sizes[beyond][0]:g} is not allowed; numbers must be 0, or from {LEAST:g} to {MOST:g} "
            "in magnitude"
        )


@dataclass(frozen=True)
class Channel:
    """A signal: its name, such as `fan.x`, and its SI unit."""

    name: str
    unit: str

    def renamed(self, names: Mapping[str, str]) -> Channel:
        """Return the channel with its new name from `names`, or with its old name if `names` does not contain it."""
        return Channel(names.get(self.name, self.name), self.unit)

    def __str__(self) -> str:
        return f"{self.name} ({self.unit})"


@dataclass(frozen=True)
class Estimate:
    """How responses were estimated from a record.

    window
        Name of the window.
    blocks, length
        Number of averaged blocks, and their length (s).
    decay
        Rate (1/s) at which an exponential window decays; 0 without this window.
    blows
        Number of blows of a hammer with a block each; 0 if the blocks divide the record evenly.
    rebounds
        Number of blows with rebounds.
    highest
        Highest frequency (Hz) that the hammer excites; None without blows.
    left
        Amplitude of the response at the end of a block, over that after the blow; None without blows.
    incomplete
        Whether the record begins within its only blow.
    """

    window: str
    blocks: int
    length: Annotated[float, "s"]
    decay: Annotated[float, "1/s"] = 0.0
    blows: int = 0
    rebounds: int = 0
    highest: Annotated[float | None, "Hz"] = None
    left: float | None = None
    incomplete: bool = False

    def __str__(self) -> str:
        if not self.blows:
            return f"estimated from {self.blocks} segments of {self.length:.4g} s with the window {self.window}"
        blows = f"{self.blows} blow{'s' if self.blows > 1 else ''} of a hammer"
        rebounds = f" ({self.rebounds} with rebounds)" if self.rebounds else ""
        tau = f" of {1.0 / self.decay:.4g} s" if self.decay else ""
        return (
            f"estimated from {blows}{rebounds}, in blocks of {self.length:.4g} s with the window {self.window}{tau}; "
            f"the hammer excites up to {self.highest:.4g} Hz"
        )


@dataclass(frozen=True, eq=False)
class FrequencyResponse:
    """The response of an output to an input.

    output, input
        Channels.
    frequencies
        Frequencies (Hz) above 0, in ascending order, shape (n,).
    values
        Y/U in the units of the channels, shape (n,). Because y = Re[Y exp(j omega t)], a delay has a negative phase.
    coherence
        Coherence from 0 to 1, shape (n,); None if it was not measured. Values above 1 due to rounding are reduced to 1.
    resolution
        Width (Hz) of the window over which the response was averaged; None if its lines are exact, or this is unknown.
    decay
        Rate 1/tau (1/s) of the exponential window exp(-t/tau) of the records. The values are those at j omega + 1/tau,
        because the window is a factor of both records. 0 without this window.
    estimate
        How the response was estimated from a record; None if the file contains responses.
    scatter
        Expected square of the error of the values due to the noise of the output, shape (n,); None if it is unknown.
    force_noise
        Noise of the force of a hammer; None without blows.

    Raises
    ------
    ValueError
        If the shapes differ, a number is not finite or is too large or too small, a coherence is not from 0 to 1, or
        the frequencies are not positive and in ascending order.
    """

    output: Channel
    input: Channel
    frequencies: Array
    values: Complex
    coherence: Array | None = None
    resolution: float | None = None
    decay: float = 0.0
    estimate: Estimate | None = None
    scatter: Array | None = None
    force_noise: ForceNoise | None = None

    def __post_init__(self) -> None:
        n = len(self.frequencies)
        for name, values in (("values", self.values), ("coherence", self.coherence)):
            if values is not None and values.shape != (n,):
                raise ValueError(f"{self.name}: {name} of shape {values.shape} is not allowed; it must be ({n},)")
            if values is not None and not np.isfinite(values).all():
                raise ValueError(f"{self.name}: {name} contains numbers that are not finite")
        check_sizes(self.values, self.name)
        if self.coherence is not None:
            if not (np.abs(self.coherence - 0.5) <= 0.5 + ROUNDED).all():
                worst = float(self.coherence[np.argmax(np.abs(self.coherence - 0.5))])
                raise ValueError(f"{self.name}: coherence {worst:g} is not allowed; it must be from 0 to 1")
            object.__setattr__(self, "coherence", np.clip(self.coherence, 0.0, 1.0))
        if n < 2 or not np.isfinite(self.frequencies).all() or not (np.diff(self.frequencies) > 0.0).all():
            raise ValueError(
                f"{self.name}: its {n} frequencies are not allowed; there must be two or more, in ascending order"
            )
        if self.frequencies[0] <= 0.0:
            raise ValueError(f"{self.name}: frequency {self.frequencies[0]:g} Hz is not allowed; it must be > 0 Hz")

    @property
    def name(self) -> str:
        """Name of the response, `output/input`."""
        return f"{self.output.name}/{self.input.name}"

    @property
    def unit(self) -> str:
        """Unit of the values."""
        above = f"({self.output.unit})" if "/" in self.output.unit else self.output.unit
        return f"{above}/{self.input.unit}"

    def between(self, lowest: float, highest: float) -> FrequencyResponse:
        """Return the part of the response between two frequencies (Hz)."""
        return self.at((self.frequencies >= lowest) & (self.frequencies <= highest))

    def at(self, k: Indices | Bools) -> FrequencyResponse:
        """Return the response at the frequencies that indices or a mask select."""
        coherence = None if self.coherence is None else self.coherence[k]
        return replace(
            self,
            frequencies=self.frequencies[k],
            values=self.values[k],
            coherence=coherence,
            scatter=None if self.scatter is None else self.scatter[k],
            force_noise=None if self.force_noise is None else self.force_noise.at(k),
        )


def response_above_zero(
    output: Channel, source: Channel, frequencies: Array, values: Complex, coherence: Array | None
) -> FrequencyResponse:
    """Return a response without the line at 0 Hz that many instruments write; see `FrequencyResponse` for errors."""
    on = frequencies != 0.0
    return FrequencyResponse(output, source, frequencies[on], values[on], None if coherence is None else coherence[on])


@dataclass(frozen=True, eq=False)
class Modes:
    """Natural frequencies (Hz) and damping ratios (1), shape (n,) each; NaN for a missing ratio."""

    frequencies: Array
    damping_ratios: Array

    def __post_init__(self) -> None:
        is_positive = (self.frequencies > 0.0).all() and np.isfinite(self.frequencies).all()
        if (
            self.frequencies.shape != self.damping_ratios.shape
            or not is_positive
            or np.isinf(self.damping_ratios).any()
        ):
            raise ValueError(
                "these modes are not allowed; each mode needs a frequency > 0 Hz and a damping ratio (NaN if unknown)"
            )


@dataclass(frozen=True, eq=False)
class TimeRecord:
    """Signals over time.

    sample_time
        Sample time (s).
    signals
        Samples of each channel, shape (n,).
    repeats
        Number of consecutive records of equal length in the samples, such as one record for each hammer blow.
    warning
        What the samples do not show; empty if nothing is known to be missing.
    """

    sample_time: float
    signals: Mapping[Channel, Array]
    repeats: int = 1
    warning: str = ""

    def channel(self, name: str) -> Channel:
        """Return the channel with this name; if a force and a motion at a driving point share it, return the force.

        Raises
        ------
        ValueError
            If the record has no such channel.
        """
        from amb_files.suggestions import suggest

        found = [channel for channel in self.signals if channel.name == name]
        if not found:
            raise ValueError(f"the record has no channel {name!r}; {suggest(name, [c.name for c in self.signals])}")
        if len(found) > 1:
            found = [channel for channel in found if channel.unit in EXCITATIONS]
        if len(found) != 1:
            raise ValueError(
                f"the record has several channels {name!r}; exactly one of them must have the unit "
                f"{' or '.join(EXCITATIONS)}"
            )
        return found[0]


@dataclass(frozen=True)
class Measurement:
    """Content of a file: responses, modes if it lists them, and what the data do not show or what was not used."""

    responses: tuple[FrequencyResponse, ...] = ()
    modes: Modes | None = None
    warnings: tuple[str, ...] = ()
