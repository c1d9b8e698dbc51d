"""The retainers' ball bearings in a machine file, and the loads on their balls during a landing."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from functools import cached_property
from typing import Literal

import numpy as np
from pydantic import model_validator

from amb_assessment.assessment.format.quantities import ResultTable
from amb_assessment.reporting.panels import Curve, Panel, curve
from amb_cosim.cosim.system.tables import Table, Value
from amb_cosim.cosim.system.values import quantity
from amb_files.suggestions import suggest
from ball_bearings.bearing import STRIBECK, BallBearing
from ball_bearings.hertz import SILICON_NITRIDE, STEEL

STEEL_DENSITY = 7800.0  # kg/m^3
MATERIALS = {"steel": STEEL, "silicon_nitride": SILICON_NITRIDE}
TITLE = "Ball bearings of the retainers"
STANDING = "Ball bearings that carry the rotor's weight along the shaft without power"
LOAD_HEADS = ("retainer", "force (N)", "ball load (N)", "pressure (MPa)", "C_0 over force", "displacement (µm)")
AXIAL_HEADS = ("axial force (N)", "contact angle (deg)")
STANDING_HEADS = (
    "retainer",
    "axial force (N)",
    "ball load (N)",
    "contact angle (deg)",
    "pressure (MPa)",
    "life (10^6 turns)",
    "at the largest speed (h)",
)
MOUNTED = "Balls and mounts of the retainers in a fall"
MOUNTED_HEADS = ("retainer", "mount (MN/m)", "force (N)", "balls (MN/m)", "balls at C_0 (MN/m)", "inner ring (kg)")
SOFT = 5.0  # tangent stiffness of the balls over that of the mount below which they act in series
WIDTH = 1.7  # of a ring over the diameter of a ball, in catalogues from thin to medium sections
SHOULDER = 0.6  # of the diameter of a ball: difference between pitch diameter and outside of the inner ring
DATA_HEADS = (
    "balls",
    "C_0 (kN)",
    "by ISO 76 (kN)",
    "stiffness under the weight (MN/m)",
    "displacement (µm)",
    "at C_0 (µm)",
)


class RetainerBearing(Table):
    """The ball bearing of a retainer, described by its catalogue data.

    at
        Contact site of the rotor.
    balls, ball_diameter, bore, outside
        Number of balls in a row; diameter of a ball; bore and outside diameter of the bearing.
    rows, contact_angle, preload
        Number of rows, which is 1 for a deep-groove bearing and 2 for a pair. A pair may have a contact angle and an
        axial preload.
    clearance
        Diametral internal clearance of the mounted bearing, for a bearing without contact angle; negative for an
        interference.
    conformity
        Radius of the inner groove and of the outer groove, each divided by the ball diameter.
    ball
        Material of the balls: steel or silicon_nitride.
    static_rating
        Static rating C_0 from the catalogue; by default, the load that causes the pressure of ISO 76.
    """

    at: str
    balls: int
    ball_diameter: Value
    bore: Value
    outside: Value
    rows: int = 1
    contact_angle: Value = 0.0
    preload: Value = 0.0
    clearance: Value = 0.0
    conformity: tuple[float, float] = (0.52, 0.52)
    ball: Literal["steel", "silicon_nitride"] = "steel"
    static_rating: Value | None = None

    @model_validator(mode="after")
    def _can_be_built(self) -> RetainerBearing:
        width, D = 0.5 * (self._value("outside", "m") - self._value("bore", "m")), self._value("ball_diameter", "m")
        if not 0.0 < D < width:
            allowed = f"> 0 m and < {width:g} m, half the difference between outside and bore"
            raise ValueError(
                f"ball_diameter of the bearing at {self.at} = {D:g} m is not allowed; it must be {allowed}"
            )
        _ = self.bearing
        if not self.rating > 0.0:
            raise ValueError(f"static_rating of the bearing at {self.at} = {self.rating:g} N must be > 0 N")
        return self

    def _value(self, name: str, unit: str) -> float:
        return quantity(getattr(self, name), unit, f"{name} of the bearing at {self.at}")

    @cached_property
    def bearing(self) -> BallBearing:
        """The bearing as a model; its pitch diameter is the mean of bore and outside diameter."""
        return BallBearing(
            self.balls,
            self._value("ball_diameter", "m"),
            0.5 * (self._value("bore", "m") + self._value("outside", "m")),
            self.conformity,
            self.rows,
            self._value("contact_angle", "rad"),
            self._value("clearance", "m"),
            self._value("preload", "N"),
            MATERIALS[self.ball],
        )

    @property
    def rating(self) -> float:
        """Static rating C_0 (N), from the catalogue or from the pressure of ISO 76."""
        if self.static_rating is None:
            return self.bearing.static_rating
        return self._value("static_rating", "N")

    def pressure(self, force: float, axial: float = 0.0) -> float:
        """Return the largest Hertz pressure on a ball (MPa) under a radial and an axial force (N)."""
        return 1e-6 * self.bearing.pressure(self.bearing.largest_load(force, axial))

    def equivalent_load(self, force: float, axial: float = 0.0) -> float:
        """Return the radial force (N) that, alone and without clearance, causes the same load on the most loaded ball.

        By definition, this is the equivalent static load of ISO 76.
        """
        if axial == 0.0:
            return force
        of_ball = self.bearing.largest_load(force, axial) * math.cos(self.bearing.contact_angle)
        return self.rows * self.balls * of_ball / STRIBECK

    def under_load(self, force: float, axial: float = 0.0) -> tuple[str, ...]:
        """Return the table row under `LOAD_HEADS` and `AXIAL_HEADS`, for a radial and an axial force (N)."""
        bearing, equivalent = self.bearing, self.equivalent_load(force, axial)
        safety = f"{self.rating / equivalent:.3g}" if equivalent > 0.0 else ""
        numbers = (f"{force:.4g}", f"{bearing.largest_load(force, axial):.4g}", f"{self.pressure(force, axial):.0f}")
        displaced = f"{1e6 * float(bearing.displacement(force, axial)[0]):.3g}"
        return (self.at, *numbers, safety, displaced, f"{axial:.4g}", self._angle(force, axial))

    def standing(self, axial: float, Omega: float) -> tuple[str, ...]:
        """Return the table row under `STANDING_HEADS`, for an axial force (N) and the largest speed (rad/s)."""
        life, largest = self.bearing.life(0.0, axial), self.bearing.largest_load(0.0, axial)
        loads = (f"{axial:.4g}", f"{largest:.4g}", self._angle(0.0, axial), f"{self.pressure(0.0, axial):.0f}")
        return (self.at, *loads, f"{1e-6 * life:.3g}", f"{life * 2.0 * math.pi / Omega / 3600.0:.3g}")

    def _angle(self, force: float, axial: float) -> str:
        return f"{math.degrees(self.bearing.largest_contact_angle(force, axial)):.1f}"

    def stiffness(self, force: float) -> float:
        """Return the tangent stiffness dF/dx (N/m) under a radial force (N) above 0."""
        more, less = (self.bearing.displacement_under(share * force) for share in (1.01, 0.99))
        return 0.02 * force / (more - less)

    @property
    def inner_ring(self) -> float:
        """Mass (kg) of the inner ring, or rings, estimated from bore, pitch diameter and balls."""
        bearing, bore = self.bearing, self._value("bore", "m")
        outside = bearing.pitch_diameter - SHOULDER * bearing.ball_diameter
        return self.rows * STEEL_DENSITY * WIDTH * bearing.ball_diameter * 0.25 * math.pi * (outside**2 - bore**2)

    def mounted(self, weight: float, clearance: float, mount: float) -> tuple[tuple[str, ...], str]:
        """Return the table row under `MOUNTED_HEADS`, and a sentence if the balls are soft; empty otherwise.

        A weight W that falls through a clearance c onto a mount of stiffness k presses it with

            F = W (1 + sqrt(1 + 2 k c/W)),    from W (c + F/k) = F^2/(2 k)

        Parameters
        ----------
        weight, clearance, mount
            W (N), c (m) and k (N/m), all above 0.
        """
        force = weight * (1.0 + math.sqrt(1.0 + 2.0 * mount * clearance / weight))
        of_balls, ring = self.stiffness(force), self.inner_ring
        numbers = (
            f"{1e-6 * mount:.4g}",
            f"{force:.4g}",
            f"{1e-6 * of_balls:.4g}",
            f"{1e-6 * self.stiffness(self.rating):.4g}",
        )
        row = (self.at, *numbers, f"{ring:.2g}")
        if of_balls >= SOFT * mount:
            return row, ""
        series = 1.0 / (1.0 / mount + 1.0 / of_balls)
        return row, (
            f"{self.at}: in a fall, the balls are {of_balls / mount:.2g} times as stiff as the mount; state the "
            f"stiffness of both in series, mount_stiffness = {1e-6 * series:.3g} MN/m, and the inner ring, of about "
            f"{ring:.2g} kg, as housing_mass"
        )

    def data(self, weight: float) -> tuple[str, ...]:
        """Return the table row under `DATA_HEADS`, for a radial force `weight` (N), which may be 0."""
        bearing, rating = self.bearing, self.rating
        stiffness = f"{1e-6 * self.stiffness(weight):.4g}" if weight > 0.0 else "-"
        displacements = (f"{1e6 * bearing.displacement_under(force):.3g}" for force in (weight, rating))
        ratings = (f"{1e-3 * rating:.4g}", f"{1e-3 * bearing.static_rating:.4g}")
        return (self.at, f"{self.rows} x {self.balls}", *ratings, stiffness, *displacements)

    def curve(self, most: float) -> Curve:
        """Return the radial displacement (um) as a function of the radial force (N), up to the force `most`."""
        bearing, forces = self.bearing, np.linspace(0.0, most, 60)
        return curve(self.at, forces, np.array([1e6 * bearing.displacement_under(force) for force in forces]))


def check_sites(bearings: Iterable[RetainerBearing], sites: Iterable[str]) -> None:
    """Raise a ValueError if a bearing is at none of the `sites`, or if two bearings are at the same site."""
    names, used = list(sites), list[str]()
    for item in bearings:
        if item.at not in names:
            raise ValueError(f"the rotor has no contact site {item.at!r} for a bearing; {suggest(item.at, names)}")
        if item.at in used:
            raise ValueError(f"two retainer_bearings are at {item.at}; define a pair as one bearing with rows = 2")
        used.append(item.at)


def load_panels(loaded: Sequence[tuple[RetainerBearing, float, float]]) -> tuple[Panel, ...]:
    """Return a plot of the bearings' displacement against force (N), up to the largest of their ratings and forces."""
    if not loaded:
        return ()
    most = max(max(force, item.rating) for item, force, _ in loaded)
    curves = tuple(item.curve(most) for item, *_ in loaded)
    return (Panel(TITLE, "radial force (N)", "displacement (um)", curves),)


def load_tables(loaded: Sequence[tuple[RetainerBearing, float, float]]) -> tuple[ResultTable, ...]:
    """Return a table of the ball loads under the radial and the axial forces on the bearings (N)."""
    rows = tuple(item.under_load(force, axial) for item, force, axial in loaded)
    heads = (*LOAD_HEADS, *AXIAL_HEADS) if any(axial for *_, axial in loaded) else LOAD_HEADS
    return (ResultTable(TITLE, heads, tuple(row[: len(heads)] for row in rows)),) if rows else ()
