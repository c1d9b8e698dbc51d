"""Contact with the retainer bearings: its share of the time, and an adaptation that accounts for it.

A journal in contact is held on its circle by a force -N q/c, like a spring N/c between the journal and the centre.
With D = R_b^-1, the dynamic stiffness of the free rotor at the bearings, the total force on it is F = (D + N/c) q. To
release it, U must change along -F. ROLAC changes it along H Q ~ -D q, which is the wrong direction for Re D < 0: above
the critical speed of a mode the response rotates by more than 90 degrees when contact stiffens the mode. The phase of
D + N/c is between 0 (stiffness) and 90 degrees (damping). Contact-aware adaptation therefore keeps the size of the step
and rotates it against the journal's displacement, with a lead psi, in proportion to the share p of contact:

    U_b' = alpha [ (1 - p) (H Q)_b - p exp(j psi) |(H Q)_b| q_b/|q_b| ]           for each bearing b

With p = 0 this is ROLAC. With p > 0 the law moves the journals inward until they are free; ROLAC then converges to the
optimum.
"""

from __future__ import annotations

import math

from fmi_export.jit import inlined_kernel, kernel
from fmi_export.model import Array
from rolac_controller.complex_numbers import Complex, phasor, squared_magnitude
from rolac_controller.enumerations import GIVEN, NO_SOURCE, OWN_SENSORS
from rolac_controller.records import Parameters


@inlined_kernel
def is_in_contact(parameters: Parameters, contact_state: float, displacements: Array, bearing: int) -> bool:
    """Return whether a journal is in contact, by the criterion of `contact.source`."""
    contact, sensor_of_axis = parameters.common[0].contact, parameters.sensor_of_axis
    if contact.source == GIVEN:
        return int(contact_state) >> bearing & 1 == 1
    if contact.source == OWN_SENSORS:
        x, y = displacements[int(sensor_of_axis[2 * bearing])], displacements[int(sensor_of_axis[2 * bearing + 1])]
        return bool(abs(complex(x, y)) >= contact.threshold * contact.clearance)
    return False


@inlined_kernel
def update_contact_share(
    parameters: Parameters, contact_state: float, displacements: Array, delta_theta: float, shares: Array
) -> bool:
    """Update the share of contact of each bearing; return whether any journal is in contact now.

    The share is a running mean with the time constant of a revolution.

    Parameters
    ----------
    contact_state
        The input of that name: a sum of 1, 2, 4, ... for the bearings in contact.
    displacements
        As measured, shape (n_sensors,) (m).
    delta_theta
        Angle since the previous sample (rad).
    shares
        Shape (n_bearings,), in [0, 1]; changed.
    """
    if parameters.common[0].contact.source == NO_SOURCE:
        return False
    weight = min(abs(delta_theta) / (2.0 * math.pi), 1.0)
    any_contact = False
    for bearing in range(shares.shape[0]):
        now = is_in_contact(parameters, contact_state, displacements, bearing)
        any_contact = any_contact or now
        shares[bearing] += weight * ((1.0 if now else 0.0) - shares[bearing])
    return any_contact


@kernel
def turn_against_displacement(parameters: Parameters, share: float, Q: Complex, delta_U: Complex, bearing: int) -> None:
    """Rotate a step of the adaptation against the displacement of one bearing, by its share of contact.

    Parameters
    ----------
    share
        p, see above.
    Q
        Synchronous displacements, shape (n_sensors,) (m).
    delta_U
        Step of the forces, shape (n_axes,) (N); changed.
    """
    sensor_of_axis = parameters.sensor_of_axis
    step_squared = q_squared = 0.0
    for axis in range(2 * bearing, 2 * bearing + 2):
        step, q = delta_U[axis], Q[int(sensor_of_axis[axis])]
        step_squared += squared_magnitude(step)
        q_squared += squared_magnitude(q)
    if q_squared == 0.0:
        return
    size = share * math.sqrt(step_squared / q_squared)
    direction = size * phasor(parameters.common[0].contact.lead)
    for axis in range(2 * bearing, 2 * bearing + 2):
        delta_U[axis] = (1.0 - share) * delta_U[axis] - direction * Q[int(sensor_of_axis[axis])]
