"""Response of the shaft and the bodies to a contact: M^-1 J^T for forces along n and t, in all degrees of freedom.

The journal receives the force -N n + T t, its housing the opposite force, its race the torque -T (R_s + c), and a free
spin the torque T R_s. With the coupling p of spin and shaft (`bodies`), a force f on the shaft and a torque r T on the
spin cause

    q'' = M^-1 f + s g,    Omega' = -g/sqrt(d),    g = s^T f - r T/sqrt(d),    s = M^-1 p/sqrt(d),  d = J - p^T M^-1 p
"""

from __future__ import annotations

from fmi_export.jit import inlined_kernel, kernel
from fmi_export.model import Array
from rotor_contact.contact.site import Site, race_radius
from rotor_contact.contact.workspace import Workspace
from rotor_contact.forces.dynamics import spin_coupling


@kernel
def set_spin_response(w: Workspace, site: Site) -> None:
    """Store the values of g for unit forces along n and t at a site (its normal must be up to date)."""
    if site.spin >= 0:
        s = spin_coupling(w.motion).s
        i = site.row
        site.spin_n = s[i] * site.n_x + s[i + 1] * site.n_y
        site.spin_t = s[i + 1] * site.n_x - s[i] * site.n_y - site.journal_radius * w.spin[0].scale


@inlined_kernel
def add_contact_response(w: Workspace, site: Site, normal: float, friction: float, target: Array) -> None:
    """Add to `target` the response to -normal n + friction t: accelerations for forces (N), velocities for impulses."""
    _add_response_of_shaft(w.Minv, site, normal, friction, target)
    if w.n > w.Minv.shape[0]:
        _add_response_of_bodies(w, site, normal, friction, target)


@kernel
def _add_response_of_shaft(Minv: Array, site: Site, normal: float, friction: float, target: Array) -> None:
    """Add M^-1 (-normal n + friction t) to the shaft's part of `target`."""
    j = site.row
    f_x = -normal * site.n_x - friction * site.n_y
    f_y = -normal * site.n_y + friction * site.n_x
    for i in range(Minv.shape[0]):
        target[i] += Minv[i, j] * f_x + Minv[i, j + 1] * f_y


@kernel
def _add_response_of_bodies(w: Workspace, site: Site, normal: float, friction: float, target: Array) -> None:
    """Add the effects of a contact on housing, race and spin, and the effect of the spin on the shaft, to `target`."""
    if site.housing >= 0:
        target[site.housing] += site.mobility * (normal * site.n_x + friction * site.n_y)
        target[site.housing + 1] += site.mobility * (normal * site.n_y - friction * site.n_x)
    if site.race >= 0:
        target[site.race] -= friction * race_radius(site) / site.race_inertia
    if site.spin >= 0:
        g = friction * site.spin_t - normal * site.spin_n
        s = spin_coupling(w.motion).s
        for i in range(s.shape[0]):
            target[i] += s[i] * g
        target[site.spin] -= g * w.spin[0].scale
