"""Gains that levitate a first design: the best closed-loop stiffness and damping of a grid."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Annotated

from amb_analysis.machine.machine import Machine
from amb_analysis.studies.closed_loop_poles import OVERDAMPED, vibrations
from amb_assessment.first_design.sizing import MachineSizes
from amb_cosim.cosim.basics.choices import Flavour
from amb_cosim.cosim.system.values import RPM
from amb_cosim.design.magnetic_bearing import axis_parameters, linearisation, static_current_for
from amb_cosim.scenario.scenario import load_scenario
from amb_cosim.scenario.simulation import prepare

STIFFNESSES = (0.3, 0.5, 0.75, 1.0, 1.5)  # over K_s
DAMPING_RATIOS = (0.2, 0.35, 0.5, 0.75)  # of the rotor's share on a bearing
SPEEDS = (0.02, 0.35, 0.7, 1.0)  # over the highest
RANGE = 1.2  # of the highest speed
WANTED_IN_RANGE, WANTED_BEYOND = 0.1, 0.002  # damping ratios


@dataclass(frozen=True)
class OperatingPoint:
    """Static current (A), K_s (N/m) and K_i (N/A) with which an axis carries its share of the weight."""

    static_current: float
    k_s: float
    k_i: float


@dataclass(frozen=True)
class Gains:
    """Stiffness and damping of the closed bearings, and the smallest damping ratios of vibrations with them.

    in_range, beyond
        Smallest damping of vibrations up to 1.2 times the highest speed, which unbalance excites, and above; -1 of a
        rotor that drifts away without vibration.
    frequency, speed
        Frequency of the vibration that is furthest below its target, and its speed.
    """

    k_b: Annotated[float, "N/m"]
    c_b: Annotated[float, "N.s/m"]
    in_range: float
    beyond: float
    frequency: Annotated[float, "rad/s"] = math.nan
    speed: Annotated[float, "rad/s"] = math.nan

    @property
    def least_damped(self) -> str:
        """Description of the least damped vibration, or of a growing drift without vibration."""
        if min(self.in_range, self.beyond) < -OVERDAMPED:
            return f"a drift without vibration at {self.speed * RPM:.0f} rpm"
        return f"the vibration at {self.frequency / (2.0 * math.pi):.0f} Hz at {self.speed * RPM:.0f} rpm"

    @property
    def quality(self) -> float:
        """The smaller of the two over its target; above 0 the rotor levitates, at 1 it is well damped."""
        return min(self.in_range / WANTED_IN_RANGE, self.beyond / WANTED_BEYOND)


def operating_points(sizes: MachineSizes) -> dict[str, OperatingPoint]:
    """Return the operating points of the axes of each bearing."""
    return {bearing: _point(sizes, bearing, load) for bearing, load in sizes.loads.items()}


def _point(sizes: MachineSizes, bearing: str, load: float) -> OperatingPoint:
    names = ("turns", "pole_area", "gap", "bias_current", "current_limit")
    p = axis_parameters(**{name: getattr(sizes, name) for name in names}, static_current=0.0)
    if bearing in sizes.coils:
        coils = sizes.coils[bearing]
        p.bias_current, p.pole_area = coils.bias_current, coils.pole_area
    p.static_current = static_current_for(abs(load), p)  # of the coil pair that carries it, whichever that is
    at_rest = linearisation(p)
    return OperatingPoint(float(p.static_current), float(at_rest.k_s), float(at_rest.k_i))


def candidates(sizes: MachineSizes) -> list[tuple[float, float]]:
    """Return stiffnesses K_b (N/m) and damping C_b (N s/m) to try: K_b over K_s, and C_b = 2 zeta sqrt(K_b m/n)."""
    k_s, share = max(point.k_s for point in operating_points(sizes).values()), sizes.mass / len(sizes.loads)
    return [
        (ratio * k_s, 2.0 * zeta * math.sqrt(ratio * k_s * share))
        for ratio, zeta in product(STIFFNESSES, DAMPING_RATIOS)
    ]


def gains_of(scenario: Path, k_b: float, c_b: float, speed: float, flavour: Flavour) -> Gains:
    """Return the least damping ratios of the vibrations of the sampled loop up to a speed (rad/s).

    Parameters
    ----------
    scenario
        File of the scenario whose machine it is.
    k_b, c_b
        Gains of its PID (N/m, N s/m).
    """
    values = {"rolac_controller.*.k_b_?": k_b, "rolac_controller.*.c_b_?": c_b}
    loop = Machine(prepare(load_scenario(str(scenario)).machine(), values, flavour=flavour)).loop
    result = []
    for Omega in (share * speed for share in SPEEDS):
        at = vibrations(loop, Omega)
        if at.stability.is_drift and not at.stability.is_stable:
            result.append((-1.0, 0.0, Omega))
        result += [
            (zeta, omega, Omega) for zeta, omega in zip(at.ratios().tolist(), at.poles.imag.tolist(), strict=True)
        ]
    low, high = ([v for v in result if (v[1] <= RANGE * speed) == is_low] for is_low in (True, False))
    worst = min(result, key=lambda v: v[0] / (WANTED_IN_RANGE if v in low else WANTED_BEYOND))
    return Gains(k_b, c_b, min(low, default=(1.0,))[0], min(high, default=(1.0,))[0], *worst[1:])


def best_gains(scenario: Path, sizes: MachineSizes, flavour: Flavour) -> Gains:
    """Return the gains of the best `quality`; those of `candidates` are tried.

    Raises
    ------
    ValueError
        If none levitates the rotor; the message suggests a change.
    """
    result = [gains_of(scenario, k_b, c_b, sizes.speed, flavour) for k_b, c_b in candidates(sizes)]
    best = max(result, key=lambda gains: gains.quality)
    if best.quality <= 0.0:
        raise ValueError(
            f"no PID of {len(result)} levitates rotor {sizes.rotor.name!r} up to {sizes.speed * RPM:.0f} rpm: with the "
            f"best, K_b = {best.k_b:.3g} N/m and C_b = {best.c_b:.3g} N s/m, {best.least_damped}, "
            f"{min(best.in_range, best.beyond):.2g} of critical damping; {_advice(best.frequency, sizes.speed)}"
        )
    return best


def _advice(frequency: float, speed: float) -> str:
    """Return advice for an unstable vibration (rad/s) of a machine of this speed (rad/s)."""
    if frequency <= RANGE * speed:
        return "move sensors to their bearings and bearings apart, or lower the speed"
    return "it bends: give the rotor its measured [damping], and move sensors to their bearings, away from its nodes"
