"""Totals of a contact site in a step: peaks, impulses, heat and means, collected from substeps, pieces and impacts.

An output that is collected over a step is declared in `site_variables`. In this module, such an output has a field in
`COLLECTED` or `SITE_INTEGRALS`, whose fields start each step at zero, or in `SITE_STATE` if it grows from step to step.
The functions called in each step must also handle the output; they are called in this order:

    begin_step -> (set_rates, collect_substep | collect_piece | collect_impact)* -> end_step -> average,
    advance_temperature -> write_totals
"""

from __future__ import annotations

import math

import numpy as np

from fmi_export.jit import kernel
from fmi_export.records import record, size_of
from rotor_contact.shaft.lobatto import LOBATTO_WEIGHTS, N_LOBATTO, greatest_of_cubic, greatest_of_parabola
from rotor_contact.variables.enumerations import FREE, SLIDING

COLLECTED = (  # fields of `site.SITE` that are zero when a step begins
    ("f_n", np.float64),  # normal and friction force (N) of the last solution
    ("f_t", np.float64),
    ("f_n_peak", np.float64),  # largest normal force (N) in this step
    ("f_n_mean", np.float64),  # mean normal force (N) over this step, the impulses of impacts in it included
    ("impulse", np.float64),  # normal impulse (N s) of the impacts in this step
    ("impact_heat", np.float64),  # heat (J) of these impacts
    ("drive_work", np.float64),  # work (J) of the drive against their friction
)
# Integrals over the step, from zero: heat of friction, drag and compression (J); normal force (N s, without impacts).
SITE_INTEGRALS = record(("heat", np.float64), ("f_n", np.float64))
# Mode and direction of slip; temperature (K); heat so far (J).
SITE_STATE = record(("mode", np.float64), ("slip_sign", np.float64), ("temperature", np.float64), ("heat", np.float64))

Fields = tuple[tuple[str, object], ...]
Nodes = np.ndarray[tuple[int], np.dtype[np.record]]  # of type `matrix_sizes.NODE`, those of a site


def places_of(fields: Fields, dtype: np.dtype[np.record]) -> tuple[int, int]:
    """Return the position of the first of several adjacent fields in a record, and the position after the last."""
    first = dict(dtype.fields or {})[fields[0][0]][1] // 8
    return first, first + size_of(record(*fields))


@kernel
def begin_step(site: np.record, state: np.record) -> None:
    """Set the mode of a site, and the sign of its slip, from its state."""
    site.mode = int(state.mode)
    site.slip_sign = state.slip_sign


@kernel
def set_rates(site: np.record, heat: float, rate: np.record) -> None:
    """Write the rates of the site's integrals; `heat` is the heat flow (W) of friction, drag and compression."""
    rate.heat = heat
    rate.f_n = site.f_n if site.mode != FREE else 0.0


@kernel
def collect_substep(site: np.record, begin: np.record, second: np.record, third: np.record, end: np.record) -> None:
    """Update the largest normal force from a parabola through the normal forces at the stages of a substep.

    At the midpoint, the mean of the two stages is one order more accurate than either stage alone.
    """
    site.f_n_peak = max(site.f_n_peak, greatest_of_parabola(begin.f_n, 0.5 * (second.f_n + third.f_n), end.f_n))


@kernel
def collect_piece(site: np.record, nodes: Nodes, h: float, of_site: np.record) -> float:
    """Add a piece of length h (s) to the totals of a constrained site; return the heat (J) -int T v_slip dt."""
    a, b, c, d = nodes[0], nodes[1], nodes[2], nodes[3]
    site.f_n_peak = max(site.f_n_peak, greatest_of_cubic(a.f_n, b.f_n, c.f_n, d.f_n))
    heat = 0.0
    for point in range(N_LOBATTO):
        share = h * LOBATTO_WEIGHTS[point]
        of_site.f_n += share * nodes[point].f_n
        if site.mode == SLIDING:
            heat -= share * nodes[point].f_t * nodes[point].slip
    return heat


@kernel
def collect_impact(site: np.record, heat: float) -> None:
    """Add the normal impulse `p_n` (N s) and the heat (J) of an impact to the totals."""
    site.impulse += site.p_n
    site.impact_heat += heat


@kernel
def end_step(site: np.record, state: np.record, of_site: np.record) -> None:
    """Store the results of a step in the state of a site; add the heat of impacts to the heat of the step."""
    state.mode = site.mode
    state.slip_sign = site.slip_sign
    of_site.heat += site.impact_heat
    state.heat += of_site.heat


@kernel
def average(site: np.record, of_site: np.record, step_size: float) -> None:
    """Set the mean normal force over a step of `step_size` (s)."""
    site.f_n_mean = (of_site.f_n + site.impulse) / step_size


@kernel
def advance_temperature(site: np.record, state: np.record, heat: float, ambient: float, step_size: float) -> None:
    """Update the temperature (K) in the `state` of a site after a step of `step_size` (s) that produced `heat` (J).

    A retainer is one heat capacity, C T' = P - h (T - T_ambient). P is the heat flow from friction, race drag and
    impacts, assumed constant over a step.
    """
    if site.heat_capacity == 0.0:
        return
    exponent = site.heat_transfer * step_size / site.heat_capacity
    mean_share = -math.expm1(-exponent) / exponent if exponent > 1e-12 else 1.0
    excess = (state.temperature - ambient) * math.exp(-exponent) + heat / site.heat_capacity * mean_share
    state.temperature = ambient + excess


@kernel
def write_totals(site: np.record, y: np.record) -> None:
    """Write the outputs that are collected over a step; the largest force includes the final force, which is in `y`."""
    y.f_n_peak = max(site.f_n_peak, y.f_n)
    y.f_n_mean = site.f_n_mean
    y.impulse = site.impulse
