"""The path of a journal between two states: the cubic through both ends with their velocities.

It differs from the motion by the fourth derivative times dt^4/384: nanometres over the usual steps.
"""

from __future__ import annotations

from fmi_export.jit import kernel
from fmi_export.model import Array
from rotor_contact.contact import PLANE
from rotor_contact.interface import CLEARANCE, OFFSET_X, OFFSET_Y

HALVINGS = 40  # of the interval in which a path touches


@kernel
def stays_within(sites: Array, k: int, z: Array, z_new: Array, dt: float, n: int, margin: float) -> bool:
    """Whether the path at site k keeps clear of its retainer by a share `margin` of the clearance.

    It lies within the hull of its four Bezier points, so it does where these do.

    Parameters
    ----------
    z, z_new
        States that begin with displacements (m) and velocities (m/s), n of each.
    dt
        Time between them (s).
    """
    row = int(sites[k, PLANE])
    limit = (1.0 - margin) * sites[k, CLEARANCE]
    for y, share in ((z, 0.0), (z, dt / 3.0), (z_new, -dt / 3.0), (z_new, 0.0)):
        along = y[row] + share * y[n + row] - sites[k, OFFSET_X]
        across = y[row + 1] + share * y[n + row + 1] - sites[k, OFFSET_Y]
        if not along * along + across * across < limit * limit:
            return False
    return True


@kernel
def touches_at(sites: Array, k: int, z: Array, z_new: Array, dt: float, n: int) -> float:
    """When the path at site k, that ends beyond its retainer, crosses it (s); arguments as for `stays_within`."""
    row = int(sites[k, PLANE])
    low, high = 0.0, 1.0
    for _ in range(HALVINGS):
        share = 0.5 * (low + high)
        rest = 1.0 - share
        first, last = rest * rest * (1.0 + 2.0 * share), share * share * (3.0 - 2.0 * share)
        leaving, arriving = rest * rest * share * dt, -share * share * rest * dt
        square = 0.0
        for axis in range(2):
            i = row + axis
            at = first * z[i] + last * z_new[i] + leaving * z[n + i] + arriving * z_new[n + i]
            square += (at - sites[k, OFFSET_X + axis]) ** 2
        if square > sites[k, CLEARANCE] ** 2:
            high = share
        else:
            low = share
    return high * dt
