"""Study that fits parameters of a rotor file, of magnets and of controllers to a measurement."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from itertools import groupby
from pathlib import Path
from typing import Annotated, ClassVar

import numpy as np

from amb_analysis.machine.channels import Place, place_of
from amb_analysis.machine.frequency_response import LOOPS, Loop
from amb_analysis.measured.convention import contradictions
from amb_analysis.measured.estimates import ESTIMATORS, Estimator
from amb_analysis.measured.least_squares import Fit, FreeParameter
from amb_analysis.measured.least_squares import fit as least_squares_fit
from amb_analysis.measured.modal_fit import fitted_modes
from amb_analysis.measured.records import FrequencyResponse, Measurement, Modes
from amb_analysis.measured.response_fit import fit_responses
from amb_analysis.studies.fitted_machine import FittedMachine
from amb_analysis.studies.frequency_responses import (
    FrequencyResponses,
    computed_values,
    estimation_of,
    frequency_range,
    laid_over,
    measured_content,
)
from amb_analysis.studies.inputs import Number
from amb_analysis.studies.result import DrawnResult, WarnedResult
from amb_analysis.studies.rotor_parameters import free_bounds
from amb_cosim.cosim.choices import FLAVOURS, Flavour
from amb_cosim.cosim.system.values import Raw
from amb_cosim.presentation.json_data import Layout
from amb_cosim.presentation.text_tables import TextBlock, text_table
from amb_files.checks import as_names, require_choice
from amb_files.plain_values import plain_values
from array_types import Array, Complex
from rotor_analysis.assembly import assemble, with_bearings
from rotor_analysis.modes import modes as modes_of
from rotor_analysis.rotor import Rotor

MOST_LINES = 300  # of a response; more frequencies are thinned evenly
FREQUENCY_ERROR, DAMPING_ERROR = 1e-3, 0.1  # expected relative errors of measured modes, which weight the fit
BIASED = 10.0  # lines about a peak that is not resolved
ELASTIC = 1e-2  # of the lowest measured frequency, below which a mode is rigid motion


@dataclass(frozen=True, eq=False, repr=False)
class RotorFit(WarnedResult, DrawnResult):
    """A rotor fitted to a measurement.

    rotor, measured, loop
        Name of the rotor, name of the measurement, and support of the rotor.
    fit
        Parameters with intervals, correlation and residuals.
    before, after
        Responses before and after the fit, compared with the measured responses; None if only modes were measured.
    files
        Texts of the fitted files by file name: `rotor.toml` and, for a machine, `scenario.toml`.
    """

    name: ClassVar[str] = "fit"

    rotor: str
    measured: str
    loop: Loop
    fit: Annotated[Fit, Layout.MERGED]
    before: Annotated[FrequencyResponses | None, Layout.OMITTED]
    after: Annotated[FrequencyResponses | None, Layout.OMITTED]
    files: Annotated[dict[str, str], Layout.OMITTED]

    def data_files(self) -> dict[str, str]:
        """Return the text of the data file and of the fitted files, by file name."""
        return {**super().data_files(), **self.files}

    def text(self) -> list[TextBlock]:
        """Return the estimate and warnings, a table of the parameters, and lines about correlation and residuals."""
        heads = ("parameter", "fitted", "95 % interval", "")
        table = text_table(f"{self.rotor} fitted to {self.measured}", heads, left=("parameter", ""))
        names = list(self.fit.parameters)
        for name, p in self.fit.parameters.items():
            at = "at its bound" if p.at_bound else ""
            table.add_row(name, f"{p.value:.6g}", f"{p.lower:.6g} to {p.upper:.6g}", at)
        estimate = self.after.estimate if self.after else None
        first = [f"measured responses: {estimate}"] if estimate else []
        lines: list[TextBlock] = [*first, *self.warning_lines(), table]
        pairs = [
            f"{names[i]} and {names[j]}: {self.fit.correlation[i, j]:+.2f}"
            for i in range(len(names))
            for j in range(i)
            if abs(self.fit.correlation[i, j]) > 0.5
        ]
        if pairs:
            lines.append("correlation " + ", ".join(pairs))
        ratio = f"{self.fit.rms_before:.4g} before, {self.fit.rms_after:.4g} after"
        return [*lines, f"rms of {self.fit.residuals} residuals: {ratio}"]


def fit(
    rotor: str | Path | None = None,
    *,
    scenario: str | Path | None = None,
    controller: str | Path | None = None,
    measured: str | Path | Measurement | None = None,
    free: Mapping[str, tuple[Number, Number]] | str | Sequence[str] = (),
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
) -> RotorFit:
    """Fit parameters of a rotor, or of a machine, to a measurement, and return them with 95 % intervals.

    The residuals of responses are the differences between computed and measured values, divided by the scatter of the
    measured values. The scatter at each frequency is estimated from the data and the coherence
    (`measured.response_fit`). The residuals of modes are the logarithms of the ratios of computed to measured values,
    in units of 0.1 % for frequencies and 10 % for damping ratios. If the data do not determine a parameter, an error is
    raised (`measured.least_squares.fit`).

    Parameters
    ----------
    rotor
        Rotor file, or the name of a packaged rotor; by default the rotor of the scenario, or the packs' default rotor.
    scenario, controller
        The machine and its controller, as for `response`. If neither is given, the study treats the rotor alone.
    measured
        File of responses or modes, or a measurement.
    free
        Bounds by parameter name, or strings such as `bodies.wheel.mass=3:5`. Names are keys of the rotor file, or
        parameters of the scenario's components. In a key, an item of a list is given by its name or its number, as in
        `damping.modal.1`. All matches of a pattern such as `amb_actuator.left.k_i_measured_?` share one value.
    loop
        As for `response`: `closed` by default if there is a scenario, otherwise `free`.
    inputs, outputs, channels, channel_units, lowest, up_to, estimator, segment, window, exponential_window
        As for `response`.
    speed
        Spin speed (rad/s), or a string with its unit; by default the speed of the scenario, or 0 without a scenario.
    set, flavour
        Parameter values by `component.variable`, and the flavour of the FMUs.

    Raises
    ------
    ValueError
        If a parameter does not exist, the measurement cannot be read or does not determine a parameter, or an argument
        is not allowed.
    """
    loop = loop or ("free" if scenario is None else "closed")
    require_choice("flavour", flavour, FLAVOURS)
    require_choice("loop", loop, LOOPS)
    require_choice("estimator", estimator, ESTIMATORS)
    estimation, ends = estimation_of(estimator, segment, window, exponential_window), frequency_range(lowest, up_to)
    if measured is None:
        raise ValueError("measured is missing; a fit needs a measurement")
    files = scenario, rotor, controller
    subject = FittedMachine.load(files, loop, speed, free_bounds(free), plain_values(set, "set"), flavour)
    inputs, outputs = as_names("inputs", inputs), as_names("outputs", outputs)
    content = measured_content(measured, channels, channel_units, inputs, outputs, ends, estimation)
    curves = [thinned(curve) for curve in resolved(content.responses)]
    if not curves and content.modes is None:
        raise ValueError("the measurement contains neither a response nor a mode to fit")
    name = "a measurement" if isinstance(measured, Measurement) else Path(measured).name
    if curves:
        result = _fit_of_responses(subject, content.responses, curves, name)
        return replace(result, warnings=(*content.warnings, *result.warnings))
    assert content.modes is not None
    return _fit_of_modes(subject, content.modes, name)


def _fit_of_responses(
    subject: FittedMachine, measured: Sequence[FrequencyResponse], curves: Sequence[FrequencyResponse], name: str
) -> RotorFit:
    """Fit the rotor to some lines of the measured responses, and return the result."""
    ends = [_ends(curve, subject.rotor_with(subject.start)) for curve in curves]
    subject = subject.with_places([place for pair in ends for place in pair])

    def laid_over_measured(values: Array | Sequence[float]) -> FrequencyResponses:
        structure = subject.structure_with(values)
        computed = computed_values(structure, measured, ends)
        if found := contradictions(measured, computed):
            raise ValueError(f"no parameters of the rotor can fit this measurement: {'; '.join(found)}")
        return laid_over(structure.rotor.name, structure.loop, structure.Omega, measured, computed)

    @lru_cache(maxsize=4)
    def responses(values: bytes) -> list[Complex]:
        return computed_values(subject.structure_with(np.frombuffer(values)), curves, ends)

    before = laid_over_measured(subject.start)
    result, noticed = fit_responses(
        lambda values: responses(np.asarray(values, np.float64).tobytes()), curves, subject.free, subject.start
    )
    best = np.array([p.value for p in result.parameters.values()])
    after = laid_over_measured(best)
    return _result(subject, result, before, after, name, (*noticed, *after.warnings))


def _fit_of_modes(subject: FittedMachine, measured: Modes, name: str) -> RotorFit:
    """Fit the rotor to measured modes, and return the result."""
    loop, Omega = subject.loop, subject.Omega
    if loop not in ("free", "linear"):
        raise ValueError(f"loop = {loop!r} is not allowed with modes; they are fitted with 'free' or 'linear'")
    residuals = partial(_mode_residuals, subject, loop, Omega, measured)
    result = least_squares_fit(residuals, subject.free, subject.start)
    return _result(subject, result, None, None, name, ())


def _result(
    subject: FittedMachine,
    result: Fit,
    before: FrequencyResponses | None,
    after: FrequencyResponses | None,
    name: str,
    warnings: Sequence[str],
) -> RotorFit:
    best = np.array([p.value for p in result.parameters.values()])
    head = "\n".join(_comments(result, subject.free, name)) + "\n\n"
    files = {file: head + text for file, text in subject.files_with(best).items()}
    warnings = (*warnings, *subject.warnings(best))
    return RotorFit(subject.rotor_with(best).name, name, subject.loop, result, before, after, files, warnings=warnings)


def resolved(curves: Sequence[FrequencyResponse]) -> list[FrequencyResponse]:
    """Return the responses without lines near unresolved peaks, where the estimated values are too low.

    At a distance of d lines from such a peak, an average over the width of a line has an error of about 1/(3 d^2). At a
    distance of `BIASED` lines, this error is 0.3 %.
    """
    result: list[FrequencyResponse] = []
    for _, group in groupby(curves, lambda curve: curve.frequencies.tobytes()):
        members = list(group)
        width = max((curve.resolution or 0.0) for curve in members)
        on = np.ones(len(members[0].frequencies), dtype=np.bool_)
        narrow = [mode.frequency for mode in fitted_modes(members) if not mode.is_resolved] if width else []
        for frequency in narrow:
            on &= np.abs(members[0].frequencies - frequency) > BIASED * width
        result += [curve.at(on) for curve in members]
    return result


def thinned(curve: FrequencyResponse) -> FrequencyResponse:
    """Return a response with at most `MOST_LINES` frequencies."""
    return curve.at(np.unique(np.linspace(0, len(curve.frequencies) - 1, MOST_LINES).round().astype(np.intp)))


def _ends(curve: FrequencyResponse, rotor: Rotor) -> tuple[Place, Place]:
    """Return the places of the input and the output of a response."""
    return (
        place_of(curve.input.name, curve.input.unit, rotor, is_input=True),
        place_of(curve.output.name, curve.output.unit, rotor, is_input=False),
    )


def _mode_residuals(subject: FittedMachine, loop: Loop, Omega: float, measured: Modes, values: Array) -> Array:
    return mode_residuals(subject.rotor_with(values), loop, Omega, measured)


def mode_residuals(rotor: Rotor, loop: Loop, Omega: float, measured: Modes) -> Array:
    """Return ln(f/f_measured)/0.1 % and ln(zeta/zeta_measured)/10 %, with f and zeta of the nearest computed mode."""
    full = assemble(rotor)
    model = full if loop == "free" else with_bearings(full, (*rotor.bearings, *rotor.seals))
    lowest = 2.0 * np.pi * ELASTIC * float(measured.frequencies.min())
    computed = [mode for mode in modes_of(model, Omega) if mode.frequency > lowest]
    hertz = np.array([mode.frequency for mode in computed]) / (2.0 * np.pi)
    if not computed:
        least = lowest / (2.0 * np.pi)
        raise ValueError(f"rotor {rotor.name} has no vibration above {least:.4g} Hz to compare with the measured modes")
    result = []
    for f, zeta in zip(measured.frequencies, measured.damping_ratios, strict=True):
        k = int(np.argmin(np.abs(np.log(hertz / f))))
        result.append(np.log(hertz[k] / f) / FREQUENCY_ERROR)
        ratio = computed[k].damping_ratio
        if np.isfinite(zeta) and zeta > 0.0 and ratio > 0.0:
            result.append(np.log(ratio / zeta) / DAMPING_ERROR)
    return np.array(result)


def _comments(result: Fit, free: Sequence[FreeParameter], measured: str) -> list[str]:
    """Return comment lines for a TOML file, which describe the fitted parameters."""
    lines = [f"# Fitted to {measured} by least squares ({result.residuals} residuals). Values and 95 % intervals:"]
    for p in free:
        fitted = result.parameters[p.name]
        bounds = f"bounds {p.lowest:.6g} to {p.highest:.6g}"
        at = ", at its bound" if fitted.at_bound else ""
        lines.append(f"# {p.name} = {fitted.value:.6g}, {fitted.lower:.6g} to {fitted.upper:.6g} ({bounds}{at})")
    return lines
