"""Variable table of the plant, which follows from the planes of its rotor."""

from __future__ import annotations

import math

from fmi_export.variables import (
    Array,
    Enumeration,
    Interface,
    Variable,
    input_,
    interface,
    one_of,
    output,
    parameter,
    repeated,
)
from rotor_contact import start_values
from rotor_contact.planes import ContactSite, Planes, SensorPlane

IMPACT_LAW = Enumeration(
    "ImpactLaw",
    (
        ("nodal", "the radial velocity of the touching node alone becomes zero (4.22, 4.23)"),
        ("newton", "momentum-consistent impact with restitution"),
    ),
)
NODAL, NEWTON = range(2)
CONTACT_MODE = Enumeration("ContactMode", (("free", ""), ("sliding", ""), ("rolling", "")))
FREE, SLIDING, ROLLING = range(3)
CONTACT_LAW = Enumeration(  # the constraint, and the classical laws of 4.2 in the order of the thesis
    "ContactLaw",
    (
        ("constraint", "rigid"),
        ("linear", "spring"),
        ("hertz", "power 3/2 of the penetration"),
        ("kelvin_voigt", "spring and damper"),
        ("kirk", "spring and damper that engage with the penetration"),
        ("hunt_crossley", "Hertz with damping"),
        ("ulbrich", "Hertz with loss"),
        ("switched_kelvin_voigt", "spring and damper without pull"),
    ),
)
LAWS = CONTACT_LAW.names
CONSTRAINT, LINEAR, HERTZ, KELVIN_VOIGT, KIRK, HUNT_CROSSLEY, ULBRICH, SWITCHED_KELVIN_VOIGT = range(len(LAWS))


def _site_parameters(contact: ContactSite) -> list[Variable]:
    site = contact.name
    at = f"at {site.upper()}"
    return [
        parameter(f"{site}.enabled", "1", f"Whether the rotor can touch {at}", 1.0, type="Boolean"),
        parameter(f"{site}.law", "1", f"Contact law {at}", CONSTRAINT, **one_of(CONTACT_LAW)),
        parameter(f"{site}.clearance", "m", f"Radial clearance {at}", contact.clearance, minimum=1e-6, maximum=0.1),
        parameter(f"{site}.mu", "1", f"Coefficient of friction {at}", 0.0, minimum=0.0, maximum=10.0),
        parameter(
            f"{site}.mu_static",
            "1",
            f"Coefficient of static friction {at}; that of sliding counts if it is larger",
            0.0,
            minimum=0.0,
            maximum=10.0,
        ),
        parameter(
            f"{site}.stribeck_velocity",
            "m/s",
            f"Slip velocity {at} over which sliding friction falls from mu_static to mu; 0: it is mu at once",
            0.0,
            minimum=0.0,
            maximum=1e3,
        ),
        parameter(
            f"{site}.restitution",
            "1",
            f"Coefficient of restitution {at}, of the newton impact law",
            0.0,
            minimum=0.0,
            maximum=1.0,
        ),
        parameter(
            f"{site}.journal_radius", "m", f"Journal radius {at}", contact.journal_radius, minimum=0.0, maximum=10.0
        ),
        parameter(f"{site}.offset_x", "m", f"Centre of the clearance in x {at}", 0.0),
        parameter(f"{site}.offset_y", "m", f"Centre of the clearance in y {at}", 0.0),
        parameter(
            f"{site}.k_c",
            "N/m",
            f"Contact stiffness {at}, at delta_c in laws 2, 5 and 6",
            1e8,
            minimum=1.0,
            maximum=1e12,
        ),
        parameter(f"{site}.c_c", "N.s/m", f"Contact damping {at}, of laws 3, 4 and 7", 0.0, minimum=0.0, maximum=1e9),
        parameter(
            f"{site}.delta_c",
            "m",
            f"Penetration {at} at which laws 2, 5 and 6 have stiffness k_c, law 4 is fully engaged, and law 7 switches",
            1e-5,
            minimum=1e-9,
            maximum=1e-2,
        ),
        parameter(f"{site}.alpha_c", "s/m", f"Damping {at}, of law 5", 0.0, minimum=0.0, maximum=1e3),
        parameter(f"{site}.eta", "1", f"Loss {at}, of law 6", 0.0, minimum=0.0, maximum=0.66),
        *_retainer_parameters(site, at),
    ]


