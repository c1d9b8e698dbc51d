"""The thrust bearing in a machine file: magnets, iron, amplifier, controller, and the thrust that it carries."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cached_property
from pathlib import Path

from pydantic import model_validator

from amb_analysis.linear.axial_loop import AxialControl, AxialLoop, AxialPlant
from amb_cosim.controllers.linear_controller import linear_controller
from amb_cosim.cosim.system.tables import Table, Value
from amb_cosim.cosim.system.values import quantity
from amb_files.checks import require
from thrust_bearings.disc import CatalogueBearing, OperatingPoint, ThrustDisc, moment_stiffness
from thrust_bearings.eddy_currents import LEAKAGE, SolidIron, corner_frequency

LEAST_CORNER = 2.0 * math.pi  # rad/s
OF_GEOMETRY = {
    "pole_area": "m2",
    "gap": "m",
    "turns": "1",
    "bias_current": "A",
    "current_limit": "A",
    "saturation": "T",
}
OF_DATA_SHEET = {"k_i": "N/A", "k_s": "N/m", "capacity": "N"}
OF_IRON = {"conductivity": "S/m", "permeability": "1", "slot_depth": "m"}
DATA_HEADS = ("K_i (N/A)", "K_s (MN/m)", "capacity (N)", "carries (N)", "tilt (N m/rad)", "eddy currents from (Hz)")


class SolidCore(Table):
    """Solid iron of the core and the disc, described by its material or by the measured corner frequency of its lag.

    conductivity, permeability, slot_depth, leakage
        Conductivity, relative permeability, depth of the coil's slot, and ratio of the flux in the iron to the flux
        between the poles.
    corner
        Frequency at which the reluctance of the eddy currents has the magnitude of the gap's reluctance.
    """

    conductivity: Value | None = None
    permeability: Value | None = None
    slot_depth: Value | None = None
    leakage: float = LEAKAGE
    corner: Value | None = None

    @model_validator(mode="after")
    def _is_complete(self) -> SolidCore:
        stated = [name for name in OF_IRON if getattr(self, name) is not None]
        if (self.corner is None) != (len(stated) == len(OF_IRON)) or (self.corner is not None and stated):
            raise ValueError(f"iron of the thrust bearing needs either 'corner', or {', '.join(OF_IRON)}")
        if self.corner is None:
            _ = self.material
        else:
            value = self.measured_corner
            require(0.0 < value < math.inf, "corner of the thrust bearing", f"{value:g} rad/s", "> 0 rad/s")
        return self

    @property
    def measured_corner(self) -> float:
        """The measured corner frequency (rad/s)."""
        return _value("corner", self.corner, "rad/s")

    @property
    def material(self) -> SolidIron:
        """The material."""
        sigma, mu_r, depth = (_value(name, getattr(self, name), unit) for name, unit in OF_IRON.items())
        return SolidIron(sigma, mu_r, depth, self.leakage)


class ThrustBearing(Table):
    """The axial magnetic bearing of a machine, with a disc between two magnets.

    at
        Part of the rotor where the disc is; the rotor file includes the mass of the disc.
    controller
        Controller file with one measured signal, which is the displacement along z, and one demand. By default, the
        axis along the shaft in the machine's controller is used.
    bandwidth
        Bandwidth of the amplifier.
    thrust
        Force of the process on the rotor along z, or the smallest and the largest such force.
    inner_radius, outer_radius
        Radius of the inner edge of the inner pole, and radius of the outer edge of the outer pole.
    pole_area, gap, turns, bias_current, current_limit, saturation
        As for `ThrustDisc`.
    k_i, k_s, capacity
        Constants K_i and K_s of a data sheet, and the largest static force. These three values replace the geometry.
    iron
        Solid iron of the core and the disc; by default, both are laminated.
    """

    at: str
    controller: str | None = None
    bandwidth: Value
    thrust: Value | tuple[Value, Value] = 0.0
    inner_radius: Value
    outer_radius: Value
    pole_area: Value | None = None
    gap: Value | None = None
    turns: Value | None = None
    bias_current: Value | None = None
    current_limit: Value | None = None
    saturation: Value | None = None
    k_i: Value | None = None
    k_s: Value | None = None
    capacity: Value | None = None
    iron: SolidCore | None = None

    @model_validator(mode="after")
    def _can_be_built(self) -> ThrustBearing:
        geometry, sheet = (
            [name for name in names if getattr(self, name) is not None] for names in (OF_GEOMETRY, OF_DATA_SHEET)
        )
        if (len(geometry), len(sheet)) not in ((len(OF_GEOMETRY), 0), (0, len(OF_DATA_SHEET))):
            both = f"{', '.join(OF_GEOMETRY)}, or the {', '.join(OF_DATA_SHEET)} of a data sheet"
            raise ValueError(f"the thrust bearing needs either {both}")
        if sheet and self.iron is not None and self.iron.corner is None:
            raise ValueError(
                "iron of a thrust bearing with k_i and k_s needs 'corner', because the bearing's gap is not stated"
            )
        try:
            _ = self.bearing
            omega_b, (low, high) = self.amplifier_bandwidth, self.thrusts
            require(0.0 < omega_b < math.inf, "bandwidth", f"{omega_b:g} rad/s", "> 0 rad/s")
            slowest = math.inf if self.corner is None else self.corner
            allowed = f">= {LEAST_CORNER:.3g} rad/s (1 Hz); a bearing with a slower lag cannot work"
            require(slowest >= LEAST_CORNER, "corner of the eddy currents", f"{slowest:.3g} rad/s", allowed)
            require(-math.inf < low <= high < math.inf, "thrust", f"{low:g} to {high:g} N", "finite, ascending")
        except ValueError as error:
            raise ValueError(f"thrust bearing: {error}") from error
        return self

    @cached_property
    def bearing(self) -> ThrustDisc | CatalogueBearing:
        """The magnets as a model."""
        names = OF_GEOMETRY if self.k_i is None else OF_DATA_SHEET
        radii = (_value(name, getattr(self, name), "m") for name in ("inner_radius", "outer_radius"))
        values = (_value(name, getattr(self, name), unit) for name, unit in names.items())
        return (ThrustDisc if self.k_i is None else CatalogueBearing)(*radii, *values)

    @property
    def amplifier_bandwidth(self) -> float:
        """Bandwidth of the amplifier (rad/s)."""
        return _value("bandwidth", self.bandwidth, "rad/s")

    @property
    def thrusts(self) -> tuple[float, float]:
        """Smallest and largest force of the process on the rotor along z (N)."""
        both = self.thrust if isinstance(self.thrust, tuple) else (self.thrust, self.thrust)
        low, high = (_value("thrust", raw, "N") for raw in both)
        return low, high

    def loads(self, weight: float) -> tuple[float, ...]:
        """Return the static forces (N) with which the bearing balances the weight along z and, in turn, each thrust."""
        return tuple(dict.fromkeys(0.0 - (thrust + weight) for thrust in self.thrusts))

    @property
    def corner(self) -> float | None:
        """Corner frequency (rad/s) of the lag due to eddy currents; None for laminated iron."""
        if self.iron is None:
            return None
        if self.iron.corner is not None:
            return self.iron.measured_corner
        assert isinstance(self.bearing, ThrustDisc), "a corner computed from the material requires the geometry"
        return corner_frequency(self.bearing, self.iron.material)

    @property
    def is_corner_computed(self) -> bool:
        """Whether the corner frequency is computed from the iron's material."""
        return self.iron is not None and self.iron.corner is None

    @cached_property
    def control(self) -> AxialControl | None:
        """The control law from the bearing's own controller file, or None if it has no such file.

        Raises
        ------
        ValueError
            If the file cannot be read, or if the controller does not have exactly one signal, one demand and one law
            for all speeds.
        """
        if self.controller is None:
            return None
        controller = linear_controller(Path(self.controller))
        name = Path(self.controller).name
        signals, demands = len(controller.ports.signals), len(controller.ports.demands)
        if (signals, demands) != (1, 1):
            raise ValueError(
                f"controller {name} of the thrust bearing has {signals} signals and {demands} demands; it must have "
                "one of each"
            )
        if len(controller.laws) > 1:
            raise ValueError(f"controller {name} of the thrust bearing depends on speed; it must have a single law")
        delay = float(controller.starts.get("delay", 0.0))
        return AxialControl(controller.law_at(), controller.sample_time, delay)

    def loop(
        self, mass: float, point: OperatingPoint, control: AxialControl, factors: tuple[float, float] = (1.0, 1.0)
    ) -> AxialLoop:
        """Return the sampled loop of the rotor's axial motion at a static force.

        Parameters
        ----------
        mass
            Mass of the rotor (kg).
        point
            Operating point of the bearing under its static force.
        control
            Control law of the axis, with its sample time and delay.
        factors
            Factors by which K_i and K_s are multiplied (1).
        """
        k_i, k_s = factors[0] * point.k_i, factors[1] * point.k_s
        plant = AxialPlant(mass, k_i, k_s, self.amplifier_bandwidth, self.corner)
        return AxialLoop(plant, *control)

    def moment_stiffness(self, load: float = 0.0) -> float:
        """Return the moment per tilt of the disc (N m/rad) under a static force (N); a positive moment destabilises."""
        return moment_stiffness(self.bearing.operating_point(load).k_s, self.bearing.rings)

    def largest_moment_stiffness(self, weight: float) -> float:
        """Return the largest `moment_stiffness` (N m/rad) under the static forces, which are limited to the capacity.

        The stiffness without load is considered as well, because it applies as long as no force acts.
        """
        return moment_stiffness(self._largest_stiffness(weight), self.bearing.rings)

    def _largest_stiffness(self, weight: float) -> float:
        """Return K_s (N/m) that corresponds to `largest_moment_stiffness`."""
        capacity = self.bearing.capacity
        limited = (min(abs(load), capacity) for load in (0.0, *self.loads(weight)))
        return max(self.bearing.operating_point(load).k_s for load in limited)

    def data(self, weight: float) -> tuple[str, ...]:
        """Return the table row under `DATA_HEADS`, for a weight along z (N).

        K_s and tilt stiffness are the values without load and under the worst static force.
        """
        rest, loads = self.bearing.operating_point(), self.loads(weight)
        k_s = f"{1e-6 * rest.k_s:.4g}", f"{1e-6 * self._largest_stiffness(weight):.4g}"
        corner = "laminated" if self.corner is None else f"{self.corner / (2.0 * math.pi):.4g}"
        constants = (f"{rest.k_i:.4g}", " to ".join(dict.fromkeys(k_s)), f"{self.bearing.capacity:.4g}")
        return (*constants, _span(loads), self._tilt(weight), corner)

    def _tilt(self, weight: float) -> str:
        """Return the tilt stiffness (N m/rad) without load and under the worst static force, as text."""
        values = (f"{-self.moment_stiffness():.4g}", f"{-self.largest_moment_stiffness(weight):.4g}")
        return " to ".join(dict.fromkeys(values))


def _span(loads: Sequence[float]) -> str:
    return " to ".join(f"{load:.4g}" for load in sorted(loads))


def _value(name: str, raw: Value | None, unit: str) -> float:
    assert raw is not None, name
    return quantity(raw, unit, f"{name} of the thrust bearing")
