"""Bodies other than the shaft: retainer housings on their mounts, the races in these housings, and the rotor's spin.

docs/theory/retainers.md states the equations of motion; its omega_0 is `RACE_SPEED_SCALE`. T is the friction force on
the rotor; it is positive in the direction of spin. Unbalance couples a free spin to the shaft through p, so that

    (J - p^T M^-1 p) Omega' = M_drive - c_s Omega - p^T a

where a is the shaft's acceleration at constant speed. Damping that rotates with the shaft adds its torque. The mass
matrix and the energy include the coupling; the effect of gravity and base motion on the unbalance itself is neglected.
A body exists if its mass or inertia is set.
"""

from __future__ import annotations

import math

import numpy as np

from fmi_export.jit import kernel, noinline_kernel
from fmi_export.model import Array
from fmi_export.records import record
from rotor_contact.contact.site import Site, Sites, race_radius
from rotor_contact.contact.workspace import Workspace
from rotor_contact.forces.dynamics import Motion, accelerations, forces, spin_coupling
from rotor_contact.variables.signals import Inputs, Parameters

RACE_SPEED_SCALE = 1.0  # rad/s, over which the constant drag of a race changes its sign
CONSTANT_BEYOND = 20.0  # of these speeds, the constant drag no longer depends on the speed
RESOLUTION = 0.2  # of a body's fastest time constant; a substep is no longer
SHORTEST_SUBSTEP = 1e-7  # s; no body requires a shorter one

SPIN = record(  # during a step
    ("row", np.int64),  # degree of freedom, -1 if the speed is prescribed or held
    ("inertia", np.float64),  # kg m^2
    ("drag", np.float64),  # N m s
    ("demanded", np.float64),  # of the drive: its demanded speed (rad/s), gain (N m s), torque and its limit (N m)
    ("gain", np.float64),
    ("torque", np.float64),
    ("torque_limit", np.float64),
    ("scale", np.float64),  # 1/sqrt(J - p . M^-1 p)
)
Spin = np.record


@kernel
def place_bodies(parameters: Parameters, inputs: Inputs, sites: Sites, spin: Spin, n: int) -> int:
    """Assign degrees of freedom to the bodies, after the n degrees of freedom of the shaft; return the total number.

    Housings come first, x and y in turn, then races, then the spin.
    """
    u, p = inputs.scalars[0], parameters.scalars[0]
    place = n
    for site in sites:
        site.housing = -1
        if site.housing_mass > 0.0:
            site.housing = place
            site.mobility = 1.0 / site.housing_mass
            site.base_x, site.base_y = u.base_acceleration.x, u.base_acceleration.y
            place += 2
    for site in sites:
        site.race = -1
        if site.race_inertia > 0.0:
            site.race = place
            site.race_mobility = race_radius(site) ** 2 / site.race_inertia
            place += 1
    spin.row = -1
    if p.spin.free != 0.0:
        spin.inertia = p.spin.inertia
        spin.drag = p.spin.drag
        spin.demanded = u.Omega
        spin.gain = p.drive.gain
        spin.torque = u.drive.torque
        spin.torque_limit = u.drive.torque_limit
        if u.drive.ideal == 0.0:
            spin.row = place
            place += 1
    for site in sites:
        site.spin = spin.row
    return place


@kernel
def race_drag(site: Site, speed: float) -> float:
    """Return the drag torque (N m) that opposes the rotation of a race at `speed` (rad/s)."""
    drag: float = site.race_drag * math.tanh(speed / RACE_SPEED_SCALE) + site.race_viscous_drag * speed
    return drag


@kernel
def drag_slope(site: Site, speed: float) -> float:
    """Return a bound (N m s) on the slope of a race's drag torque with respect to its speed, near `speed` (rad/s)."""
    slope: float = site.race_viscous_drag
    if abs(speed) < CONSTANT_BEYOND * RACE_SPEED_SCALE:
        slope += site.race_drag / RACE_SPEED_SCALE
    return slope


@kernel
def drive_torque(spin: Spin, Omega: float) -> float:
    """Return the torque (N m) of the drive at the spin speed `Omega` (rad/s)."""
    torque: float = spin.torque + spin.gain * (spin.demanded - Omega)
    return min(max(torque, -spin.torque_limit), spin.torque_limit)


@kernel
def drive_slope(spin: Spin) -> float:
    """Return the drag coefficient plus the drive gain (N m s); the gain counts only if the torque limit is not 0."""
    slope: float = spin.drag + (spin.gain if spin.torque_limit > 0.0 else 0.0)
    return slope


@kernel
def is_beyond_limit(spin: Spin, Omega: float) -> bool:
    """Return whether a drive would have to exceed its torque limit to follow its demanded speed.

    For an ideal drive, which prescribes the speed, only the drag counts. A drive whose torque limit is 0 is off.
    """
    torque = spin.drag * Omega if spin.row < 0 else spin.torque + spin.gain * (spin.demanded - Omega)
    return bool(spin.torque_limit > 0.0 and abs(torque) > spin.torque_limit)


@kernel
def drive_limit(spin: Spin) -> float:
    """Return a substep length (s) that resolves drive and drag; the coupling must be up to date."""
    return RESOLUTION / max((spin.drag + spin.gain) * spin.scale * spin.scale, 1e-300)


