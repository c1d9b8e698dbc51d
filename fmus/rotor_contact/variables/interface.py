"""Variable table of the plant, derived from the planes of its rotor."""

from __future__ import annotations

import math

from fmi_export.interface import Interface, interface, repeated
from fmi_export.variables import FAULT, Array, Variable, at_place, enumerated, input_, output, parameter
from rotor_contact.variables import start_values
from rotor_contact.variables.axis_variables import axial_inputs, axial_outputs, axial_parameters, axis_inputs
from rotor_contact.variables.energies import energies
from rotor_contact.variables.enumerations import IMPACT_LAW, METHOD, NEWTON
from rotor_contact.variables.face_variables import face_outputs, face_parameters
from rotor_contact.variables.planes import ContactSite, Face, MeasuredPlane, Planes
from rotor_contact.variables.site_variables import site_outputs, site_parameters
from rotor_contact.variables.start_values import ALWAYS_SAME


def _bearing_parameters(bearing: str) -> list[Variable]:
    declare, *_ = at_place(f"{bearing}.{{}}", f"at {bearing.upper()} in x and y, in addition to the input forces")
    return [
        declare("k_b", "N/m", "Stiffness of a passive bearing {}", 0.0, tunable=True),
        declare("c_b", "N.s/m", "Damping of a passive bearing {}", 0.0, minimum=0.0, tunable=True),
    ]


def _unbalance_inputs(name: str, what: str) -> list[Variable]:
    _, declare, _ = at_place(f"{name}.{{}}", what)
    return [
        declare("u", "kg.m", "Unbalance of {}", minimum=0.0),
        declare("phi", "rad", "Angle of the unbalance of {} relative to the rotor angle theta"),
    ]


def _disc_inputs(disc: str) -> list[Variable]:
    _, declare, _ = at_place(f"{disc}.{{}}", disc.upper())
    forces = (declare(f"f_{axis}", "N", f"External force on {{}} in {axis}") for axis in "xy")
    return [*_unbalance_inputs(disc, disc.upper()), *forces]


def _seal_outputs(seal: str) -> list[Variable]:
    beyond = "the speed is outside the range for which {} has coefficients"
    return [
        output(
            f"{seal}.beyond_table",
            "1",
            f"Whether {beyond.format(seal.upper())}, so that those at its limit are used",
            type="Boolean",
            initially_depends_on=("Omega",),
            warning=f"{beyond.format(seal)}; the coefficients at the limit are used",
        )
    ]


def _displacement_output(name: str, what: str, initially_depends_on: tuple[str, ...]) -> list[Variable]:
    return [output(name, "m", what, initially_depends_on=initially_depends_on, field=".", display_unit="um")]


def interface_of(planes: Planes) -> Interface:
    """Return the variables of a plant whose rotor has these planes; for `initially_depends_on` see `start_values`."""
    sites, bearings, thrust = planes.sites, planes.bearings, [(planes.thrust,)] if planes.thrust else []
    axes = [(bearing, axis) for bearing in bearings for axis in "xy"]
    displacements = [
        (f"{b}.{a}", f"Displacement of the rotor at {b.upper()} in {a}", start_values.displacement(planes, b, a))
        for b, a in axes
    ]
    sensors = [
        (name, f"Displacement of the rotor at plane {p.name} in {a}", start_values.displacement(planes, p.name, a))
        for p in planes.sensors
        for name, a in ((p.x, "x"), (p.y, "y"))
    ]
    names = ", ".join(name for name, *_ in sensors)
    sensor_array = Array("sensors", f"Displacements of the rotor at the sensors {names}")
    return interface(
        *_model_parameters(planes.max_substep),
        *_spin_parameters(planes.polar_inertia),
        repeated("sites", [(site,) for site in sites], site_parameters),
        repeated("bearings", [(bearing,) for bearing in bearings], _bearing_parameters),
        repeated("thrust", thrust, axial_parameters),
        repeated("faces", [(face,) for face in planes.faces], face_parameters),
        input_(
            "Omega",
            "rad/s",
            "Spin speed at the beginning of a step, or with spin.free the initial speed and then the speed demanded of "
            "the drive",
            minimum=-1e5,
            maximum=1e5,
        ),
        input_("Omega_dot", "rad/s2", "Spin acceleration during a step, ignored with spin.free"),
        input_("drive.torque", "N.m", "Torque of the drive at the demanded speed, used with spin.free"),
        input_(
            "drive.torque_limit",
            "N.m",
            "Largest torque of the drive in either direction, or 0 for a drive that is off",
            minimum=0.0,
        ),
        input_(
            "drive.ideal",
            "1",
            "Whether the drive of a free spin holds the demanded speed, whatever torque this requires",
            type="Boolean",
        ),
        *(
            input_(f"base.a_{axis}", "m/s2", f"Acceleration of the base in {axis}", field=f"base_acceleration.{axis}")
            for axis in "xy"
        ),
        repeated("axes", axes, axis_inputs),
        repeated("discs", [(disc,) for disc in planes.discs], _disc_inputs),
        repeated("cores", [(bearing, f"the rotor at {bearing.upper()}") for bearing in bearings], _unbalance_inputs),
        repeated("thrust", thrust, axial_inputs),
        output(
            "theta",
            "rad",
            "Rotor angle within one turn, positive from x towards y",
            minimum=0.0,
            maximum=2.0 * math.pi,
            initially_depends_on=("initial.angle",),
        ),
        output("speed", "rad/s", "Spin speed at the end of the step", initially_equals="Omega"),
        output(
            "solver.tolerance_missed",
            "1",
            "Whether a substep of the last step was less accurate than solver.tolerance",
            type="Boolean",
            **ALWAYS_SAME,
            warning="a substep was less accurate than solver.tolerance = {solver.tolerance} m/s; "
            "use a solver.max_substep below {solver.max_substep} s",
        ),
        output(
            "solver.energy_missed",
            "1",
            "Whether energy.balance, relative to the largest energy so far, exceeds a tenth of solver.energy_limit",
            type="Boolean",
            **ALWAYS_SAME,
            warning="energy is not conserved: energy.balance exceeds a tenth of solver.energy_limit = "
            "{solver.energy_limit} times the largest energy so far; compare with solver.exact_motion = false, or with "
            "a solver.max_substep below {solver.max_substep} s",
        ),
        output(
            "solver.method",
            "1",
            "Method that computed the last step",
            **ALWAYS_SAME,
            over_step="largest",
            **enumerated(METHOD),
        ),
        output(
            "drive.at_limit",
            "1",
            "Whether the drive would need more than drive.torque_limit to follow the demanded speed",
            type="Boolean",
            **ALWAYS_SAME,
            warning="the drive is at its limit, drive.torque_limit = {drive.torque_limit} N.m, and does not hold the "
            "speed",
        ),
        repeated("displacements", displacements, _displacement_output),
        repeated("sensors", sensors, _displacement_output, array=sensor_array),
        repeated("sites", [(site.name, planes) for site in sites], site_outputs),
        repeated("seals", [(seal,) for seal in planes.seals], _seal_outputs),
        repeated("thrust", thrust, axial_outputs),
        repeated("faces", [(face.name,) for face in planes.faces], face_outputs),
        _contact_state(planes),
        *energies(planes),
        FAULT,
    )


