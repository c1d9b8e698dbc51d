"""Warnings of a run: outputs that FMUs declare as warnings, and other logged warnings."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass

import numpy as np

from amb_cosim.cosim.fmu.fmu_interface import Port
from amb_cosim.cosim.record.signals import Signals
from array_types import Array, Bools

ATTRIBUTE = "warnings"  # of a data set

# What the slaves of this project log: `at t = 0.0125 s: west.clipped_x: the demanded current is limited ..`.
_LOGGED = re.compile(r"(?:initialisation|at t = (?P<time>\S+) s): (?P<variable>\S+): (?P<sentence>.*)", re.DOTALL)


@dataclass(frozen=True)
class WarningRecord:
    """A warning of a component.

    Attributes
    ----------
    component, variable
        Output that became true; `variable` is empty for other logged warnings.
    kind
        The declared sentence without values and places, which is the same for all outputs with this warning.
    sentence
        The sentence with the values at the time of logging; for recorded outputs, with the range of values while the
        warning was true.
    first, last
        First and last time at which it was true (s); the first may be before time 0, during settling.
    share
        Share of the time from 0 on for which it was true (`share_of_time`), or None if no step follows. `last` and
        `share` are None if the output was not recorded.
    sampled
        Whether `last` and `share` are those of a thinned record's samples, not of all steps.
    """

    component: str
    variable: str
    kind: str
    sentence: str
    first: float | None = None
    last: float | None = None
    share: float | None = None
    sampled: bool = False


def of_component(
    component: str,
    ports: Mapping[str, Port],
    log: Sequence[str],
    start: float,
    times: Array,
    recorded: Mapping[str, Array],
) -> list[WarningRecord]:
    """Return the warnings of a component.

    Parameters
    ----------
    component, ports
        The component's name and variables.
    log
        Warnings that the component logged.
    start
        Time of the initialisation (s).
    times, recorded
        Times of the samples (s), and samples of the recorded variables, by name.
    """
    logged: dict[str, tuple[float, str]] = {}
    others: list[WarningRecord] = []
    for text in dict.fromkeys(log):
        match = _LOGGED.fullmatch(text)
        if match is not None and match["variable"] in ports:
            # logged once in a run, and again where the run continues from a checkpoint
            logged.setdefault(match["variable"], (float(match["time"] or start), match["sentence"]))
        else:
            others.append(WarningRecord(component, "", text, text))
    outputs = {name: values for name, values in recorded.items() if name in ports and ports[name].causality == "output"}
    declared = (
        _of_output(component, port, logged.get(port.name), times, outputs) for port in ports.values() if port.warning
    )
    return [*(warned for warned in declared if warned is not None), *others]


def _of_output(
    component: str, port: Port, logged: tuple[float, str] | None, times: Array, recorded: Mapping[str, Array]
) -> WarningRecord | None:
    """Return the warning of an output, or None if the output was never true."""
    samples = recorded.get(port.name)
    true_times = times[:0] if samples is None else times[samples != 0.0]
    if logged is None and not len(true_times):
        return None
    first, sentence = logged or (float(true_times[0]), re.sub(r"[{}]", "", port.warning))
    if logged is not None and samples is not None:
        during = {name: values[samples != 0.0] for name, values in recorded.items() if f"{{{name}}}" in port.warning}
        sentence = _with_ranges(port.warning, sentence, during)
    last, share = None, None
    if samples is not None and (times >= 0.0).any():
        last = float(max(true_times[-1], first)) if len(true_times) else first
        share = share_of_time(times, samples != 0.0)
    return WarningRecord(component, port.name, _kind(port), sentence, first, last, share)


def share_of_time(times: Array, true: Bools) -> float | None:
    """Return the share of the time from 0 on for which an output was true; None if no step follows time 0.

        share = sum of h_k over the steps with a true sample / sum of h_k,    h_k = t_k - t_(k-1)

    An output describes the step that ends at its sample, so that the sample at time 0 describes a step before it.

    Parameters
    ----------
    times
        Times of the samples (s), shape (n,).
    true
        Whether the output was true, shape (n,).
    """
    steps = np.where(times > 0.0, np.diff(times, prepend=np.minimum(times[:1], 0.0)), 0.0)
    return float(steps @ true / steps.sum()) if steps.any() else None


def _with_ranges(declared: str, sentence: str, during: Mapping[str, Array]) -> str:
    """Replace each value in a logged sentence by the range of this value and its variable's samples in `during`."""
    texts = re.split(r"\{([^}]*)\}", declared)  # texts and, between them, variables
    logged = re.fullmatch("(.*)".join(map(re.escape, texts[::2])), sentence, re.DOTALL)
    if logged is None:
        return sentence
    result = texts[0]
    for name, value, text in zip(texts[1::2], logged.groups(), texts[2::2], strict=True):
        limits = (
            [f"{limit(during[name], initial=float(value)):.6g}" for limit in (np.min, np.max)] if name in during else []
        )
        result += (" to ".join(dict.fromkeys(limits)) or value) + text
    return result


def _kind(port: Port) -> str:
    """Return an output's sentence without values and without the place in its name, such as `seal` in `seal.passed`."""
    place, _, variable = port.name.partition(".")
    sentence = re.sub(r"\{[^}]*\}", "{}", port.warning)
    return re.sub(rf"\b{re.escape(place)}\b", "*", sentence, flags=re.IGNORECASE) if variable else sentence


def to_json(warnings: Sequence[WarningRecord]) -> str:
    """Return warnings as JSON text, which `warnings_of` reads."""
    return json.dumps([asdict(warned) for warned in warnings])


def warnings_of(dataset: Signals) -> list[WarningRecord]:
    """Return the warnings of a data set's run."""
    return [WarningRecord(**warned) for warned in json.loads(dataset.attrs.get(ATTRIBUTE, "[]"))]


def sentences(warnings: Sequence[WarningRecord]) -> list[str]:
    """Return a sentence for each kind of warning: what, where, when, and for which share of the time."""
    kinds: dict[tuple[str, str], list[WarningRecord]] = {}
    for warned in warnings:
        kinds.setdefault((warned.component, warned.kind), []).append(warned)
    return [_sentence(alike) for alike in kinds.values()]


def _sentence(alike: Sequence[WarningRecord]) -> str:
    earliest = min(alike, key=lambda warned: -np.inf if warned.first is None else warned.first)
    where = ", ".join(warned.variable for warned in alike if warned.variable) or earliest.component
    return f"{earliest.sentence} ({where}{_when(alike)})"


def _when(alike: Sequence[WarningRecord]) -> str:
    """Return the beginning, the end and the share of the time in words."""
    starts = [warned.first for warned in alike if warned.first is not None]
    if not starts:
        return ""
    first, ends = min(starts), [warned.last for warned in alike if warned.last is not None]
    last = max(ends, default=None)
    if last is not None and last < 0.0:
        return "; only before time 0, during settling"
    begin = "before time 0" if first < 0.0 else f"{first:.4g} s"
    if last is None:
        return f"; first at {begin}" if first >= 0.0 else f"; first {begin}"
    end = f"{last:.4g} s"
    span = f"; at {end}" if begin == end else f"; from {begin} to {end}"
    shares = [warned.share for warned in alike if warned.share is not None]
    if not shares:
        return span
    total = "samples" if any(warned.sampled for warned in alike) else "time"
    return f"{span}, {_percent(max(shares), 'up to ' if len(alike) > 1 else '')} of the {total}"


def _percent(share: float, most: str) -> str:
    return "less than 0.1 %" if share < 1e-3 else f"{most}{100.0 * share:.3g} %"
