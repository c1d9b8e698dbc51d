"""The axial bearing of a first design: its disc and faces, its magnet, and the controller of five axes.

    A = mu_0 F/B^2,  F = 4 m g;   K_b = K_s,  C_b = 2 zeta sqrt(K_b m)                              (1)

Both coils share the weight, with the currents I_0 + i and I_0 - i. The machine file states I_0, from which an
assessment computes the operating point under the weight. The scenario states the smaller current I_0 - i as the bias,
so that the operating point in simulations is the same one.

ROLAC is radial. Therefore, one linear law controls all five axes. On the radial axes, it is identical to the law of the
radial design to the last bit.
"""

from __future__ import annotations

import math
from typing import Annotated, Any, NamedTuple

import tomli_w

from amb_assessment.first_design.levitation import Pid, operating_points
from amb_assessment.first_design.rotor_text import STEEL, diameter_at, filled
from amb_assessment.first_design.sizing import CAPACITY, FLUX, MU_0, MachineSizes
from amb_cosim.model_constants.magnetic_bearing import axis_parameters
from amb_cosim.model_constants.rotor_models import control_loop
from amb_cosim.scenario.gravity import STANDARD_GRAVITY
from rotor_analysis.rotor import Rotor
from thrust_bearings.disc import OperatingPoint, ThrustDisc

CONTROL = "control.toml"
DAMPING = 0.7  # zeta of the axial motion
DRIFT = 10.0  # 1/s, rate at which the integral removes a steady deviation
ROLL_OFF = 2000.0  # Hz, of the axial derivative
PLACE = 0.08  # of the length, distance of the disc from the lower bearing


class Thrust(NamedTuple):
    """The magnet of a thrust disc, sized by (1), and its operating point under the weight of a tilted shaft.

    name, at
        Names of the disc, and of the part of the rotor nearest to it.
    magnet, point
        The magnet, and its control current, K_i and K_s under the load.
    load
        Force against the weight along z, positive towards larger z.
    mass
        Mass of the rotor.
    """

    name: str
    at: str
    magnet: ThrustDisc
    point: OperatingPoint
    load: Annotated[float, "N"]
    mass: Annotated[float, "kg"]

    @property
    def coils(self) -> tuple[float, float]:
        """Currents of the upper and of the lower coil (A) that carry the weight."""
        return self.magnet.bias_current + self.point.current, self.magnet.bias_current - self.point.current

    @property
    def lines(self) -> str:
        """Scenario lines with the values that differ from those of the radial magnets."""
        magnet, (upper, lower) = self.magnet, self.coils
        inductance = 0.5 * MU_0 * magnet.turns**2 * magnet.pole_area / magnet.gap
        shared = f"  # lower coil; upper coil: {upper:.6g} A" if self.load else ""
        return (
            f'\n"{self.name}.bias_current_z" = "{lower:.6g} A"{shared}'
            f'\n"{self.name}.pole_area_z" = "{1e4 * magnet.pole_area:.5g} cm^2"'
            f'\n"{self.name}.inductance_z" = "{1e3 * inductance:.5g} mH"'
            f'\n"{self.name}.half_angle_z" = 0  # its poles are rings'
        )


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


def thrust_magnet(rotor: Rotor, sizes: MachineSizes, tilt: float) -> Thrust:
    """Return the axial magnet of a rotor with a thrust disc, whose shaft is tilted by an angle (rad) to the horizontal.

    The poles begin at the surface of the shaft, as in `radii`.
    """
    disc = rotor.thrust_disc
    assert disc is not None, "the rotor has no thrust disc"
    inner, outer = radii(rotor, disc.z)
    magnet = ThrustDisc(
        inner_radius=inner,
        outer_radius=outer,
        pole_area=_pole_area(sizes.mass),
        gap=sizes.gap,
        turns=2 * sizes.turns,  # of its one coil; the actuator counts them for each pole
        bias_current=sizes.bias_current,
        current_limit=sizes.current_limit,
        saturation=float(axis_parameters().b_sat),
    )
    load = sizes.mass * STANDARD_GRAVITY * math.sin(tilt)
    nodes, parts = rotor.shaft.nodes, rotor.nodes_by_name
    bodies = {body.name for body in rotor.bodies}
    at = min(parts, key=lambda name: (round(abs(nodes[parts[name] - 1] - disc.z), 6), name not in bodies))
    return Thrust(disc.name, at, magnet, magnet.operating_point(abs(load)), load, sizes.mass)


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
    channels.append(axial_channel(thrust.name, thrust.point.k_i, thrust.point.k_s, thrust.mass))
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


