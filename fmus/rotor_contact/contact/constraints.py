"""Contact as a constraint: multipliers and projection at several sites (thesis 4.10 to 4.21, 4.24 to 4.35).

Every site has two unknowns, N_k and T_k, and two equations in every mode (4.27 to 4.29):

    free       N_k = 0                           T_k = 0
    sliding    n_k . a_k = -|v_k|^2 / r_k        T_k + mu_k sign_k N_k = 0
    rolling    n_k . a_k = -|v_k|^2 / r_k        t_k . a_k = -R_s Omega'

r_k, v_k and a_k are the displacement, velocity and acceleration of the journal relative to its retainer. The
accelerations of a race and of a free spin belong on the left-hand side of the last equation. In contact, the equation
for N_k is (4.15) divided by 2 r_k; in rolling, the equation for T_k is (4.33). Free sites are omitted, and T_k of a
sliding site is eliminated. The unknowns are therefore N_k of the constrained sites and T_k of the rolling sites. The
same equations, with other right-hand sides, give impulses (`impact`) and corrections (`project`). Compliant contacts
(`compliant`) do not need these equations. See `site` for n, t and their signs.
"""

from __future__ import annotations

from fmi_export.jit import kernel
from fmi_export.model import Array
from rotor_contact.contact.friction import friction_ratio
from rotor_contact.contact.response import add_contact_response, set_spin_response
from rotor_contact.contact.site import (
    Site,
    Sites,
    is_constrained,
    locate_journal,
    radial_component,
    slip_velocity,
    square_of_velocity,
)
from rotor_contact.contact.workspace import Workspace
from rotor_contact.shaft.linear_solver import Equations, solve
from rotor_contact.variables.enumerations import ROLLING

MAX_UNKNOWNS = 2  # of a site


@kernel
def is_any_constrained(sites: Sites) -> bool:
    """Return whether any rigid site is closed."""
    for site in sites:
        if is_constrained(site):
            return True
    return False


@kernel
def number_unknowns(sites: Sites) -> int:
    """Assign indices to the unknowns (N of each constrained site, T of each rolling site); return their number."""
    count = 0
    for site in sites:
        if is_constrained(site):
            site.unknown = count
            count += 2 if site.mode == ROLLING else 1
    return count


@kernel
def write_equations(w: Workspace, friction: float) -> int:
    """Write the left-hand sides of the equations for the constrained sites in their modes; return their number.

    Right-hand sides are set to zero. Row and column `site.unknown` belong to N_k, and the next row and column to T_k if
    the site rolls. Each column contains the response to a unit of its unknown, M^-1 (-n) or M^-1 t. The response to N_k
    of a sliding site includes the friction of this site: M^-1 (-n - mu sign t). `friction` is 1, or 0 to omit sliding
    friction.
    """
    size = number_unknowns(w.sites)
    Minv, sites = w.Minv, w.sites
    A, b = w.equations
    for site in sites:
        if not is_constrained(site):
            continue
        i, row = site.row, site.unknown
        n_x, n_y = site.n_x, site.n_y
        rolling = site.mode == ROLLING
        b[row] = 0.0
        if rolling:
            b[row + 1] = 0.0
        for other in sites:
            if not is_constrained(other):
                continue
            j, column = other.row, other.unknown
            m_x, m_y = other.n_x, other.n_y
            # response at the site, in x and y, to a unit force along n and along t at the other site
            xn = Minv[i, j] * m_x + Minv[i, j + 1] * m_y
            yn = Minv[i + 1, j] * m_x + Minv[i + 1, j + 1] * m_y
            xt = Minv[i, j + 1] * m_x - Minv[i, j] * m_y
            yt = Minv[i + 1, j + 1] * m_x - Minv[i + 1, j] * m_y
            ratio = friction_ratio(other, friction)
            A[row, column] = -(n_x * xn + n_y * yn) + ratio * (n_x * xt + n_y * yt)
            if rolling:
                A[row + 1, column] = -(n_x * yn - n_y * xn) + ratio * (n_x * yt - n_y * xt)
            if other.mode == ROLLING:
                A[row, column + 1] = n_x * xt + n_y * yt
                if rolling:
                    A[row + 1, column + 1] = n_x * yt - n_y * xt
    if w.n > Minv.shape[0]:
        _add_bodies(w, friction)
    return size


