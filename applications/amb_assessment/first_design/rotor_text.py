"""Texts for a first rotor file: a plain shaft with a wheel, and any missing supports, damping and reduction.

A rotor file made from a drawing is used instead of the shaft. If it has bearings, retainers and sensors, they are used
instead of the supports.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from string import Template

from amb_cosim.cosim.system.values import RPM, stated
from amb_cosim.presentation.units import speed_unit
from amb_cosim.scenario.gravity import STANDARD_GRAVITY
from amb_files.checks import require
from rolac_controller.signals import LARGEST_SPEED
from rotor_analysis.rotor import Rotor

STEEL = 7850.0  # kg/m3
SHAFT_SHARE = 0.7  # fraction of the mass in the shaft; the rest is in the wheel
WHEEL_PLACE = 0.45  # of the length
RIM_SPEED = 400.0  # m/s, highest of the wheel
FASTEST = 0.95 * LARGEST_SPEED  # the trip speed is above it (`levitation.TRIP`)
BEARING_PLACES = (0.18, 0.82)  # of the length
SENSOR_OFFSET, RETAINER_OFFSET = 0.02, -0.05  # of the length, towards the middle
TEMPLATES = Path(__file__).parent / "part_templates"


def plain_shaft(name: str, mass: float, length: float, speed: float) -> str:
    """Return the text of a rotor file for a steel cylinder with a wheel, without supports.

    d = sqrt(4 m_shaft/(pi rho L)), m_shaft = 0.7 m; the wheel's rim moves at up to 400 m/s (1)

    Parameters
    ----------
    name
        Name of the rotor.
    mass, length, speed
        Mass (kg) and length (m) of the rotor, and its highest operating speed (rad/s).

    Raises
    ------
    ValueError
        If the name is not allowed in a TOML file, if a number is not positive, or if the shaft would be thicker than a
        quarter of its length.
    """
    require_name(name)
    for key, value, unit, most in (("mass", mass, "kg", 1e5), ("length", length, "m", 50.0)):
        require(0.0 < value <= most, key, f"{value:g} {unit}", f"> 0 {unit} and <= {most:g} {unit}")
    require_speed(speed)
    diameter = math.sqrt(4.0 * SHAFT_SHARE * mass / (math.pi * STEEL * length))
    thin = "less for this length: the shaft would be thicker than a quarter of its length"
    require(diameter <= length / 4.0, "mass", f"{mass:g} kg", thin)
    wheel_mass, radius = (1.0 - SHAFT_SHARE) * mass, min(2.0 * diameter, RIM_SPEED / speed)
    return filled(
        "shaft.toml",
        name=name,
        mass=mass,
        length=float(length),
        shaft_share=SHAFT_SHARE,
        diameter=diameter,
        density=STEEL,
        wheel=WHEEL_PLACE * length,
        wheel_mass=wheel_mass,
        wheel_radius=radius,
        wheel_width=wheel_mass / (STEEL * math.pi * radius**2),
    )


def supports(
    rotor: Rotor,
    places: tuple[float, float] | None,
    k_b: Mapping[str, float] | None = None,
    c_b: Mapping[str, float] | None = None,
    gap: float | None = None,
) -> str:
    """Return the text of bearings, retainers and sensors for a rotor file without them.

    s_0 = d/250, >= min(0.3 mm, d/40), <= max(1 mm, d/500),  clearance = s_0/2                 (2)

    d is the diameter of the shaft in the bearings. The limits of 0.3 and 1 mm are those of shafts of 12 to 500 mm.

    Parameters
    ----------
    rotor
        The rotor without these parts.
    places
        Positions of the two bearings along the shaft (m); by default 0.18 and 0.82 of the length.
    k_b, c_b
        Stiffness (N/m) and damping (N s/m) of the bearings `left` and `right` in analyses without a controller. By
        default, there is no damping, and the rotor sinks by half the clearance under its weight.
    gap
        Air gap s_0 (m); by default, it is computed by (2).

    Raises
    ------
    ValueError
        If the bearings are not in ascending order, or are too close to each other or to the ends of the shaft.
    """
    begin, end = rotor.shaft.nodes[0], rotor.shaft.nodes[-1]
    length = end - begin
    left, right = places or (begin + BEARING_PLACES[0] * length, begin + BEARING_PLACES[1] * length)
    lowest, highest = begin + 0.08 * length, begin + 0.92 * length
    require(
        lowest <= left and right <= highest and right - left >= 0.2 * length,
        "bearings",
        f"{left:g} m, {right:g} m",
        f"ascending, from {lowest:g} m to {highest:g} m, at least a fifth of the length apart",
    )
    diameter = max(diameter_at(rotor, z) for z in (left, right))
    clearance = 0.5 * (gap or gap_for(diameter))
    names = ("left", "right")
    k_b = k_b or dict.fromkeys(names, rotor.mass * STANDARD_GRAVITY / clearance)
    c_b = c_b or dict.fromkeys(names, 0.0)
    offsets = {"bearing": 0.0, "sensor": SENSOR_OFFSET * length, "retainer": RETAINER_OFFSET * length}
    values = {f"{part}_left": left + offset for part, offset in offsets.items()}
    values |= {f"{part}_right": right - offset for part, offset in offsets.items()}
    values |= {f"{key}_{name}": gains[name] for key, gains in (("k_b", k_b), ("c_b", c_b)) for name in names}
    return filled("supports.toml", clearance=clearance, **values)


def gap_for(diameter: float) -> float:
    """Return the air gap (m) of a magnet around a shaft of diameter d (m), as in (2)."""
    narrowest, widest = min(0.3e-3, diameter / 40.0), max(1e-3, diameter / 500.0)
    return float(f"{min(max(round(diameter / 250.0, 4), narrowest), widest):.2g}")


def damping() -> str:
    """Return the text of the damping that is assumed for a rotor file without damping."""
    return filled("damping.toml")


def reduction(speed: float) -> str:
    """Return the text of a reduction that is valid up to a spin speed (rad/s), for a rotor file without a reduction."""
    return filled("reduction.toml", speed=speed, rpm=speed * RPM)


def diameter_at(rotor: Rotor, z: float) -> float:
    """Return the diameter of the shaft (m) at a position (m); at a step, this is the larger diameter."""
    nodes, elements = rotor.shaft.nodes, rotor.elements
    near = [k for k in range(len(elements)) if nodes[k] - 1e-9 <= z <= nodes[k + 1] + 1e-9]
    return max(elements[k][0].diameters_at(min(max((z - nodes[k]) / elements[k][0].length, 0.0), 1.0))[0] for k in near)


def require_name(name: str) -> None:
    """Raise a ValueError unless a name is allowed between quotes in a TOML file."""
    is_plain = name.isprintable() and not set(name) & {'"', "\\"}
    require(is_plain, "name", repr(name), "printable, without quotation marks and backslashes")


def require_speed(speed: float, written: str | None = None) -> None:
    """Raise a ValueError unless a speed (rad/s) and the trip speed above it are within the limits of the models.

    The message contains the speed as the user wrote it, if `written` is given.
    """
    shown = speed_unit().text(speed) if written is None else stated(speed_unit().text(speed), written)
    most = f"{speed_unit().text(FASTEST)}, because the models end at {speed_unit().text(LARGEST_SPEED)}"
    require(0.0 < speed <= FASTEST, "speed", shown, f"> {speed_unit().text(0.0)} and <= {most}")


def filled(template: str, **values: float | str) -> str:
    """Return the text of a template with the values filled in; numbers have five significant digits."""
    text = Template((TEMPLATES / template).read_text(encoding="utf-8"))
    return text.substitute({key: v if isinstance(v, str) else f"{v:.5g}" for key, v in values.items()})