def _retainer_parameters(site: str, at: str) -> list[Variable]:
    """What makes a retainer a body: housing on a mount, race, temperature."""
    not_negative = {"minimum": 0.0, "maximum": 1e12}
    return [
        parameter(
            f"{site}.housing_mass", "kg", f"Mass of the retainer's housing {at}; 0: it is fixed", 0.0, **not_negative
        ),
        *(
            parameter(
                f"{site}.mount_stiffness_{axis}", "N/m", f"Stiffness of its mount {at} in {axis}", 0.0, **not_negative
            )
            for axis in "xy"
        ),
        *(
            parameter(
                f"{site}.mount_damping_{axis}", "N.s/m", f"Damping of its mount {at} in {axis}", 0.0, **not_negative
            )
            for axis in "xy"
        ),
        parameter(
            f"{site}.race_inertia",
            "kg.m2",
            f"Polar inertia of what turns in the retainer {at}, race and rolling elements; 0: nothing does",
            0.0,
            **not_negative,
        ),
        parameter(f"{site}.race_drag", "N.m", f"Constant drag on the race {at}", 0.0, **not_negative),
        parameter(f"{site}.race_viscous_drag", "N.m.s", f"Viscous drag on the race {at}", 0.0, **not_negative),
        parameter(
            f"{site}.heat_capacity",
            "J/K",
            f"Heat capacity of the retainer {at}; 0: its temperature stays",
            0.0,
            **not_negative,
        ),
        parameter(f"{site}.heat_transfer", "W/K", f"Heat given off per temperature {at}", 0.0, **not_negative),
        parameter(f"{site}.temperature_limit", "K", f"Temperature that is allowed {at}", 393.15, **not_negative),
    ]


def _site_outputs(site: str, planes: Planes) -> list[Variable]:
    at = f"at {site.upper()}"
    journal = start_values.journal(planes, site)
    forces = start_values.forces(planes)
    return [
        output(
            f"{site}.gap",
            "m",
            f"Clearance left {at}, zero in contact, negative if the contact yields",
            starts_from=journal,
            display_unit="um",
        ),
        output(
            f"{site}.mode",
            "1",
            f"Mode of contact {at}",
            starts_from=forces,
            **one_of(CONTACT_MODE),
        ),
        output(f"{site}.f_n", "N", f"Normal contact force {at}, inward on the rotor", starts_from=forces),
        output(
            f"{site}.f_t",
            "N",
            f"Friction force on the rotor {at}, forward (in the direction of spin) positive",
            starts_from=forces,
        ),
        output(
            f"{site}.impulse",
            "N.s",
            f"Normal impulse of the impacts {at} during the last step, such that momentum is conserved",
            starts_from=(),
        ),
        output(
            f"{site}.slip_velocity",
            "m/s",
            f"Velocity of the journal surface over the retainer {at}",
            starts_from=start_values.slip(planes, site),
        ),
        output(
            f"{site}.whirl_speed",
            "rad/s",
            f"Whirl speed about the centre of the clearance {at}",
            starts_from=journal,
        ),
        *(
            output(
                f"{site}.housing_{axis}",
                "m",
                f"Displacement of the retainer's housing {at} in {axis}",
                starts_from=(),
                display_unit="um",
            )
            for axis in "xy"
        ),
        output(
            f"{site}.race_speed", "rad/s", f"Speed of the race {at}, positive in the direction of spin", starts_from=()
        ),
        output(
            f"{site}.friction_power",
            "W",
            f"Heat per second of sliding friction {at}",
            starts_from=start_values.sliding(planes),
        ),
        output(f"{site}.heat", "J", f"Heat so far of friction, race drag and impacts {at}", starts_from=()),
        output(f"{site}.temperature", "K", f"Temperature of the retainer {at}", starts_as="ambient_temperature"),
        output(
            f"{site}.passed",
            "1",
            f"Whether the rotor is beyond the clearance {at}, where it cannot touch because enabled is false",
            type="Boolean",
            starts_from=journal,
            warning=f"the rotor passes {site.upper()}, which {site}.enabled = false leaves out: the gap is "
            f"{{{site}.gap}} m with a clearance of {{{site}.clearance}} m",
        ),
        output(
            f"{site}.beyond_reduction",
            "1",
            f"Whether it whirls in contact {at} faster than the frequency to which the rotor's reduction is accurate",
            type="Boolean",
            starts_from=start_values.sliding_contact(planes),
            warning=f"the whirl in contact at {site.upper()}, {{{site}.whirl_speed}} rad/s, is faster than the rotor's "
            "reduction is accurate for: keep more planes or modes",
        ),
        output(
            f"{site}.overheated",
            "1",
            f"Whether the retainer is beyond its temperature_limit {at}",
            type="Boolean",
            starts_from=("ambient_temperature", f"{site}.temperature_limit"),
            warning=f"{site}.temperature = {{{site}.temperature}} K is beyond {site}.temperature_limit = "
            f"{{{site}.temperature_limit}} K",
        ),
    ]


