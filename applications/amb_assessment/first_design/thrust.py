"""The axial bearing of a first design: its disc and faces, its magnet, and the controller of five axes.

    A = mu_0 F/B^2,  F = 4 m g;   K_b = K_s,  C_b = 2 zeta sqrt(K_b m)                              (1)

ROLAC is radial. Therefore, one linear law controls all five axes. On the radial axes, it is identical to the law of the
radial design to the last bit.
"""

from __future__ import annotations

import math
from typing import Annotated, Any, NamedTuple

import tomli_w

from amb_assessment.first_design.levitation import Pid, operating_points
from amb_assessment.first_design.rotor_text import STEEL, diameter_at, filled
from amb_assessment.first_design.sizing import BANDWIDTH, CAPACITY, FLUX, MU_0, MachineSizes
from amb_cosim.model_constants.magnetic_bearing import axis_parameters, linearisation, static_current_for
from amb_cosim.model_constants.rotor_models import control_loop
from amb_cosim.scenario.gravity import STANDARD_GRAVITY
from rotor_analysis.rotor import Rotor

CONTROL = "control.toml"
COLLAR = "thrust_collar"  # of the template, the body that is the disc
DAMPING = 0.7  # zeta of the axial motion
DRIFT = 10.0  # 1/s, rate at which the integral removes a steady deviation
ROLL_OFF = 2000.0  # Hz, of the axial derivative
PLACE = 0.08  # of the length, distance of the disc from the lower bearing


class Thrust(NamedTuple):
    """The magnet of a thrust disc, sized by (1), and its K_s and K_i under the weight of a tilted shaft."""

    name: str
    pole_area: Annotated[float, "m2"]
    inductance: Annotated[float, "H"]
    k_s: Annotated[float, "N/m"]
    k_i: Annotated[float, "N/A"]
    mass: Annotated[float, "kg"]

    @property
    def gains(self) -> tuple[float, float, float]:
        """Gains of the PID: proportional (A/m), integral (A/(m s)) and derivative (A s/m)."""
        kp, kd = 2.0 * self.k_s / self.k_i, 2.0 * DAMPING * math.sqrt(self.k_s * self.mass) / self.k_i
        return kp, DRIFT * kp, kd

    @property
    def channel(self) -> dict[str, Any]:
        """The channel that levitates the axis, for a controller file."""
        return _channel(f"{self.name}.z", f"{self.name}.i_z", *self.gains, ROLL_OFF)

    @property
    def lines(self) -> str:
        """Scenario lines with the values that differ from those of the radial magnets."""
        values = {
            "pole_area_z": f"{1e4 * self.pole_area:.5g} cm^2",
            "inductance_z": f"{1e3 * self.inductance:.5g} mH",
            "half_angle_z": 0,  # its poles are rings
        }
        return "\n" + tomli_w.dumps({f"{self.name}.{key}": value for key, value in values.items()}).rstrip()


def disc_and_faces(rotor: Rotor, gap: float | None = None) -> str:
    """Return the text of a thrust disc above the lower bearing, and of two faces at this bearing's retainer, if any."""
    nodes = rotor.shaft.nodes
    lower = min(rotor.bearings, key=lambda bearing: bearing.node)
    z = nodes[lower.node - 1] + PLACE * (nodes[-1] - nodes[0])
    inner, outer = radii(rotor, z)
    width = 0.25 * outer
    mass = STEEL * math.pi * (outer**2 - inner**2) * width
    text = filled("thrust_disc.toml", z=z, radius=outer, width=width, disc_mass=mass)
    site = next((site for site in rotor.sites if site.bearing == lower.name), None)
    if site is None:
        return text
    at = nodes[site.node - 1]
    return text + filled(
        "faces.toml",
        face_z=at,
        clearance=0.5 * gap if gap else site.clearance,
        radius=0.5 * diameter_at(rotor, at),
        retainer=site.name,
    )


