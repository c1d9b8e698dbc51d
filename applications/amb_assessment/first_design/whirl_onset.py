"""The time after which a landing has begun to whirl, if it does.

The rotor falls, and swings in its retainers like a pendulum of the length of the clearance c. A swing over the top may
become backward whirl, but no longer once friction mu has spun up the races, each of which carries half the weight W,
because nothing slides then.

    t = sqrt(2 c/g) + min(n 2 pi sqrt(c/g), I_r Omega/(mu r W/2))                                     (1)

In 266 landings of three first designs (40 to 400 kg, 6,000 to 18,000 rpm, clearances of 0.15 and 0.3 mm, friction from
0.08 to 0.4), the last of 63 whirls began after 19 periods. I_r is the inertia of a race, and r its radius.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from amb_cosim.scenario.gravity import STANDARD_GRAVITY
from amb_cosim.scenario.scenario import share_across

FRICTION = 0.12  # steel on steel, lubricated
SWINGS = 20  # n in (1)
STEP = 0.05  # s, to which times are rounded up


class Race(NamedTuple):
    """The races of a first design: radius, polar inertia, and drag under half the weight of the rotor."""

    radius: Annotated[float, "m"]
    inertia: Annotated[float, "kg.m2"]
    drag: Annotated[float, "N.m"]


def race_of(mass: float, diameter: float) -> Race:
    """Return an assumed race: a hundredth of m r^2, and a coefficient of rolling friction of 0.0015.

    Parameters
    ----------
    mass, diameter
        Mass of the rotor (kg), and diameter of its shaft in the bearings (m).
    """
    r = 0.5 * diameter
    return Race(r, 0.01 * mass * r**2, 0.0015 * 0.5 * mass * STANDARD_GRAVITY * r)


def whirl_onset(mass: float, speed: float, clearance: float, race: Race, tilt: float = 0.0) -> float:
    """Return the time (1) from the loss of power until any whirl has begun (s), rounded up to 0.05 s.

    Parameters
    ----------
    mass, speed
        Mass of the rotor (kg), and its speed when the power is lost (rad/s).
    clearance, race
        Clearance of the retainers (m), and their races.
    tilt
        Angle of the shaft above the horizontal (rad). An upright rotor does not swing, and falls along its shaft.
    """
    across = STANDARD_GRAVITY * share_across(tilt)
    spun_up = race.inertia * speed / (FRICTION * race.radius * 0.5 * mass * STANDARD_GRAVITY)
    swings = SWINGS * 2.0 * math.pi * math.sqrt(clearance / across) if across else math.inf
    fall = math.sqrt(2.0 * clearance / (across or STANDARD_GRAVITY))
    return STEP * math.ceil((fall + min(swings, spun_up)) / STEP - 1e-9)
