"""First sizes of a rotor's magnetic bearings, computed from its weight and speed by handbook rules.

Drawings do not state amplifiers and sample times. They are assumed, and scaled with unusual machines:

    f_b = max(1.4 kHz, 2 f),   T = 50 us/2^n <= 1/(24 f),   f = Omega/(2 pi)                          (0)

The bandwidth f_b of small signals is thus at least that of a full swing, for which the voltage is chosen
(`machine_sizes`). If coils of 10 A need more than 600 V, they have fewer turns and more current, up to 100 A; if they
need less than 50 V, they have more turns and less current, down to 1 A. `rotor_text.gap_for` has the air gap.

Every size is in a file that states its source, so that you can replace it with the value of a data sheet. Sources: G.
Schweitzer, E. H. Maslen, Magnetic Bearings, Springer, 2009; ISO 21940-11 (balancing grades).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, Literal

from amb_analysis.studies.inputs import GRADE
from amb_assessment.first_design.rotor_text import diameter_at, gap_for, require_speed
from amb_cosim.model_constants.magnetic_bearing import axis_parameters, linear_constants
from amb_cosim.presentation.units import speed_unit
from amb_cosim.scenario.gravity import STANDARD_GRAVITY
from amb_cosim.scenario.scenario import share_across
from amb_files.checks import require
from rotor_analysis.parts import BodyOrDisc, Site
from rotor_analysis.rigid_body import rigid_body
from rotor_analysis.rotor import Rotor
from rotor_analysis.static_load import carried_with_seals

MU_0 = 4e-7 * math.pi  # V s/(A m)

SURFACE_SPEED = 200.0  # m/s, limit of laminations on the shaft
CAPACITY = 4.0  # force of an axis over its share of the weight
FLUX = 1.2  # T in the gap at twice the bias current
CURRENT = 10.0  # A, current limit of the amplifier of usual machines
CURRENTS = (1.0, 100.0)  # A, smallest and largest current limit that is assumed
LEAST_VOLTAGE = 50.0  # V, of an amplifier
INDUSTRIAL = 600.0  # V, about the highest voltage of amplifiers that are sold for magnetic bearings
ROOM = 2.5  # least bias current over the current that carries the weight, if neither gap nor bias is stated
AGREES = 0.02  # relative difference of a stated bias current from that of a stated gap
WIDEST = 3.0  # largest assumed gap, over that of a first design
BANDWIDTH = 1400.0  # Hz, least of an amplifier for small signals
SAMPLE_TIME, SAMPLES = 50e-6, 24.0  # s, longest sample time, and least number of samples in a turn


Drive = Literal["differential", "one-sided"]


def bandwidth_for(speed: float) -> float:
    """Return the bandwidth (Hz) that is assumed for amplifiers at a highest speed (rad/s), by (0)."""
    return max(BANDWIDTH, speed / math.pi)


def sample_times_for(speed: float) -> tuple[float, float]:
    """Return the sample times (s) to try at a highest speed (rad/s): that of (0), and half of it."""
    longest = SAMPLE_TIME
    while longest * SAMPLES * speed > 2.0 * math.pi:
        longest *= 0.5
    return longest, 0.5 * longest


@dataclass(frozen=True)
class MagnetData:
    """K_i (N/A) and K_s (N/m) of an axis at its centre, from a data sheet.

    gap, bias
        Air gap (m) or bias current I_0 (A) of the coils, if stated; each follows from the other, and both must agree.
        If one of them is stated, K_i and K_s hold without load; otherwise, they hold at the operating point.
    drive
        How the coils carry a load: `differential` (with currents I_0 + i_s and I_0 - i_s) or `one-sided` (with I_0 +
        I_s and I_0).
    """

    k_i: Annotated[float, "N/A"]
    k_s: Annotated[float, "N/m"]
    gap: Annotated[float | None, "m"] = None
    bias: Annotated[float | None, "A"] = None
    drive: Drive = "differential"

    def __post_init__(self) -> None:
        for name, unit, value in (("K_i", "N/A", self.k_i), ("K_s", "N/m", self.k_s)):
            require(0.0 < value < math.inf, name, f"{value:g} {unit}", f"> 0 {unit}")
        for name, unit, stated in (("gap", "m", self.gap), ("bias", "A", self.bias)):
            require(stated is None or 0.0 < stated < math.inf, name, f"{stated} {unit}", f"> 0 {unit}")
        if self.gap is not None and self.bias is not None:
            follows = self.gap * self.k_s / self.k_i
            if not math.isclose(self.bias, follows, rel_tol=AGREES):
                raise ValueError(
                    f"bias = {self.bias:.4g} A conflicts with the gap: K_s, K_i and a gap of {1e3 * self.gap:.4g} mm "
                    f"require {follows:.4g} A (within {100.0 * AGREES:g} %); set only one of gap and bias"
                )

    @property
    def keeps_k_s(self) -> bool:
        """Whether K_s holds for the loaded axis, as it does for differential drive without a stated gap or bias."""
        return self.gap is None and self.bias is None and self.drive == "differential"


@dataclass(frozen=True)
class CoilCurrents:
    """The coils of an axis that carries its load.

    bias_current, static_current
        Current of the lower coils (A), and additional current of the upper coils (A).
    pole_area
        Pole area (m2).
    """

    bias_current: float
    static_current: float
    pole_area: float


@dataclass(frozen=True)
class MachineSizes:
    """The magnets of a rotor, identical in all bearings, sized for the bearing with the largest load.

    rotor, speed
        The rotor, and its highest speed in operation.
    mass, diameter
        Mass of the rotor, and largest diameter of the shaft in its bearings.
    plane, retainers
        The plane of unbalance nearest to the centre of mass, and the sites that are retainers of the bearings.
    gap
        Air gap of the magnets: twice the smallest clearance of a retainer, or `gap_for` the shaft if there is none.
    turns, pole_area, bias_current, current_limit
        Values of a magnet.
    resistance, inductance, voltage_limit, bandwidth
        Values of a coil and its amplifier.
    unbalance
        Unbalance of the balancing grade at the highest speed.
    loads
        By bearing, the larger load of its two axes at 45 degrees at the highest speed. The load of an axis is its share
        of the weight.
    coils
        Currents and pole area of each bearing that is driven differentially; empty if the upper coils carry the load.
    """

    rotor: Rotor
    speed: Annotated[float, "rad/s"]
    mass: Annotated[float, "kg"]
    diameter: Annotated[float, "m"]
    plane: BodyOrDisc
    retainers: tuple[Site, ...]
    gap: Annotated[float, "m"]
    turns: int
    pole_area: Annotated[float, "m2"]
    bias_current: Annotated[float, "A"]
    current_limit: Annotated[float, "A"]
    resistance: Annotated[float, "Ohm"]
    inductance: Annotated[float, "H"]
    voltage_limit: Annotated[float, "V"]
    bandwidth: Annotated[float, "Hz"]
    unbalance: Annotated[float, "kg.m"]
    loads: dict[str, float]
    coils: dict[str, CoilCurrents] = field(default_factory=dict)

    @property
    def magnet(self) -> MagnetData:
        """K_i and K_s of each axis at its centre, without static current."""
        return _constants(self.turns, self.pole_area, self.gap, self.bias_current)

    @property
    def clearance(self) -> float:
        """Smallest clearance of any retainer (m)."""
        return min((site.clearance for site in self.retainers), default=0.5 * self.gap)


def machine_sizes(
    rotor: Rotor,
    speed: float,
    magnet: MagnetData | None = None,
    *,
    gap: float | None = None,
    tilt: float = 0.0,
    bandwidth: float | None = None,
) -> MachineSizes:
    """Return first sizes of the magnets of a rotor, or sizes that give the constants of a data sheet.

    N = B s_0/(2 mu_0 I_b),  A = mu_0 F/B^2,  F = 4 W + 2 m G Omega,  W = m_b g cos(beta)/sqrt(2)    (1)
    L = 2 mu_0 N^2 A/s_0,  U = 2 R I_max + L I_b 2 Omega                                    (2)
    I_0 = s_0 K_s/K_i,  A such that K_i is the data sheet's                                 (3)
    K_s(i_s) = K_s (1 + (i_s/I_0)^2),  i_s = W/K_i                                          (4)

    m_b is the mass of the flexible rotor that a bearing carries (`carried_with_seals`). The magnets must also carry the
    load at rest, where seals may carry less of the weight. In (1), B is the flux density at twice the bias current,
    which is reached when the control current equals the bias current. The force F includes the unbalance of twice the
    balancing grade. Equation (2) gives a full-swing bandwidth of about twice the speed. With a data sheet, (3) replaces
    (1). Equation (3) follows from (2.8) and (2.9) without a static current. Equation (4) holds for
    differential drive. Unless gap or bias is stated, I_0 is chosen so that K_s(i_s) equals the K_s of the data sheet,
    and the gap is chosen so that I_0 is at least `ROOM` times i_s.

    Parameters
    ----------
    rotor
        The rotor, which must have a sensor and a plane of unbalance, and no bearings other than magnetic ones.
    speed
        Highest operating speed (rad/s).
    magnet
        Constants of a data sheet.
    gap
        Air gap (m); by default twice the smallest clearance of the retainers, or the gap of the data sheet.
    tilt
        Angle beta of the shaft above the horizontal (rad).
    bandwidth
        Bandwidth of the amplifiers for small signals (Hz); by default as in (0).

    Raises
    ------
    ValueError
        If the rotor lacks a sensor or a plane of unbalance, if its surface in a bearing would be faster than 200 m/s,
        or if a magnet of the data sheet cannot carry the weight.
    """
    require_speed(speed)
    retainers = tuple(site for site in rotor.sites if site.bearing is not None)
    for present, what, key in (
        (rotor.sensors, "a sensor", "[[sensors]] with name and z"),
        (rotor.discs, "a plane of unbalance", "a body with unbalance = true"),
    ):
        if not present:
            raise ValueError(f"rotor {rotor.name!r} lacks {what}; its file needs {key}")
    nodes = rotor.shaft.nodes
    diameter = max(diameter_at(rotor, nodes[node - 1]) for node in rotor.bearing_nodes)
    fastest = 2.0 * SURFACE_SPEED / diameter
    surface = f"the shaft's surface then moves at {SURFACE_SPEED:g} m/s (diameter {1e3 * diameter:.3g} mm in a bearing)"
    require(speed <= fastest, "speed", speed_unit().text(speed), f"<= {speed_unit().text(fastest)}: {surface}")
    body = rigid_body(rotor)
    loads, at_rest = (_axis_loads(rotor, Omega, share_across(tilt)) for Omega in (speed, 0.0))
    least = min((site.clearance for site in retainers), default=0.0)
    gap = gap or 2.0 * least or gap_for(diameter)
    most_loaded = max(map(abs, (*loads.values(), *at_rest.values())))
    if magnet is not None:
        gap = _gap_with(magnet, gap, most_loaded)
    require(gap > least, "gap", f"{gap:.4g} m", f"> {least:.4g} m, the clearance of a retainer")
    bias = 0.4 * CURRENT if magnet is None else gap * magnet.k_s / magnet.k_i
    turns = max(round(FLUX * gap / (2.0 * MU_0 * bias)), 4)
    force = CAPACITY * most_loaded + 2.0 * body.mass * GRADE * speed
    area = math.ceil(1e6 * MU_0 * force / FLUX**2) / 1e6
    if magnet is not None:
        area = _area_with(magnet, gap, bias, turns, most_loaded)
    coils = {} if magnet is None else _differential(magnet, bias, area, loads)
    inductance = 2.0 * MU_0 * turns**2 * area / gap
    resistance, limit = 0.3, max(CURRENT, 2.5 * bias)
    voltage = 2.0 * resistance * limit + 2.0 * inductance * bias * speed
    if magnet is None:
        fewer = _fewer(turns, voltage)
        turns, bias, limit, voltage = round(turns / fewer), bias * fewer, limit * fewer, voltage / fewer
        inductance, resistance = inductance / fewer**2, resistance / fewer**2
    return MachineSizes(
        rotor=rotor,
        speed=speed,
        mass=body.mass,
        diameter=diameter,
        plane=min(rotor.discs, key=lambda disc: abs(rotor.position_of(rotor.point_of(disc.name)) - body.centre)),
        retainers=retainers,
        gap=gap,
        turns=turns,
        pole_area=area,
        bias_current=bias,
        current_limit=limit,
        resistance=resistance,
        inductance=inductance,
        voltage_limit=float(max(LEAST_VOLTAGE, 10 * math.ceil(0.1 * voltage - 1e-9))),
        bandwidth=bandwidth_for(speed) if bandwidth is None else bandwidth,
        unbalance=body.mass * GRADE / speed,
        loads=loads,
        coils=coils,
    )


def _fewer(turns: int, voltage: float) -> float:
    """Return the factor by which coils have fewer turns and more current, so that they need 50 to 600 V.

    U ~ N with the same force, current I ~ 1/N, and the same copper, R ~ N^2; I remains within `CURRENTS`.
    """
    wanted = math.floor(turns * min(max(1.0, LEAST_VOLTAGE / voltage), INDUSTRIAL / voltage))
    least, most = (CURRENT / limit for limit in CURRENTS[::-1])
    return turns / min(max(wanted, math.ceil(least * turns)), math.floor(most * turns))


def _axis_loads(rotor: Rotor, Omega: float, across: float) -> dict[str, float]:
    """Return, by bearing, the larger load (N) of its two axes, which are at 45 degrees, at a spin speed (rad/s).

    `across` is the share of the weight that acts across the shaft.
    """
    carried = carried_with_seals(rotor, {}, Omega)
    of_axes = {name: mass.sum(axis=1) * across * STANDARD_GRAVITY / math.sqrt(2.0) for name, mass in carried.items()}
    return {name: float(max(loads, key=abs)) for name, loads in of_axes.items()}


def _gap_with(magnet: MagnetData, gap: float, load: float) -> float:
    """Return the gap (m) of a magnet from a data sheet; if the gap is assumed, it is at least `gap`."""
    if magnet.gap is not None:
        return magnet.gap
    if magnet.bias is not None:
        return magnet.bias * magnet.k_i / magnet.k_s
    if magnet.drive == "one-sided":
        return gap
    return min(max(gap, (ROOM + 1.0 / ROOM) * load / magnet.k_s), WIDEST * gap)


def _differential(magnet: MagnetData, bias: float, area: float, loads: Mapping[str, float]) -> dict[str, CoilCurrents]:
    """Return the coils that share the load of each bearing, computed by (4); empty for one-sided drive.

    If neither gap nor bias is stated, I_0 + i_s^2/I_0 = s_0 K_s/K_i, and the pole area is proportional to 1/I_0.
    """
    if magnet.drive == "one-sided":
        return {}
    result = {}
    for bearing, load in loads.items():
        shift, unloaded_bias = abs(load) / magnet.k_i, bias
        if magnet.keeps_k_s:
            unloaded_bias = 0.5 * (bias + math.sqrt(bias**2 - 4.0 * shift**2))
        result[bearing] = CoilCurrents(unloaded_bias - shift, 2.0 * shift, area * bias / unloaded_bias)
    return result


def _area_with(magnet: MagnetData, gap: float, bias: float, turns: int, load: float) -> float:
    """Return the pole area (m2) that gives an axis the K_i of a data sheet; check that the axis carries a load (N)."""
    swing = 0.5 * bias if magnet.keeps_k_s else bias
    reason = f"to carry {load:.4g} N with a swing of {swing:.3g} A, which follows from gap, K_i and K_s"
    allowed = f"> {load / swing:.4g} N/A, {reason}"
    require(magnet.k_i * swing > load, "K_i", f"{magnet.k_i:g} N/A", allowed)
    return 1e-4 * magnet.k_i / _constants(turns, 1e-4, gap, bias).k_i


def _constants(turns: int, pole_area: float, gap: float, bias: float) -> MagnetData:
    """Return K_i and K_s of an axis at its centre, without static current."""
    p = axis_parameters(
        turns=turns, pole_area=pole_area, gap=gap, bias_current=bias, current_limit=3.0 * bias, static_current=0.0
    )
    k_s, k_i = linear_constants(p)
    return MagnetData(k_i, k_s)
