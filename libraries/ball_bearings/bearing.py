"""A ball bearing under a force: ball loads, displacement, pressure, life and static rating.

The balls lie at the angles phi_j. Without load, the distance between the groove centres is B = (f_i + f_o - 1) D, and
the contact angle is alpha. A displacement (x, y, z) of the inner ring changes the distance at ball j to s_j and causes
the load Q_j:

    s_j = hypot(B cos(alpha) - P_d/2 + x cos(phi_j) + y sin(phi_j),  B sin(alpha) +- z)
    Q_j = K max(s_j - B, 0)^1.5

The load acts along the line between the groove centres. The sign before z is + in the first row and - in the second row
of a pair. The force -Q_j acts on the inner ring. Under an axial force alone, every ball of a row carries Q = F_a/(Z
sin(alpha)), where alpha is the contact angle under that load. Rings are rigid and the balls have no mass, so forces are
quasi-static. The rings do not tilt, and the shoulders of the grooves are as high as the balls' contacts require.
Source: T. A. Harris, Rolling Bearing Analysis, chapters on load distribution; ISO 76 for the static rating.

The life L is the number of revolutions that 90 % of bearings reach (G. Lundberg, A. Palmgren, 1947; factor b_m of ISO
281):

    Q_c = 98.1 b_m (2f/(2f - 1))^0.41 (1 -+ g)^1.39/(1 +- g)^(1/3) (D/d_m)^0.3 d(D) Z^(-1/3)       N, D in mm
    d(D) = D^1.8 up to 25.4 mm,  25.4^0.4 D^1.4 = 3.647 D^1.4 for larger balls
    L = 10^6 (Q_c/Q_e)^3,   g = D cos(alpha)/d_m,   upper signs for the inner race

For the rotating race (the inner one), Q_e is the cubic mean of a row's ball loads; for the other race, the exponent of
the mean is 10/3. The lives of races and rows combine by L^(-10/9) = sum of L_i^(-10/9).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from scipy.optimize import brentq

from amb_files.checks import require
from array_types import Array
from ball_bearings.hertz import STEEL, Material, PointContact, groove_contact, in_series

PRESSURE_LIMIT = 4200e6  # Pa, which leaves a permanent indentation of 1e-4 of the ball's diameter (ISO 76)
STRIBECK = 5.0  # F = Z Q_max/5 with usual clearance (ISO 76)
MATERIAL = 1.3  # b_m of radial ball bearings (ISO 281)
LARGE = 25.4  # mm, ball diameter above which the rating grows more slowly (ISO 281)
WEIBULL = 10.0 / 9.0  # exponent of the distribution of lives of ball bearings


@dataclass(frozen=True)
class BallBearing:
    """A deep-groove ball bearing with one or two rows, or a pair of rows with a contact angle.

    balls, ball_diameter, pitch_diameter
        Number of balls per row, ball diameter D (m) and pitch diameter d_m (m).
    conformity
        Ratios f_i and f_o of the groove radii of the inner and outer race to D.
    rows
        Number of rows, 1 or 2. Back-to-back and face-to-face arrangements differ only under moments, which are not
        modelled.
    contact_angle
        Contact angle alpha without load (rad). It may be above 0 only if there are two rows, because a single row needs
        an axial force to carry a radial force.
    clearance
        Diametral internal clearance P_d (m) of a bearing whose contact angle is 0; negative for an interference.
    preload
        Axial force (N) that the two rows of a pair with a contact angle exert on each other.
    ball
        Material of the balls; the races are made of steel.
    """

    balls: int
    ball_diameter: float
    pitch_diameter: float
    conformity: tuple[float, float] = (0.52, 0.52)
    rows: int = 1
    contact_angle: float = 0.0
    clearance: float = 0.0
    preload: float = 0.0
    ball: Material = field(default=STEEL)

    def __post_init__(self) -> None:
        D, d_m, Z = self.ball_diameter, self.pitch_diameter, self.balls
        require(Z >= 3, "balls", f"{Z}", "3 or more")
        require(0.0 < D < d_m, "ball_diameter", f"{D:g} m", f"> 0 m and < pitch_diameter = {d_m:g} m")
        spacing = d_m * math.sin(math.pi / Z)
        allowed = f"< {spacing:.4g} m for {Z} balls to fit on a pitch diameter of {d_m:g} m"
        require(spacing > D, "ball_diameter", f"{D:g} m", allowed)
        for name, f in zip(("inner", "outer"), self.conformity, strict=True):
            require(0.5 < f <= 0.6, f"conformity of the {name} groove", f"{f:g}", "> 0.5 and <= 0.6")
        require(self.rows in (1, 2), "rows", f"{self.rows}", "1 or 2")
        degrees = math.degrees(self.contact_angle)
        require(0.0 <= degrees <= 45.0, "contact_angle", f"{degrees:g} deg", ">= 0 deg and <= 45 deg")
        if self.contact_angle > 0.0:
            require(self.rows == 2, "rows", f"{self.rows}", "2 if contact_angle > 0 deg")
            require(self.clearance == 0.0, "clearance", f"{self.clearance:g} m", "0 m if contact_angle > 0 deg")
        else:
            require(self.preload == 0.0, "preload", f"{self.preload:g} N", "0 N if contact_angle = 0 deg")
        require(self.preload >= 0.0, "preload", f"{self.preload:g} N", ">= 0 N")
        require(self.clearance < D, "clearance", f"{self.clearance:g} m", f"< ball_diameter = {D:g} m")
        pressure = self.pressure(float(np.max(self.ball_loads(np.zeros(3)))))
        what, value = ("preload", f"{self.preload:g} N") if self.preload else ("clearance", f"{self.clearance:g} m")
        allowed = (
            f"smaller: with this value, the pressure at rest is {pressure / 1e6:.0f} MPa, and 4200 MPa leaves "
            "permanent marks"
        )
        require(pressure < PRESSURE_LIMIT, what, value, allowed)

    @cached_property
    def contacts(self) -> tuple[PointContact, PointContact]:
        """Contacts of a ball with the inner and the outer race."""
        gamma = self.ball_diameter * math.cos(self.contact_angle) / self.pitch_diameter
        inner, outer = (
            groove_contact(self.ball_diameter, f, sign * gamma, self.ball, STEEL)
            for f, sign in zip(self.conformity, (1.0, -1.0), strict=True)
        )
        return inner, outer

    @cached_property
    def stiffness(self) -> float:
        """Stiffness K of a ball between both races (N/m^1.5)."""
        return in_series(*self.contacts)

    @property
    def groove_distance(self) -> float:
        """Distance B between the groove centres without load (m)."""
        return (sum(self.conformity) - 1.0) * self.ball_diameter

    @cached_property
    def preload_approach(self) -> float:
        """Axial displacement of each row of a pair due to its preload (m)."""
        if self.preload == 0.0:
            return 0.0
        B, alpha = self.groove_distance, self.contact_angle

        def excess(z: float) -> float:
            s = math.hypot(B * math.cos(alpha), B * math.sin(alpha) + z)
            return self.balls * self.stiffness * (s - B) ** 1.5 * (B * math.sin(alpha) + z) / s - self.preload

        return float(brentq(excess, 0.0, B, xtol=1e-15))

    def pressure(self, Q: float) -> float:
        """Return the largest Hertz pressure (Pa) that a ball under the load Q (N) causes in either race."""
        return max(contact.pressure(Q) for contact in self.contacts)

    def ball_loads(self, displacement: Array, angle: float = 0.0) -> Array:
        """Return the loads Q_j (N) of the balls, shape (rows, balls).

        Parameters
        ----------
        displacement
            Displacement (x, y, z) of the inner ring relative to the outer ring (m).
        angle
            Angle of the first ball (rad).
        """
        return self._loads(displacement, angle)[0]

    def force(self, displacement: Array, angle: float = 0.0) -> Array:
        """Return the force on the inner ring (N), shape (3,); the arguments are as in `ball_loads`."""
        Q, radial, axial, phi = self._loads(displacement, angle)
        lateral = Q * radial
        return -np.array([np.sum(lateral * np.cos(phi)), np.sum(lateral * np.sin(phi)), np.sum(Q * axial)])

    def _loads(self, displacement: Array, angle: float) -> tuple[Array, Array, Array, Array]:
        """Return the ball loads, the radial and axial components of their directions, and the angles of the balls."""
        x, y, z = displacement
        phi = angle + 2.0 * math.pi * np.arange(self.balls) / self.balls
        signs = np.array([[1.0], [-1.0]])[: self.rows]
        B, alpha = self.groove_distance, self.contact_angle
        radial = B * math.cos(alpha) - 0.5 * self.clearance + x * np.cos(phi) + y * np.sin(phi)
        axial = signs * (B * math.sin(alpha) + self.preload_approach) + z
        s = np.hypot(radial, axial)
        Q = self.stiffness * np.maximum(s - B, 0.0) ** 1.5
        return Q, radial / s, axial / s, phi

    def displacement_under(self, force: float) -> float:
        """Return the radial displacement (m) under a radial force (N) that is directed towards a ball.

        Raises
        ------
        ValueError
            If the force is negative, or so large that a ball leaves its groove.
        """
        require(force >= 0.0, "force", f"{force:g} N", ">= 0 N")
        if force == 0.0:
            return 0.0
        largest_displacement = 0.5 * self.ball_diameter
        limit = -float(self.force(np.array([largest_displacement, 0.0, 0.0]))[0])
        require(
            force < limit,
            "force",
            f"{force:g} N",
            f"< {limit:.3g} N, the force at which the balls leave their grooves",
        )

        def excess(x: float) -> float:
            return -float(self.force(np.array([x, 0.0, 0.0]))[0]) - force

        return float(brentq(excess, 0.0, largest_displacement, xtol=1e-15))

    def displacement(self, radial: float, axial: float = 0.0) -> Array:
        """Return the displacement (m), shape (3,), under an axial force and a radial force towards a ball (N).

        The energy of the balls is a convex function of the displacement, so there is exactly one equilibrium.

        Raises
        ------
        ValueError
            If the radial force is negative, or if a force is so large that a ball leaves its groove.
        """
        if axial == 0.0:
            return np.array([self.displacement_under(radial), 0.0, 0.0])
        require(radial >= 0.0, "force", f"{radial:g} N", ">= 0 N")
        most = 0.5 * self.ball_diameter

        def axial_at(x: float) -> float:
            """Return the axial displacement (m) at which axial forces balance, given a radial displacement (m)."""

            def excess(z: float) -> float:
                return -float(self.force(np.array([x, 0.0, z]))[2]) - abs(axial)

            limit = excess(most) + abs(axial)
            allowed = f"less than {limit:.3g} N, the force at which the balls leave their grooves"
            require(abs(axial) < limit, "axial force", f"{axial:g} N", allowed)
            return float(brentq(excess, 0.0, most, xtol=1e-15))

        def excess(x: float) -> float:
            return -float(self.force(np.array([x, 0.0, axial_at(x)]))[0]) - radial

        x = 0.0
        if radial > 0.0:
            limit = excess(most) + radial
            require(
                radial < limit,
                "force",
                f"{radial:g} N",
                f"< {limit:.3g} N, the force at which the balls leave their grooves",
            )
            x = float(brentq(excess, 0.0, most, xtol=1e-15))
        return np.array([x, 0.0, math.copysign(axial_at(x), axial)])

    def largest_load(self, force: float, axial: float = 0.0) -> float:
        """Return the load (N) of the most heavily loaded ball; the forces are as in `displacement`."""
        return float(np.max(self.ball_loads(self.displacement(force, axial))))

    def largest_contact_angle(self, force: float, axial: float = 0.0) -> float:
        """Return the largest contact angle (rad) of all loaded balls; the forces are as in `displacement`."""
        Q, radial, along, _ = self._loads(self.displacement(force, axial), 0.0)
        return float(np.max(np.arctan2(np.abs(along), radial)[Q > 0.0], initial=0.0))

    def life(self, force: float, axial: float = 0.0) -> float:
        """Return the life (revolutions of the inner ring, infinite without load); forces are as in `displacement`."""
        Q = self.ball_loads(self.displacement(force, axial))
        powers = (3.0, 10.0 / 3.0)  # of the means on the race that rotates, and on the other
        failures = 0.0
        for rating, power in zip(self._dynamic_loads, powers, strict=True):
            means = np.mean(Q**power, axis=1) ** (1.0 / power)
            failures += float(np.sum((means / rating) ** (3.0 * WEIBULL)))
        return 1e6 * failures ** (-1.0 / WEIBULL) if failures else math.inf

    @cached_property
    def _dynamic_loads(self) -> tuple[float, float]:
        """Ball loads Q_c (N) at which the inner and the outer race have a life of a million revolutions."""
        D, size = 1e3 * self.ball_diameter, self.ball_diameter / self.pitch_diameter
        gamma = size * math.cos(self.contact_angle)
        inner, outer = (
            98.1
            * MATERIAL
            * (2.0 * f / (2.0 * f - 1.0)) ** 0.41
            * (1.0 - g) ** 1.39
            / (1.0 + g) ** (1.0 / 3.0)
            * size**0.3
            * min(D, LARGE) ** 0.4
            * D**1.4
            * self.balls ** (-1.0 / 3.0)
            for f, g in zip(self.conformity, (gamma, -gamma), strict=True)
        )
        return inner, outer

    @property
    def static_rating(self) -> float:
        """Static rating C_0 = rows Z Q cos(alpha)/5 (N), where Q is the ball load that causes 4200 MPa (ISO 76)."""
        Q = min(contact.force_at(PRESSURE_LIMIT) for contact in self.contacts)
        return self.rows * self.balls * Q * math.cos(self.contact_angle) / STRIBECK
