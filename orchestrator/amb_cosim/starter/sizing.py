"""First sizes of a rotor and of its magnetic bearings from mass, length and speed, as handbooks give them.

They are a start, to be replaced by the drawing and the data sheets: every number stands in a file that says where it
comes from. Sources: G. Schweitzer, E. H. Maslen, Magnetic Bearings, Springer, 2009; ISO 21940-11 (balancing grades).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated

from rotor_analysis.checks import require

STEEL = 7850.0  # kg/m3
MU_0 = 4e-7 * math.pi  # V s/(A m)
STANDARD_GRAVITY = 9.81  # m/s2

SHAFT_SHARE = 0.7  # of the mass that is shaft; the rest is one wheel
WHEEL_PLACE = 0.45  # of the length
BEARING_PLACES = (0.18, 0.82)  # of the length
SENSOR_OFFSET, RETAINER_OFFSET = 0.02, -0.05  # of the length, towards the middle
RIM_SPEED = 400.0  # m/s that the wheel may have
SURFACE_SPEED = 200.0  # m/s that laminations on the shaft bear
GRADE = 2.5e-3  # m/s, balancing grade G 2.5
CAPACITY = 4.0  # force of an axis over its share of the weight
FLUX = 1.2  # T in the gap at twice the bias current
CURRENT = 10.0  # A that the amplifier gives
SAMPLE_TIME = 50e-6  # s


@dataclass(frozen=True)
class MachineSizes:
    """A machine of one shaft, one wheel and two magnetic bearings, sized for its mass, length and speed.

    mass, length, speed
        As they were given: kg, m, rad/s.
    diameter, wheel_mass, wheel_radius, wheel_width
        Of the shaft and of the wheel.
    wheel, bearings, sensors, retainers
        Positions along the shaft.
    gap, clearance
        Of magnets, and of retainers.
    turns, pole_area, bias_current, current_limit
        Of a magnet.
    resistance, inductance, voltage_limit
        Of a coil and its amplifier.
    unbalance
        That of the balancing grade at the speed, on the wheel.
    load
        Share of the weight that an axis at 45 degrees carries.
    """

    mass: Annotated[float, "kg"]
    length: Annotated[float, "m"]
    speed: Annotated[float, "rad/s"]
    diameter: Annotated[float, "m"]
    wheel_mass: Annotated[float, "kg"]
    wheel_radius: Annotated[float, "m"]
    wheel_width: Annotated[float, "m"]
    wheel: Annotated[float, "m"]
    bearings: tuple[float, float]
    sensors: tuple[float, float]
    retainers: tuple[float, float]
    gap: Annotated[float, "m"]
    clearance: Annotated[float, "m"]
    turns: int
    pole_area: Annotated[float, "m2"]
    bias_current: Annotated[float, "A"]
    current_limit: Annotated[float, "A"]
    resistance: Annotated[float, "Ohm"]
    inductance: Annotated[float, "H"]
    voltage_limit: Annotated[float, "V"]
    unbalance: Annotated[float, "kg.m"]
    load: tuple[float, float]


def machine_sizes(
    mass: float, length: float, speed: float, bearings: tuple[float, float] | None = None
) -> MachineSizes:
    """Return first sizes of a machine.

    d = sqrt(4 m_shaft/(pi rho L)),  m_shaft = 0.7 m;                                       (1)
    s_0 = d/250, 0.3 to 1 mm,  clearance = s_0/2;                                           (2)
    N = B s_0/(2 mu_0 I_b),  A = mu_0 F/B^2,  F = 4 W + 2 m G Omega,  W = m g/sqrt(2) share  (3)
    L = 2 mu_0 N^2 A/s_0,  U = 2 R I_max + L I_b 2 Omega                                    (4)

    (3) has the flux B at twice the bias current, where a control force of the bias current takes the magnet, and room
    for the unbalance of twice the balancing grade; (4) a bandwidth of full swing of about twice the speed.

    Parameters
    ----------
    mass, length, speed
        Of the rotor (kg, m), and its highest speed in operation (rad/s).
    bearings
        Positions of the bearings along the shaft (m); 0.18 and 0.82 of the length without.

    Raises
    ------
    ValueError
        If a number is not positive, the bearings are not on the shaft one after the other, or the shaft would be so
        thick that its surface is faster than 200 m/s.
    """
    for name, value, unit, most in (
        ("mass", mass, "kg", 1e5),
        ("length", length, "m", 50.0),
        ("speed", speed, "rad/s", 2e4),
    ):
        require(0.0 < value <= most, name, f"{value:g} {unit}", f"> 0 {unit} and <= {most:g} {unit}")
    diameter = math.sqrt(4.0 * SHAFT_SHARE * mass / (math.pi * STEEL * length))
    surface = 0.5 * diameter * speed
    least = math.ceil(1.05 * length * (0.5 * diameter * speed / SURFACE_SPEED) ** 2 * 100.0) / 100.0
    allowed = f">= {least:g} m: at this mass and speed the surface of the shaft has {surface:.0f} m/s"
    require(surface <= SURFACE_SPEED, "length", f"{length:g} m", allowed)
    thin = "less for this length: the shaft would be thicker than a quarter of it"
    require(diameter <= length / 4.0, "mass", f"{mass:g} kg", thin)
    places = bearings or (BEARING_PLACES[0] * length, BEARING_PLACES[1] * length)
    lowest, highest = 0.08 * length, 0.92 * length
    inside = lowest <= places[0] and places[1] <= highest and places[1] - places[0] >= 0.2 * length
    require(
        inside,
        "bearings",
        f"{places[0]:g} m, {places[1]:g} m",
        f"ascending, from {lowest:g} m to {highest:g} m, a fifth of the length apart",
    )
    wheel_mass = (1.0 - SHAFT_SHARE) * mass
    radius = min(2.0 * diameter, RIM_SPEED / speed)
    wheel = WHEEL_PLACE * length
    centre = SHAFT_SHARE * 0.5 * length + (1.0 - SHAFT_SHARE) * wheel
    right = (centre - places[0]) / (places[1] - places[0])
    loads = tuple(mass * STANDARD_GRAVITY * share / math.sqrt(2.0) for share in (1.0 - right, right))
    gap = min(max(round(diameter / 250.0, 4), 0.3e-3), 1e-3)
    bias = 0.4 * CURRENT
    turns = max(round(FLUX * gap / (2.0 * MU_0 * bias)), 4)
    force = CAPACITY * max(*loads) + 2.0 * mass * GRADE * speed
    area = math.ceil(1e6 * MU_0 * force / FLUX**2) / 1e6
    inductance = 2.0 * MU_0 * turns**2 * area / gap
    resistance = 0.3
    return MachineSizes(
        mass=mass,
        length=length,
        speed=speed,
        diameter=diameter,
        wheel_mass=wheel_mass,
        wheel_radius=radius,
        wheel_width=wheel_mass / (STEEL * math.pi * radius**2),
        wheel=wheel,
        bearings=places,
        sensors=(places[0] + SENSOR_OFFSET * length, places[1] - SENSOR_OFFSET * length),
        retainers=(places[0] + RETAINER_OFFSET * length, places[1] - RETAINER_OFFSET * length),
        gap=gap,
        clearance=0.5 * gap,
        turns=turns,
        pole_area=area,
        bias_current=bias,
        current_limit=CURRENT,
        resistance=resistance,
        inductance=inductance,
        voltage_limit=float(
            max(50, 10 * math.ceil(0.1 * (2.0 * resistance * CURRENT + 2.0 * inductance * bias * speed)))
        ),
        unbalance=mass * GRADE / speed,
        load=(loads[0], loads[1]),
    )
