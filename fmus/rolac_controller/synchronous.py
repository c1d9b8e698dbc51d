"""Synchronous control: what it may do now, and the forces of all harmonics by the law that is chosen."""

from __future__ import annotations

from fmi_export.jit import kernel
from fmi_export.model import Array
from rolac_controller import stored
from rolac_controller.adaptation import N_U, limit, step_of
from rolac_controller.arrays import Scratch, State
from rolac_controller.contact import turn_step
from rolac_controller.fourier import N_Q
from rolac_controller.interface import (
    ALPHA,
    CONTACT_AWARE,
    CONTACT_LEAD,
    ENABLE,
    EXTRAPOLATE,
    FORCE_LIMIT,
    MIN_SPEED,
    MODE,
    OMEGA,
    SAMPLE_TIME,
)
from rolac_controller.names import (
    ADAPTING,
    FORCE_FREE,
    HELD,
    N_BEARINGS,
    N_HARMONICS,
    NO_H,
    NO_WINDOW,
    NOTCH,
    OFF,
    SUSPECT,
    TOO_SLOW,
)
from rolac_controller.names import OLAC as OLAC_MODE
from rolac_controller.names import ROLAC as ROLAC_MODE
from rolac_controller.notch import reject
from rolac_controller.olac import due


@kernel
def permitted(parameters: Array, inputs: Array, valid: bool, suspect: bool, identifying: bool) -> int:
    """Status of the synchronous control before the table is asked."""
    if inputs[ENABLE] == 0.0:
        return OFF
    if inputs[OMEGA] < parameters[MIN_SPEED]:
        return TOO_SLOW
    if not valid:
        return NO_WINDOW
    if suspect:
        return SUSPECT
    return HELD if identifying else ADAPTING


@kernel
def update(parameters: Array, inputs: Array, status: int, turn: float, s: State, x: Scratch) -> tuple[int, bool, bool]:
    """Bring the synchronous forces one sample further.

    Parameters
    ----------
    status
        As `permitted` found it. Forces stay under HELD and vanish under everything but ADAPTING.
    turn
        Angle since the sample before (rad).

    Returns
    -------
    status, extrapolated, limited
        The status, NO_H where H is missing for a harmonic; whether H is that of the nearest speed; whether a force
        is at its limit.
    """
    if status == HELD:
        return status, False, limit(s.forces, parameters[FORCE_LIMIT])
    extrapolated = False
    if status == ADAPTING:
        now = parameters[MODE] != OLAC_MODE or due(parameters, turn, x.q, s.olac)
        for k in range(N_HARMONICS):
            if x.orders[k] == 0.0:
                break
            found = step_harmonic(parameters, inputs, k, now, s, x)
            extrapolated = extrapolated or found == stored.BEYOND
            if found == stored.MISSING or (found == stored.BEYOND and parameters[EXTRAPOLATE] == 0.0):
                status = NO_H
    if status != ADAPTING:
        s.forces[:] = 0.0
        s.olac[:] = 0.0
        return status, False, False
    return status, extrapolated, limit(s.forces, parameters[FORCE_LIMIT])


@kernel
def step_harmonic(parameters: Array, inputs: Array, number: int, now: bool, s: State, x: Scratch) -> int:
    """Advance the forces of one harmonic, if `now`; what the table had for it."""
    omega = x.orders[number] * inputs[OMEGA]
    low, high, share, found = stored.bracket(s.table, x.orders[number], inputs[OMEGA])
    if found == stored.MISSING or not now:
        return found
    mode = parameters[MODE]
    gain = parameters[ALPHA] * parameters[SAMPLE_TIME]
    q = x.q[number * N_Q : (number + 1) * N_Q]
    force = s.forces[number * N_U : (number + 1) * N_U]
    if mode in (NOTCH, FORCE_FREE):
        stored.interpolate(s.table, stored.R, low, high, share, x.matrix)
        reject(parameters, x.matrix, omega, gain, mode == FORCE_FREE, q, force, x.rest)
        return found
    stored.interpolate(s.table, stored.H, low, high, share, x.matrix)
    step_of(x.matrix, gain if mode == ROLAC_MODE else 1.0, q, x.change)
    if mode == ROLAC_MODE and parameters[CONTACT_AWARE] != 0.0:
        for bearing in range(N_BEARINGS):
            turn_step(s.contact[bearing], parameters[CONTACT_LEAD], q, x.change, bearing)
    for i in range(N_U):
        force[i] += x.change[i]
    return found
