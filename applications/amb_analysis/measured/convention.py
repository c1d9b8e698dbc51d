"""Sign and time convention of measured responses, compared with computed ones.

For the computed response H_c and the measured response H_m at n frequencies,

    z = 1/n sum H_c/H_m |H_m/H_c|                                                                  (1)

has the angle 0 if H_m and H_c agree, and 180 degrees if the force or the sensor points in the opposite direction. FRAC,
MAC and the levels do not reveal a reversed direction, and no parameter of a rotor can compensate for it. An angle of 90
degrees indicates that a measured velocity was taken for a displacement or an acceleration.

Data in the convention exp(-j omega t) have conjugate values and appear to have unstable poles
(`modal_fit.is_conjugate`). For such data, the following sums over frequency, with unit phasors u = H/|H|,

    q_re = sum Re u_m Re u_c/sum |Re u_m Re u_c|,   q_im = sum Im u_m Im u_c/sum |Im u_m Im u_c|    (2)

are near 1 and -1, respectively. They show the convention even if the frequency lines are too coarse to show growing
poles.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby

import numpy as np

from amb_analysis.measured.modal_fit import is_conjugate
from amb_analysis.measured.records import FrequencyResponse
from array_types import Complex

LEAST = 0.5  # |z| above which (1) has an angle
ALIKE = 1.0  # standard deviation of ln |H_c/H_m| below which both are of one system
OFF = 45.0  # degrees
OPPOSITE = 0.8  # of (2)
REAL = 1e-9  # largest imaginary part over the amplitude of an amplitude without a phase


def phase_offset(measured: Complex, computed: Complex) -> float | None:
    """Return the angle of (1) in degrees, from -180 to 180; None if the curves differ too much for a valid angle.

    Parameters
    ----------
    measured, computed
        Responses at the same frequencies, shape (n,); the measured values must not be 0.
    """
    on = computed != 0.0
    if not on.any():
        return None
    ratio = computed[on] / measured[on]
    z = complex(np.mean(ratio / np.abs(ratio)))
    if abs(z) < LEAST or float(np.std(np.log(np.abs(ratio)))) > ALIKE:
        return None
    return float(np.degrees(np.angle(z)))


def are_conjugate(measured: Sequence[Complex], computed: Sequence[Complex]) -> bool:
    """Return whether, by (2), responses agree with computed ones except for the sign of their imaginary parts.

    Parameters
    ----------
    measured, computed
        Values of several responses, shape (n,) each.
    """
    u_m, u_c = (np.concatenate([H / np.maximum(np.abs(H), 1e-300) for H in values]) for values in (measured, computed))
    q_re, q_im = (
        float(np.sum(products) / max(float(np.sum(np.abs(products))), 1e-12))
        for products in (u_m.real * u_c.real, u_m.imag * u_c.imag)
    )
    return q_re > OPPOSITE and q_im < -OPPOSITE


def _is_real(values: Complex) -> bool:
    return bool((np.abs(values.imag) <= REAL * np.abs(values)).all())


def contradictions(curves: Sequence[FrequencyResponse], values: Sequence[Complex]) -> tuple[str, ...]:
    """Return sentences about measured responses whose sign, quantity or time convention contradicts the computed ones.

    Parameters
    ----------
    curves
        Measured responses.
    values
        Computed values of each response, shape (n,).
    """
    result = []
    for _, group in groupby(zip(curves, values, strict=True), lambda pair: pair[0].frequencies.tobytes()):
        pairs = list(group)
        measured = [curve for curve, _ in pairs]
        if is_conjugate(measured) or are_conjugate([curve.values for curve in measured], [v for _, v in pairs]):
            names = ", ".join(curve.name for curve, _ in pairs)
            result.append(
                f"the measured phase of {names} rises through resonance, as with exp(-j omega t): "
                "change the sign of phases or of imaginary parts"
            )
            continue
        for curve, computed in pairs:
            if _is_real(curve.values) and not _is_real(computed):
                result.append(
                    f"the measured {curve.name} has no phase: its imaginary parts are 0; export complex values"
                )
                continue
            angle = phase_offset(curve.values, computed)
            if angle is None or abs(angle) < OFF:
                continue
            reversed_ = abs(angle) > 180.0 - OFF
            cause = (
                "is the force or the sensor reversed?" if reversed_ else "is it another quantity, such as a velocity?"
            )
            size = 180 if reversed_ else 90
            result.append(f"the measured phase of {curve.name} is off by {size} degrees: {cause}")
    return tuple(result)
