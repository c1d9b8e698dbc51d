"""Contact with the retainer bearings: how much of it there is, and an adaptation that counts with it.

A journal in contact is held on its circle by a force -N q/c, like a spring N/c between the journal and the centre.
With D = R_b^-1, the dynamic stiffness of the free rotor at the bearings, the total force on it is F = (D + N/c) q. To
let it go, U must change along -F. ROLAC changes it along H Q ~ -D q, which is the wrong way where Re D < 0: above the
critical speed of a mode the response turns by more than 90 degrees when the mode gets stiff through contact. The
phase of D + N/c lies between 0 (stiffness) and 90 degrees (damping). Contact-aware adaptation therefore keeps the size
of the step and turns it against the journal's displacement, with a lead psi, by the share p of contact:

    U_b' = alpha [ (1 - p) (H Q)_b - p exp(j psi) |(H Q)_b| q_b/|q_b| ]           for each bearing b

With p = 0 it is ROLAC. It draws the journals in until they are free, and ROLAC then finds the optimum.
"""

from __future__ import annotations

import math

from fmi_export.jit import kernel
from fmi_export.model import Array
from rolac_controller.interface import CLEARANCE, CONTACT_SOURCE, CONTACT_STATE, THRESHOLD
from rolac_controller.names import GIVEN, N_BEARINGS, NO_SOURCE, OWN_SENSORS, SENSOR_OF_AXIS


@kernel
def touches(parameters: Array, inputs: Array, measured: Array, bearing: int) -> bool:
    """Whether a journal is in contact, as `contact.source` tells."""
    source = parameters[CONTACT_SOURCE]
    if source == GIVEN:
        return int(inputs[CONTACT_STATE]) >> bearing & 1 == 1
    if source == OWN_SENSORS:
        x, y = measured[SENSOR_OF_AXIS[2 * bearing]], measured[SENSOR_OF_AXIS[2 * bearing + 1]]
        return bool(math.hypot(x, y) >= parameters[THRESHOLD] * parameters[CLEARANCE])
    return False


@kernel
def watch(parameters: Array, inputs: Array, measured: Array, turn: float, shares: Array) -> bool:
    """Keep the share of contact of each bearing, a running mean with the time constant of a revolution.

    Parameters
    ----------
    measured
        Displacements, shape (N_SENSORS,) (m).
    turn
        Angle since the sample before (rad).
    shares
        Shape (N_BEARINGS,), in [0, 1]; changed.

    Returns
    -------
    bool
        Whether any journal is in contact now.
    """
    if parameters[CONTACT_SOURCE] == NO_SOURCE:
        return False
    weight = min(abs(turn) / (2.0 * math.pi), 1.0)
    any_contact = False
    for bearing in range(N_BEARINGS):
        now = touches(parameters, inputs, measured, bearing)
        any_contact = any_contact or now
        shares[bearing] += weight * ((1.0 if now else 0.0) - shares[bearing])
    return any_contact


@kernel
def turn_step(share: float, lead: float, q: Array, change: Array, bearing: int) -> None:
    """Turn a step of the adaptation against the displacement of one bearing, by its share of contact.

    Parameters
    ----------
    share, lead
        p and psi (rad), see above.
    q
        Synchronous displacements, re and im, shape (2 N_SENSORS,) (m).
    change
        Step of the forces, re and im, shape (2 N_AXES,) (N); changed.
    """
    first = 4 * bearing
    of_step = of_q = 0.0
    for i in range(4):
        of_step += change[first + i] ** 2
        of_q += q[2 * SENSOR_OF_AXIS[2 * bearing + i // 2] + i % 2] ** 2
    if of_q == 0.0:
        return
    size = share * math.sqrt(of_step / of_q)
    cos, sin = size * math.cos(lead), size * math.sin(lead)
    for axis in range(2):
        k, s = first + 2 * axis, 2 * SENSOR_OF_AXIS[2 * bearing + axis]
        change[k] = (1.0 - share) * change[k] - (cos * q[s] - sin * q[s + 1])
        change[k + 1] = (1.0 - share) * change[k + 1] - (cos * q[s + 1] + sin * q[s])
