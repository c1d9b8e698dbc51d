"""Study of computed frequency responses of a rotor, free or in its machine, compared with measured responses."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from pathlib import Path
from typing import Annotated, ClassVar, NamedTuple

import numpy as np

from amb_analysis.machine.channels import Place, place_of
from amb_analysis.machine.frequency_response import (
    LOOPS,
    Loop,
    Structure,
    frequency_response,
    refined,
    resonant_frequencies,
)
from amb_analysis.machine.machine import machine_of
from amb_analysis.measured.convention import contradictions
from amb_analysis.measured.deviation import CurveDeviation, ModeDeviation, curve_deviation, mode_deviations
from amb_analysis.measured.estimates import ESTIMATORS, Estimator
from amb_analysis.measured.files import read_measured
from amb_analysis.measured.modal_fit import FittedMode, doubtful_modes, fitted_modes, is_masked, peak_frequencies
from amb_analysis.measured.quality import estimate_warnings, listed, median_coherence
from amb_analysis.measured.records import Channel, Estimate, FrequencyResponse, Measurement
from amb_analysis.measured.units import si_channel
from amb_analysis.studies.inputs import Number, controlled, positive, spin_speed
from amb_analysis.studies.result import DrawnResult, WarnedResult
from amb_cosim.cosim.choices import FLAVOURS, Flavour
from amb_cosim.cosim.run.options import RunOptions
from amb_cosim.cosim.system.values import Raw, quantity
from amb_cosim.presentation.text_tables import TextBlock, number, text_table
from amb_cosim.presentation.units import speed_unit
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.scenario import Scenario
from amb_files.checks import as_names, require, require_choice
from array_types import Array, Complex
from rotor_analysis.implausible_sizes import implausible_sizes
from rotor_analysis.refinement import about_resonances, vertex
from rotor_analysis.refinement import refined as refined_samples
from rotor_analysis.rotor import Rotor
from rotor_analysis.rotor_file import load_rotor

LOWEST, HIGHEST = 1.0, 1000.0  # Hz, without a measurement
POINTS = 600
UNDAMPED = 1e-7  # half width of a resonance over its frequency, below which only rounding limits the peak
COARSE = 10  # frequencies per interval of the search for resonances
WITH_UNIT = re.compile(r"(?P<name>[^\[\]]*[^\[\]\s])\s*(?:\[(?P<unit>[^\[\]]+)\])?")


@dataclass(frozen=True, eq=False)
class ComputedResponse:
    """A computed response and, if there is a measurement, the measured response.

    unit
        Unit of both responses.
    frequencies
        Frequencies (Hz), shape (n,).
    computed, measured
        Complex values, shape (n,).
    coherence
        Coherence of the measurement (1), shape (n,).
    deviation
        Deviation of the computed response from the measured one.
    """

    unit: str
    frequencies: Annotated[Array, "Hz"]
    computed: Complex
    measured: Complex | None = None
    coherence: Array | None = None
    deviation: CurveDeviation | None = None


@dataclass(frozen=True, eq=False, repr=False)
class FrequencyResponses(WarnedResult, DrawnResult):
    """Frequency responses of a rotor.

    rotor
        Name of the rotor.
    loop
        Support of the rotor.
    speed
        Spin speed (rad/s).
    responses
        Responses by name, `output/input`.
    modes
        Modes of the measured responses, each with the matching computed mode, and computed modes that match none; empty
        if there is no measurement.
    estimate
        How the measured responses were estimated from a record; None if the file contains responses.
    exponential_window
        Time constant (s) of the exponential window of the measurement, whose damping the modes do not include; None
        without this window.
    """

    name: ClassVar[str] = "response"

    rotor: str
    loop: Loop
    speed: Annotated[float, "rad/s"]
    responses: dict[str, ComputedResponse]
    modes: tuple[ModeDeviation, ...]
    estimate: Estimate | None = None
    exponential_window: Annotated[float | None, "s"] = None

    def text(self) -> list[TextBlock]:
        """Return tables of the modes and the deviations or, if there is no measurement, of the largest peaks.

        If there is a measurement, how it was estimated and the warnings come first.
        """
        title = f"{self.rotor}, {self.loop}, {speed_unit().text(self.speed)}: "
        if all(item.measured is None for item in self.responses.values()):
            table = text_table(f"{title}largest peaks", ("response", "", "at (Hz)", "phase (deg)"), left=("response",))
            beyond = []
            for name, item in self.responses.items():
                top = _largest_peak(np.abs(item.computed))
                if (end := int(np.argmax(np.abs(item.computed)))) in (0, len(item.computed) - 1):
                    at_end = f"{abs(item.computed[end]):.4g} {item.unit} at {item.frequencies[end]:.4g} Hz"
                    beyond.append(f"{name}: largest at an end of the range, {at_end}")
                phase = f"{np.degrees(np.angle(item.computed[top])):z.1f}"
                size = f"{abs(item.computed[top]):.4g} {item.unit}"
                if _is_unbounded(item.frequencies, np.abs(item.computed), top):
                    size, phase = "no bound", "-"
                elif not item.computed.any():
                    phase = "-"
                table.add_row(name, size, f"{item.frequencies[top]:.4g}", phase)
            return [table, *beyond, *self.warning_lines()]
        heads = ("measured (Hz)", "computed (Hz)", "(%)", "damping ratio", "computed ratio", "MAC")
        modes = text_table(f"{title}modes", heads)
        for mode in self.modes:
            ratios = (number(mode.measured_damping), number(mode.computed_damping))
            percent = "-" if mode.percent is None else f"{mode.percent:+z.2f}"
            mac = "-" if mode.mac is None else f"{mode.mac:.3f}"
            hertz = "-" if mode.measured is None else f"{mode.measured:.2f}"
            modes.add_row(hertz, number(mode.computed), percent, *ratios, mac)
        columns = ("response", "unit", "FRAC", "least in an octave", "rms (dB)", "coherence")
        curves = text_table(f"{title}responses", columns, left=("response", "unit"))
        for name, item in self.responses.items():
            if item.deviation is not None:
                d = item.deviation
                least = f"{d.least:.3f} ({d.band[0]:.4g} to {d.band[1]:.4g} Hz)"
                deviations = f"{d.frac:.3f}", least, f"{d.decibel:.2f}"
                gamma = median_coherence(item.coherence)
                curves.add_row(name, item.unit, *deviations, "-" if gamma is None else f"{gamma:.3f}")
        return [*self.estimate_lines(), *([modes, *self._window_lines()] if self.modes else []), curves]

    def estimate_lines(self) -> list[TextBlock]:
        """Return lines about the estimate of the measured responses, and the warnings."""
        return [*([f"measured responses: {self.estimate}"] if self.estimate else []), *self.warning_lines()]

    def _window_lines(self) -> list[TextBlock]:
        """Return a line about the damping that an exponential window adds."""
        if self.exponential_window is not None:
            return [f"damping ratios without that of the exponential window of {self.exponential_window:.4g} s"]
        if self.estimate is None and any(mode.measured_damping is not None for mode in self.modes):
            return ["if an exponential window was used, state its `exponential_window`; it adds damping"]
        return []


def response(
    scenario: str | Path | Scenario | None = None,
    *,
    rotor: str | Path | Rotor | None = None,
    controller: str | Path | None = None,
    measured: str | Path | Measurement | None = None,
    loop: Loop | None = None,
    inputs: str | Sequence[str] = (),
    outputs: str | Sequence[str] = (),
    channels: Mapping[str, str] | None = None,
    channel_units: Mapping[str, str] | None = None,
    speed: Number | None = None,
    lowest: Number | None = None,
    up_to: Number | None = None,
    estimator: Estimator = "H1",
    segment: Number | None = None,
    window: str | None = None,
    exponential_window: Number | None = None,
    set: Mapping[str, Raw] | None = None,
    flavour: Flavour = "native",
) -> FrequencyResponses:
    """Return frequency responses from forces or currents to motion or currents, compared with measured responses.

    The result is y/u at the frequencies of the measurement, computed with the equations of
    `machine.frequency_response`. Both the measured and the computed responses are fitted near their peaks
    (`measured.modal_fit`), so that frequencies and damping ratios come from the same method.

    Parameters
    ----------
    scenario, rotor, controller
        The machine, its rotor and its controller, as for `sensitivity`. If only `rotor` is given, the study treats that
        rotor alone.
    measured
        File of a measurement (`measured.files.read_measured`), or a measurement.
    loop
        `free` is the rotor alone, and `linear` is the rotor on the bearings and seals of its file. `open` is the rotor
        with magnets but without a controller, and `closed` is the rotor under control. The default is `closed`, or
        `free` for a rotor alone.
    inputs, outputs
        Channels, such as `fan.f_x`, `left.i_x`, `eye.x`, or `0.12 m.y [m/s2]`. If there is a measurement, these
        channels select the responses to compare; by default, all responses are compared. The inputs of a record over
        time must be named.
    channels
        Name or place in the model for each name of a channel in the file.
    channel_units
        Units by the names of columns or channels in the file; they replace the units in the file, or supply missing
        units.
    speed
        Spin speed (rad/s), or a string with its unit; by default the speed of the scenario, or 0 if there is no
        machine.
    lowest
        Lowest frequency (Hz), or a string with its unit; by default that of the measurement, or 1 Hz without a
        measurement.
    up_to
        Highest frequency (Hz), or a string with its unit; by default that of the measurement, the highest that a hammer
        excites, or 1 kHz without a measurement.
    estimator, segment, window
        Arguments of the estimate from a record over time (`measured.estimates.estimate`); `segment` is in s.
    exponential_window
        Time constant tau (s) of the window exp(-t/tau) with which the responses of the file were measured, or with
        which those of a record are to be estimated. Its damping is subtracted from that of the measured modes, and the
        computed responses are those with the same window.
    set, flavour
        Parameter values by `component.variable`, and the flavour of the FMUs.

    Raises
    ------
    ValueError
        If the file cannot be read, a channel is not a place of the rotor, or an argument is not allowed.

    Examples
    --------
    >>> result = response(rotor="compressor", inputs=["impeller3.f_x"], outputs=["seal.x"], up_to="200 Hz")
    >>> curve = result.responses["seal.x/impeller3.f_x"]
    >>> f"{abs(curve.computed[0]):.2g} {curve.unit} at {curve.frequencies[0]:.0f} Hz"
    '0.00011 m/N at 1 Hz'
    """
    loop = loop or ("free" if scenario is None and rotor is not None else "closed")
    require_choice("flavour", flavour, FLAVOURS)
    require_choice("loop", loop, LOOPS)
    require_choice("estimator", estimator, ESTIMATORS)
    ends = frequency_range(lowest, up_to)
    estimation = estimation_of(estimator, segment, window, exponential_window)
    inputs, outputs = as_names("inputs", inputs), as_names("outputs", outputs)
    curves: Sequence[FrequencyResponse] = ()
    of_data: tuple[str, ...] = ()
    if measured is not None:
        content = measured_content(measured, channels, channel_units, inputs, outputs, ends, estimation)
        curves, of_data = content.responses, content.warnings
        if not curves:
            raise ValueError("the measurement lists only modes; there is no response to compare")
    is_machine = loop in ("open", "closed")
    levitated = controlled(scenario, rotor, controller) if scenario is not None or is_machine else None
    described = load_rotor(rotor if levitated is None else levitated.rotor)
    if measured is None:
        curves = _requested(inputs, outputs, ends)
    places = [(_place(c.input, described, True), _place(c.output, described, False)) for c in curves]
    refined_rotor = refined(described, [place for pair in places for place in pair])
    machine = None
    if levitated is not None and is_machine:
        prepared = prepare_run(levitated.machine(rotor=refined_rotor), set, options=RunOptions(flavour=flavour))
        machine = machine_of(prepared)
    default_speed = 0.0 if machine is None else machine.Omega
    Omega = default_speed if speed is None else spin_speed(speed)
    if machine is not None and loop == "closed":
        machine.loop.check_stable([Omega])
    structure = Structure(refined_rotor, loop, Omega, machine)
    if measured is None:
        curves = _closer(structure, curves, places)
    values = computed_values(structure, curves, places)
    result = laid_over(described.name, loop, Omega, curves, values, compared=measured is not None)
    warnings = implausible_sizes(described) if machine is None else machine.prepared.warnings
    return replace(result, warnings=(*of_data, *result.warnings, *warnings))


def laid_over(
    rotor: str,
    loop: Loop,
    Omega: float,
    curves: Sequence[FrequencyResponse],
    values: Sequence[Complex],
    *,
    compared: bool = True,
) -> FrequencyResponses:
    """Return the computed responses and, if they are `compared`, their deviations from the measured responses.

    Responses of the same name, such as repeated measurements, are numbered.
    """
    names = _numbered([c.name for c in curves])
    if not compared:
        plain = {n: ComputedResponse(c.unit, c.frequencies, v) for n, c, v in zip(names, curves, values, strict=True)}
        return FrequencyResponses(rotor, loop, Omega, plain, ())
    responses = {
        name: ComputedResponse(c.unit, c.frequencies, v, c.values, c.coherence, curve_deviation(c, v))
        for name, c, v in zip(names, curves, values, strict=True)
    }
    modes: list[ModeDeviation] = []
    contradicted = contradictions(curves, values)
    warnings = [*estimate_warnings(curves), *contradicted]
    for _, group in groupby(zip(curves, values, strict=True), lambda pair: pair[0].frequencies.tobytes()):
        pairs = list(group)
        measured = [c for c, _ in pairs]
        found = fitted_modes(measured)
        warnings += unresolved([mode for mode in found if not mode.is_resolved], measured[0].decay)
        if dropped := doubtful_modes(measured):
            low, high = min(gamma for _, gamma in dropped), max(gamma for _, gamma in dropped)
            warnings.append(
                f"the peaks at {listed([f'{hertz:.4g}' for hertz, _ in dropped])} Hz are not listed as modes, because "
                f"the coherence around them is only {low:.2f} to {high:.2f}"
            )
        if not found and not contradicted:
            at = listed([f"{peak:.4g}" for peak in peak_frequencies(measured)])
            cause = (
                f"no decaying vibration fits the peaks at {at} Hz"
                if at
                else "no peak rises 6 dB above its surroundings"
            )
            warnings.append(f"{cause}: no mode is compared")
        computed = [replace(c, values=v, coherence=None, resolution=None, estimate=None) for c, v in pairs]
        modes += mode_deviations(found, fitted_modes(computed))
    ascending = tuple(sorted(modes, key=lambda mode: mode.measured or mode.computed or 0.0))
    tau = 1.0 / curves[0].decay if curves[0].decay else None
    return FrequencyResponses(
        rotor, loop, Omega, responses, ascending, curves[0].estimate, tau, warnings=tuple(dict.fromkeys(warnings))
    )


def unresolved(modes: Sequence[FittedMode], decay: float = 0.0) -> list[str]:
    """Return sentences about these modes, whose damping is not resolved; empty if there are none.

    Parameters
    ----------
    modes
        Modes that are not resolved.
    decay
        Rate (1/s) of the exponential window of the records.
    """
    by_window = [mode for mode in modes if is_masked(mode, decay)]
    by_lines = [mode for mode in modes if not is_masked(mode, decay)]
    result = []
    if by_lines:
        widest = max(mode.lines for mode in by_lines)
        result.append(
            f"the damping of the modes at {_listed(by_lines)} is not resolved: the half-power width of their peaks is "
            f"at most {widest:.2g} lines; use longer segments, a longer record or more closely spaced lines"
        )
    if by_window:
        result.append(
            f"the damping of the modes at {_listed(by_window)} is not resolved, because the exponential window of "
            f"{1.0 / decay:.3g} s adds at least ten times as much; check its time constant, or use a longer window"
        )
    return result


def _listed(modes: Sequence[FittedMode]) -> str:
    return listed([f"{mode.frequency:.2f} Hz" for mode in modes])


def _numbered(names: Sequence[str]) -> list[str]:
    """Make names unique by numbering repetitions: `a, b, a` becomes `a, b, a (2)`."""
    before = [names[:k].count(name) for k, name in enumerate(names)]
    return [f"{name} ({count + 1})" if count else name for name, count in zip(names, before, strict=True)]


class Estimation(NamedTuple):
    """Arguments of `read_measured` for a record over time, in SI units."""

    estimator: Estimator
    segment: float | None
    window: str | None
    decay: float


def estimation_of(
    estimator: Estimator, segment: Number | None, window: str | None, exponential_window: Number | None
) -> Estimation:
    """Return the arguments of an estimate, given those of `response`; raise a ValueError if one is not allowed."""
    length = None if segment is None else quantity(segment, "s", "segment")
    tau = np.inf if exponential_window is None else positive(exponential_window, "s", "exponential_window")
    return Estimation(estimator, length, window, 1.0 / tau)


def measured_content(
    measured: str | Path | Measurement,
    channels: Mapping[str, str] | None,
    channel_units: Mapping[str, str] | None,
    inputs: Sequence[str],
    outputs: Sequence[str],
    ends: tuple[float | None, float | None],
    estimation: Estimation,
) -> Measurement:
    """Return a measurement that contains the chosen responses between two frequencies (Hz).

    The other arguments are those of `response`.

    Raises
    ------
    ValueError
        If the file cannot be read, if none of its responses is chosen, or if a response is 0 at some frequency, where
        its logarithm does not exist.
    """
    in_file = {place: name for name, place in (channels or {}).items()}
    named = tuple(in_file.get(_bare(name), _bare(name)) for name in inputs)
    content = measured
    if not isinstance(content, Measurement):
        content = read_measured(content, channels, named, channel_units, **estimation._asdict())
    elif estimation.decay:
        with_window = (replace(curve, decay=estimation.decay) for curve in content.responses)
        content = replace(content, responses=tuple(with_window))
    if not content.responses:
        return content
    excited = content.responses[0].estimate.highest if content.responses[0].estimate else None
    lowest, highest = ends[0] or 0.0, ends[1] or excited or np.inf
    names = channels or {}
    requested = [{names.get(name, name) for name in map(_bare, ends)} for ends in (inputs, outputs)]
    chosen = [
        item.between(lowest, highest)
        for item in content.responses
        if all(not ends or c.name in ends for ends, c in zip(requested, (item.input, item.output), strict=True))
    ]
    if not chosen:
        measured_names = ", ".join(item.name for item in content.responses)
        raise ValueError(f"no response is left to compare; the measurement contains {measured_names}")
    for item in chosen:
        if not item.values.all():
            at = f"{item.frequencies[np.argmin(np.abs(item.values))]:g} Hz"
            raise ValueError(f"{item.name} = 0 at {at} is not allowed; omit that frequency, or choose other responses")
    return replace(content, responses=tuple(sorted(chosen, key=lambda item: item.frequencies.tobytes())))


def frequency_range(lowest: Number | None, up_to: Number | None) -> tuple[float | None, float | None]:
    """Return two frequencies (Hz), None where the arguments are None.

    Raises
    ------
    ValueError
        If a frequency is not positive, or the first one is not below the second one.
    """
    low, high = (
        None if raw is None else positive(raw, "Hz", name) for raw, name in ((lowest, "lowest"), (up_to, "up_to"))
    )
    if low is not None and high is not None:
        require(low < high, "lowest", f"{low:g} Hz", f"< {high:g} Hz, the highest frequency")
    return low, high


def _requested(
    inputs: Sequence[str], outputs: Sequence[str], ends: tuple[float | None, float | None]
) -> list[FrequencyResponse]:
    """Return a response from each input to each output, without values, between two frequencies (Hz)."""
    missing = [name for name, ends in (("`inputs`", inputs), ("`outputs`", outputs)) if not ends]
    if missing:
        raise ValueError(f"{' and '.join(missing)} are missing; without a measurement, name at least one of each")
    highest = ends[1] or max(HIGHEST, 2.0 * (ends[0] or 0.0))
    frequencies = np.geomspace(ends[0] or min(LOWEST, 0.5 * highest), highest, POINTS)
    empty = np.zeros(POINTS, dtype=np.complex128)
    return [
        FrequencyResponse(_channel(output, "m"), _channel(source, "N"), frequencies, empty)
        for output in outputs
        for source in inputs
    ]


def _largest_peak(sizes: Array) -> int:
    """Return the index of the largest local maximum; of the largest value if there is none.

    A free rotor moves as a rigid body at low frequencies, where |H| grows without bound with 1/(m omega^2), so the
    largest value is that of the lowest frequency and no resonance.
    """
    inside = np.flatnonzero((sizes[1:-1] > sizes[:-2]) & (sizes[1:-1] >= sizes[2:])) + 1
    return int(inside[np.argmax(sizes[inside])] if inside.size else np.argmax(sizes))


def _is_unbounded(frequencies: Array, sizes: Array, top: int) -> bool:
    """Return whether only rounding limits the largest value, as at an undamped resonance."""
    if not 0 < top < len(sizes) - 1:
        return False
    near = slice(top - 1, top + 2)
    with np.errstate(divide="ignore"):
        _, lowest, curvature = vertex(frequencies[near], (sizes[top] / sizes[near]) ** 2)
    return bool(max(float(lowest), 0.0) < float(curvature) * (UNDAMPED * frequencies[top]) ** 2)


def _closer(
    structure: Structure, curves: Sequence[FrequencyResponse], ends: Sequence[tuple[Place, Place]]
) -> list[FrequencyResponse]:
    """Return responses that have no values yet; their frequencies are denser near resonances and maxima."""
    first = curves[0].frequencies
    input_places, output_places = (list(dict.fromkeys(pair[side] for pair in ends)) for side in (0, 1))
    coarse = np.unique([*first[::COARSE], first[-1]])
    sampled = about_resonances(first, resonant_frequencies(structure, input_places, output_places, coarse))
    frequencies, _ = refined_samples(
        lambda more: frequency_response(structure, input_places, output_places, more, float(first[-1])), sampled, np.abs
    )
    return [replace(c, frequencies=frequencies, values=np.zeros(len(frequencies), np.complex128)) for c in curves]


def _bare(text: str) -> str:
    """Return the name of a channel without the unit in brackets."""
    return text.partition("[")[0].strip()


def _channel(text: str, unit: str) -> Channel:
    """Return the channel for a name with its unit in brackets; the default is A for a current, otherwise `unit`."""
    match = WITH_UNIT.fullmatch(text)
    if match is None:
        raise ValueError(f"channel {text!r} is not allowed; it must be a name such as 'fan.x' or 'fan.x [m/s2]'")
    name = match["name"]
    default = "A" if name.rpartition(".")[2].startswith("i_") else unit
    return si_channel(name, match["unit"] or default)[1]


def _place(channel: Channel, rotor: Rotor, is_input: bool) -> Place:
    return place_of(channel.name, channel.unit, rotor, is_input=is_input)


def computed_values(
    structure: Structure, curves: Sequence[FrequencyResponse], ends: Sequence[tuple[Place, Place]]
) -> list[Complex]:
    """Return the computed values of responses; those with the same frequencies are computed together."""
    result: dict[int, Complex] = {}
    for _, group in groupby(range(len(curves)), lambda k: curves[k].frequencies.tobytes()):
        members = list(group)
        input_places = list(dict.fromkeys(ends[k][0] for k in members))
        output_places = list(dict.fromkeys(ends[k][1] for k in members))
        first = curves[members[0]]
        H = frequency_response(structure, input_places, output_places, first.frequencies, decay=first.decay)
        for k in members:
            result[k] = H[:, output_places.index(ends[k][1]), input_places.index(ends[k][0])]
    return [result[k] for k in range(len(curves))]
