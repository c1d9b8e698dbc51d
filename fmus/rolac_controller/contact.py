"""Contact with the retainer bearings: how much of it there is, and an adaptation that takes it into account.

A journal in contact is kept on its circle by a force -N q/c, like a spring N/c between the journal and the centre.
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

import numpy as np

from fmi_export.jit import kernel
from fmi_export.model import Array
from rolac_controller.complex_numbers import Complex, phasor, squared_magnitude
from rolac_controller.enumerations import GIVEN, NO_SOURCE, OWN_SENSORS
from rolac_controller.rig_layout import N_BEARINGS, SENSOR_OF_AXIS


@kernel
def is_in_contact(contact: np.record, contact_state: float, displacements: Array, bearing: int) -> bool:
    """Return whether a journal is in contact, by the source that `contact.source` selects."""
    if contact.source == GIVEN:
        return int(contact_state) >> bearing & 1 == 1
    if contact.source == OWN_SENSORS:
        x, y = displacements[SENSOR_OF_AXIS[2 * bearing]], displacements[SENSOR_OF_AXIS[2 * bearing + 1]]
        return bool(abs(complex(x, y)) >= contact.threshold * contact.clearance)
    return False


@kernel
def update_contact_share(
    contact: np.record, contact_state: float, displacements: Array, delta_theta: float, shares: Array
) -> bool:
    """Update the share of contact of each bearing; return whether any journal is in contact now.

    The share is a running mean with the time constant of a revolution.

    Parameters
    ----------
    contact
        The parameters `contact.*`.
    contact_state
        The input of that name.
    displacements
        As measured, shape (N_SENSORS,) (m).
    delta_theta
        Angle since the sample before (rad).
    shares
        Shape (N_BEARINGS,), in [0, 1]; changed.
    """
    if contact.source == NO_SOURCE:
        return False
    weight = min(abs(delta_theta) / (2.0 * math.pi), 1.0)
    any_contact = False
    for bearing in range(N_BEARINGS):
        now = is_in_contact(contact, contact_state, displacements, bearing)
        any_contact = any_contact or now
        shares[bearing] += weight * ((1.0 if now else 0.0) - shares[bearing])
    return any_contact


@kernel
def turn_against_displacement(share: float, lead: float, Q: Complex, delta_U: Complex, bearing: int) -> None:
    """Turn a step of the adaptation against the displacement of one bearing, by its share of contact.

    Parameters
    ----------
    share, lead
        p and psi (rad), see above.
    Q
        Synchronous displacements, shape (N_SENSORS,) (m).
    delta_U
        Step of the forces, shape (N_AXES,) (N); changed.
    """
    step_squared = q_squared = 0.0
    for axis in range(2 * bearing, 2 * bearing + 2):
        step, q = delta_U[axis], Q[SENSOR_OF_AXIS[axis]]
        step_squared += squared_magnitude(step)
        q_squared += squared_magnitude(q)
    if q_squared == 0.0:
        return
    size = share * math.sqrt(step_squared / q_squared)
    direction = size * phasor(lead)
    for axis in range(2 * bearing, 2 * bearing + 2):
        delta_U[axis] = (1.0 - share) * delta_U[axis] - direction * Q[SENSOR_OF_AXIS[axis]]
