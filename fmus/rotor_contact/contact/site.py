"""A contact site: its record in the scratch array, and the geometry of a journal in its clearance circle.

            y ^    ___ retainer, radius of the gap c
              |  /     \\
              | |    o->|n     n outward normal, t = (-y, x)/r forward tangent (direction of spin)
              |  \\ ___ /      force on the rotor: -N n + T t, N >= 0
              +--------> x     v_slip = Omega R_s + t . v - omega_r (R_s + c)

The displacement r and the velocity v of the journal are relative to the retainer, which may move (`bodies`); omega_r is
the speed of its race. Vectors cover all degrees of freedom: first those of the shaft, then those of the bodies.
"""

from __future__ import annotations

import math

import numpy as np

from fmi_export.jit import kernel
from fmi_export.model import Array
from fmi_export.records import record
from rotor_contact.contact.site_totals import COLLECTED, places_of
from rotor_contact.variables.contact_laws import CONSTRAINT
from rotor_contact.variables.enumerations import FREE
from rotor_contact.variables.signals import SITE_PARAMETERS

# A site during a step: its parameters, in the order of the interface, and what changes.
SITE = record(
    *((name, np.float64) for name in SITE_PARAMETERS.names or ()),
    ("row", np.int64),  # of the site's x among the degrees of freedom; y is the next
    ("housing", np.int64),  # the same of its housing, -1 if that is fixed
    ("race", np.int64),  # degree of freedom of its race, -1 without a race
    ("spin", np.int64),  # that of the rotor's spin, -1 if the speed is prescribed
    ("base_x", np.float64),  # acceleration of the base (m/s^2)
    ("base_y", np.float64),
    ("mobility", np.float64),  # 1/m of the housing (1/kg), 0 if it is fixed
    ("race_mobility", np.float64),  # (R_s + c)^2/J of the race (1/kg), 0 without a race
    ("spin_n", np.float64),  # how a force along n and along t couples to a free spin, see `bodies` (1/sqrt(kg))
    ("spin_t", np.float64),
    ("mode", np.int64),  # FREE, SLIDING or ROLLING
    ("slip_sign", np.float64),  # sign of the slip velocity that sliding friction opposes
    ("push_sign", np.float64),  # 1 while a compliant law pushes, -1 while it would pull and has no force
    ("slip", np.float64),  # slip velocity (m/s) for which kinetic friction is evaluated
    ("radius", np.float64),  # distance (m) of the journal from the centre
    ("n_x", np.float64),  # outward normal
    ("n_y", np.float64),
    *COLLECTED,
    ("before", np.float64, 2),  # indicators at the ends of the time in which an event is located, see `event_time`
    ("after", np.float64, 2),
    ("unknown", np.int64),  # place of N among the unknowns of the contact equations; T of a rolling site is the next
    ("mode_fixed", np.int64),  # 1 once the mode may not change again at this instant
    ("touching", np.int64),  # 1 if the site takes part in the present impact
    ("mode_before", np.int64),  # mode before the present impact
    ("rebound", np.float64),  # coefficient of restitution of the present impact
    ("p_n", np.float64),  # normal and friction impulse (N s) of the present impact
    ("p_t", np.float64),
)

COLLECTED_FROM, COLLECTED_TO = places_of(COLLECTED, SITE)

Sites = np.ndarray[tuple[int], np.dtype[np.record]]
Site = np.record


@kernel
def is_constrained(site: Site) -> bool:
    """Return whether a site is in contact and this contact is a constraint."""
    return site.mode != FREE and site.law == CONSTRAINT


@kernel
def can_touch(site: Site) -> bool:
    """Return whether a site is enabled and free."""
    return site.mode == FREE and site.enabled != 0.0


@kernel
def can_impact(site: Site) -> bool:
    """Return whether a site is enabled, free and rigid, so that an impact closes it."""
    return can_touch(site) and site.law == CONSTRAINT


@kernel
def locate_journal(site: Site, q: Array) -> float:
    """Return the radius |r| (m) of the journal about the centre of its retainer; store it and the normal."""
    x = q[site.row] - site.offset_x
    y = q[site.row + 1] - site.offset_y
    if site.housing >= 0:
        x -= q[site.housing]
        y -= q[site.housing + 1]
    r = math.sqrt(x * x + y * y)
    site.radius = r
    inverse = 1.0 / r if r > 0.0 else 0.0
    site.n_x = x * inverse if r > 0.0 else 1.0
    site.n_y = y * inverse
    return r


@kernel
def radial_component(site: Site, v: Array) -> float:
    """Return the outward component n . v of `v` at a site (its normal must be up to date)."""
    component: float = site.n_x * v[site.row] + site.n_y * v[site.row + 1]
    if site.housing >= 0:
        component -= site.n_x * v[site.housing] + site.n_y * v[site.housing + 1]
    return component


@kernel
def tangential_component(site: Site, v: Array) -> float:
    """Return the forward component t . v of `v` at a site (its normal must be up to date)."""
    component: float = site.n_x * v[site.row + 1] - site.n_y * v[site.row]
    if site.housing >= 0:
        component -= site.n_x * v[site.housing + 1] - site.n_y * v[site.housing]
    return component


@kernel
def square_of_velocity(site: Site, v: Array) -> float:
    """Return |v|^2 of the journal relative to its retainer (m^2/s^2)."""
    v_x, v_y = v[site.row], v[site.row + 1]
    if site.housing >= 0:
        v_x -= v[site.housing]
        v_y -= v[site.housing + 1]
    square: float = v_x * v_x + v_y * v_y
    return square


@kernel
def slip_velocity(site: Site, v: Array, Omega: float) -> float:
    """Return v_slip (4.11), the velocity of the journal surface relative to the retainer (m/s).

    `Omega` (rad/s) is the spin speed if it is prescribed; a free spin is in `v`. If `v` contains accelerations, the
    function returns the rate of v_slip in contact.
    """
    speed = Omega if site.spin < 0 else v[site.spin]
    slip: float = speed * site.journal_radius + tangential_component(site, v)
    if site.race >= 0:
        slip -= v[site.race] * race_radius(site)
    return slip


@kernel
def race_radius(site: Site) -> float:
    """Return the radius (m) at which the journal touches its race."""
    radius: float = site.journal_radius + site.clearance
    return radius


@kernel
def put_on_circle(site: Site, q: Array) -> None:
    """Move the journal of a site onto its clearance circle, along its normal (which must be up to date)."""
    q[site.row] = site.offset_x + site.clearance * site.n_x
    q[site.row + 1] = site.offset_y + site.clearance * site.n_y
    if site.housing >= 0:
        q[site.row] += q[site.housing]
        q[site.row + 1] += q[site.housing + 1]


@kernel
def remove_radial_velocity(site: Site, v: Array) -> float:
    """Set the radial velocity of the site's node alone to zero (4.22); return its previous value (m/s)."""
    speed: float = radial_component(site, v)
    v[site.row] -= speed * site.n_x
    v[site.row + 1] -= speed * site.n_y
    return speed
