"""Contact with the retainer bearings: the fraction of time in contact, and an adaptation that accounts for contact.

A journal in contact is held on its clearance circle by a force -N q/c, as by a spring N/c between journal and centre.
Let D = R_b^-1 be the dynamic stiffness of the free rotor at the bearings; then the total force on the journal is F = (D
+ N/c) q. To release the journal, U must change along -F. ROLAC changes U along H Q ~ -D q. This direction is wrong if
Re D < 0. Above the critical speed of a mode, contact stiffens the mode and thereby rotates the response by more than 90
degrees. The phase of D + N/c is between 0 (stiffness) and 90 degrees (damping). Contact-aware adaptation therefore
keeps the size of the step, but rotates the step against the journal's displacement, with a lead psi and in proportion
to the share p of time in contact:

    U_b' = alpha [ (1 - p) (H Q)_b - p exp(j psi) |(H Q)_b| q_b/|q_b| ]           for each bearing b

For p = 0 this law is ROLAC. For p > 0 it moves the journals inward until they are free; ROLAC then converges to the
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
    """Return whether a journal is in contact, by the criterion that `contact.source` selects."""
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
    """Update each bearing's share of time in contact; return whether any journal is in contact now.

    The share is a running mean with a time constant of one revolution.

    Parameters
    ----------
    contact_state
        The input of that name: the sum of 2^k over all bearings k that are in contact.
    displacements
        Measured displacements, shape (n_sensors,) (m).
    delta_theta
        Rotor angle since the previous sample (rad).
    shares
        Shares of all bearings, each in [0, 1], shape (n_bearings,); updated.
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
    """Rotate a bearing's adaptation step against the journal's displacement, in proportion to the share of contact.

    Parameters
    ----------
    share
        Share p of time in contact; see the module.
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