def thrust_magnet(name: str, sizes: MachineSizes, tilt: float) -> Thrust:
    """Return the axial magnet of a machine whose shaft is tilted by an angle (rad) above the horizontal."""
    area = _pole_area(sizes.mass)
    p = axis_parameters(
        turns=sizes.turns,
        pole_area=area,
        gap=sizes.gap,
        bias_current=sizes.bias_current,
        current_limit=sizes.current_limit,
        half_angle=0.0,
        static_current=0.0,
    )
    p.static_current = static_current_for(sizes.mass * STANDARD_GRAVITY * abs(math.sin(tilt)), p)
    at_rest = linearisation(p)
    inductance = 2.0 * MU_0 * sizes.turns**2 * area / sizes.gap
    return Thrust(name, area, inductance, float(at_rest.k_s), float(at_rest.k_i), sizes.mass)


def controller(name: str, sizes: MachineSizes, thrust: Thrust, pid: Pid, sample_time: float) -> str:
    """Return a controller file for five axes with a design's radial gains; demands are limited to the bias current."""
    axes, points = control_loop(sizes.rotor).axes, operating_points(sizes)
    roll_off = 1.0 / (math.tau * pid.derivative_time)
    channels = []
    for axis in axes:
        k_s, k_i = points[axis.bearing].k_s, points[axis.bearing].k_i
        k, c = pid.k_b[axis.bearing] + k_s, pid.c_b[axis.bearing]
        of = f"{axis.bearing}.i_{axis.direction}"
        channels.append(_channel(axis.sensor, of, k / k_i, 0.0, c / k_i, roll_off))
    channels.append(thrust.channel)
    inputs = [*(axis.sensor for axis in axes), f"{thrust.name}.z"]
    outputs = [*(f"{axis.bearing}.i_{axis.direction}" for axis in axes), f"{thrust.name}.i_z"]
    limit = f"{sizes.bias_current:.5g} A"
    table = {
        "description": f"The PID of {name} on five axes",
        "inputs": inputs,
        "outputs": outputs,
        "sample_time": f"{1e6 * sample_time:.5g} us",
        "method": "backward_diff",
        "delay": 1,
        "limits": [f"-{limit}", limit],
        "channel": channels,
    }
    return tomli_w.dumps(table)


def machine_part(radii: tuple[float, float], thrust: Thrust, sizes: MachineSizes) -> str:
    """Return the machine file's text on the axial bearing of `disc_and_faces`, whose disc has the given radii (m)."""
    inner, outer = radii
    of_bearing = {
        "at": COLLAR,
        "bandwidth": f"{1e-3 * BANDWIDTH:.5g} kHz",
        "inner_radius": f"{1e3 * inner:.5g} mm",
        "outer_radius": f"{1e3 * outer:.5g} mm",
        "pole_area": f"{1e4 * thrust.pole_area:.5g} cm^2",
        "gap": f"{1e3 * sizes.gap:.5g} mm",
        "turns": 2 * sizes.turns,  # of its one coil; the actuator counts them for each pole
        "bias_current": f"{sizes.bias_current:.5g} A",
        "current_limit": f"{sizes.current_limit:.5g} A",
        "saturation": f"{axis_parameters().b_sat:.5g} T",
    }
    note = "# The magnet of the thrust disc; a solid disc has eddy currents: see [thrust_bearing.iron]."
    return f"\n{note}\n{tomli_w.dumps({'thrust_bearing': of_bearing})}"


def radii(rotor: Rotor, z: float) -> tuple[float, float]:
    """Return the inner and outer radius (m) of a disc at z with room for the coil and two pole rings sized by (1)."""
    inner = 0.5 * diameter_at(rotor, z)
    return inner, math.sqrt(inner**2 + 3.0 * _pole_area(rotor.mass) / math.pi)


def _channel(source: str, target: str, kp: float, ki: float, kd: float, roll_off: float) -> dict[str, Any]:
    """Return a channel with a PID whose output opposes its input."""
    pid = {"type": "pid", "kp": f"{kp:.6g} A/m", "kd": f"{kd:.6g} A.s/m", "roll_off": f"{roll_off:.6g} Hz"}
    pid |= {"ki": f"{ki:.6g} A/(m.s)"} if ki else {}
    return {"from": source, "to": target, "gain": -1, "blocks": [pid]}


def _pole_area(mass: float) -> float:
    """Return the pole area (m2) of the axial magnet for a rotor's mass (kg), computed by (1)."""
    return MU_0 * CAPACITY * mass * STANDARD_GRAVITY / FLUX**2
