"""The actuator: computes forces and their gradients from demanded currents and displacements, for each bearing axis."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from amb_actuator.amplifier import (
    CoilPair,
    CoilResponse,
    coil_courses,
    coil_step,
    commanded_current,
    demanded_current,
    steady_coil,
)
from amb_actuator.eddy_currents import lagged_flux, steady_flux
from amb_actuator.force import Coils, current_per_displacement, force, is_beyond_knee, least_and_most
from amb_actuator.interface import DYNAMIC, NONLINEAR, axes_of, interface_of
from amb_actuator.records import N_DEVIATIONS, N_IRON_STATE, Axes, n_axes_of, views_of
from fmi_export.jit import inlined_kernel, kernel, noinline_kernel, views
from fmi_export.linear_state import LinearState
from fmi_export.model import Array, Model

# Three kinds of fault, each with a code for every axis, and at least `FEWEST_CODES` codes per kind.
GAP, BIAS, VOLTAGE = range(3)
FEWEST_CODES = 10
MAX_BEARINGS = 16  # with a thrust magnet: 33 axes, whose codes of three kinds end at 99
AT_STATOR = 0.99  # of the air gap, up to which the force of a magnet without power follows the displacement
BEYOND_STATOR = 1.1  # of the air gap; no rotor without power that rests on the stator reaches it


class CoilPairs(NamedTuple):
    """The two coil pairs of an axis at the beginning of a step."""

    upper: CoilPair
    lower: CoilPair


class AxisResponse(NamedTuple):
    """Commanded control current of an axis (A) and how its two coil pairs respond to it."""

    i_c: float
    upper: CoilResponse
    lower: CoilResponse


class EquivalentCurrents(NamedTuple):
    """Equivalent currents of both coil pairs (A) as linear functions, such as upper + per_upper times the deviation."""

    upper: float
    per_upper: float
    lower: float
    per_lower: float


@views
def fault_code(kind: int, axis: int, n_axes: int) -> int:
    """Return the fault code for a kind of fault on an axis."""
    return 1 + kind * max(FEWEST_CODES, n_axes) + axis


@inlined_kernel
def is_beyond_gap(axis: np.record, u: np.record) -> bool:
    """Return whether the displacement of an axis is a fault: |x| >= l (air gap) with power, >= 1.1 l without power.

    An energised magnet would pull the rotor into the stator. Without power the rotor may lie on the stator; contact
    then keeps |x| near l.
    """
    limit = BEYOND_STATOR * axis.gap if u.amplifier_off != 0.0 else axis.gap
    return bool(abs(u.displacement) >= limit)


@inlined_kernel
def place_of_force(axis: np.record, u: np.record) -> float:
    """Return the displacement (m) at which the force of an axis is evaluated.

    While the amplifier is on, this is x. Without power it is limited to +-0.99 l, because decaying currents would exert
    an unlimited pull at x = l.
    """
    x: float = u.displacement
    limit = AT_STATOR * axis.gap
    return math.copysign(min(abs(x), limit), x) if u.amplifier_off != 0.0 else x


@inlined_kernel
def coil_currents(axis: np.record) -> tuple[float, float]:
    """Return the coil currents of the upper and the lower pair at the operating point (A)."""
    permanent = axis.permanent_bias
    return axis.static_current + axis.bias_current - permanent, axis.bias_current - permanent


@inlined_kernel
def coil_pairs(axes: Axes, k: int) -> CoilPairs:
    """Return the coil pairs of axis k with their present currents."""
    operating, bias = coil_currents(axes.parameters[k])
    deviation = axes.deviations[k]
    return CoilPairs(CoilPair(operating, 1.0, deviation.upper), CoilPair(bias, -1.0, deviation.lower))


@inlined_kernel
def respond(axes: Axes, k: int, pairs: CoilPairs, step_size: float) -> AxisResponse:
    """Advance the currents of axis k by a step (s), or set them to their steady state if the step is 0 s."""
    axis, u, deviation, amplifier = axes.parameters[k], axes.inputs[k], axes.deviations[k], axes.common[0].amplifier
    i_c = commanded_current(axis, u, amplifier)
    if step_size == 0.0:
        upper, lower = steady_coil(axis, u, pairs.upper, i_c), steady_coil(axis, u, pairs.lower, i_c)
    else:
        upper = coil_step(axis, u, pairs.upper, i_c, amplifier, step_size)
        lower = coil_step(axis, u, pairs.lower, i_c, amplifier, step_size)
    deviation.upper, deviation.lower = upper.current, lower.current
    return AxisResponse(i_c, upper, lower)


@inlined_kernel
def check(axes: Axes) -> int:
    """Return the code of the first fault among the axes, or 0."""
    dynamic, n_axes = axes.common[0].amplifier == DYNAMIC, axes.parameters.shape[0]
    for k in range(n_axes):
        axis = axes.parameters[k]
        with_magnets, bias = axis.static_current + axis.bias_current, axis.bias_current
        least, most = least_and_most(axis.current_limit, axis.permanent_bias)
        upper, lower = coil_currents(axis)
        if is_beyond_gap(axis, axes.inputs[k]):
            return fault_code(GAP, k, n_axes)
        if min(with_magnets, bias) < least or max(with_magnets, bias) > most:
            return fault_code(BIAS, k, n_axes)
        if dynamic and axis.resistance * max(abs(upper), abs(lower)) > axis.voltage_limit:
            return fault_code(VOLTAGE, k, n_axes)
    return 0


@inlined_kernel
def working_share(turns: float, current: float, axis: np.record) -> float:
    """Return the fraction of a coil pair's current that remains effective when only some of the pair's turns work.

    Lost turns do not reduce the contribution of permanent magnets.
    """
    permanent: float = axis.permanent_bias
    return turns if permanent == 0.0 or current == 0.0 else (turns * (current - permanent) + permanent) / current


@inlined_kernel
def working_coils(axes: Axes, k: int, response: AxisResponse) -> Coils:
    """Return the working turns of axis k, and its currents at the end of the step or, with `mean_current`, averaged."""
    axis, u, upper, lower = axes.parameters[k], axes.inputs[k], response.upper, response.lower
    above, below = (upper.mean, lower.mean) if axes.common[0].mean_current != 0.0 else (upper.current, lower.current)
    upper_turns = working_share(1.0 - u.coil_loss_upper, axis.static_current + axis.bias_current + above, axis)
    lower_turns = working_share(1.0 - u.coil_loss_lower, axis.bias_current - below, axis)
    return Coils(above, below, upper_turns, lower_turns)


@kernel
def equivalent_currents(law: float, axis: np.record, x: float) -> EquivalentCurrents:
    """Return the equivalent currents (A) of the coil pairs as functions of their deviations; see `eddy_currents`."""
    if law == NONLINEAR:
        upper, lower = axis.gap / (axis.gap - x), axis.gap / (axis.gap + x)
        above, below = upper * (axis.static_current + axis.bias_current), lower * axis.bias_current
        return EquivalentCurrents(above, upper, -below, lower)
    offset = current_per_displacement(law, axis) * x
    return EquivalentCurrents(offset, 1.0, offset, 1.0)


@kernel
def lagged_coils(axes: Axes, k: int, pairs: CoilPairs, response: AxisResponse, step_size: float) -> Coils:
    """Return the coils of axis k, with currents that correspond to the fluxes after the lag of the eddy currents.

    The lags are advanced by `step_size` (s), or set to a steady state if `step_size` is 0 s.
    """
    coils = working_coils(axes, k, response)
    common, axis, motion, lags = axes.common[0], axes.parameters[k], axes.motion[0], axes.lags[0]
    u = axes.inputs[k]
    x, limit = place_of_force(axis, u), AT_STATOR * axis.gap
    here = equivalent_currents(common.force_law, axis, x)
    if step_size == 0.0:
        upper = steady_flux(lags[0], here.upper + here.per_upper * coils.upper)
        lower = steady_flux(lags[1], here.lower + here.per_lower * coils.lower)
    else:
        middle = min(max(1.5 * x - 0.5 * motion.previous, -limit), limit)
        v = equivalent_currents(common.force_law, axis, middle)
        omega_e = 2.0 * math.pi * axes.iron[0].eddy_current_corner
        courses = coil_courses(axis, u, pairs.upper, response.i_c, common.amplifier, step_size)
        upper = lagged_flux(lags[0], v.upper, v.per_upper, courses, response.upper.mean, omega_e, step_size)
        courses = coil_courses(axis, u, pairs.lower, response.i_c, common.amplifier, step_size)
        lower = lagged_flux(lags[1], v.lower, v.per_lower, courses, response.lower.mean, omega_e, step_size)
    motion.previous = x
    above, below = (upper.mean, lower.mean) if common.mean_current != 0.0 else (upper.end, lower.end)
    return Coils(
        (above - here.upper) / here.per_upper,
        (below - here.lower) / here.per_lower,
        coils.upper_turns,
        coils.lower_turns,
    )


@inlined_kernel
def write_outputs(axes: Axes, k: int, response: AxisResponse, coils: Coils) -> None:
    """Write the outputs of axis k; the currents and turns in `coils` determine its force."""
    p, axis, u, y = axes.common[0], axes.parameters[k], axes.inputs[k], axes.outputs[k]
    x, upper, lower = place_of_force(axis, u), response.upper, response.lower
    y.force, y.gradient = force(p.force_law, axis, x, coils, p.total_force != 0.0)
    if x != u.displacement:
        y.gradient = 0.0
    y.reference = u.displacement
    # A coil pair that has lost all its turns carries no current, whatever its amplifier is commanded.
    has_upper, has_lower = 1.0 if u.coil_loss_upper < 1.0 else 0.0, 1.0 if u.coil_loss_lower < 1.0 else 0.0
    upper_current = has_upper * (axis.static_current + axis.bias_current + upper.current - axis.permanent_bias)
    lower_current = has_lower * (axis.bias_current - lower.current - axis.permanent_bias)
    y.upper_current, y.lower_current = upper_current, lower_current
    y.clipped = 1.0 if u.amplifier_off == 0.0 and response.i_c != demanded_current(axis, u) else 0.0
    y.saturated = 1.0 if is_beyond_knee(axis, x, coils) else 0.0
    y.voltage_limited = max(has_upper * upper.limited, has_lower * lower.limited)
    y.upper_voltage = has_upper * upper.voltage
    y.lower_voltage = has_lower * lower.voltage
    y.copper_loss = axis.resistance * (upper_current * upper_current + lower_current * lower_current)


@noinline_kernel
def advance_lagged_axis(axes: Axes, k: int, step_size: float) -> None:
    """Advance axis k, whose flux, and therefore force, lags behind its currents."""
    pairs = coil_pairs(axes, k)
    response = respond(axes, k, pairs, step_size)
    write_outputs(axes, k, response, lagged_coils(axes, k, pairs, response, step_size))
    axes.outputs[k].gradient = 0.0


@kernel
def advance(axes: Axes, step_size: float) -> int:
    """Advance all axes by a step (s), or set them to a steady state if the step is 0 s, and return the fault code."""
    fault = check(axes)
    if fault != 0:
        return fault
    n = axes.parameters.shape[0]
    n_lagged = 1 if n % 2 == 1 and axes.iron[0].eddy_current_corner != 0.0 else 0
    for k in range(n - n_lagged):
        response = respond(axes, k, coil_pairs(axes, k), step_size)
        write_outputs(axes, k, response, working_coils(axes, k, response))
    if n_lagged != 0:
        advance_lagged_axis(axes, n - 1, step_size)
    return 0


@kernel
def initialise(constants: Array, parameters: Array, inputs: Array, state: Array, work: Array, outputs: Array) -> int:
    """Set the coil currents to their steady state under the first command, and return the fault code."""
    return advance(views_of(constants, parameters, inputs, state, outputs), 0.0)


@kernel
def step(
    constants: Array,
    parameters: Array,
    inputs: Array,
    state: Array,
    work: Array,
    outputs: Array,
    time: float,
    step_size: float,
) -> int:
    """Advance the coil currents by `step_size` (s) under constant inputs, and return the fault code.

    The force is evaluated at the displacement in the inputs.
    """
    return advance(views_of(constants, parameters, inputs, state, outputs), step_size)


def constants_for(bearings: Sequence[str], thrust: str = "") -> Array:
    """Return the constants of an actuator with these bearings and, if `thrust` is given, a thrust magnet."""
    return np.array([len(axes_of(bearings, thrust))], dtype=np.float64)


def n_state(constants: Array) -> int:
    """Return the size of the state of an actuator with these constants."""
    n = n_axes_of(constants)
    return n * N_DEVIATIONS + n % 2 * N_IRON_STATE


def model_for(bearings: Sequence[str], thrust: str = "") -> Model:
    """Return an actuator for bearings with these names; `constants_for` returns its constants for the same names.

    If `thrust` is given, the actuator also has a thrust magnet of that name, with one axis, z, along the shaft.

    Raises
    ------
    ValueError
        If there is no bearing, or there are more bearings than fault codes.
    """
    if not 1 <= len(bearings) <= MAX_BEARINGS:
        raise ValueError(f"{len(bearings)} bearings is not allowed; there must be 1 to {MAX_BEARINGS}")
    return Model(
        name="amb_actuator",
        description="Active magnetic bearings with linear and nonlinear force laws, saturation, amplifiers and faults",
        author="The amb-cosim authors",
        interface=interface_of(bearings, thrust),
        initialise=initialise,
        step=step,
        n_state=n_state,
        n_work=0,
        packages=("amb_actuator", "fmi_export"),
        faults=_fault_sentences(axes_of(bearings, thrust)),
        layout={"bearings": list(bearings), "thrust": thrust},
        linear_state=lambda constants: LinearState(((0, n_state(constants)),)),
    )


def _fault_sentences(axes: Sequence[tuple[str, str]]) -> dict[int, str]:
    sentences = {}
    for k, (b, a) in enumerate(axes):
        bias_current = f"{b}.bias_current_{a} = {{{b}.bias_current_{a}}} A"
        operating = f"{bias_current} plus {b}.static_current_{a} = {{{b}.static_current_{a}}} A"
        gap, bias, voltage = (fault_code(kind, k, len(axes)) for kind in (GAP, BIAS, VOLTAGE))
        sentences[gap] = (
            f"{b}.{a} = {{{b}.{a}}} m is not allowed; the rotor must stay within the air gap, "
            f"|{b}.{a}| < {{{b}.gap_{a}}} m"
        )
        sentences[bias] = (
            f"{operating} is not allowed; the first and the sum must be >= 0 A; of each, permanent magnets provide "
            f"{{{b}.permanent_bias_{a}}} A and the coils the rest, which must be at most {{{b}.current_limit_{a}}} A "
            f"in either direction"
        )
        sentences[voltage] = (
            f"{b}.voltage_limit_{a} = {{{b}.voltage_limit_{a}}} V is not allowed; it must drive {operating} "
            f"through {b}.resistance_{a} = {{{b}.resistance_{a}}} Ohm"
        )
    return sentences
