"""Sentences about the quality of measured responses: coherence, and blows of a hammer that follow too closely."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from amb_analysis.measured.records import FrequencyResponse
from array_types import Array

LEAST_COHERENCE = 0.8  # median over frequency, below which the inputs do not explain the output
MOST_LEFT = 0.1  # amplitude at the end of a block, which the next response then contains
MOST_LISTED = 6


def median_coherence(coherence: Array | None) -> float | None:
    """Return the median of a coherence over frequency; None if it was not measured."""
    return None if coherence is None else float(np.median(coherence))


def estimate_warnings(curves: Sequence[FrequencyResponse]) -> list[str]:
    """Return sentences about responses with a low coherence, and about blows that are incomplete or too close."""
    low = [
        f"{curve.name} ({gamma:.2f})"
        for curve in curves
        if (gamma := median_coherence(curve.coherence)) is not None and gamma < LEAST_COHERENCE
    ]
    result = []
    if low:
        result.append(
            f"the median coherence of {listed(low)} is below {LEAST_COHERENCE:g}: the response contains noise or an "
            "input that was not measured, or the window does not suit the record"
        )
    estimate = curves[0].estimate
    if estimate is not None and estimate.incomplete:
        result.append("the record begins within the blow, so that the force is incomplete; record its beginning, too")
    if estimate is not None and (estimate.left or 0.0) > MOST_LEFT:
        result.append(
            f"the response to a blow falls only to {100.0 * (estimate.left or 0.0):.0f} % within {estimate.length:.3g} "
            "s, before the next blow or the end of the record; wait until it has decayed"
        )
    return result


def listed(names: Sequence[str]) -> str:
    """Return the first names, and the number of others."""
    more = f" and {len(names) - MOST_LISTED} more" if len(names) > MOST_LISTED else ""
    return ", ".join(names[:MOST_LISTED]) + more
