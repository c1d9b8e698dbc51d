"""The path of a journal between two states: the cubic through both ends with their velocities.

It differs from the motion by the fourth derivative times dt^4/384: nanometres over the usual steps.
"""

from __future__ import annotations

from fmi_export.jit import kernel
from fmi_export.model import Array
from rotor_contact.site import Site

N_BISECTIONS = 40  # of the interval in which a path touches


@kernel
def stays_within(site: Site, z: Array, z_new: Array, dt: float, n: int, margin: float) -> bool:
    """Return whether the path at a site stays clear of its retainer by the fraction `margin` of the clearance.

    A cubic lies within the convex hull of its four Bezier points, so it does where these do.

    Parameters
    ----------
    site
        The site.
    z, z_new
        States that begin with displacements (m) and velocities (m/s), n of each.
    dt
        Time between them (s).
    n, margin
        Degrees of freedom, and the fraction of the clearance.
    """
    row = site.row
    limit = (1.0 - margin) * site.clearance
    third = dt * (1.0 / 3.0)
    for y, lead in ((z, 0.0), (z, third), (z_new, -third), (z_new, 0.0)):
        r_x = y[row] + lead * y[n + row] - site.offset_x
        r_y = y[row + 1] + lead * y[n + row + 1] - site.offset_y
        if not r_x * r_x + r_y * r_y < limit * limit:
            return False
    return True


@kernel
def touch_time(site: Site, z: Array, z_new: Array, dt: float, n: int) -> float:
    """Return the time (s) at which a path that ends beyond its retainer crosses it; arguments as for `stays_within`."""
    row = site.row
    low, high = 0.0, 1.0
    for _ in range(N_BISECTIONS):
        s = 0.5 * (low + high)
        rest = 1.0 - s
        of_z, of_z_new = rest * rest * (1.0 + 2.0 * s), s * s * (3.0 - 2.0 * s)  # Hermite's cubics
        of_v, of_v_new = rest * rest * s * dt, -s * s * rest * dt
        square = 0.0
        for axis in range(2):
            i = row + axis
            position = of_z * z[i] + of_z_new * z_new[i] + of_v * z[n + i] + of_v_new * z_new[n + i]
            square += (position - (site.offset_x if axis == 0 else site.offset_y)) ** 2
        if square > site.clearance**2:
            high = s
        else:
            low = s
    return high * dt