def _bearing_parameters(bearing: str) -> list[Variable]:
    at = f"at {bearing.upper()}, both axes; on top of the forces given as inputs"
    return [
        parameter(f"{bearing}.k_b", "N/m", f"Passive bearing stiffness {at}", 0.0, tunable=True),
        parameter(f"{bearing}.c_b", "N.s/m", f"Passive bearing damping {at}", 0.0, minimum=0.0, tunable=True),
    ]


def _axis_inputs(bearing: str, axis: str) -> list[Variable]:
    at = f"{bearing.upper()}, {axis} axis"
    return [
        input_(f"{bearing}.f_{axis}", "N", f"Force on the rotor, {at}", field="force"),
        input_(f"{bearing}.k_{axis}{axis}", "N/m", f"Gradient of that force over displacement, {at}", field="gradient"),
        input_(
            f"{bearing}.{axis}_ref",
            "m",
            f"Displacement at which that force holds, {at}",
            field="reference",
            display_unit="um",
        ),
    ]


def _unbalance_inputs(name: str, what: str) -> list[Variable]:
    return [
        input_(f"{name}.u", "kg.m", f"Unbalance of {what}", minimum=0.0),
        input_(f"{name}.phi", "rad", f"Angle of that unbalance from the rotor's mark, {what}"),
    ]


def _disc_inputs(disc: str) -> list[Variable]:
    at = disc.upper()
    return [
        *_unbalance_inputs(disc, at),
        input_(f"{disc}.f_x", "N", f"External force on {at} in x"),
        input_(f"{disc}.f_y", "N", f"External force on {at} in y"),
    ]


def _displacement_output(name: str, what: str, starts_from: tuple[str, ...]) -> list[Variable]:
    return [output(name, "m", what, starts_from=starts_from, field=".", display_unit="um")]


def _sensor_array(names: list[str]) -> Array:
    return Array("sensors", f"Sensor displacements: {', '.join(names)}")


def interface_of(planes: Planes) -> Interface:
    """Return the variables of a plant whose rotor has these planes."""
    sites, bearings = planes.sites, planes.bearings
    axes = [(bearing, axis) for bearing in bearings for axis in "xy"]
    displacements = [
        (f"{b}.{a}", f"Displacement at {b.upper()} in {a}", start_values.displacement(planes, b, a)) for b, a in axes
    ]
    sensors = [
        (name, f"Sensor displacement, {p.name}, in {a}", start_values.displacement(planes, p.name, a))
        for p in planes.sensors
        for name, a in ((p.x, "x"), (p.y, "y"))
    ]
    return interface(
        *_model_parameters(planes.max_substep),
        *_spin_parameters(planes.polar_inertia),
        repeated("sites", [(site,) for site in sites], _site_parameters),
        repeated("bearings", [(bearing,) for bearing in bearings], _bearing_parameters),
        input_(
            "Omega",
            "rad/s",
            "Spin speed at the beginning of a step; with spin.free the speed at the start, then what the drive demands",
            minimum=-1e4,
            maximum=1e4,
        ),
        input_("Omega_dot", "rad/s2", "Spin acceleration during a step, without spin.free"),
        input_("drive.torque", "N.m", "Torque of the drive at the demanded speed, with spin.free"),
        input_("drive.torque_limit", "N.m", "Largest torque of the drive, either way; 0: it is off", minimum=0.0),
        input_("base.a_x", "m/s2", "Acceleration of the base in x", field="base_acceleration.x"),
        input_("base.a_y", "m/s2", "Acceleration of the base in y", field="base_acceleration.y"),
        repeated("axes", axes, _axis_inputs),
        repeated("discs", [(disc,) for disc in planes.discs], _disc_inputs),
        repeated("cores", [(bearing, f"the rotor at {bearing.upper()}") for bearing in bearings], _unbalance_inputs),
        output("theta", "rad", "Rotor angle, within one turn", minimum=0.0, maximum=2.0 * math.pi, starts_from=()),
        output("speed", "rad/s", "Spin speed at the end of the step", starts_as="Omega"),
        output(
            "solver.tolerance_missed",
            "1",
            "Whether a substep of the last step was less accurate than solver.tolerance",
            type="Boolean",
            starts_from=(),
            warning="a substep was less accurate than solver.tolerance = {solver.tolerance} m/s; it takes a "
            "solver.max_substep below {solver.max_substep} s",
        ),
        repeated("displacements", displacements, _displacement_output),
        repeated("sensors", sensors, _displacement_output, array=_sensor_array([name for name, *_ in sensors])),
        repeated("sites", [(site.name, planes) for site in sites], _site_outputs),
        _contact_state(planes),
        *_energies(planes),
        output("fault_code", "1", "0 while all is well; the log says what else means", type="Integer", starts_from=()),
    )