@kernel
def _add_bodies(w: Workspace, friction: float) -> None:
    """Add the response of housings, races and spin (see `response`) to the left-hand sides."""
    A = w.equations.matrix
    for site in w.sites:
        if is_constrained(site):
            set_spin_response(w, site)
    for site in w.sites:
        if not is_constrained(site):
            continue
        row = site.unknown
        for other in w.sites:
            if not is_constrained(other):
                continue
            column, ratio = other.unknown, friction_ratio(other, friction)
            spin = ratio * other.spin_t - other.spin_n
            delta = 1.0 if row == column else 0.0
            A[row, column] += site.spin_n * spin - delta * site.mobility
            if site.mode == ROLLING:
                A[row + 1, column] += site.spin_t * spin
            if other.mode == ROLLING:
                A[row, column + 1] += site.spin_n * other.spin_t
                if site.mode == ROLLING:
                    A[row + 1, column + 1] += site.spin_t * other.spin_t + delta * (site.mobility + site.race_mobility)


@kernel
def multipliers(site: Site, equations: Equations, friction: float) -> tuple[float, float]:
    """Return N_k and T_k of a constrained site from the solved equations; for `friction` see `write_equations`."""
    normal = equations.right_side[site.unknown]
    if site.mode == ROLLING:
        return normal, equations.right_side[site.unknown + 1]
    return normal, friction_ratio(site, friction) * normal


@kernel
def apply_contact(w: Workspace, q: Array, v: Array, Omega: float, a: Array) -> bool:
    """Solve for the multipliers of the constrained sites and add their effect to `a`; return False if this fails.

    The arguments are the displacements (m), velocities (m/s), spin speed (rad/s) and accelerations `a` (m/s^2).
    """
    if not is_any_constrained(w.sites):
        return True
    if not find_multipliers(w, q, v, Omega, a):
        return False
    for site in w.sites:
        if is_constrained(site):
            add_contact_response(w, site, site.f_n, site.f_t, a)
    return True


@kernel
def find_multipliers(w: Workspace, q: Array, v: Array, Omega: float, a: Array) -> bool:
    """Solve for f_n and f_t of constrained sites from the contact-free acceleration `a`; return False if this fails.

    The arguments are those of `apply_contact`; only the entries of `a` that belong to sites are read.
    """
    for site in w.sites:
        if is_constrained(site):
            locate_journal(site, q)
            site.slip = slip_velocity(site, v, Omega)
    size = write_equations(w, 1.0)
    for site in w.sites:
        if is_constrained(site):
            row = site.unknown
            curvature = square_of_velocity(site, v) / site.radius
            w.equations.right_side[row] = -curvature - radial_component(site, a)
            if site.mode == ROLLING:
                w.equations.right_side[row + 1] = -slip_velocity(site, a, w.motion.Omega_dot)
    if not solve(w.equations, size):
        return False
    for site in w.sites:
        if is_constrained(site):
            site.f_n, site.f_t = multipliers(site, w.equations, 1.0)
    return True


@kernel
def project(w: Workspace, q: Array, v: Array, Omega: float) -> bool:
    """Project constrained sites onto their circles and velocity constraints by the smallest mass-weighted change.

    This prevents drift of the integrated constraint (4.14). Friction is not involved.
    """
    if not is_any_constrained(w.sites):
        return True
    if not put_on_circles(w, q):
        return False
    size = _write_corrections(w, q)
    for site in w.sites:
        if is_constrained(site):
            w.equations.right_side[site.unknown] = -radial_component(site, v)
            if site.mode == ROLLING:
                w.equations.right_side[site.unknown + 1] = -slip_velocity(site, v, Omega)
    return _add_corrections(w, size, v)


@kernel
def put_on_circles(w: Workspace, q: Array) -> bool:
    """Project constrained sites onto their circles by the smallest mass-weighted change; return False if this fails.

    One Newton step suffices, because it leaves an error of the order of the square of the substep's error.
    """
    size = _write_corrections(w, q)
    for site in w.sites:
        if is_constrained(site):
            w.equations.right_side[site.unknown] = site.clearance - site.radius
    return _add_corrections(w, size, q)


@kernel
def _write_corrections(w: Workspace, q: Array) -> int:
    """Write the left-hand sides of the equations for corrections at q, without friction; return their number."""
    for site in w.sites:
        if is_constrained(site):
            locate_journal(site, q)
    return write_equations(w, 0.0)


@kernel
def _add_corrections(w: Workspace, size: int, target: Array) -> bool:
    """Solve the equations and add the response to `target`; return False if they are singular."""
    if not solve(w.equations, size):
        return False
    for site in w.sites:
        if is_constrained(site):
            normal, friction = multipliers(site, w.equations, 0.0)
            add_contact_response(w, site, normal, friction, target)
    return True
