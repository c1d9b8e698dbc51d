"""Eddy currents in solid iron: the flux of a coil pair follows its current with a lag of order one half.

    G(s) = 1/(1 + sqrt(s/omega_e)) = int_0^inf c(p) p/(s + p) dp                                                     (1)
    c(p) = 1/(pi sqrt(p omega_e) (1 + p/omega_e)) > 0

with the corner frequency omega_e, which `thrust_bearings.eddy_currents` derives from the iron. The trapezoidal rule in
ln p turns (1) into a sum of first-order lags with positive weights. Such a sum is passive, whatever its error:

    G_n(s) = sum c_k p_k/(s + p_k),   sum c_k = 1                                                                    (2)

Successive poles differ by the factor `RATIO`, beginning at `LOWEST` omega_e. The tails of the integral, below a omega_e
and above b omega_e, have the weights 2/pi atan(sqrt(a)) and 2/pi atan(1/sqrt(b)). Their poles, a/3 and 3 b, preserve
the first moments of the tails. G_n is within 0.05 % of G up to 100 omega_e, 0.1 % up to 1000 omega_e, and 0.25 % up to
10,000 omega_e.

The lagging flux is expressed as an equivalent current v of a coil pair. As a function of v, the force does not depend
on the displacement:

    nonlinear    v = i l/(l -+ x)        the current with the same flux mu_0 N v/l at the centre
    linear       v = i +- x K_s/K_i      F = K_i v

The force is computed from the lagged v, so that F = G(s) (K_i I_c + K_s x) about the centre. The current of a coil pair
is known over a step (`amplifier.Course`), so (2) is solved exactly. The displacement is extrapolated to the middle of
the step, with an error of second order. A change in the number of working turns changes the lagged flux at once.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from amb_actuator.amplifier import CoilCourses, Course
from fmi_export.jit import kernel
from fmi_export.model import Array

RATIO = 3.0
LOWEST = 1e-5  # pole p_2 over the corner frequency
_INNER = 22  # poles between the two of the tails


class HalfOrderLag(NamedTuple):
    """Poles of (2), divided by the corner frequency and in ascending order, and their weights."""

    poles: tuple[float, ...]
    weights: tuple[float, ...]


def _half_order_lag() -> HalfOrderLag:
    inner = [LOWEST * RATIO**k for k in range(_INNER)]
    begin, end = inner[0] / math.sqrt(RATIO), inner[-1] * math.sqrt(RATIO)
    weights = [2.0 / math.pi * math.atan(math.sqrt(begin))]
    weights += [math.log(RATIO) * math.sqrt(p) / (math.pi * (1.0 + p)) for p in inner]
    weights += [2.0 / math.pi * math.atan(1.0 / math.sqrt(end))]
    return HalfOrderLag((begin / 3.0, *inner, 3.0 * end), tuple(weight / sum(weights) for weight in weights))


LAG = _half_order_lag()
POLES, WEIGHTS = LAG
N_POLES = len(POLES)
_LINEAR_MEAN = 1e-3  # decay over a step below which the mean of a lag is that of its ends; exact to 1e-7 of its change


class Flux(NamedTuple):
    """Lagged equivalent current of a coil pair (A), at the end of a step and averaged over it."""

    end: float
    mean: float


@kernel
def steady_flux(lags: Array, v: float) -> Flux:
    """Set the lags (A) of a coil pair to their steady state under an equivalent current v (A)."""
    for k in range(N_POLES):
        lags[k] = v
    return Flux(v, v)


@kernel
def lagged_flux(
    lags: Array, offset: float, slope: float, courses: CoilCourses, mean_current: float, omega_e: float, h: float
) -> Flux:
    """Advance the lags of a coil pair by a step.

    Parameters
    ----------
    lags
        Outputs of the first-order lags (A), shape (N_POLES,); they are changed.
    offset, slope
        Offset (A) and slope (1) of the equivalent current, v = offset + slope times the deviation of the current.
    courses, mean_current
        The coil pair's current during the step and its average, both as deviations from the operating point (A).
    omega_e
        Corner frequency (rad/s).
    h
        Length of the step (s).
    """
    end, mean, mean_input = 0.0, 0.0, offset + slope * mean_current
    for k in range(N_POLES):
        p, begin = omega_e * POLES[k], lags[k]
        value = _followed(p, _followed(p, begin, offset, slope, courses.first), offset, slope, courses.last)
        lags[k] = value
        end += WEIGHTS[k] * value
        z = p * h
        mean += WEIGHTS[k] * (0.5 * (begin + value) if z < _LINEAR_MEAN else mean_input - (value - begin) / z)
    return Flux(end, mean)


@kernel
def _followed(p: float, y: float, offset: float, slope: float, course: Course) -> float:
    """Return the output of a lag y' = p (v - y) at the end of a course, given y at its start; v = offset + slope i.

    With i = i_t + (i_0 - i_t) exp(-r t):

        y(t) = y + (v_t - y) (1 - exp(-p t)) + p slope (i_0 - i_t) (exp(-r t) - exp(-p t))/(p - r)
    """
    t, target = course.duration, offset + slope * course.target
    change = slope * (course.begin - course.target)
    result = y - (target - y) * math.expm1(-p * t)
    if change == 0.0 or t == 0.0:
        return result
    slow, between = min(p, course.rate), abs(p - course.rate) * t
    share = -math.expm1(-between) / between if between > 0.0 else 1.0
    return result + p * change * t * math.exp(-slow * t) * share