def _contact_state(planes: Planes) -> Variable:
    """Which bearings' retainers the rotor touches, as a sum of 1, 2, 4, ... in the order of the bearings."""
    parts = [
        f"{2**k} {' or '.join(site.name.upper() for site in planes.sites if site.bearing == bearing) or bearing}"
        for k, bearing in enumerate(planes.bearings)
    ]
    largest = 2 ** len(planes.bearings) - 1
    description = f"Contact in the bearings: 0 none, else the sum of {', '.join(parts)}"
    start = start_values.forces(planes) if any(site.bearing in planes.bearings for site in planes.sites) else ()
    return output("contact_state", "1", description, type="Integer", minimum=0, maximum=largest, starts_from=start)


def _model_parameters(max_substep: float) -> list[Variable]:
    return [
        parameter("contact.impact_law", "1", "What an impact does to the velocities", NEWTON, **one_of(IMPACT_LAW)),
        parameter("solver.max_substep", "s", "Longest integration step", max_substep, minimum=1e-9, maximum=1e-3),
        parameter(
            "solver.tolerance",
            "m/s",
            "Error of the velocities above which an integration step is halved, twice at most",
            5e-6,
            minimum=0.0,
        ),
        parameter(
            "solver.exact_flight",
            "1",
            "Take steps at constant speed without contact by their exact solution, once 64 were alike",
            1.0,
            type="Boolean",
        ),
        parameter("gravity", "m/s2", "Gravity", 0.0),
        parameter(
            "gravity_angle",
            "rad",
            "Direction of gravity, from x towards y; by default towards negative x and y",
            1.25 * math.pi,
        ),
        parameter("ambient_temperature", "K", "Temperature around the retainers", 293.15, minimum=0.0),
        parameter(
            "initial.orbit",
            "1",
            "Start on the synchronous orbit in the passive bearings, put back onto the retainers where it passes them, "
            "in place of at rest",
            0.0,
            type="Boolean",
        ),
    ]


def _spin_parameters(polar_inertia: float) -> list[Variable]:
    return [
        parameter(
            "spin.free",
            "1",
            "Whether the spin is a degree of freedom: the drive, friction at the sites and unbalance change the speed",
            0.0,
            type="Boolean",
        ),
        parameter("spin.inertia", "kg.m2", "Polar inertia of rotor and drive", polar_inertia, minimum=0.0),
        parameter("spin.drag", "N.m.s", "Viscous drag on the spin", 0.0, minimum=0.0),
        parameter(
            "drive.gain",
            "N.m.s",
            "Torque of the drive per speed that is missing to what Omega demands",
            0.0,
            minimum=0.0,
        ),
    ]


def _energies(planes: Planes) -> list[Variable]:
    return [
        output(
            "energy.kinetic",
            "J",
            "Kinetic energy of the lateral motion, of housings, races and a free spin",
            starts_from=(*start_values.motion(planes), "spin.free", "spin.inertia"),
        ),
        output(
            "energy.strain",
            "J",
            "Strain energy of shaft, passive bearings, mounts and yielding contacts",
            starts_from=start_values.strain(planes),
        ),
        output(
            "energy.damping",
            "J",
            "Heat so far of damping: passive bearings, shaft, mounts, drag of a free spin",
            starts_from=(),
        ),
        output("energy.friction", "J", "Heat so far of sliding friction and of the drag on races", starts_from=()),
        output(
            "energy.impact",
            "J",
            "Heat so far of impacts, friction in them included, and of yielding contacts",
            starts_from=(),
        ),
        output("energy.dissipated", "J", "Heat so far, the sum of the three", starts_from=()),
        output("energy.work", "J", "Work so far of all inputs, the drive's included", starts_from=()),
        output(
            "energy.balance", "J", "Gain of kinetic + strain + dissipated beyond the work; ideally zero", starts_from=()
        ),
    ]


# One of each, for the record types of the parts.
SMALLEST = interface_of(
    Planes(("d",), ("b",), (ContactSite("s", 1e-3, 0.0),), (SensorPlane("p", "p.x", "p.y"),)),
).with_all_parts()
