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

    def data(self, weight: float) -> tuple[str, ...]:
        """Return the table row under `DATA_HEADS`, for a radial force `weight` (N), which may be 0."""
        bearing, rating = self.bearing, self.rating
        more, less = (bearing.displacement_under(share * weight) for share in (1.01, 0.99))
        stiffness = f"{1e-6 * 0.02 * weight / (more - less):.4g}" if weight > 0.0 else "-"
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
