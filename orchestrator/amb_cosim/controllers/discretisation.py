"""Discretisation of continuous laws by the methods of python-control, applied to balanced states.

    tustin           s -> 2/T (z - 1)/(z + 1); with a prewarped frequency w, w / tan(w T/2) replaces 2/T, so the
                     response at w is that of the continuous law
    zoh, foh         the response to a signal that is held or linear between samples
    euler            s -> (z - 1)/T
    backward_diff    s -> (z - 1)/(T z)
    matched          poles and zeros mapped by z = exp(s T); the laws are equal as s -> 0 (`_matched`);
                     only for one signal and one demand
    impulse          the impulse response

Balancing scales the states by powers of two until the rows and columns of A have similar norms. Rounding errors, which
are mainly due to the matrix exponential, are then small relative to each state. The scaling is undone afterwards
without rounding.
"""

from __future__ import annotations

import warnings
from dataclasses import replace
from typing import Any

import numpy as np

from amb_cosim.controllers.laws import Law, balancing_factors, law_of
from amb_cosim.cosim.system.values import Raw, quantity
from amb_files.suggestions import suggest

METHODS = ("tustin", "zoh", "foh", "euler", "backward_diff", "matched", "impulse")
AT_REST = 1e-12  # s T of a pole or zero at s = 0, up to rounding
SAMPLE_TIMES = (1e-6, 0.1)  # s


def check_sample_time(sample_time: Raw) -> float:
    """Return a sample time (s), a number or a text with its unit; raise ValueError if it is not allowed."""
    low, high = SAMPLE_TIMES
    value = quantity(sample_time, "s", "sample_time")
    if not low <= value <= high:
        raise ValueError(f"sample_time = {value:g} s is not allowed; it must be >= {low:g} and <= {high:g} s")
    return value


def sampled(law: Law, sample_time: float, method: str = "tustin", prewarp: float | None = None) -> Law:
    """Return the sampled law; a law that is already sampled is returned unchanged.

    Parameters
    ----------
    law
        Continuous law, or law sampled at `sample_time`.
    sample_time
        Sample time (s).
    method
        One of `METHODS`, for a continuous law.
    prewarp
        Frequency (rad/s) at which `tustin` preserves the response; none by default.

    Raises
    ------
    ValueError
        If the law has another sample time, or the method or frequency is not allowed.
    """
    check_sample_time(sample_time)
    if method not in METHODS:
        raise ValueError(f"no discretisation {method!r}; {suggest(method, METHODS)}")
    if law.sample_time is not None:
        if law.sample_time != 0.0 and abs(law.sample_time / sample_time - 1.0) > 1e-9:
            raise ValueError(
                f"a law sampled at {law.sample_time:g} s is not allowed with sample_time = {sample_time:g} s; the "
                "sample times must be equal"
            )
        return law
    if prewarp is not None and method != "tustin":
        raise ValueError(f"prewarp is not allowed with {method}; only tustin supports it")
    nyquist = np.pi / sample_time
    if prewarp is not None and not 0.0 < prewarp < nyquist:
        raise ValueError(
            f"prewarp = {prewarp:g} rad/s is not allowed; it must be > 0 and below half the sampling frequency, "
            f"{nyquist:g} rad/s"
        )
    if method == "matched" and law.D.shape != (1, 1):
        raise ValueError("matched is not allowed for several signals or demands; it requires one signal and one demand")
    return _sampled(law, sample_time, method, prewarp) if len(law.A) else replace(law, sample_time=sample_time)


def _sampled(law: Law, sample_time: float, method: str, prewarp: float | None) -> Law:
    import control

    scale = balancing_factors(law.A)
    balanced = control.ss(
        law.A * scale[None, :] / scale[:, None], law.B / scale[:, None], law.C * scale[None, :], law.D
    )
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        try:
            if method == "matched":
                return replace(law_of(_matched(control.ss2tf(balanced), sample_time)), sample_time=sample_time)
            result = balanced.sample(sample_time, method, prewarp_frequency=prewarp)
        except (ValueError, ArithmeticError, RuntimeWarning, np.linalg.LinAlgError) as error:
            raise ValueError(f"the law cannot be sampled by {method}: {error}") from error
    A = result.A * scale[:, None] / scale[None, :]
    return Law(A, result.B * scale[:, None], result.C / scale[None, :], result.D, sample_time)


def _matched(system: Any, sample_time: float) -> Any:
    """Return the matched law of a transfer function.

    Unlike python-control, this does not divide by zero if the function has a pole or zero at s = 0.

    Let z_i be the zeros and p_i the poles, let n be the number of zeros minus the number of poles at s = 0, and let
    primes denote products over all other zeros or poles. Then

        K(s) = k prod (s - z_i)/prod (s - p_i),    K_d(z) = k_d prod (z - exp(z_i T))/prod (z - exp(p_i T))    (1)
        k_d T^n prod' (1 - exp(z_i T))/prod' (1 - exp(p_i T)) = k prod' (-z_i)/prod' (-p_i)                    (2)

    because z - 1 -> s T. This preserves the static gain, or the rate of integration.
    """
    import control
    from scipy.signal import tf2zpk

    zeros, poles, gain = tf2zpk(system.num[0][0], system.den[0][0])
    for roots in (zeros, poles):
        roots[np.abs(roots) * sample_time < AT_REST] = 0.0
    order = np.sum(zeros == 0.0) - np.sum(poles == 0.0)
    others = [roots[roots != 0.0] for roots in (zeros, poles)]
    slow = np.prod(-others[0]) / np.prod(-others[1])
    fast = np.prod(-np.expm1(others[0] * sample_time)) / np.prod(-np.expm1(others[1] * sample_time))
    factor = gain * np.real(slow / fast) / sample_time**order
    return control.zpk(np.exp(zeros * sample_time), np.exp(poles * sample_time), factor, sample_time)