def _contact_state(planes: Planes) -> Variable:
    """Return the output for touched retainers: a sum of 1, 2, 4, ... for the first, second, third, ... bearing."""
    parts = [
        f"{2**k} for {' or '.join(site.name.upper() for site in planes.sites if site.bearing == bearing) or bearing}"
        for k, bearing in enumerate(planes.bearings)
    ]
    largest = 2 ** len(planes.bearings) - 1
    description = f"Contact with the retainers, as the sum of {', '.join(parts)}, or 0 without contact"
    start = start_values.forces(planes) if any(site.bearing in planes.bearings for site in planes.sites) else ()
    return output(
        "contact_state", "1", description, type="Integer", minimum=0, maximum=largest, initially_depends_on=start
    )


def _model_parameters(max_substep: float) -> list[Variable]:
    return [
        parameter(
            "contact.impact_law",
            "1",
            "Effect of an impact on the velocities of the rotor",
            NEWTON,
            **enumerated(IMPACT_LAW),
        ),
        parameter(
            "solver.max_substep",
            "s",
            "Length of the longest substep of the integration",
            max_substep,
            minimum=1e-9,
            maximum=1e-3,
        ),
        parameter(
            "solver.tolerance",
            "m/s",
            "Error of the velocities above which a substep is halved, at most twice",
            5e-6,
            minimum=0.0,
        ),
        parameter(
            "solver.energy_limit",
            "1",
            "Ratio of energy.balance to the largest energy so far above which a step fails, with a warning above a "
            "tenth of it",
            0.1,
            minimum=0.0,
        ),
        parameter(
            "solver.exact_motion",
            "1",
            "Whether the exact solution of the linear motion, and collocation during contact, replace substeps where "
            "possible",
            1.0,
            type="Boolean",
        ),
        parameter(
            "gravity",
            "m/s2",
            "Acceleration of gravity, or 0 if displacements are measured from the levitated equilibrium",
            0.0,
        ),
        parameter("gravity_angle", "rad", "Direction of gravity, as an angle from x towards y", 1.25 * math.pi),
        parameter(
            "ambient_temperature",
            "K",
            "Temperature of the surroundings, at which the retainers start",
            293.15,
            minimum=0.0,
        ),
        parameter(
            "initial.orbit",
            "1",
            "Whether the rotor starts on its synchronous orbit in the passive bearings, limited to the clearances, "
            "instead of at rest",
            0.0,
            type="Boolean",
        ),
        parameter("initial.angle", "rad", "Rotor angle at the start", 0.0),
    ]


def _spin_parameters(polar_inertia: float) -> list[Variable]:
    return [
        parameter(
            "spin.free",
            "1",
            "Whether torques of the drive, friction, drag and unbalance determine the spin speed, instead of Omega",
            0.0,
            type="Boolean",
        ),
        parameter(
            "spin.inertia",
            "kg.m2",
            "Polar moment of inertia of the rotor and its drive, used with spin.free",
            polar_inertia,
            minimum=0.0,
        ),
        parameter(
            "spin.drag", "N.m.s", "Coefficient of the viscous drag on the spin, used with spin.free", 0.0, minimum=0.0
        ),
        parameter(
            "drive.gain",
            "N.m.s",
            "Torque of the drive per difference between the demanded speed Omega and the spin speed, used with "
            "spin.free",
            0.0,
            minimum=0.0,
        ),
    ]


# A single element of each, for the record types of the parts.
SMALLEST = interface_of(
    Planes(
        ("d",),
        ("b",),
        (ContactSite("s", 1e-3, 0.0),),
        (MeasuredPlane("p", "p.x", "p.y"),),
        seals=("l",),
        thrust="t",
        faces=(Face("f", 1e-3, 1e-2),),
    ),
).with_all_parts()