@noinline_kernel
def couple_spin(motion: Motion, spin: Spin, theta: float) -> float:
    """Write the coupling of a free spin at the rotor angle `theta` (rad); return J - p^T M^-1 p (kg m^2)."""
    direction_x, direction_y = -math.sin(theta), math.cos(theta)
    p, s = spin_coupling(motion)
    _, cosine, sine, _ = forces(motion)
    _, cosine_effect, sine_effect, _ = accelerations(motion)
    inertia: float = spin.inertia
    for i in range(p.shape[0]):
        p[i] = direction_x * cosine[i] + direction_y * sine[i]
        s[i] = direction_x * cosine_effect[i] + direction_y * sine_effect[i]
        inertia -= p[i] * s[i]
    spin.scale = 1.0 / math.sqrt(inertia) if inertia > 0.0 else 0.0
    for i in range(s.shape[0]):
        s[i] *= spin.scale
    return inertia


@kernel
def least_inertia(motion: Motion) -> float:
    """Return an inertia (kg m^2) above which J - p^T M^-1 p is positive at every angle."""
    force, acceleration = forces(motion), accelerations(motion)
    total = 0.0
    for i in range(force.cosine.shape[0]):
        total += force.cosine[i] * acceleration.cosine[i] + force.sine[i] * acceleration.sine[i]
    return total


@kernel
def accelerate_bodies(w: Workspace, q: Array, v: Array, damping_torque: float, a: Array) -> None:
    """Write the contact-free accelerations of the bodies into `a`, and add the effect of the spin on the shaft.

    `damping_torque` is the torque of the shaft's damping on the spin (N m).
    """
    for site in w.sites:
        if site.housing >= 0:
            x, y = site.housing, site.housing + 1
            a[x] = -site.mobility * (site.mount_stiffness_x * q[x] + site.mount_damping_x * v[x]) - site.base_x
            a[y] = -site.mobility * (site.mount_stiffness_y * q[y] + site.mount_damping_y * v[y]) - site.base_y
        if site.race >= 0:
            a[site.race] = -race_drag(site, v[site.race]) / site.race_inertia
    spin = w.spin[0]
    if spin.row >= 0:
        Omega = v[spin.row]
        couple_spin(w.motion, spin, q[spin.row])
        coupling = spin_coupling(w.motion)
        torque = drive_torque(spin, Omega) - spin.drag * Omega + damping_torque
        for i in range(coupling.p.shape[0]):
            torque -= coupling.p[i] * a[i]
        a[spin.row] = torque * spin.scale * spin.scale
        for i in range(coupling.s.shape[0]):
            a[i] -= coupling.s[i] * (torque * spin.scale)


@kernel
def mount_heat(sites: Sites, spin: Spin, v: Array) -> float:
    """Return the dissipation (W) of mount dampers and spin drag."""
    power = 0.0
    for site in sites:
        if site.housing >= 0:
            v_x, v_y = v[site.housing], v[site.housing + 1]
            power += site.mount_damping_x * v_x * v_x + site.mount_damping_y * v_y * v_y
    if spin.row >= 0:
        power += spin.drag * v[spin.row] * v[spin.row]
    return power


@kernel
def power_on_bodies(sites: Sites, spin: Spin, v: Array) -> float:
    """Return the power (W) of the drive, plus the power that the base's acceleration supplies to the housings."""
    power = 0.0
    for site in sites:
        if site.housing >= 0:
            power -= site.housing_mass * (site.base_x * v[site.housing] + site.base_y * v[site.housing + 1])
    if spin.row >= 0:
        power += drive_torque(spin, v[spin.row]) * v[spin.row]
    return power


@noinline_kernel
def kinetic_energy(sites: Sites, v: Array) -> float:
    """Return the kinetic energy (J) of housings and races."""
    energy = 0.0
    for site in sites:
        if site.housing >= 0:
            v_x, v_y = v[site.housing], v[site.housing + 1]
            energy += 0.5 * site.housing_mass * (v_x * v_x + v_y * v_y)
        if site.race >= 0:
            energy += 0.5 * site.race_inertia * v[site.race] * v[site.race]
    return energy


@noinline_kernel
def strain_energy(sites: Sites, q: Array) -> float:
    """Return the strain energy (J) of the mounts."""
    energy = 0.0
    for site in sites:
        if site.housing >= 0:
            x, y = q[site.housing], q[site.housing + 1]
            energy += 0.5 * (site.mount_stiffness_x * x * x + site.mount_stiffness_y * y * y)
    return energy


@kernel
def coupling_energy(motion: Motion, spin: Spin, theta: float, v: Array) -> float:
    """Return the kinetic energy Omega p . v (J) due to the coupling of shaft and free spin."""
    if spin.row < 0:
        return 0.0
    couple_spin(motion, spin, theta)
    p = spin_coupling(motion).p
    energy = 0.0
    for i in range(p.shape[0]):
        energy += v[spin.row] * p[i] * v[i]
    return energy


@kernel
def body_limit(sites: Sites, spin: Spin) -> float:
    """Return a substep length (s) that resolves mounts, races and drive; the coupling must be up to date."""
    fastest = 1e-300
    for site in sites:
        if site.housing >= 0:
            stiffness = max(site.mount_stiffness_x, site.mount_stiffness_y)
            damping = max(site.mount_damping_x, site.mount_damping_y)
            fastest = max(fastest, math.sqrt(stiffness * site.mobility) + damping * site.mobility)
        if site.race >= 0:
            fastest = max(fastest, drag_slope(site, 0.0) / site.race_inertia)
    limit = RESOLUTION / fastest
    return min(limit, drive_limit(spin)) if spin.row >= 0 else limit
