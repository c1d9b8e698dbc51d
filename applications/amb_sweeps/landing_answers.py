"""Answers of a sample of landings: how often they whirl, with which loads, and what drives it, with intervals."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from amb_cosim.presentation.units import force_unit, temperature_text
from amb_cosim.results.touchdown import WHIRL_TURNS
from amb_sweeps.intervals import CONFIDENCE, Interval, probability, quantile, runs_for_bounds
from amb_sweeps.outcomes import BROKEN_OFF
from amb_sweeps.sampling import SAMPLE, SamplePlan

if TYPE_CHECKING:
    import xarray as xr

UNANSWERED = 0.05  # share of undecided and failed landings above which a probability is no answer
SIGNIFICANT = 0.05  # largest probability by chance of a correlation that is printed
ORDERS = (0.5, 0.95)
QUANTITIES: dict[str, tuple[str, Callable[[float], str]]] = {
    "averaged_contact_force": ("force averaged over 1 ms", lambda value: force_unit(value).text(value)),
    "contact_time": ("time in contact", lambda value: f"{value:.3g} s"),
    "heat": ("heat at a retainer", lambda value: f"{value:.4g} J"),
    "temperature": ("temperature", temperature_text),
}


def landing_lines(design: SamplePlan, part: xr.Dataset) -> list[str]:
    """Return the answers of a sample of landings; none for grids, and for runs that do not lose their power.

    A landing whirls from 10 net backward turns on (`touchdown.landing_whirl`). Failed landings and those whose run ends
    too early widen the interval of the probability. Quantiles are separate for landings with and without whirl,
    because a quantile of both would only show their proportion.
    """
    if design.method not in ("random", "lhs", "sobol") or "whirl_number" not in part:
        return []
    numbers, outcomes = part["whirl_number"].values.ravel(), part["outcome"].values.ravel()
    failed, landed = np.isin(outcomes, BROKEN_OFF), ~np.isnan(numbers)
    counted = failed | landed
    if not landed.any() or (~counted & (outcomes != "")).any():
        return []
    decided = part["whirl_decided"].values.ravel() == 1.0
    whirls = numbers >= WHIRL_TURNS
    return [
        _probability(whirls, landed & ~decided, failed, int(counted.sum()), design),
        *_quantiles(part, whirls, "with whirl"),
        *_quantiles(part, landed & decided & ~whirls, "without whirl"),
        *_drivers(part, whirls, landed & decided),
    ]


def _probability(
    whirls: NDArray[np.bool_], undecided: NDArray[np.bool_], failed: NDArray[np.bool_], runs: int, design: SamplePlan
) -> str:
    count, open_, lost = (int(which.sum()) for which in (whirls, undecided, failed))
    interval = probability(count, runs, open_ + lost)
    exact = (
        "" if design.method == "random" else f"; not exact, because the points of {design.method} are not independent"
    )
    without = [f"{n} {what}" for n, what in ((open_, "undecided when the run ended"), (lost, "failed")) if n]
    beside = f"; {' and '.join(without)}, counted as either" if without else ""
    if open_ + lost > UNANSWERED * runs:
        beside += ", so the question is unanswered" + ("; a later `until` lets the runs last longer" if open_ else "")
    return (
        f"whirl in {count} of {runs} landings: {_share(interval)} ({100.0 * CONFIDENCE:g} % confidence{exact}){beside}"
    )


def _share(interval: Interval) -> str:
    low, high = 100.0 * (interval.low or 0.0), 100.0 * (1.0 if interval.high is None else interval.high)
    if interval.value == 0.0 and low == 0.0:
        return f"less than {high:.3g} %"
    if interval.value == 1.0 and high == 100.0:
        return f"more than {low:.3g} %"
    return f"{low:.3g} to {high:.3g} %"


def _quantiles(part: xr.Dataset, which: NDArray[np.bool_], kind: str) -> Iterator[str]:
    """Yield a line for each quantity of the landings of a kind."""
    for name, (words, text) in QUANTITIES.items():
        values = part[name].values.ravel()[which] if name in part else np.empty(0)
        values = values[~np.isnan(values)]
        if not len(values):
            continue
        parts = []
        for order in ORDERS:
            interval = quantile(values, order)
            label = "median" if order == 0.5 else f"{100.0 * order:g} % below"
            if interval.low is None or interval.high is None:
                bounds = f"at least {runs_for_bounds(order)} landings needed for both bounds"
            else:
                bounds = f"{text(interval.low)} to {text(interval.high)}"
            parts.append(f"{label} {text(interval.value)} ({bounds})")
        yield f"{words}, {len(values)} landings {kind}: {', '.join(parts)}"


def _drivers(part: xr.Dataset, whirls: NDArray[np.bool_], decided: NDArray[np.bool_]) -> list[str]:
    """Return a line with the rank correlations of whirl with the sampled variables, largest first."""
    from scipy.stats import spearmanr

    inputs = [name for name, values in part.coords.items() if values.dims == (SAMPLE,) and values.dtype.kind == "f"]
    if part["outcome"].dims != (SAMPLE,) or not inputs or len(set(whirls[decided])) < 2:
        return []
    correlations = {str(name): spearmanr(part[name].values[decided], whirls[decided]) for name in inputs}
    named = [name for name in correlations if correlations[name].pvalue < SIGNIFICANT]
    named.sort(key=lambda name: -abs(correlations[name].statistic))
    texts = [f"{name} {correlations[name].statistic:+.2f} (p = {correlations[name].pvalue:.2g})" for name in named]
    tested = f"rank correlation of whirl, {len(inputs)} variables tested without correction"
    return [f"{tested}: {', '.join(texts) or f'none with p below {SIGNIFICANT:g}'}"]