def limits(sizes: MachineSizes, thrust: Thrust) -> str:
    """Return scenario lines that limit each demand to what the coil with less current allows, where coils share a load.

    Beyond that, the amplifier would not follow, and the integral of the axial PID would wind up.
    """
    shared = [(f"{b}.i_?", coils.bias_current, sizes.loads[b]) for b, coils in sizes.coils.items()]
    shared.append((f"{thrust.name}.i_z", thrust.coils[1], thrust.load))
    lines = [
        f'"{demand}.upper" = "{least:.5g} A"' if load > 0.0 else f'"{demand}.lower" = "-{least:.5g} A"'
        for demand, least, load in shared
        if load
    ]
    head = "[parameters.rolac_controller]  # limits of the coils with less current"
    return "\n".join((head, *lines, "", "")) if lines else ""


def machine_part(thrust: Thrust, bandwidth: float) -> str:
    """Return the machine file's text on the axial bearing, whose amplifiers have a bandwidth (Hz)."""
    magnet = thrust.magnet
    of_bearing = {
        "at": thrust.at,
        "bandwidth": f"{1e-3 * bandwidth:.5g} kHz",
        "inner_radius": f"{1e3 * magnet.inner_radius:.5g} mm",
        "outer_radius": f"{1e3 * magnet.outer_radius:.5g} mm",
        "pole_area": f"{1e4 * magnet.pole_area:.5g} cm^2",
        "gap": f"{1e3 * magnet.gap:.5g} mm",
        "turns": int(magnet.turns),
        "bias_current": f"{magnet.bias_current:.5g} A",
        "current_limit": f"{magnet.current_limit:.5g} A",
        "saturation": f"{magnet.saturation:.5g} T",
    }
    note = "# The magnet of the thrust disc; a solid disc has eddy currents: see [thrust_bearing.iron]."
    return f"\n{note}\n{tomli_w.dumps({'thrust_bearing': of_bearing})}"


def radii(rotor: Rotor, z: float) -> tuple[float, float]:
    """Return the inner and outer radius (m) of a disc at z with room for the coil and two pole rings sized by (1)."""
    inner = 0.5 * diameter_at(rotor, z)
    return inner, math.sqrt(inner**2 + 3.0 * _pole_area(rotor.mass) / math.pi)


def axial_channel(name: str, k_i: float, k_s: float, mass: float) -> dict[str, Any]:
    """Return the channel of a controller file that levitates a mass (kg) along its shaft, by (1).

    Parameters
    ----------
    name
        Name of the thrust disc.
    k_i, k_s
        K_i (N/A) and K_s (N/m) of its magnet under the weight.
    mass
        Mass of the rotor (kg).
    """
    return _channel(f"{name}.z", f"{name}.i_z", *axial_gains(k_i, k_s, mass), ROLL_OFF)


def axial_gains(k_i: float, k_s: float, mass: float) -> tuple[float, float, float]:
    """Return the gains of `axial_channel`: proportional (A/m), integral (A/(m s)) and derivative (A s/m)."""
    kp, kd = 2.0 * k_s / k_i, 2.0 * DAMPING * math.sqrt(k_s * mass) / k_i
    return kp, DRIFT * kp, kd


def _channel(source: str, target: str, kp: float, ki: float, kd: float, roll_off: float) -> dict[str, Any]:
    """Return a channel with a PID whose output opposes its input."""
    pid = {"type": "pid", "kp": f"{kp:.6g} A/m", "kd": f"{kd:.6g} A.s/m", "roll_off": f"{roll_off:.6g} Hz"}
    pid |= {"ki": f"{ki:.6g} A/(m.s)"} if ki else {}
    return {"from": source, "to": target, "gain": -1, "blocks": [pid]}


def _pole_area(mass: float) -> float:
    """Return the pole area (m2) of the axial magnet for a rotor's mass (kg), computed by (1)."""
    return MU_0 * CAPACITY * mass * STANDARD_GRAVITY / FLUX**2
